"""Square markers: families, detection, corners to sub-pixels, pose candidates."""

from __future__ import annotations

from motorcade.tracking.markers.detection import (
    Backend,
    Detection,
    backend_for,
    detect_markers,
)
from motorcade.tracking.markers.families import APRILTAG_FAMILIES, FAMILIES
from motorcade.tracking.markers.poses import PosedMarker, pose_marker
from motorcade.tracking.markers.refinding import refind_markers

__all__ = [
    "APRILTAG_FAMILIES",
    "FAMILIES",
    "Backend",
    "Detection",
    "PosedMarker",
    "backend_for",
    "detect_markers",
    "pose_marker",
    "refind_markers",
]
