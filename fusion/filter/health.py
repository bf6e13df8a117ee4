"""The verdict on a fusion: what its inputs say of each other, and what came out of them."""

from __future__ import annotations

import logging

import numpy as np

from motorcade.fusion.filter.fused import Fused
from motorcade.fusion.filter.settings import FilterSettings
from motorcade.fusion.health.check import check_health
from motorcade.fusion.health.outcome import covariance_findings, with_outcome
from motorcade.fusion.health.verdict import Health
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Trajectory

log = logging.getLogger("motorcade.fuse")


def fused_health(
    camera: Trajectory,
    imu: ImuStream,
    imu_T_camera: Motor,
    time_offset_s: float,
    settings: FilterSettings,
    fused: Fused,
) -> Health:
    """Test the inputs, then the outcome, and log what is wrong; see `check_health`."""
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
    covered = covariance_findings(
        fused.trajectory.time_ns, fused.covariance, fused.state_covariance
    )
    accepted = fused.accepted[np.isfinite(fused.nis)]
    biases = fused.gyro_bias_rad_s, fused.accel_bias_m_s2
    health = with_outcome(of_inputs, accepted, *biases, covered)
    for finding in health.findings:
        if finding.fault != "deviations_modelled":
            log.warning("%s", finding.summary)
    return health
