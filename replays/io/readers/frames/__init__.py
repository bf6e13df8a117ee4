"""Frame sequences, whatever they come from: picture files, videos, or marker corners alone."""
