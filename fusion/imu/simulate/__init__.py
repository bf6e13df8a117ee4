"""A simulated IMU: paths in continuous time, the sensor's noise and faults, what it reads."""

from __future__ import annotations

from motorcade.fusion.imu.simulate.path import ContinuousPath
from motorcade.fusion.imu.simulate.readings import SimulatedImu, simulate_imu
from motorcade.fusion.imu.simulate.sensor import PERFECT, ImuFaults

__all__ = ["PERFECT", "ContinuousPath", "ImuFaults", "SimulatedImu", "simulate_imu"]
