"""Poses of markers refined on their whole print, both candidates at once, by torch and kornia."""

from motorcade.tracking.markers.photometric.refine import (
    PhotometricPoses,
    PhotometricUnavailable,
    RefinedFrame,
    joined_frames,
    refine_frame,
    refine_photometric,
)

__all__ = [
    "PhotometricPoses",
    "PhotometricUnavailable",
    "RefinedFrame",
    "joined_frames",
    "refine_frame",
    "refine_photometric",
]
