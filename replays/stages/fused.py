"""Stage `fused`: camera poses and IMU as one path, between frames and through blackouts."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused, fuse
from motorcade.fusion.imu import ImuNoise
from motorcade.replays.stages.camera_poses import CameraPoses
from motorcade.replays.stages.imu import Imu

NOISE_FACTORS = {"recorded": (10.0, 1.0), "reference": (1.0, 1.0), "tracked": (1000.0, 1000.0)}
"""On white densities and on bias walks, by where the IMU came from. Data sheets describe a sensor
at rest on a bench: one that is carried or flown feels what shakes it, and its scales and axes are
a little off, which looks like white noise. Tenfold is what Kalibr's authors advise, and brings the
filter's NIS to six on EuRoC's flights; biases walk as the sheet says. A stream simulated along the
tracked path repeats what the camera said, errors and all, and must not be believed twice."""

ALIGNMENT_SIGMA_DEG = {"recorded": 1.0, "reference": 0.0, "tracked": 0.0}
"""How far the world's z may be from up, and the camera's calibrated attitude on the IMU from the
true one, by where the IMU came from; a simulated one knows both."""


def fused(
    camera_poses: CameraPoses,
    imu: Imu,
    *,
    look_ahead: bool = True,
    noise_factor: float | None = None,
    walk_factor: float | None = None,
    alignment_sigma_deg: float | None = None,
    gate: float = 0.9999,
    initial_tilt_deg: float = 0.0,
) -> Fused:
    """Filter the measured poses with the IMU, at every stamp at which a pose was sought.

    `look_ahead` adds the backward pass; without it every estimate knows only its past.
    `noise_factor` multiplies the IMU's white densities: by default 10 for a recorded IMU, 1 for one
    simulated from the truth, 1000 for one simulated along the tracked path; `walk_factor` its bias
    walks: 1, 1, 1000. `alignment_sigma_deg` above zero has the vertical of the world and the
    attitude of the camera on the IMU estimated, from so much doubt about each axis: by default 1
    for a recorded IMU, else 0. `gate` is the probability with which a good measurement passes;
    `initial_tilt_deg` starts so far off upright.
    """
    noise = filter_noise(imu, noise_factor, walk_factor)
    return fuse(
        camera_poses.measurements,
        imu.stream,
        noise,
        imu.imu_T_camera,
        camera_poses.sought_ns,
        settings=filter_settings(imu, initial_tilt_deg, alignment_sigma_deg, gate),
        smoothed=look_ahead,
    )


def filter_noise(
    imu: Imu, noise_factor: float | None = None, walk_factor: float | None = None
) -> ImuNoise:
    """The noise that the filter assumes: the sensor's, times the factors of its origin."""
    white, walk = NOISE_FACTORS[imu.origin]
    white = white if noise_factor is None else noise_factor
    walk = walk if walk_factor is None else walk_factor
    noise = imu.noise
    return ImuNoise(
        white * noise.gyro_density_rad_s_rthz,
        walk * noise.gyro_walk_rad_s2_rthz,
        white * noise.accel_density_m_s2_rthz,
        walk * noise.accel_walk_m_s3_rthz,
    )


def filter_settings(
    imu: Imu,
    initial_tilt_deg: float = 0.0,
    alignment_sigma_deg: float | None = None,
    gate: float = 0.9999,
) -> FilterSettings:
    """What the filter assumes besides."""
    if alignment_sigma_deg is None:
        alignment_sigma_deg = ALIGNMENT_SIGMA_DEG[imu.origin]
    sigma_rad = float(np.deg2rad(alignment_sigma_deg))
    return FilterSettings(
        gate=gate,
        initial_tilt_error_rad=float(np.deg2rad(initial_tilt_deg)),
        gravity_sigma_rad=sigma_rad,
        mount_sigma_rad=sigma_rad,
    )
