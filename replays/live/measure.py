"""What live tracking achieves, measured while it runs: frames, latency and registration.

Each figure is of the last `WINDOW_S` seconds, so that what is shown is what is so now.
"""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from motorcade.replays.live.tracker import LivePose

WINDOW_S = 5.0
_MOST = 4096


@dataclass
class LiveMeasure:
    """Counts what was tracked and drawn, on a clock of seconds that only grow.

    >>> from motorcade.replays.live.measure import LiveMeasure
    >>> seconds = iter(range(100))
    >>> measure = LiveMeasure(clock=lambda: 0.25 * next(seconds))
    >>> for latency_s in (0.04, 0.05, 0.06):
    ...     measure.drawn(latency_s)
    >>> figures = measure.figures()
    >>> figures["frames_drawn_s"], figures["latency_p50_ms"], figures["registration_px"]
    (4.0, 50.0, None)
    """

    clock: Callable[[], float] = time.monotonic
    states: Counter[str] = field(default_factory=Counter)
    _drawn: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_MOST))
    _off: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_MOST))

    def tracked(self, pose: LivePose) -> None:
        """A frame's pose is known, or is known to be missing."""
        self.states[pose.state] += 1
        now = self.clock()
        self._off.extend((now, float(off)) for off in pose.held_out_px)

    def drawn(self, latency_s: float) -> None:
        """A frame was drawn with its pose, so long after it was taken."""
        self._drawn.append((self.clock(), latency_s))

    def figures(self) -> dict[str, Any]:
        """Figures of the last seconds; None for what there is none of.

        `registration_px` is the median distance of corners from where a pose that they had no
        part in has them; `latency_…_ms` from capture to drawn.
        """
        now = self.clock()
        for kept in (self._drawn, self._off):
            while kept and now - kept[0][0] > WINDOW_S:
                kept.popleft()
        latency = np.array([latency_s for _, latency_s in self._drawn])
        off = np.array([off_px for _, off_px in self._off])
        span_s = self._drawn[-1][0] - self._drawn[0][0] if len(self._drawn) > 1 else 0.0
        return {
            "frames_drawn_s": round((len(latency) - 1) / span_s, 1) if span_s > 0.0 else None,
            "latency_p50_ms": _percentile(1e3 * latency, 50.0),
            "latency_p95_ms": _percentile(1e3 * latency, 95.0),
            "registration_px": _percentile(off, 50.0),
            "registration_p95_px": _percentile(off, 95.0),
        }


def _percentile(values: np.ndarray[Any, np.dtype[np.float64]], percent: float) -> float | None:
    return round(float(np.percentile(values, percent)), 3) if len(values) else None
