"""Poses of markers refined on their whole print, both candidates at once, by torch and kornia."""

from motorcade.tracking.markers.photometric.refine import (
    PhotometricPoses,
    PhotometricUnavailable,
    refine_photometric,
)
from motorcade.tracking.markers.photometric.sightings import (
    RefinedFrame,
    joined_frames,
    refine_frame,
)

__all__ = [
    "PhotometricPoses",
    "PhotometricUnavailable",
    "RefinedFrame",
    "joined_frames",
    "refine_frame",
    "refine_photometric",
]
