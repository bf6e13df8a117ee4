"""Poses measured by visual SLAM, with its map.

They stand apart so that an edit of SLAM computes nothing anew of a run on a board.
"""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.tracking.slam import MapSnapshot


@dataclass(frozen=True, eq=False, kw_only=True)
class SlamPoses(CameraPoses):
    """Poses by SLAM; `slam_map` is the map as it may be saved and gone on in, in its own world."""

    slam_map: MapSnapshot
