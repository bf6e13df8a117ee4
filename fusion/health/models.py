"""The models that a sensor's readings are tested against, and which of them explains these best.

In order of belief: as stated; one fault, which is extrinsics that were given the wrong way round,
or signs and axes, the simplest first; both at once; any rotation. Each may come with a unit. What
has a mend of its own so stands before what explains as much by accident, and a model only counts
where the motion tells it from nothing. Those that explain as much are kept as candidates: the other
sensor may tell them apart (see `check`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import permutations, product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray

Base = Literal["stated", "inverted"]
State = Literal["sound", "named", "unexplained", "nothing"]
Model = tuple[Base, FloatArray]
"""Which way round the extrinsics are to be read, and a signed permutation ``(3, 3)``."""

NEEDED = 12.0
"""Logarithm of the odds at which a model beats another: e¹² is one error in 160,000."""
SCALE_TOLERANCE = 0.1
"""A unit or a fault changes readings by more; scales of MEMS sensors are good to a few percent."""
TURN_TOLERANCE_RAD = float(np.deg2rad(5.0))
"""Drawings and screws place a camera to a degree or two."""
SIGMAS = 4.0
"""On top of a tolerance: one of 16,000 estimates lies further off by chance."""
_BLURRED = 0.25
_SURE = 2.0  # deviations
_SEARCHED = 200
_TURNS = 3
# Of the score, by which six elements more of K may explain readings better than scales alone.
_SCALES_LOSE = 3.0 * NEEDED
# Of each element of K: scales on the diagonal, turns beside it.
_TOLERANCE = np.where(np.eye(3) > 0.0, SCALE_TOLERANCE, np.sin(TURN_TOLERANCE_RAD))


@dataclass(frozen=True, eq=False)
class AxesVerdict:
    """How a sensor's readings stand to the camera's path.

    Fields:
        state: sound; named, where a model other than the stated one explains them; unexplained,
            where they tell something that no model explains; nothing, where they tell nothing.
        base: which way round the extrinsics were to be read.
        permutation: ``(3, 3)`` signed; true readings are multiple · turn · permutation · scales ·
            readings.
        turn: ``(3, 3)`` rotation that is left besides; the identity where axes explain all.
        multiple: of the readings; one where that explains them.
        gain: logarithm of the odds against readings that have nothing to do with the path.
        sigma: ``(3, 3)`` deviations of the elements of K, as shares.
        fit: of what was chosen, with the unknowns besides K last.
        candidates: models without a turn that explain the readings as well, this one among them, by
            belief; none where that was not asked, or a turn explains them.
        scales: of the axes of the readings, where one of them differs from the others.
    """

    state: State
    base: Base
    permutation: FloatArray
    turn: FloatArray
    multiple: float
    gain: float
    sigma: FloatArray
    fit: RobustFit
    candidates: tuple[Model, ...] = ()
    scales: tuple[float, float, float] = (1.0, 1.0, 1.0)

    @property
    def turn_rad(self) -> float:
        """Angle of the turn."""
        return float(np.arccos(np.clip(0.5 * (np.trace(self.turn) - 1.0), -1.0, 1.0)))

    @property
    def blurred(self) -> str:
        """Axes x, y, z of the readings of which the motion tells little."""
        dark = (self.sigma.max(axis=0) > _BLURRED) | (self.least_scales > 1.0 / _SMALLEST)
        return "".join(axis for axis, one in zip("xyz", dark, strict=True) if one)

    @property
    def least_scales(self) -> FloatArray:
        """What multiple of true rates an axis ``(3,)`` must read to be named nearly always."""
        share = SCALE_TOLERANCE + (SIGMAS + _SURE) * np.diag(self.sigma)
        return np.asarray(1.0 / np.maximum(1.0 - share, 0.5 * _SMALLEST))

    @property
    def matrix(self) -> FloatArray:
        """K ``(3, 3)``: what makes true readings."""
        matrix: FloatArray = self.multiple * self.turn @ self.permutation * np.array(self.scales)
        return matrix


def judge_stated(evidence: AxesEvidence, needed: float = NEEDED) -> AxesVerdict:
    """Whether readings are as stated: the state is then sound, and unexplained where not."""
    nothing, same = evidence.nothing(), evidence.along(np.eye(3))
    gain = same.score - nothing.score
    free = evidence.free(np.eye(3), same.sigma)
    off, sigma = _off(free, np.eye(3), 1.0)
    sound = gain >= needed and bool(np.all(off <= _TOLERANCE + SIGMAS * sigma))
    sound = sound and not evidence.strained(same)
    state: State = "sound" if sound else "unexplained"
    identity = np.eye(3)
    return AxesVerdict(state, "stated", identity, identity, 1.0, gain, sigma, same)


def judge_axes(
    evidence: Mapping[Base, AxesEvidence], units: tuple[float, ...], needed: float = NEEDED
) -> AxesVerdict:
    """Which model explains readings that are not as stated.

    Evidence is by which way round the extrinsics are read, the more believed first.
    """
    believed = next(iter(evidence))
    candidates = find_candidates(evidence)
    if not candidates:
        return replace(judge_stated(evidence[believed], needed), state="nothing")
    base, matrix = candidates[0]
    own = evidence[base]
    nothing = own.nothing().score
    fit = own.scaled(matrix, own.multiple(matrix))
    multiple = _named_multiple(float(fit.values[0]), float(fit.deviations[0]), units)
    fitted = own.along(multiple * matrix)
    free = own.free(multiple * matrix, fitted.sigma)
    off, sigma = _off(free, matrix, multiple)
    gain = fit.score - nothing
    if np.any(off > _TOLERANCE + SIGMAS * sigma) and free.score - nothing >= needed:
        if base == believed and np.array_equal(matrix, np.eye(3)):
            scaled = _judge_scales(base, own, free)
            if scaled is not None:
                return scaled
        return _judge_turn(believed, evidence[believed], units)
    state: State = "named" if gain >= needed else "nothing"
    if state == "named" and own.strained(fitted):
        state = "unexplained"
    return AxesVerdict(state, base, matrix, np.eye(3), multiple, gain, sigma, fitted, candidates)


def find_candidates(evidence: Mapping[Base, AxesEvidence]) -> tuple[Model, ...]:
    """Models that explain the readings as well as the best of them, by belief.

    Those are what scores nearly as well, and what is the same but for its name: where both ways
    round of the extrinsics differ by a quarter turn or so, other axes make one of the other, and
    what is left between them is less than extrinsics are known to.
    """
    tried = _tried(evidence)
    if not tried:
        return ()
    score = np.array([one for one, _, _ in tried])
    whole = np.array([evidence[base].camera_R_imu @ matrix for _, base, matrix in tried])
    good = score >= np.max(score) - NEEDED
    kept = good | np.any(same_turns(whole, whole[good]), axis=1)
    return tuple(tried[number][1:] for number in np.flatnonzero(kept))


def same_turns(ones: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    """Which of N and M rotations ``(N, M)``, mirrored ones or not, are the same.

    That is, as far as extrinsics are known.
    """
    cosine = 0.5 * (np.einsum("nij,mij->nm", ones, others) - 1.0)
    alike = np.sign(np.linalg.det(ones))[:, None] == np.sign(np.linalg.det(others))
    return np.asarray(alike & (cosine > np.cos(TURN_TOLERANCE_RAD)), dtype=np.bool_)


def _judge_scales(base: Base, evidence: AxesEvidence, free: RobustFit) -> AxesVerdict | None:
    """Readings whose axes have scales of their own; None where more than that is off."""
    off, sigma = _off(free, np.eye(3), 1.0)
    within = off <= _TOLERANCE + SIGMAS * sigma
    if not np.all(within | np.eye(3, dtype=np.bool_)):
        return None
    sizes = np.where(np.diag(within), 1.0, np.diag(free.values[:9].reshape(3, 3)))
    if np.any(sizes <= 0.0):
        return None
    fitted = evidence.along(np.diag(sizes))
    if evidence.strained(fitted) or fitted.score < free.score - _SCALES_LOSE:
        return None
    gain, same = fitted.score - evidence.nothing().score, np.eye(3)
    scales = float(sizes[0]), float(sizes[1]), float(sizes[2])
    return AxesVerdict("named", base, same, same, 1.0, gain, sigma, fitted, ((base, same),), scales)


def _judge_turn(base: Base, evidence: AxesEvidence, units: tuple[float, ...]) -> AxesVerdict:
    """Whether a rotation explains the readings, or a mirrored one."""
    free = evidence.free(np.zeros((3, 3)), evidence.nothing().sigma)
    for _ in range(_TURNS):
        linear = free.values[:9].reshape(3, 3)
        free = evidence.free(linear, evidence.along(linear).sigma)
    linear, sigma = free.values[:9].reshape(3, 3), free.deviations[:9].reshape(3, 3)
    u, sizes, vt = np.linalg.svd(linear)
    sign = float(np.sign(np.linalg.det(u @ vt)))
    size = float(np.mean(sizes))
    multiple = _named_multiple(size, float(np.max(sigma)), units)
    off = np.abs(linear - size * u @ vt)
    fits = bool(np.all(off <= SCALE_TOLERANCE * size + SIGMAS * sigma))
    fitted = evidence.along(multiple * u @ vt)
    fits &= not evidence.strained(fitted)
    gain = free.score - evidence.nothing().score
    state: State = "named" if fits else "unexplained"
    turn, sigma = sign * (u @ vt), sigma / multiple
    return AxesVerdict(state, base, sign * np.eye(3), turn, multiple, gain, sigma, fitted)


def _tried(evidence: Mapping[Base, AxesEvidence]) -> list[tuple[float, Base, FloatArray]]:
    """Score, base and permutation of every model, by belief."""
    few = {base: one.thinned(_SEARCHED) for base, one in evidence.items()}
    models = [(base, matrix) for matrix in SIGNED_PERMUTATIONS for base in few]
    models.sort(key=lambda model: model[0] == "inverted" and np.trace(model[1]) < 3.0)
    tried = []
    for base, matrix in models:
        own = few[base]
        fit = own.scaled(matrix, own.multiple(matrix))
        if fit.values[0] > 0.0:
            tried.append((fit.score, base, matrix))
    return tried


def _named_multiple(multiple: float, sigma: float, units: tuple[float, ...]) -> float:
    """One, or a unit, where that is as near as scales of sensors are to it."""
    for unit in (1.0, *units):
        if abs(multiple / unit - 1.0) <= SCALE_TOLERANCE + SIGMAS * sigma / multiple:
            return unit
    return multiple


def _off(free: RobustFit, matrix: FloatArray, multiple: float) -> tuple[FloatArray, FloatArray]:
    """How far K is from a multiple of a signed permutation, and the deviation of that."""
    relative = free.values[:9].reshape(3, 3) @ matrix.T / multiple
    sigma = free.deviations[:9].reshape(3, 3) @ np.abs(matrix.T) / multiple
    return np.abs(relative - np.eye(3)), sigma


# How a sensor's readings can stand to what it should read: units, signs, axes, a free turn.
#
# True readings are ``K @ readings``, up to a bias. Where a sensor is as stated K is the identity; a
# unit is a multiple of it, axes in another order a signed permutation, a sensor that was turned a
# rotation.

# K has elements of about one in any unit that somebody may use, degrees and milli-g included.
_LOOSE = 1e3
_SMALLEST = 1e-6
_STRAINED = 4.0  # deviations
_MOST_LAGS = 40


def _signed_permutations() -> tuple[FloatArray, ...]:
    """All 48: the identity, all signs, then by how many axes they leave."""
    signed = [
        np.eye(3)[list(order)] * np.array(signs)
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]

    def far(matrix: FloatArray) -> tuple[bool, bool, float]:
        same = float(np.trace(matrix))
        return same < 3.0, same > -3.0, float(np.sum(np.abs(matrix - np.eye(3))))

    return tuple(sorted(signed, key=far))


SIGNED_PERMUTATIONS = _signed_permutations()


@dataclass(frozen=True, eq=False)
class AxesEvidence:
    """What was measured beside what a sensor read, linear in K.

    Fields:
        target: ``(N, 3)``.
        block: ``(N, 3, 3, 3)``, its derivative by the elements of K.
        extra: ``(N, 3, q)``, its derivative by all else that is unknown, of which the first three
            are a constant.
        prior: of all else.
        camera_R_imu: ``(3, 3)`` that it takes for true. Where this, times K, is the same no
            measurement tells two models apart.
        gravity: size of the first three of all else, and its deviation, where only that is known.
    """

    target: FloatArray
    block: FloatArray
    extra: FloatArray
    prior: Prior
    camera_R_imu: FloatArray
    gravity: tuple[float, float] | None = None

    def __len__(self) -> int:
        return len(self.target)

    def thinned(self, most: int) -> AxesEvidence:
        """At most so many rows, spread evenly."""
        rows = slice(None, None, max(1, -(-len(self) // most)))
        return replace(
            self, target=self.target[rows], block=self.block[rows], extra=self.extra[rows]
        )

    def strained(self, fit: RobustFit) -> bool:
        """Whether unknowns besides K end far from what is known of them."""
        besides = fit.values[-len(self.prior.mean) :]
        off = np.abs(besides - self.prior.mean) > _STRAINED * self.prior.sigma
        return bool(np.any(off)) or self._surprise(fit) > _STRAINED

    @property
    def repeats(self) -> float:
        """How many rows tell as much as one: slow motions tell the same again and again.

        M. Bartlett, Some aspects of the time-correlation problem in regard to tests of
        significance, Journal of the Royal Statistical Society 98(3), 1935.
        """
        own = np.einsum("naii->na", self.block)
        of_target, other = (_autocorrelation(values) for values in (self.target, own))
        return max(1.0, 1.0 + 2.0 * float(np.sum(of_target * other)))

    def multiple(self, matrix: FloatArray) -> float:
        """A multiple of `matrix` to start with, by least squares."""
        column = np.einsum("naij,ij->na", self.block, matrix)[..., None]
        slope = np.concatenate([column, self.extra], axis=-1).reshape(3 * len(self), -1)
        prior = self._with([0.0])
        rows = np.concatenate([slope, np.diag(1.0 / prior.sigma)])
        values = np.append(self.target.ravel(), prior.mean / prior.sigma)
        return max(float(np.linalg.lstsq(rows, values)[0][0]), _SMALLEST)

    def nothing(self) -> RobustFit:
        """Without the sensor: nothing but a constant."""
        constant = np.broadcast_to(np.eye(3), (len(self), 3, 3))
        return fit(self.target, constant, Prior(np.zeros(3), np.full(3, _LOOSE)), np.zeros(3))

    def along(self, matrix: FloatArray) -> RobustFit:
        """With K as given: nothing of it free."""
        explained = np.einsum("naij,ij->na", self.block, matrix)
        left = self.target - explained
        return self._judged(fit(left, self.extra, self.prior, self._start(left)))

    def scaled(self, matrix: FloatArray, start: float) -> RobustFit:
        """With a multiple of `matrix`, which is the first value."""
        column = np.einsum("naij,ij->na", self.block, matrix)[..., None]
        slope = np.concatenate([column, self.extra], axis=-1)
        prior = self._with([0.0])
        first = np.append(start, self._start(self.target - start * column[..., 0]))
        return self._judged(fit(self.target, slope, prior, first))

    def free(self, start: FloatArray, sigma: float) -> RobustFit:
        """With any K, whose elements are the first nine values; the noise's scale is held."""
        columns = self.block.reshape(*self.block.shape[:2], 9)
        slope = np.concatenate([columns, self.extra], axis=-1)
        left = self.target - columns @ start.ravel()
        first = np.append(start.ravel(), self._start(left))
        return self._judged(fit(self.target, slope, self._with(np.zeros(9)), first, sigma))

    def _start(self, left: FloatArray) -> FloatArray:
        """Unknowns besides K to start with: the constant that is left, the others as believed."""
        others = self.extra[..., 3:] @ self.prior.mean[3:]
        return np.append(np.median(left - others, axis=0), self.prior.mean[3:])

    def _surprise(self, fit: RobustFit) -> float:
        """Deviations by which gravity has another size than expected."""
        if self.gravity is None:
            return 0.0
        rows = slice(-len(self.prior.mean), 3 - len(self.prior.mean) or None)
        vector, covariance = fit.values[rows], fit.covariance[rows, rows]
        size = max(float(np.linalg.norm(vector)), _SMALLEST)
        variance = float(vector @ covariance @ vector) / size**2
        return abs(size - self.gravity[0]) / float(np.sqrt(variance + self.gravity[1] ** 2))

    def _judged(self, fit: RobustFit) -> RobustFit:
        return replace(fit, score=fit.score - 0.5 * self._surprise(fit) ** 2)

    def _with(self, mean: FloatArray | list[float]) -> Prior:
        return Prior(
            np.append(mean, self.prior.mean),
            np.append(np.full(len(mean), _LOOSE), self.prior.sigma),
        )


