"""An errand in time: which state from when to when, and where the character is meanwhile.

No pose is made here, so that crowds can try many errands. Ways go over into one another by inertia,
poses do so in `perform`.

What a character may do and in which order: the states, and the errand that leads through them.

idle ── turn ── walk ── arrive ── turn ── act ── idle

A state is left for the first of those that follow it which the situation asks for: whoever has a
way to go turns towards it and walks, whoever has arrived turns to where it shall look and acts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.behaviour import sources
from motorcade.animation.behaviour.actor import Actor
from motorcade.animation.blend import Inertialized, PoseSource
from motorcade.animation.place.walks import GroundPath
from motorcade.animation.vectors import turn_z, wrapped
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, checked_number, frozen

# How long what one way leaves to the next takes to die away.
EASED_S = 0.3
# Errands that take longer are mistaken: a small character on a long way.
LONGEST_S = 600.0

Way = sources.Still | sources.Along | sources.Turning | sources.Travelling


@dataclass(frozen=True, eq=False)
class Segment:
    """A state from one time to another; the last one lasts for good.

    Fields:
        state: what it is.
        clip: name of what is played.
        start_s, end_s: from when to when.
        way: where the character is meanwhile, before inertia.
    """

    state: State
    clip: str
    start_s: float
    end_s: float
    way: Way


class Timeline:
    """What an errand makes of an actor.

    Raises:
        ValueError: an act that the actor does not have, a path for one without a gait, or an errand
            that takes more than ten minutes.
    """

    def __init__(self, actor: Actor, errand: Errand) -> None:
        self.actor, self.errand = actor, errand
        if len(errand.path_m):  # the way is no shorter than this, and dear to curve
            straight_m = np.linalg.norm(np.diff(errand.path_m, axis=0), axis=1).sum()
            self._check_lasts(actor.pace(float(straight_m)).done_s)
        self.segments: tuple[Segment, ...] = self._led_through()
        self._check_lasts(self.done_s)

    def _check_lasts(self, done_s: float) -> None:
        if not done_s <= LONGEST_S:
            raise ValueError(
                f"Errand: expected '{self.actor.name}' done within {LONGEST_S:g} s, got "
                f"{done_s:.0f} s; wait and do less, or go a shorter way at that height"
            )

    @property
    def done_s(self) -> float:
        """When all is done, and it only idles."""
        return self.segments[-1].start_s

    @cached_property
    def ways(self) -> tuple[PoseSource, ...]:
        """The way of each segment, as it goes on from the one before; Motor ``(*, 1)``."""
        pose_sources: list[PoseSource] = [self.segments[0].way]
        for before, now in zip(self.segments, self.segments[1:], strict=False):
            if now.way is before.way:
                pose_sources.append(pose_sources[-1])
            else:
                pose_sources.append(Inertialized(pose_sources[-1], now.way, now.start_s, EASED_S))
        return tuple(pose_sources)

    def at(self, time_s: ArrayLike) -> Motor:
        """``plane_T_character`` ``(F,)`` at times ``(F,)``."""
        clock = np.asarray(time_s, dtype=np.float64)
        coefficients = np.empty((len(clock), 8))
        for way, rows in zip(self.ways, self.rows(clock), strict=True):
            if rows.stop > rows.start:
                moved = way.at(clock[rows])
                coefficients[rows] = moved.coefficients[:, 0]
        return Motor.normalize(coefficients)

    def rows(self, time_s: FloatArray) -> list[slice]:
        """Which of rising times ``(F,)`` lie in each segment."""
        starts = [-np.inf, *(one.start_s for one in self.segments[1:])]
        first = np.searchsorted(time_s, starts, side="left")
        return [
            slice(int(a), int(b)) for a, b in zip(first, [*first[1:], len(time_s)], strict=True)
        ]

    def reach_m(self, time_s: FloatArray) -> FloatArray:
        """Radius ``(F,)`` of the upright cylinder about its place that holds it, plane metres."""
        reach = np.zeros(len(time_s))
        radii = [self._radius_m(one) for one in self.segments]
        for number, rows in enumerate(self.rows(time_s)):
            reach[rows] = max(radii[max(number - 1, 0) : number + 1])  # what blends out reaches on
        return reach

    def _radius_m(self, segment: Segment) -> float:
        kind = {"act": segment.clip, "idle": "idle", "turn": "idle"}.get(segment.state, "walk")
        return self.actor.radii_m[segment.state == "act", kind]

    def _led_through(self) -> tuple[Segment, ...]:
        """The state graph, from state to state until nothing is left but to idle."""
        actor, errand = self.actor, self.errand
        path = GroundPath(errand.path_m) if len(errand.path_m) else None
        pace = None if path is None else actor.pace(path.length_m)
        x, y = errand.start_m
        here = Motor.from_rotor_translation(turn_z(errand.heading_rad), np.array([x, y, 0.0]))
        looks, clock, waits = errand.heading_rad, 0.0, errand.waits_s
        acts, known = list(errand.acts), actor.acts or {}
        state: State | None = None
        way: Way = sources.Still(here)
        segments: list[Segment] = []
        while True:
            wish = errand.facing_rad
            if path is not None and pace is not None:
                wish = float(path.at(0.0)[1])
            off = 0.0 if wish is None else float(wrapped(wish - looks))
            state = next_state(state, Situation(waits > 0.0, path is not None, off, len(acts)))
            name, lasts = actor.idle.name, waits
            if state == "turn":
                way = sources.Turning(here, off, clock)
                lasts, looks = way.lasts_s, looks + off
            elif state == "walk" and path is not None and pace is not None:
                way = sources.Along(
                    path, pace, actor.scale, clock, actor.size * sources.GRAVITY_M_S2
                )
                lasts, name = pace.left_s, getattr(actor.cycle, "name", "")
            elif state == "arrive" and path is not None and pace is not None:
                lasts, name = pace.done_s - pace.left_s, getattr(actor.cycle, "name", "")
                looks, path = float(path.at(path.length_m)[1]), None
            elif state == "act":
                name = acts.pop(0)
                if name not in known:
                    listed = ", ".join(map(repr, known)) or "none"
                    raise ValueError(f"Errand.acts: expected some of {listed}, got {name!r}")
                way, lasts = sources.Travelling(here, known[name].motion, actor.scale, clock), 0.0
                lasts = known[name].clip.duration_s
            elif state == "idle":
                way = sources.Still(here)
                if waits <= 0.0:
                    segments.append(Segment(state, name, clock, np.inf, way))
                    return tuple(segments)
                waits = 0.0
            segments.append(Segment(state, name, clock, clock + lasts, way))
            clock += lasts
            here = way.at(clock)[..., 0]
            if state == "act":
                looks = float(_heading(here))


def _heading(pose: Motor) -> FloatArray:
    ahead = pose.rotor.apply(np.array([1.0, 0.0, 0.0]))
    return np.asarray(np.arctan2(ahead[..., 1], ahead[..., 0]))


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
