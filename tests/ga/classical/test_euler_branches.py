"""Euler angles that follow a path: of all triples that are a rotation, the one nearest the last."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.ga.arrays import FloatArray
from motorcade.ga.classical import follow_euler, nearest_euler
from motorcade.ga.versors.euler_angles import (
    SEQUENCES,
    euler_from_matrix,
    lock_levers,
    matrix_from_euler,
)

EVERY_ORDER = pytest.mark.parametrize("sequence", SEQUENCES)
LOCKS = {False: (0.5 * np.pi, -0.5 * np.pi), True: (0.0, np.pi)}


def proper(sequence: str) -> bool:
    return sequence[0] == sequence[2]


def walk(rng: np.random.Generator, count: int = 300, step_rad: float = 0.2) -> FloatArray:
    """Rotations that wander through all orientations."""
    made = [Rotation.random(random_state=int(rng.integers(1 << 31)))]
    for step in step_rad * rng.standard_normal((count - 1, 3)):
        made.append(made[-1] * Rotation.from_rotvec(step))
    return np.array([one.as_matrix() for one in made])


def equivalents(angles: FloatArray, sequence: str) -> FloatArray:
    """The triples of a rotation with up to two whole turns an angle, twins among them."""
    a, b, c = angles
    twin = np.array([a + np.pi, -b if proper(sequence) else np.pi - b, c + np.pi])
    turns = 2.0 * np.pi * np.array(list(product(range(-2, 3), repeat=3)))
    return np.concatenate([angles + turns, twin + turns])


@EVERY_ORDER
def test_no_triple_of_the_same_rotation_is_nearer(sequence: str, rng: np.random.Generator) -> None:
    angles = rng.uniform(-np.pi, np.pi, (200, 3))
    references = rng.uniform(-2.0 * np.pi, 2.0 * np.pi, (200, 3))
    found = nearest_euler(angles, references, sequence)
    moved = matrix_from_euler(found, sequence) - matrix_from_euler(angles, sequence)
    assert np.abs(moved).max() < 1e-12
    for one, reference, near in zip(angles, references, found, strict=True):
        every = np.linalg.norm(equivalents(one, sequence) - reference, axis=1)
        assert np.linalg.norm(near - reference) < every.min() + 1e-12


@EVERY_ORDER
def test_paths_come_back_and_follow_triple_by_triple(
    sequence: str, rng: np.random.Generator
) -> None:
    rotations = walk(rng)
    raw = euler_from_matrix(rotations, sequence)
    found = follow_euler(raw, sequence)
    assert np.abs(matrix_from_euler(found, sequence) - rotations).max() < 1e-12
    np.testing.assert_array_equal(found[0], raw[0])
    for k in range(1, len(raw)):
        np.testing.assert_array_equal(found[k], nearest_euler(raw[k], found[k - 1], sequence))


@EVERY_ORDER
def test_what_scipy_gives_is_followed_alike(sequence: str, rng: np.random.Generator) -> None:
    rotations = walk(rng)
    theirs = Rotation.from_matrix(rotations).as_euler(sequence.upper())
    away = lock_levers(rotations, sequence) > 0.05
    ours = follow_euler(euler_from_matrix(rotations, sequence), sequence)
    witness = follow_euler(theirs, sequence)
    # Both may stand on another branch since they began; steps are the same on all.
    both = away[1:] & away[:-1]
    steps, expected = (np.abs(np.diff(one, axis=0))[both] for one in (ours, witness))
    np.testing.assert_allclose(steps, expected, rtol=0, atol=1e-12)


@EVERY_ORDER
def test_angles_go_on_through_gimbal_lock(sequence: str) -> None:
    """Exactly through the lock, which is one of the poses: no angle takes more than its step."""
    lock = LOCKS[proper(sequence)][0]
    given = np.stack(
        [
            np.linspace(0.2, 0.4, 41),
            lock + np.linspace(-0.4, 0.4, 41),
            np.linspace(-1.0, -0.9, 41),
        ],
        axis=-1,
    )
    rotations = matrix_from_euler(given, sequence)
    assert lock_levers(rotations, sequence).min() < 1e-15
    found = follow_euler(euler_from_matrix(rotations, sequence), sequence)
    assert np.abs(matrix_from_euler(found, sequence) - rotations).max() < 1e-12
    assert np.abs(np.diff(found, axis=0)).max() < 0.021


@EVERY_ORDER
def test_paths_that_stay_at_gimbal_lock_are_followed_alike(
    sequence: str, rng: np.random.Generator
) -> None:
    """Runs of poses exactly at either lock, and others between them."""
    given = rng.uniform(-np.pi, np.pi, (80, 3))
    given[10:30, 1], given[40:50, 1] = LOCKS[proper(sequence)]
    rotations = matrix_from_euler(given, sequence)
    raw = euler_from_matrix(rotations, sequence)
    found = follow_euler(raw, sequence)
    assert np.abs(matrix_from_euler(found, sequence) - rotations).max() < 1e-12
    for k in range(1, len(raw)):
        alone = nearest_euler(raw[k], found[k - 1], sequence)
        np.testing.assert_allclose(found[k], alone, rtol=0, atol=1e-12)


@EVERY_ORDER
@pytest.mark.parametrize("side", [0, 1])
def test_at_gimbal_lock_both_angles_share_the_way(
    sequence: str, side: int, rng: np.random.Generator
) -> None:
    lock = LOCKS[proper(sequence)][side]
    locked = matrix_from_euler([0.3, lock, 0.4], sequence)
    reference = np.array([1.0, lock + 0.1, -0.7])
    found = nearest_euler(euler_from_matrix(locked, sequence), reference, sequence)
    assert np.abs(matrix_from_euler(found, sequence) - locked).max() < 1e-14
    nearest = np.linalg.norm(found - reference)
    for free in rng.uniform(-np.pi, np.pi, 200):
        for way in (-1.0, 1.0):
            other = found + free * np.array([1.0, 0.0, way])
            if np.abs(matrix_from_euler(other, sequence) - locked).max() < 1e-12:
                assert np.linalg.norm(other - reference) > nearest - 1e-12


@EVERY_ORDER
def test_levers_are_the_sine_between_the_first_and_the_last_axis(
    sequence: str, rng: np.random.Generator
) -> None:
    angles = rng.uniform(-np.pi, np.pi, (100, 3))
    found = lock_levers(matrix_from_euler(angles, sequence), sequence)
    middle = np.sin(angles[:, 1]) if proper(sequence) else np.cos(angles[:, 1])
    np.testing.assert_allclose(found, np.abs(middle), rtol=0, atol=1e-14)
    near = matrix_from_euler([0.3, LOCKS[proper(sequence)][0] + 1e-12, 0.1], sequence)
    assert lock_levers(near, sequence) == pytest.approx(1e-12, rel=1e-3)


@pytest.mark.parametrize(("one", "other"), [("xyx", "xzx"), ("yzy", "yxy"), ("zxz", "zyz")])
def test_orders_around_one_axis_differ_by_constants(
    one: str, other: str, rng: np.random.Generator
) -> None:
    rotations = walk(rng)
    first, second = (follow_euler(euler_from_matrix(rotations, s), s) for s in (one, other))
    np.testing.assert_allclose(
        np.abs(np.diff(first, axis=0)), np.abs(np.diff(second, axis=0)), rtol=0, atol=1e-9
    )


def test_unknown_sequences_and_wrong_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match="sequence: expected one of xyz"):
        nearest_euler(np.zeros(3), np.zeros(3), "xyy")
    with pytest.raises(ValueError, match=r"angles_rad: expected \(N, 3\)"):
        follow_euler(np.zeros(3))
