"""`fit_noise`: a glance at whether a recording contradicts its IMU's noise, and what fits it."""

from __future__ import annotations

import logging

import numpy as np

from motorcade.fusion.filter.fused import covered
from motorcade.fusion.filter.learning import TURN_NS, Predictions, Trials, middle, scaled
from motorcade.fusion.filter.settings import FilterSettings
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.ga.stamps import checked_span_ns
from motorcade.tracking.measurements import PoseMeasurements

log = logging.getLogger("motorcade.fuse")

_GLANCE_NS, _FEWEST_POSES, _APART_NS = 30_000_000_000, 60, 200_000_000
_BESIDE_NS, _SAMPLE_NS = 1_000_000_000, 20_000_000
"""What `fit_noise` looks at: the middle of a recording, and how many poses of it there must be; how
much of the stream before and behind these, and how far apart its samples may be, as those of a slow
IMU are."""
_TOLD = 1.92
"""By so much a log likelihood must tell one density from another, half of what chi-squared of one
number reaches once in twenty; else the larger is taken, for too little noise is what makes a path
believe itself."""
_MOST = np.log(64.0) + 1e-9
"""No sensor shakes more beyond its data sheet; what needs more is another fault."""
_COLOURED = 4.0
"""Deviations by which innovations must be correlated to be called so."""
_GLANCE_STEPS = (
    (np.log(4.0), ((1.0, 1.0), (-1.0, -1.0))),
    *((np.log(n), ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))) for n in (2.0, 2.0**0.5)),
)
"""Steps of both densities, then of each; the last, of two in a variance, only refine others."""


def fit_noise(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    *,
    settings: FilterSettings | None = None,
    time_offset_s: float = 0.0,
) -> ImuNoise:
    """The noise as stated, or with densities that fit where innovations are not white.

    A filter that believes its IMU too much lags behind: errors of its predictions keep their sign
    for some time (R. K. Mehra, On the identification of variances and adaptive Kalman filtering,
    IEEE TAC 15(2), 1970). Only then larger ones are looked for, by the likelihood of poses 0.2 s
    apart in half a minute from the middle of the recording (of a stream that gaps split, of the
    segment with most poses), every other turn of two seconds; the others must agree. Densities are
    never lowered, so that poses whose noise is stated too small change nothing; nor is anything
    fitted where extrinsics or offset are to be estimated, whose errors look alike. It takes as long
    as fusing a minute or two; `learn_noise` finds walks too.

    Args:
        measurements: ``world_T_camera`` with covariances.
        imu: readings that cover them.
        noise: as stated; its walks stay.
        imu_T_camera: pose of the camera on the IMU.
        settings: as for `fuse`.
        time_offset_s: likewise.

    Raises:
        ValueError: what `fuse` refuses.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.filter.fitting import fit_noise
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.ga import Motor
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(handheld(rng), 20.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448.scaled(10.0), rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)
        >>> fitted = fit_noise(measured, sensor.stream, ADIS16448, Motor.identity())
        >>> factor = fitted.accel_density_m_s2_rthz / ADIS16448.accel_density_m_s2_rthz
        >>> bool(5.0 < factor < 40.0)  # the larger of what poses do not tell apart
        True
    """
    chosen = settings or FilterSettings()
    shift_ns = checked_span_ns(time_offset_s, "time_offset_s")
    imu = _most_measured(covered(measurements, imu, shift_ns), imu, shift_ns)
    used = _thinned(middle(covered(measurements, imu, shift_ns), _GLANCE_NS))
    stamps = used.trajectory.time_ns
    if len(stamps) < _FEWEST_POSES or any(chosen.known_sigmas[1:]):
        return noise
    around = stamps[[0, -1]] + shift_ns + np.array([-_BESIDE_NS, _BESIDE_NS])
    imu = _averaged(imu.around(np.clip(around, imu.time_ns[0], imu.time_ns[-1])))
    rows = np.arange(len(stamps)) > 0
    turn = (stamps - stamps[0]) // TURN_NS
    trials = Trials(used, imu, imu_T_camera, chosen, time_offset_s, rows)
    limit = chosen.gate_limit(6)

    def predicted(logarithms: FloatArray) -> Predictions:
        densities = np.array([logarithms[0], 0.0, logarithms[1], 0.0])
        return trials.ahead(scaled(noise, densities), rows, ~rows & False, turn)

    def likely(predictions: Predictions, parity: int) -> float:
        """One gross error counts as much as the gate lets through."""
        half = predictions.of(parity)
        beyond = np.maximum(0.0, np.sum(half.normalised**2, axis=1) - limit)
        return float(np.sum(half.densities + 0.5 * beyond))

    best = np.zeros(2)
    first = at = predicted(best)
    size = np.clip(first.normalised, -4.0, 4.0)
    if np.mean(size[1:] * size[:-1]) * np.sqrt(size[1:].size) < _COLOURED:
        return noise
    for step, ways in _GLANCE_STEPS:
        for way in step * np.array(ways):
            allowed_loss = _TOLD * np.sign(way.sum())
            while np.all((best + way >= 0) & (best + way <= _MOST) & (step > 0.5 or any(best))):
                tried = predicted(best + way)
                if likely(tried, 1) <= likely(at, 1) - allowed_loss:
                    break
                best, at = best + way, tried
    if likely(at, 0) <= likely(first, 0):
        return noise
    gyro, accel = np.exp(best)
    log.info(
        "the IMU's noise as stated contradicts the poses: %.2g times the gyroscope's density and "
        "%.2g times the accelerometer's are used",
        gyro,
        accel,
    )
    return scaled(noise, np.array([best[0], 0.0, best[1], 0.0]))


def _most_measured(measurements: PoseMeasurements, imu: ImuStream, shift_ns: int) -> ImuStream:
    """The segment between gaps of the stream within which most poses were measured."""
    stamps = measurements.trajectory.time_ns + shift_ns
    parts = imu.segments()
    counts = [np.ptp(np.searchsorted(stamps, part.time_ns[[0, -1]])) for part in parts]
    return parts[int(np.argmax(counts))] if any(counts) else imu


def _averaged(imu: ImuStream) -> ImuStream:
    """Means of as many samples as lie within the interval; white noise keeps its density."""
    size = max(1, int(_SAMPLE_NS // np.median(np.diff(imu.time_ns))))
    count = len(imu.time_ns) // size * size
    since = (imu.time_ns[:count] - imu.time_ns[0]).reshape(-1, size)
    rate, force = (
        readings[:count].reshape(-1, size, 3).mean(axis=1)
        for readings in (imu.angular_rate_rad_s, imu.specific_force_m_s2)
    )
    return ImuStream(imu.time_ns[0] + since.mean(axis=1).astype(np.int64), rate, force)


def _thinned(measurements: PoseMeasurements) -> PoseMeasurements:
    """Poses at least so far apart that what lasts in an IMU's error is seen beside their noise."""
    stamps = measurements.trajectory.time_ns
    _, first = np.unique((stamps - stamps[0]) // _APART_NS, return_index=True)
    return PoseMeasurements(measurements.trajectory[first], measurements.covariance[first])
