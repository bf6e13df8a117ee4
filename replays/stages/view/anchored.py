"""What a character or an anchor of a scene stands on, as it was asked for, and how that moves.

The camera's path comes from whatever stands still, and takes the marker's two planar poses of each
frame to the world. The likeliest sequence of these is chosen (a chain: small error, little turning)
and smoothed between jumps. A marker that one pose explains in all frames does not move; if a map
holds its pose, that one is used.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from motorcade.animation.place.anchors import followed
from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import LooseMarkers, Recording
from motorcade.replays.stages.camera.marker_poses import markers_found
from motorcade.replays.stages.values.camera_poses import HELD_HEIGHT, CameraPoses, MarkerPoses
from motorcade.replays.stages.values.view import StandingPlace
from motorcade.replays.stages.view.candidates import (
    SeenScene,
    foot_ground,
    grounds_in,
    seen_scene,
    tall_at,
    weigh_up,
)
from motorcade.replays.stages.view.ground import (
    FLOOR_HEIGHT_M,
    Ground,
    ground_on_board,
    ground_on_marker,
    ground_on_world,
    known_marker,
    on_top_edge,
)
from motorcade.tracking import MarkerGrid, SingleMarker
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import pose_stream
from motorcade.tracking.markers.disambiguate.states import most_probable
from motorcade.tracking.markers.families import marker_points_m
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
            located = find_marker(recording, self.seen_from, marker, known)
            ground = ground_on_marker(located.world_T_marker, located.side_m, marker)
            if located.path is None:
                return ground, None
            start_T_marker: Motor = located.world_T_marker.inverse()
            motion = located.path.transformed_by(right=start_T_marker, child="start")
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
            return replace(ground, doubt="that up is the image's is a guess")
        return ground_on_world(self.seen_from, floor_m)

    def _of_print(self, face: Ground, up: UpEstimate) -> list[Ground]:
        """A board or marker that lies is stood on; one that stands upright, on its top edge.

        Many directions lie across its normal and one along it, while prints lie more often than
        they stand: what counts is how dense up is there.
        """
        normal = face.world_T_plane.rotor.apply([0.0, 0.0, 1.0])
        lies, stands = up.probability(normal), up.probability_across(normal)
        either, flat = lies + stands, PRINTS_LIE / (1.0 - PRINTS_LIE) * ACROSS_TO_ALONG * lies
        lies = either * flat / max(flat + stands, 1e-12)
        stands = either - lies
        face = replace(self._seen_large(face), rank=lies)
        edge = replace(on_top_edge(face, up.across(normal)), rank=stands)
        doubts = [f"that {face.name} {how} is a guess" for how in ("lies flat", "stands upright")]
        grounds = [
            replace(
                ground,
                doubt=f"{doubt} ({100 * ground.rank:.0f} % sure)" * (ground.rank < PRINT_SURE),
            )
            for ground, doubt in zip((face, edge), doubts, strict=True)
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


_FEET = 0.88
"""Of the image's height: so far down the soles are seen."""


def level_ground(camera: Camera, path: Trajectory, floor_m: float) -> Ground:
    """The floor, and a place on it where the first camera sees a figure down to its soles.

    The image's up is taken for the world's, and a camera that looks up or down for one that
    looks level: nothing in poses that only turn tells otherwise. How high the camera is held is
    a guess, and so the figure is as high as one sees it well.
    """
    below = max(HELD_HEIGHT - floor_m, 0.1)
    soles_px = (0.5 * (camera.width - 1), _FEET * camera.height)
    gaze = path.motors[0].rotor.apply(camera.bearings([soles_px])[0])
    reach = below / -gaze[2] if gaze[2] < -0.05 else 4.0 * below
    place = path.motors[0].translation_m[:2] + reach * gaze[:2]
    plane, x, y = Motor.from_translation([0.0, 0.0, floor_m]), float(place[0]), float(place[1])
    height_m = min(FLOOR_HEIGHT_M, tall_at((x, y), camera, plane.inverse() @ path.motors))
    name = "a level floor below the camera, up being the image's"
    return Ground(plane, (x, y), height_m, name)


FIXED_PX = 1.5
"""A marker that one pose brings this near to nine in ten of its observations does not move."""
FASTEST_SIDES_S = 25.0
"""A marker carried by hand passes no more of its own sides in a second; more is a leap."""
LEAST_SIGMA_PX, TURNING_RAD_S, TURNING_RAD = 0.3, 3.0, 0.1
UNSEEN_S, FEWEST_ALIKE, FEWEST_SMOOTHED = 0.15, 3, 16


@dataclass(frozen=True, eq=False)
class FoundMarker:
    """A marker in the world.

    Attributes:
        side_m: of its black square.
        world_T_marker: where it is first, or always.
        path: where it is at every frame that has a pose; None where it does not move.
    """

    side_m: float
    world_T_marker: Motor
    path: Trajectory | None


