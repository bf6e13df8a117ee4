"""Poses measured by a board, with all that was seen of it."""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.tracking import BoardTrack


@dataclass(frozen=True, eq=False, kw_only=True)
class BoardPoses(CameraPoses):
    """Poses by a board; `track` holds the corners and both planar candidates of every frame."""

    track: BoardTrack
