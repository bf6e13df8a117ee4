"""Motions with known derivatives, shared by the tests of the fusion room.

`handheld` swings about all axes and wanders in a metre of space; its linear acceleration and
angular rate follow from the closed forms, not from differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.filter import Fused, fuse
from motorcade.fusion.imu import ImuNoise, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.measurements import PoseMeasurements

START_NS = 1_403_715_273_262_142_976

NOISE = ImuNoise(2e-3, 2e-4, 2e-2, 3e-3)
IMU_T_CAMERA = Motor.from_euler_translation(
    np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07])
)
SIGMA_M, SIGMA_RAD = 0.01, np.deg2rad(0.5)


@dataclass(frozen=True)
class Handheld:
    """Sines of position and of intrinsic x-y'-z'' angles; `speed` multiplies all frequencies."""

    speed: float = 1.0

    def time_ns(self, rate_hz: float, duration_s: float) -> IntArray:
        count = round(duration_s * rate_hz) + 1
        return START_NS + np.round(np.arange(count) * 1e9 / rate_hz).astype(np.int64)

    def _phases(self, seconds: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        rates = self.speed * np.array([0.9, 1.3, 0.7, 1.1, 0.8, 1.5])
        phase = seconds[:, None] * rates + np.array([0.0, 0.7, 1.9, 0.4, 1.2, 2.5])
        return np.array([0.5, 0.4, 0.2, 0.4, 0.5, 0.6]), rates, phase

    def poses(self, time_ns: IntArray) -> Motor:
        size, _, phase = self._phases((time_ns - START_NS) * 1e-9)
        wave = size * np.sin(phase)
        return Motor.from_rotor_translation(Rotor.from_euler(wave[:, 3:]), wave[:, :3])

    def accelerations(self, time_ns: IntArray) -> FloatArray:
        size, rates, phase = self._phases((time_ns - START_NS) * 1e-9)
        return (-size * rates**2 * np.sin(phase))[:, :3]

    def velocities(self, time_ns: IntArray) -> FloatArray:
        size, rates, phase = self._phases((time_ns - START_NS) * 1e-9)
        return (size * rates * np.cos(phase))[:, :3]

    def trajectory(
        self, rate_hz: float = 100.0, duration_s: float = 10.0, child: str = "camera"
    ) -> Trajectory:
        stamps = self.time_ns(rate_hz, duration_s)
        return Trajectory(stamps, self.poses(stamps), "world", child)


@pytest.fixture
def handheld() -> Handheld:
    return Handheld()


@pytest.fixture
def jittered() -> Callable[[Trajectory, float, float, np.random.Generator], Trajectory]:
    """Add independent noise (m, rad an axis) in the moving frame."""

    def add(
        trajectory: Trajectory, sigma_m: float, sigma_rad: float, rng: np.random.Generator
    ) -> Trajectory:
        noise = rng.standard_normal((len(trajectory), 6)) * np.repeat([sigma_rad, sigma_m], 3)
        return trajectory.transformed_by(right=Motor.from_twist(noise))

    return add


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20240229)


@dataclass(frozen=True)
class Run:
    """One simulated recording: the true state at the IMU's stamps, and what was measured."""

    truth: Trajectory
    velocity_m_s: FloatArray
    gyro_bias: FloatArray
    accel_bias: FloatArray
    imu: ImuStream
    measurements: PoseMeasurements
    noise: ImuNoise = NOISE
    imu_T_camera: Motor = IMU_T_CAMERA

    @property
    def camera(self) -> Trajectory:
        return self.truth.transformed_by(right=self.imu_T_camera, child="camera")

    def fuse(self, **options: Any) -> Fused:
        return fuse(self.measurements, self.imu, self.noise, self.imu_T_camera, **options)


@pytest.fixture
def record(handheld: Handheld) -> Callable[..., Run]:
    """Simulate a recording; its biases start where the filter's prior says they may."""

    def make(rng: np.random.Generator, duration_s: float = 8.0, rate_hz: float = 100.0) -> Run:
        path = handheld.trajectory(100.0, duration_s, "imu")
        simulated = simulate_imu(path, rate_hz, NOISE, rng)
        gyro, accel = 0.05 * rng.standard_normal(3), 0.25 * rng.standard_normal(3)
        imu = ImuStream(
            simulated.stream.time_ns,
            simulated.stream.angular_rate_rad_s + gyro,
            simulated.stream.specific_force_m_s2 + accel,
        )
        camera = simulated.path.transformed_by(right=IMU_T_CAMERA)
        measured = simulate_camera_poses(camera, 20.0, SIGMA_M, SIGMA_RAD, rng)
        biases = simulated.gyro_bias_rad_s + gyro, simulated.accel_bias_m_s2 + accel
        return Run(simulated.path, simulated.velocity_m_s, *biases, imu, measured)

    return make
