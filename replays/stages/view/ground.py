"""What there is to stand on: the board, loose markers, a plane found in depth or map, a floor.

Which way is up comes from gravity where there is an IMU, from the world where the poses were
simulated in one that stands upright; else the picture's own up serves as a guess. What was taken
is said in `Ground.name`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.animation.vectors import axes_along
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, frozen
from motorcade.render.light import Prints
from motorcade.replays.recording import Frame, Recording
from motorcade.replays.stages.view.in_view import best_place
from motorcade.replays.values.camera_poses import CameraPoses
from motorcade.tracking import Board, MarkerGrid, SingleMarker
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.planes import (
    Plane,
    choose_floor,
    choose_stage,
    find_planes,
    find_planes_in_depth,
)

FLOOR_HEIGHT_M = 1.75
FARTHEST_M = 4.0
"""On a floor the character stands at most this far in front of the first camera."""
_FRAMES_SEARCHED, _EVERY_PX = 5, 4
_MOST_SAMPLES = 2000
_FEWEST_POINTS = 50
# Of the scene's depth: how far a point of a map may lie off a plane, a character's greatest and
# least height where lengths have no unit; and how much of the heights may lie below a floor.
_POINT_NOISE, _FREE_HEIGHT, _LEAST_FREE_HEIGHT, _FOOT = 0.01, 0.25, 0.05, 0.05
_TILTED_WORLDS = ("seven_scenes",)


@dataclass(frozen=True)
class Ground:
    """A plane to stand on, with where on it and how high unless the user says otherwise.

    `extent_m` ``(2, 2)`` is how far a board or marker reaches: its least x and y, then its
    greatest; None where the ground has no edge that is known.
    """

    world_T_plane: Motor
    position_m: tuple[float, float]
    height_m: float
    name: str
    extent_m: FloatArray | None = None


def upward(
    recording: Recording, camera_poses: CameraPoses, path: Trajectory
) -> tuple[FloatArray, str] | None:
    """Up ``(3,)`` in the world, and how it is known; None where it is not.

    A carried accelerometer's mean over the recording, turned into the world, points up: its own
    motion averages out.
    """
    imu = recording.imu
    if imu is not None and recording.imu_T_camera is not None:
        inside = (imu.time_ns >= path.time_ns[0]) & (imu.time_ns <= path.time_ns[-1])
        rows = np.flatnonzero(inside)
        rows = rows[:: max(1, len(rows) // _MOST_SAMPLES)]
        if len(rows):
            world_T_imu = path.motors_at(imu.time_ns[rows]) @ recording.imu_T_camera.inverse()
            mean = world_T_imu.rotor.apply(imu.specific_force_m_s2[rows]).mean(axis=0)
            return mean / np.linalg.norm(mean), "up being against gravity"
    if camera_poses.origin == "simulated" and recording.layout not in _TILTED_WORLDS:
        return np.array([0.0, 0.0, 1.0]), "up being the world's"
    return None


def ground_on_board(
    recording: Recording, camera_poses: CameraPoses, marker_map: MarkerMap | None
) -> Ground | None:
    """The board where one is known, or loose markers: the plane of the one seen most."""
    if recording.board is not None and camera_poses.origin in ("board", "simulated"):
        height = 0.5 * min(recording.board.size_m)
        printed = recording.board.pattern  # whose y runs down
        x, y = printed.x_edges_m[[0, -1]], 0.0 - printed.y_edges_m[[-1, 0]]
        place, extent = _middle(recording.board), frozen(np.stack([x, y], axis=-1))
        return Ground(recording.world_T_board, place, height, "the board", extent)
    if marker_map is None:
        return None
    base = int(np.argmin(np.linalg.norm(marker_map.world_T_marker.as_twist(), axis=-1)))
    side_m, number = float(marker_map.side_m[base]), int(marker_map.marker_ids[base])
    return ground_on_marker(marker_map.world_T_marker[base], side_m, number)


def ground_on_marker(world_T_marker: Motor, side_m: float, marker_id: int) -> Ground:
    """The middle of one marker."""
    middle, extent = (0.5 * side_m, -0.5 * side_m), side_m * np.array([[0, -1], [1, 0]])
    return Ground(world_T_marker, middle, side_m, f"marker {marker_id}", frozen(extent))


def known_marker(
    recording: Recording,
    camera_poses: CameraPoses,
    marker_map: MarkerMap | None,
    marker_id: int,
) -> Motor | None:
    """Where a map, or the board that it is part of, has a marker; None where neither knows it."""
    board = recording.board
    if camera_poses.origin in ("board", "simulated") and isinstance(
        board, MarkerGrid | SingleMarker
    ):
        rows = np.flatnonzero(board.marker_ids == marker_id)
        if len(rows):
            corner_m = board.points_m[4 * int(rows[0])]
            inside = Motor.from_translation(corner_m)
            return recording.world_T_board @ inside
    if marker_map is None:
        return None
    rows = np.flatnonzero(marker_map.marker_ids == marker_id)
    return marker_map.world_T_marker[int(rows[0])] if len(rows) else None


def prints_of(
    recording: Recording, camera_poses: CameraPoses, marker_map: MarkerMap | None
) -> Prints | None:
    """Boards and markers whose place in the world is known; None where there are none."""
    if recording.board is not None and camera_poses.origin in ("board", "simulated"):
        points = recording.board.points_m[:, :2]
        low, high = points.min(axis=0)[None], points.max(axis=0)[None]
        # The paper holds the whole pattern and the white zone that finding it needs.
        pattern = recording.board.pattern
        sides = [
            low[0] - [pattern.x_edges_m[0], -pattern.y_edges_m[-1]],
            [pattern.x_edges_m[-1], -pattern.y_edges_m[0]] - high[0],
        ]
        margin_m = max(0.0, float(np.min(sides)) + pattern.quiet_m)
        return Prints(recording.world_T_board.reshape(1), low, high, margin_m)
    if marker_map is None:
        return None
    side = marker_map.side_m[:, None]
    return Prints(marker_map.world_T_marker, side * [0.0, -1.0], side * [1.0, 0.0])


def ground_on_plane(
    recording: Recording, camera_poses: CameraPoses, path: Trajectory
) -> Ground | None:
    """The first plane to stand on that the depth of a few frames shows, or the map's points."""
    up = upward(recording, camera_poses, path)
    for frame in _with_depth(recording, path):
        world_T_camera = path.motors_at(np.int64(frame.time_ns))
        plane = _chosen(_planes_of(recording, frame, world_T_camera), world_T_camera, up)
        if plane is not None:
            where = f"m found in the depth of {frame.name}"
            points = world_T_camera.apply(_points_of(recording, frame))
            return _stage(plane, where, up, FLOOR_HEIGHT_M, recording.camera, path, points)
    points = camera_poses.points
    if len(points) < _FEWEST_POINTS:
        return None
    first = path.motors[0]
    depth = _scene_depth(points, first)
    found = find_planes(
        points, _POINT_NOISE * depth, np.random.default_rng(0), seen_from_m=first.translation_m
    )
    plane = _chosen(found.planes, first, up)
    if plane is None:
        return None
    highest = FLOOR_HEIGHT_M if camera_poses.metric else _FREE_HEIGHT * depth
    if not camera_poses.metric:
        # Whoever holds a camera is about as tall as it is high above what they stand on.
        above = float(np.median((plane.world_T_plane.inverse() @ path.motors).translation_m[:, 2]))
        highest = min(highest, max(above, _LEAST_FREE_HEIGHT * depth))
    where = "m found in the map" if camera_poses.metric else "units found in the map"
    return _stage(plane, where, up, highest, recording.camera, path, points)