def order_of(matrix: FloatArray) -> str:
    """The order and signs that put readings right, such as ``(y, -x, z)``."""
    names = []
    for row in matrix:
        axis = int(np.argmax(np.abs(row)))
        names.append(("-" if row[axis] < 0.0 else "") + "xyz"[axis])
    return f"({', '.join(names)})"


def _autocorrelation(values: FloatArray) -> FloatArray:
    """Of vectors ``(N, 3)`` about their median, at lags from 1 on, wild ones clipped."""
    values = values - np.median(values, axis=0)
    limit = 3.0 * float(np.median(np.linalg.norm(values, axis=-1)))
    values = np.clip(values, -limit, limit)
    power = float(np.sum(values**2))
    lags = range(1, max(2, min(len(values) // 4, _MOST_LAGS)))
    if power == 0.0:
        return np.zeros(len(lags))
    return np.array([float(np.sum(values[lag:] * values[:-lag])) / power for lag in lags])


# Linear models fitted to vectors with heavy-tailed noise, so that they can be compared.
#
# The noise is Cauchy's in three dimensions (Student's with one degree of freedom): up to three
# quarters of the vectors may be far off before its scale gives way, since one that is infinitely
# far counts with 4/3 of the scale's square where all together must make up one. Source: K. Lange,
# R. Little, J. Taylor, Robust statistical modeling using the t distribution, JASA 84(408), 1989.

_FREEDOM = 1.0
_ITERATIONS = 50
_SETTLED = 0.01  # of the score


@dataclass(frozen=True, eq=False)
class Prior:
    """Means ``(p,)`` and finite deviations ``(p,)`` of the values, known beforehand."""

    mean: FloatArray
    sigma: FloatArray


@dataclass(frozen=True, eq=False)
class RobustFit:
    """What fits best.

    Fields:
        values: ``(p,)``.
        covariance: ``(p, p)``.
        sigma: scale of the noise, an axis.
        score: the logarithm of likelihood times prior at its best, without constants.
    """

    values: FloatArray
    covariance: FloatArray
    sigma: float
    score: float

    @property
    def deviations(self) -> FloatArray:
        """Of the values ``(p,)``."""
        return np.sqrt(np.diag(self.covariance))


def fit(
    target: FloatArray,
    slope: FloatArray,
    prior: Prior,
    start: FloatArray,
    sigma: float | None = None,
) -> RobustFit:
    """RobustFit ``target (N, 3) = slope (N, 3, p) @ values (p,)``, from values to start with.

    It climbs to the nearest summit of the likelihood. What nothing tells stays at its prior. With
    few rows many values leave some rows next to nothing, and the noise's scale would collapse onto
    these: `sigma` holds it where fewer values have put it.
    """
    count = len(target)
    precision, mean = prior.sigma**-2.0, prior.mean
    values = start
    left = target - slope @ values
    square = np.sum(left**2, axis=-1)
    scale = float(np.median(square)) / 3.0 if sigma is None else sigma**2
    scale = max(scale, _SMALLEST**2)
    flat = slope.reshape(3 * count, -1)
    score = -np.inf
    for _ in range(_ITERATIONS):
        weight = (_FREEDOM + 3.0) / (_FREEDOM + square / scale)
        weighted = (weight[:, None, None] * slope).reshape(3 * count, -1)
        matrix = weighted.T @ flat / scale + np.diag(precision)
        vector = weighted.T @ target.ravel() / scale + precision * mean
        values = np.linalg.solve(matrix, vector)
        left = target - slope @ values
        square = np.einsum("na,na->n", left, left)
        if sigma is None:
            scale = max(float(weight @ square) / (3.0 * count), _SMALLEST**2)
        before, score = score, _score(square, scale, precision * (values - mean) ** 2)
        if score - before < _SETTLED:
            break
    # The curvature that Student's likelihood has on average: a share (ν + 3)/(ν + 5).
    known = (_FREEDOM + 3.0) / (_FREEDOM + 5.0) * (flat.T @ flat) / scale + np.diag(precision)
    covariance = np.linalg.inv(known).astype(np.float64)
    return RobustFit(values, covariance, float(np.sqrt(scale)), score)


def _score(square: FloatArray, scale: float, doubts: FloatArray) -> float:
    likelihood = 0.5 * (_FREEDOM + 3.0) * float(np.sum(np.log1p(square / (_FREEDOM * scale))))
    return -likelihood - 1.5 * len(square) * float(np.log(scale)) - 0.5 * float(np.sum(doubts))
