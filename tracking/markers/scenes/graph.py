"""The factor graph of a scene: corners, stated poses, steps of odometry, measured lengths.

All factors of a kind are linearised at once; the normal equations are sparse (see
`motorcade.tracking.optimise`). A corner hangs on four poses: gtsam's Python has no such factor, and
one written in Python costs a hundred times as much. Wrong observations are bounded by Huber's loss,
then by Cauchy's.

Source: F. Dellaert and M. Kaess, Factor Graphs for Robot Perception, 2017.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import chain
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.scenes.scene import BodyOdometry, MarkerScene
from motorcade.tracking.markers.scenes.start import stated_rows
from motorcade.tracking.markers.scenes.table import CAMERA, SceneObservations
from motorcade.tracking.optimise import (
    PairIndex,
    PassingEquations,
    Stop,
    huber,
    huber_cauchy,
    minimise,
)

_HUBER, _OUTLIER = 4.0, 12.0
"""In deviations of an observation's eight residuals: where its loss turns straight, and flat."""
_NO_IMAGE = 1e3
_STOP = Stop(steps=40, gain=1e-5, most_damping=1e8, what="adjusting the scene")
_ROUGHLY = replace(_STOP, steps=15, gain=1e-3)
"""Where all is adjusted again from there: a step takes seconds where odometry joins the frames."""
_STEP = 1e-6


class _Linear(Protocol):
    """Factors of a kind at one table of poses, each upon k poses."""

    @property
    def cost(self) -> float:
        """Half the squares of their residuals, in deviations, or a robust loss."""

    def product(self, a: int, b: int) -> FloatArray:
        """``J_a^T J_b``, ``(n, 6, 6)``: derivatives by the poses in two columns."""

    def pull(self, a: int) -> FloatArray:
        """``J_a^T r``, ``(n, 6)``."""


@dataclass(frozen=True, eq=False)
class _Whitened:
    """Residuals ``(n, r)`` in deviations and their derivatives ``(n, k, r, 6)``."""

    residuals: FloatArray
    jacobians: FloatArray
    cost: float

    def product(self, a: int, b: int) -> FloatArray:
        left = self.jacobians[:, a].swapaxes(-1, -2)
        return np.asarray(left @ self.jacobians[:, b], np.float64)

    def pull(self, a: int) -> FloatArray:
        left = self.jacobians[:, a].swapaxes(-1, -2)
        return np.asarray((left @ self.residuals[..., None])[..., 0], np.float64)


@dataclass(frozen=True, eq=False)
class _Chained:
    """``J^T J`` ``(n, 6, 6)`` and ``J^T r`` ``(n, 6)`` by the first pose of a chain; derivatives by
    the others are J times a matrix ``(n, 6, 6)`` each.
    """

    information: FloatArray
    gradient: FloatArray
    others: tuple[FloatArray, ...]
    cost: float

    def product(self, a: int, b: int) -> FloatArray:
        right = self._by[b]
        return right if a == 0 else np.asarray(self._left(a) @ right, np.float64)

    def pull(self, a: int) -> FloatArray:
        if a == 0:
            return self.gradient
        return np.asarray((self._left(a) @ self.gradient[..., None])[..., 0], np.float64)

    def _left(self, a: int) -> FloatArray:
        return self.others[a - 1].swapaxes(-1, -2)

    @cached_property
    def _by(self) -> list[FloatArray]:
        return [self.information, *(self.information @ one for one in self.others)]


@dataclass(frozen=True, eq=False)
class Factors:
    """Factors of a kind.

    Fields:
        rows: ``(n, k)`` of the table: the poses that each hangs on.
        linearise: at a table of poses.
    """

    rows: IntArray
    linearise: Callable[[Motor], _Linear]


