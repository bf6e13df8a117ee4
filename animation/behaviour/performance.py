"""An errand in time, as states and ways on the plane, and the poses that are made of it.

idle ── turn ── walk ── arrive ── turn ── act ── idle

A state is left for the first of those that follow it which the situation asks for: whoever has a
way to go turns towards it and walks, whoever has arrived turns to where it shall look and acts.

All segments are put together first and their feet are planted once, over all of them: a foot that
stands from one state into the next stands on one place. Where the next state has it stand elsewhere
it steps there, one foot after the other. `Timeline` makes no pose, so that crowds can try many
errands. Ways go over into one another by inertia, poses do so in `perform`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.behaviour import sources
from motorcade.animation.behaviour.actor import Actor, ClipLayer
from motorcade.animation.behaviour.sources import LookTarget
from motorcade.animation.blend import Inertialized, Shifted
from motorcade.animation.blend.transitions import PoseSource
from motorcade.animation.clip import Clip
from motorcade.animation.easing import FADE_S, smootherstep
from motorcade.animation.ik import find_stances, plant_feet
from motorcade.animation.ik.feet import segments
from motorcade.animation.place.walks import GroundPath, played, rigid, stances_along
from motorcade.animation.vectors import turn_z, wrapped
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, checked_number, checked_positive, frozen

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


# Poses go over within this time, in which both feet can step.
SWITCH_S = 0.5
# Feet nearer to where they shall stand than this share of the highest joint's height stay; a foot
# that moves by less in all of a clip stands.
NEAR = 0.01
# A ball as near to its height at rest as this share of the highest joint's height is on the ground.
TOUCHES = 0.003


@dataclass(frozen=True, eq=False)
class Performance:
    """What a character does, frame by frame.

    Fields:
        time_s: ``(F,)`` from 0.
        plane_T_character: Motor ``(F,)``, where it is, in the plane's metres.
        poses: Motor ``(F, J)``, local poses with planted feet.
        segments: the states that it goes through.
    """

    time_s: FloatArray
    plane_T_character: Motor
    poses: Motor
    segments: tuple[Segment, ...]


def perform(
    timeline: Timeline,
    lasts_s: float,
    rate_hz: float = 60.0,
    look_at: LookTarget | None = None,
    most_s: float = np.inf,
) -> Performance:
    """Make a timeline into poses with planted feet.

    Args:
        timeline: of an actor and its errand.
        lasts_s: until when, or until all of the errand is done where that is later.
        rate_hz: frames a second.
        look_at: what neck, head and eyes turn to, as far as they can.
        most_s: it ends by then, done or not: nobody sees what comes after footage ends.

    Raises:
        ValueError: a time or rate that is not positive, or something to look at for a character
            whose head nothing tells.
    """
    checked_positive(lasts_s, "perform(lasts_s)")
    checked_positive(rate_hz, "perform(rate_hz)")
    if not most_s > 0.0:
        raise ValueError(f"perform(most_s): expected a number above 0, got {most_s}")
    actor = timeline.actor
    end_s = min(max(lasts_s, timeline.done_s), most_s)
    time_s = np.arange(int(np.ceil(end_s * rate_hz)) + 1) / rate_hz
    way = timeline.at(time_s)
    poses, stances = _unplanted(timeline, time_s, way)
    own = Motor.from_rotor_translation(way.rotor, way.translation_m / actor.scale)
    if actor.legs:
        poses = plant_feet(
            actor.skeleton, time_s, poses, actor.legs, world_T_character=own, stances=stances
        )
    if look_at is not None:
        target = own.inverse().apply(look_at.at(time_s) / actor.scale)
        poses = actor.gaze.looking(poses, target, time_s)
    return Performance(time_s, way, poses, timeline.segments)


def foot_slides_m(actor: Actor, performance: Performance) -> list[tuple[float, float, float]]:
    """How far each foot goes on the ground while it is on it: (start s, end s, plane metres).

    On the ground is a foot whose ball is as low as it rests. It is told from the poses alone, not
    from where feet were planted. Of every such segment it is the farthest that the ball lies from
    the median of its places.
    """
    skeleton = actor.skeleton
    own = Motor.from_rotor_translation(
        performance.plane_T_character.rotor,
        performance.plane_T_character.translation_m / actor.scale,
    )
    world = own.reshape(-1, 1) @ skeleton.world(performance.poses)
    touches_m = TOUCHES * float(np.max(skeleton.rest_world.translation_m[:, 2]))
    slides = []
    for leg in actor.legs:
        ball = skeleton.index(leg.ball)
        at = world[:, ball].translation_m
        low = at[:, 2] <= skeleton.rest_world.translation_m[ball, 2] + touches_m
        for start, end in segments(low):
            places = at[start:end, :2]
            off = np.linalg.norm(places - np.median(places, axis=0), axis=1).max()
            slides.append(
                (
                    float(performance.time_s[start]),
                    float(performance.time_s[end - 1]),
                    actor.scale * float(off),
                )
            )
    return slides


def _unplanted(
    timeline: Timeline, time_s: FloatArray, way: Motor
) -> tuple[Motor, list[NDArray[np.bool_]]]:
    """Poses before feet are planted, and when each foot stands."""
    actor = timeline.actor
    poses = np.empty((len(time_s), len(actor.skeleton), 8))
    stances = [np.ones(len(time_s), dtype=bool) for _ in actor.legs]
    pose_source: PoseSource | None = None
    for segment, rows in zip(timeline.segments, timeline.rows(time_s), strict=True):
        if segment.state == "arrive":  # the walk goes on
            pass
        elif pose_source is None:
            pose_source = _source(actor, segment)
        else:
            pose_source = Inertialized(
                pose_source, _source(actor, segment), segment.start_s, SWITCH_S
            )
        assert pose_source is not None  # a timeline does not begin by arriving
        poses[rows] = rigid(pose_source, time_s[rows]).coefficients
        for number, standing in enumerate(_standing(actor, segment, time_s, rows)):
            stances[number][rows] = standing
    layered = _with_layers(timeline, time_s, Motor.normalize(poses))
    return _stepping(timeline, time_s, way, layered, stances), stances


def _source(actor: Actor, segment: Segment) -> PoseSource:
    """What a segment plays, on the timeline's clock."""
    if (
        segment.state == "walk"
        and actor.cycle is not None
        and isinstance(segment.way, sources.Along)
    ):
        walk = Shifted(played(actor.cycle, actor.standing, segment.way.pace), segment.start_s)
        return sources.Leaning(walk, segment.way, actor.skeleton.root)
    if segment.state == "act":
        clip = (actor.acts or {})[segment.clip].clip
        return Shifted(clip, segment.start_s, float(clip.time_s[0]))
    idle = replace(actor.idle, poses=actor.idle.poses.rigid)
    idling = Shifted(idle, segment.start_s, float(idle.time_s[0]))
    if isinstance(segment.way, sources.Turning):
        return sources.Stepping(idling, segment.way, actor.skeleton, actor.legs)
    return idling


