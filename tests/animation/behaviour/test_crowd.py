"""Characters whose paths cross: they keep apart, or say that they cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import legs_of, mannequin
from motorcade.animation.behaviour import (
    Actor,
    ClipLayer,
    Errand,
    Performance,
    Timeline,
    crowd,
    gait_between,
    keep_apart,
    perform,
)
from motorcade.animation.behaviour.crowd import closest_m
from motorcade.animation.skin import skin
from motorcade.ga.arrays import FloatArray

GAP_M = 0.05


def least_distance_m(
    first: tuple[Actor, Performance], second: tuple[Actor, Performance]
) -> FloatArray:
    """Distances ``(F,)`` between two bodies' skins, frame by frame; who is done first stays."""
    frames = max(len(first[1].time_s), len(second[1].time_s))
    points = [crowd._skin_m(*member) for member in (first, second)]
    return np.array(
        [crowd._nearest_m(*(at[min(k, len(at) - 1)] for at in points)) for k in range(frames)]
    )


@pytest.fixture(scope="module")
def actor() -> Actor:
    figure = mannequin()
    legs = tuple(legs_of(figure.skeleton))
    cycle, speed_m_s = gait_between([figure.clip("walk")], figure.skeleton, legs)
    return Actor("first", figure, legs, 1.0, figure.clip("idle"), cycle, speed_m_s)


def straight(start: tuple[float, float], end: tuple[float, float], waits_s: float = 0.0) -> Errand:
    heading = float(np.arctan2(end[1] - start[1], end[0] - start[0]))
    return Errand(start, heading, [start, end], waits_s=waits_s)


def gap_m(first: Timeline, second: Timeline) -> float:
    """Between two cylinders, over all times, at another rate than plans are made."""
    time_s = np.arange(0.0, max(first.done_s, second.done_s) + 1.0, 1.0 / 47.0)
    apart = np.linalg.norm(first.at(time_s).translation_m - second.at(time_s).translation_m, axis=1)
    return float(np.min(apart - first.reach_m(time_s) - second.reach_m(time_s)))


def test_random_crossing_paths_keep_their_distance(actor, rng):
    other, kept_up = replace(actor, name="second"), 0
    for _ in range(12):
        ends = rng.uniform(0.0, 2.0 * np.pi, 2)
        ways = [
            straight(
                (2.5 * np.cos(angle), 2.5 * np.sin(angle)),
                (-2.5 * np.cos(angle), -2.5 * np.sin(angle)),
            )
            for angle in ends
        ]
        if np.linalg.norm(ways[0].start_m - ways[1].start_m) < 1.8:
            continue
        crowd = keep_apart([(actor, ways[0]), (other, ways[1])], GAP_M)
        first, second = crowd.timelines
        # Between the planner's frames they come nearer by no more than they walk in half a one.
        assert gap_m(first, second) > GAP_M - 0.07
        assert crowd.least_gap_m >= GAP_M
        kept_up += not crowd.stays
        for asked, line in zip(ways, crowd.timelines, strict=True):
            if not crowd.stays:
                end = line.at(np.array([line.done_s + 1.0]))[0]
                np.testing.assert_allclose(end.translation_m[:2], asked.path_m[-1], atol=1e-5)
    assert kept_up >= 5


def test_without_a_plan_they_would_meet(actor):
    ways = straight((0, 0), (4, 0)), straight((2, -2), (2, 2))
    assert gap_m(*(Timeline(actor, way) for way in ways)) < 0.0


def test_skins_are_apart_by_the_gap_at_least(actor):
    other = replace(actor, name="second")
    crowd = keep_apart(
        [(actor, straight((0, 0), (4, 0))), (other, straight((4, 0), (0, 0)))], GAP_M
    )
    assert crowd.stays == ()
    assert "goes round" in crowd.notes
    made = [perform(line, 1.0, rate_hz=30.0) for line in crowd.timelines]
    told = least_distance_m((actor, made[0]), (other, made[1]))
    frame = int(np.argmin(told))
    skins = []
    for one in made:
        at = min(frame, len(one.time_s) - 1)
        vertices = skin(actor.character, one.poses[at])[0]
        skins.append(one.plane_T_character[at].apply(vertices))
    apart = min(float(np.linalg.norm(skins[1] - point, axis=1).min()) for point in skins[0])
    assert apart == pytest.approx(told.min(), abs=0.06)
    assert min(apart, told.min()) >= GAP_M


