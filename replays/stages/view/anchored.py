"""What a character or an anchor of a scene stands on, as it was asked for, and how that moves."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses, MarkerPoses
from motorcade.replays.stages.values.view import StandingPlace
from motorcade.replays.stages.view.candidates import (
    SeenScene,
    foot_ground,
    grounds_in,
    seen_scene,
    weigh_up,
)
from motorcade.replays.stages.view.ground import (
    Ground,
    ground_on_board,
    ground_on_marker,
    ground_on_world,
    known_marker,
    on_top_edge,
)
from motorcade.replays.stages.view.in_view import tall_at
from motorcade.replays.stages.view.level_ground import level_ground
from motorcade.replays.stages.view.moving_marker import find_marker
from motorcade.tracking.planes import UpEstimate, fit_plane
from motorcade.tracking.planes.upward import NEAR_DEG

GroundKind = Literal["auto", "board", "marker", "plane", "floor"]

BELIEF_IN_PRINT = 0.98
PRINTS_LIE = 0.9
"""Share of prints that lie, before anything is seen of them: sheets do not stand by themselves."""
PRINT_SURE = 0.92
"""So sure is what was seen, and not that share alone: steep above, a print that leans is seen as
one that lies."""
ACROSS_TO_ALONG = float(2.0 / np.tan(np.deg2rad(0.5 * NEAR_DEG)))
"""Solid angle of the directions across a normal over that of those along it, so far off either."""
ROOM = 2.5
"""Times the shorter side of a print: the arms of a taller figure would reach beyond it."""


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
    _known: dict[tuple[str, float], list[Ground]] = field(
        default_factory=dict, init=False, repr=False
    )

    def asked(
        self, on: GroundKind, marker: int | None = None, floor_m: float = 0.0, choice: int = 0
    ) -> tuple[Ground, Trajectory | None]:
        """A ground, and where it moves the motion that takes it from its first place.

        `choice` takes one of the `candidates` by its number from 1 on.

        Raises:
            ValueError: a board, marker or plane that is asked for and not there.
        """
        recording, camera_poses = self.recording, self.camera_poses
        marker_map = None if self.marker_poses is None else self.marker_poses.marker_map
        if marker is not None:
            known = known_marker(recording, camera_poses, marker_map, marker)
            found = find_marker(recording, self.seen_from, marker, known)
            ground = ground_on_marker(found.world_T_marker, found.side_m, marker)
            if found.path is None:
                return ground, None
            start_T_marker: Motor = found.world_T_marker.inverse()
            motion = found.path.transformed_by(right=start_T_marker, child="start")
            return replace(ground, name=f"{ground.name}, which moves"), motion
        grounds = self.candidates(on, floor_m)
        if not grounds:
            lacking = "no board is known" if on == "board" else "no plane was found"
            raise ValueError(f"{recording.name}: placed.on={on}, but {lacking}")
        if choice < 0:
            raise ValueError(f"placed.floor: expected 1 on, got {choice}")
        if choice > len(grounds):
            names = "; ".join(f"{k}: {one.name}" for k, one in enumerate(grounds, 1))
            raise ValueError(f"placed.floor: expected 1 to {len(grounds)}, got {choice} ({names})")
        return grounds[max(choice, 1) - 1], None

    def choices(self, on: GroundKind, floor_m: float = 0.0) -> tuple[StandingPlace, ...]:
        """The candidates as a report shows them."""
        grounds = () if on == "marker" else self.candidates(on, floor_m)
        return tuple(StandingPlace(one.name, one.doubt, one.corners_m) for one in grounds)

    def candidates(self, on: GroundKind = "auto", floor_m: float = 0.0) -> list[Ground]:
        """What can be stood on, the likeliest first; none where a board or plane is not there."""
        if (on, floor_m) not in self._known:
            self._known[on, floor_m] = self._searched(on, floor_m)
        return self._known[on, floor_m]

    @cached_property
    def _scene(self) -> SeenScene:
        return seen_scene(self.recording, self.camera_poses, self.seen_from)

    @cached_property
    def _up(self) -> UpEstimate:
        """Up by all there is; a print is a surface as well."""
        scene = self._scene
        if self._print is not None:
            eye = self.seen_from.motors.translation_m.mean(axis=0)
            face = fit_plane(self._print.corners_m, towards_m=eye)
            planes, beliefs = (*scene.planes, face), (*scene.beliefs, BELIEF_IN_PRINT)
            away_m = scene.depth_m if len(scene.points) else float(face.distances_m(eye))
            scene = replace(scene, planes=planes, beliefs=beliefs, depth_m=away_m)
        return weigh_up(scene)

    @cached_property
    def _print(self) -> Ground | None:
        """The board, or the marker seen most, out of its face."""
        marker_map = None if self.marker_poses is None else self.marker_poses.marker_map
        return ground_on_board(self.recording, self.camera_poses, marker_map)

    def _searched(self, on: GroundKind, floor_m: float) -> list[Ground]:
        if on == "board":
            return [] if self._print is None else [self._seen_large(self._print)]
        if on == "floor" and self._scene.has_level:
            return [foot_ground(self._scene, self._up, floor_m)]
        if on == "floor":
            return [self._plain_floor(floor_m)]
        face = self._print if on == "auto" else None
        grounds = [] if face is None else self._of_print(face, self._up)
        grounds += grounds_in(self._scene, self._up, planes_only=on == "plane")
        if on == "auto" and not grounds:
            grounds = [self._plain_floor(floor_m)]
        return grounds

    def _plain_floor(self, floor_m: float) -> Ground:
        """The world's floor; before a camera that only turns, one below it."""
        camera = self.recording.camera
        if self.camera_poses.origin == "turning" and camera is not None:
            ground = level_ground(camera, self.seen_from, floor_m)
            return replace(ground, doubt="that up is the picture's is a guess")
        return ground_on_world(self.seen_from, floor_m)

    def _of_print(self, face: Ground, up: UpEstimate) -> list[Ground]:
        """A board or marker that lies is stood on; one that stands upright, on its top edge.

        Many directions lie across its normal and one along it, while prints lie more often than
        they stand: what counts is how dense up is there.
        """
        normal = face.world_T_plane.rotor.apply([0.0, 0.0, 1.0])
        lies, stands = up.probability(normal), up.probability_across(normal)
        told, flat = lies + stands, PRINTS_LIE / (1.0 - PRINTS_LIE) * ACROSS_TO_ALONG * lies
        lies = told * flat / max(flat + stands, 1e-12)
        stands = told - lies
        face = replace(self._seen_large(face), rank=lies)
        edge = replace(on_top_edge(face, up.across(normal)), rank=stands)
        doubts = [f"that {face.name} {how} is a guess" for how in ("lies flat", "stands upright")]
        grounds = [
            replace(one, doubt=f"{doubt} ({100 * one.rank:.0f} % sure)" * (one.rank < PRINT_SURE))
            for one, doubt in zip((face, edge), doubts, strict=True)
        ]
        return sorted(grounds, key=lambda ground: -ground.rank)

    def _seen_large(self, ground: Ground) -> Ground:
        """A print's figure, no speck where lengths have no unit and as its feet have room."""
        camera = self.recording.camera
        if camera is None or self.camera_poses.metric or ground.extent_m is None:
            return ground
        plane_T_camera = ground.world_T_plane.inverse() @ self.seen_from.motors
        room_m = ROOM * float(np.ptp(ground.extent_m, axis=0).min())
        tall_m = min(room_m, tall_at(ground.position_m, camera, plane_T_camera))
        return replace(ground, height_m=max(ground.height_m, tall_m))
