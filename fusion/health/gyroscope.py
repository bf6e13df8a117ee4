"""The gyroscope against what the camera turned: unit, sign, axes, extrinsics, delay."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from motorcade.fusion.health.axes import AxesEvidence
from motorcade.fusion.health.models import (
    NEEDED,
    SIGMAS,
    AxesVerdict,
    Base,
    judge_axes,
    judge_stated,
)
from motorcade.fusion.health.regression import Prior
from motorcade.fusion.health.turning import (
    FEWEST_SPANS,
    CameraRates,
    TurnedAngle,
    norm_correlations,
)
from motorcade.fusion.imu.noise import GYRO_BIAS_SIGMA_RAD_S
from motorcade.ga.arrays import FloatArray

RATE_UNITS = {float(np.deg2rad(1.0)): "degrees a second", 1e-3: "thousandths of a radian a second"}
"""What readings must be multiplied by, and the unit that they are then in."""
LAG_TOLERANCE_S = 0.01
"""Exposure and readout put stamps so far off where nobody has measured the offset."""

_MOST_SPANS = 1000
# Nearer than motion changes; what is left of an offset is linear.
_GRID_S = 0.02
_SLOPE_S = 0.0025
# What the linear part follows of an offset: motion bends within longer times.
_LAG_SIGMA_S = 0.05
# Of the gain, that another offset must add before it is believed.
_CLEARER = 0.05
_REFINEMENTS = 3
# Times what is needed elsewhere: 96 models at 800 offsets are tried, e¹¹.
_SEARCHED = 2.0
# Of the gain that sound readings would have: with less the motion is another.
_LEAST_SHARE = 0.25
_MOST_EXPLAINED = 0.9


@dataclass(frozen=True, eq=False)
class RateVerdict:
    """How the gyroscope's readings stand to what the camera turned.

    Fields:
        state: that of `axes`; unrelated, where both turn but not together; unknown, where too
            little turns.
        axes: signs, axes, unit; None where too little was measured.
        lag_s, lag_sigma_s: what is to be added to the poses' stamps, besides the stated offset.
        bias_rad_s: ``(3,)`` of the readings.
        evidence: what `axes` was judged by, readings put right.
        sigma_rad_s: scale of what is left of the camera's rates, an axis.
        read_rad_s, turned_rad_s: scales, an axis, of what was read and what the camera turned,
            noise included; zero where both agree.
    """

    state: Literal["sound", "named", "unexplained", "unrelated", "unknown"]
    axes: AxesVerdict | None
    lag_s: float
    lag_sigma_s: float
    bias_rad_s: FloatArray
    evidence: AxesEvidence | None
    sigma_rad_s: float
    read_rad_s: float = 0.0
    turned_rad_s: float = 0.0

    @property
    def late(self) -> bool:
        """Whether the poses' stamps are off by more than is usual."""
        return abs(self.lag_s) > float(np.hypot(LAG_TOLERANCE_S, SIGMAS * self.lag_sigma_s))

    def allows(self, turn: FloatArray) -> bool:
        """Whether readings that are as stated would be as well explained under a rotation."""
        if self.evidence is None:
            return True
        return self.evidence.along(turn).score > self.evidence.along(np.eye(3)).score - NEEDED

    @property
    def explained(self) -> bool:
        """Whether the readings can be made right."""
        return self.axes is not None and self.state in ("sound", "named")


def judge_rates(
    rates: CameraRates,
    turned: TurnedAngle,
    camera_R_imu: FloatArray,
    offset_s: float,
    search_s: float,
    *,
    known: bool,
) -> RateVerdict:
    """Compare the rates of both.

    Args:
        rates: of the camera.
        turned: the gyroscope's integral.
        camera_R_imu: ``(3, 3)`` from the extrinsics.
        offset_s: what is added to the camera's stamps.
        search_s: how far from that a better offset is looked for.
        known: whether the extrinsics are stated, and may be the wrong way round.
    """
    rates = rates.disjoint(_MOST_SPANS)
    try_here = _Trial(rates, turned, camera_R_imu, known)
    here = try_here.at(offset_s)
    if here is None:
        return RateVerdict("unknown", None, 0.0, 0.0, np.zeros(3), None, 0.0)
    first = judge_stated(here["stated"], NEEDED * here["stated"].repeats)
    if first.state == "sound":
        verdict = _verdict("sound", first, here["stated"], 0.0)
        if not verdict.late:
            return verdict
    chosen_s, evidence, axes = try_here.best(here, offset_s, search_s)
    state = _state(axes, evidence["stated"])
    if state not in ("sound", "named"):
        return _verdict(state, axes, evidence["stated"], 0.0)
    chosen_s, mended = try_here.refined(axes, chosen_s)
    if state == "sound":
        axes = judge_stated(mended)
    return _verdict(state, axes, mended, chosen_s - offset_s)


