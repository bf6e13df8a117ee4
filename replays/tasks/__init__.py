"""What commands do beside the pipeline: calibrate, detect, fuse, edit, blend, print, inspect."""
