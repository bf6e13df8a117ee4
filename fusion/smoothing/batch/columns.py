"""Smoothing splines of columns, which of them a column calls for, and columns of one twist.

A column is a number at stamps: one axis of a path. White noise of some density drives its first,
second or third derivative but one (`order` derivatives change, and the one above is noise), and its
measured values have white noise besides; the most probable path is a smoothing spline (G. Wahba,
Improper priors, spline smoothing and the problem of guarding against model errors in regression, J.
Royal Statistical Society B 40, 1978).

Order and density are those that predict best: each value from all others, by generalised
cross-validation (P. Craven, G. Wahba, Smoothing noisy data with spline functions, Numerische
Mathematik 31, 1979). What predicts nearly as well, by no more than the errors' own scatter
explains, counts as equal, and of equals the likeliest is taken: prediction alone is blind to noise
that lasts for some poses, likelihood alone is led astray by motion that the model does not have.

Some columns move together. However stiff the splines of its axes are, a body that turns takes the
axes along, and errors with them. But where nothing else moves the path is ``X exp(t ξ)``, whose
twelve numbers least squares tell from all poses (T. D. Barfoot, State Estimation for Robotics, 2nd
ed., 2024, ch. 7); where it goes anywhere and turns evenly, six do for its rotations. Where the rate
changes as well, a Kalman filter and smoother propagates errors of all three axes along the turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from motorcade.fusion.prediction import EQUAL, standard_errors
from motorcade.fusion.smoothing.causal.kalman import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    smoothed_states,
)
from motorcade.fusion.smoothing.native import _columns
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

ORDERS = (1, 2, 3)
# Logarithms of the process's variance from one value to the next over the noise's that are tried:
# from splines as stiff as a thousand values to such as go through every one; then around the best.
COARSE, FINE = np.arange(-28.0, 8.5, 3.0), np.array([-2.0, -1.0, 1.0, 2.0])
# With that logarithm a spline goes through every value.
_EXACT = 14.0
# Bodies shake as fast as stamps resolve, and faster: what is folded back looks like noise, but does
# not fill the band. So noise is told where it alone has this share of the band at least. Chosen on
# V1_02 and synthetic motions.
_NOISE_ALONE = 0.45
_BAND, _FOLDS = np.pi * (np.arange(256) + 0.5) / 256, 2.0 * np.pi * np.arange(-2, 3)[:, None]
NO_JUMPS: IntArray = np.empty(0, dtype=np.int64)
_ROUNDS = 4
# Noise of an axis that is finer by more than this than the usual one hinders more than it tells.
FINEST = 0.1
# Noise of rotations in rad, or positions in m, that is none.
LEAST = 1e-9
# Orders of rotations that are smoothed together, the least weight that a pose has there, which
# leaves a filter's covariances half of their digits, and noise that is enough for rounding.
_JOINT_ORDERS, _LIGHTEST, _NO_NOISE = (1, 2), 1e-8, 1e-6

# Shares of an error that may be left at the next pose, and how many such memories a path must span
# for errors to be told from motion.
_KEPT, MEMORIES = (0.3, 0.5, 0.7, 0.8, 0.9), 32.0


@dataclass(frozen=True)
class ColumnModel:
    """How a column moves, and how noisy its values are.

    Fields:
        order: how many derivatives change smoothly.
        ratio: density of the noise that drives the highest, in deviations of a value.
        noise: deviation of a value.
        memory_s: in which an error decays to a third (1/e); 0 where errors are white.
        unobservable: why values do not tell their noise, whose size then says nothing; else empty.
        stiff: whether it moves by a constant twist; see the module.
        joint: whether all rotations are smoothed together, by this model; see there.
    """

    order: int
    ratio: float
    noise: float
    memory_s: float = 0.0
    unobservable: str = ""
    stiff: bool = False
    joint: bool = False

    @property
    def density(self) -> float:
        """Of the process, in the column's unit over s^(order + 1) √Hz."""
        return self.ratio * self.noise

    def rate(self, interval_s: float) -> float:
        """In rad/s, at which process and noise are as strong."""
        return float((self.ratio / np.sqrt(interval_s)) ** (1.0 / (self.order + 1)))

    def told(self, interval_s: float) -> ColumnModel:
        """The model where it leaves enough of the band to noise alone, else one through all."""
        if self.noise_alone(interval_s) >= _NOISE_ALONE:
            return self
        return self.through_all(interval_s, "its motion takes up the band that would tell")

    def noise_alone(self, interval_s: float) -> float:
        """Share of the frequencies up to half the rate that the spline does not pass."""
        kept = float(np.exp(-interval_s / self.memory_s)) if self.memory_s > 0.0 else 0.0
        errors = (1.0 - kept**2) / np.abs(1.0 - kept * np.exp(1j * _BAND)) ** 2
        level = self.ratio**2 * interval_s ** (2 * self.order + 1)
        motion = level * np.sum(np.abs(_BAND + _FOLDS) ** (-2.0 * (self.order + 1)), axis=0)
        return float(np.mean(errors / (errors + motion)))

    def through_all(self, interval_s: float, unobservable: str) -> ColumnModel:
        """A model that goes through every value, whose noise is not told, and why."""
        ratio = ratio_of(_EXACT, self.order, interval_s)
        return replace(
            self, ratio=ratio, memory_s=0.0, unobservable=unobservable, stiff=False, joint=False
        )

    def smoother(self, smoothness: float, interval_s: float) -> ColumnModel:
        """The model that averages over ``2**smoothness`` times as long.

        A spline that goes through every value is made smoother from where it first does not.
        """
        rate = self.rate(interval_s)
        if smoothness > 0.0:
            rate = min(rate, np.pi / interval_s)
        ratio = float(np.sqrt(interval_s) * (rate * 2.0**-smoothness) ** (self.order + 1))
        return replace(self, ratio=ratio, stiff=self.stiff and smoothness >= 0.0)