@dataclass(frozen=True, eq=False)
class _Trial:
    rates: CameraRates
    turned: TurnedAngle
    camera_R_imu: FloatArray
    known: bool

    def at(self, offset_s: float) -> dict[Base, AxesEvidence] | None:
        """Evidence at an offset; None where too little is covered."""
        used = self.rates.inside(self.turned, offset_s, _SLOPE_S)
        if len(used) < FEWEST_SPANS:
            return None
        camera, read = used.beside(self.turned, offset_s)
        _, after = used.beside(self.turned, offset_s + _SLOPE_S)
        _, before = used.beside(self.turned, offset_s - _SLOPE_S)
        return self._evidence(camera, read, (after - before) / (2.0 * _SLOPE_S))

    def _evidence(
        self, camera: FloatArray, read: FloatArray, slope: FloatArray
    ) -> dict[Base, AxesEvidence]:
        block = np.zeros((len(read), 3, 3, 3))
        block[:, np.arange(3), np.arange(3)] = read[:, None, :]
        constant = np.broadcast_to(np.eye(3), block.shape[:3])
        extra = np.concatenate([constant, slope[..., None]], axis=-1)
        prior = Prior(np.zeros(4), np.array([*[GYRO_BIAS_SIGMA_RAD_S] * 3, _LAG_SIGMA_S]))
        bases: dict[Base, FloatArray] = {"stated": self.camera_R_imu}
        if self.known:
            bases["inverted"] = self.camera_R_imu.T
        return {
            base: AxesEvidence(camera @ turn, block, extra, prior, turn)
            for base, turn in bases.items()
        }

    def best(
        self, here: dict[Base, AxesEvidence], offset_s: float, search_s: float
    ) -> tuple[float, dict[Base, AxesEvidence], AxesVerdict]:
        """Offset, evidence and verdict where they fit best.

        That is here, or where the norms of both match, whatever the axes, or where the readings do
        as they are. The simplest wins: an offset alone, before one with other axes.
        """
        best = (offset_s, here, _explained(here))
        steps = np.arange(-round(search_s / _GRID_S), round(search_s / _GRID_S) + 1)
        grid = offset_s + _GRID_S * steps.astype(np.float64)
        for match in (norm_correlations(self.rates, self.turned, grid), self._matches(grid)):
            if not np.any(np.isfinite(match)):
                continue
            there_s = float(grid[int(np.nanargmax(match))])
            there = self.at(there_s)
            if there is None or abs(there_s - offset_s) <= _LAG_SIGMA_S:
                continue
            axes = _explained(there)
            simpler = axes.state == "sound" and best[2].state != "sound"
            clearer = axes.gain > (1.0 + _CLEARER) * best[2].gain + NEEDED
            if clearer or (simpler and axes.gain > best[2].gain - NEEDED):
                best = (there_s, there, axes)
        return best

    def _matches(self, offsets_s: FloatArray) -> FloatArray:
        """How well the readings as they are match the camera's rates ``(M,)``, NaN where too few.

        By the median of what is left, so that wrong poses count no more than others.
        """
        matches = np.full(len(offsets_s), np.nan)
        for number, offset_s in enumerate(offsets_s):
            camera, read = self.rates.beside(self.turned, float(offset_s))
            if len(read) >= FEWEST_SPANS:
                left = camera @ self.camera_R_imu - read
                left -= np.median(left, axis=0)
                matches[number] = -float(np.median(np.sum(left**2, axis=-1)))
        return matches

    def refined(self, axes: AxesVerdict, offset_s: float) -> tuple[float, AxesEvidence]:
        """The offset to a fraction of a sample, and the evidence there of readings put right."""
        mended = self
        if axes.base == "inverted":
            mended = replace(self, camera_R_imu=self.camera_R_imu.T)
        for _ in range(_REFINEMENTS):
            used = self.rates.inside(self.turned, offset_s, _SLOPE_S)
            camera, read = used.beside(self.turned, offset_s)
            _, after = used.beside(self.turned, offset_s + _SLOPE_S)
            _, before = used.beside(self.turned, offset_s - _SLOPE_S)
            slope = (after - before) / (2.0 * _SLOPE_S)
            evidence = mended._evidence(camera, read @ axes.matrix.T, slope @ axes.matrix.T)
            step_s = float(evidence["stated"].along(np.eye(3)).values[3])
            offset_s += float(np.clip(step_s, -_LAG_SIGMA_S, _LAG_SIGMA_S))
        return offset_s, evidence["stated"]


def _explained(evidence: dict[Base, AxesEvidence]) -> AxesVerdict:
    needed = NEEDED * evidence["stated"].repeats
    plain = judge_stated(evidence["stated"], needed)
    if plain.state == "sound":
        return plain
    return judge_axes(evidence, tuple(RATE_UNITS), _SEARCHED * needed)


def _state(
    axes: AxesVerdict, evidence: AxesEvidence
) -> Literal["sound", "named", "unexplained", "unrelated", "unknown"]:
    """What the readings mean: of those that tell nothing, whether sound ones would have told."""
    if axes.state == "sound":
        return "sound"
    expected = _expected_gain(evidence)
    needed = _SEARCHED * NEEDED * evidence.repeats
    if axes.gain < max(needed, _LEAST_SHARE * expected):
        return "unrelated" if expected >= needed else "unknown"
    return "unexplained" if axes.state == "nothing" else axes.state


def _expected_gain(evidence: AxesEvidence) -> float:
    """Logarithm of the odds that readings would have that are what the camera turned."""
    read, turned = _sizes(evidence)
    share = min((read / turned) ** 2, _MOST_EXPLAINED) if turned > 0.0 else _MOST_EXPLAINED
    return -1.5 * len(evidence) * float(np.log1p(-share))


def _sizes(evidence: AxesEvidence) -> tuple[float, float]:
    """Scales, an axis, of what was read and what the camera turned, both about their means."""
    read = evidence.block[:, 0, 0]
    return replace(evidence, target=read).nothing().sigma, evidence.nothing().sigma


def _verdict(
    state: Literal["sound", "named", "unexplained", "unrelated", "unknown"],
    axes: AxesVerdict,
    evidence: AxesEvidence,
    lag_s: float,
) -> RateVerdict:
    values, sigmas = axes.fit.values[-4:], axes.fit.deviations[-4:]
    explained = state in ("sound", "named")
    if state == "sound":
        lag_s += float(values[3])
    return RateVerdict(
        state,
        axes,
        lag_s if explained else 0.0,
        float(sigmas[3]),
        -values[:3],
        evidence,
        axes.fit.sigma,
        *((0.0, 0.0) if explained else _sizes(evidence)),
    )