def test_the_closest_of_all_is_the_least_of_all_frames_and_pairs(actor):
    small = replace(actor, name="second", scale=0.6)
    cast = [
        (actor, straight((0, 0), (4, 0))),
        (small, straight((2, -2), (2, 2))),
        (replace(actor, name="third"), Errand((-2.0, 1.0))),
    ]
    made = [perform(Timeline(*one), 1.0, rate_hz=10.0) for one in cast]
    all_made = [(one[0], poses) for one, poses in zip(cast, made, strict=True)]
    pairs = ((0, 1), (0, 2), (1, 2))
    each = [least_distance_m(all_made[a], all_made[b]).min() for a, b in pairs]
    assert closest_m(all_made) == min(each)
    assert closest_m(all_made[::2]) == each[1] > min(each)
    assert closest_m(all_made[:1]) == np.inf
    points = [
        who.scale * who.skin_m(poses.poses[5], 700) + poses.plane_T_character[5].translation_m
        for who, poses in (all_made[0], all_made[2])
    ]
    # Neither of them turns: all pairs of points, one by one.
    assert np.abs(made[0].plane_T_character[5].rotor.coefficients[1:]).max() < 1e-12
    apart = min(float(np.linalg.norm(points[1] - point, axis=1).min()) for point in points[0])
    assert least_distance_m(all_made[0], all_made[2])[5] == pytest.approx(apart, rel=1e-12)


@pytest.mark.parametrize(
    "asked", [straight((0, 0), (1e4, 0)), Errand((0.0, 0.0), waits_s=1e9)], ids=["way", "wait"]
)
def test_errands_without_end_are_refused(actor, asked):
    with pytest.raises(ValueError, match=r"done within 600 s, got .* go a shorter way"):
        Timeline(actor, asked)


def test_layers_and_errands_of_no_meaning_are_refused(actor):
    clip, mask = actor.idle, np.ones(len(actor.skeleton))
    for made, message in (
        (lambda: ClipLayer(clip, mask, "wlak"), r"during: expected one of walk, .*'wlak'"),
        (lambda: ClipLayer(clip, mask[:-1]), r"mask: expected \d+ shares from 0 to 1"),
        (lambda: ClipLayer(clip, 2.0 * mask), r"mask: expected \d+ shares from 0 to 1"),
        (lambda: ClipLayer(clip, np.nan * mask), r"mask: expected finite numbers"),
    ):
        with pytest.raises(ValueError, match=message):
            made()
    with pytest.raises(TypeError, match=r"Errand.facing_rad: expected a number, got str"):
        Errand((0.0, 0.0), facing_rad="north")


def test_a_gait_of_no_clip_is_refused(actor):
    with pytest.raises(ValueError, match=r"gait_between\(clips\): expected one gait or more"):
        gait_between([], actor.skeleton, actor.legs)


def test_who_cannot_get_there_stays_and_is_named(actor):
    blocking = replace(actor, name="second")
    stands = Errand((4.0, 0.0), np.pi)
    crowd = keep_apart([(actor, straight((0, 0), (4, 0))), (blocking, stands)], GAP_M)
    assert crowd.stays == ("first",)
    assert "finds no way" in crowd.notes[0]
    assert crowd.timelines[0].done_s == 0.0


def test_plans_are_the_same_every_time(actor):
    other = replace(actor, name="second")
    cast = [(actor, straight((0, 0), (4, 0))), (other, straight((2, -2), (2, 2)))]
    first, second = keep_apart(cast, GAP_M), keep_apart(cast, GAP_M)
    assert first.notes == second.notes
    assert first.least_gap_m == second.least_gap_m


def test_those_who_stand_in_each_other_are_refused(actor):
    with pytest.raises(ValueError, match=r"'first' and 'second' stand in each other at the start"):
        keep_apart([(actor, Errand((0, 0))), (replace(actor, name="second"), Errand((0.3, 0)))])
    with pytest.raises(ValueError, match="1 to 8 characters"):
        keep_apart([])
    with pytest.raises(ValueError, match="gap_m"):
        keep_apart([(actor, Errand((0, 0)))], -1.0)
