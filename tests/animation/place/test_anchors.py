"""Anchors follow corrections without popping, at any frame rate."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation.place import Anchor
from motorcade.animation.place.anchors import followed, plane_anchor
from motorcade.ga import Motor, Similarity


def _apart(a: Similarity, b: Similarity) -> float:
    return float(np.max(np.abs((a.inverse() @ b).as_twist())))


@pytest.fixture
def targets(rng) -> list[Similarity]:
    base = Similarity.random(rng)
    return [base @ Similarity.from_twist(0.3 * rng.standard_normal(7)) for _ in range(3)]


def test_at_a_correction_nothing_jumps_and_then_it_settles(targets):
    anchor = Anchor(targets[0], 0.0, settle_s=0.2)
    assert _apart(anchor.at(5.0), targets[0]) < 1e-15
    moved = anchor.corrected(targets[1], 1.0)
    assert _apart(moved.at(1.0), targets[0]) < 1e-12
    gap = _apart(targets[1], targets[0])
    assert _apart(targets[1], moved.at(1.2)) == pytest.approx(gap / np.e, rel=1e-9)
    assert _apart(moved.at(1.0 + 0.2 * 30), targets[1]) < 1e-11


def test_corrections_on_the_way_do_not_jump_either(targets):
    anchor = Anchor(targets[0], 0.0)
    for k, target in enumerate((targets[1], targets[2], targets[0]), start=1):
        before = anchor.at(0.1 * k)
        anchor = anchor.corrected(target, 0.1 * k)
        assert _apart(anchor.at(0.1 * k), before) < 1e-12


def test_the_frame_rate_does_not_matter(targets):
    """Being told the same target again, as trackers do every frame, changes nothing."""
    once = Anchor(targets[0]).corrected(targets[1], 1.0)
    often = once
    for time_s in np.linspace(1.0, 1.5, 60):
        often = often.corrected(targets[1], float(time_s))
    assert _apart(once.at(1.7), often.at(1.7)) < 1e-11


def test_a_settling_time_of_zero_follows_at_once(targets):
    anchor = Anchor(targets[0], settle_s=0.0).corrected(targets[1], 1.0)
    assert _apart(anchor.at(1.0), targets[1]) < 1e-15


def test_what_carries_itself_is_followed_at_once_and_the_rest_settles(targets):
    """A correction leaves an offset; the target's own motion after it is shown in full."""
    anchor = Anchor(targets[0]).corrected(targets[1], 0.0)
    step = Similarity.from_twist([0.1, -0.2, 0.05, 0.0, 0.3, 0.1, -0.2])
    moved = step @ targets[1]
    tracked = anchor.tracked(moved, 0.1)
    assert _apart(tracked.at(0.1), step @ anchor.at(0.1)) < 1e-12
    assert _apart(tracked.at(0.6), step @ anchor.at(0.6)) < 1e-12
    assert _apart(tracked.at(20.0), moved) < 1e-11


def test_a_thing_that_moves_is_followed_without_lag_and_leaps_are_glided_over(rng):
    seen_s = np.delete(np.arange(60) / 30.0, np.arange(20, 30))
    twist = np.array([0.2, -0.1, 0.3, 0.2, 0.1, -0.1])
    true = Motor.from_twist(seen_s[:, None] * twist)
    leap = Motor.from_twist([0.0, 0.0, 0.0, 0.5, 0.0, 0.0])
    given = Motor.concatenate([true[:40], leap @ true[40:]])
    shown = followed(seen_s, given, np.arange(-5, 60) / 30.0, fastest_m_s=2.0)
    places, before = shown.translation_m, true.translation_m
    np.testing.assert_allclose(places[:6], np.tile(before[0], (6, 1)), atol=1e-12)
    np.testing.assert_allclose(places[5:25], before[:20], atol=1e-12)
    np.testing.assert_allclose(places[25:35], np.tile(before[19], (10, 1)), atol=1e-12)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    own = np.linalg.norm(np.diff(before[:20], axis=0), axis=1).max()
    assert steps.max() < 2.0 * own + 0.5 * (1.0 - np.exp(-1.0 / (30.0 * 0.25)))
    left = np.linalg.norm(places[-1] - given.translation_m[-1])
    assert left < 0.6 * np.exp(-9.0 / (30.0 * 0.25))
    with pytest.raises(ValueError, match="expected one pose for each"):
        followed(seen_s, given[:3], seen_s, fastest_m_s=1.0)


def test_a_plane_anchor_stands_up_from_its_plane(rng):
    normal, point, ahead = rng.standard_normal((3, 3))
    anchor = plane_anchor(normal, point, ahead, 0.3)
    unit = normal / np.linalg.norm(normal)
    np.testing.assert_allclose(anchor.rotor.apply([0, 0, 1.0]), unit, atol=1e-12)
    x = anchor.rotor.apply([1.0, 0, 0])
    assert abs(x @ unit) < 1e-12
    assert x @ ahead > 0.0
    assert np.cross(unit, x) @ np.cross(unit, ahead) == pytest.approx(
        np.linalg.norm(np.cross(unit, ahead))
    )
    np.testing.assert_allclose(anchor.apply(np.zeros(3)), point, atol=1e-12)


def test_refusals(targets):
    with pytest.raises(ValueError, match=r"expected 1\.0 s or later, got 0\.5"):
        Anchor(targets[0], 1.0).at(0.5)
    with pytest.raises(ValueError, match="expected 0 or more seconds"):
        Anchor(targets[0], settle_s=-1.0)
    with pytest.raises(ValueError, match="got a batch"):
        Anchor(Similarity.from_motor_scale(Motor.identity((2,))))
    with pytest.raises(ValueError, match="off the normal"):
        plane_anchor(np.array([0, 0, 1.0]), np.zeros(3), np.array([0, 0, -2.0]))
