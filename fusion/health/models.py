"""The models that a sensor's readings are tested against, and which of them explains these best.

In order of belief: as stated; one fault, which is extrinsics that were given the wrong way round,
or signs and axes, the simplest first; both at once; any rotation. Each may come with a unit. What
has a mend of its own so stands before what explains as much by accident, and a model only counts
where the motion tells it from nothing. Those that explain as much are kept as rivals: the other
sensor may tell them apart (see `joint`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.axes import SIGNED_PERMUTATIONS, AxesEvidence
from motorcade.fusion.health.regression import RobustFit
from motorcade.ga.arrays import FloatArray

Base = Literal["stated", "inverted"]
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
        blurred: axes x, y, z of the readings of which the motion tells little.
        fit: of what was chosen, with the unknowns besides K last.
        rivals: models without a turn that explain the readings as well, this one among them, by
            belief; none where that was not asked, or a turn explains them.
        scales: of the axes of the readings, where one of them differs from the others.
    """

    state: Literal["sound", "named", "unexplained", "nothing"]
    base: Base
    permutation: FloatArray
    turn: FloatArray
    multiple: float
    gain: float
    blurred: str
    fit: RobustFit
    rivals: tuple[Model, ...] = ()
    scales: tuple[float, float, float] = (1.0, 1.0, 1.0)

    @property
    def turn_rad(self) -> float:
        """Angle of the turn."""
        return float(np.arccos(np.clip(0.5 * (np.trace(self.turn) - 1.0), -1.0, 1.0)))

    @property
    def matrix(self) -> FloatArray:
        """K ``(3, 3)``: what makes true readings."""
        matrix: FloatArray = self.multiple * self.turn @ self.permutation * np.array(self.scales)
        return matrix


def judge_stated(evidence: AxesEvidence, needed: float = NEEDED) -> AxesVerdict:
    """Whether readings are as stated: the state is then sound, and unexplained where not.

    Args:
        evidence: with the extrinsics as stated.
        needed: of the gain over nothing.
    """
    nothing, same = evidence.nothing(), evidence.along(np.eye(3))
    gain = same.score - nothing.score
    free = evidence.free(np.eye(3), same.sigma)
    off, sigma = _off(free, np.eye(3), 1.0)
    sound = gain >= needed and bool(np.all(off <= _TOLERANCE + SIGMAS * sigma))
    sound = sound and not evidence.strained(same)
    state: Literal["sound", "unexplained"] = "sound" if sound else "unexplained"
    identity = np.eye(3)
    return AxesVerdict(state, "stated", identity, identity, 1.0, gain, _blurred(sigma), same)


def judge_axes(
    evidence: Mapping[Base, AxesEvidence], units: tuple[float, ...], needed: float = NEEDED
) -> AxesVerdict:
    """Which model explains readings that are not as stated.

    Args:
        evidence: by which way round the extrinsics are read, the more believed first.
        units: multiples that have a name.
        needed: of the gain over nothing.
    """
    believed = next(iter(evidence))
    rivals = find_rivals(evidence)
    if not rivals:
        return replace(judge_stated(evidence[believed], needed), state="nothing")
    base, matrix = rivals[0]
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
    state: Literal["named", "unexplained", "nothing"] = "named" if gain >= needed else "nothing"
    if state == "named" and own.strained(fitted):
        state = "unexplained"
    same, blurred = np.eye(3), _blurred(sigma)
    return AxesVerdict(state, base, matrix, same, multiple, gain, blurred, fitted, rivals)


def find_rivals(evidence: Mapping[Base, AxesEvidence]) -> tuple[Model, ...]:
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
    return AxesVerdict(
        "named", base, same, same, 1.0, gain, _blurred(sigma), fitted, ((base, same),), scales
    )


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
    state: Literal["named", "unexplained"] = "named" if fits else "unexplained"
    turn, blurred = sign * (u @ vt), _blurred(sigma / multiple)
    return AxesVerdict(state, base, sign * np.eye(3), turn, multiple, gain, blurred, fitted)


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


def _blurred(sigma: FloatArray) -> str:
    worst = sigma.max(axis=0)
    return "".join(axis for axis, one in zip("xyz", worst, strict=True) if one > _BLURRED)
