"""Characters that follow errands: states in order, no jump between them, feet that stay put."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Character, Clip, legs_of, mannequin
from motorcade.animation.behaviour import (
    Act,
    Actor,
    ClipLayer,
    Errand,
    Timeline,
    gait_between,
    perform,
)
from motorcade.animation.behaviour.performance import FOLLOWS, foot_slides_m
from motorcade.animation.ik import fitted_legs
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

SCALE = 0.1


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


@pytest.fixture(scope="module")
def actor(figure: Character) -> Actor:
    legs = tuple(fitted_legs(legs_of(figure.skeleton), figure))
    cycle, speed_m_s = gait_between([figure.clip("walk")], figure.skeleton, legs)
    acts = {name: Act.of(figure.clip(name), figure.skeleton, legs) for name in ("wave", "turn")}
    return Actor("one", figure, legs, SCALE, figure.clip("idle"), cycle, speed_m_s, acts)


def errand(rng: np.random.Generator) -> Errand:
    """Some way with bends, from any heading to any other, and something to do there."""
    bends = rng.uniform(-0.5, 0.5, 4)
    turns = np.cumsum(bends) + rng.uniform(-3.0, 3.0)
    steps = SCALE * rng.uniform(0.8, 1.6, 4)[:, None] * np.stack([np.cos(turns), np.sin(turns)], 1)
    path = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]) + rng.uniform(-1, 1, 2)
    return Errand(
        path[0],
        float(rng.uniform(-3.0, 3.0)),
        path,
        float(rng.uniform(-3.0, 3.0)),
        ("wave",),
        float(rng.choice([0.0, 0.7])),
    )


def rates(poses: Motor, step_s: float) -> FloatArray:
    """Changes of velocity from frame to frame: the largest component in each."""
    velocity = (poses[:-1].inverse() @ poses[1:]).as_twist() / step_s
    change = np.abs(np.diff(velocity, axis=0))
    return np.asarray(change.reshape(len(change), -1).max(axis=1))


def test_states_come_in_the_order_of_the_graph(actor, rng):
    for _ in range(20):
        made = Timeline(actor, errand(rng)).segments
        states = [segment.state for segment in made]
        assert states.index("walk") < states.index("arrive") < states.index("act")
        assert states[-1] == "idle"
        assert made[-1].end_s == np.inf
        for before, after in itertools.pairwise(made):
            assert after.state in FOLLOWS[before.state]
            assert after.start_s == before.end_s > before.start_s


def test_the_way_leads_along_the_path_to_its_end_and_front(actor, rng):
    for _ in range(5):
        given = errand(rng)
        line = Timeline(actor, given)
        (walk,) = (one for one in line.segments if one.state == "walk")
        (arrival,) = (one for one in line.segments if one.state == "arrive")
        clock = np.linspace(walk.start_s + 0.3, arrival.end_s, 200)
        moved = line.at(clock)
        steps = (moved[:-1].inverse() @ moved[1:]).translation_m
        # The sum of all root motions is the way, and it ends where and as it was asked.
        summed = moved[0]
        for step in moved[:-1].inverse() @ moved[1:]:
            summed = summed @ step
        np.testing.assert_allclose(summed.translation_m, [*given.path_m[-1], 0.0], atol=1e-6)
        assert np.all(steps[:, 0] > -1e-9)  # it goes ahead
        end = line.at(np.array([line.done_s + 1.0]))[0]
        np.testing.assert_allclose(end.translation_m[:2], given.path_m[-1], atol=1e-6)
        ahead = end.rotor.apply(np.array([1.0, 0.0, 0.0]))
        off = np.arctan2(ahead[1], ahead[0]) - given.facing_rad
        arrived = float(walk.way.path.at(walk.way.path.length_m)[1]) - given.facing_rad
        if abs((arrived + np.pi) % (2 * np.pi) - np.pi) > np.deg2rad(25.0):
            assert abs((off + np.pi) % (2 * np.pi) - np.pi) < 1e-6


def test_no_way_and_no_pose_jumps_in_place_or_velocity_where_states_change(actor, rng):
    """With a finer step, what changes from frame to frame gets less; at a jump it would not."""
    given = errand(rng)
    line = Timeline(actor, given)
    planted = {rate_hz: perform(line, 1.0, rate_hz=rate_hz) for rate_hz in (60.0, 240.0)}
    for before, after in itertools.pairwise(line.segments):
        found = []
        for step_s in (2e-3, 5e-4):
            clock = after.start_s + step_s * np.arange(-3, 4)
            found.append(rates(line.at(clock), step_s).max())
        assert found[1] < 0.5 * found[0] + 0.01, after.state
        if "walk" in (before.state, after.state) or "arrive" in (before.state, after.state):
            continue  # soles that come down change velocity at once, as those of any walk do
        moved = []
        for rate_hz, made in planted.items():
            near = np.abs(made.time_s - after.start_s) < 0.05
            moved.append(rates(made.poses[near], 1.0 / rate_hz).max())
        assert moved[1] < 0.5 * moved[0] + 0.05, after.state
    made = planted[240.0]
    assert np.abs((made.poses[:-1].inverse() @ made.poses[1:]).as_twist()).max() < 0.1  # in 4 ms


def test_feet_do_not_slide(actor, rng):
    """At most 1 % of the height in any step, and a quarter of that in most."""
    height_m = SCALE * actor.character.height_m
    for _ in range(4):
        made = perform(Timeline(actor, errand(rng)), 1.0)
        slides = foot_slides_m(actor, made)
        assert len(slides) > 8
        assert max(slide for _, _, slide in slides) < 0.01 * height_m
        assert np.median([slide for _, _, slide in slides]) < 0.0025 * height_m


def test_the_measure_of_sliding_sees_what_slides(actor):
    line = Timeline(actor, Errand((0.0, 0.0)))
    made = perform(line, 1.0)
    shift = np.stack([0.05 * made.time_s, 0.0 * made.time_s, 0.0 * made.time_s], axis=1)
    pushed = replace(made, plane_T_character=Motor.from_translation(shift))
    worst = max(slide for _, _, slide in foot_slides_m(actor, pushed))
    assert worst == pytest.approx(0.025, abs=2e-3)


def test_the_same_errand_gives_the_same_bytes(actor, rng):
    given = errand(rng)
    first, second = (perform(Timeline(actor, given), 2.0) for _ in range(2))
    assert first.poses.coefficients.tobytes() == second.poses.coefficients.tobytes()
    assert (
        first.plane_T_character.coefficients.tobytes()
        == second.plane_T_character.coefficients.tobytes()
    )


def test_a_clip_that_travels_takes_the_character_along(actor):
    line = Timeline(actor, Errand((1.0, 2.0), 0.5, acts=("turn",)))
    end = line.at(np.array([10.0]))[0]
    ahead = end.rotor.apply(np.array([1.0, 0.0, 0.0]))
    heading = float(np.arctan2(ahead[1], ahead[0]))
    assert heading == pytest.approx(0.5 + 0.5 * np.pi, abs=0.05)  # a quarter to the left


def test_a_layer_changes_its_joints_alone_and_only_while_it_lasts(actor, figure):
    mask = np.zeros(len(figure.skeleton))
    arm = figure.skeleton.index("right_upper_arm")
    mask[arm] = 1.0
    path = SCALE * np.array([[0.0, 0.0], [3.0, 0.0]])
    plain = perform(Timeline(actor, Errand((0, 0), path_m=path, waits_s=1.0)), 6.0)
    layer = ClipLayer(figure.clip("wave"), mask)
    waving = replace(actor, layers=(layer,))
    made = perform(Timeline(waving, Errand((0, 0), path_m=path, waits_s=1.0)), 6.0)
    apart = np.abs((plain.poses.inverse() @ made.poses).as_twist()).max(axis=-1)
    walking = (made.time_s > 1.5) & (made.time_s < 3.0)
    assert apart[walking, arm].max() > 0.3
    assert apart[:60].max() < 1e-9
    others = np.delete(np.arange(len(mask)), arm)
    assert apart[:, others].max() < 1e-6


def test_an_additive_layer_adds_its_difference(actor, figure):
    mask = np.ones(len(figure.skeleton))
    still = Clip("still", np.array([0.0, 1.0]), Motor.stack([figure.skeleton.rest] * 2))
    layers = (ClipLayer(still, mask, "always", additive=True),)
    plain = perform(Timeline(actor, Errand((0, 0))), 1.0)
    made = perform(Timeline(replace(actor, layers=layers), Errand((0, 0))), 1.0)
    apart = np.abs((plain.poses.inverse() @ made.poses).as_twist()).max()
    assert apart < 1e-9  # no difference, nothing added


def test_gaits_are_blended_to_a_speed_between_them(figure):
    legs = legs_of(figure.skeleton)
    clips = [figure.clip("jog"), figure.clip("walk")]
    (slow, low), (fast, high) = (
        gait_between([clip], figure.skeleton, legs) for clip in clips[::-1]
    )
    cycle, speed_m_s = gait_between(clips, figure.skeleton, legs, 0.5 * (low + high))
    assert speed_m_s == pytest.approx(0.5 * (low + high), rel=0.1)
    assert min(slow.duration_s, fast.duration_s) < cycle.duration_s < max(slow.duration_s, 9.0)
    with pytest.raises(ValueError, match="a speed that the gaits have"):
        gait_between(clips, figure.skeleton, legs, 9.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (lambda: Errand((0, 0), path_m=[(1, 1), (2, 2)]), "expected to begin at"),
        (lambda: Errand((0, 0), path_m=[(0, 0)]), "P at least 2"),
        (lambda: Errand((0, 0), waits_s=-1.0), "waits_s"),
        (lambda: Errand((0, 0), heading_rad=np.nan), "heading_rad"),
    ],
)
def test_errands_that_make_no_sense_are_refused(given, said):
    with pytest.raises(ValueError, match=said):
        given()


def test_an_act_that_is_not_there_is_refused_with_those_that_are(actor):
    with pytest.raises(ValueError, match="expected some of 'wave', 'turn', got 'dance'"):
        Timeline(actor, Errand((0, 0), acts=("dance",)))
