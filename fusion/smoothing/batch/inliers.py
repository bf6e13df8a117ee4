"""Which poses of a path are inliers of one smooth motion, and the most probable path from there.

Wrong poses often come in runs that agree with each other, such as a planar marker's wrong candidate
over ten frames; then no average over a window tells right from wrong. The path is cut wherever it
leaps, and of the pieces that chain is taken which keeps the most poses at the least price for its
joints, by dynamic programming. A joint costs the squared error of extrapolating with the speed
at both sides, in deviations that the motion model allows, but never more than 20 poses: runs of up
to twice as many are left out, longer ones are kept with both their leaps.

The most probable path from there is a problem of least squares (see `robust_map`). The state of a
pose is its small move and the change of its velocity, 2 d numbers. Normal equations couple
neighbours only, and are factored from the first pose to the last (`native/robust_map.h`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.native import _columns, _robust_map
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

# Gaps are bridged by the speed of so many steps to both sides.
_NEIGHBOURS = 3
# Sizes in rad and m that rounding leaves.
_FINEST = 1e-8
# Of a normal vector of three components.
_MEDIAN_OF_NORM, _QUARTILE_OF_NORM = 1.5382, 2.0269
# The loss is this much wider than its own width at first, and halves until it is not.
_WIDEST = 8.0
LAST_STEPS = 60
# Largest move of a last step, in deviations of the noise; and where the loss narrows again anyway,
# which only has to lead to where that begins.
_CONVERGED, _NEARLY = 1e-5, 0.1


class Sizes(NamedTuple):
    """Deviation of a measured pose, and density of its white acceleration, of one block."""

    noise: float
    acceleration: float


def inlier_poses(
    time_s: FloatArray, poses: Motor, rotation: Sizes, translation: Sizes
) -> NDArray[np.bool_]:
    """Which of the poses ``(N,)`` belong to the longest smooth chain; at least one does.

    Args:
        time_s: ``(N,)`` increasing.
        poses: as measured.
        rotation: in rad and rad/s²/√Hz.
        translation: in m and m/s²/√Hz.
    """
    kept = np.ones(len(poses), dtype=np.bool_)
    if len(poses) >= 3:
        coefficients = np.ascontiguousarray(poses.coefficients, dtype=np.float64)
        _columns.chain(np.ascontiguousarray(time_s), coefficients, rotation, translation, kept)
    return kept


def bridged(time_s: FloatArray, poses: Motor, kept: NDArray[np.bool_]) -> Motor:
    """The path ``(N,)`` with the poses that are not kept put between their neighbours.

    In a gap the pose goes on with the speed at both sides, and what is missing at the far end is
    made up evenly along it; so a gap may hold full revolutions. Beyond the ends it stands still.
    """
    rows = np.flatnonzero(kept)
    lost = np.flatnonzero(~kept)
    if lost.size == 0 or rows.size == 1:
        return poses[rows[np.zeros(len(kept), dtype=np.int64)]] if lost.size else poses
    coefficients = np.array(poses.coefficients)
    coefficients[: rows[0]], coefficients[rows[-1] :] = coefficients[rows[[0, -1]]]
    gaps, speed, missing = crossings(time_s, poses, kept)
    lost = lost[(lost > rows[0]) & (lost < rows[-1])]
    if lost.size:
        gap = np.searchsorted(gaps[:, 1], lost)
        before = gaps[gap, 0]
        passed_s = (time_s[lost] - time_s[before])[:, None]
        share = passed_s / (time_s[gaps[gap, 1]] - time_s[before])[:, None]
        moved = Motor.from_twist(speed[gap] * passed_s) @ Motor.from_twist(missing[gap] * share)
        coefficients[lost] = (poses[before] @ moved).coefficients
    return Motor(coefficients)


def bridged_poses(
    time_s: FloatArray, poses: Motor | Similarity, kept: NDArray[np.bool_]
) -> Motor | Similarity:
    """The same of poses that may have a scale, which is interpolated beside."""
    rigid = bridged(time_s, poses.rigid, kept)
    if not isinstance(poses, Similarity):
        return rigid
    log_scale = np.interp(time_s, time_s[kept], np.log(poses.scale[kept]))
    return Similarity.from_motor_scale(rigid, np.exp(log_scale))


def crossings(
    time_s: FloatArray, poses: Motor, kept: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Gaps between kept poses: both ends ``(G, 2)``, speed over them, and what it misses by.

    The speed ``(G, 6)`` is the median of that at both sides, the other a twist ``(G, 6)``.
    """
    rows = np.flatnonzero(kept)
    span_s = np.diff(time_s[rows])
    gap, whole = (np.flatnonzero(one) for one in (np.diff(rows) > 1, np.diff(rows) == 1))
    speed = np.zeros((len(gap), 6))
    if whole.size and gap.size:
        steps = (poses[rows[whole]].inverse() @ poses[rows[whole + 1]]).as_twist()
        rates = steps / span_s[whole, None]
        around = np.searchsorted(whole, gap)[:, None] + np.arange(-_NEIGHBOURS, _NEIGHBOURS)
        speed = np.median(rates[np.clip(around, 0, len(whole) - 1)], axis=1)
    before, after = rows[gap], rows[gap + 1]
    arrival = poses[before] @ Motor.from_twist(speed * span_s[gap, None])
    return np.stack([before, after], axis=1), speed, (arrival.inverse() @ poses[after]).as_twist()


