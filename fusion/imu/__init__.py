"""Inertial sensors: their data, their noise and how to measure it, and a simulator of both."""

from __future__ import annotations

from motorcade.fusion.imu.allan import StreamNoise, estimate_noise
from motorcade.fusion.imu.continuous_path import ContinuousPath
from motorcade.fusion.imu.faults import ImuFaults
from motorcade.fusion.imu.noise import ADIS16448, ImuNoise
from motorcade.fusion.imu.screening import screen_imu
from motorcade.fusion.imu.simulate import simulate_imu, simulate_imu_in_chunks
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.imu.vibration import VibrationSpectrum

__all__ = [
    "ADIS16448",
    "ContinuousPath",
    "ImuFaults",
    "ImuNoise",
    "ImuStream",
    "StreamNoise",
    "VibrationSpectrum",
    "estimate_noise",
    "screen_imu",
    "simulate_imu",
    "simulate_imu_in_chunks",
]
