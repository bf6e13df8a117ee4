"""What an IMU inside visual SLAM told of a recording, and when."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Literal

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray

InertialFrameState = Literal["initialising", "visual", "tracking", "inertial", "lost"]


@dataclass(frozen=True, eq=False)
class InertialHistory:
    """Every frame's state, and what the map was taken to metres by.

    Fields:
        time_ns: ``(f,)`` stamps of the frames that were tracked.
        states: theirs: "initialising" without a map, "visual" before it had metres, "tracking" by
            pictures and IMU, "inertial" by the IMU alone, "lost" where that was too long ago.
        metric_from_ns: stamp of the frame at which the map got metres.
        metres_a_unit, scale_sigma: of the map's own unit at that frame, and the relative deviation.
        gravity_direction: ``(3,)`` unit vector along gravity in the axes of the map's first camera.
        tilt_sigma_rad: its deviation about each of two axes.
        readout_s: of the rolling shutter that was reckoned with; 0 for none.

    >>> import numpy as np
    >>> from motorcade.replays.stages.values.inertial_history import InertialHistory
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