def corners(seen: SceneObservations, used: IntArray, sigma_px: float, bounded: bool) -> Factors:
    """Corners of observations ``(n,)`` of which every pose is known."""

    def linearise(poses: Motor) -> _Linear:
        residuals, jacobian, others = seen.linearised(poses, used)
        size = np.linalg.norm(residuals, axis=-1) / sigma_px
        size = np.where(jacobian.any(axis=(1, 2)), size, _NO_IMAGE)
        if bounded:
            loss, weight = huber_cauchy(size, _HUBER, _OUTLIER)
        else:
            loss, weight = huber(size, _HUBER)
        left = jacobian.swapaxes(-1, -2) * (weight / sigma_px**2)[:, None, None]
        gradient = (left @ residuals[..., None])[..., 0]
        return _Chained(left @ jacobian, gradient, others, float(np.sum(loss)))

    return Factors(seen.chain[used], linearise)


def stated(rows: IntArray, prior: Motor, covariance: FloatArray) -> Factors:
    """Poses that were stated, ``(n,)`` with covariances ``(n, 6, 6)``."""
    white = np.linalg.inv(np.linalg.cholesky(covariance))

    def linearise(poses: Motor) -> _Linear:
        apart = prior.local(poses[rows])
        residuals = (white @ apart[..., None])[..., 0]
        jacobians = (white @ Motor.right_jacobian_inverse(apart))[:, None]
        return _Whitened(residuals, jacobians, 0.5 * float(np.sum(residuals**2)))

    return Factors(rows[:, None], linearise)


def between(before: IntArray, after: IntArray, step: Motor, sigma: FloatArray) -> Factors:
    """Motions ``(n,)`` of a body from one frame to a later one, with deviations ``(n, 6)``.

    Odometry may jump: Huber's loss.
    """

    def linearise(poses: Motor) -> _Linear:
        moved = poses[before].inverse() @ poses[after]
        apart = step.local(moved)
        residuals = apart / sigma
        loss, weight = huber(np.linalg.norm(residuals, axis=-1), _HUBER)
        by_after = Motor.right_jacobian_inverse(apart)
        by_before = -by_after @ moved.inverse().adjoint()
        root = np.sqrt(weight)[:, None]
        jacobians = np.stack([by_before, by_after], axis=1) / sigma[:, None, :, None]
        return _Whitened(residuals * root, jacobians * root[..., None, None], float(np.sum(loss)))

    return Factors(np.stack([before, after], axis=1), linearise)


def measured(
    rows: IntArray, value: Callable[[Motor], FloatArray], length_m: FloatArray, sigma_m: FloatArray
) -> Factors:
    """Lengths ``(n,)`` that are told of poses at rows ``(n, k)``; derivatives by differences."""

    def linearise(poses: Motor) -> _Linear:
        here = poses[rows]
        residuals = (value(here) - length_m) / sigma_m
        jacobians = np.empty((*rows.shape, 1, 6))
        for column in range(rows.shape[1]):
            for axis in range(6):
                twist = np.zeros((*rows.shape, 6))
                twist[:, column, axis] = _STEP
                there = (value(here.retract(twist)) - value(here.retract(-twist))) / (2.0 * _STEP)
                jacobians[:, column, 0, axis] = there / sigma_m
        cost = 0.5 * float(np.sum(residuals**2))
        return _Whitened(residuals[:, None], jacobians, cost)

    return Factors(rows, linearise)


def scene_factors(
    seen: SceneObservations, scene: MarkerScene, known: NDArray[np.bool_]
) -> list[Factors]:
    """All that is stated and measured of poses that are known; corners are not among them."""
    factors: list[Factors] = []
    stated_poses = [(row, one) for row, one in stated_rows(seen, scene) if known[row]]
    if stated_poses:
        rows = np.array([row for row, _ in stated_poses])
        prior = Motor.stack([one.pose for _, one in stated_poses])
        factors.append(stated(rows, prior, np.stack([one.covariance for _, one in stated_poses])))
    for body, first in zip(scene.bodies, seen.first_row.tolist(), strict=True):
        if not body.moves:
            continue
        frames = np.flatnonzero(known[first : first + len(seen.time_ns)])
        if body.odometry is not None:
            path = body.odometry.trajectory
            inside = (seen.time_ns[frames] >= path.time_ns[0]) & (
                seen.time_ns[frames] <= path.time_ns[-1]
            )
            mine = frames[inside]
            if len(mine) > 1:
                step, sigma = odometry_steps(body.odometry, seen.time_ns[mine])
                factors.append(between(first + mine[:-1], first + mine[1:], step, sigma))
        if body.still is not None and len(frames) > 1:
            apart = np.sqrt(np.diff(frames))[:, None]
            sigma = apart * np.repeat(body.still, 3)
            none = Motor.identity((len(frames) - 1,))
            factors.append(between(first + frames[:-1], first + frames[1:], none, sigma))
    return factors + _wiggles(seen, scene, known) + _lengths(seen, scene, known)


