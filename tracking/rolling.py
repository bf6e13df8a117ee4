"""A rolling shutter taken out of what was seen: corners as a shutter sees them that reads at once.

Lines of an image are read one after another, so a camera that moves bends what it sees. How long a
line is read before or after the stamp follows from where it lies; how far a corner moves in that
time, from the velocity that the frames beside it give. The poses are then those at the stamp, when
the middle line is read.

Source: Hedborg et al. 2012 (a velocity a view; here to second order in the line's time).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.board_tracking.flatness import refined_track
from motorcade.tracking.board_tracking.tracker import BoardTrack
from motorcade.tracking.boards import Board
from motorcade.tracking.cameras.camera import Camera, reproject
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.measurements import PoseMeasurements
from motorcade.tracking.self_calibration.bodies import velocities

_ROUNDS = 2


def lateness_s(camera: Camera, px: FloatArray, shutter_s: FloatArray) -> FloatArray:
    """How long after the stamp ``(*)`` pixels ``(*, 2)`` are read; below zero before it.

    Args:
        camera: its size.
        px: in the upright image.
        shutter_s: ``(2,)`` from the left edge to the right one and from the upper to the lower.

    >>> import numpy as np
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.rolling import lateness_s
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> lateness_s(camera, np.array([[319.5, 479.5], [0.0, 239.5]]), np.array([0.0, 0.02]))
    array([0.01, 0.  ])
    """
    size = np.array([camera.width, camera.height])
    late: FloatArray = ((px + 0.5) / size - 0.5) @ shutter_s
    return late


def shift_px(
    camera: Camera,
    in_camera: FloatArray,
    twist: FloatArray,
    px: FloatArray,
    shutter_s: FloatArray,
) -> FloatArray:
    """How far ``(n, 2)`` points that still are seen by a moving camera, from where they would be.

    0 where either has no image.

    Args:
        camera: who sees them.
        in_camera: ``(n, 3)`` points at the stamp.
        twist: ``(n, 6)`` of the camera per second, in its own frame.
        px: ``(n, 2)`` where they were seen.
        shutter_s: as `lateness_s` takes it.

    >>> import numpy as np
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.rolling import shift_px
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> seen, point = np.array([[319.5, 479.5]]), np.array([[0.0, 0.48, 1.0]])
    >>> to_the_right = np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]])  # a metre a second
    >>> shift_px(camera, point, to_the_right, seen, np.array([0.0, 0.02])).round(6)
    array([[-5.,  0.]])
    """
    turn, shift = twist[:, :3], twist[:, 3:]
    late = lateness_s(camera, px, shutter_s)[:, None]
    moves = np.cross(in_camera, turn) - shift
    moved = in_camera + late * (moves + 0.5 * late * np.cross(moves, turn))
    return np.nan_to_num(camera.project(moved) - camera.project(in_camera))


def unrolled_track(
    track: BoardTrack, board: Board, camera: Camera, shutter_s: FloatArray
) -> BoardTrack:
    """A board's track as a shutter gives it that reads at once; states and candidates are kept.

    Frames without a near neighbour, of which no velocity is known, stay as they are.

    Args:
        track: of a camera with a rolling shutter, its world the board's frame.
        board: that was tracked.
        camera: that saw it.
        shutter_s: as `lateness_s` takes it.
    """
    unrolled = track
    for _ in range(_ROUNDS):
        poses = unrolled.measurements.trajectory.motors
        in_camera, twist, px, starts = _moving(track, board, poses)
        still_px = np.split(px - shift_px(camera, in_camera, twist, px, shutter_s), starts[1:])
        both = zip(track.observations, still_px, strict=True)
        observations = tuple(replace(seen, corners_px=px) for seen, px in both)
        unrolled = refined_track(
            replace(unrolled, observations=observations), board.points_m, camera
        )
    return unrolled


_Moving = tuple[FloatArray, FloatArray, FloatArray, IntArray]
"""Corners in the camera's frame, its twist a second, where they are; each frame's first."""


def _moving(track: BoardTrack, board: Board, poses: Motor) -> _Moving:
    time_ns = track.measurements.trajectory.time_ns
    counts = [len(seen.ids) for seen in track.observations]
    view = np.repeat(np.arange(len(counts)), counts)
    twist = velocities(1e-9 * (time_ns - time_ns[0]), poses)[view]
    points = board.points_m[np.concatenate([seen.ids for seen in track.observations])]
    px = np.concatenate([seen.corners_px for seen in track.observations])
    return poses[view].inverse().apply(points), twist, px, np.cumsum([0, *counts[:-1]])


def with_unsure_shutter(
    track: BoardTrack, board: Board, camera: Camera, unsure_s2: FloatArray
) -> BoardTrack:
    """The track with what it does not know of the shutter's read-out in its covariances.

    Args:
        track: of a camera whose read-out was taken out of it, as far as that is known.
        board: that was tracked.
        camera: that saw it.
        unsure_s2: ``(2, 2)`` mean square of what is left of `shutter_s`, s².
    """
    seen = _moving(track, board, track.measurements.trajectory.motors)
    return replace(track, measurements=_less_sure(track.measurements, camera, seen, unsure_s2))


def with_unsure_readout(
    measured: PoseMeasurements, stream: CornerStream, known: MarkerMap, unsure_s2: FloatArray
) -> PoseMeasurements:
    """Poses by markers, as `with_unsure_shutter` gives those by a board; arguments as there."""
    _, in_camera, twist, px, view = _markers_moving(stream, measured.trajectory, known)
    starts = 4 * np.searchsorted(view, np.arange(len(measured)))
    return _less_sure(measured, stream.camera, (in_camera, twist, px, starts), unsure_s2)


def _less_sure(
    measured: PoseMeasurements, camera: Camera, seen: _Moving, unsure_s2: FloatArray
) -> PoseMeasurements:
    in_camera, twist, px, starts = seen
    likely_s = np.linalg.cholesky(unsure_s2).T
    shifts = np.stack([shift_px(camera, in_camera, twist, px, one) for one in likely_s], -1)
    by_pose = reproject(camera, in_camera)[1]
    down = by_pose.swapaxes(-1, -2)
    square, pull = (np.add.reduceat(down @ other, starts) for other in (by_pose, shifts))
    moved = np.linalg.solve(square, pull)
    spread = measured.covariance + moved @ moved.swapaxes(-1, -2)
    return PoseMeasurements(measured.trajectory, spread)


def unrolled_stream(
    stream: CornerStream, path: Trajectory, known: MarkerMap, shutter_s: FloatArray
) -> CornerStream:
    """Markers' corners as a shutter sees them that reads at once.

    Those of markers that are not in the map, and of frames without a pose, stay as they are.

    Args:
        stream: what a camera with a rolling shutter saw.
        path: of that camera, in the map's world.
        known: where the markers are.
        shutter_s: as `lateness_s` takes it.
    """
    mapped, in_camera, twist, seen, _ = _markers_moving(stream, path, known)
    shift = shift_px(stream.camera, in_camera, twist, seen, shutter_s)
    corners = stream.corners_px.copy()
    corners[mapped] = (seen - shift).reshape(-1, 4, 2)
    return replace(stream, corners_px=corners)


def _markers_moving(
    stream: CornerStream, path: Trajectory, known: MarkerMap
) -> tuple[NDArray[np.bool_], FloatArray, FloatArray, FloatArray, IntArray]:
    """Which observations are of mapped markers; of their corners as of a board; their poses."""
    frames = stream.time_ns[stream.frame]
    mapped = np.isin(stream.marker_ids, known.marker_ids) & np.isin(frames, path.time_ns)
    view = np.searchsorted(path.time_ns, frames[mapped])
    body = np.searchsorted(known.marker_ids, stream.marker_ids[mapped])
    velocity = velocities(1e-9 * (path.time_ns - path.time_ns[0]), path.motors)
    points = known.points_m.reshape(-1, 4, 3)[body]
    in_camera = path.motors[view].inverse()[:, None].apply(points).reshape(-1, 3)
    seen = stream.corners_px[mapped].reshape(-1, 2)
    return mapped, in_camera, np.repeat(velocity[view], 4, axis=0), seen, view


def as_read(
    path: Trajectory, camera: Camera, points_m: FloatArray, shutter_s: FloatArray
) -> Trajectory:
    """One pose a stamp that shows points where a rolling shutter does, as nearly as one pose can.

    Each point is seen by the path's pose of the time when its line is read; the pose is the one
    from which all are seen there with the least squared error. It is for drawing what lies between
    the points, and for nothing else.

    Args:
        path: world_T_camera.
        camera: that sees them; where one of them has no image, the path's own pose is kept.
        points_m: ``(n, 3)`` of the world, around what is drawn, not all on one line.
        shutter_s: as `lateness_s` takes it.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.rolling import as_read
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> path = Trajectory([0, 10**9], Motor.from_translation([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    >>> corners = np.array([[x, y, 2.0] for x in (0.4, 0.6) for y in (0.7, 0.9)])
    >>> read = as_read(path, camera, corners, np.array([0.0, 0.02]))
    >>> float(camera.project(read.motors[0].inverse().apply(corners))[:, 0].mean().round(1))
    442.4
    """
    poses = path.motors
    seen = camera.project(poses.inverse()[:, None].apply(points_m), allow_nan=True)
    with_image = np.isfinite(seen).all(axis=(-1, -2))
    if not with_image.any():
        return path
    stamps = np.repeat(path.time_ns[with_image, None], len(points_m), axis=1)
    px = seen[with_image]
    size = np.array([camera.width, camera.height])
    for _ in range(_ROUNDS):
        late_s = lateness_s(camera, np.clip(np.nan_to_num(px), 0.0, size), shutter_s)
        read_ns = stamps + np.rint(1e9 * late_s).astype(np.int64)
        at = path.motors_at(np.clip(read_ns, path.time_ns[0], path.time_ns[-1]))
        px = camera.project(at.inverse().apply(points_m), allow_nan=True)
    refined = poses[with_image]
    for _ in range(_ROUNDS):
        pixels, by_pose, _ = reproject(camera, refined.inverse()[:, None].apply(points_m))
        both = np.concatenate([by_pose, (px - pixels)[..., None]], axis=-1).reshape(len(px), -1, 7)
        both[~np.isfinite(both).all(axis=(1, 2))] = 0.0
        square, pull = np.split(both[..., :6].swapaxes(-1, -2) @ both, [6], axis=-1)
        firm = 1e-9 * np.trace(square, axis1=-2, axis2=-1)[:, None, None] + 1e-12
        refined = refined.retract(np.linalg.solve(square + firm * np.eye(6), pull)[..., 0])
    coefficients = poses.coefficients.copy()
    coefficients[with_image] = refined.coefficients
    return Trajectory(path.time_ns, Motor(coefficients), path.parent, path.child)
