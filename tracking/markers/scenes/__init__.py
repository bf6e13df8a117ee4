"""Scenes of bodies that carry markers and cameras: what is stated of them, and what is found."""

from __future__ import annotations

from motorcade.tracking.markers.scenes.estimate import map_scene
from motorcade.tracking.markers.scenes.scene import (
    BodyOdometry,
    CornerCoordinate,
    CornerDistance,
    FixedMarker,
    MarkerBody,
    MarkerScene,
    StatedPose,
)

__all__ = [
    "BodyOdometry",
    "CornerCoordinate",
    "CornerDistance",
    "FixedMarker",
    "MarkerBody",
    "MarkerScene",
    "StatedPose",
    "map_scene",
]