@dataclass(frozen=True, eq=False)
class ColumnPath:
    """A smoothed column ``(N,)``, or several ``(N, K)`` of one model.

    Fields:
        values: smoothed.
        left_out: measured values less what all others make of them.
        variance: ``(N,)`` that these have beyond the noise's own, in that of the noise of a value
            of weight 1; less than nothing where the others tell of its error.
        spread: ``(N,)`` variance of the smoothed values, likewise.
    """

    values: FloatArray
    left_out: FloatArray
    variance: FloatArray
    spread: FloatArray


@dataclass(frozen=True, eq=False)
class ColumnSegment:
    """Columns ``(N, K)`` at stamps ``(N,)`` with the weights ``(N,)`` of their rows; 0 is none.

    Before the rows `jumps` their level jumps.
    """

    time_s: FloatArray
    values: FloatArray
    weights: FloatArray
    jumps: IntArray = field(default_factory=lambda: NO_JUMPS)


def splined(
    time_s: FloatArray,
    column: FloatArray,
    weights: FloatArray,
    order: int,
    ratio: float,
    jumps: IntArray = NO_JUMPS,
    shocks: FloatArray | None = None,
    memory_s: float = 0.0,
) -> ColumnPath:
    """The smoothing spline of a column ``(N,)``, of which more than `order` rows have a weight.

    Args:
        time_s: ``(N,)`` increasing.
        column: ``(N,)``.
        weights: ``(N,)``, 0 where a row is not measured.
        order: of the model.
        ratio: of the model.
        jumps: rows before which the level jumps, while derivatives go on; ascending.
        shocks: ``(N, 1, 2)``, filled where given: by how many deviations, for unit noise, a jump of
            the value and one of its slope before each row would differ from none.
        memory_s: of the model's errors.
    """
    segment = ColumnSegment(time_s, np.ascontiguousarray(column[:, None]), weights, jumps)
    path, _ = _splined(segment, order, ratio, memory_s, shocks)
    return replace(path, values=path.values[:, 0], left_out=path.left_out[:, 0])


def _splined(
    segment: ColumnSegment,
    order: int,
    ratio: float,
    memory_s: float,
    shocks: FloatArray | None = None,
) -> tuple[ColumnPath, tuple[float, list[float], float]]:
    """Splines of columns ``(N, K)``; of their innovations how many, squares and logarithms."""
    columns, weights = segment.values, segment.weights
    values, left_out = np.empty(columns.shape), np.empty(columns.shape)
    variance, spread = np.empty((2, len(columns)))
    out = (values, left_out, variance, spread)
    innovations = _columns.spline(
        segment.time_s, columns, weights, segment.jumps, order, ratio, memory_s, out, shocks
    )
    return ColumnPath(*out), innovations


