"""What a character or an anchor of a scene stands on, as it was asked for, and how that moves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from motorcade.ga import Motor, Trajectory
from motorcade.replays.recording import Recording
from motorcade.replays.stages.view.ground import (
    Ground,
    ground_on_board,
    ground_on_floor,
    ground_on_marker,
    ground_on_plane,
    known_marker,
)
from motorcade.replays.stages.view.level_ground import level_ground
from motorcade.replays.stages.view.moving_marker import find_marker
from motorcade.replays.values.camera_poses import CameraPoses
from motorcade.replays.values.marker_poses import MarkerPoses

GroundKind = Literal["auto", "board", "marker", "plane", "floor"]


@dataclass(frozen=True, eq=False)
class Grounds:
    """What of a recording can be stood on.

    Fields:
        recording: with the camera that was found.
        camera_poses: as measured.
        marker_poses: of loose markers, if any.
        seen_from: the path along which it is drawn.
    """

    recording: Recording
    camera_poses: CameraPoses
    marker_poses: MarkerPoses | None
    seen_from: Trajectory

    def asked(
        self, on: GroundKind, marker: int | None = None, floor_m: float = 0.0
    ) -> tuple[Ground, Trajectory | None]:
        """A ground, and where it moves the motion that takes it from its first place.

        Raises:
            ValueError: a board, marker or plane that is asked for and not there.
        """
        recording, camera_poses = self.recording, self.camera_poses
        marker_map = None if self.marker_poses is None else self.marker_poses.marker_map
        ground = None
        if marker is not None:
            known = known_marker(recording, camera_poses, marker_map, marker)
            found = find_marker(recording, self.seen_from, marker, known)
            ground = ground_on_marker(found.world_T_marker, found.side_m, marker)
            if found.path is None:
                return ground, None
            start_T_marker: Motor = found.world_T_marker.inverse()
            motion = found.path.transformed_by(right=start_T_marker, child="start")
            return replace(ground, name=f"{ground.name}, which moves"), motion
        if on in ("auto", "board"):
            ground = ground_on_board(recording, camera_poses, marker_map)
        if on == "plane" or (on == "auto" and ground is None):
            ground = ground_on_plane(recording, camera_poses, self.seen_from)
        if ground is None and on in ("board", "plane"):
            lacking = "no board is known" if on == "board" else "no plane that faces up was found"
            raise ValueError(f"{recording.name}: placed.on={on}, but {lacking}")
        if ground is None and camera_poses.origin == "turning" and recording.camera is not None:
            ground = level_ground(recording.camera, self.seen_from, floor_m)
        if ground is None:
            ground = ground_on_floor(recording, camera_poses, self.seen_from, floor_m)
        return ground, None
