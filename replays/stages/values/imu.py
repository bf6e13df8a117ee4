"""The inertial stream that a run uses: recorded, simulated for an experiment, or none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.ga import Motor

if TYPE_CHECKING:
    from motorcade.replays.io.recording import Recording

ImuOrigin = Literal["recorded", "reference", "none"]


@dataclass(frozen=True, eq=False)
class UsedImu:
    """What inertial stream there is, its noise model, where the camera sits on it, its origin.

    Fields:
        simulated: the stream where an experiment simulates one. The recording's own is not stored
            twice; `stream` gives the one or the other.
        noise: as the sensor's sheet or calibration says.
        imu_T_camera: camera coordinates to the IMU's.
        origin: recorded, simulated along the reference (the ground truth), or none; where there is
            none, noise and extrinsics are placeholders.
        absent: why there is none, as the end of a sentence.
        clock_offset_s: taken off the recorded stamps (what the IMU's clock showed at an event
            minus what the camera's did).
        clock_offset_sigma_s: its deviation; None where the offset was not estimated.
    """

    simulated: ImuStream | None
    noise: ImuNoise
    imu_T_camera: Motor
    origin: ImuOrigin
    absent: str = ""
    clock_offset_s: float = 0.0
    clock_offset_sigma_s: float | None = None

    @classmethod
    def none(cls, why: str) -> UsedImu:
        """No inertial stream, and why there is none."""
        return cls(None, ADIS16448, Motor.identity(), "none", why)

    def stream(self, recording: Recording) -> ImuStream:
        """The stream on the camera's clock; `recording` is the one that the stage was given.

        Raises:
            ValueError: there is none, or another recording was given, without a stream.
        """
        if self.origin == "none":
            raise ValueError(f"{recording.name}: expected an IMU, but {self.absent}")
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