def first_sizes(trajectory: Trajectory) -> tuple[Sizes, Sizes]:
    """Rotation and translation, as differences of measured poses tell: on the wide side.

    White acceleration that would explain the upper quartile of changes of speed, and noise that
    would explain the median third difference, as if stamps were even: its square is 20 times that
    of the noise.
    """
    interval_s, poses = np.diff(trajectory.time_s)[:, None], trajectory.poses.rigid
    usual_s = float(np.median(interval_s))
    changes = np.diff((poses[:-1].inverse() @ poses[1:]).as_twist() / interval_s, axis=0)
    third = np.diff(changes, axis=0) * usual_s
    sizes = []
    for part in (slice(3), slice(3, 6)):
        noise = float(np.median(np.linalg.norm(third[:, part], axis=1)))
        change = float(np.quantile(np.linalg.norm(changes[:, part], axis=1), 0.75))
        noise, change = noise / _MEDIAN_OF_NORM / 20.0**0.5, change / _QUARTILE_OF_NORM
        sizes.append(Sizes(max(noise, _FINEST), max(change / usual_s**0.5, _FINEST)))
    return sizes[0], sizes[1]


class PathState(NamedTuple):
    """Coordinates ``(N, D)`` and velocities ``(N, d)``."""

    coordinates: FloatArray
    velocity: FloatArray


class Charged(NamedTuple):
    """A state, what its poses and the prior are charged, and squared residuals ``(N,)``."""

    state: PathState
    cost: float
    squares: FloatArray


def component_sizes(
    representation: Representation, count: int, rotation: float, translation: float, scale: float
) -> FloatArray:
    """Sizes ``(d,)`` of the components of a difference for sizes in rad, m and log scale.

    A small turn changes quaternion components by half of it, and so does a small shift the dual
    part of a dual quaternion near the origin (further off, components are larger than that).
    """
    (turning, shifting), (a_radian, a_metre) = representation.ends, representation.units
    sizes = np.full(count, scale)
    sizes[:turning], sizes[turning:shifting] = a_radian * rotation, a_metre * translation
    return sizes


