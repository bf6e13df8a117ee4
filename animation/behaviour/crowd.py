"""Characters that do not walk through each other: they wait, or go round, or say that they cannot.

Bodies are upright cylinders that hold all that a character does in a state (`Actor.radii_m`), so
that no arm of one meets another. Plans are made one character after the other, in the order given
and then in others, each around those before it, who keep to theirs; where no order serves, whoever
finds no way stays where it is, and those that are still to plan are taken to stand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from motorcade.animation.behaviour.actor import Actor
from motorcade.animation.behaviour.performance import Errand, Performance, Timeline
from motorcade.animation.place.walks import GroundPath
from motorcade.ga.arrays import FloatArray

MOST = 8
"""Characters in one crowd."""
# Times at which distances are looked at, and how finely and how long waits are tried.
RATE_HZ, WAIT_STEP_S, LONGEST_WAIT_S = 20.0, 0.25, 30.0
# Ways round: how far aside, in sums of both radii, on either side; how many bends, one after the
# other; and how many ways are gone on with.
ASIDE, BENDS, KEPT = (1.1, 1.4, 1.9), 3, 6
# Of a skin, in measuring.
POINTS = 700


@dataclass(frozen=True, eq=False)
class Crowd:
    """What everybody does, and what became of the wishes.

    Fields:
        timelines: one for each errand, in their order.
        notes: by character, how it keeps out of the others' way; "" where it does as it was asked.
        stays: names of those who cannot do as they were asked.
        least_gap_m: between the cylinders of any two, at any time; infinite for one alone.
    """

    timelines: tuple[Timeline, ...]
    notes: tuple[str, ...]
    stays: tuple[str, ...]
    least_gap_m: float


def keep_apart(cast: Sequence[tuple[Actor, Errand]], gap_m: float = 0.0) -> Crowd:
    """Plan errands so that no two bodies come nearer than a gap.

    Args:
        cast: actors with their errands; earlier ones have the right of way.
        gap_m: that is kept, in the plane's metres.

    Raises:
        ValueError: none or more than 8 characters, a negative gap, or two that stand in each
            other at the start.
    """
    if not 1 <= len(cast) <= MOST:
        raise ValueError(f"keep_apart(cast): expected 1 to {MOST} characters, got {len(cast)}")
    if not (np.isfinite(gap_m) and gap_m >= 0.0):
        raise ValueError(f"keep_apart(gap_m): expected 0 or more metres, got {gap_m}")
    wanted = [Timeline(actor, errand) for actor, errand in cast]
    _refuse_overlap(wanted, gap_m)
    count = len(cast)
    for turn in range(count):
        order = [(turn + k) % count for k in range(count)]
        planned = _in_order(wanted, order, gap_m, resting=False)
        if all(one is not None for one in planned.values()):
            break
    else:
        planned = _in_order(wanted, list(range(count)), gap_m, resting=True)
    timelines, notes, stays = [], [], []
    for number, (actor, errand) in enumerate(cast):
        timeline = planned[number]
        if timeline is None:
            stays.append(actor.name)
            notes.append(_why_it_stays(number, wanted, gap_m))
            timeline = _staying(wanted[number])
        else:
            notes.append(_note(errand, timeline.errand))
        timelines.append(timeline)
    return Crowd(tuple(timelines), tuple(notes), tuple(stays), _least_gap(timelines))


def closest_m(performances: Sequence[tuple[Actor, Performance]]) -> float:
    """The least distance between any two bodies at any time, in the plane's metres.

    It is measured between points of their skins (see `Actor.skin_m`), some 700 each: skins may be
    nearer by as much as points are apart, 3 % of the height. Who is done first stays as it is.
    Infinite for one alone. Frames in which boxes about two bodies are farther apart than others
    have come are not looked into.
    """
    if len(performances) < 2:
        return float("inf")
    skins = [_skin_m(*one) for one in performances]
    least_m = float("inf")
    for first_skin, other in combinations(skins, 2):
        rows = np.arange(max(len(first_skin), len(other)))
        first, second = (np.minimum(rows, len(skin) - 1) for skin in (first_skin, other))
        low, high = (
            np.stack([f(first_skin, axis=1)[first], f(other, axis=1)[second]])
            for f in (np.min, np.max)
        )
        gaps = np.maximum(low - high[::-1], 0.0).max(axis=0)
        apart = np.linalg.norm(gaps, axis=1)
        for row in np.argsort(apart):
            if apart[row] >= least_m:
                break
            least_m = min(least_m, _nearest_m(first_skin[first[row]], other[second[row]]))
    return least_m


def _skin_m(actor: Actor, performance: Performance) -> FloatArray:
    """Points ``(F, P, 3)`` of a skin on the plane."""
    way = performance.plane_T_character.reshape(-1, 1)
    return way.apply(actor.scale * actor.skin_m(performance.poses, POINTS))


def _nearest_m(value: FloatArray, other: FloatArray) -> float:
    """Between two clouds ``(P, 3)``; points that cannot be the nearest are left out first."""
    first = value[np.argmin(_from_box_m(value, other))]
    second = other[np.argmin(np.linalg.norm(other - first, axis=1))]
    most = float(np.linalg.norm(value - second, axis=1).min())
    value = value[_from_box_m(value, other) <= most]
    other = other[_from_box_m(other, value) <= most]
    return float(np.sqrt(np.sum((value[:, None] - other) ** 2, axis=-1).min()))


def _from_box_m(points: FloatArray, about: FloatArray) -> FloatArray:
    """Of each point ``(P, 3)`` to the box that holds others."""
    inside = np.clip(points, about.min(axis=0), about.max(axis=0))
    return np.asarray(np.linalg.norm(points - inside, axis=1))


@dataclass(frozen=True, eq=False)
class _Track:
    """Places ``(F, 2)`` and radii ``(F,)`` at `RATE_HZ`; the last ones hold for good."""

    at_m: FloatArray
    radius_m: FloatArray
    moves_s: float

    @classmethod
    def of(cls, timeline: Timeline) -> _Track:
        time_s = np.arange(int(np.ceil((timeline.done_s + 1.0) * RATE_HZ)) + 1) / RATE_HZ
        moved = timeline.at(time_s).translation_m[:, :2]
        return cls(moved, timeline.reach_m(time_s), timeline.errand.waits_s)

    def lasting(self, count: int, late: int = 0) -> tuple[FloatArray, FloatArray]:
        """The same over `count` frames, begun so many frames later."""
        rows = np.clip(np.arange(count) - late, 0, len(self.at_m) - 1)
        return self.at_m[rows], self.radius_m[rows]


def _gaps(mine: _Track, other: _Track, late: int = 0) -> FloatArray:
    """Between two cylinders at every frame, one of them begun later."""
    count = max(len(mine.at_m) + late, len(other.at_m))
    (a, wide), (b, broad) = mine.lasting(count, late), other.lasting(count)
    return np.asarray(np.linalg.norm(a - b, axis=1) - wide - broad)


def _least_gap(timelines: Sequence[Timeline]) -> float:
    tracks = [_Track.of(one) for one in timelines]
    pairs = [(a, b) for k, a in enumerate(tracks) for b in tracks[k + 1 :]]
    return min((float(_gaps(a, b).min()) for a, b in pairs), default=np.inf)


def _refuse_overlap(wanted: Sequence[Timeline], gap_m: float) -> None:
    tracks = [_Track.of(_staying(one)) for one in wanted]
    for k, track in enumerate(tracks):
        for number, other in enumerate(tracks[k + 1 :], k + 1):
            gap = float(_gaps(track, other).min())
            if gap < gap_m:
                names = wanted[k].actor.name, wanted[number].actor.name
                need = np.linalg.norm(track.at_m[0] - other.at_m[0]) + gap_m - gap
                raise ValueError(
                    f"'{names[0]}' and '{names[1]}' stand in each other at the start: expected "
                    f"them {need:.3g} m apart or more, got "
                    f"{np.linalg.norm(track.at_m[0] - other.at_m[0]):.3g} m"
                )


def _in_order(
    wanted: Sequence[Timeline], order: Sequence[int], gap_m: float, *, resting: bool
) -> dict[int, Timeline | None]:
    """A plan for each, one after the other; those still to plan stand, or are not there."""
    planned: dict[int, Timeline | None] = {}
    for position, number in enumerate(order):
        others = [_Track.of(planned[k] or _staying(wanted[k])) for k in order[:position]]
        if resting:
            others += [_Track.of(_staying(wanted[k])) for k in order[position + 1 :]]
        planned[number] = _around(wanted[number], others, gap_m)
        if planned[number] is None and not resting:
            return planned
    return planned


def _around(me: Timeline, others: Sequence[_Track], gap_m: float) -> Timeline | None:
    """The plan that is done first and keeps clear; None where none was found."""
    if not others:
        return me
    tried = [(me, _Track.of(me))]
    if any(_rest_gap(tried[0][1], other) < gap_m for other in others):
        return None  # however it goes, it would rest in another
    for _ in range(BENDS):
        best: Timeline | None = None
        further: list[tuple[Timeline, _Track]] = []
        for candidate, track in tried:
            late = _first_wait(track, others, gap_m)
            if late is not None and (best is None or candidate.done_s + late < best.done_s):
                waiting = replace(candidate.errand, waits_s=candidate.errand.waits_s + late)
                best = Timeline(candidate.actor, waiting) if late else candidate
            if late != 0.0:
                further += _ways_round(candidate, track, others, gap_m)
        further.sort(key=lambda pair: pair[0].done_s)
        clear = (one for one, track in further if _clears(track, others, gap_m))
        round_it = next(clear, None)
        if round_it is not None and (best is None or round_it.done_s < best.done_s):
            return round_it
        if best is not None:
            return best
        tried = further[:KEPT]
    return None


def _clears(track: _Track, others: Sequence[_Track], gap_m: float, late: int = 0) -> bool:
    return all(float(_gaps(track, other, late).min()) >= gap_m for other in others)


def _rest_gap(mine: _Track, other: _Track) -> float:
    """Between two cylinders once both have come to rest."""
    away = np.linalg.norm(mine.at_m[-1] - other.at_m[-1])
    return float(away - mine.radius_m[-1] - other.radius_m[-1])


def _first_wait(track: _Track, others: Sequence[_Track], gap_m: float) -> float | None:
    """The least time that it must wait at its start to keep clear from then on; None for never."""
    steps = int(WAIT_STEP_S * RATE_HZ)
    for late in range(0, int(LONGEST_WAIT_S * RATE_HZ) + 1, steps):
        if _clears(track, others, gap_m, late):
            return late / RATE_HZ
    return None


def _ways_round(
    me: Timeline, track: _Track, others: Sequence[_Track], gap_m: float
) -> list[tuple[Timeline, _Track]]:
    """Ways with one bend more, past where it first comes too near."""
    if not len(me.errand.path_m):
        return []
    near = []
    for other in others:
        below = np.flatnonzero(_gaps(track, other) < gap_m)
        if below.size:
            near.append((int(below[0]), int(below[-1]), other))
    if not near:
        return []
    first, last, other = min(near, key=lambda meeting: meeting[0])
    row = min((first + last) // 2, len(track.at_m) - 1)
    place = other.at_m[min(row, len(other.at_m) - 1)]
    wide = track.radius_m[row] + other.radius_m[min(row, len(other.radius_m) - 1)] + gap_m
    path = GroundPath(me.errand.path_m)
    along = np.linspace(0.0, path.length_m, max(16, int(8.0 * path.length_m / wide)))
    at, heading = path.at(along)
    nearest = int(np.argmin(np.linalg.norm(at - place, axis=1)))
    across = np.array([-np.sin(heading[nearest]), np.cos(heading[nearest])])
    ways = []
    for aside in ASIDE:
        for side in (1.0, -1.0):
            point = place + side * aside * wide * across
            bent = _bent(me.errand.path_m, path, along[nearest], 1.2 * aside * wide, point)
            if bent is None:
                continue
            way = Timeline(me.actor, replace(me.errand, path_m=bent))
            ways.append((way, _Track.of(way)))
    return ways


def _bent(
    points: FloatArray, path: GroundPath, at_m: float, spare_m: float, point: FloatArray
) -> FloatArray | None:
    """A path that leaves its own by a point, and comes back to it, its ends as they were."""
    dense = np.linspace(0.0, path.length_m, 400)
    places = path.at(dense)[0]
    on = np.array([dense[np.argmin(np.linalg.norm(places - one, axis=1))] for one in points])
    on[0], on[-1] = 0.0, path.length_m
    before, after = on < at_m - spare_m, on > at_m + spare_m
    before[0], after[-1] = True, True
    bent = np.concatenate([points[before], point[None], points[after & ~before]])
    steps = np.linalg.norm(np.diff(bent, axis=0), axis=1)
    return None if np.any(steps < 1e-3 * spare_m) else bent


def _staying(timeline: Timeline) -> Timeline:
    """The same character that only idles."""
    return Timeline(timeline.actor, Errand(timeline.errand.start_m, timeline.errand.heading_rad))


def _why_it_stays(number: int, wanted: Sequence[Timeline], gap_m: float) -> str:
    """That there is no way, and who rests where it would, or would do so."""
    mine, said = _Track.of(wanted[number]), "finds no way to its goal and stays"
    for other, resting in enumerate(wanted):
        for rests in (resting, _staying(resting)):
            lacking = gap_m - _rest_gap(mine, _Track.of(rests))
            if other != number and lacking > 0.0:
                where = "starts" if rests is not resting else "ends"
                who = f"'{resting.actor.name}' {where}"
                return f"{said}: its goal is {lacking:.3g} m too near to where {who}"
    return f"{said}: none that was tried keeps clear of the others"


def _note(asked: Errand, errand: Errand) -> str:
    parts = []
    if errand.waits_s > asked.waits_s:
        parts.append(f"waits {errand.waits_s - asked.waits_s:.2f} s")
    if len(errand.path_m) != len(asked.path_m) or not np.array_equal(errand.path_m, asked.path_m):
        parts.append("goes round")
    return " and ".join(parts)
