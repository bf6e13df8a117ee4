"""The gyroscope against what the camera turned: unit, sign, axes, extrinsics, delay."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.models import (
    NEEDED,
    SCALE_TOLERANCE,
    SIGMAS,
    AxesEvidence,
    AxesVerdict,
    Base,
    Prior,
    judge_axes,
    judge_stated,
)
from motorcade.fusion.imu.noise import GYRO_BIAS_SIGMA_RAD_S
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

RateState = Literal["sound", "named", "unexplained", "unrelated", "unknown"]
RATE_UNITS = {float(np.deg2rad(1.0)): "degrees a second", 1e-3: "thousandths of a radian a second"}
"""What readings must be multiplied by, and the unit that they are then in."""
LAG_TOLERANCE_S = 0.01
"""Exposure and readout put stamps so far off where nobody has measured the offset."""

_MOST_SPANS = 1000
# Nearer than motion changes; what is left of an offset is linear.
_GRID_S = 0.02
_SLOPE_S = 0.0025
_LEAST_RAD_S = 1e-3  # no camera's rates are better
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

    state: RateState
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
    """Compare the rates of both, at an offset and those up to `search_s` from it.

    `known` says that the extrinsics are stated, and may be the wrong way round.
    """
    rates = rates.disjoint(_MOST_SPANS)
    try_here = _Trial(rates, turned, camera_R_imu, known)
    here = try_here.at(offset_s)
    if here is None:
        return RateVerdict("unknown", None, 0.0, 0.0, np.zeros(3), None, 0.0)
    first = _judge_stated(here["stated"], NEEDED * here["stated"].repeats)
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
        axes = _judge_stated(mended)
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
        return self._evidence(used, offset_s, np.eye(3)) if len(used) >= FEWEST_SPANS else None

    def _evidence(
        self, used: CameraRates, offset_s: float, matrix: FloatArray
    ) -> dict[Base, AxesEvidence]:
        """Of rates of the camera that the IMU covers, with readings put right by a matrix."""
        camera, read = used.beside(self.turned, offset_s)
        _, after = used.beside(self.turned, offset_s + _SLOPE_S)
        _, before = used.beside(self.turned, offset_s - _SLOPE_S)
        read, slope = read @ matrix.T, (after - before) / (2.0 * _SLOPE_S) @ matrix.T
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
        """What the readings as they are explain of the camera's rates ``(M,)``, NaN where too few.

        A sum of logarithms, so that wrong poses count little, over all that is covered: of the
        offsets of a motion that repeats itself the one under which both streams overlap most.
        """
        matches = np.full(len(offsets_s), np.nan)
        for number, offset_s in enumerate(offsets_s):
            camera, read = self.rates.beside(self.turned, float(offset_s))
            if len(read) >= FEWEST_SPANS:
                both = np.stack([camera, camera - read @ self.camera_R_imu.T])
                both -= np.median(both, axis=1, keepdims=True)
                whole, left = np.log(np.sum(both**2, axis=-1) + _LEAST_RAD_S**2)
                matches[number] = float(np.sum(whole - left))
        return matches

    def refined(self, axes: AxesVerdict, offset_s: float) -> tuple[float, AxesEvidence]:
        """The offset to a fraction of a sample, and the evidence there of readings put right."""
        mended = self
        if axes.base == "inverted":
            mended = replace(self, camera_R_imu=self.camera_R_imu.T)
        for _ in range(_REFINEMENTS):
            used = self.rates.inside(self.turned, offset_s, _SLOPE_S)
            evidence = mended._evidence(used, offset_s, axes.matrix)
            step_s = float(evidence["stated"].along(np.eye(3)).values[3])
            offset_s += float(np.clip(step_s, -_LAG_SIGMA_S, _LAG_SIGMA_S))
        return offset_s, evidence["stated"]


def _judge_stated(evidence: AxesEvidence, needed: float = NEEDED) -> AxesVerdict:
    """`judge_stated`, and one scale of all axes, which is known better than any element."""
    judged, scaled = judge_stated(evidence, needed), evidence.scaled(np.eye(3), 1.0)
    allowed = SCALE_TOLERANCE + SIGMAS * float(scaled.deviations[0])
    if judged.state == "sound" and abs(float(scaled.values[0]) - 1.0) > allowed:
        return replace(judged, state="unexplained")
    return judged


def _explained(evidence: dict[Base, AxesEvidence]) -> AxesVerdict:
    needed = NEEDED * evidence["stated"].repeats
    plain = _judge_stated(evidence["stated"], needed)
    if plain.state == "sound":
        return plain
    return judge_axes(evidence, tuple(RATE_UNITS), _SEARCHED * needed)


def _state(axes: AxesVerdict, evidence: AxesEvidence) -> RateState:
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
    state: RateState, axes: AxesVerdict, evidence: AxesEvidence, lag_s: float
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


# What a camera and a gyroscope turned over the same short spans of time.

# Rates are means over so much time: longer than noise of single poses, shorter than motion.
_BASELINE_S = 0.15
# From a pose to the next; what turns between poses farther apart is open.
LONGEST_STEP_S = 3.0 * _BASELINE_S
# Three axes, and a tail heavier than the normal distribution's.
_STEADY_SIGMAS = 6.0
# A gyroscope's scale may be off by so much and be sound.
_STEADY_SHARE = 0.1
FEWEST_SPANS = 20
LEAST_OVERLAP_S = 2.0


@dataclass(frozen=True, eq=False)
class CameraRates:
    """Mean rates ``(M, 3)`` in the camera's axes, from `start_ns` to `end_ns` ``(M,)``."""

    start_ns: IntArray
    end_ns: IntArray
    rate_rad_s: FloatArray

    @classmethod
    def of(cls, camera: Trajectory) -> CameraRates:
        """Those of every span of 0.15 s, or from a pose to the next, that starts at a pose."""
        stamps = camera.time_ns
        end = np.searchsorted(stamps, stamps + round(_BASELINE_S * 1e9))
        end = np.maximum(end, np.arange(len(stamps)) + 1)
        start = np.flatnonzero(end < len(stamps))
        end = end[start]
        near = (stamps[end] - stamps[start]) * 1e-9 < LONGEST_STEP_S  # no gap between
        start, end = start[near], end[near]
        rotors = camera.motors.rotor
        # Turns in the middle's axes: half of the turn carries neither forward nor back.
        turns = (rotors[start].inverse() @ rotors[end]).as_rotation_vector()
        seconds = (stamps[end] - stamps[start]) * 1e-9
        return cls(stamps[start], stamps[end], turns / seconds[:, None])

    def __len__(self) -> int:
        return len(self.start_ns)

    def beside(self, turned: TurnedAngle, offset_s: float) -> tuple[FloatArray, FloatArray]:
        """Rates ``(m, 3)`` of camera and IMU over the spans that the IMU covers."""
        used, shift = self.inside(turned, offset_s, 0.0), round(offset_s * 1e9)
        start, end = used.start_ns + shift, used.end_ns + shift
        angle = turned.at(end) - turned.at(start)
        return used.rate_rad_s, angle / ((end - start)[:, None] * 1e-9)

    def inside(self, turned: TurnedAngle, offset_s: float, margin_s: float) -> CameraRates:
        """Those over spans that the IMU covers, with a margin."""
        shift, margin = round(offset_s * 1e9), round(margin_s * 1e9)
        covered = turned.covers(self.start_ns + shift - margin, self.end_ns + shift + margin)
        return self[np.flatnonzero(covered)]

    def disjoint(self, most: int) -> CameraRates:
        """At most so many that do not overlap, spread evenly over the whole."""
        if len(self) < 2:
            return self
        longest = np.median(self.end_ns - self.start_ns)
        step = max(1, round(float(longest / np.median(np.diff(self.start_ns)))))
        step = max(step, -(-len(self) // most))
        return self[np.arange(0, len(self), step)]

    def __getitem__(self, rows: IntArray) -> CameraRates:
        return CameraRates(self.start_ns[rows], self.end_ns[rows], self.rate_rad_s[rows])


class TurnedAngle:
    """The gyroscope's running integral: good for mean rates over short times."""

    def __init__(self, imu: ImuStream) -> None:
        parts = imu.segments()
        self._begin_ns = np.array([one.time_ns[0] for one in parts])
        self._end_ns = np.array([one.time_ns[-1] for one in parts])
        self._angle = RunningIntegral(imu.time_ns, imu.angular_rate_rad_s)

    def covers(self, first_ns: IntArray, last_ns: IntArray) -> NDArray[np.bool_]:
        """Which spans ``(m,)`` lie in one segment of the stream."""
        number = np.searchsorted(self._begin_ns, first_ns, side="right") - 1
        return np.asarray((number >= 0) & (last_ns <= self._end_ns[number]), dtype=np.bool_)

    def at(self, time_ns: IntArray) -> FloatArray:
        """Angles ``(m, 3)`` turned since the start."""
        return self._angle.at(time_ns)


def steady(
    camera: Trajectory,
    turned: TurnedAngle,
    offset_s: float,
    camera_R_read: FloatArray,
    bias_rad_s: FloatArray,
    sigma: float,
) -> NDArray[np.bool_]:
    """Which poses ``(N,)`` turned from one of their neighbours as the gyroscope says.

    `camera_R_read` ``(3, 3)`` takes readings, less their bias, to rates in the camera's axes;
    `sigma` is of the camera's mean rates over spans of 0.15 s, rad/s an axis.
    """
    rotors = camera.motors.rotor
    turns = (rotors[:-1].inverse() @ rotors[1:]).as_rotation_vector()
    read = np.diff(turned.at(camera.time_ns + round(offset_s * 1e9)), axis=0)
    read -= np.diff(camera.time_ns)[:, None] * 1e-9 * bias_rad_s
    read = read @ camera_R_read.T
    apart = np.linalg.norm(turns - read, axis=-1)
    allowed = _STEADY_SIGMAS * sigma * _BASELINE_S + _STEADY_SHARE * np.linalg.norm(read, axis=-1)
    right = np.concatenate([[False], apart < allowed, [False]])
    return np.asarray(right[:-1] | right[1:], dtype=np.bool_)


def norm_correlations(rates: CameraRates, turned: TurnedAngle, offsets_s: FloatArray) -> FloatArray:
    """Correlations ``(M,)`` of how fast both turn, NaN where too little overlaps.

    Of ranks, so that wrong poses count no more than others.
    """
    stamps, places = np.unique(np.stack([rates.start_ns, rates.end_ns]), return_inverse=True)
    first, last = places.reshape(2, -1)
    norms = np.linalg.norm(rates.rate_rad_s, axis=-1)
    ranks, seconds = _ranks(norms), (rates.end_ns - rates.start_ns) * 1e-9
    step_s = float(np.median(np.diff(rates.start_ns))) * 1e-9 if len(rates) > 1 else 0.0

    def correlation(offset_s: float) -> float:
        shift = round(offset_s * 1e9)
        covered = turned.covers(rates.start_ns + shift, rates.end_ns + shift)
        count = np.count_nonzero(covered)
        if count < FEWEST_SPANS or count * step_s < LEAST_OVERLAP_S:
            return np.nan
        angle = turned.at(stamps + shift)
        read = np.linalg.norm(angle[last] - angle[first], axis=-1) / seconds
        if count == len(covered):
            return _correlation(ranks, _ranks(read))
        return _correlation(_ranks(norms[covered]), _ranks(read[covered]))

    return np.array([correlation(float(one)) for one in offsets_s])


def _correlation(first: FloatArray, second: FloatArray) -> float:
    """Of ranks from 0 on, none twice: their mean and spread are known from their number."""
    count = len(first)
    mean, spread = 0.5 * (count - 1), count * (count * count - 1) / 12.0
    return float((first @ second - count * mean * mean) / spread)


def _ranks(values: FloatArray) -> FloatArray:
    ranks = np.empty(len(values))
    ranks[np.argsort(values, kind="stable")] = np.arange(len(values))
    return ranks


# Up to so many samples the sum at each is kept, in six megabytes; of more one in eight, and those
# between are made again where they are asked for.
_ALL_KEPT, _STRIDE = 1 << 18, 8
_BLOCK = 1 << 15  # samples at once


class RunningIntegral:
    """Integral from the first sample on, by trapezoids.

    Args:
        time_ns: ``(N,)`` rising.
        values: ``(N, 3)``; both are held, not copied.
    """

    def __init__(self, time_ns: IntArray, values: FloatArray) -> None:
        self._time_ns, self._values = time_ns, values
        self._stride = stride = 1 if len(time_ns) <= _ALL_KEPT else _STRIDE
        kept = np.zeros(((len(time_ns) - 1) // stride + 1, 3))
        for first in range(0, len(time_ns) - 1, _BLOCK):
            steps = self._steps(np.arange(first, min(first + _BLOCK, len(time_ns) - 1)))
            steps[0] += kept[first // stride]
            sums = np.cumsum(steps, axis=0)[stride - 1 :: stride]
            kept[first // stride + 1 : first // stride + 1 + len(sums)] = sums
        self._kept = kept

    def at(self, time_ns: IntArray) -> FloatArray:
        """The integral at stamps ``(m,)``, between samples by the line between their sums.

        Before the first sample it is zero, after the last as there.
        """
        most = _BLOCK // self._stride
        parts = [self._at(time_ns[k : k + most]) for k in range(0, len(time_ns), most)]
        return np.concatenate(parts) if parts else np.zeros((0, 3))

    def _at(self, time_ns: IntArray) -> FloatArray:
        known = self._time_ns
        wanted = np.clip(time_ns, known[0], known[-1])
        before = np.minimum(np.searchsorted(known, wanted, side="right"), len(known) - 1) - 1
        share = (wanted - known[before]) / (known[before + 1] - known[before])
        if self._stride == 1:
            sums = np.take(self._kept, before, axis=0)
            sums += share[:, None] * (np.take(self._kept, before + 1, axis=0) - sums)
            return sums
        number, left = np.divmod(before, self._stride)
        sums = self._kept[number]
        for k in range(self._stride - 1):  # in the order in which the kept ones were summed
            more = np.flatnonzero(left > k)
            sums[more] += self._steps(number[more] * self._stride + k)
        sums += share[:, None] * self._steps(before)
        return sums

    def _steps(self, rows: IntArray) -> FloatArray:
        """What is added from samples to the next ones ``(m, 3)``."""
        seconds = (self._time_ns[rows + 1] - self._time_ns[rows]) * 1e-9
        return 0.5 * (self._values[rows] + self._values[rows + 1]) * seconds[:, None]