def ground_on_floor(
    recording: Recording, camera_poses: CameraPoses, path: Trajectory, floor_m: float
) -> Ground:
    """The world's z = `floor_m`; in the world of SLAM, a level at the foot of what was mapped."""
    first = path.motors[0]
    points = camera_poses.points
    if camera_poses.origin == "slam" and len(points):
        known = upward(recording, camera_poses, path)
        up = first.rotor.apply([0.0, -1.0, 0.0]) if known is None else known[0]
        depth = _scene_depth(points, first)
        height = float(np.quantile(points @ up, _FOOT))
        plane = Motor.from_rotor_translation(_turned_up(up), (height + floor_m) * up)
        name = f"a level at the foot of the map, {known[1] if known else _GUESS}"
        tall = FLOOR_HEIGHT_M if camera_poses.metric else _FREE_HEIGHT * depth
        farthest = FARTHEST_M if camera_poses.metric else depth
        return Ground(plane, _where_it_looks(plane.inverse() @ first, farthest), tall, name)
    plane = Motor.from_translation([0.0, 0.0, floor_m])
    position = _where_it_looks(plane.inverse() @ first, FARTHEST_M)
    return Ground(plane, position, FLOOR_HEIGHT_M, f"the world's z = {floor_m:g} m")


_GUESS = "up being the picture's"


