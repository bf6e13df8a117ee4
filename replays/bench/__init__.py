"""Every performance figure the project quotes, measured side by side in one run."""
