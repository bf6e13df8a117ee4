"""Metres and up for what one camera mapped, by the IMU that was carried with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from motorcade.fusion.imu import ADIS16448
from motorcade.fusion.visual_inertial import MetricMap, metric_map
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera.offered import rows_readout_s
from motorcade.replays.stages.inertial.filter_input import assumed_noise

if TYPE_CHECKING:
    from motorcade.tracking.slam import SlamResult

_MOST_SIGMA = 0.1


class NoMetres(ValueError):
    """The IMU does not tell the scale; the message says why."""


@dataclass(frozen=True, eq=False)
class Metres:
    """The map in metres with z up, and the relative deviation of its scale."""

    made: MetricMap
    scale_sigma: float


def in_metres(recording: Recording, found: SlamResult) -> Metres:
    """Give a finished run of SLAM scale and up, by the recorded IMU at its recorded stamps.

    Raises:
        NoMetres: no IMU, one that is not known to sit anywhere, or motion that tells the scale to
            no better than a tenth.
    """
    imu, camera = recording.imu, recording.camera
    if imu is None or camera is None:
        raise NoMetres("no IMU whose extrinsics are known was recorded")
    if recording.imu_T_camera is None:
        raise NoMetres("where the camera sits on the IMU is not known")
    noise = assumed_noise(recording.imu_noise or ADIS16448, "recorded")
    try:
        readout_s = rows_readout_s(recording)
        made = metric_map(found, camera, imu, noise, recording.imu_T_camera, readout_s)
    except (ValueError, RuntimeError) as refused:  # gtsam's own errors are RuntimeErrors
        raise NoMetres(f"the IMU does not tell the scale: {refused}") from refused
    sigma = made.start.log_scale_sigma
    if not sigma <= _MOST_SIGMA:
        raise NoMetres(
            f"the IMU tells the scale to ±{100 * sigma:.0f} % only: too little acceleration"
        )
    return Metres(made, sigma)
