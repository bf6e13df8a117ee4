"""What a character may do and in which order: the states, and the errand that leads through them.

    idle ── turn ── walk ── arrive ── turn ── act ── idle

A state is left for the first of those that follow it which the situation asks for: whoever has a
way to go turns towards it and walks, whoever has arrived turns to where it shall look and acts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np

from motorcade.ga.arrays import FloatArray, checked_floats, checked_number, frozen

State = Literal["idle", "turn", "walk", "arrive", "act"]
"""What a character does at a time; `FOLLOWS` says what may come next."""

FOLLOWS: Mapping[State, tuple[State, ...]] = MappingProxyType(
    {
        "idle": ("turn", "walk", "act"),
        "turn": ("walk", "act", "idle"),
        "walk": ("arrive",),
        "arrive": ("turn", "act", "idle"),
        "act": ("act", "idle"),
    }
)
# Off by less than this a character begins to walk, or acts, without turning first.
TURN_AT_RAD = np.deg2rad(25.0)


@dataclass(frozen=True, eq=False)
class Errand:
    """What a character is asked to do.

    Args:
        start_m: ``(2,)`` where it stands at first, x and y of the plane, metres.
        heading_rad: where it looks at first, from the plane's x towards its y.
        path_m: ``(P, 2)`` points that it walks through from its start, which is the first of them;
            ``(0, 2)`` for a character that stays.
        facing_rad: where it looks once it has arrived; None leaves it as it comes.
        acts: names of what it does there, one after another.
        waits_s: how long it idles first.

    Raises:
        ValueError: numbers that are not finite, one point alone, a path that begins elsewhere, or
            a negative time.
        TypeError: an angle or a time that is no number.

    >>> from motorcade.animation.behaviour import Errand
    >>> Errand((0.0, 0.0), path_m=[(0.0, 0.0), (1.0, 0.5)], acts=("wave",)).acts
    ('wave',)
    """

    start_m: FloatArray
    heading_rad: float = 0.0
    path_m: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    facing_rad: float | None = None
    acts: tuple[str, ...] = ()
    waits_s: float = 0.0

    def __post_init__(self) -> None:
        start = checked_floats(self.start_m, "Errand.start_m", (2,))
        path = checked_floats(self.path_m, "Errand.path_m", (2,))
        if start.shape != (2,) or path.ndim != 2 or len(path) == 1:
            raise ValueError(
                "Errand: expected start_m (2,) and path_m (P, 2), P at least 2 or none, got shapes "
                f"{start.shape} and {path.shape}"
            )
        if len(path) and not np.allclose(path[0], start, rtol=0.0, atol=1e-9):
            raise ValueError(f"Errand.path_m: expected to begin at {start}, got {path[0]}")
        for name in ("heading_rad", "facing_rad", "waits_s"):
            value = getattr(self, name)
            if value is not None and not np.isfinite(checked_number(value, f"Errand.{name}")):
                raise ValueError(f"Errand.{name}: expected a finite number, got {value}")
        if self.waits_s < 0.0:
            raise ValueError(f"Errand.waits_s: expected 0 or more seconds, got {self.waits_s}")
        object.__setattr__(self, "start_m", frozen(start))
        object.__setattr__(self, "path_m", frozen(path))


@dataclass(frozen=True)
class Situation:
    """What decides on the next state.

    Fields:
        waits: whether it is to wait still.
        way_left: whether it has not come to its goal.
        off_rad: from where it looks to where it shall.
        acts_left: how much there is to do at the goal.
    """

    waits: bool
    way_left: bool
    off_rad: float
    acts_left: int


def next_state(state: State | None, now: Situation) -> State:
    """The state that follows one that has ended; None before the first."""
    if now.waits:
        return "idle"
    if state == "walk":
        return "arrive"
    if abs(now.off_rad) > TURN_AT_RAD and state not in ("turn", "act"):
        return "turn"
    if now.way_left:
        return "walk"
    return "act" if now.acts_left else "idle"


def wrapped(angle_rad: float) -> float:
    """The same angle from −π to π."""
    return float((angle_rad + np.pi) % (2.0 * np.pi) - np.pi)
