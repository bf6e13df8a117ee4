"""SLAM with the recorded IMU inside: metres and up while the map is made."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.imu import ADIS16448, ImuStream
from motorcade.fusion.visual_inertial import InertialSlam, InertialSlamResult
from motorcade.ga.progress import track
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.offered import camera_of, rows_readout_s
from motorcade.replays.stages.inertial.filter_input import assumed_noise
from motorcade.replays.stages.values.inertial import InertialHistory
from motorcade.tracking import PoseMeasurements

if TYPE_CHECKING:
    from motorcade.tracking.slam import SlamResult, SlamSettings

log = logging.getLogger("motorcade.slam")

# Frames that no sample covers get no pose: so few may be left out at either end for its sake.
_MOST_OUTSIDE_S = 0.5
_FEWEST_SAMPLES = 2  # beyond a frame's stamp, so that readings at the stamp lie between two


@dataclass(frozen=True, eq=False)
class MappedWithImu:
    """A finished run, its map in metres with z up, and what the IMU told."""

    slam: SlamResult
    measurements: PoseMeasurements
    history: InertialHistory


def carries_imu(recording: Recording) -> bool:
    """Whether a camera or a pair was recorded with an IMU that sits somewhere known, all along."""
    imu, stamps = recording.imu, recording.frames.time_ns
    if imu is None or recording.imu_T_camera is None or len(imu) <= _FEWEST_SAMPLES:
        return False
    outside_ns = max(imu.time_ns[0] - stamps[0], stamps[-1] - imu.time_ns[-_FEWEST_SAMPLES])
    without_depth = recording.frames[0].read_depth is None
    return (
        without_depth and recording.slam_map is None and bool(outside_ns <= 1e9 * _MOST_OUTSIDE_S)
    )


def mapped_with_imu(recording: Recording, settings: SlamSettings) -> MappedWithImu | None:
    """Track a recording that `carries_imu`, with the samples inside; None: they told no metres."""
    imu, imu_T_camera = recording.imu, recording.imu_T_camera
    if imu is None or imu_T_camera is None:
        raise ValueError("recording: expected one that carries an IMU, got none")
    noise = assumed_noise(recording.imu_noise or ADIS16448, "recorded")
    slam = InertialSlam(
        camera_of(recording), noise, imu_T_camera, settings, readout_s=rows_readout_s(recording)
    )
    stamps, fed = recording.frames.time_ns, 0
    covered = np.flatnonzero((stamps >= imu.time_ns[0]) & (stamps <= imu.time_ns[-_FEWEST_SAMPLES]))
    if not len(covered):
        return None
    for row in track(covered.tolist(), "mapping with the IMU", len(covered)):
        frame = recording.frames[row]
        fed = _fed(slam, imu, fed, frame.time_ns)
        right = None if settings.baseline_m is None else frame.right()
        slam.track(frame.time_ns, frame.gray(), right)
    return _told(recording, slam.finish())


def _fed(slam: InertialSlam, imu: ImuStream, fed: int, time_ns: int) -> int:
    """Hand over samples until they reach beyond a stamp; returns how many were given so far.

    A stream is two samples or more, so none is left by itself.
    """
    reached = int(np.searchsorted(imu.time_ns, time_ns)) + _FEWEST_SAMPLES
    if reached <= fed:
        return fed
    reached = max(reached, fed + _FEWEST_SAMPLES)
    if len(imu) - reached < _FEWEST_SAMPLES:
        reached = len(imu)
    rows = slice(fed, reached)
    turn, force = imu.angular_rate_rad_s[rows], imu.specific_force_m_s2[rows]
    slam.imu(ImuStream(imu.time_ns[rows], turn, force))
    return reached


def _told(recording: Recording, result: InertialSlamResult) -> MappedWithImu | None:
    start, measurements = result.start, result.measurements
    if start is None or result.metric_from_ns is None or measurements is None:
        log.info("%s: no metres while mapping, so they are looked for afterwards", recording.name)
        return None
    scale = float(start.world_T_visual.scale)
    history = InertialHistory(
        result.slam.time_ns,
        result.states,
        result.metric_from_ns,
        scale,
        start.log_scale_sigma,
        start.world_T_visual.rotor.inverse().apply(np.array([0.0, 0.0, -1.0])),
        start.tilt_sigma_rad,
        rows_readout_s(recording),
    )
    return MappedWithImu(result.slam, measurements, history)
