"""Metres and up for what one camera mapped, by the IMU that was carried with it.

The deviation of the scale believes the poses' own covariances. A map that drifts, or a lens that is
not quite the one it was made with, errs otherwise, and a scale far off may then come out as sure;
so the IMU is asked again whether the path that it gave metres to is one that it felt.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.filter import FilterSettings, fuse
from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.fusion.metrics import most_by_chance
from motorcade.fusion.visual_inertial import MetricMap, metric_map
from motorcade.ga import Motor
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.offered import rows_readout_s
from motorcade.replays.stages.inertial.filter_input import assumed_noise

if TYPE_CHECKING:
    from motorcade.tracking.slam import SlamResult

_MOST_SIGMA = 0.1
_CONTAMINATION = 0.1
"""Share of the poses that may contradict the IMU, as in the check of the run (`integrity`)."""
_FREEDOM = 6


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
        NoMetres: no IMU, one that is not known to sit anywhere, motion that tells the scale to no
            better than a tenth, or a path in metres that the IMU contradicts.
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
    beyond, count = _contradicting(made, imu, noise, recording.imu_T_camera)
    if beyond > most_by_chance(count, _CONTAMINATION):
        raise NoMetres(
            f"the IMU does not tell the scale: {beyond} of {count} poses of the path that it was "
            "to bring to metres contradict it"
        )
    return Metres(made, sigma)


def _contradicting(
    made: MetricMap, imu: ImuStream, noise: ImuNoise, imu_T_camera: Motor
) -> tuple[int, int]:
    """How many of the poses in metres the filter's gate would not let pass, and of how many."""
    stamps = made.measurements.trajectory.time_ns
    fused = fuse(made.measurements, imu, noise, imu_T_camera, stamps)
    judged = fused.nis[np.isfinite(fused.nis)]
    return int(np.count_nonzero(judged > FilterSettings().gate_limit(_FREEDOM))), len(judged)
