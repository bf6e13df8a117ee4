"""Stage `imu`: the recorded inertial stream; for experiments, one simulated from ground truth."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import Literal

import numpy as np

from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.sync.synchronise import synchronise
from motorcade.ga import Motor
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.inertial import UsedImu

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
    source: Literal["auto", "recorded", "reference"] = "auto",
    sync: Literal["off", "estimate"] = "off",
    rate_hz: float = 200.0,
    knot_spacing_s: float | None = None,
    seed: int = 0,
) -> UsedImu:
    """The recording's own IMU; without one, none.

    `source=auto` takes the recorded stream where there is one, and no other: what was not measured
    cannot be fused. "reference" simulates a stream from the ground truth instead and is meant for
    experiments. A simulation has `rate_hz` samples a second, their noise drawn by `seed`.
    `sync=estimate` finds the offset between the clocks of camera and recorded IMU by the motion of
    both, and takes it off; otherwise the stamps are believed. `knot_spacing_s` is that of the
    simulation's spline: by default one knot a pose of the ground truth, but none nearer than
    0.02 s. A simulated IMU sits where the recorded one does, and in the camera itself where that is
    not known. Nothing is guessed of a recorded one: where nothing tells how the camera sits on it,
    `auto` leaves it aside with a warning. Raises ValueError where the source asked for is not
    there, and where the motion does not tell the offset.
    """
    if source == "reference":
        if sync != "off":
            raise ValueError(f"{recording.name}: imu.sync={sync} needs a recorded IMU")
        return _simulated(recording, rate_hz, knot_spacing_s, seed)
    if source == "recorded":
        if recording.imu is None:
            raise ValueError(f"{recording.name}: imu.source=recorded, but it has no IMU stream")
        if recording.imu_T_camera is None:
            raise ValueError(f"{recording.name}: imu.source=recorded, but {_NO_EXTRINSICS}")
    if recording.imu is None or recording.imu_T_camera is None:
        if sync != "off":
            raise ValueError(f"{recording.name}: imu.sync={sync} needs a recorded IMU")
        return _none(recording)
    noise = recording.imu_noise or ADIS16448
    used = UsedImu(None, noise, recording.imu_T_camera, "recorded")
    return used if sync == "off" else _on_camera_clock(used, recording.imu, camera_poses)


def _none(recording: Recording) -> UsedImu:
    """No stream, or one that is left aside because nothing tells how the camera sits on it."""
    if recording.imu is None:
        return UsedImu.none("no IMU was recorded")
    log.warning("%s: its IMU is left aside: %s", recording.name, _NO_EXTRINSICS)
    return UsedImu.none("nothing tells how the camera sits on the recorded IMU")


def _simulated(
    recording: Recording, rate_hz: float, knot_spacing_s: float | None, seed: int
) -> UsedImu:
    """A stream along the ground truth."""
    path = recording.truth
    if path is None:
        raise ValueError(f"{recording.name}: imu.source=reference, but it has no ground truth")
    if len(path) < FEWEST_POSES:
        raise ValueError(
            f"{recording.name}: expected at least {FEWEST_POSES} poses to simulate an IMU along, "
            f"got {len(path)}"
        )
    noise, imu_T_camera = recording.imu_noise or ADIS16448, recording.imu_T_camera
    if imu_T_camera is None:
        imu_T_camera = Motor.identity()
    world_T_imu = path.transformed_by(right=imu_T_camera.inverse(), child="imu")
    if knot_spacing_s is None:
        knot_spacing_s = max(float(np.median(np.diff(path.time_s))), NEAREST_KNOTS_S)
    simulated = simulate_imu(
        world_T_imu, rate_hz, noise, np.random.default_rng(seed), knot_spacing_s=knot_spacing_s
    )
    return UsedImu(simulated.stream, noise, imu_T_camera, "reference")


def _on_camera_clock(imu: UsedImu, recorded: ImuStream, camera_poses: CameraPoses) -> UsedImu:
    """The IMU with the offset by which its stamps are carried over to the camera's clock."""
    from_imu = camera_poses.metres_a_unit is not None or camera_poses.inertial is not None
    if from_imu or not camera_poses.metric:
        raise ValueError(
            "imu.sync=estimate needs a path in metres that does not come from the IMU itself: with "
            "a pair slam_poses.imu_inside=false gives one; with one camera find the offset on "
            "another recording (motorcade sync), and state it in a manifest ([imu] clock_offset_s "
            "= ...)"
        )
    synchronised = synchronise(camera_poses.measurements.trajectory, recorded, imu.noise)
    return replace(
        imu, clock_offset_s=synchronised.offset_s, clock_offset_sigma_s=synchronised.offset_sigma_s
    )
