"""Inertial streams of a run: recorded, simulated for an experiment, or none; and what they told.

What an IMU inside visual SLAM told and when, and how the filter recovered from a wrong start.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray

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


InertialFrameState = Literal["initialising", "visual", "tracking", "inertial", "lost"]


@dataclass(frozen=True, eq=False)
class InertialHistory:
    """Every frame's state, and what the map was taken to metres by.

    Fields:
        time_ns: ``(f,)`` stamps of the frames that were tracked.
        states: theirs: "initialising" without a map, "visual" before it had metres, "tracking" by
            images and IMU, "inertial" by the IMU alone, "lost" where that was too long ago.
        metric_from_ns: stamp of the frame at which the map got metres.
        metres_a_unit, scale_sigma: of the map's own unit at that frame, and the relative deviation.
        gravity_direction: ``(3,)`` unit vector along gravity in the axes of the map's first camera.
        tilt_sigma_rad: its deviation about each of two axes.
        readout_s: of the rolling shutter that was reckoned with; 0 for none.

    >>> import numpy as np
    >>> from motorcade.replays.stages.values.inertial import InertialHistory
    >>> stamps = 50_000_000 * np.arange(4)
    >>> told = InertialHistory(stamps, ("initialising", "visual", "tracking", "tracking"),
    ...     metric_from_ns=100_000_000, metres_a_unit=2.1, scale_sigma=0.02,
    ...     gravity_direction=np.array([0.0, 1.0, 0.0]), tilt_sigma_rad=0.003)
    >>> told.metric_from_s, told.frames_in_state["tracking"]
    (0.1, 2)
    """

    time_ns: IntArray
    states: tuple[InertialFrameState, ...]
    metric_from_ns: int
    metres_a_unit: float
    scale_sigma: float
    gravity_direction: FloatArray
    tilt_sigma_rad: float
    readout_s: float = 0.0

    @property
    def metric_from_s(self) -> float:
        """Seconds after the first frame at which the map got metres."""
        return 1e-9 * (self.metric_from_ns - int(self.time_ns[0]))

    @property
    def frames_in_state(self) -> dict[str, int]:
        """How many frames were in each state that there was."""
        return dict(Counter(self.states))

    def as_dict(self) -> dict[str, Any]:
        """Its figures, JSON-ready; of the states where each begins."""
        first_ns, row, spans = int(self.time_ns[0]), 0, []
        for state, run in groupby(self.states):
            spans.append({"start_s": 1e-9 * (int(self.time_ns[row]) - first_ns), "state": state})
            row += len(list(run))
        return {
            "metric_from_s": self.metric_from_s,
            "metres_a_unit": self.metres_a_unit,
            "scale_sigma": self.scale_sigma,
            "gravity_direction": self.gravity_direction.tolist(),
            "tilt_sigma_deg": float(np.rad2deg(self.tilt_sigma_rad)),
            "readout_s": self.readout_s,
            "frames_in_state": self.frames_in_state,
            "states": spans,
        }


@dataclass(frozen=True, eq=False)
class Convergence:
    """Tilt error ``(N,)`` in degrees over seconds after a start `initial_tilt_deg` wrong.

    `settled_s` is when it falls below a tenth of the start for good, None if it never does;
    `judged_by` names what the tilt was compared with. There are no errors where no filter ran.
    """

    initial_tilt_deg: float
    time_s: FloatArray
    tilt_error_deg: FloatArray
    settled_s: float | None
    judged_by: str