def noise_of(paths: Sequence[ColumnPath], weights: Sequence[FloatArray]) -> float:
    """Deviation of a value of weight 1, from how far values lie from what the others make."""
    squares = rows = 0.0
    for path, weight in zip(paths, weights, strict=True):
        squares += float(np.sum(weight * path.left_out**2 / (1.0 + weight * path.variance)))
        rows += float(np.count_nonzero(weight))
    return float(np.sqrt(squares / rows))


def chosen(
    segments: Sequence[ColumnSegment],
    orders: tuple[int, ...] = ORDERS,
    equal: float = EQUAL,
    known: FloatArray | None = None,
) -> list[ChosenColumn]:
    """The models that the columns of some segments call for; see the module.

    Args:
        segments: of the path.
        orders: that come into question.
        equal: standard errors up to which predictions count as equal; infinite takes the likeliest.
        known: ``(K,)`` deviations of the columns' values, NaN where they are to be found out.
            Where they are known, predictions are judged by them: an unbiased estimate of the risk
            (C. L. Mallows, Some comments on Cp, Technometrics 15, 1973) for cross-validation.
    """
    interval_s = float(np.median(np.diff(segments[0].time_s)))
    tried: dict[tuple[int, float], Prediction] = {}

    def predicted(order: int, level: float) -> Prediction:
        if (order, level) not in tried:
            tried[order, level] = Prediction.by(
                segments, order, ratio_of(level, order, interval_s), 0.0
            )
        return tried[order, level]

    columns = segments[0].values.shape[1]
    picked = []
    for column, noise in enumerate(np.full(columns, np.nan) if known is None else known):
        searched = not np.isfinite(noise)
        own = []
        for order in orders:
            tried_first = [predicted(order, level) for level in COARSE]
            best = COARSE[
                int(np.argmin([candidate.score(column, noise) for candidate in tried_first]))
            ]
            own += tried_first + [predicted(order, best + step) for step in FINE]
        best_of_all = min(own, key=lambda candidate: candidate.score(column, noise))
        risks = np.stack([candidate.risks(column, noise) for candidate in own])
        behind = standard_errors(risks - best_of_all.risks(column, noise))
        equals = [candidate for candidate, by in zip(own, behind, strict=True) if by <= equal]
        taken = max(equals, key=lambda candidate: candidate.likelihood(column, noise))
        size = float(taken.noise[column] if searched else noise)
        model = ColumnModel(taken.order, taken.ratio, size)
        rows = sum(len(segment.weights) for segment in segments)
        density = -0.5 * rows * float(np.log(max(best_of_all.scores[column], 1e-300)))
        likelihood = max(candidate.likelihood(column, noise) for candidate in own)
        picked.append(ChosenColumn(model, density, best_of_all, likelihood))
    return picked


class ChosenColumn(NamedTuple):
    """What a column calls for.

    Fields:
        model: the column's.
        density: logarithm of that of every value given the others, at its best scale.
        best: what predicts the values best, which the model does as well.
        likelihood: logarithm of that of the likeliest model.
    """

    model: ColumnModel
    density: float
    best: Prediction
    likelihood: float


