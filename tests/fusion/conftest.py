"""Motions with known derivatives, shared by the tests of the fusion room.

`handheld` swings about all axes and wanders in a metre of space; its linear acceleration and
angular rate follow from the closed forms, not from differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from motorcade.ga import FloatArray, IntArray, Motor, Rotor, Trajectory

START_NS = 1_403_715_273_262_142_976


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
def shaken() -> Callable[[Trajectory, float, float, np.random.Generator], Trajectory]:
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
