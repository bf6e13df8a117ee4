"""Stage `imu`: the recorded inertial stream, or one simulated along the path."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream, simulate_imu
from motorcade.fusion.sync import synchronise
from motorcade.ga import Motor
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera.camera_poses import CameraPoses
from motorcade.replays.stages.inertial.imu_noise import Origin

log = logging.getLogger("motorcade.imu")
_NO_MOUNT = (
    "the camera's pose on the IMU is not known; put imu_T_camera (4 by 4, from camera to IMU "
    "coordinates, as `motorcade sync` finds it) into [imu] of a manifest"
)

NEAREST_KNOTS_S = 0.02
FEWEST_POSES = 4


@dataclass(frozen=True)
class Imu:
    """What inertial stream there is, its noise model, where the camera sits on it, its origin.

    `simulated` is there unless the stream is the recording's own, which is not stored twice;
    `stream` gives the one or the other. `clock_offset_s` is taken off the recorded stamps (what the
    IMU's clock showed at an event minus what the camera's did), and `clock_offset_sigma_s` is its
    deviation; None where it was not sought.
    """

    simulated: ImuStream | None
    noise: ImuNoise
    imu_T_camera: Motor
    origin: Origin
    clock_offset_s: float = 0.0
    clock_offset_sigma_s: float | None = None

    def stream(self, recording: Recording) -> ImuStream:
        """The stream on the camera's clock; `recording` is the one that the stage was given.

        Raises:
            ValueError: another recording, without a stream.
        """
        if self.simulated is not None:
            return self.simulated
        recorded = recording.imu
        if recorded is None:
            raise ValueError(f"{recording.name}: expected a recorded IMU, got none")
        if self.clock_offset_s == 0.0:
            return recorded
        return ImuStream(
            recorded.time_ns - round(self.clock_offset_s * 1e9),
            recorded.angular_rate_rad_s,
            recorded.specific_force_m_s2,
        )


def imu(
    recording: Recording,
    camera_poses: CameraPoses,
    *,
    source: Literal["auto", "recorded", "reference", "tracked"] = "auto",
    sync: Literal["off", "estimate"] = "off",
    rate_hz: float = 200.0,
    knot_spacing_s: float | None = None,
    seed: int = 0,
) -> Imu:
    """The recording's own IMU; without one, a simulation along the tracked path.

    `source=auto` takes the recorded stream, else simulates one along the tracked path; that adds
    nothing that the images did not know, so it flatters no result. "reference" simulates from the
    truth instead and is meant for experiments. A simulation has `rate_hz` samples a second, their
    noise drawn by `seed`. `sync=estimate` finds the offset between the clocks of camera and
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
            raise ValueError(f"{recording.name}: imu.source=recorded, but {_NO_MOUNT}")
        made = Imu(None, noise, imu_T_camera, origin)
        return made if sync == "off" else _on_camera_clock(made, recording.imu, camera_poses)
    if sync != "off":
        raise ValueError(f"{recording.name}: imu.sync={sync} needs a recorded IMU")
    path = recording.truth if origin == "reference" else camera_poses.measurements.trajectory
    if path is None:
        raise ValueError(f"{recording.name}: imu.source=reference, but it has no truth")
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
    return Imu(simulated.stream, noise, imu_T_camera, origin)


def _origin(recording: Recording) -> Origin:
    """Recorded, unless there is no stream, or nothing tells how the camera sits on its sensor."""
    if recording.imu is None:
        return "tracked"
    if recording.imu_T_camera is None:
        log.warning("%s: its IMU is left aside: %s", recording.name, _NO_MOUNT)
        return "tracked"
    return "recorded"


def _on_camera_clock(imu: Imu, recorded: ImuStream, camera_poses: CameraPoses) -> Imu:
    """The IMU with the offset by which its stamps are carried over to the camera's clock."""
    if camera_poses.metres_a_unit is not None or not camera_poses.metric:
        raise ValueError(
            "imu.sync=estimate needs a path whose metres do not come from the IMU itself; find the "
            "offset on another recording (motorcade sync), and state it in a manifest "
            "([imu] clock_offset_s = ...)"
        )
    found = synchronise(camera_poses.measurements.trajectory, recorded, imu.noise)
    return replace(imu, clock_offset_s=found.offset_s, clock_offset_sigma_s=found.offset_sigma_s)
