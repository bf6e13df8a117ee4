"""Stage `fused`: camera poses and IMU as one path, between frames and through blackouts."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused, fuse
from motorcade.replays.stages.camera_poses import CameraPoses
from motorcade.replays.stages.imu import Imu

NOISE_FACTORS = {"recorded": 5.0, "reference": 1.0, "tracked": 1000.0}
"""By where the IMU came from. Data sheets describe a sensor at rest on a bench; Kalibr's authors
advise to inflate their densities by up to ten for one that is carried, and the filter's NIS says
whether it fits. A stream simulated along the tracked path repeats what the camera said, errors
and all, and must not be believed a second time."""


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
    `noise_factor` multiplies the IMU's densities: by default 5 for a recorded IMU, 1 for one
    simulated from the truth, 1000 for one simulated along the tracked path. `gate` is the
    probability with which a good measurement passes.
    """
    return fuse(
        camera_poses.measurements,
        imu.stream,
        imu.noise.scaled(default_noise_factor(imu) if noise_factor is None else noise_factor),
        imu.imu_T_camera,
        camera_poses.sought_ns,
        settings=FilterSettings(
            gate=gate, initial_tilt_error_rad=float(np.deg2rad(initial_tilt_deg))
        ),
        smoothed=look_ahead,
    )


def default_noise_factor(imu: Imu) -> float:
    """What the densities are multiplied by where nobody says."""
    return NOISE_FACTORS[imu.origin]
