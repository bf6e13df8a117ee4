"""Layers: masks, rest pose where little weighs, and additive poses."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation.blend import PoseLayer, added, additive, blend_layers, blend_poses
from motorcade.ga import Motor, Similarity


def _apart(a: Motor, b: Motor) -> float:
    return float(np.max(np.abs((a.inverse() @ b).as_twist())))


@pytest.fixture
def rest(rng) -> Motor:
    return Motor.random(rng, (5,))


def _near(rest: Motor, rng: np.random.Generator) -> Motor:
    return rest @ Motor.from_twist(0.3 * rng.standard_normal((5, 6)))


def test_layers_of_no_mask_are_a_plain_blend(rest, rng):
    a, b = _near(rest, rng), _near(rest, rng)
    found = blend_layers([PoseLayer(a, 0.3), PoseLayer(b, 0.9)], rest)
    pair = Motor(np.stack([a.coefficients, b.coefficients]))
    assert _apart(found, blend_poses(pair, [0.3, 0.9])) < 1e-14


def test_a_mask_leaves_the_other_joints_to_the_other_layer(rest, rng):
    body, arms = _near(rest, rng), _near(rest, rng)
    upper = np.array([0.0, 0.0, 1.0, 1.0, 0.5])
    found = blend_layers([PoseLayer(body, 1.0, 1.0 - upper), PoseLayer(arms, 1.0, upper)], rest)
    assert _apart(found[:2], body[:2]) < 1e-14
    assert _apart(found[2:4], arms[2:4]) < 1e-14
    assert _apart(found[4], body[4].interpolate(arms[4], 0.5)) < 1e-14


def test_below_the_threshold_the_rest_pose_makes_up_the_weight(rest, rng):
    pose = _near(rest, rng)
    for weight, share in ((0.0, 0.0), (0.025, 0.25), (0.1, 1.0), (0.7, 1.0)):
        found = blend_layers([PoseLayer(pose, weight)], rest, threshold=0.1)
        assert _apart(found, rest.interpolate(pose, share)) < 1e-13
    assert _apart(blend_layers([], rest), rest) < 1e-15


def test_what_is_added_is_what_was_taken_as_difference(rest, rng):
    pose = _near(rest, rng)
    difference = additive(pose, rest)
    assert _apart(added(rest, difference), pose) < 1e-14
    assert _apart(added(pose, difference, -1.0), rest) < 1e-13
    layered = blend_layers([PoseLayer(rest)], rest, additive_layers=[PoseLayer(difference, 0.5)])
    assert _apart(layered, rest.interpolate(pose, 0.5)) < 1e-13


def test_poses_that_grow_mix_with_rigid_ones(rest, rng):
    grown = Similarity.from_motor_scale(_near(rest, rng), 1.3)
    found = blend_layers([PoseLayer(rest, 0.5), PoseLayer(grown, 0.5)], rest, method="similarity")
    np.testing.assert_allclose(found.scale, np.sqrt(1.3), rtol=1e-12)


def test_refusals(rest, rng):
    with pytest.raises(ValueError, match=r"Layer\.weight: expected a number from 0 up, got -1"):
        PoseLayer(rest, -1.0)
    with pytest.raises(ValueError, match=r"Layer\.mask: expected 5 factors from 0 to 1"):
        PoseLayer(rest, 1.0, np.array([0.0, 0.5, 2.0, 0.0, 0.0]))
    with pytest.raises(ValueError, match=r"expected poses of \(5,\) joints"):
        blend_layers([PoseLayer(rest[:3])], rest)
    with pytest.raises(ValueError, match="threshold"):
        blend_layers([PoseLayer(rest)], rest, threshold=0.0)