def find_marker(
    recording: Recording, world_T_camera: Trajectory, marker_id: int, known: Motor | None
) -> FoundMarker:
    """Find a marker in all frames that have a pose.

    Args:
        recording: with images and a family of markers, or with recorded corners.
        world_T_camera: the camera's path, smoothed, by what does not move.
        marker_id: of the marker.
        known: its pose in the world, where a map tells one; taken if the images do not refute it.

    Raises:
        ValueError: no camera, no family to look for, or a marker that no frame shows.
    """
    stream, side_m = _observations_of(recording, marker_id)
    inside = (stream.time_ns[stream.frame] >= world_T_camera.time_ns[0]) & (
        stream.time_ns[stream.frame] <= world_T_camera.time_ns[-1]
    )
    seen = stream.where(inside)
    posed = pose_stream(seen, {marker_id: side_m})
    if not len(posed):
        raise ValueError(
            f"{recording.name}: placed.marker={marker_id}, but no frame with a pose shows it"
        )
    cameras = world_T_camera.motors_at(seen.time_ns[seen.frame])
    stamps = posed.time_ns[posed.frame]
    both = world_T_camera.motors_at(stamps).reshape(-1, 1) @ posed.camera_T_marker
    chosen = _likeliest(both, posed.error_px, 1e-9 * (stamps - stamps[0]))
    poses = both[np.arange(len(chosen)), chosen]
    for fixed in (known, _one_pose(poses, cameras, seen, side_m)):
        if fixed is not None and _explains(fixed, cameras, seen, side_m):
            return FoundMarker(side_m, fixed, None)
    frames_ns = stream.time_ns[
        (stream.time_ns >= world_T_camera.time_ns[0])
        & (stream.time_ns <= world_T_camera.time_ns[-1])
    ]
    path = _shown(poses, stamps, frames_ns, FASTEST_SIDES_S * side_m)
    return FoundMarker(side_m, path.motors[0], path)


def _observations_of(recording: Recording, marker_id: int) -> tuple[CornerStream, float]:
    """Corners of one marker, all frames counting, and its size."""
    frames = recording.frames
    if isinstance(frames, CornerFrames):
        stream = frames.first
        if marker_id not in frames.side_m:
            raise ValueError(f"{recording.name}: placed.marker={marker_id} is none of its markers")
        side_m = frames.side_m[marker_id]
    else:
        loose = _looked_for(recording, marker_id)
        stream, side_m = markers_found(recording, loose)[0], loose.side_m
    return stream.where(stream.marker_ids == marker_id), side_m


def _looked_for(recording: Recording, marker_id: int) -> LooseMarkers:
    board = recording.board
    if isinstance(board, MarkerGrid | SingleMarker) and marker_id in board.marker_ids:
        side_m = board.marker_m if isinstance(board, MarkerGrid) else board.side_m
        return LooseMarkers(board.family, side_m)
    if recording.markers is None:
        raise ValueError(
            f"{recording.name}: placed.marker={marker_id}, but no family of markers is known; name "
            "it in a manifest ([markers])"
        )
    return recording.markers


def _likeliest(both: Motor, error_px: FloatArray, time_s: FloatArray) -> IntArray:
    """Which of the two poses of each observation: small errors, and little turning between them."""
    sigma = max(LEAST_SIGMA_PX, float(np.median(error_px[:, 0])))
    unary = 4.0 * (error_px / sigma) ** 2
    between = both[:-1, :, None].rotor.inverse() @ both[1:, None, :].rotor
    angle = np.linalg.norm(between.as_rotation_vector(), axis=-1)
    bearable = TURNING_RAD + TURNING_RAD_S * np.diff(time_s)
    steps = np.minimum(0.5 * (angle / bearable[:, None, None]) ** 2, 50.0)
    return most_probable(np.zeros(2), unary, steps)


def _one_pose(poses: Motor, cameras: Motor, seen: CornerStream, side_m: float) -> Motor:
    """The pose that explains all corners best, robustly."""
    from scipy.optimize import least_squares

    start = poses[int(np.argmin(_apart(poses)))]

    def residuals(twist: FloatArray) -> FloatArray:
        return _missed_px(start @ Motor.from_twist(twist), cameras, seen, side_m).ravel()

    fit = least_squares(residuals, np.zeros(6), loss="soft_l1", x_scale=[1, 1, 1] + [side_m] * 3)
    return start @ Motor.from_twist(fit.x)


def _apart(poses: Motor) -> FloatArray:
    """How far each pose is from the median place, metres."""
    places = poses.translation_m
    return np.asarray(np.linalg.norm(places - np.median(places, axis=0), axis=-1))


def _missed_px(
    world_T_marker: Motor, cameras: Motor, seen: CornerStream, side_m: float
) -> FloatArray:
    """(N, 4, 2) from each corner seen to where one pose of the marker has it."""
    corners = world_T_marker.apply(marker_points_m(side_m))
    camera: Camera = seen.camera
    return camera.project(cameras.inverse().reshape(-1, 1).apply(corners)) - seen.corners_px


def _explains(world_T_marker: Motor, cameras: Motor, seen: CornerStream, side_m: float) -> bool:
    missed = _missed_px(world_T_marker, cameras, seen, side_m)
    each = np.sqrt(np.mean(np.sum(missed**2, axis=-1), axis=-1))
    return bool(np.quantile(each, 0.9) <= FIXED_PX)


def _shown(poses: Motor, stamps: IntArray, frames_ns: IntArray, fastest_m_s: float) -> Trajectory:
    """The path at every frame: smooth between leaps, which are glided over."""
    time_s = 1e-9 * (stamps - frames_ns[0])
    passed = np.diff(time_s)
    step_m = np.linalg.norm(np.diff(poses.translation_m, axis=0), axis=-1)
    begins = np.flatnonzero((passed > UNSEEN_S) | (step_m > fastest_m_s * passed)) + 1
    parts = np.split(np.arange(len(stamps)), begins)
    # A few frames apart from what is before and after are wrong, unless there is nothing else.
    parts = [part for part in parts if len(part) >= FEWEST_ALIKE] or parts
    smoothed = [_smooth(Trajectory(stamps[part], poses[part])) for part in parts]
    rows = np.concatenate(parts)
    shown = followed(
        time_s[rows],
        Motor.concatenate(smoothed),
        1e-9 * (frames_ns - frames_ns[0]),
        fastest_m_s=fastest_m_s,
    )
    return Trajectory(frames_ns, shown, "world", "marker")


def _smooth(path: Trajectory) -> Motor:
    return path.motors if len(path) < FEWEST_SMOOTHED else smooth(path).motors
