"""Poses measured by loose markers, with the map of these."""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.tracking.markers.marker_map import MarkerMap


@dataclass(frozen=True, eq=False, kw_only=True)
class MarkerPoses(CameraPoses):
    """Poses by loose markers; `marker_map` says where these stand in the same world."""

    marker_map: MarkerMap
