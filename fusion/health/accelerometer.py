"""The accelerometer against the path's accelerations: unit, sign, axes, gravity, extrinsics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.gyroscope import LONGEST_STEP_S, RunningIntegral
from motorcade.fusion.health.models import (
    NEEDED,
    SCALE_TOLERANCE,
    SIGMAS,
    AxesEvidence,
    AxesVerdict,
    Base,
    Model,
    Prior,
    find_candidates,
    judge_axes,
    judge_stated,
)
from motorcade.fusion.imu.noise import ACCEL_BIAS_SIGMA_M_S2
from motorcade.fusion.imu.stream import GRAVITY_SHARE, ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

ForceState = Literal["sound", "named", "gravity", "unexplained", "unknown"]
FORCE_UNITS = {9.80665: "g", 9.80665e-3: "milli-g", 0.3048: "ft/s²", 0.01: "cm/s²"}
"""What readings must be multiplied by, and the unit that they are then in."""
LEAN_RAD = float(np.deg2rad(5.0))
"""A world that was levelled by hand leans less."""

# Windows: three numbers each, for up to eighteen unknowns and a scale that must not collapse.
_FEWEST = 20
_SIZE_SIGMA_M_S2 = 0.2
_LEVER_SIGMA_M = 0.1
_ANY_GRAVITY_M_S2 = 20.0
# As good as none beside what is usual.
_NO_BIAS_M_S2 = 1e-3
# A scale is told where it is known to so much of itself.
_SCALE_SHARE = 0.2


@dataclass(frozen=True, eq=False)
class ForceVerdict:
    """How the accelerometer's readings stand to the path.

    Fields:
        state: that of `axes`; gravity, where another gravity explains them as they are; unknown,
            where too little was measured.
        axes: signs, axes, unit; None where too little was measured.
        gravity_m_s2: ``(3,)`` in the path's world, as found.
        bias_m_s2: ``(3,)`` in the camera's axes.
        agrees: whether the gyroscope's verdict explains these readings as well.
    """

    state: ForceState
    axes: AxesVerdict | None
    gravity_m_s2: FloatArray
    bias_m_s2: FloatArray
    agrees: bool


@dataclass(frozen=True, eq=False)
class ForceTrial:
    """What is compared.

    Fields:
        pushes: the path's accelerations and the readings.
        imu_T_camera: extrinsics.
        known: whether these are stated, and may be the wrong way round.
        gravity_m_s2: its size.
        up: whether the world's z is.
        lean_sigma_rad: of that.
    """

    pushes: Pushes
    imu_T_camera: Motor
    known: bool
    gravity_m_s2: float
    up: bool
    lean_sigma_rad: float

    def judged(self, of_rates: AxesVerdict | None) -> ForceVerdict:
        """The verdict; `of_rates` is the gyroscope's, where it has one."""
        if len(self.pushes) < _FEWEST:
            return ForceVerdict("unknown", None, np.zeros(3), np.zeros(3), agrees=True)
        bases = self._bases()
        stated = bases["stated"]
        first = judge_stated(stated, -NEEDED)
        if first.state == "sound" and (of_rates is None or of_rates.state == "sound"):
            return self._verdict("sound", first, agrees=True)
        shared = self._shared(bases, of_rates)
        if first.state == "sound":
            agrees = shared is not None and shared.fit.score > first.fit.score - NEEDED
            return self._verdict("sound", first, agrees=agrees)
        if shared is not None and shared.state == "sound":
            return self._verdict("named", shared, agrees=True)
        if of_rates is not None:  # which says how the extrinsics are to be read
            bases = {of_rates.base: bases[of_rates.base]}
        judged = judge_axes(bases, tuple(FORCE_UNITS), -NEEDED)
        other = judge_stated(self._with_any_gravity(stated), -NEEDED)
        explained = judged.state == "named"
        named = explained and judged.multiple in (1.0, *FORCE_UNITS)
        if other.state == "sound" and not (named and judged.fit.score > other.fit.score - NEEDED):
            return self._verdict("gravity", other, agrees=of_rates is None)
        if judged.state == "nothing":
            judged = replace(judged, state="unexplained")
        return self._verdict("named" if explained else "unexplained", judged, agrees=False)

    def candidates(self) -> tuple[Model, ...]:
        """Bases and permutations that explain the accelerometer best; none where too few are."""
        return find_candidates(self._bases()) if len(self.pushes) >= _FEWEST else ()

    def camera_R_imu(self) -> dict[Base, FloatArray]:
        """Rotations ``(3, 3)`` of the extrinsics, read either way round."""
        imu_R_camera = self.imu_T_camera.rotor.as_matrix()
        return {"stated": imu_R_camera.T, "inverted": imu_R_camera}

    def position_scale(self) -> float | None:
        """What positions are multiples of metres of; None in metres, or where nothing tells.

        Positions in another unit, or of a camera that knows no scale, show accelerations and
        gravity alike so many times too large. An accelerometer of another scale shows its own
        gravity as a multiple and leaves the world's as it is.
        """
        if len(self.pushes) < _FEWEST:
            return None
        evidence = self._with_any_gravity(self._bases()["stated"])
        start = evidence.multiple(np.eye(3))
        wide = evidence.prior.sigma.copy()
        wide[:3], wide[3:6] = _ANY_GRAVITY_M_S2 * (1.0 + start), wide[3:6] * (1.0 + start)
        wide[6:] *= 1.0 + start
        free = replace(evidence, prior=Prior(evidence.prior.mean, wide))
        fitted = free.scaled(np.eye(3), start)
        scale, variance = float(fitted.values[0]), float(fitted.covariance[0, 0])
        gravity_m_s2 = float(np.linalg.norm(fitted.values[1:4]))
        # Where nothing moves the variance is lost in rounding.
        if scale <= 0.0 or not 0.0 < SIGMAS * np.sqrt(max(variance, 0.0)) < _SCALE_SHARE * scale:
            return None
        off = abs(np.log(scale)) > np.log1p(2.0 * SCALE_TOLERANCE)
        alike = abs(gravity_m_s2 / (scale * self.gravity_m_s2) - 1.0) < GRAVITY_SHARE
        gain = fitted.score - free.nothing().score
        return scale if off and alike and gain > NEEDED else None

    def size_share(self) -> float | None:
        """What the readings show of gravity's size, were they without a bias; None as stated.

        Turned into the path's world they leave gravity beside the path's accelerations. Who keeps
        level cannot tell a scale from a bias along gravity, but that it is either.
        """
        stated = self._with_any_gravity(self._bases()["stated"])
        sigma = stated.prior.sigma.copy()
        sigma[3:6] = _NO_BIAS_M_S2
        unbiased = replace(stated, prior=Prior(stated.prior.mean, sigma)).along(np.eye(3))
        gravity, part = unbiased.values[:3], unbiased.covariance[:3, :3]
        size = float(np.linalg.norm(gravity))
        share = size / self.gravity_m_s2
        deviation = float(np.sqrt(gravity @ part @ gravity)) / max(size * self.gravity_m_s2, 1e-9)
        return share if abs(share - 1.0) > SCALE_TOLERANCE + SIGMAS * deviation else None

    def _shared(
        self, bases: dict[Base, AxesEvidence], of_rates: AxesVerdict | None
    ) -> AxesVerdict | None:
        """How well the gyroscope's axes and extrinsics, but not its unit, explain the readings."""
        if of_rates is None or of_rates.state != "named":
            return None
        own, permutation, turn = bases[of_rates.base], of_rates.permutation, of_rates.turn
        turned = np.einsum("naij,il->nalj", own.block, turn)
        block = np.einsum("nalj,jm->nalm", turned, permutation.T)
        judged = judge_stated(replace(own, block=block), -NEEDED)
        return replace(judged, base=of_rates.base, permutation=permutation, turn=turn)

    def _bases(self) -> dict[Base, AxesEvidence]:
        bases: dict[Base, AxesEvidence] = {"stated": self._evidence(self.imu_T_camera)}
        if self.known:
            bases["inverted"] = self._evidence(self.imu_T_camera.inverse())
        return bases

    def _evidence(self, imu_T_camera: Motor) -> AxesEvidence:
        """Acceleration = mean(world_R_camera camera_R_imu K readings) + gravity - bias - lever."""
        pushes, camera_T_imu = self.pushes, imu_T_camera.inverse()
        camera_R_imu = camera_T_imu.rotor.as_matrix()
        block = np.einsum("kaij,im->kamj", pushes.force, camera_R_imu)
        constant = np.broadcast_to(np.eye(3), pushes.attitude.shape)
        extra = np.concatenate([constant, -pushes.attitude, -pushes.lever], axis=-1)
        across = max(self.lean_sigma_rad, LEAN_RAD / SIGMAS) * self.gravity_m_s2
        lever, sigma = camera_T_imu.translation_m, _LEVER_SIGMA_M
        if not self.known:
            lever, sigma = np.zeros(3), 1.0
        gravity, gravity_sigma = [0.0] * 3, [_ANY_GRAVITY_M_S2] * 3
        if self.up:
            gravity = [0.0, 0.0, -self.gravity_m_s2]
            gravity_sigma = [across, across, _SIZE_SIGMA_M_S2]
        prior = Prior(
            np.array([*gravity, 0.0, 0.0, 0.0, *lever]),
            np.array([*gravity_sigma, *[ACCEL_BIAS_SIGMA_M_S2] * 3, *[sigma] * 3]),
        )
        size = None if self.up else (self.gravity_m_s2, _SIZE_SIGMA_M_S2)
        return AxesEvidence(pushes.acceleration_m_s2, block, extra, prior, camera_R_imu, size)

    def _with_any_gravity(self, evidence: AxesEvidence) -> AxesEvidence:
        mean, sigma = evidence.prior.mean.copy(), evidence.prior.sigma.copy()
        mean[:3], sigma[:3] = 0.0, _ANY_GRAVITY_M_S2
        return replace(evidence, prior=Prior(mean, sigma), gravity=None)

    def _verdict(self, state: ForceState, axes: AxesVerdict, *, agrees: bool) -> ForceVerdict:
        besides = axes.fit.values[-9:]
        return ForceVerdict(state, axes, besides[:3], besides[3:6], agrees)


