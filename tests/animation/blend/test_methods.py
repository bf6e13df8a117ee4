"""Blending by every method: ends, ties that theory predicts, and laws of each.

Witnesses: scipy's slerp, and the screw by the matrix logarithm.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm, logm
from scipy.spatial.transform import Rotation, Slerp

from motorcade.animation.blend import blend_poses
from motorcade.animation.blend.methods import BLEND_METHODS
from motorcade.ga import Motor, Similarity

JOINTS = 9
SCREWS = ("motor", "similarity", "dual_quaternion")
SUMS = ("motor_linear", "similarity_linear", "dual_quaternion_linear")
TURNS, TURN_SUMS = ("rotor", "quaternion"), ("rotor_linear", "quaternion_linear")


def _poses(rng: np.random.Generator, count: int, spread: float = 0.4) -> Motor:
    """Poses (4, count, J) near one another, one joint without any difference."""
    base = Motor.random(rng, (4, 1, JOINTS))
    twists = spread * rng.standard_normal((4, count, JOINTS, 6))
    twists[..., 0, :] = 0.0
    return base @ Motor.from_twist(twists)


def _apart(a: Motor, b: Motor) -> float:
    return float(np.max(np.abs((a.inverse() @ b).as_twist())))


@pytest.mark.parametrize("method", BLEND_METHODS)
def test_a_share_of_one_gives_the_pose_itself(method, rng):
    poses = _poses(rng, 3)
    for k, weights in enumerate(np.eye(3)):
        blended = blend_poses(poses, weights, method)
        np.testing.assert_allclose(blended.as_matrix(), poses[:, k].as_matrix(), rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", BLEND_METHODS)
def test_only_ratios_of_weights_count_and_masks_give_each_joint_its_own(method, rng):
    poses = _poses(rng, 3)
    weights = rng.uniform(0.1, 1.0, (4, 3, JOINTS))
    whole = blend_poses(poses, weights, method)
    assert _apart(whole, blend_poses(poses, 7.0 * weights, method)) < 1e-12
    alone = blend_poses(poses[1:2, :, 4:5], weights[1:2, :, 4:5], method)
    assert _apart(whole[1:2, 4:5], alone) < 1e-11


@pytest.mark.parametrize("count", [2, 3, 5])
@pytest.mark.parametrize("group", [SCREWS, SUMS, TURNS, TURN_SUMS])
def test_methods_that_theory_calls_one_are_one(group, count, rng):
    poses = _poses(rng, count)
    weights = rng.uniform(0.1, 1.0, (4, count))
    first = blend_poses(poses, weights, group[0])
    for other in group[1:]:
        assert _apart(first, blend_poses(poses, weights, other)) < 1e-11


def test_methods_that_differ_by_theory_differ(rng):
    poses, weights = _poses(rng, 2), np.array([0.3, 0.7])
    by_group = [blend_poses(poses, weights, group[0]) for group in (SCREWS, SUMS, TURNS)]
    assert _apart(by_group[0], by_group[1]) > 1e-3
    assert _apart(by_group[0], by_group[2]) > 1e-3
    assert _apart(blend_poses(poses, weights, "euler"), by_group[0]) > 1e-3


def test_the_screw_is_that_of_the_matrix_logarithm(rng):
    a, b = Motor.random(rng), Motor.random(rng)
    pair = Motor(np.stack([a.coefficients, b.coefficients])[:, None])
    between = np.linalg.inv(a.as_matrix()) @ b.as_matrix()
    for fraction in (0.1, 0.5, 0.83):
        expected = a.as_matrix() @ np.real(expm(fraction * logm(between)))
        found = blend_poses(pair, [1 - fraction, fraction], "motor")
        np.testing.assert_allclose(found.as_matrix()[0], expected, atol=1e-10)


def test_the_screw_has_constant_speed_and_the_sum_has_not(rng):
    pair = _poses(rng, 2, spread=1.0)[0]
    fractions = np.linspace(0.0, 1.0, 11)
    weights = np.stack([1 - fractions, fractions], axis=-1)
    repeated = Motor(np.broadcast_to(pair.coefficients, (11, *pair.coefficients.shape)))
    speeds = {}
    for method in ("motor", "motor_linear"):
        path = blend_poses(repeated, weights, method)
        steps = (path[:-1].inverse() @ path[1:]).as_twist()
        speeds[method] = np.linalg.norm(steps, axis=-1)[:, 1:]
    assert np.ptp(speeds["motor"], axis=0).max() < 1e-12
    assert np.ptp(speeds["motor_linear"], axis=0).max() > 1e-3


def test_slerp_beside_lerp_is_scipys(rng):
    pair = _poses(rng, 2)[0]
    found = blend_poses(pair, [0.4, 0.6], "quaternion")
    wxyz, translation = pair.as_quaternion_translation()
    for joint in range(JOINTS):
        turns = Rotation.from_quat(wxyz[:, joint], scalar_first=True)
        expected = Slerp([0.0, 1.0], turns)(0.6).as_matrix()
        np.testing.assert_allclose(found[joint].rotor.as_matrix(), expected, atol=1e-12)
    np.testing.assert_allclose(
        found.translation_m, 0.4 * translation[0] + 0.6 * translation[1], atol=1e-12
    )


@pytest.mark.parametrize("method", [name for name in BLEND_METHODS if name != "euler"])
def test_the_other_sign_of_a_motor_changes_nothing(method, rng):
    poses = _poses(rng, 2)
    flipped = np.array(poses.coefficients)
    flipped[:, 1] *= -1.0
    weights = [0.3, 0.7]
    assert (
        _apart(blend_poses(poses, weights, method), blend_poses(Motor(flipped), weights, method))
        < 1e-12
    )


@pytest.mark.parametrize("method", BLEND_METHODS)
def test_scales_blend_beside_or_with_the_rest(method, rng):
    motors, scale = _poses(rng, 2), rng.uniform(0.5, 2.0, (4, 2, JOINTS))
    grown = blend_poses(Similarity.from_motor_scale(motors, scale), [0.25, 0.75], method)
    weighted = 0.25 * scale[:, 0] + 0.75 * scale[:, 1]
    geometric = scale[:, 0] ** 0.25 * scale[:, 1] ** 0.75
    if method == "similarity":
        np.testing.assert_allclose(grown.scale, geometric, rtol=1e-12)
    elif method != "similarity_linear":
        np.testing.assert_allclose(grown.scale, weighted, rtol=1e-12)
    else:
        assert np.all(grown.scale >= scale.min(axis=1) - 1e-12)
        assert np.all(grown.scale <= scale.max(axis=1) + 1e-12)


def test_refusals_name_what_is_wrong(rng):
    poses = _poses(rng, 2)
    for weights, message in (
        ([0.5, np.nan], "finite"),
        ([0.5, -0.5], "shares >= 0"),
        ([0.0, 0.0], "above 0 for every joint"),
        ([1.0, 1.0, 1.0], r"expected shape \(\*, 2\)"),
    ):
        with pytest.raises(ValueError, match=message):
            blend_poses(poses, weights)
    with pytest.raises(ValueError, match="expected one of motor, motor_linear"):
        blend_poses(poses, [1.0, 1.0], "slerp")
    with pytest.raises(ValueError, match=r"\(\*, K, J\)"):
        blend_poses(poses[0, 0], [1.0])
    opposite = Motor.from_twist([[[0.0] * 6], [[np.pi, 0.0, 0.0, 0.0, 0.0, 0.0]]])
    blended = blend_poses(opposite, [0.5, 0.5], "motor_linear")  # a tie, not a cancellation
    assert np.isfinite(blended.coefficients).all()
