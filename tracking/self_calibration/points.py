"""Least squares over a camera, where it stood, and points of a scene that nobody knows.

Points are eliminated (`BlockEquations`), so a step costs time in proportion to what was seen and
with the cube of the poses. Nothing fixes the unit of length; the damping leaves it where it was.

Sources: Triggs et al. 2000; Hartley & Zisserman 2003, ch. 19 (a moving camera).

The read-out of a rolling shutter: how fast the camera moved is known from its path; corners are
moved to where a shutter sees them that reads at once (`tracking.rolling`), for a few read-outs
along either axis, and all is fitted. The squared noise that is left is a parabola in the read-out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import reproject
from motorcade.tracking.optimise import (
    BlockEquations,
    Stop,
    huber_cauchy,
    minimise,
    pair_sums,
    sum_by,
)
from motorcade.tracking.rolling import shift_px
from motorcade.tracking.self_calibration.bodies import median_noise_px
from motorcade.tracking.self_calibration.lens import LensKind
from motorcade.tracking.self_calibration.result import ReadoutAxis, ShutterReadout

_STOP = Stop(steps=30, gain=1e-5)
_WIDTH = 6
_LIMIT, _OUTLIER = 2.0, 6.0  # of the noise of a coordinate
_NOISE_FLOOR_PX = 0.05


@dataclass(frozen=True, eq=False)
class PointObservations:
    """Points in views.

    Fields:
        size: width and height of the images.
        view, point: ``(N,)`` of each observation; a pair stands once, each has some.
        px: ``(N, 2)``.
    """

    size: tuple[int, int]
    view: IntArray
    point: IntArray
    px: FloatArray

    def only(self, rows: IntArray) -> PointObservations:
        """Some observations; views and points keep their numbers."""
        return replace(self, view=self.view[rows], point=self.point[rows], px=self.px[rows])


@dataclass(frozen=True, eq=False)
class PointState:
    """What is estimated.

    Fields:
        kind: the lens model; numbers: ``(3 + terms,)`` of the lens.
        world_T_camera: Motor ``(V,)``, the first of which stays.
        points: ``(P, 3)`` world.
    """

    kind: LensKind
    numbers: FloatArray
    world_T_camera: Motor
    points: FloatArray


@dataclass(frozen=True, eq=False)
class PointFit:
    """A state that is least squares.

    Fields:
        state: where it ended.
        residuals_px: ``(N, 2)`` reprojection minus observation; infinite behind the camera.
        noise_px: of a coordinate, by the median.
        covariance: ``(3 + terms, 3 + terms)`` of the lens's numbers, for independent observations.
    """

    state: PointState
    residuals_px: FloatArray
    noise_px: float
    covariance: FloatArray


class _Reprojection:
    """All observations against their reprojection; those behind the camera count as far off."""

    def __init__(self, seen: PointObservations, noise_px: float, state: PointState) -> None:
        self._seen, self._state = seen, state
        self.cost = np.inf
        if not (np.isfinite(state.numbers).all() and state.numbers[0] > 0.0):
            return
        self._camera = state.kind.camera(state.numbers, seen.size)
        poses = state.world_T_camera.inverse()[seen.view]
        self._turn = poses.rotor.as_matrix()
        in_camera = poses.apply(state.points[seen.point])
        before = in_camera[:, 2] > 1e-6
        self._in_camera = np.where(before[:, None], in_camera, [0.0, 0.0, 1.0])
        self._pixels, self._by_pose, self._by_point = reproject(self._camera, self._in_camera)
        far = np.full(2, 1e4)
        self.residuals_px: FloatArray = np.where(before[:, None], self._pixels - seen.px, far)
        limit, outlier = _LIMIT * noise_px, _OUTLIER * noise_px
        size = np.linalg.norm(self.residuals_px, axis=-1)
        loss, weight = huber_cauchy(size, limit, outlier)
        self._weight = np.where(before, weight, 0.0)
        self._away, information = state.kind.prior(state.numbers, seen.size)
        self._expected = information * noise_px**2
        cost = float(loss.sum() + 0.5 * (self._expected * self._away**2).sum())
        self.cost = cost if np.isfinite(cost) else np.inf

    @cached_property
    def equations(self) -> BlockEquations:
        """Groups: the lens's numbers, filled up to sixes, then every view but the first."""
        seen, count = self._seen, len(self._state.numbers)
        groups = -(-count // _WIDTH)
        by_lens = np.zeros((len(seen.px), 2, groups * _WIDTH))
        by_lens[..., :count] = self._state.kind.by_numbers(
            self._camera, self._in_camera, self._pixels
        )
        by_world = self._by_point @ self._turn
        weight, residual = self._weight[:, None, None], self.residuals_px[..., None]
        pull_lens, pull_pose, pull_world = (
            (weight * by).swapaxes(-1, -2) for by in (by_lens, self._by_pose, by_world)
        )
        points, moving = len(self._state.points), seen.view > 0
        information, gradient = self._kept(by_lens, pull_lens, pull_pose, residual)
        every, point = np.arange(points), seen.point
        blocks = sum_by(pull_world @ by_world, point, points)
        push = sum_by((pull_world @ residual)[..., 0], point, points)
        met = sum_by(pull_world @ by_lens, point, points).reshape(points, 3, groups, _WIDTH)
        rows, columns, across = pair_sums(
            (pull_world @ self._by_pose)[moving], point[moving], seen.view[moving] - 1
        )
        return BlockEquations(
            information,
            gradient,
            blocks,
            push,
            np.concatenate([np.repeat(every, groups), rows]),
            np.concatenate([np.tile(np.arange(groups), points), groups + columns]),
            np.concatenate([met.swapaxes(1, 2).reshape(-1, 3, _WIDTH), across]),
        )

    def _kept(
        self,
        by_lens: FloatArray,
        pull_lens: FloatArray,
        pull_pose: FloatArray,
        residual: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Information and gradient of lens and views."""
        seen, views = self._seen, int(self._state.world_T_camera.shape[0])
        wide, count = by_lens.shape[-1], len(self._state.numbers)
        information = np.zeros((wide + (views - 1) * _WIDTH,) * 2)
        gradient = np.zeros(len(information))
        information[:wide, :wide] = (pull_lens @ by_lens).sum(axis=0)
        gradient[:wide] = (pull_lens @ residual)[..., 0].sum(axis=0)
        own = np.arange(count)
        information[own, own] += self._expected
        gradient[own] += self._expected * self._away
        blocks = sum_by(pull_pose @ self._by_pose, seen.view, views)
        across = sum_by(pull_pose @ by_lens, seen.view, views)
        push = sum_by((pull_pose @ residual)[..., 0], seen.view, views)
        for view in range(1, views):
            place = slice(wide + (view - 1) * _WIDTH, wide + view * _WIDTH)
            information[place, place] = blocks[view]
            information[place, :wide] = across[view]
            information[:wide, place] = across[view].T
            gradient[place] = push[view]
        return information, gradient


def fit_points(seen: PointObservations, start: PointState) -> PointFit:
    """Minimise the reprojection error over lens, views and points; wrong matches hardly count.

    Raises:
        ValueError: a start from which nothing is seen.
    """
    state, noise_px = start, _noise_px(_Reprojection(seen, 1.0, start).residuals_px)
    for _ in range(3):
        evaluate = partial(_Reprojection, seen, noise_px)
        minimum = minimise(state, evaluate, _retract, _STOP)
        state, before = minimum.state, noise_px
        noise_px = _noise_px(minimum.evaluation.residuals_px)
        if abs(noise_px - before) < 0.05 * before:
            break
    at, count = minimum.evaluation, len(state.numbers)
    inverse = np.linalg.inv(at.equations.reduced_information)[:count, :count]
    covariance = np.asarray(noise_px**2 * inverse, np.float64)
    return PointFit(state, at.residuals_px, noise_px, covariance)


def _noise_px(residuals_px: FloatArray) -> float:
    noise_px = median_noise_px(residuals_px, _NOISE_FLOOR_PX)
    if not np.isfinite(noise_px):
        raise ValueError("start: expected points before their cameras")
    return noise_px


def _retract(state: PointState, step: tuple[FloatArray, FloatArray]) -> PointState:
    groups, points = step
    count = len(state.numbers)
    wide = -(-count // _WIDTH)
    poses = np.concatenate([np.zeros((1, _WIDTH)), groups[wide:]])
    return replace(
        state,
        numbers=state.numbers + groups[:wide].ravel()[:count],
        world_T_camera=state.world_T_camera.retract(poses),
        points=state.points + points,
    )


def parallax_deg(seen: PointObservations, state: PointState) -> float:
    """Median over the points of the largest angle between directions that they were seen from."""
    towards = state.points[seen.point] - state.world_T_camera.translation_m[seen.view]
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    order = np.argsort(seen.point, kind="stable")
    first = np.searchsorted(seen.point[order], np.arange(len(state.points)))
    reference = towards[order][first]
    angle = np.arccos(np.clip((towards * reference[seen.point]).sum(axis=-1), -1.0, 1.0))
    largest = np.zeros(len(state.points))
    np.maximum.at(largest, seen.point, angle)
    return float(np.degrees(np.median(largest)))


_TRIED_S = 0.012
_LONGEST_S = 0.04
_SURE_SIGMAS = 4.0
_ROUNDS = 2
_EVERY = 3
_NAMES: tuple[tuple[ReadoutAxis, ReadoutAxis], ...] = (("right", "left"), ("down", "up"))


def fit_with_shutter(
    seen: PointObservations, start: PointState, velocity: FloatArray
) -> tuple[PointObservations, PointFit, ShutterReadout | None]:
    """Fit points, lens and views, with the rolling shutter that they show, if they show one.

    Args:
        seen: corners as they were seen.
        start: a state that is near.
        velocity: twist ``(V, 6)`` per second of each view, in its own frame.

    Returns:
        the corners as a shutter sees them that reads at once, their fit, and the read-out.
    """
    straight, fit, best = seen, fit_points(seen, start), None
    for _ in range(_ROUNDS):
        readouts = [_told(seen, fit.state, velocity, axis) for axis in (0, 1)]
        # The two share what an axis alone explains: the surer one is taken.
        axis = int(np.argmax([abs(r) / max(sigma, 1e-12) for r, sigma in readouts]))
        seconds, sigma = readouts[axis]
        if not _SURE_SIGMAS * sigma < abs(seconds) < _LONGEST_S:
            break
        shutter_s = seconds * np.eye(2)[axis]
        moved = _unrolled(seen, fit.state, velocity, shutter_s)
        again = fit_points(moved, fit.state)
        if again.noise_px >= fit.noise_px:
            break
        straight, fit = moved, again
        best = ShutterReadout(abs(seconds), sigma, _NAMES[axis][int(seconds < 0.0)])
    return straight, fit, best


def _told(
    seen: PointObservations, state: PointState, velocity: FloatArray, axis: int
) -> tuple[float, float]:
    """Read-out along an axis, seconds, and its standard deviation; infinite where none is best.

    Every third point tells it well enough.
    """
    some = np.flatnonzero(seen.point % _EVERY == 0)
    if len(np.unique(seen.view[some])) == len(velocity):  # each view keeps some
        points, which = np.unique(seen.point[some], return_inverse=True)
        seen, state = (
            replace(seen.only(some), point=which),
            replace(state, points=state.points[points]),
        )
    tried = _TRIED_S * np.array([-1.0, 0.0, 1.0])
    squares = [
        fit_points(_unrolled(seen, state, velocity, seconds * np.eye(2)[axis]), state).noise_px ** 2
        for seconds in tried
    ]
    bend, slope, _ = np.polyfit(tried, squares, 2)
    if bend <= 0.0:
        return 0.0, np.inf
    seconds = float(-0.5 * slope / bend)
    least = max(float(np.polyval([bend, slope, squares[1]], seconds)), 0.1 * min(squares))
    return seconds, float(np.sqrt(least / (bend * len(seen.px))))


def _unrolled(
    seen: PointObservations, state: PointState, velocity: FloatArray, shutter_s: FloatArray
) -> PointObservations:
    camera = state.kind.camera(state.numbers, seen.size)
    in_camera = state.world_T_camera[seen.view].inverse().apply(state.points[seen.point])
    shift = shift_px(camera, in_camera, velocity[seen.view], seen.px, shutter_s)
    return replace(seen, px=seen.px - shift)
