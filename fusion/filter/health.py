"""The verdict on a fusion: what its inputs say of each other, and what came out of them."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.settings import FilterSettings
from motorcade.fusion.health.check import check_health
from motorcade.fusion.health.outcome import with_outcome
from motorcade.fusion.health.verdict import Health
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

log = logging.getLogger("motorcade.fuse")


def fused_health(
    camera: Trajectory,
    imu: ImuStream,
    imu_T_camera: Motor,
    time_offset_s: float,
    settings: FilterSettings,
    outcome: tuple[NDArray[np.bool_], FloatArray, FloatArray],
) -> Health:
    """Test the inputs, then the outcome, and log what is wrong; see `check_health`.

    `outcome` is what `with_outcome` takes: which poses were accepted, and the biases.
    """
    of_inputs = check_health(
        camera,
        imu,
        imu_T_camera,
        time_offset_s=time_offset_s,
        gravity_m_s2=settings.gravity_m_s2,
        lean_sigma_rad=settings.gravity_sigma_rad,
        extrinsics_sigma_rad=settings.extrinsics_sigma_rad,
        time_offset_sigma_s=settings.time_offset_sigma_s,
    )
    health = with_outcome(of_inputs, *outcome)
    for one in health.findings:
        log.warning("%s", one.summary)
    return health
