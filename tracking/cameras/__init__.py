"""Cameras: intrinsics and lenses, and their calibration from images of a board."""
