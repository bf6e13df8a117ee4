"""Anchors follow corrections without popping, at any frame rate."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation.place import Anchor, plane_anchor
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


def test_a_plane_anchor_stands_up_from_its_plane(rng):
    normal, point, ahead = rng.standard_normal((3, 3))
    anchor = plane_anchor(normal, point, ahead, 0.3)
    unit = normal / np.linalg.norm(normal)
    np.testing.assert_allclose(anchor.rotor.apply([0, 0, 1.0]), unit, atol=1e-12)
    x = anchor.rotor.apply([1.0, 0, 0])
    assert abs(x @ unit) < 1e-12
    assert x @ ahead > 0.0
    assert np.cross(unit, x) @ np.cross(unit, ahead) == pytest.approx(
        np.linalg.norm(np.cross(unit, ahead)))  # fmt: skip
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
