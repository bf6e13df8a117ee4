"""Stage `imu`: the recorded inertial stream, or one simulated along the path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream, simulate_imu
from motorcade.ga import Motor
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera_poses import CameraPoses

Origin = Literal["recorded", "reference", "tracked"]
NEAREST_KNOTS_S = 0.02
FEWEST_POSES = 4


@dataclass(frozen=True)
class Imu:
    """An inertial stream, its noise model, where the camera sits on it, and where it came from."""

    stream: ImuStream
    noise: ImuNoise
    imu_T_camera: Motor
    origin: Origin


def imu(
    recording: Recording,
    camera_poses: CameraPoses,
    *,
    source: Literal["auto", "recorded", "reference", "tracked"] = "auto",
    rate_hz: float = 200.0,
    knot_spacing_s: float | None = None,
    seed: int = 0,
) -> Imu:
    """The recording's own IMU; without one, a simulation along the tracked path.

    A stream simulated from the tracked path adds nothing that the images did not know, so it
    flatters no result; `source=reference` simulates from the truth instead and is meant for
    experiments. `knot_spacing_s` is that of the simulation's spline: by default one knot a pose,
    but none nearer than 0.02 s, so that the stream moves as the poses do. Raises ValueError where
    the source asked for is not there.
    """
    imu_T_camera = recording.imu_T_camera
    if imu_T_camera is None:
        imu_T_camera = Motor.identity()
    noise = recording.imu_noise or ADIS16448
    origin: Origin = "recorded" if recording.imu is not None else "tracked"
    origin = origin if source == "auto" else source
    if origin == "recorded":
        if recording.imu is None:
            raise ValueError(f"{recording.name}: imu.source=recorded, but it has no IMU stream")
        return Imu(recording.imu, noise, imu_T_camera, origin)
    path = recording.truth if origin == "reference" else camera_poses.measurements.trajectory
    if path is None:
        raise ValueError(f"{recording.name}: imu.source=reference, but it has no truth")
    world_T_imu = path.transformed_by(right=imu_T_camera.inverse(), child="imu")
    if len(path) < FEWEST_POSES:
        raise ValueError(
            f"{recording.name}: expected at least {FEWEST_POSES} poses to simulate an IMU along, "
            f"got {len(path)}"
        )
    if knot_spacing_s is None:
        knot_spacing_s = max(float(np.median(np.diff(path.time_s))), NEAREST_KNOTS_S)
    simulated = simulate_imu(
        world_T_imu, rate_hz, noise, np.random.default_rng(seed), knot_spacing_s=knot_spacing_s
    )
    return Imu(simulated.stream, noise, imu_T_camera, origin)
