"""What there is to stand on, as one value; boards, loose markers and the world's floor.

Which way is up comes from gravity where there is an IMU, from the world where the poses were
simulated in one that stands upright; else it is weighed (see `candidates`). What was taken is said
in `Ground.name`, and what is a guess in `Ground.doubt`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.vectors import axes_along
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, frozen
from motorcade.render.light import Prints
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.tracking import Board, MarkerGrid, SingleMarker
from motorcade.tracking.markers.marker_map import MarkerMap

FLOOR_HEIGHT_M = 1.75
FARTHEST_M = 4.0
"""On a floor the character stands at most this far in front of the first camera."""
_MOST_SAMPLES = 2000
_TILTED_WORLDS = ("seven_scenes",)


@dataclass(frozen=True)
class Ground:
    """A plane to stand on, with where on it and how high unless the user says otherwise.

    `extent_m` ``(2, 2)`` is how far a board or marker reaches: its least x and y, then its
    greatest; None where the ground has no edge that is known. `outline_m` ``(k, 2)`` is of a
    surface that was found, `rank` what speaks for it (see `candidates`), and `doubt` says in words
    what is a guess of it.
    """

    world_T_plane: Motor
    position_m: tuple[float, float]
    height_m: float
    name: str
    extent_m: FloatArray | None = None
    outline_m: FloatArray | None = None
    rank: float = 1.0
    doubt: str = ""

    @property
    def corners_m(self) -> FloatArray:
        """Corners ``(k, 3)`` of what is known of it, in the world; of a height's square else."""
        if self.outline_m is not None:
            flat = self.outline_m
        elif self.extent_m is not None:
            (left, down), (right, up) = self.extent_m
            flat = np.array([[left, down], [right, down], [right, up], [left, up]])
        else:
            square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
            flat = np.array(self.position_m) + self.height_m * square
        return self.world_T_plane.apply(np.pad(flat, ((0, 0), (0, 1))))


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


def ground_on_world(path: Trajectory, floor_m: float) -> Ground:
    """The world's z = `floor_m`, where the first camera looks."""
    plane = Motor.from_translation([0.0, 0.0, floor_m])
    position = where_it_looks(plane.inverse() @ path.motors[0], FARTHEST_M)
    return Ground(plane, position, FLOOR_HEIGHT_M, f"the world's z = {floor_m:g} m")


def on_top_edge(ground: Ground, up: FloatArray) -> Ground:
    """On the uppermost edge of a board or marker that stands upright, in its middle."""
    assert ground.extent_m is not None  # boards and markers have one
    low, high = ground.extent_m
    local = ground.world_T_plane.inverse().rotor.apply(up)
    axis = int(np.argmax(np.abs(local[:2]) * (high - low)[::-1]))
    middle = 0.5 * (low + high)
    middle[axis] = (high if local[axis] > 0.0 else low)[axis]
    at_m = ground.world_T_plane.apply([*middle, 0.0])
    face = ground.world_T_plane.rotor.apply([0.0, 0.0, 1.0])
    along = np.cross(face, up)
    world_T_edge = Motor.from_rotor_translation(axes_along(along, np.cross(up, along)), at_m)
    return Ground(world_T_edge, (0.0, 0.0), ground.height_m, f"the top edge of {ground.name}")


def _middle(board: Board) -> tuple[float, float]:
    """Centre of the board's corners in its own plane, metres."""
    low, high = board.points_m.min(axis=0), board.points_m.max(axis=0)
    x, y, _ = (low + high) / 2
    return float(x), float(y)


def where_it_looks(floor_T_camera: Motor, farthest_m: float) -> tuple[float, float]:
    """Where the optical axis meets the floor, or a few paces ahead if that is far or never."""
    centre = floor_T_camera.translation_m
    gaze = floor_T_camera.rotor.apply([0.0, 0.0, 1.0])
    reach_m = -centre[2] / gaze[2] if gaze[2] < 0.0 < centre[2] else np.inf
    along = float(np.hypot(gaze[0], gaze[1]))
    ahead_m = min(reach_m * along, farthest_m) if along > 0.0 else 0.0
    x, y = centre[:2] + (ahead_m / along * gaze[:2] if along > 0.0 else 0.0)
    return float(x), float(y)