@dataclass(frozen=True, eq=False)
class Prediction:
    """How well a model predicts values of columns from the others.

    Fields:
        order, ratio, memory_s: of the model.
        noise: ``(K,)`` deviations of a value of weight 1.
        squares: ``(K, N)`` squared residuals, those beside gaps, which tell little, made less.
        scores: ``(K,)`` their means.
        shares: ``(N,)`` of its noise that a value's residual from the spline has.
        innovations: how many there are, the sum of their squares in unit noise ``(K,)``, and that
            of the logarithms of their variances.
    """

    order: int
    ratio: float
    memory_s: float
    noise: FloatArray
    squares: FloatArray
    scores: FloatArray
    shares: FloatArray
    innovations: tuple[float, FloatArray, float]

    @classmethod
    def by(
        cls, segments: Sequence[ColumnSegment], order: int, ratio: float, memory_s: float
    ) -> Prediction:
        """How well a model predicts the values of some segments that have a weight."""
        splines = [_splined(one, order, ratio, memory_s) for one in segments]
        weights = np.concatenate([one.weights for one in segments])
        used = np.flatnonzero(weights)
        kept = weights[used]
        off = np.concatenate([path.left_out for path, _ in splines])[used]
        squares = np.ascontiguousarray(off.T) ** 2
        shares = 1.0 / (1.0 + kept * np.concatenate([path.variance for path, _ in splines])[used])
        noise = np.sqrt(squares @ (kept * shares) / len(kept))
        squares *= kept * (shares / float(np.mean(shares))) ** 2
        innovations = (
            sum(one[0] for _, one in splines),
            np.asarray(np.sum([one[1] for _, one in splines], axis=0), dtype=np.float64),
            sum(one[2] for _, one in splines),
        )
        scores = np.mean(squares, axis=1)
        return cls(order, ratio, memory_s, noise, squares, scores, shares, innovations)

    def risks(self, column: int, noise: float) -> FloatArray:
        """Of each value ``(N,)``: its squared residual, or with known noise what that tells of the
        spline's own error.
        """
        if not np.isfinite(noise):
            return np.asarray(self.squares[column], dtype=np.float64)
        residuals = self.squares[column] * float(np.mean(self.shares)) ** 2
        return np.asarray(residuals + noise**2 * (1.0 - 2.0 * self.shares), dtype=np.float64)

    def score(self, column: int, noise: float) -> float:
        """The mean of these; the less the better."""
        if not np.isfinite(noise):
            return float(self.scores[column])
        return float(np.mean(self.risks(column, noise)))

    def likelihood(self, column: int, noise: float) -> float:
        """Logarithm of the likelihood of a column, at known noise or else the likeliest."""
        rows, squares, logarithms = self.innovations
        if rows == 0.0:
            return -float("inf")  # all only open the state, and tell no model from another
        likeliest = float(np.sqrt(max(float(squares[column]), 1e-300) / rows))
        size = noise if np.isfinite(noise) else likeliest
        return -0.5 * (
            2.0 * rows * float(np.log(size)) + logarithms + float(squares[column]) / size**2
        )


def told_noise(models: Sequence[ColumnModel]) -> float | None:
    """Root mean square deviation of the columns that tell theirs; None where none does."""
    sizes = [one.noise for one in models if not one.unobservable]
    return float(np.sqrt(np.mean(np.square(sizes)))) if sizes else None


def noise_in_words(noise_m: float | None, noise_rad: float | None) -> str:
    """Deviations of position and rotation, in mm and degrees."""
    shift = "not told" if noise_m is None else f"{1e3 * noise_m:.3g} mm"
    turn = "not told" if noise_rad is None else f"{np.rad2deg(noise_rad):.3g}°"
    return f"{shift} and {turn}"


def ratio_of(level: float, order: int, interval_s: float) -> float:
    """Of a process whose variance from one value to the next has that logarithm, in the noise's."""
    return float(np.exp(0.5 * level) / interval_s ** (order + 0.5))


def likelihoods(
    segments: Sequence[ColumnSegment], order: int, ratio: float, memory_s: float
) -> FloatArray:
    """Logarithms of the likelihood of columns ``(K,)``, each at its likeliest noise."""
    innovations = [
        _columns.spline(
            segment.time_s, segment.values, segment.weights, segment.jumps, order, ratio, memory_s
        )
        for segment in segments
    ]
    rows = sum(part[0] for part in innovations)
    squares = np.maximum(np.sum([part[1] for part in innovations], axis=0), 1e-300)
    if rows == 0.0:
        return np.full(len(squares), -np.inf)
    logarithms = sum(part[2] for part in innovations)
    return np.asarray(-0.5 * (rows * (np.log(squares / rows) + 1.0) + logarithms))