def _standing(
    actor: Actor, segment: Segment, time_s: FloatArray, rows: slice
) -> list[NDArray[np.bool_]]:
    """When each foot stands ``(rows,)`` within a segment."""
    clock = time_s[rows] - segment.start_s
    if not len(clock):
        return [np.ones(0, dtype=bool) for _ in actor.legs]
    if isinstance(segment.way, sources.Along) and segment.state in ("walk", "arrive"):
        return _standing_on_the_way(actor, segment.way, time_s, rows)
    if isinstance(segment.way, sources.Turning) and segment.state == "turn":
        return [segment.way.swinging(k, clock) == 0.0 for k in range(len(actor.legs))]
    if segment.state != "act":
        return [np.ones(len(clock), dtype=bool) for _ in actor.legs]
    act = (actor.acts or {})[segment.clip]
    local = clock + act.clip.time_s[0]
    moved = act.motion.at(np.clip(local, act.clip.time_s[0], act.clip.time_s[-1] - 1e-9))
    world = moved.reshape(-1, 1) @ actor.skeleton.world(rigid(act.clip, local))
    near_m = _near_m(actor)
    standing = []
    for leg in actor.legs:
        at = world[:, actor.skeleton.index(leg.ball)].translation_m
        still = np.linalg.norm(np.ptp(at, axis=0)) < near_m or len(clock) < 3
        standing.append(np.ones(len(clock), bool) if still else find_stances(at, clock))
    return standing


