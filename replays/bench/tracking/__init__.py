"""Tracking: accuracy and milliseconds of markers, maps, boards and SLAM."""
