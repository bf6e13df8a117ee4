"""FABRIK: reachable targets reached, limits and lengths kept, hard chains handled."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation.ik import fabrik
from motorcade.ga import CGA3, Motor, kernels

ARM, LEG, LONG = (2, np.radians(150.0)), (3, np.radians(120.0)), (20, np.radians(60.0))


def _chains(rng, count: int, bones: int, limit: float) -> np.ndarray:
    """Chains (count, bones + 1, 3) of given lengths whose bends are drawn within the limit."""
    lengths = np.random.default_rng(5).uniform(0.2, 0.4, bones)
    steps = rng.standard_normal((count, bones, 3))
    steps[:, 0] /= np.linalg.norm(steps[:, 0], axis=-1, keepdims=True)
    for k in range(1, bones):
        angle = rng.uniform(0.0, limit, (count, 1))
        across = np.cross(steps[:, k - 1], steps[:, k])
        across /= np.linalg.norm(across, axis=-1, keepdims=True)
        steps[:, k] = np.cos(angle) * steps[:, k - 1] + np.sin(angle) * across
    moved = np.cumsum(steps * lengths[:, None], axis=1)
    return np.concatenate([np.zeros((count, 1, 3)), moved], axis=1)


def _check(points: np.ndarray, start: np.ndarray, limit: float) -> None:
    """The base stays, bones keep their lengths, bends their limit."""
    np.testing.assert_array_equal(points[:, 0], start[:, 0])
    bones, before = np.diff(points, axis=1), np.diff(start, axis=1)
    length = np.linalg.norm(bones, axis=-1)
    np.testing.assert_allclose(length, np.linalg.norm(before, axis=-1), atol=1e-12)
    unit = bones / length[..., None]
    cosine = np.sum(unit[:, 1:] * unit[:, :-1], axis=-1)
    assert np.arccos(np.clip(cosine, -1.0, 1.0)).max() <= limit + 1e-7


@pytest.mark.parametrize(
    ("chain", "count"),
    [
        (ARM, 10_000),
        (LEG, 10_000),
        (LONG, 10_000),
    ],
)
def test_random_targets_within_reach_are_reached_within_limits(chain, count, rng):
    bones, limit = chain
    start = _chains(rng, count, bones, 0.3 * limit)
    target = _chains(rng, count, bones, limit)[:, -1]
    found = fabrik(start, target, limit)
    total = np.linalg.norm(np.diff(start[0], axis=0), axis=-1).sum()
    assert found.error_m.max() <= 1e-4 * total
    _check(found.points, start, limit)
    np.testing.assert_allclose(
        np.linalg.norm(found.points[:, -1] - target, axis=-1), found.error_m, atol=1e-15
    )


def test_out_of_reach_a_chain_is_stretched_straight(rng):
    start = _chains(rng, 50, 5, 1.0)
    target = 10.0 * rng.standard_normal((50, 3))
    found = fabrik(start, target, 0.7)
    _check(found.points, start, 1e-6)
    ahead = target / np.linalg.norm(target, axis=-1, keepdims=True)
    total = np.linalg.norm(np.diff(start[0], axis=0), axis=-1).sum()
    np.testing.assert_allclose(found.points[:, -1], total * ahead, atol=1e-9)


def test_a_chain_in_line_with_its_target_bends():
    straight = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    for target in ([1.0, 0, 0], [-1.2, 0, 0], [1.999, 0, 0]):
        found = fabrik(straight, target)
        assert found.error_m < 2e-4
        _check(found.points[None], straight[None], np.pi)


def test_bones_of_no_length_stay_so_and_targets_at_the_base_are_reached():
    points = np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 1], [0, 0.8, 1.2], [0, 0.9, 0.4]])
    found = fabrik(points, [0.3, 0.2, 0.1])
    assert found.error_m < 1e-4
    np.testing.assert_allclose(found.points[1], found.points[2], atol=1e-12)
    assert fabrik(points, [0.0, 0.0, 0.0]).error_m < 1e-4


def test_the_first_bone_keeps_to_the_direction_of_the_base(rng):
    start = _chains(rng, 200, 4, 0.5)
    swing = np.radians(40.0)
    found = fabrik(
        start,
        rng.standard_normal((200, 3)) * 0.3,
        1.2,
        base_direction=[0, 0, 1.0],
        max_swing_rad=swing,
    )
    first = found.points[:, 1] - found.points[:, 0]
    cosine = first[:, 2] / np.linalg.norm(first, axis=-1)
    assert np.arccos(np.clip(cosine, -1, 1)).max() <= swing + 1e-7
    _check(found.points, start, 1.2)


def test_the_same_chain_and_target_give_the_same_bytes(rng):
    start, target = _chains(rng, 40, 3, 0.2), rng.standard_normal((40, 3)) * 0.4
    one, two = (fabrik(start, target, 2.0).points for _ in range(2))
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("limit", [np.pi, 1.0, 0.4])
def test_a_chain_follows_a_target_without_jumps(limit):
    """A quarter of the steps' length, a quarter of the moves; the last is out of reach at times."""
    most = []
    for steps in (200, 800):
        phase = np.linspace(0.0, 2.0 * np.pi, steps)
        swung = [0.3 * np.cos(phase), 0.5 * np.sin(phase), 0.3 * np.sin(2.0 * phase)]
        path = np.array([0.4, 0.0, 0.2]) + np.stack(swung, axis=-1)
        points = np.zeros((12, 3))
        points[:, 0] = np.linspace(0.0, 1.0, 12)
        points[:, 1] = 0.01 * np.sin(7.0 * points[:, 0])
        points, moved = fabrik(points, path[0], limit).points, 0.0
        for target in path:
            after = fabrik(points, target, limit).points
            moved, points = max(moved, float(np.abs(after - points).max())), after
        most.append(moved)
    assert most[0] < 0.08
    assert most[1] < 0.4 * most[0]


