"""Frame sequences, whatever they come from: image files, videos, or marker corners alone."""