def moved_together(
    representation: Representation,
    time_s: FloatArray,
    coordinates: FloatArray,
    path: FloatArray,
    weights: FloatArray,
    models: Sequence[ColumnModel],
) -> dict[int, ColumnPath]:
    """The columns whose models are stiff or joint, as splines have them, of values beyond a path's.

    Args:
        representation: motors where rotations and positions are stiff, else rotors or motors.
        time_s: ``(N,)`` increasing.
        coordinates: ``(N, D)`` of measured poses.
        path: ``(N, D)`` near them, to start from.
        weights: ``(N,)`` of these.
        models: of the columns.
    """
    stiff = [k for k, model in enumerate(models) if model.stiff]
    joint = models[0].joint
    if not stiff and not joint:
        return {}
    poses, near = (representation.poses(base).rigid for base in (coordinates, path))
    if joint:
        smoothed, spread = turned_together(time_s, poses, weights, models[0])
        beyond, off = (
            (base.rotor.inverse() @ other.rotor).as_rotation_vector()
            for base, other in ((near, smoothed), (smoothed, poses))
        )
        others = spread / np.maximum(1.0 - weights * spread, LEAST)
        left_out = off * (1.0 + weights * others)[:, None]
        return {k: ColumnPath(beyond[:, k], left_out[:, k], others, spread) for k in range(3)}
    if len(stiff) == 3:
        poses, near = (
            Motor.from_rotor_translation(base.rotor, np.zeros((len(base), 3)))
            for base in (poses, near)
        )
    parts = np.reshape([base.noise for base in models[: len(stiff)]], (-1, 3))
    usual = np.sqrt(np.mean(parts**2, axis=1, keepdims=True))
    noise = np.resize(np.maximum(parts, FINEST * usual) + LEAST, 6)
    fitted, off, spread = _fitted(time_s, poses, near, weights, noise)
    beyond = (near.inverse() @ fitted).as_twist()
    columns = {}
    for k in stiff:
        others = spread[:, k] / np.maximum(1.0 - weights * spread[:, k], LEAST)
        left_out = off[:, k] * (1.0 + weights * others)
        if models[k].memory_s > 0.0:
            beside, less = _beside(time_s, left_out, weights, models[k].memory_s)
            # Of an error whose variance is that of weight 1 divided by its own.
            left_out, others = left_out - beside, others - less / np.where(weights > 0, weights, 1)
        columns[k] = ColumnPath(beyond[:, k], left_out, others, spread[:, k])
    return columns


def _beside(
    time_s: FloatArray, off: FloatArray, weights: FloatArray, memory_s: float
) -> tuple[FloatArray, FloatArray]:
    """What errors ``(N,)`` that last tell of those between, and by what share of their variance.

    The nearest to either side tell it all (G. E. Uhlenbeck, L. S. Ornstein, 1930).
    """
    rows, kept = np.flatnonzero(weights), np.arange(len(off))
    before = np.searchsorted(rows, kept) - 1
    behind = np.searchsorted(rows, kept, "right")
    near = []
    for place, there in ((before, before >= 0), (behind, behind < len(rows))):
        row = rows[np.clip(place, 0, len(rows) - 1)]
        left = np.exp(-np.abs(time_s[row] - time_s) / memory_s)
        near.append((np.where(there, left, 0.0), off[row]))
    (first, past), (last, next_) = near
    both = 1.0 - (first * last) ** 2
    shared = (first * (1.0 - last**2) * past + last * (1.0 - first**2) * next_) / both
    return shared, 1.0 - (1.0 - first**2) * (1.0 - last**2) / both


def _fitted(
    time_s: FloatArray, poses: Motor, path: Motor, weights: FloatArray, noise: FloatArray
) -> tuple[Motor, FloatArray, FloatArray]:
    """The likeliest path, twists ``(N, 6)`` from it to poses, and its variance in their noise's."""
    middle = len(time_s) // 2
    passed_s = (time_s - time_s[middle])[:, None]
    steps = (path[:-1].inverse() @ path[1:]).as_twist() / np.diff(time_s)[:, None]
    pose, twist = path[middle], np.median(steps, axis=0)
    step, scales = np.zeros(12), np.sqrt(weights)[:, None] / noise
    for _ in range(_ROUNDS + 1):
        pose, twist = pose @ Motor.from_twist(step[:6]), twist + step[6:]
        moved = Motor.from_twist(twist * passed_s)
        off = ((pose @ moved).inverse() @ poses).as_twist()
        turned = passed_s[..., None] * Motor.right_jacobian(twist * passed_s)
        slopes = np.concatenate([moved.inverse().adjoint(), turned], axis=2)
        rows = (slopes * scales[..., None]).reshape(-1, 12)
        covariance = np.linalg.pinv(rows.T @ rows, hermitian=True)
        step = covariance @ (rows.T @ (off * scales).ravel())
    spread = np.einsum("nij,jk,nik->ni", slopes, covariance, slopes, optimize=True)
    return pose @ moved, off, spread / noise**2


