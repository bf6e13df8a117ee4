"""An IMU simulated along a path: what the sensor would have read, with its noise and its faults.

The simulated sensor rides on a path in continuous time, see `ContinuousPath`.

Readings pass through the sensor's faults in the order of the hardware: the axes mix and scale the
truth, biases and noise are added, the amplifier saturates, the converter rounds, and the wire loses
samples.

Angular rate and acceleration are exact derivatives of the path, so there is no error of
differencing. The world has z up; an accelerometer at rest reads +g upward.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.imu.continuous_path import ContinuousPath
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive, frozen
from motorcade.ga.motion import SplineSample, sampled_motion
from motorcade.ga.stamps import check_count, checked_rate, checked_span_ns


@dataclass(frozen=True, eq=False)
class ImuFaults:
    """What is wrong with an IMU besides its noise; nothing by default.

    Scale and misalignment form Kalibr's lower triangular matrix, by which the true vector is
    multiplied: scale ``(x, y, z)`` on the diagonal, misalignment ``(yx, zx, zy)`` below it, the
    small angles by which the y axis leans to x and the z axis to x and y
    (github.com/ethz-asl/kalibr/wiki/Multi-IMU-and-IMU-intrinsic-calibration).

    Args:
        gyro_scale, accel_scale: ``(3,)`` or one for all axes, above 0; 1 is right.
        gyro_misalignment_rad, accel_misalignment_rad: ``(3,)``.
        gyro_bias_rad_s, accel_bias_m_s2: ``(3,)``, the biases that the walks start from.
        gyro_range_rad_s, accel_range_m_s2: readings end at ± this; infinite by default.
        gyro_step_rad_s, accel_step_m_s2: readings are multiples of this; 0 for none.
        dropped_share: probability, in [0, 1), that a sample is lost, each for itself.

    Raises:
        ValueError: a number outside its bounds, named by its field.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)

        >>> from motorcade.fusion.imu import ImuFaults
        >>> faults = ImuFaults(gyro_range_rad_s=1.0, dropped_share=0.1)
        >>> faulty = simulate_imu(path, 100.0, ADIS16448, rng, faults=faults)
        >>> bool(np.abs(faulty.stream.angular_rate_rad_s).max() <= 1.0), len(faulty.stream) < 301
        (True, True)
    """

    gyro_scale: ArrayLike = 1.0
    accel_scale: ArrayLike = 1.0
    gyro_misalignment_rad: ArrayLike = 0.0
    accel_misalignment_rad: ArrayLike = 0.0
    gyro_bias_rad_s: ArrayLike = 0.0
    accel_bias_m_s2: ArrayLike = 0.0
    gyro_range_rad_s: float = np.inf
    accel_range_m_s2: float = np.inf
    gyro_step_rad_s: float = 0.0
    accel_step_m_s2: float = 0.0
    dropped_share: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            name = f"ImuFaults.{field.name}"
            value = getattr(self, field.name)
            if field.type == "float":
                object.__setattr__(self, field.name, _checked_number(float(value), name))
            else:
                object.__setattr__(self, field.name, _checked_axes(value, name))

    @property
    def gyro_matrix(self) -> FloatArray:
        """``(3, 3)`` from the true angular rate to that read, before bias and noise."""
        return _lower_triangular(self.gyro_scale, self.gyro_misalignment_rad)

    @property
    def accel_matrix(self) -> FloatArray:
        """``(3, 3)`` from the true specific force to that read, before bias and noise."""
        return _lower_triangular(self.accel_scale, self.accel_misalignment_rad)

    def converted_rate(self, rate_rad_s: FloatArray) -> FloatArray:
        """Angular rates ``(*, 3)`` as they come out of the converter: cut off, then rounded."""
        return _converted(rate_rad_s, self.gyro_range_rad_s, self.gyro_step_rad_s)

    def converted_force(self, force_m_s2: FloatArray) -> FloatArray:
        """Specific forces ``(*, 3)`` as they come out of the converter: cut off, then rounded."""
        return _converted(force_m_s2, self.accel_range_m_s2, self.accel_step_m_s2)


def _checked_axes(value: ArrayLike, name: str) -> FloatArray:
    given = np.asarray(value, dtype=np.float64)
    if given.shape not in ((), (3,)):
        raise ValueError(f"{name}: expected one number or three, got shape {given.shape}")
    axes: FloatArray = checked_floats(np.broadcast_to(given, (3,)).copy(), name, (3,))
    if name.endswith("_scale") and np.any(axes <= 0.0):
        raise ValueError(f"{name}: expected numbers above 0, got {axes.tolist()}")
    return frozen(axes)


def _checked_number(value: float, name: str) -> float:
    if name.endswith("dropped_share"):
        if not 0.0 <= value < 1.0:
            raise ValueError(f"{name}: expected a share in [0, 1), got {value}")
    elif "_range_" in name:
        if not value > 0.0:
            raise ValueError(f"{name}: expected a number above 0, got {value}")
    elif not 0.0 <= value < np.inf:
        raise ValueError(f"{name}: expected a number of at least 0, got {value}")
    return value


def _lower_triangular(scale: ArrayLike, misalignment_rad: ArrayLike) -> FloatArray:
    matrix: FloatArray = np.diag(np.asarray(scale, dtype=np.float64))
    matrix[[1, 2, 2], [0, 0, 1]] = misalignment_rad
    return matrix


def _converted(values: FloatArray, limit: float, step: float) -> FloatArray:
    if step > 0.0:
        # The last step that the range holds, so that saturated readings are multiples too.
        limit = np.floor(limit / step) * step if np.isfinite(limit) else limit
        values = np.round(values / step) * step
    cut: FloatArray = np.clip(values, -limit, limit)
    return cut


PERFECT = ImuFaults()
"""A sensor without faults; it may still be noisy."""


@dataclass(frozen=True, eq=False)
class SimulatedImu:
    """A simulated stream and its ground truth, sample by sample ``(N,)``.

    Fields:
        stream: what the sensor reads, at stamps of its own clock.
        gyro_bias_rad_s, accel_bias_m_s2: the true biases ``(N, 3)``.
        path: the true poses ``world_T_imu``, at stamps of the path's clock: those of the stream
            less its time offset.
        velocity_m_s: the true velocity in the world ``(N, 3)``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)

        >>> sensor.stream
        ImuStream(301 samples, 100.0 Hz, 3.000 s)
        >>> sensor.path
        Trajectory(world_T_imu, 301 poses, 3.000 s)
    """

    stream: ImuStream
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    path: Trajectory
    velocity_m_s: FloatArray


def simulate_imu(
    world_T_imu: Trajectory | ContinuousPath,
    rate_hz: float,
    noise: ImuNoise | None,
    rng: np.random.Generator,
    gravity_m_s2: float = 9.81,
    knot_spacing_s: float = 0.1,
    *,
    faults: ImuFaults = PERFECT,
    imu_T_child: Motor | None = None,
    time_offset_s: float = 0.0,
) -> SimulatedImu:
    """Simulate an IMU that moves along `world_T_imu`, or is bolted to what does.

    Args:
        world_T_imu: poses, two or more, or a path; world z up.
        rate_hz: samples a second, from the first stamp to the last; none where gaps split the
            path, see `ContinuousPath.through`.
        noise: white noise σ/√Δt and bias walks σ_b√Δt (Kalibr); None for none.
        rng: source of the noise; the same seed gives the same bytes.
        gravity_m_s2: size of gravity, which pulls along -z of the world.
        knot_spacing_s: knots of the spline through poses, see `ContinuousPath.through`.
        faults: scale, misalignment, first biases, range, steps and losses.
        imu_T_child: where the poses are those of a camera or a vehicle: that frame in the IMU's
            axes (``imu_T_camera``); None where they are the IMU's own.
        time_offset_s: what the IMU's clock shows more than that of the poses, Kalibr's
            ``t_imu = t_camera + offset``; rounded to nanoseconds.

    Raises:
        ValueError: a rate, gravity or spacing that is not positive, an offset of more than thirty
            years, a rate or losses that leave fewer than two samples or make more than ten
            million, a single pose, or motion too fast for the knots.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)

        >>> sensor.stream
        ImuStream(301 samples, 100.0 Hz, 3.000 s)
    """
    checked_rate(checked_positive(rate_hz, "rate_hz"), "rate_hz")
    checked_positive(gravity_m_s2, "gravity_m_s2")
    path = world_T_imu
    if isinstance(path, Trajectory):
        path = ContinuousPath.through(path, knot_spacing_s)
    if imu_T_child is not None:
        path = path.seen_from(imu_T_child)
    true_ns = _stamps(path, rate_hz)
    offset_ns = checked_span_ns(time_offset_s, "time_offset_s")
    seconds = np.minimum((true_ns - path.start_ns) * 1e-9, path.duration_s)
    exact = sampled_motion(path.twists(seconds))
    gyro_bias, accel_bias, white = _errors(noise, 1.0 / rate_hz, true_ns, faults, rng)
    rate = exact.body_angular_rate_rad_s @ faults.gyro_matrix.T + gyro_bias + white[0]
    force = specific_force_m_s2(exact, gravity_m_s2) @ faults.accel_matrix.T + accel_bias + white[1]
    kept = _kept(len(true_ns), faults.dropped_share, rng)
    stream = ImuStream(
        true_ns[kept] + offset_ns,
        faults.converted_rate(rate[kept]),
        faults.converted_force(force[kept]),
    )
    truth = Trajectory(true_ns[kept], exact.pose[kept], path.parent, path.child)
    return SimulatedImu(
        stream, gyro_bias[kept], accel_bias[kept], truth, exact.world_velocity_m_s[kept]
    )


def specific_force_m_s2(motion: SplineSample, gravity_m_s2: float) -> FloatArray:
    """What a perfect accelerometer reads ``(*, 3)``: acceleration minus gravity, in its axes."""
    up = np.array([0.0, 0.0, gravity_m_s2])
    return motion.pose.rotor.inverse().apply(motion.world_acceleration_m_s2 + up)


def _stamps(path: ContinuousPath, rate_hz: float) -> IntArray:
    """Even stamps in every stretch, from its start on."""
    count = sum((last - first) * rate_hz for first, last in path.stretches_s)
    check_count(count, f"rate_hz of {rate_hz:g}")
    made = np.concatenate([_even(path, *span, rate_hz) for span in path.stretches_s])
    if len(made) < 2:
        raise ValueError(
            f"rate_hz: expected two samples or more within {path.duration_s} s, got {rate_hz} Hz"
        )
    return made


def _even(path: ContinuousPath, first_s: float, last_s: float, rate_hz: float) -> IntArray:
    count = int(np.floor((last_s - first_s) * rate_hz + 1e-6)) + 1
    offsets = np.round(np.arange(count) * (1e9 / rate_hz)).astype(np.int64)
    start_ns = path.start_ns + round(first_s * 1e9)
    stamps: IntArray = start_ns + np.minimum(offsets, round((last_s - first_s) * 1e9))
    return stamps


def _errors(
    noise: ImuNoise | None,
    step_s: float,
    time_ns: IntArray,
    faults: ImuFaults,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Biases of both sensors ``(N, 3)`` and their white noise ``(2, N, 3)``."""
    count = len(time_ns)
    gyro, accel = (
        np.tile(np.asarray(first, dtype=np.float64), (count, 1))
        for first in (faults.gyro_bias_rad_s, faults.accel_bias_m_s2)
    )
    if noise is None:
        return gyro, accel, np.zeros((2, count, 3))
    gyro += _walk(noise.gyro_walk_rad_s2_rthz, step_s, time_ns, rng)
    accel += _walk(noise.accel_walk_m_s3_rthz, step_s, time_ns, rng)
    white = rng.standard_normal((2, count, 3)) / np.sqrt(step_s)
    white[0] *= noise.gyro_density_rad_s_rthz
    white[1] *= noise.accel_density_m_s2_rthz
    return gyro, accel, white


def _walk(density: float, step_s: float, time_ns: IntArray, rng: np.random.Generator) -> FloatArray:
    """Random walks ``(N, 3)`` from zero; through a gap they go on for as long as it lasts."""
    steps = density * np.sqrt(step_s) * rng.standard_normal((len(time_ns) - 1, 3))
    longer = np.diff(time_ns) * (1e-9 / step_s)
    gaps = longer > 1.5
    steps[gaps] *= np.sqrt(longer[gaps])[:, None]
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _kept(count: int, dropped_share: float, rng: np.random.Generator) -> IntArray:
    """Indices of the samples that arrive."""
    if dropped_share == 0.0:
        return np.arange(count)
    kept = np.flatnonzero(rng.random(count) >= dropped_share)
    if kept.size < 2:
        raise ValueError(
            f"ImuFaults.dropped_share: expected two samples or more to be left of {count}, "
            f"got a share of {dropped_share}"
        )
    return kept
