"""Times and transforms as USD has them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.pipeline.runs import Shown


class UsdClock:
    """Stamps of a run's frames as time codes.

    Attributes:
        time_ns: (N,) of the frames within the path.
        codes: (N,) what USD calls these times.
        rate_hz: codes a second.
        since_start_s: (N,) on the characters' clock, which begins with the first frame.
    """

    def __init__(self, shown: Shown) -> None:
        every: IntArray = shown.recording.frames.time_ns
        first_ns, last_ns = shown.path.time_ns[[0, -1]]
        self.time_ns = every[(first_ns <= every) & (every <= last_ns)]
        usual_s = 1e-9 * float(np.median(np.diff(every))) if len(every) > 1 else 1.0
        self.rate_hz = float(round(1.0 / usual_s)) or 1.0 / usual_s
        self.codes: FloatArray = 1e-9 * self.rate_hz * (self.time_ns - self.time_ns[0])
        self.since_start_s: FloatArray = 1e-9 * (self.time_ns - every[0])


def as_matrix(matrix: FloatArray) -> Any:
    """A transform ``(4, 4)`` as USD has it: rows for columns."""
    from pxr import Gf

    return Gf.Matrix4d(matrix.T.tolist())


def identifiers(names: Iterable[str]) -> list[str]:
    """What USD may call things of these names, each once."""
    from pxr import Tf

    made: list[str] = []
    for name in names:
        own = Tf.MakeValidIdentifier(name)
        while own in made:
            own += "_"
        made.append(own)
    return made