def turned_together(
    time_s: FloatArray, poses: Motor, weights: FloatArray, model: ColumnModel
) -> tuple[Motor, FloatArray]:
    """Poses ``(N,)`` with smoothed rotations, and their variance in that of a pose of weight 1."""
    noise = max(model.noise, _NO_NOISE)
    noise_rad = noise / np.sqrt(np.maximum(weights, _LIGHTEST))
    chosen = (
        ConstantVelocityFilter(
            angular_acceleration_rad_s2=model.ratio * noise,
            noise_rad=noise_rad,
            representation="rotor",
        )
        if model.order == 1
        else ConstantAccelerationFilter(
            angular_jerk_rad_s3=model.ratio * noise, noise_rad=noise_rad, representation="rotor"
        )
    )
    still = Motor.from_rotor_translation(poses.rotor, np.zeros((len(poses), 3)))
    states = smoothed_states(Trajectory(np.rint(1e9 * time_s).astype(np.int64), still), chosen)
    return states.trajectory.motors, (states.deviations[:, 0, 0] / noise) ** 2


def turning_model(
    time_s: FloatArray, poses: Motor, weights: FloatArray, noise: float
) -> ColumnModel:
    """What predicts each rotation best from all others, by generalised cross-validation."""
    interval_s, kept = float(np.median(np.diff(time_s))), weights > 0.0

    def scored(order: int, level: float) -> tuple[float, ColumnModel]:
        model = ColumnModel(order, ratio_of(level, order, interval_s), noise, joint=True)
        smoothed, spread = turned_together(time_s, poses, weights, model)
        off = (smoothed.rotor.inverse() @ poses.rotor).angle()[kept]
        shares = 1.0 - (weights * spread)[kept]
        return float(np.mean(weights[kept] * off**2) / np.mean(shares) ** 2), model

    tried = [scored(order, level) for order in _JOINT_ORDERS for level in COARSE]
    best = int(np.argmin([score for score, _ in tried]))
    order, level = _JOINT_ORDERS[best // len(COARSE)], COARSE[best % len(COARSE)]
    tried += [scored(order, level + step) for step in FINE]
    return min(tried, key=lambda trial: trial[0])[1]


def memories_beside(segment: ColumnSegment, columns: int) -> FloatArray | None:
    """For how many seconds errors ``(columns,)`` last of which poses beyond a path consist; else
    None, where the first of some columns hold motion too.

    That is where a spline of a velocity that white noise changes makes them likelier than errors
    alone do, white or lasting, by what G. Schwarz asks for of two numbers more: how large that is,
    and where it starts. What is much finer than errors about the other axes is none.
    """
    interval_s, rows = float(np.median(np.diff(segment.time_s))), np.count_nonzero(segment.weights)
    memories_s = [0.0] + [
        -interval_s / float(np.log(kept)) for kept in _KEPT if -np.log(kept) * rows >= MEMORIES
    ]
    ratios = [ratio_of(level, 1, interval_s) for level in COARSE]
    likelihood = np.array(
        [[likelihoods([segment], 1, ratio, one) for ratio in ratios] for one in memories_s]
    )[..., :columns]
    gained = np.max(likelihood, axis=(0, 1)) - np.max(likelihood[:, 0], axis=0)
    parts = np.sqrt(np.mean(segment.values[:, :columns] ** 2, axis=0)).reshape(-1, 3)
    counts = parts > FINEST * np.sqrt(np.mean(parts**2, axis=1, keepdims=True))
    if np.any(gained[counts.ravel()] > np.log(rows)):
        return None
    still = np.sum(likelihood[:, 0].reshape(len(memories_s), -1, 3), axis=2)
    still[1:] -= np.log(rows)  # a memory is one number more, which must be worth it
    return np.repeat(np.array(memories_s)[np.argmax(still, axis=0)], 3)
