"""How far what is drawn along a path lies from the footage, by what was tracked there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.recording import Recording
from motorcade.replays.values.board_poses import BoardPoses
from motorcade.replays.values.marker_poses import MarkerPoses
from motorcade.replays.values.slam_poses import SlamPoses
from motorcade.tracking import registration_px
from motorcade.tracking.cameras.camera import Camera

__all__ = ["registrations"]


def registrations(
    paths: dict[str, Trajectory],
    recording: Recording,
    board_poses: BoardPoses | None = None,
    marker_poses: MarkerPoses | None = None,
    slam_poses: SlamPoses | None = None,
) -> dict[str, FloatArray]:
    """Of each path ``(M,)`` pixels, root mean square over the points of a frame.

    Points are the board's corners, those of the mapped markers, or what the keyframes of SLAM saw
    of the map. Frames outside a path's span are left out, NaN stands for a point behind the camera.
    Empty where nothing was tracked in pictures.
    """
    board, camera = recording.board, recording.camera
    if board_poses is not None and board is not None and camera is not None:
        seen, world_T_board = board_poses.track, recording.world_T_board
        return {
            name: registration_px(path, seen, board, camera, world_T_board)
            for name, path in paths.items()
        }
    sighted = None
    if marker_poses is not None:
        sighted = _of_markers(marker_poses)
    elif slam_poses is not None and camera is not None:
        sighted = _of_keyframes(slam_poses, camera)
    if sighted is None:
        return {}
    return {name: sighted.registration_px(path) for name, path in paths.items()}


@dataclass(frozen=True, eq=False)
class _Sightings:
    """Points of the world ``(n, 3)``, and where ``(n, 2)`` they were seen in which frames.

    `frame` ``(n,)`` is the row of `time_ns` ``(F,)``.
    """

    camera: Camera
    time_ns: IntArray
    frame: IntArray
    points: FloatArray
    px: FloatArray

    def registration_px(self, path: Trajectory) -> FloatArray:
        """Root mean square over the points of each frame within the path's span that has some."""
        stamps = self.time_ns[self.frame]
        inside = (stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1])
        world_T_camera = path.motors_at(stamps[inside])
        expected = self.camera.project(world_T_camera.inverse().apply(self.points[inside]))
        squares = np.sum((expected - self.px[inside]) ** 2, axis=-1)
        count = np.bincount(self.frame[inside], minlength=len(self.time_ns))
        total = np.bincount(self.frame[inside], squares, minlength=len(self.time_ns))
        return np.asarray(np.sqrt(total[count > 0] / count[count > 0]))


def _of_markers(found: MarkerPoses) -> _Sightings:
    """Four corners of every sighting of a mapped marker."""
    known, seen = found.marker_map, found.corners
    mapped = np.isin(seen.marker_ids, known.marker_ids)
    rows = np.searchsorted(known.marker_ids, seen.marker_ids[mapped])
    return _Sightings(
        seen.camera,
        seen.time_ns,
        np.repeat(seen.frame[mapped], 4),
        known.points_m.reshape(-1, 4, 3)[rows].reshape(-1, 3),
        seen.corners_px[mapped].reshape(-1, 2),
    )


def _of_keyframes(found: SlamPoses, camera: Camera) -> _Sightings | None:
    """The map's points as this recording's keyframes saw them; None where it has no keyframes.

    They hang on the measured poses, in metres where an IMU gave these: the map has a world and a
    unit of its own.
    """
    known, measured = found.slam_map, found.measurements.trajectory
    own = np.flatnonzero(np.isin(known.time_ns, measured.time_ns))
    kept = np.isin(known.keyframe_of, own)
    if not np.any(kept):
        return None
    frame, point = known.keyframe_of[kept], known.point_of[kept]
    unit = 1.0 if found.metres_a_unit is None else found.metres_a_unit
    in_camera = unit * known.world_T_camera[frame].inverse().apply(known.points[point])
    world_T_camera = measured.motors_at(known.time_ns[frame])
    return _Sightings(
        camera.undistorted(),
        known.time_ns,
        frame,
        world_T_camera.apply(in_camera),
        known.px[kept],
    )
