"""What a runtime is handed in practice and must refuse or bear: after ozz-animation's job tests."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Character, Clip, PoseRuntime, Skeleton, Skinner, skin
from motorcade.animation.blend import BLEND_METHODS, Layer, blend_layers, blend_poses
from motorcade.animation.skin import SKIN_METHODS
from motorcade.ga import Motor

PARENTS = np.array([-1, 0, 1])


@pytest.fixture
def skeleton() -> Skeleton:
    shifts = np.concatenate([np.zeros((3, 3)), [[0, 0, 1.0], [0, 0, 0.5], [0, 0, 0.5]]], axis=1)
    return Skeleton(("root", "middle", "end"), PARENTS, Motor.from_twist(shifts))


@pytest.fixture
def poses(rng) -> Motor:
    return Motor.random(rng, (2, 3))


def _character(skeleton: Skeleton, weights: np.ndarray) -> Character:
    vertices = np.array([[0.1, 0, 0.2], [0, 0.1, 0.8], [0, 0, 1.4]])
    normals, colors = np.tile([1.0, 0, 0], (3, 1)), np.full((3, 3), 0.5)
    joints = np.tile([0, 1, 2, 0], (3, 1))
    return Character(skeleton, vertices, normals, np.array([[0, 1, 2]]), colors, joints, weights)


@pytest.mark.parametrize("method", BLEND_METHODS)
class TestBlending:
    def test_no_weight_at_all_is_refused(self, poses, method):
        with pytest.raises(ValueError, match="weights"):
            blend_poses(poses, [0.0, 0.0], method)
        with pytest.raises(ValueError, match="weights"):
            blend_poses(poses, np.stack([[1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]), method)

    @pytest.mark.parametrize("weights", [[1.0, -0.5], [np.nan, 1.0], [np.inf, 1.0]])
    def test_weights_that_are_none_are_refused(self, poses, method, weights):
        with pytest.raises(ValueError, match="weights"):
            blend_poses(poses, weights, method)

    def test_only_ratios_of_weights_count(self, poses, method):
        one, other = (blend_poses(poses, w, method) for w in ([0.3, 0.7], [30.0, 70.0]))
        np.testing.assert_allclose(one.coefficients, other.coefficients, atol=1e-12)

    def test_antipodal_versors_are_one_pose(self, poses, method):
        """The same poses written with the other sign blend to the same."""
        other = Motor(poses.coefficients * [[[1.0]] * 3, [[-1.0]] * 3])
        one, two = (
            blend_poses(given, [0.4, 0.6], method).apply([0.1, 0.2, 0.3])
            for given in (poses, other)
        )
        np.testing.assert_allclose(one, two, atol=1e-9)

    def test_a_weight_of_zero_leaves_the_other_pose(self, poses, method):
        alone = blend_poses(poses, [0.0, 1.0], method)
        np.testing.assert_allclose(
            alone.apply([0.1, 0.2, 0.3]), poses[1].apply([0.1, 0.2, 0.3]), atol=1e-9
        )


def test_layers_of_other_skeletons_are_refused(skeleton, poses):
    with pytest.raises(ValueError, match=r"expected poses of \(3,\) joints"):
        blend_layers([Layer(poses[0][:2])], skeleton.rest)
    with pytest.raises(ValueError, match="expected 3 factors from 0 to 1"):
        Layer(poses[0], 1.0, np.ones(2))


def test_layers_without_weight_are_the_rest_pose(skeleton, poses):
    made = blend_layers([Layer(poses[0], 0.0)], skeleton.rest)
    np.testing.assert_allclose(made.coefficients, skeleton.rest.coefficients, atol=1e-15)
    half = blend_layers([Layer(poses[0], 0.0), Layer(poses[1], 1.0)], skeleton.rest)
    np.testing.assert_allclose(half.apply([0, 0, 0.1]), poses[1].apply([0, 0, 0.1]), atol=1e-12)


@pytest.mark.parametrize("broken", [np.nan, np.inf])
def test_keys_that_are_no_numbers_are_refused(skeleton, broken):
    rows = np.stack([skeleton.rest.coefficients] * 2)
    rows[1, 1, 3] = broken
    with pytest.raises(ValueError, match="Motor"):
        Motor(rows)
    good = Motor.stack([skeleton.rest] * 2)
    with pytest.raises(ValueError, match="time_s"):
        Clip("c", np.array([0.0, broken]), good)
    with pytest.raises(ValueError, match="time_s"):
        Clip("c", np.array([0.0, 1.0]), good).at(broken)


def test_versors_that_are_not_unit_are_refused(skeleton):
    with pytest.raises(ValueError, match="Motor"):
        Motor(1.1 * skeleton.rest.coefficients)


@pytest.mark.parametrize("parents", [[-1, 2, 1], [1, 0, 1], [-1, 1, 0], [-1, -2, 0]])
def test_cycles_and_children_before_parents_are_refused(parents):
    with pytest.raises(ValueError, match=r"Skeleton\.parents"):
        Skeleton(("a", "b", "c"), np.array(parents), Motor.identity((3,)))


@pytest.mark.parametrize(
    "row", [[0.0, 0, 0, 0], [0.5, 0.6, 0, 0], [1.5, -0.5, 0, 0], [np.nan, 1.0, 0, 0]]
)
def test_skinning_weights_that_are_no_shares_are_refused(skeleton, row):
    weights = np.tile([1.0, 0, 0, 0], (3, 1))
    weights[1] = row
    with pytest.raises(ValueError, match=r"Character\.weights"):
        _character(skeleton, weights)


@pytest.mark.parametrize("method", SKIN_METHODS)
def test_skinning_bears_antipodal_joints_and_refuses_missing_ones(skeleton, rng, method):
    figure = _character(skeleton, np.tile([0.2, 0.3, 0.5, 0.0], (3, 1)))
    turns = Motor.from_twist(0.4 * rng.standard_normal((3, 6)))
    pose = skeleton.rest @ turns
    other = Motor(pose.coefficients * [[1.0], [-1.0], [1.0]])
    for one, two in zip(skin(figure, pose, method), skin(figure, other, method), strict=True):
        np.testing.assert_allclose(one, two, atol=1e-12)
    for one, two in zip(
        Skinner(figure, method).skin(other), skin(figure, pose, method), strict=True
    ):
        np.testing.assert_allclose(one, two, atol=1e-5)
    with pytest.raises(ValueError, match="shape"):
        skin(figure, pose[:2], method)
    with pytest.raises(ValueError, match="shape"):
        Skinner(figure, method).skin(pose[:2])


@pytest.mark.parametrize("method", ["motor_linear", "motor"])
def test_the_runtime_refuses_what_it_cannot_play(skeleton, rng, method):
    time_s = np.array([0.0, 1.0])
    still = Clip("still", time_s, Motor.stack([skeleton.rest] * 2))
    runtime = PoseRuntime(skeleton, [still], method)
    for layers in ([], [(1, 0.0, 1.0)], [(0, np.nan, 1.0)], [(0, 0.0, -1.0)],
                   [(0, 0.0, 0.0)], [(0, 0.0, np.nan)], [(0, np.inf, 1.0)]):  # fmt: skip
        with pytest.raises(ValueError, match=r"layer|time|weight|clip"):
            runtime.palette(layers)
    with pytest.raises(ValueError, match="from 0 to 0, got -1"):
        runtime.palette([(-1, 0.0, 1.0)])
    with pytest.raises(ValueError, match="expected rigid poses of 3 joints"):
        PoseRuntime(skeleton, [Clip("few", time_s, Motor.random(rng, (2, 2)))], method)
    flipped = Motor(still.poses.coefficients * [[[1.0]], [[-1.0]]])
    moved = PoseRuntime(skeleton, [Clip("flipped", time_s, flipped)], method)
    np.testing.assert_allclose(moved.palette([(0, 0.5, 1.0)]), runtime.palette([(0, 0.5, 1.0)]),
                               atol=1e-6)  # fmt: skip
