"""How far a print is from flat: heights of its corners, which views from several sides tell.

Paper curls. A corner that stands ``h`` above the plane of its print lies ``h`` times a derivative
off in the image; what a pose takes up of that is taken out, and the rest of many views tells the
heights by least squares. They are believed where views that had no part in them say so as well,
and where letting every corner move in the plane, which is what a wrong statement or lens would
want, explains no more.

Source: the idea of targets that are not quite what is stated is Strobl and Hirzinger's, "More
accurate pinhole camera calibration with imperfect planar target" (2011).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.board_tracking.tracker import BoardTrack, with_pooled_noise
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.camera import Camera, reproject
from motorcade.tracking.measurements import MarkerObservation, PoseMeasurements
from motorcade.tracking.pose import refine

_VIEWS, _FEWEST = 120, 10
_USUAL_HEIGHT = 0.03
"""Of a print's width: how far paper stands off the table, before anything was seen."""
_EXPLAINED = 0.5
"""Of the squares in views that had no part: heights that explain less are noise of the lens."""
_BETTER = 0.8
"""Of the squares that corners moved in the plane leave, at most: views from one side alone tell the
two apart by chance only, which scatters such sums by some hundredths."""
_ROUNDS = 2
_UP, _ALONG = np.eye(3)[:, 2:], np.eye(3)[:, :2]


@dataclass(frozen=True, eq=False)
class PrintShape:
    """Heights of a print's corners, and what speaks for them.

    Fields:
        heights_m: ``(n,)`` of each corner over the plane, towards the printed face.
        flat_px: RMS of what poses leave of corners, of views that had no part, if it is flat.
        bent_px: the same with the heights that the other views tell.
        moved_px: the same where each corner moves in the plane instead.
    """

    heights_m: FloatArray
    flat_px: float
    bent_px: float
    moved_px: float

    @property
    def is_bent(self) -> bool:
        """Whether views that had no part in the heights confirm them."""
        left = self.bent_px**2
        return left < (1.0 - _EXPLAINED) * self.flat_px**2 and left < _BETTER * self.moved_px**2

    @property
    def height_m(self) -> float:
        """Between the lowest corner and the highest."""
        return float(np.ptp(self.heights_m))


def print_shape(track: BoardTrack, points_m: FloatArray, camera: Camera) -> PrintShape | None:
    """How a tracked print is bent; None where too few views show it.

    Args:
        track: corners and poses, the board's frame being the world.
        points_m: ``(n, 3)`` corners as stated, flat.
        camera: that saw them.

    Where the camera hardly moves, nothing tells a bent print from a bent image, nor from squares
    that are none: it then counts as flat.
    """
    count = len(track.observations)
    if count < _FEWEST:
        return None
    rows = np.unique(np.linspace(0, count - 1, min(count, _VIEWS)).round().astype(int))
    seen = [track.observations[row] for row in rows]
    poses = track.measurements.trajectory.motors[rows]
    first, second = slice(0, len(rows) // 2), slice(len(rows) // 2, len(rows))
    up, along = (
        [_Normal(seen[part], poses[part], points_m, camera, axes) for part in (first, second)]
        for axes in (_UP, _ALONG)
    )
    left = sum(half.squares for half in up), _left_of_each_other(*up), _left_of_each_other(*along)
    flat, bent, moved = np.sqrt(np.array(left) / sum(half.freedom for half in up)).tolist()
    return PrintShape(up[0].solution(up[1]), flat, bent, moved)


def bent_track(
    track: BoardTrack, points_m: FloatArray, camera: Camera
) -> tuple[BoardTrack, FloatArray, PrintShape | None]:
    """The track on the print as it is bent, its corners ``(n, 3)``, and its shape.

    A print that is not bent, or too seldom seen, leaves track and corners as they are.
    """
    shape = print_shape(track, points_m, camera)
    if shape is None or not shape.is_bent:
        return track, points_m, shape
    heights = shape.heights_m
    for turn in range(_ROUNDS):
        bent = points_m + heights[:, None] * _UP.T
        track = refined_track(track, bent, camera)
        again = print_shape(track, bent, camera) if turn < _ROUNDS - 1 else None
        heights = heights if again is None else heights + again.heights_m
    return track, bent, replace(shape, heights_m=bent[:, 2] - points_m[:, 2])


class _Normal:
    """Normal equations of corners that move along given directions, poses being taken out."""

    def __init__(
        self,
        seen: Sequence[MarkerObservation],
        poses: Motor,
        points_m: FloatArray,
        camera: Camera,
        directions: FloatArray,
    ) -> None:
        width, self._count = directions.shape[1], len(points_m)
        self._matrix = np.zeros((width * self._count, width * self._count))
        self._vector = np.zeros(width * self._count)
        self.squares, self.freedom = 0.0, 0
        self._usual_m = _USUAL_HEIGHT * float(np.ptp(points_m, axis=0).max())
        for observation, pose in zip(seen, poses, strict=True):
            ids: IntArray = observation.ids
            board_T_camera = pose.inverse()
            px, by_twist, by_point = reproject(camera, board_T_camera.apply(points_m[ids]))
            along = board_T_camera.rotor.apply(directions.T).T  # (3, k) in the camera's frame
            left = (observation.corners_px - px).ravel()
            design = np.zeros((len(ids), 2, len(ids), width))
            design[np.arange(len(ids)), :, np.arange(len(ids))] = by_point @ along
            columns = design.reshape(2 * len(ids), -1)
            if not (np.isfinite(left).all() and np.isfinite(columns).all()):
                continue
            basis = np.linalg.qr(by_twist.reshape(-1, 6))[0]
            left = left - basis @ (basis.T @ left)
            columns = columns - basis @ (basis.T @ columns)
            place = (width * ids[:, None] + np.arange(width)).ravel()
            self._matrix[np.ix_(place, place)] += columns.T @ columns
            self._vector[place] += columns.T @ left
            self.squares += float(left @ left)
            self.freedom += max(len(left) - 6, 1)

    def solution(self, other: _Normal | None = None) -> FloatArray:
        """The displacements ``(k n,)`` that these views tell, with another half's if given."""
        matrix = self._matrix + (0.0 if other is None else other._matrix)
        vector = self._vector + (0.0 if other is None else other._vector)
        prior = np.eye(len(vector)) / self._usual_m**2
        return np.asarray(np.linalg.solve(matrix + prior, vector), np.float64)

    def left(self, moved: FloatArray) -> float:
        """Sum of squares that these displacements leave here."""
        return float(self.squares - 2.0 * moved @ self._vector + moved @ self._matrix @ moved)


def _left_of_each_other(first: _Normal, second: _Normal) -> float:
    """Sum of squares that is left in each half of the views by what the other half tells."""
    return first.left(second.solution()) + second.left(first.solution())


def refined_track(track: BoardTrack, points_m: FloatArray, camera: Camera) -> BoardTrack:
    """Poses anew on corners ``(n, 3)``, flat or not; states and planar candidates are kept."""
    path = track.measurements.trajectory
    refined = [
        refine(BoardCorners(seen.ids, seen.corners_px, points_m[seen.ids]), camera, pose)
        for seen, pose in zip(track.observations, path.motors, strict=True)
    ]
    poses = Motor.stack([pose.world_T_camera for pose in refined])
    trajectory = Trajectory(path.time_ns, poses, path.parent, path.child)
    measured = PoseMeasurements(trajectory, np.stack([pose.covariance for pose in refined]))
    errors = np.array([pose.error_px for pose in refined])
    return with_pooled_noise(replace(track, measurements=measured, error_px=errors))
