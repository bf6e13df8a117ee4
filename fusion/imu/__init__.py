"""Inertial sensors: their data, their noise, and a simulator of both."""

from __future__ import annotations

from motorcade.fusion.imu.noise import ADIS16448, ImuNoise
from motorcade.fusion.imu.simulate import ContinuousPath, ImuFaults, SimulatedImu, simulate_imu
from motorcade.fusion.imu.stream import ImuStream

__all__ = [
    "ADIS16448",
    "ContinuousPath",
    "ImuFaults",
    "ImuNoise",
    "ImuStream",
    "SimulatedImu",
    "simulate_imu",
]
