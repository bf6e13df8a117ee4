"""Stage `imu`: the recorded inertial stream, or one simulated along the path."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import Literal

import numpy as np

from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.sync import synchronise
from motorcade.ga import Motor
from motorcade.replays.recording import Recording
from motorcade.replays.values.camera_poses import CameraPoses
from motorcade.replays.values.imu import ImuOrigin, UsedImu

log = logging.getLogger("motorcade.imu")
_NO_EXTRINSICS = (
    "the camera's pose on the IMU is not known; put imu_T_camera (4 by 4, from camera to IMU "
    "coordinates, as `motorcade sync` finds it) into [imu] of a manifest"
)

NEAREST_KNOTS_S = 0.02
FEWEST_POSES = 4


def imu(
    recording: Recording,
    camera_poses: CameraPoses,
    *,
    source: Literal["auto", "recorded", "reference", "tracked"] = "auto",
    sync: Literal["off", "estimate"] = "off",
    rate_hz: float = 200.0,
    knot_spacing_s: float | None = None,
    seed: int = 0,
) -> UsedImu:
    """The recording's own IMU; without one, a simulation along the tracked path.

    `source=auto` takes the recorded stream, else simulates one along the tracked path; that adds
    nothing that the images did not know, so it flatters no result. "reference" simulates from the
    ground truth instead and is meant for experiments. A simulation has `rate_hz` samples a second,
    their noise drawn by `seed`. `sync=estimate` finds the offset between the clocks of camera and
    recorded IMU by the motion of both, and takes it off; otherwise the stamps are believed.
    `knot_spacing_s` is that of the simulation's spline: by default one knot a pose, but none nearer
    than 0.02 s, so that the stream moves as the poses do. A simulated IMU sits where the recorded
    one does, and in the camera itself where that is not known. Nothing is guessed of a recorded
    one: where nothing tells how the camera sits on it, `auto` leaves it aside with a warning.
    Raises ValueError where the source asked for is not there, and where the motion does not tell
    the offset.
    """
    origin = _origin(recording) if source == "auto" else source
    imu_T_camera, noise = recording.imu_T_camera, recording.imu_noise or ADIS16448
    if origin == "recorded":
        if recording.imu is None:
            raise ValueError(f"{recording.name}: imu.source=recorded, but it has no IMU stream")
        if imu_T_camera is None:
            raise ValueError(f"{recording.name}: imu.source=recorded, but {_NO_EXTRINSICS}")
        made = UsedImu(None, noise, imu_T_camera, origin)
        return made if sync == "off" else _on_camera_clock(made, recording.imu, camera_poses)
    if sync != "off":
        raise ValueError(f"{recording.name}: imu.sync={sync} needs a recorded IMU")
    path = recording.truth if origin == "reference" else camera_poses.measurements.trajectory
    if path is None:
        raise ValueError(f"{recording.name}: imu.source=reference, but it has no ground truth")
    if imu_T_camera is None:
        imu_T_camera = Motor.identity()
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
    return UsedImu(simulated.stream, noise, imu_T_camera, origin)


def _origin(recording: Recording) -> ImuOrigin:
    """Recorded, unless there is no stream, or nothing tells how the camera sits on its sensor."""
    if recording.imu is None:
        return "tracked"
    if recording.imu_T_camera is None:
        log.warning("%s: its IMU is left aside: %s", recording.name, _NO_EXTRINSICS)
        return "tracked"
    return "recorded"


def _on_camera_clock(imu: UsedImu, recorded: ImuStream, camera_poses: CameraPoses) -> UsedImu:
    """The IMU with the offset by which its stamps are carried over to the camera's clock."""
    if camera_poses.metres_a_unit is not None or not camera_poses.metric:
        raise ValueError(
            "imu.sync=estimate needs a path whose metres do not come from the IMU itself; find the "
            "offset on another recording (motorcade sync), and state it in a manifest "
            "([imu] clock_offset_s = ...)"
        )
    found = synchronise(camera_poses.measurements.trajectory, recorded, imu.noise)
    return replace(imu, clock_offset_s=found.offset_s, clock_offset_sigma_s=found.offset_sigma_s)
