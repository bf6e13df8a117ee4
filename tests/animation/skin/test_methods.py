"""Skinning by four methods: ties, volumes, growth, and the compiled path against the plain one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Character, Skeleton
from motorcade.animation.clip import MorphTarget
from motorcade.animation.skin import SKIN_METHODS, Skinner, palette, skin
from motorcade.ga import DualQuaternion, Motor, Similarity, kernels


@pytest.fixture
def tube() -> Character:
    """A tube of 2 m along x about two joints, weights running over from one to the other."""
    rings, around = 41, 24
    x = np.linspace(0.0, 2.0, rings)
    angle = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=1)
    normals = np.tile(ring, (rings, 1))
    vertices = 0.2 * normals + np.repeat(x, around)[:, None] * [1.0, 0.0, 0.0]
    share = np.clip(np.repeat(x, around) - 0.5, 0.0, 1.0)
    weights = np.stack([1.0 - share, share, 0 * share, 0 * share], axis=1)
    joints = np.tile([0, 1, 0, 0], (len(vertices), 1))
    i = np.arange(around * (rings - 1))
    after = i // around * around + (i + 1) % around
    triangles = np.concatenate(
        [np.stack([i, i + around, after], 1), np.stack([after, i + around, after + around], 1)]
    )
    rest = Motor.from_twist([[0.0] * 6, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]])
    skeleton = Skeleton(("upper", "lower"), np.array([-1, 0]), rest)
    colors = np.full(vertices.shape, 0.5)
    return Character(skeleton, vertices, normals, triangles, colors, joints, weights)


def _bent(tube: Character, *turn: float) -> Motor:
    turned = Motor.from_twist([*turn, 0.0, 0.0, 0.0])
    return Motor(
        np.stack(
            [tube.skeleton.rest[0].coefficients, (tube.skeleton.rest[1] @ turned).coefficients]
        )
    )


def _radius(vertices: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vertices.reshape(41, 24, 3)[..., 1:], axis=-1)


@pytest.mark.parametrize("method", SKIN_METHODS)
def test_in_the_rest_pose_nothing_moves(tube, method):
    vertices, normals = skin(tube, tube.skeleton.rest, method)
    np.testing.assert_allclose(vertices, tube.vertices, atol=1e-14)
    np.testing.assert_allclose(normals, tube.normals, atol=1e-14)


@pytest.mark.parametrize("method", SKIN_METHODS)
def test_vertices_of_one_joint_move_as_it_does(tube, method):
    pose = _bent(tube, 0.3, -0.8, 1.1)
    vertices, normals = skin(tube, pose, method)
    held = tube.weights[:, 1] == 1.0
    moved = (tube.skeleton.world(pose) @ tube.skeleton.rest_world_inverse)[1]
    np.testing.assert_allclose(vertices[held], moved.apply(tube.vertices[held]), atol=1e-14)
    turned = moved.rotor.apply(tube.normals[held])
    np.testing.assert_allclose(normals[held], turned, atol=1e-14)


def test_motors_and_dual_quaternions_are_one(tube, rng):
    pose = Motor.random(rng, (6, 2))
    by_motor, by_dual = skin(tube, pose, "motor"), skin(tube, pose, "dual_quaternion")
    np.testing.assert_allclose(by_motor[0], by_dual[0], atol=1e-13)
    np.testing.assert_allclose(by_motor[1], by_dual[1], atol=1e-13)
    np.testing.assert_allclose(by_motor[0], skin(tube, pose, "similarity")[0], atol=1e-12)
    assert np.abs(by_motor[0] - skin(tube, pose, "linear")[0]).max() > 1e-2


def test_dual_quaternions_are_those_of_the_rival_values(tube, rng):
    pose = Motor.random(rng, (2,))
    entries = DualQuaternion(palette(tube.skeleton, pose, "dual_quaternion")[0])
    vertices, _ = skin(tube, pose, "dual_quaternion")
    for v in rng.integers(0, len(vertices), 20):
        blended = entries[tube.joints[v, :2]].blend(tube.weights[v, :2])
        np.testing.assert_allclose(vertices[v], blended.apply(tube.vertices[v]), atol=1e-13)


def test_a_twisted_tube_keeps_its_width_but_under_linear(tube):
    pose = _bent(tube, 0.9 * np.pi, 0.0, 0.0)
    assert _radius(skin(tube, pose, "linear")[0]).min() < 0.05
    for method in ("dual_quaternion", "motor", "similarity"):
        np.testing.assert_allclose(_radius(skin(tube, pose, method)[0]), 0.2, atol=1e-12)


@pytest.mark.parametrize("method", SKIN_METHODS)
def test_normals_stand_on_the_surface(tube, method):
    vertices, normals = skin(tube, _bent(tube, 0.4, 0.0, 0.0), method)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-12)
    rings, across = vertices.reshape(41, 24, 3), normals.reshape(41, 24, 3)
    along = np.roll(rings, -1, axis=1) - np.roll(rings, 1, axis=1)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    assert np.abs(np.sum(along * across, axis=-1)).max() < 0.05


def test_joints_that_grow_make_the_mesh_grow_under_every_method(tube):
    grown = Similarity.from_motor_scale(tube.skeleton.rest, [1.0, 1.5])
    far = tube.weights[:, 1] == 1.0
    expected = (tube.vertices[far] - [1.0, 0.0, 0.0]) * 1.5 + [1.0, 0.0, 0.0]
    for method in SKIN_METHODS:
        np.testing.assert_allclose(skin(tube, grown, method)[0][far], expected, atol=1e-12)


@pytest.mark.parametrize("method", SKIN_METHODS)
@pytest.mark.parametrize("threads", [1, 3])
def test_the_compiled_path_is_the_plain_one_in_single_precision(tube, method, threads, rng):
    pose = Motor.random(rng, (2,))
    before = kernels.threads()
    kernels.set_threads(threads)
    try:
        found = Skinner(tube, method).skin(pose)
    finally:
        kernels.set_threads(before)
    expected = skin(tube, pose, method)
    assert found[0].dtype == np.float32
    np.testing.assert_allclose(found[0], expected[0], atol=3e-6)
    np.testing.assert_allclose(found[1], expected[1], atol=3e-6)


@pytest.mark.parametrize("method", SKIN_METHODS)
def test_morph_targets_are_mixed_in_before_the_compiled_path_too(tube, method, rng):
    rows = np.arange(0, len(tube.vertices), 3)
    moved, turned = 0.1 * rng.standard_normal((2, len(rows), 3))
    tube = replace(tube, morphs=(MorphTarget("bulge", rows, moved, turned),))
    pose, skinner = _bent(tube, 0.2, 0.3, -0.4), Skinner(tube, method)
    for weights in (None, [0.7], [0.7], [-0.2], None, [0.0]):
        found = skinner.skin(pose, weights)
        shaped = tube if weights is None else tube.shaped(weights)
        for one, expected in zip(found, skin(shaped, pose, method), strict=True):
            np.testing.assert_allclose(one, expected, atol=3e-6)
    with pytest.raises(ValueError, match=r"morphed.weights.: expected 1, got shape \(2,\)"):
        skinner.skin(pose, [0.1, 0.2])


@pytest.mark.parametrize("most", [4, 8])
@pytest.mark.parametrize("method", SKIN_METHODS)
def test_weights_of_zero_may_stand_anywhere(tube, method, most, rng):
    """Vertices that follow one to eight joints, in any order, and no whole blocks of them."""
    count = 203
    rest = Motor.random(rng, (5,))
    skeleton = Skeleton(tuple("abcde"), np.array([-1, 0, 1, 0, 3]), rest)
    weights = rng.uniform(0.1, 1.0, (count, most)) * (rng.uniform(size=(count, most)) < 0.5)
    weights[~np.any(weights, axis=1), rng.integers(most)] = 1.0
    weights /= weights.sum(axis=1, keepdims=True)
    assert np.any(weights[:, 0] == 0.0)
    triangles = np.arange(201).reshape(-1, 3)
    figure = Character(
        skeleton,
        rng.standard_normal((count, 3)),
        np.tile([0.0, 0.0, 1.0], (count, 1)),
        triangles,
        np.full((count, 3), 0.5),
        rng.integers(0, 5, (count, most)),
        weights,
    )
    pose = rest @ Motor.from_twist(0.4 * rng.standard_normal((5, 6)))
    found, expected = Skinner(figure, method).skin(pose), skin(figure, pose, method)
    np.testing.assert_allclose(found[0], expected[0], atol=2e-5)
    np.testing.assert_allclose(found[1], expected[1], atol=2e-5)


def test_refusals(tube):
    with pytest.raises(ValueError, match="expected one of linear, dual_quaternion, motor, sim"):
        skin(tube, tube.skeleton.rest, "spherical")
    with pytest.raises(ValueError, match="use 'similarity' or 'linear'"):
        Skinner(tube, "motor").skin(Similarity.from_motor_scale(tube.skeleton.rest, [1.0, 1.5]))
    with pytest.raises(ValueError, match="palette: expected a row a joint"):
        Skinner(tube, "motor").skin_palette(np.zeros((2, 12), np.float32))