class Problem:
    """Measured poses and the model; see the module."""

    def __init__(
        self,
        representation: Representation,
        time_s: FloatArray,
        poses: Motor | Similarity,
        start: NDArray[np.bool_],
        sizes: tuple[Sizes, Sizes, Sizes],
    ) -> None:
        self.representation = representation
        self.time_s, self.interval_s = time_s, np.diff(time_s)
        self.poses, self.start = poses, start
        self.measured = representation.coordinates(poses)
        d = representation.local(self.measured[:1], self.measured[:1]).shape[-1]
        self.noise = component_sizes(representation, d, *(size.noise for size in sizes))
        self.density = component_sizes(representation, d, *(size.acceleration for size in sizes))

    def narrowed(self, loss: str, width: float) -> PathState:
        """The path of the poses to start from alone, by a loss that narrows down to its width."""
        state = self._first_guess()
        self.measured = self.written(self.poses, state.coordinates)
        wide = _WIDEST * width
        while loss != "squares" and wide > width:
            state = self.descended(state, loss, wide, self.start, 3, _NEARLY).state
            wide *= 0.5
        return state

    def written(self, poses: Motor | Similarity, near: FloatArray) -> FloatArray:
        """Coordinates of poses ``(K,)``, on the branches nearest to others ``(K, D)``."""
        own = self.representation.coordinates(poses)
        return np.array(self.representation.continued(own, near))

    def _first_guess(self) -> PathState:
        """The poses to start from, and what lies between them."""
        guess = bridged_poses(self.time_s, self.poses, self.start)
        coordinates = self.representation.coordinates(guess)
        steps = self.representation.local(coordinates[1:], coordinates[:-1])
        rate = steps / self.interval_s[:, None]
        velocity = np.concatenate([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
        return PathState(coordinates, velocity)

    def charged(
        self, state: PathState, loss: str, width: float, among: NDArray[np.bool_]
    ) -> Charged:
        """What the prior and some of the poses charge at a state."""
        return self.descended(state, loss, width, among, steps=0)

    def descended(
        self,
        state: PathState,
        loss: str,
        width: float,
        among: NDArray[np.bool_],
        steps: int,
        converged: float = _CONVERGED,
    ) -> Charged:
        """Lower the cost of a loss over some of the poses until it does not fall any more."""
        moved = PathState(*(np.array(one, order="C") for one in state))
        squares = np.empty(len(self.time_s))
        cost = _robust_map.descend(
            self._kind(), self._given(among), (loss, width), moved, steps, converged, squares
        )
        return Charged(moved, cost, squares)

    def stepped(
        self, state: PathState, loss: str, width: float, pull: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The step downhill ``(N, 2 d)``, and those that pulls ``(N, 2 d, k)`` would make."""
        alone = np.empty((len(self.time_s), 2 * len(self.noise)))
        along = np.array(pull, order="C")
        inputs = self._given(np.ones(len(self.time_s), np.bool_))
        _robust_map.step(self._kind(), inputs, (loss, width), state, alone, along)
        return alone, along

    def retract(self, state: PathState, move: FloatArray) -> PathState:
        """The state a step ``(N, 2 d)`` on."""
        d = state.velocity.shape[1]
        coordinates = self.representation.retract(state.coordinates, move[:, :d])
        return PathState(coordinates, state.velocity + move[:, d:])

    def _kind(self) -> tuple[str, bool]:
        beside = self.representation.scale_beside and isinstance(self.poses, Similarity)
        return self.representation.compiled, beside

    def _given(
        self, among: NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray, NDArray[np.bool_], FloatArray, FloatArray]:
        measured = np.ascontiguousarray(self.measured)
        return self.interval_s, measured, among, self.noise, self.density


def with_rigid(poses: Motor | Similarity, rigid: Motor) -> Motor | Similarity:
    """Other rigid poses with the scale of these, where they have one."""
    if isinstance(poses, Similarity):
        return Similarity.from_motor_scale(rigid, poses.scale)
    return rigid


def loss_weights(squares: FloatArray, loss: str, width: float) -> FloatArray:
    """``ρ'(s)``."""
    if loss == "cauchy":
        return np.asarray(1.0 / (1.0 + squares / width**2), dtype=np.float64)
    if loss == "huber":
        return np.asarray(width / np.sqrt(np.maximum(squares, width**2)), dtype=np.float64)
    return np.ones_like(squares)