def _standing_on_the_way(
    actor: Actor, way: sources.Along, time_s: FloatArray, rows: slice
) -> list[NDArray[np.bool_]]:
    """Of a walk from standing to standing, as `walk_along` finds it, at these frames."""
    assert actor.cycle is not None
    step = float(np.mean(np.diff(time_s)))
    first = time_s[rows.start] - way.start_s
    more = int(np.ceil(actor.cycle.duration_s / step))
    before = more + int(first / step)
    after = more + int((way.pace.done_s - (time_s[rows.stop - 1] - way.start_s)) / step)
    count = rows.stop - rows.start
    clock = first + step * np.arange(-before, count + max(after, more))
    poses = rigid(played(actor.cycle, actor.standing, way.pace), clock)
    stances = stances_along(actor.skeleton, actor.legs, poses, clock, way.pace)
    return [one[before : before + count] for one in stances]


def _with_layers(timeline: Timeline, time_s: FloatArray, poses: Motor) -> Motor:
    """Poses with the clips that lie over them while states last that they belong to."""
    for layer in timeline.actor.layers:
        for start, end in _spans(timeline, layer, float(time_s[-1])):
            within = (time_s >= start) & (time_s <= end)
            if not np.any(within):
                continue
            below = Clip("below", time_s, poses)
            clip = replace(layer.clip, poses=layer.clip.poses.rigid)
            over = Shifted(clip, start, float(clip.time_s[0]))
            reference = clip.poses.rigid[0] if layer.additive else None
            layered = sources.Layered(below, over, layer.mask, (start, end), FADE_S, reference)
            changed = poses.coefficients.copy()
            changed[within] = layered.at(time_s[within]).coefficients
            poses = Motor(changed)
    return poses


def _spans(timeline: Timeline, layer: ClipLayer, last_s: float) -> list[tuple[float, float]]:
    """From when to when a layer lies over the rest: neighbouring states that it belongs to."""
    joined: list[tuple[float, float]] = []
    for segment in timeline.segments:
        state = {"arrive": "walk", "turn": "idle"}.get(segment.state, segment.state)
        if layer.during not in (state, "always"):
            continue
        end = min(segment.end_s, last_s + FADE_S)
        if joined and joined[-1][1] == segment.start_s:
            joined[-1] = (joined[-1][0], end)
        else:
            joined.append((segment.start_s, end))
    return joined


def _stepping(
    timeline: Timeline,
    time_s: FloatArray,
    way: Motor,
    poses: Motor,
    stances: list[NDArray[np.bool_]],
) -> Motor:
    """Poses in which feet that a switch has stand elsewhere step there, one after the other.

    The stances are changed with them.
    """
    actor, half = timeline.actor, 0.5 * SWITCH_S
    own = Motor.from_rotor_translation(way.rotor, way.translation_m / actor.scale)
    world = own.reshape(-1, 1) @ actor.skeleton.world(poses)
    changed = poses.coefficients.copy()
    for before, now in pairwise(timeline.segments):
        if "act" not in (before.state, now.state) or now.start_s + SWITCH_S > time_s[-1]:
            continue
        start, end = np.searchsorted(time_s, [now.start_s, now.start_s + SWITCH_S])
        begun = actor.skeleton.world(rigid(_source(actor, now), now.start_s))
        goal = (own[start].reshape(1) @ begun).translation_m
        for number, leg in enumerate(actor.legs[:2]):
            ankle, ball = (world[:, joint].translation_m for joint in leg.foot(actor.skeleton))
            standing, last = stances[number], max(start - 1, 0)
            off = goal[actor.skeleton.index(leg.ball)] - ball[last]
            if not standing[last] or np.linalg.norm(off) <= _near_m(actor):
                continue
            through = (time_s[start:end] - now.start_s) / half - number
            standing[start:end] = (through < 0.0) | (through >= 1.0)
            rows = np.flatnonzero(through >= 0.0) + start
            share = smootherstep(through[through >= 0.0])[:, None]
            places = ankle[rows[0]] + share * (ankle[end] - ankle[rows[0]])
            stepped = sources.lifted(
                actor.skeleton,
                Motor(changed[rows]),
                leg,
                np.clip(through[through >= 0.0], 0.0, 1.0),
                own[rows].inverse().apply(places),
            )
            changed[rows] = stepped.coefficients
    return Motor(changed)


def _near_m(actor: Actor) -> float:
    return NEAR * float(np.max(actor.skeleton.rest_world.translation_m[:, 2]))