def _wiggles(
    seen: SceneObservations, scene: MarkerScene, known: NDArray[np.bool_]
) -> list[Factors]:
    """Poses of cameras in single frames, about their usual ones."""
    usual, own = np.unique(np.stack([seen.usual_camera, seen.chain[:, CAMERA]]), axis=1)
    loose = (usual != own) & known[usual] & known[own]
    usual, own = usual[loose], own[loose]
    if not len(own):
        return []
    sigma = np.array([np.repeat(scene.wiggle.get(name, (1.0, 1.0)), 3) for name in seen.names])
    return [between(usual, own, Motor.identity((len(own),)), sigma[usual])]


def odometry_steps(odometry: BodyOdometry, time_ns: IntArray) -> tuple[Motor, FloatArray]:
    """Motion of the body between stamps ``(n,)``, and deviations ``(n - 1, 6)``."""
    path = odometry.trajectory.transformed_by(right=odometry.body_T_odometry.inverse())
    poses = path.motors_at(time_ns)
    step = poses[:-1].inverse() @ poses[1:]
    dt_s = np.maximum(np.diff(time_ns) * 1e-9, 1e-3)[:, None]
    rate = step.as_twist() / dt_s
    change = rate - np.concatenate([np.zeros((1, 6)), rate[:-1]])
    sizes = np.stack(
        [np.linalg.norm(change[:, :3], axis=-1), np.linalg.norm(change[:, 3:], axis=-1)], axis=-1
    )
    least, most = (np.array(one) * dt_s**2 for one in (odometry.least, odometry.most))
    sigma: FloatArray = np.repeat(np.clip(sizes * dt_s, least, most), 3, axis=-1)
    return step, sigma


def _lengths(
    seen: SceneObservations, scene: MarkerScene, known: NDArray[np.bool_]
) -> list[Factors]:
    row_of = {int(one): k for k, one in enumerate(seen.marker_ids)}

    def rows_of(marker: int) -> list[int] | None:
        k = row_of.get(marker)
        if k is None or scene.bodies[int(seen.marker_body[k])].moves:
            return None
        rows = [int(seen.first_row[seen.marker_body[k]]), len(seen.names) + k]
        return rows if known[rows].all() else None

    def corner_m(marker: int, corner: int | None) -> FloatArray:
        points: FloatArray = marker_points_m(seen.side_m[row_of[marker]])
        return np.asarray(points.mean(axis=0) if corner is None else points[corner], np.float64)

    factors: list[Factors] = []
    for distance in scene.distances:
        a, b = (rows_of(marker) for marker in distance.markers)
        if a is None or b is None:
            continue
        ends = [corner_m(*end) for end in zip(distance.markers, distance.corners, strict=True)]
        value = partial(_distance_m, ends=ends)
        factors.append(
            measured(
                np.array([a + b]),
                value,
                np.array([distance.distance_m]),
                np.array([distance.sigma_m]),
            )
        )
    for place in scene.coordinates:
        a = rows_of(place.marker)
        if a is None:
            continue
        value = partial(
            _coordinate_m,
            point=corner_m(place.marker, place.corner),
            direction=np.array(place.direction),
        )
        factors.append(
            measured(np.array([a]), value, np.array([place.length_m]), np.array([place.sigma_m]))
        )
    return factors


