"""The compiled representations are the Python ones: same layout, coordinates and verbs."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.smoothing.native import _scans
from motorcade.fusion.smoothing.representations import REPRESENTATIONS
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray

TOLERANCE = 1e-12


def steps(rng: np.random.Generator) -> FloatArray:
    """Twists from nothing to nearly half a turn, some without rotation or translation."""
    sizes = 10.0 ** rng.uniform(-12.0, 0.0, 300)
    twist = rng.standard_normal((300, 7))
    twist[:, :3] *= (np.minimum(sizes * np.pi, 3.1) / np.linalg.norm(twist[:, :3], axis=1))[:, None]
    twist[:40, :3] *= (3.14159 / np.linalg.norm(twist[:40, :3], axis=1))[:, None]
    twist[40:60, :3] = 0.0
    twist[60:80, 3:] = 0.0
    twist[:, 6] *= 0.2
    return twist


def path(rng: np.random.Generator, scaled: bool) -> Motor | Similarity:
    """A walk whose coefficients change sign at random, far from gimbal lock."""
    turns = np.cumsum(rng.normal(0.0, 0.2, (300, 3)), axis=0)
    turns[:, 1] = 1.2 * np.sin(turns[:, 1])
    motor = Motor.from_euler_translation(turns, np.cumsum(rng.standard_normal((300, 3)), axis=0))
    signed = Motor(np.where(rng.random((300, 1)) < 0.5, -1.0, 1.0) * motor.coefficients)
    if not scaled:
        return signed
    return Similarity.from_motor_scale(signed, np.exp(0.3 * rng.standard_normal(300)))


@pytest.mark.parametrize("scaled", [False, True])
@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_verbs_are_the_python_ones(name: str, scaled: bool, rng: np.random.Generator) -> None:
    poses, representation = path(rng, scaled), REPRESENTATIONS[name]
    base = representation.coordinates(poses)
    assert np.abs(_scans.coordinates(name, scaled, poses.coefficients) - base).max() < TOLERANCE
    if scaled:
        moved = poses @ Similarity.from_twist(steps(rng))
    else:
        moved = poses @ Motor.from_twist(steps(rng)[:, :6])
    there = representation.coordinates(moved)
    size = np.maximum(1.0, np.abs(there).max())
    vector = representation.local(there, base)
    ours = _scans.local(name, scaled, there, base)
    assert np.abs(ours - vector).max() < TOLERANCE * size
    back = _scans.retract(name, scaled, base, vector)
    assert np.abs(back - representation.retract(base, vector)).max() < TOLERANCE * size


@pytest.mark.parametrize("scaled", [False, True])
@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_layouts_are_the_python_ones(name: str, scaled: bool, rng: np.random.Generator) -> None:
    representation = REPRESENTATIONS[name]
    ends, units, coupled = _scans.layout(name, scaled)
    assert tuple(ends[:2]) == representation.ends
    assert tuple(units[:2]) == representation.units
    assert coupled == representation.coupled
    x = representation.coordinates(path(rng, scaled)[:1])
    assert representation.local(x, x).shape[-1] == ends[-1]


@pytest.mark.parametrize("scaled", [False, True])
@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_poses_come_back(name: str, scaled: bool, rng: np.random.Generator) -> None:
    poses = path(rng, scaled)
    coordinates = _scans.coordinates(name, scaled, poses.coefficients)
    again = type(poses)(_scans.poses(name, scaled, coordinates))
    assert np.abs(again.as_matrix() - poses.as_matrix()).max() < TOLERANCE * 100


def test_euler_angles_at_gimbal_lock_give_the_pose_back() -> None:
    rotors = Rotor.from_euler([[0.4, 0.5 * np.pi, 0.2], [1.0, -0.5 * np.pi, 0.7], [0.0, 1.57, 0.1]])
    poses = Motor.from_rotor_translation(rotors, np.ones((3, 3)))
    again = Motor(
        _scans.poses("euler", False, _scans.coordinates("euler", False, poses.coefficients))
    )
    assert np.abs(again.as_matrix() - poses.as_matrix()).max() < 1e-14


def test_a_scale_that_is_not_positive_is_refused() -> None:
    coordinates = np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.1]])
    with pytest.raises(ValueError, match=r"scale: expected a positive number, got -0\.1"):
        _scans.poses("rotor", True, coordinates)


def test_a_quaternion_of_no_length_is_refused() -> None:
    zero = np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    with pytest.raises(ValueError, match="quaternion: expected averages of non-zero length"):
        _scans.retract("quaternion", False, zero, -zero)
