"""What a runtime is handed in practice and must refuse or bear: after ozz-animation's job tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Character, Clip, Skeleton, skin
from motorcade.animation.blend import PoseLayer, added, blend_layers, blend_poses
from motorcade.animation.blend.methods import BLEND_METHODS
from motorcade.animation.skin import SKIN_METHODS, PoseRuntime, Skinner
from motorcade.ga import Motor, Similarity

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

    @pytest.mark.parametrize("size", [1e-300, 1e300, 1.7e308])
    def test_weights_may_be_of_any_size(self, poses, method, size):
        one = blend_poses(poses, [0.3, 0.7], method)
        other = blend_poses(poses, [0.3 * size, 0.7 * size], method)
        np.testing.assert_allclose(one.coefficients, other.coefficients, atol=1e-12)

    def test_versors_of_any_sign_are_one_pose_among_many(self, rng, method):
        poses = Motor.from_twist(0.3 * rng.standard_normal((5, 3, 6)))
        signs = rng.choice([-1.0, 1.0], (5, 3, 1))
        one, two = (
            blend_poses(given, [0.1, 0.2, 0.3, 0.1, 0.3], method).as_matrix()
            for given in (poses, Motor(signs * poses.coefficients))
        )
        np.testing.assert_allclose(one, two, atol=1e-9)

    @pytest.mark.parametrize("scale", [None, 2.0])
    def test_half_a_turn_apart_goes_one_way_round(self, method, scale):
        """Both ways are as short: any is right, none at all is not."""
        turns = Motor.from_twist([[[0.0] * 6], [[np.pi, 0.0, 0.0, 0.0, 0.0, 0.0]]])
        given = turns if scale is None else Similarity.from_motor_scale(turns, scale)
        made = blend_poses(given, [0.5, 0.5], method)
        turn = made.rotor.as_rotation_vector()
        np.testing.assert_allclose(np.abs(turn), [[np.pi / 2, 0.0, 0.0]], atol=1e-9)

    def test_equal_poses_blend_to_themselves(self, poses, method):
        same = Motor.stack([poses[0]] * 4)
        made = blend_poses(same, [0.1, 0.0, 3.0, 0.4], method)
        np.testing.assert_allclose(made.as_matrix(), poses[0].as_matrix(), atol=1e-9)

    def test_no_poses_are_refused(self, poses, method):
        with pytest.raises(ValueError, match=r"expected shape \(\*, K, J\), got \(0, 3\)"):
            blend_poses(poses[:0], np.zeros(0), method)
        assert blend_poses(poses[:, :0], [0.5, 0.5], method).shape == (0,)

    def test_thousands_of_joints_blend_each_by_itself(self, rng, method):
        """Joints (and poses in batches) do not see one another."""
        poses = Motor.from_twist(0.5 * rng.standard_normal((3, 4000, 6)))
        weights = rng.uniform(0.0, 1.0, (3, 4000))
        whole = blend_poses(poses, weights, method)
        some = slice(1234, 1290)
        alone = blend_poses(poses[:, some], weights[:, some], method)
        np.testing.assert_allclose(whole[some].coefficients, alone.coefficients, atol=1e-9)

    def test_layers_bear_masks_of_nothing(self, skeleton, poses, method):
        empty = PoseLayer(poses[0], 1.0, np.zeros(3))
        alone = blend_layers([empty], skeleton.rest, method=method)
        np.testing.assert_allclose(alone.as_matrix(), skeleton.rest.as_matrix(), atol=1e-12)
        both = blend_layers([empty, PoseLayer(poses[1])], skeleton.rest, method=method)
        np.testing.assert_allclose(both.as_matrix(), poses[1].as_matrix(), atol=1e-9)


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        ([0.5, -0.1, 1.0], "from -0.1 to 1"),
        ([0.5, np.nan, 1.0], "finite"),
        ([0.5, 1.0, 1.5], "to 1.5"),
        ([], "expected 3 factors"),
        (0.5, "expected 3 factors"),
    ],
)
def test_masks_that_are_none_are_refused(poses, mask, message):
    with pytest.raises(ValueError, match=rf"PoseLayer\.mask.*{message}"):
        PoseLayer(poses[0], 1.0, np.array(mask))


@pytest.mark.parametrize("weight", [-0.1, np.nan, np.inf])
def test_weights_of_layers_that_are_none_are_refused(skeleton, poses, weight):
    with pytest.raises(ValueError, match=r"PoseLayer\.weight: expected a number from 0 up, got"):
        PoseLayer(poses[0], weight)
    with pytest.raises(ValueError, match="threshold"):
        blend_layers([PoseLayer(poses[0])], skeleton.rest, threshold=-abs(weight))
    if not np.isfinite(weight):
        with pytest.raises(ValueError, match=r"added\(weights\): expected finite"):
            added(poses[0], poses[1], weight)


def test_a_pose_of_no_joints_is_no_layer(poses):
    with pytest.raises(ValueError, match=r"PoseLayer\.pose: expected shape \(\*, J\), got \(\)"):
        PoseLayer(poses[0, 0])


def test_layers_of_other_skeletons_are_refused(skeleton, poses):
    with pytest.raises(ValueError, match=r"expected poses of \(3,\) joints"):
        blend_layers([PoseLayer(poses[0][:2])], skeleton.rest)
    with pytest.raises(ValueError, match="expected 3 factors from 0 to 1"):
        PoseLayer(poses[0], 1.0, np.ones(2))


def test_layers_without_weight_are_the_rest_pose(skeleton, poses):
    made = blend_layers([PoseLayer(poses[0], 0.0)], skeleton.rest)
    np.testing.assert_allclose(made.coefficients, skeleton.rest.coefficients, atol=1e-15)
    half = blend_layers([PoseLayer(poses[0], 0.0), PoseLayer(poses[1], 1.0)], skeleton.rest)
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


@pytest.mark.parametrize("method", SKIN_METHODS)
@pytest.mark.parametrize("size", [1, 100])
def test_joints_without_weight_do_not_matter(skeleton, rng, method, size):
    """Wherever they stand in the list, and even where the others are opposite as seen from them."""
    vertices = np.repeat(
        _character(skeleton, np.tile([0.0, 0.5, 0.5, 0.0], (3, 1))).vertices, size, axis=0
    )
    count = len(vertices)
    figure = Character(
        skeleton, vertices, np.tile([1.0, 0, 0], (count, 1)), np.array([[0, 1, 2]]),
        np.full((count, 3), 0.5), np.tile([0, 1, 2, 0], (count, 1)),
        np.tile([0.0, 0.5, 0.5, 0.0], (count, 1)),
    )  # fmt: skip
    others = Motor.from_twist(0.4 * rng.standard_normal((3, 6)))
    world = skeleton.world(skeleton.rest @ others)
    found = []
    for wild in (Motor.identity(), Motor.from_twist([3.0, 1.0, -2.0, 5.0, -7.0, 1.0])):
        moved = np.array(world.coefficients)
        moved[0] = wild.coefficients
        placed = Motor(moved)
        local = Motor.stack(
            [placed[0], placed[0].inverse() @ placed[1], placed[1].inverse() @ placed[2]]
        )
        found.append((*skin(figure, local, method), *Skinner(figure, method).skin(local)))
    for one, two, tolerance in zip(*found, (1e-12, 1e-12, 2e-5, 2e-5), strict=True):
        np.testing.assert_allclose(one, two, atol=tolerance)
    turns = Motor.from_twist([[0, 0, t, 0, 0, 0.0] for t in (0.0, np.pi, -np.pi)])
    opposite = Motor.stack([turns[0], turns[1], turns[1].inverse() @ turns[2]])
    bound = Skeleton(skeleton.names, PARENTS, Motor.identity((3,)))
    figure = replace(figure, skeleton=bound)
    expected = vertices * [-1.0, -1.0, 1.0]
    np.testing.assert_allclose(skin(figure, opposite, method)[0], expected, atol=1e-9)
    np.testing.assert_allclose(Skinner(figure, method).skin(opposite)[0], expected, atol=1e-5)


@pytest.mark.parametrize("shape", ["chain", "star"])
def test_thousands_of_joints_stand_where_products_of_matrices_put_them(rng, shape):
    count = 3000
    parents = np.arange(count) - 1 if shape == "chain" else np.minimum(np.arange(count) - 1, 0)
    many = Skeleton(tuple(map(str, range(count))), parents, Motor.identity((count,)))
    local = Motor.from_twist(0.01 * rng.standard_normal((count, 6)))
    expected = local.as_matrix()
    for joint in range(1, count):
        expected[joint] = expected[parents[joint]] @ expected[joint]
    np.testing.assert_allclose(many.world(local).as_matrix(), expected, atol=1e-9)
    still = Clip("c", np.zeros(1), local.reshape(1, count))
    found = PoseRuntime(many, [still]).palette([(0, 0.0, 1.0)]).reshape(count, 3, 4)
    np.testing.assert_allclose(found, expected[:, :3], atol=2e-3)
    vertices = rng.standard_normal((count, 3))
    weights, joints = np.zeros((count, 4)), np.zeros((count, 4), dtype=np.int64)
    weights[:, 0], joints[:, 0] = 1.0, np.arange(count)
    figure = Character(
        many,
        vertices,
        np.tile([1.0, 0, 0], (count, 1)),
        np.array([[0, 1, 2]]),
        np.full((count, 3), 0.5),
        joints,
        weights,
    )
    moved = np.einsum("vij,vj->vi", expected[:, :3, :3], vertices) + expected[:, :3, 3]
    for method in SKIN_METHODS:
        np.testing.assert_allclose(skin(figure, local, method)[0], moved, atol=1e-9)
        np.testing.assert_allclose(Skinner(figure, method).skin(local)[0], moved, atol=1e-4)


def test_more_joints_than_numbers_of_two_bytes_are_refused():
    count = 65537
    many = Skeleton(tuple(map(str, range(count))), np.full(count, -1), Motor.identity((count,)))
    with pytest.raises(ValueError, match="expected up to 65536 joints, got 65537"):
        Skinner(_character(many, np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))))


@pytest.mark.parametrize("entries", [np.zeros((3, 8)), np.zeros((8, 3), np.float32).T])
def test_palettes_of_other_types_are_refused(skeleton, entries):
    skinner = Skinner(_character(skeleton, np.tile([1.0, 0, 0, 0], (3, 1))))
    with pytest.raises(TypeError):
        skinner.skin_palette(entries)


@pytest.mark.parametrize("method", ["motor_linear", "motor"])
def test_the_runtime_refuses_what_it_cannot_play(skeleton, rng, method):
    time_s = np.array([0.0, 1.0])
    still = Clip("still", time_s, Motor.stack([skeleton.rest] * 2))
    runtime = PoseRuntime(skeleton, [still], method)
    for layers in (
        [],
        [(1, 0.0, 1.0)],
        [(0, np.nan, 1.0)],
        [(0, 0.0, -1.0)],
        [(0, 0.0, 0.0)],
        [(0, 0.0, np.nan)],
        [(0, np.inf, 1.0)],
    ):
        with pytest.raises(ValueError, match=r"layer|time|weight|clip"):
            runtime.palette(layers)
    with pytest.raises(ValueError, match="from 0 to 0, got -1"):
        runtime.palette([(-1, 0.0, 1.0)])
    with pytest.raises(ValueError, match="expected rigid poses of 3 joints"):
        PoseRuntime(skeleton, [Clip("few", time_s, Motor.random(rng, (2, 2)))], method)
    flipped = Motor(still.poses.coefficients * [[[1.0]], [[-1.0]]])
    moved = PoseRuntime(skeleton, [Clip("flipped", time_s, flipped)], method)
    np.testing.assert_allclose(
        moved.palette([(0, 0.5, 1.0)]), runtime.palette([(0, 0.5, 1.0)]), atol=1e-6
    )
