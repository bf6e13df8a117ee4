"""Stage `fused`: camera poses and IMU as one path, between frames and through blackouts."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused, fuse
from motorcade.replays.stages.camera_poses import CameraPoses
from motorcade.replays.stages.imu import Imu

RECORDED_NOISE_FACTOR = 5.0
"""Data sheets describe a sensor at rest on a bench. Kalibr's authors advise to inflate their
densities by a factor up to ten for one that is carried; the filter's NIS says whether it fits."""


def fused(
    camera_poses: CameraPoses,
    imu: Imu,
    *,
    look_ahead: bool = True,
    noise_factor: float | None = None,
    gate: float = 0.9999,
    initial_tilt_deg: float = 0.0,
) -> Fused:
    """Filter the measured poses with the IMU, at every stamp at which a pose was sought.

    `look_ahead` adds the backward pass; without it every estimate knows only its past.
    `noise_factor` multiplies the IMU's densities: by default 5 for a recorded IMU, 1 for a
    simulated one. `gate` is the probability with which a good measurement passes.
    """
    return fuse(
        camera_poses.measurements,
        imu.stream,
        imu.noise.scaled(noise_factor or default_noise_factor(imu)),
        imu.imu_T_camera,
        camera_poses.sought_ns,
        settings=FilterSettings(
            gate=gate, initial_tilt_error_rad=float(np.deg2rad(initial_tilt_deg))
        ),
        smoothed=look_ahead,
    )


def default_noise_factor(imu: Imu) -> float:
    """What the densities are multiplied by where nobody says."""
    return RECORDED_NOISE_FACTOR if imu.origin == "recorded" else 1.0
