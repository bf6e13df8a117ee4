"""Poses of markers refined on their whole print, both candidates at once, by torch and kornia."""

from motorcade.tracking.markers.photometric.refine import (
    PhotometricUnavailable,
    RefinedFrame,
    joined_frames,
    refine_frame,
)

__all__ = [
    "PhotometricUnavailable",
    "RefinedFrame",
    "joined_frames",
    "refine_frame",
]
