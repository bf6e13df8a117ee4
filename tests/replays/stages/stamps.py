"""Frames of a recording whose images no test looks at."""

from __future__ import annotations

from collections.abc import Iterator

from motorcade.ga.arrays import IntArray
from motorcade.replays.io.recording import Frame


class Stamps:
    """Frames of which nothing but the stamps is asked."""

    def __init__(self, time_ns: IntArray) -> None:
        self.time_ns = time_ns

    def __len__(self) -> int:
        return len(self.time_ns)

    def __iter__(self) -> Iterator[Frame]:
        return iter(())
