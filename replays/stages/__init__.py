"""The stages of the pipeline, a file each: typed functions that can be called alone."""
