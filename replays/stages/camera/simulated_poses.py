"""Stage `simulated_poses`: camera poses as a sensor would measure them along the ground truth."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.replays.engine.stage import NotOffered
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses


def simulated_poses(
    recording: Recording,
    *,
    rate_hz: float = 20.0,
    sigma_m: float = 0.01,
    sigma_deg: float = 0.5,
    seed: int = 0,
) -> CameraPoses:
    """Simulate poses from the ground truth, with noise.

    `rate_hz` poses a second are measured, with standard deviations of `sigma_m` and `sigma_deg` an
    axis; their errors are drawn by `seed`.

    Raises:
        NotOffered: the recording has no ground truth.
    """
    if recording.truth is None:
        raise NotOffered(f"{recording.name}: no ground truth to simulate camera poses from")
    simulated = simulate_camera_poses(
        recording.truth,
        rate_hz,
        sigma_m,
        float(np.deg2rad(sigma_deg)),
        np.random.default_rng(seed),
    )
    return CameraPoses(
        simulated,
        simulated.trajectory.time_ns,
        np.full(len(simulated), np.nan),
        "simulated",
        "simulated from the ground truth, with noise",
    )