def _distance_m(poses: Motor, ends: list[FloatArray]) -> FloatArray:
    a = (poses[:, 0] @ poses[:, 1]).apply(ends[0])
    b = (poses[:, 2] @ poses[:, 3]).apply(ends[1])
    return np.asarray(np.linalg.norm(a - b, axis=-1), np.float64)


def _coordinate_m(poses: Motor, point: FloatArray, direction: FloatArray) -> FloatArray:
    return np.asarray((poses[:, 0] @ poses[:, 1]).apply(point) @ direction, np.float64)


class _Graph:
    """All factors, and which poses meet: the same at every table of poses."""

    def __init__(self, factors: list[Factors], frame: IntArray) -> None:
        self.factors, self.frame = factors, frame

    @cached_property
    def pulls(self) -> list[list[PairIndex]]:
        """Of each kind of factors and each column, whose gradient it belongs to."""
        return [
            [PairIndex(rows, np.zeros_like(rows)) for rows in factors.rows.T]
            for factors in self.factors
        ]

    @cached_property
    def products(self) -> list[list[tuple[int, int, PairIndex]]]:
        """Of each kind of factors the pairs of columns, and of each the poses that meet."""
        return [
            [
                (a, b, PairIndex(factors.rows[:, a], factors.rows[:, b]))
                for a in range(factors.rows.shape[1])
                for b in range(a, factors.rows.shape[1])
            ]
            for factors in self.factors
        ]

    @cached_property
    def joined(self) -> PairIndex:
        """All of them together, mirrored where both columns differ."""
        rows, columns = [], []
        for a, b, index in chain.from_iterable(self.products):
            rows.append(index.rows)
            columns.append(index.columns)
            if b > a:
                rows.append(index.columns)
                columns.append(index.rows)
        return PairIndex(np.concatenate(rows), np.concatenate(columns))


class _Evaluated:
    """All factors at one table of poses."""

    def __init__(self, graph: _Graph, poses: Motor) -> None:
        self._graph = graph
        self._linear = [one.linearise(poses) for one in graph.factors]
        self.cost = float(sum(one.cost for one in self._linear))

    @cached_property
    def equations(self) -> PassingEquations:
        graph = self._graph
        blocks: list[FloatArray] = []
        gradient = np.zeros((len(graph.frame), 6))
        for linear, pulls, products in zip(self._linear, graph.pulls, graph.products, strict=True):
            for a, whose in enumerate(pulls):
                gradient[whose.rows] += whose.sums(linear.pull(a))
            for a, b, index in products:
                blocks.append(index.sums(linear.product(a, b)))
                if b > a:
                    blocks.append(blocks[-1].swapaxes(-1, -2))
        joined = graph.joined
        summed = joined.sums(np.concatenate(blocks))
        return PassingEquations(joined.rows, joined.columns, summed, gradient, graph.frame)


def adjust_scene(
    seen: SceneObservations,
    scene: MarkerScene,
    poses: Motor,
    known: NDArray[np.bool_],
    *,
    bounded: bool,
    last: bool = True,
) -> tuple[Motor, PassingEquations]:
    """Refine all known poses at once; the others stay as they are.

    Args:
        seen: the observations.
        scene: what is stated.
        poses: the table ``(P,)`` to start from.
        known: ``(P,)``.
        bounded: whether far observations pull no more; the start must be near then.
        last: whether nothing comes after; else it ends a hundred times as roughly.

    Returns:
        the table, and its equations at the end.
    """
    used = np.flatnonzero(known[seen.chain].all(axis=1))
    factors = [
        corners(seen, used, scene.sigma_px, bounded),
        *scene_factors(seen, scene, known),
    ]
    graph = _Graph(factors, seen.frame_of)
    stop = _STOP if last else _ROUGHLY
    minimised = minimise(poses, partial(_Evaluated, graph), _retract, stop)
    return minimised.state, minimised.evaluation.equations


def _retract(poses: Motor, step: FloatArray) -> Motor:
    return poses.retract(step)