# Accelerations of a camera's path beside the specific force that an accelerometer read.
#
# The second difference of three positions is the path's acceleration under a hat-shaped window,
# exactly, whatever the motion between them; so is the force when it is turned into the world and
# taken under the same window. Nothing is differentiated but the positions, over half a second.

# From one position to the next: poses good to a centimetre then give accelerations to 0.1 m/s²,
# a hundredth of gravity and a tenth of what a hand does.
_HALF_S = 0.5
_LEAST_STEPS = 3
# Poses farther apart than so many of their usual steps leave the attitude between them open.
_MOST_GAP_STEPS = 3.5
# Parts of a window in which force and attitude are taken for constant.
_PARTS = 24


@dataclass(frozen=True, eq=False)
class Pushes:
    """K windows of the path.

    Fields:
        acceleration_m_s2: ``(K, 3)`` of the camera in the world.
        lever: ``(K, 3, 3)`` the same of a point a metre along each of the camera's axes, less that.
        attitude: ``(K, 3, 3)`` mean of the matrices `world_R_camera`.
        force: ``(K, 3, 3, 3)`` mean of the products of `world_R_camera` (first two) and the
            readings of the accelerometer (last).
    """

    acceleration_m_s2: FloatArray
    lever: FloatArray
    attitude: FloatArray
    force: FloatArray

    def __len__(self) -> int:
        return len(self.acceleration_m_s2)

    @classmethod
    def of(cls, camera: Trajectory, imu: ImuStream, offset_s: float, most: int) -> Pushes:
        """At most so many windows, spread evenly, that the IMU covers and no gap interrupts."""
        rows = _windows(camera)
        shift = round(offset_s * 1e9)
        stamps = camera.time_ns
        rows = rows[_covered(imu, stamps[rows[:, 0]] + shift, stamps[rows[:, 2]] + shift)]
        rows = rows[:: -(-len(rows) // most) or 1]
        first, middle, last = (stamps[column] for column in rows.T)
        before, after = (middle - first) * 1e-9, (last - middle) * 1e-9
        ends = first[:, None] + np.round(
            np.linspace(0.0, 1.0, _PARTS + 1) * (last - first)[:, None]
        ).astype(np.int64)
        middles = (ends[:, :-1] + ends[:, 1:]) // 2
        weight = _hat(middles, first, middle, last)
        turned = camera.motors_at(middles.ravel()).rotor.as_matrix().reshape(*middles.shape, 3, 3)
        force = _mean_force(imu, ends + shift)
        return cls(
            _second_difference(camera.motors.translation_m, rows, before, after),
            _second_difference(camera.motors.rotor.as_matrix(), rows, before, after),
            np.einsum("kb,kbij->kij", weight, turned),
            np.einsum("kb,kbij,kbl->kijl", weight, turned, force, optimize=True),
        )


def _windows(camera: Trajectory) -> IntArray:
    """Rows ``(K, 3)`` of poses at start, middle and end of windows that overlap by half."""
    stamps = camera.time_ns
    if len(stamps) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    steps = np.diff(stamps)
    usual = int(np.median(steps))
    half = max(round(_HALF_S * 1e9), _LEAST_STEPS * usual)
    longest = min(_MOST_GAP_STEPS * usual, LONGEST_STEP_S * 1e9)
    gaps = np.concatenate([[0], np.cumsum(steps > longest)])
    windows, start = [], 0
    while True:
        middle = int(np.searchsorted(stamps, stamps[start] + half))
        if middle >= len(stamps):
            break
        end = int(np.searchsorted(stamps, stamps[middle] + half))
        if end >= len(stamps):
            break
        if gaps[end] == gaps[start]:
            windows.append((start, middle, end))
            start = middle
        else:  # on behind the first gap in it
            start = int(np.searchsorted(gaps, gaps[start], side="right"))
    return np.array(windows, dtype=np.int64).reshape(-1, 3)


def _covered(imu: ImuStream, first_ns: IntArray, last_ns: IntArray) -> NDArray[np.intp]:
    parts = imu.segments()
    begin = np.array([one.time_ns[0] for one in parts])
    end = np.array([one.time_ns[-1] for one in parts])
    number = np.searchsorted(begin, first_ns, side="right") - 1
    return np.flatnonzero((number >= 0) & (last_ns <= end[number]))


def _second_difference(
    values: FloatArray, rows: IntArray, before: FloatArray, after: FloatArray
) -> FloatArray:
    """Of values ``(N, ...)``, divided so that it is the mean of the second derivative."""
    shape = (-1,) + (1,) * (values.ndim - 1)
    first, two, three = (values[column] for column in rows.T)
    before, after = before.reshape(shape), after.reshape(shape)
    slope: FloatArray = (three - two) / after - (two - first) / before
    return slope / (0.5 * (before + after))


def _hat(at: IntArray, first: IntArray, middle: IntArray, last: IntArray) -> FloatArray:
    """Weights ``(K, parts)`` of a hat from first to last whose tip is at the middle."""
    first, middle, last = first[:, None], middle[:, None], last[:, None]
    rising = (at - first) / (middle - first)
    falling = (last - at) / (last - middle)
    weight = np.minimum(rising, falling)
    return np.asarray(weight / np.sum(weight, axis=1, keepdims=True))


def _mean_force(imu: ImuStream, ends_ns: IntArray) -> FloatArray:
    """Means ``(K, parts, 3)`` of the force between stamps ``(K, parts + 1)``."""
    at = RunningIntegral(imu.time_ns, imu.specific_force_m_s2).at(ends_ns.ravel())
    moved = np.diff(at.reshape(*ends_ns.shape, 3), axis=1)
    return moved / (np.diff(ends_ns, axis=1) * 1e-9)[..., None]
