"""Square markers: families, detection, corners to sub-pixels, pose candidates."""

from __future__ import annotations

from motorcade.tracking.markers.detection import Detection, detect_markers
from motorcade.tracking.markers.families import FAMILIES
from motorcade.tracking.markers.poses import pose_marker

__all__ = [
    "FAMILIES",
    "Detection",
    "detect_markers",
    "pose_marker",
]
