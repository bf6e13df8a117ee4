"""What the page is made of: every suite, or its parts, at sizes that fit into one sitting.

`make bench SUITE=…` measures a suite at its full size, which takes hours for some; the page holds
the same tables over fewer seeds, rooms or frames, and says so. A job that fails, or takes longer
than it may, costs itself alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

__all__ = ["JOBS", "MINUTES", "Job"]

MINUTES = 25.0
"""All jobs together end within this; what has not begun by then is left out, and named."""


@dataclass(frozen=True)
class Job:
    """A suite, or a part of one, as the page has it.

    Fields:
        suite: name of a suite.
        limit_s: it is ended after so many seconds.
        part: name of a part, where the suite has parts that can be measured apart.
        sizes: arguments of the function that measures, where its own defaults take long.
    """

    suite: str
    limit_s: float
    part: str | None = None
    sizes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """As it is told of."""
        return self.suite if self.part is None else f"{self.suite}, {self.part}"


_FLIGHTS = ("V2_02", "MH_05")
_WAYS = ("auto", "scipy", "Savitzky", "1€", "filterpy")

JOBS: tuple[Job, ...] = (
    Job("demo", 240.0),
    Job("stages", 240.0),
    Job("accuracy", 240.0),
    Job("blend", 150.0),
    Job("render", 120.0),
    Job("smoothers", 240.0, sizes={"on": _FLIGHTS, "ways": _WAYS}),
    Job("animation", 120.0),
    Job("table3", 150.0),
    Job("programs", 150.0),
    Job("compiler", 60.0),
    Job("conversions", 120.0),
    Job("smooth", 180.0, sizes={"rounds": 3}),
    Job("smoother_speed", 120.0, sizes={"poses": 20_000}),
    Job("live", 150.0),
    Job("orders", 150.0),
    Job("lag", 180.0),
    Job("tracking", 60.0, "markers"),
    Job("tracking", 90.0, "recall"),
    Job("tracking", 60.0, "flips"),
    Job("tracking", 90.0, "map"),
    Job("tracking", 60.0, "board"),
    Job("tracking", 120.0, "photometric"),
    Job("fusion", 60.0, "simulator"),
    Job("fusion", 180.0, "flights", {"seeds": 3}),
    Job("fusion", 90.0, "offsets"),
    Job("fusion", 60.0, "tags"),
    Job("fusion", 90.0, "orientation"),
    Job("fusion", 120.0, "speed"),
    Job("fusion", 240.0, "visual inertial"),
    Job("fusion", 300.0, "inertial slam", {"beside": False}),
    Job("view", 240.0),
    Job("memory", 240.0, sizes={"frames": 3_000, "stream_s": 1800.0}),
    Job("slam", 300.0, sizes={"switches": ("",)}),
)
"""What is quoted elsewhere comes first, and what takes minutes last."""
