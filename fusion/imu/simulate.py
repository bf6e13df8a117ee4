"""An IMU simulated along a trajectory: what the sensor would have read, with its noise and biases.

A spline on motors is fitted to the poses; angular rate and acceleration are its exact derivatives,
so there is no error of differencing, and the spline itself is the true path of the simulation. The
world has z up; an accelerometer at rest reads +g upward.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import FloatArray, IntArray, Trajectory
from motorcade.ga.splines import CumulativeBSpline, SplineSample

__all__ = ["SimulatedImu", "simulate_imu"]


@dataclass(frozen=True, eq=False)
class SimulatedImu:
    """A simulated stream and the truth behind it, all at the stream's stamps ``(N,)``.

    Fields:
        stream: what the sensor reads.
        gyro_bias_rad_s, accel_bias_m_s2: the true biases ``(N, 3)``; they start at zero.
        path: the true poses ``world_T_imu``, those of the spline.
        velocity_m_s: the true velocity in the world ``(N, 3)``.
    """

    stream: ImuStream
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    path: Trajectory
    velocity_m_s: FloatArray


def simulate_imu(
    world_T_imu: Trajectory,
    rate_hz: float,
    noise: ImuNoise | None,
    rng: np.random.Generator,
    gravity_m_s2: float = 9.81,
    knot_spacing_s: float = 0.1,
) -> SimulatedImu:
    """Simulate an IMU that moves along `world_T_imu`.

    Args:
        world_T_imu: poses of the IMU (not of the camera), world z up; two or more.
        rate_hz: samples a second, from the first stamp to the last.
        noise: white noise σ/√Δt and bias walks σ_b√Δt (Kalibr); None for a perfect sensor.
        rng: source of the noise; the same seed gives the same bytes.
        gravity_m_s2: size of gravity, which pulls along -z of the world.
        knot_spacing_s: knots of the spline. It follows motion up to about 1 / (4 spacing) Hz and
            averages what is faster; where poses stand farther apart than knots it only joins them.

    Raises:
        ValueError: a rate, gravity or spacing that is not positive, a rate that leaves fewer than
            two samples, a single pose, or motion too fast for the knots.
    """
    for name, value in (("rate_hz", rate_hz), ("gravity_m_s2", gravity_m_s2)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name}: expected a number above 0, got {value}")
    stamps = _stamps(world_T_imu, rate_hz)
    spline = CumulativeBSpline.fit(world_T_imu, knot_spacing_s)
    time_s = np.minimum((stamps - spline.start_ns) * 1e-9, spline.duration_s)
    exact = spline.evaluate(time_s)
    rate, force = exact.body_angular_rate_rad_s, specific_force_m_s2(exact, gravity_m_s2)
    gyro_bias, accel_bias = np.zeros_like(rate), np.zeros_like(force)
    if noise is not None:
        step_s = 1.0 / rate_hz
        gyro_bias = _walk(noise.gyro_walk_rad_s2_rthz, step_s, len(stamps), rng)
        accel_bias = _walk(noise.accel_walk_m_s3_rthz, step_s, len(stamps), rng)
        white = rng.standard_normal((2, *rate.shape)) / np.sqrt(step_s)
        rate = rate + gyro_bias + noise.gyro_density_rad_s_rthz * white[0]
        force = force + accel_bias + noise.accel_density_m_s2_rthz * white[1]
    path = Trajectory(stamps, exact.pose, world_T_imu.parent, world_T_imu.child)
    stream = ImuStream(stamps, rate, force)
    return SimulatedImu(stream, gyro_bias, accel_bias, path, exact.world_velocity_m_s)


def specific_force_m_s2(motion: SplineSample, gravity_m_s2: float) -> FloatArray:
    """What a perfect accelerometer reads ``(*, 3)``: acceleration minus gravity, in its axes."""
    up = np.array([0.0, 0.0, gravity_m_s2])
    return motion.pose.rotor.inverse().apply(motion.world_acceleration_m_s2 + up)


def _stamps(trajectory: Trajectory, rate_hz: float) -> IntArray:
    count = int(np.floor(trajectory.duration_s * rate_hz + 1e-6)) + 1
    if count < 2:
        raise ValueError(
            f"rate_hz: expected two samples or more within {trajectory.duration_s} s, "
            f"got {rate_hz} Hz"
        )
    offsets = np.round(np.arange(count) * (1e9 / rate_hz)).astype(np.int64)
    last = trajectory.time_ns[-1] - trajectory.time_ns[0]
    stamps: IntArray = trajectory.time_ns[0] + np.minimum(offsets, last)
    return stamps


def _walk(density: float, step_s: float, count: int, rng: np.random.Generator) -> FloatArray:
    steps = density * np.sqrt(step_s) * rng.standard_normal((count - 1, 3))
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
