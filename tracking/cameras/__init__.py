"""Cameras: intrinsics and lenses, and their calibration from pictures of a board."""