def _stage(
    plane: Plane,
    where: str,
    up: tuple[FloatArray, str] | None,
    highest_m: float,
    camera: Camera | None,
    path: Trajectory,
    points: FloatArray,
) -> Ground:
    wide, tall = plane.size_m
    how = _GUESS if up is None else up[1]
    name = f"a plane of {wide:.2f} x {tall:.2f} {where}, {how}"
    height_m = min(0.5 * min(wide, tall), highest_m)
    place = (0.0, 0.0)
    if camera is not None:
        plane_T_world = plane.world_T_plane.inverse()
        place = best_place(
            plane.outline,
            height_m,
            camera,
            plane_T_world @ path.motors,
            plane_T_world.apply(points),
            plane.rms_m,
        )
    return Ground(plane.world_T_plane, place, height_m, name)


def _chosen(
    planes: Sequence[Plane], world_T_camera: Motor, up: tuple[FloatArray, str] | None
) -> Plane | None:
    return choose_stage(planes, world_T_camera) if up is None else choose_floor(planes, up[0])


def _with_depth(recording: Recording, path: Trajectory) -> Iterator[Frame]:
    """A few frames that have depth and a pose, evenly over the recording."""
    if recording.camera is None:
        return
    stamps = recording.frames.time_ns
    posed = np.flatnonzero((stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1]))
    step = max(1, len(posed) // _FRAMES_SEARCHED)
    for index in posed[::step][:_FRAMES_SEARCHED]:
        frame = recording.frames[int(index)]
        if frame.read_depth is not None:
            yield frame


def _planes_of(recording: Recording, frame: Frame, world_T_camera: Motor) -> list[Plane]:
    """The planes in one frame's depth, in the world."""
    depth, camera = frame.depth_m(), recording.camera
    if depth is None or camera is None:
        return []
    try:
        found = find_planes_in_depth(depth, camera, np.random.default_rng(0))
    except ValueError:  # hardly any depth in this frame: another may have more
        return []
    return [plane.transformed_by(world_T_camera) for plane in found.planes]


def _points_of(recording: Recording, frame: Frame) -> FloatArray:
    """Points ``(p, 3)`` of a frame's depth, thinned, in the camera's frame."""
    depth, camera = frame.depth_m(), recording.camera
    if depth is None or camera is None:
        return np.zeros((0, 3))
    y, x = np.mgrid[: depth.shape[0] : _EVERY_PX, : depth.shape[1] : _EVERY_PX].reshape(2, -1)
    ahead = depth[y, x].astype(np.float64)
    known = np.isfinite(ahead) & (ahead > 0.0)
    rays = camera.unproject(np.stack([x[known], y[known]], axis=-1).astype(np.float64))
    return np.asarray(rays / rays[:, 2:] * ahead[known, None])


def _scene_depth(points: FloatArray, world_T_camera: Motor) -> float:
    """Median distance of the points before a camera along its axis."""
    ahead = world_T_camera.inverse().apply(points)[:, 2]
    return float(np.median(ahead[ahead > 0.0])) if np.any(ahead > 0.0) else 1.0


def _turned_up(up: FloatArray) -> Rotor:
    """A frame whose z is `up`."""
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(up)))], up)
    return axes_along(x, np.cross(up, x))


def _middle(board: Board) -> tuple[float, float]:
    """Centre of the board's corners in its own plane, metres."""
    low, high = board.points_m.min(axis=0), board.points_m.max(axis=0)
    x, y, _ = (low + high) / 2
    return float(x), float(y)


def _where_it_looks(floor_T_camera: Motor, farthest_m: float) -> tuple[float, float]:
    """Where the optical axis meets the floor, or a few paces ahead if that is far or never."""
    centre = floor_T_camera.translation_m
    gaze = floor_T_camera.rotor.apply([0.0, 0.0, 1.0])
    reach_m = -centre[2] / gaze[2] if gaze[2] < 0.0 < centre[2] else np.inf
    along = float(np.hypot(gaze[0], gaze[1]))
    ahead_m = min(reach_m * along, farthest_m) if along > 0.0 else 0.0
    x, y = centre[:2] + (ahead_m / along * gaze[:2] if along > 0.0 else 0.0)
    return float(x), float(y)
