"""Meshes between control motors: exact at the points, rigid where all agree, screws between."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation.skin import PoseField
from motorcade.ga import Motor


@pytest.fixture
def field(rng) -> PoseField:
    points = rng.standard_normal((5, 3))
    return PoseField(points, Motor.from_twist(0.4 * rng.standard_normal((5, 6))))


def test_at_a_control_point_its_motor_holds(field):
    found = field.at(field.points_m)
    assert np.abs((found.inverse() @ field.motors).as_twist()).max() < 1e-14
    nearly = field.at(field.points_m + 1e-9)
    assert np.abs((nearly.inverse() @ field.motors).as_twist()).max() < 1e-6


def test_where_all_motors_agree_the_mesh_is_rigid(rng):
    motor = Motor.random(rng)
    field = PoseField(rng.standard_normal((4, 3)), Motor.stack([motor] * 4))
    vertices, normals = rng.standard_normal((2, 50, 3))
    moved, turned = field.deform(vertices, normals)
    np.testing.assert_allclose(moved, motor.apply(vertices), atol=1e-12)
    np.testing.assert_allclose(turned, motor.rotor.apply(normals), atol=1e-12)


def test_halfway_between_two_points_lies_half_of_the_screw():
    twist = np.array([0.0, 0.0, 1.2, 0.3, 0.0, 0.1])
    field = PoseField(np.array([[0.0, 0, 0], [1, 0, 0]]), Motor.from_twist([np.zeros(6), twist]))
    found = field.at([0.5, 0.7, 0.0])
    assert np.abs((found.inverse() @ Motor.from_twist(0.5 * twist)).as_twist()).max() < 1e-14
    # Weights at a third of the way: 4 to 1 by inverse squares.
    np.testing.assert_allclose(field.weights([1 / 3, 0, 0]), [0.8, 0.2])


def test_fractions_lead_from_rest_to_the_pose_along_screws(field, rng):
    vertices = rng.standard_normal((20, 3))
    whole = field.at(vertices)
    for fraction in (0.0, 0.25, 1.0):
        part = field.at(vertices, fraction)
        expected = Motor.identity((20,)).interpolate(whole, fraction)
        assert np.abs((part.inverse() @ expected).as_twist()).max() < 1e-12


def test_refusals(rng):
    motors = Motor.identity((2,))
    with pytest.raises(ValueError, match="points that all differ"):
        PoseField(np.zeros((2, 3)), motors)
    with pytest.raises(ValueError, match="expected K points"):
        PoseField(rng.standard_normal((3, 3)), motors)
    with pytest.raises(ValueError, match="sharpness"):
        PoseField(rng.standard_normal((2, 3)), motors, 0.0)
