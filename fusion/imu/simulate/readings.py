"""An IMU simulated along a path: what the sensor would have read, with its noise and its faults.

Angular rate and acceleration are exact derivatives of the path, so there is no error of
differencing. The world has z up; an accelerometer at rest reads +g upward.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.simulate.path import ContinuousPath
from motorcade.fusion.imu.simulate.sensor import PERFECT, ImuFaults
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.ga.motion import SplineSample, sampled_motion

__all__ = ["SimulatedImu", "simulate_imu"]


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
        rate_hz: samples a second, from the first stamp to the last.
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
        ValueError: a rate, gravity or spacing that is not positive, an offset that is not finite,
            a rate or losses that leave fewer than two samples, a single pose, or motion too fast
            for the knots.

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
    _check(rate_hz, gravity_m_s2, time_offset_s)
    path = world_T_imu
    if isinstance(path, Trajectory):
        path = ContinuousPath.through(path, knot_spacing_s)
    if imu_T_child is not None:
        path = path.seen_from(imu_T_child)
    true_ns = _stamps(path, rate_hz)
    seconds = np.minimum((true_ns - path.start_ns) * 1e-9, path.duration_s)
    exact = sampled_motion(path.twists(seconds))
    gyro_bias, accel_bias, white = _errors(noise, 1.0 / rate_hz, len(true_ns), faults, rng)
    rate = exact.body_angular_rate_rad_s @ faults.gyro_matrix.T + gyro_bias + white[0]
    force = specific_force_m_s2(exact, gravity_m_s2) @ faults.accel_matrix.T + accel_bias + white[1]
    kept = _kept(len(true_ns), faults.dropped_share, rng)
    stream = ImuStream(
        true_ns[kept] + round(time_offset_s * 1e9),
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


def _check(rate_hz: float, gravity_m_s2: float, time_offset_s: float) -> None:
    checked_positive(rate_hz, "rate_hz")
    checked_positive(gravity_m_s2, "gravity_m_s2")
    if not np.isfinite(time_offset_s):
        raise ValueError(f"time_offset_s: expected a finite number, got {time_offset_s}")


def _stamps(path: ContinuousPath, rate_hz: float) -> IntArray:
    count = int(np.floor(path.duration_s * rate_hz + 1e-6)) + 1
    if count < 2:
        raise ValueError(
            f"rate_hz: expected two samples or more within {path.duration_s} s, got {rate_hz} Hz"
        )
    offsets = np.round(np.arange(count) * (1e9 / rate_hz)).astype(np.int64)
    stamps: IntArray = path.start_ns + np.minimum(offsets, round(path.duration_s * 1e9))
    return stamps


def _errors(
    noise: ImuNoise | None, step_s: float, count: int, faults: ImuFaults, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Biases of both sensors ``(count, 3)`` and their white noise ``(2, count, 3)``."""
    gyro, accel = (
        np.tile(np.asarray(first, dtype=np.float64), (count, 1))
        for first in (faults.gyro_bias_rad_s, faults.accel_bias_m_s2)
    )
    if noise is None:
        return gyro, accel, np.zeros((2, count, 3))
    gyro += _walk(noise.gyro_walk_rad_s2_rthz, step_s, count, rng)
    accel += _walk(noise.accel_walk_m_s3_rthz, step_s, count, rng)
    white = rng.standard_normal((2, count, 3)) / np.sqrt(step_s)
    white[0] *= noise.gyro_density_rad_s_rthz
    white[1] *= noise.accel_density_m_s2_rthz
    return gyro, accel, white


def _walk(density: float, step_s: float, count: int, rng: np.random.Generator) -> FloatArray:
    steps = density * np.sqrt(step_s) * rng.standard_normal((count - 1, 3))
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
