"""Tilt error as the BROAD data set defines it, and VQF as the rival that runs beside ours."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from vqf import VQF, offlineVQF

from motorcade.fusion.imu import ImuStream
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray


@pytest.fixture
def inclination_rms_deg() -> Callable[..., float]:
    """RMS over chosen samples of the angle of the error less its turn about the vertical.

    2 arccos √(w² + z²) of the error in the world's axes: Laidig, Caruso, Cereatti, Seel, "BROAD",
    Data 6(7), 2021.
    """

    def measure(estimate: Rotor, truth: Rotor, chosen: FloatArray | slice = slice(None)) -> float:
        error = (estimate @ truth.inverse()).as_quaternion()
        level = np.sqrt(error[:, 0] ** 2 + error[:, 3] ** 2)
        angle = 2.0 * np.arccos(np.clip(level, 0.0, 1.0))
        return float(np.degrees(np.sqrt(np.mean(angle[chosen] ** 2))))

    return measure


@pytest.fixture
def vqf_tilt() -> Callable[[ImuStream, bool], Rotor]:
    """VQF's orientation without magnetometer, online or offline, by its authors' package."""

    def run(imu: ImuStream, smooth: bool) -> Rotor:
        gyro = np.ascontiguousarray(imu.angular_rate_rad_s)
        accel = np.ascontiguousarray(imu.specific_force_m_s2)
        step_s = 1.0 / imu.rate_hz
        if smooth:
            return Rotor.from_quaternion(offlineVQF(gyro, accel, None, step_s)["quat6D"])
        return Rotor.from_quaternion(VQF(step_s).updateBatch(gyro, accel)["quat6D"])

    return run


@pytest.fixture(params=[False, True], ids=["online", "offline"])
def smooth(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)
