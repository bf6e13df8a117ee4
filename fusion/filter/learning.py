"""Noise learnt from a recording: what makes its poses least surprising, and those held out.

Every pose is predicted by a filter that knows only what came before. Two things are asked of the
noise: that the sequence of innovations is likely, which needs them to be white as well as to have
the size that was stated; and that poses held out for two seconds are predicted as well, and with as
much doubt, as can be. The logarithm of the predictive density is a proper score: neither worse
predictions nor wrong doubts gain by it, where NIS alone is content with large errors of large
deviations (T. Gneiting, A. E. Raftery, Strictly proper scoring rules, prediction, and estimation,
JASA 102, 2007). Vibration that samples alias is white to a filter. Errors that last for some time,
as of scales, axes or g-sensitivity, look small over one interval and large over two seconds; the
densities and walks that are learnt are those that fit all of these spans together.

Half of the recording, in turns of two seconds, is learnt from, the other half judges: what is
learnt replaces what it started from only where it predicts both better there, and the positions
held out not surely worse.

What turns do not contradict stays as near to the start as that allows: a likelihood is flat where
poses of half a degree tell of a gyroscope, and its top lies anywhere (`python -m
tests.bench.fusion.learnt`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.findings import DENSITIES_AND_WALKS, LearntNoise, NoiseScore
from motorcade.fusion.filter.fused import covered
from motorcade.fusion.filter.settings import FilterSettings
from motorcade.fusion.filter.unjudged import fuse_unjudged
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.prediction import surely_above_zero
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import checked_span_ns
from motorcade.tracking.measurements import PoseMeasurements

TURN_NS = 2_000_000_000
"""A turn of learning or of judging, and what is held out at once: as long as cameras are blind in
practice, and as an IMU predicts to centimetres."""
_PERIOD = 4
"""Of so many turns one is held out: in the six seconds between, velocity and tilt are found again,
so that the errors of two spans have little to do with each other."""
_FEWEST_TURNS = 12
"""Six to learn from, six to judge by: below that chance decides."""
_LONGEST_NS = 300_000_000_000
"""Of a longer recording the middle is taken: five minutes know a density to a few in a hundred."""
_DOUBT = float(np.log(10.0))
"""Of each figure beforehand, in its logarithm: data sheets and habits are right to an order of
magnitude. What the recording does not tell stays as it was."""
_STEP, _CLOSE = float(np.log(2.0)), 0.05
"""First steps, and where to stop: five in a hundred of a density change no path."""
_MOST_TRIALS = 80
_GROWTH = 0.02
"""Of an error that is none: errors of a few dozen spans know their own size to a tenth. Chosen with
a look at all five flights."""
_NEAR = float(np.log(1.2))
"""How near to the figure that turns contradict: a fifth of a density moves no deviation by more
than a tenth."""
_LAGS = (1, 2, 4, 8)


def learn_noise(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    *,
    settings: FilterSettings | None = None,
    time_offset_s: float = 0.0,
) -> LearntNoise:
    """Learn the densities and bias walks of an IMU from the poses of one recording.

    The covariances of the poses are taken as they are; poses that the smoother leaves out with the
    noise to start from are not learnt from. It takes some sixty times as long as fusing once for
    each of five patterns of held-out poses; of more than five minutes the middle five are used.

    Args:
        measurements: ``world_T_camera`` with covariances.
        imu: readings that cover them.
        noise: where to start; what the recording does not tell stays near it.
        imu_T_camera: pose of the camera on the IMU.
        settings: as for `fuse`.
        time_offset_s: likewise.

    Raises:
        ValueError: what `fuse` refuses.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.filter import learn_noise
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> from motorcade.ga import Motor
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)
        >>> learn_noise(measured, sensor.stream, ADIS16448, Motor.identity()).summary
        'the noise stays as it was: 24 s of poses are needed to learn it, and there are 3'
    """
    from scipy.optimize import minimize

    used = middle(covered(measurements, imu, checked_span_ns(time_offset_s, "time_offset_s")))
    chosen = settings or FilterSettings()
    stamps = used.trajectory.time_ns
    turns = int((stamps[-1] - stamps[0]) // TURN_NS)
    if turns < _FEWEST_TURNS:
        return LearntNoise(
            noise,
            False,
            f"the noise stays as it was: {_FEWEST_TURNS * TURN_NS // 10**9} s of poses are needed "
            f"to learn it, and there are {used.trajectory.duration_s:.0f}",
        )
    trials = Trials.of(used, imu, noise, imu_T_camera, chosen, time_offset_s)

    def cost(logarithms: FloatArray) -> float:
        likely = _by_turn(*trials.predicted(scaled(noise, logarithms)))
        return float(0.5 * np.sum((logarithms / _DOUBT) ** 2) - likely.sum())

    corners = np.vstack([np.zeros(4), _STEP * np.eye(4)])
    best = minimize(
        cost,
        np.zeros(4),
        method="Nelder-Mead",
        options={
            "initial_simplex": corners,
            "maxfev": _MOST_TRIALS,
            "xatol": _CLOSE,
            "fatol": 0.1,  # of a log likelihood, far below what decides anything
        },
    )
    learnt = _as_far_as_told(lambda tried: trials.predicted(scaled(noise, tried)), best.x)
    candidate = scaled(noise, learnt)
    predicted_before, predicted_after = (trials.predicted(one) for one in (noise, candidate))
    before, after = _score(*predicted_before), _score(*predicted_after)
    factors = tuple(zip(DENSITIES_AND_WALKS, np.exp(learnt).tolist(), strict=True))
    allowed = (1.0 + _GROWTH) ** 2 * _squares(predicted_before[1], 0)
    better = (
        after.log_density > before.log_density
        and after.held_out_log_density >= before.held_out_log_density
        and not surely_above_zero(_squares(predicted_after[1], 0) - allowed)
    )
    return LearntNoise(
        candidate if better else noise, better, _summary(better, factors, before, after), factors,
        before, after,
    )  # fmt: skip


def _by_turn(ahead: Predictions, held: Predictions) -> FloatArray:
    """Log likelihood of each turn to learn from, and of what was held out in it."""
    turns = np.unique(ahead.of(1).turn)
    row = np.searchsorted(turns, ahead.of(1).turn)
    likely = np.bincount(row, ahead.of(1).densities, len(turns))
    # The errors of a span are nearly one draw: it counts as one pose.
    spans = held.of(1)
    at = np.searchsorted(turns, spans.turn)
    count = np.bincount(at, minlength=len(turns))
    both: FloatArray = likely + np.bincount(at, spans.densities, len(turns)) / np.maximum(count, 1)
    return both


def _squares(held: Predictions, parity: int) -> FloatArray:
    """Mean square error of the positions held out in each turn."""
    spans = held.of(parity)
    _, row, count = np.unique(spans.turn, return_inverse=True, return_counts=True)
    square: FloatArray = np.sum(spans.twist[:, 3:] ** 2, axis=1)
    return np.bincount(row, square) / count


def _as_far_as_told(
    predicted: Callable[[FloatArray], tuple[Predictions, Predictions]], logarithms: FloatArray
) -> FloatArray:
    """Each figure as near to where it started as turns do not contradict, one after another.

    They contradict where what was found makes their poses surely more likely, or surely predicts
    the positions held out better. Turns are paired and count as draws: they hold what poses within
    them share. White noise that was found larger stays so, for too little of it is what makes a
    path believe itself.
    """
    best = predicted(logarithms)
    likely, squares = _by_turn(*best), _squares(best[1], 1)
    nearest = logarithms.copy()

    def contradicted(tried: FloatArray) -> bool:
        predictions = predicted(tried)
        return surely_above_zero(likely - _by_turn(*predictions)) or surely_above_zero(
            _squares(predictions[1], 1) - (1.0 + _GROWTH) ** 2 * squares
        )

    for k, name in enumerate(DENSITIES_AND_WALKS):
        if "density" in name and nearest[k] >= 0.0:
            continue
        start, shares = nearest[k], np.array([0.0, 1.0])
        tried = nearest.copy()
        tried[k] = 0.0
        if not contradicted(tried):
            nearest = tried
            continue
        while (shares[1] - shares[0]) * abs(start) > _NEAR:
            tried[k] = start * (1.0 - shares.mean())
            shares[int(contradicted(tried))] = shares.mean()
        nearest[k] = start * (1.0 - shares[0])
    return nearest


def _summary(
    better: bool, factors: tuple[tuple[str, float], ...], before: NoiseScore, after: NoiseScore
) -> str:
    gyro, gyro_walk, accel, accel_walk = (factor for _, factor in factors)
    figures = (
        f"gyroscope {gyro:.2g} times the density and {gyro_walk:.2g} times the walk, "
        f"accelerometer {accel:.2g} and {accel_walk:.2g} times"
    )
    gain = (
        f"log density of the next pose {before.log_density:.3f} to {after.log_density:.3f}, of "
        f"those held out {before.held_out_log_density:.3f} to {after.held_out_log_density:.3f}, "
        f"their error {1e3 * before.held_out_m:.0f} to {1e3 * after.held_out_m:.0f} mm"
    )
    if better:
        return f"the noise was learnt from the recording: {figures}; where it was judged, {gain}"
    return (
        f"the noise stays as it was, for {figures} predicts no better where it was judged: {gain}"
    )


def scaled(noise: ImuNoise, logarithms: FloatArray) -> ImuNoise:
    """Densities and walks times the exponentials of ``(4,)``, in the order of their names."""
    return ImuNoise(
        *(getattr(noise, name) * float(factor)
          for name, factor in zip(DENSITIES_AND_WALKS, np.exp(logarithms), strict=True))
    )  # fmt: skip


def middle(measurements: PoseMeasurements, longest_ns: int = _LONGEST_NS) -> PoseMeasurements:
    """At most so much of a recording, around the pose in its middle, which is never in a gap."""
    stamps = measurements.trajectory.time_ns
    if stamps[-1] - stamps[0] <= longest_ns:
        return measurements
    start = np.clip(stamps[len(stamps) // 2] - longest_ns // 2, stamps[0], stamps[-1] - longest_ns)
    inside = (stamps >= start) & (stamps <= start + longest_ns)
    return PoseMeasurements(measurements.trajectory[inside], measurements.covariance[inside])


@dataclass(frozen=True, eq=False)
class Predictions:
    """Normalised errors ``(M, 6)`` of predicted poses, their log densities, turns and twists."""

    normalised: FloatArray
    densities: FloatArray
    turn: IntArray
    twist: FloatArray

    @classmethod
    def from_twists(cls, twist: FloatArray, spread: FloatArray, turn: IntArray) -> Predictions:
        """Errors ``(M, 6)`` with covariances ``(M, 6, 6)``."""
        root = np.linalg.cholesky(spread)
        normalised = np.linalg.solve(root, twist[..., None])[..., 0]
        size = np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1)
        densities = -0.5 * np.sum(normalised**2, axis=1) - size - 3.0 * np.log(2.0 * np.pi)
        return cls(normalised, densities, turn, twist)

    @classmethod
    def joined(cls, parts: list[Predictions]) -> Predictions:
        """One after another."""
        return cls(*(np.concatenate(arrays) for arrays in zip(*(vars(p).values() for p in parts),
                                                               strict=True)))  # fmt: skip

    def of(self, parity: int) -> Predictions:
        """Those of every other turn: 1 to learn from, 0 to judge by."""
        rows = self.turn % 2 == parity
        return Predictions(*(one[rows] for one in vars(self).values()))

    @property
    def nis_per_dimension(self) -> float:
        """One where noise and covariances fit."""
        return float(np.mean(self.normalised**2))


@dataclass(frozen=True, eq=False)
class Trials:
    """A recording with the ways in which its poses are predicted."""

    measurements: PoseMeasurements
    imu: ImuStream
    imu_T_camera: Motor
    settings: FilterSettings
    time_offset_s: float
    believed: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        measurements: PoseMeasurements,
        imu: ImuStream,
        noise: ImuNoise,
        imu_T_camera: Motor,
        settings: FilterSettings,
        time_offset_s: float,
    ) -> Trials:
        """With the poses that the smoother believes."""
        whole = fuse_unjudged(
            measurements, imu, noise, imu_T_camera, settings=settings,
            time_offset_s=time_offset_s, state_covariances=False,
        )  # fmt: skip
        stamps = measurements.trajectory.time_ns + round(1e9 * time_offset_s)
        believed = np.isin(stamps, whole.trajectory.time_ns[whole.accepted])
        return cls(measurements, imu, imu_T_camera, settings, time_offset_s, believed)

    def predicted(self, noise: ImuNoise) -> tuple[Predictions, Predictions]:
        """The next poses, and those held out."""
        stamps = self.measurements.trajectory.time_ns
        turn = (stamps - stamps[0]) // TURN_NS
        first = np.arange(len(stamps)) == 0
        ahead = self.ahead(noise, ~first & self.believed, np.zeros_like(first), turn)
        held = []
        for phase in range(_PERIOD):
            out = (turn % _PERIOD == phase) & (turn >= _PERIOD - 1)
            if np.any(out & self.believed):
                held.append(self.ahead(noise, out & self.believed, out, turn))
        return ahead, Predictions.joined(held)

    def ahead(
        self, noise: ImuNoise, rows: NDArray[np.bool_], out: NDArray[np.bool_], turn: IntArray
    ) -> Predictions:
        """Poses of some rows by what was measured before, less those held out."""
        path, covariance = self.measurements.trajectory, self.measurements.covariance
        known = PoseMeasurements(path[~out], covariance[~out])
        # Just before it is measured itself: a nanosecond moves nothing.
        stamps = path.time_ns + round(1e9 * self.time_offset_s) - 1
        fused = fuse_unjudged(
            known, self.imu, noise, self.imu_T_camera, stamps[rows], settings=self.settings,
            lag_s=0.0, time_offset_s=self.time_offset_s, state_covariances=False,
        )  # fmt: skip
        at = np.flatnonzero(np.isin(stamps, fused.trajectory.time_ns) & rows)
        twist = fused.trajectory.motors.local(path.motors[at])
        return Predictions.from_twists(twist, fused.covariance + covariance[at], turn[at])


def _score(ahead: Predictions, held: Predictions) -> NoiseScore:
    """Of the turns that judge."""
    judged, spans, every = ahead.of(0), held.of(0), ahead.normalised
    metres, turned = np.linalg.norm(spans.twist[:, 3:], axis=1), spans.twist[:, :3]
    return NoiseScore(
        float(judged.densities.mean()),
        judged.nis_per_dimension,
        tuple(float(np.mean(every[lag:] * every[:-lag])) for lag in _LAGS),
        float(spans.densities.mean()),
        spans.nis_per_dimension,
        float(np.sqrt(np.mean(metres**2))),
        float(np.rad2deg(np.sqrt(np.mean(np.sum(turned**2, axis=1))))),
    )
