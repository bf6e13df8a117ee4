"""The accelerometer against the path's accelerations: unit, sign, axes, gravity, extrinsics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from motorcade.fusion.health.axes import AxesEvidence
from motorcade.fusion.health.models import (
    NEEDED,
    SCALE_TOLERANCE,
    SIGMAS,
    AxesVerdict,
    Base,
    Model,
    find_rivals,
    judge_axes,
    judge_stated,
)
from motorcade.fusion.health.pushing import Pushes
from motorcade.fusion.health.regression import Prior
from motorcade.fusion.imu.noise import ACCEL_BIAS_SIGMA_M_S2
from motorcade.fusion.imu.stream import GRAVITY_SHARE
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

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

    state: Literal["sound", "named", "gravity", "unexplained", "unknown"]
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
        named = judged.state == "named" and judged.multiple in (1.0, *FORCE_UNITS)
        if other.state == "sound" and not (named and judged.fit.score > other.fit.score - NEEDED):
            return self._verdict("gravity", other, agrees=of_rates is None)
        if judged.state == "nothing":
            judged = replace(judged, state="unexplained")
        state: Literal["named", "unexplained"] = (
            "named" if judged.state == "named" else "unexplained"
        )
        return self._verdict(state, judged, agrees=False)

    def rivals(self) -> tuple[Model, ...]:
        """Bases and permutations that explain the accelerometer best; none where too few are."""
        return find_rivals(self._bases()) if len(self.pushes) >= _FEWEST else ()

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
        own = bases[of_rates.base]
        turned = replace(own, block=np.einsum("naij,il->nalj", own.block, of_rates.turn))
        permuted = replace(
            turned, block=np.einsum("nalj,jm->nalm", turned.block, of_rates.permutation.T)
        )
        judged = judge_stated(permuted, -NEEDED)
        permutation, turn = of_rates.permutation, of_rates.turn
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
        if self.up:
            gravity = [0.0, 0.0, -self.gravity_m_s2]
            gravity_sigma = [across, across, _SIZE_SIGMA_M_S2]
        else:
            gravity, gravity_sigma = [0.0] * 3, [_ANY_GRAVITY_M_S2] * 3
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

    def _verdict(
        self,
        state: Literal["sound", "named", "gravity", "unexplained"],
        axes: AxesVerdict,
        *,
        agrees: bool,
    ) -> ForceVerdict:
        besides = axes.fit.values[-9:]
        return ForceVerdict(state, axes, besides[:3], besides[3:6], agrees)