def test_moving_chain_and_target_alike_moves_the_result(rng):
    for _ in range(30):
        points, move = _chains(rng, 1, 7, 1.0)[0], Motor.random(rng)
        target = 0.6 * rng.standard_normal(3)
        found = fabrik(points, target, 1.0, tolerance=1e-8)
        moved = fabrik(move.apply(points), move.apply(target), 1.0, tolerance=1e-8)
        np.testing.assert_allclose(moved.error_m, found.error_m, atol=1e-7)
        np.testing.assert_allclose(moved.points, move.apply(found.points), atol=1e-3)


def test_the_kernel_is_the_meet_of_line_and_sphere_in_the_algebra(rng):
    p, q, length = rng.standard_normal((5, 3)), rng.standard_normal((5, 3)), rng.uniform(0.1, 2, 5)
    out = np.empty((5, 3))
    kernels.function("reach")(p, q, length, out)

    def point(x):
        return CGA3.multivector({"e1": x[0], "e2": x[1], "e3": x[2], "einf": 0.5 * x @ x, "e0": 1})

    infinity = CGA3.multivector({"einf": 1})
    for k in range(5):
        on_line = point(out[k]) ^ point(p[k]) ^ point(q[k]) ^ infinity
        assert max((abs(value) for value in on_line.values), default=0.0) < 1e-12
        # The inner product of two points is minus half their distance squared.
        distance = (point(out[k]) | point(p[k])).coefficient("1")
        assert float(distance) == pytest.approx(-0.5 * length[k] ** 2, abs=1e-12)
        assert (out[k] - p[k]) @ (q[k] - p[k]) > 0.0


def test_refusals(rng):
    points = _chains(rng, 1, 3, 0.5)[0]
    for arguments, message in (
        ((points[:1], [0, 0, 1.0]), "N >= 2"),
        ((np.zeros((3, 3)), [0, 0, 1.0]), "longer than 0"),
        ((points, [0, np.nan, 0]), "finite"),
        ((points, [0, 0, 1.0], [0.1]), "expected one angle or 2"),
        ((points, [0, 0, 1.0], 4.0), "angles from 0 to pi"),
    ):
        with pytest.raises(ValueError, match=message):
            fabrik(*arguments)
