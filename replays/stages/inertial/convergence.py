"""Stage `convergence`: how the filter recovers when it starts with the wrong idea of up."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.filter import fuse
from motorcade.fusion.metrics import associate, tilt_rad
from motorcade.ga.stamps import checked_span_ns
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.inertial.filter_input import assumed_noise, levelled
from motorcade.replays.stages.inertial.fused import filter_settings
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.inertial import Convergence, UsedImu
from motorcade.replays.stages.values.paths import FusedPath


def convergence(
    recording: Recording,
    camera_poses: CameraPoses,
    imu: UsedImu,
    fused: FusedPath,
    *,
    initial_tilt_deg: float = 5.0,
    duration_s: float = 20.0,
) -> Convergence:
    """Run the causal filter again from a wrong tilt and zero biases, without looking ahead.

    The filter starts `initial_tilt_deg` off upright and runs for the first `duration_s` seconds.
    The tilt is judged by the ground truth where that shares the world of the poses (they were
    simulated from it), otherwise by the fused path. Where no filter made that nothing runs.
    """
    if fused.by != "imu":
        return Convergence(initial_tilt_deg, np.zeros(0), np.zeros(0), None, "nothing")
    simulated = camera_poses.origin == "simulated"
    stream = imu.stream(recording)
    level = levelled(camera_poses, imu, stream)
    reference = recording.truth if simulated else None
    if reference is None:
        reference = fused.trajectory.transformed_by(left=level.level_T_world)
    stamps = fused.trajectory.time_ns[fused.trajectory.time_ns >= stream.time_ns[0]]
    end_ns = stamps[0] + checked_span_ns(duration_s, "convergence.duration_s")
    stamps = stamps[stamps <= end_ns]
    again = fuse(
        level.measurements,
        stream,
        assumed_noise(imu.noise, imu.origin),
        imu.imu_T_camera,
        stamps,
        settings=filter_settings(imu, initial_tilt_deg, leaned=level.leaned),
        smoothed=False,
        state_covariances=False,
    )
    pairs = associate(again.trajectory, reference)
    time_s = (pairs.time_ns - stamps[0]) * 1e-9
    error_deg = np.rad2deg(tilt_rad(pairs.estimate, pairs.reference))
    judge = "truth" if simulated else "fused path, which knows the same data"
    above = np.flatnonzero(error_deg > initial_tilt_deg / 10)
    after = int(above[-1]) + 1 if above.size else 0
    settled = float(time_s[after]) if after < len(time_s) else None
    return Convergence(initial_tilt_deg, time_s, error_deg, settled, judge)
