"""Linear blend skinning against closed forms and against the plain formula, vertex by vertex."""

import numpy as np
import pytest

from motorcade.animation import Character, mannequin, skin
from motorcade.ga import Motor, Rotor


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


def test_rest_pose_gives_the_bound_vertices(figure: Character) -> None:
    vertices, normals = skin(figure, figure.skeleton.rest)
    np.testing.assert_allclose(vertices, figure.vertices, atol=1e-12)
    np.testing.assert_allclose(normals, figure.normals, atol=1e-12)


def test_moving_the_root_moves_every_vertex_rigidly(
    figure: Character, rng: np.random.Generator
) -> None:
    motion = Motor.random(rng, (3,))
    rest = figure.skeleton.rest
    root = motion[:, None] @ rest[:1]
    others = np.broadcast_to(rest[1:].coefficients, (3, len(figure.skeleton) - 1, 8))
    pose = Motor(np.concatenate([root.coefficients, others], axis=1))
    vertices, normals = skin(figure, pose)
    np.testing.assert_allclose(vertices, motion[:, None].apply(figure.vertices), atol=1e-11)
    turned = motion[:, None].rotor.apply(figure.normals)
    np.testing.assert_allclose(normals, turned, atol=1e-11)


def test_skinning_is_the_weighted_sum_over_joints(
    figure: Character, rng: np.random.Generator
) -> None:
    bend = Rotor.from_rotation_vector(0.4 * rng.standard_normal((len(figure.skeleton), 3)))
    rest = figure.skeleton.rest
    pose = Motor.from_rotor_translation(rest.rotor @ bend, rest.translation_m)
    vertices, _ = skin(figure, pose)
    world = figure.skeleton.world(pose).as_matrix()
    bound = np.linalg.inv(figure.skeleton.rest_world.as_matrix())
    for v in rng.choice(len(figure.vertices), 40, replace=False):
        blend = sum(
            figure.weights[v, k] * world[figure.joints[v, k]] @ bound[figure.joints[v, k]]
            for k in range(4)
        )
        expected = np.asarray(blend) @ np.append(figure.vertices[v], 1.0)
        np.testing.assert_allclose(vertices[v], expected[:3], atol=1e-12)


def test_a_batch_of_poses_is_skinned_as_its_members(figure: Character) -> None:
    poses = figure.clip("walk").at(np.array([[0.1, 0.4], [0.7, 0.9]]))
    vertices, normals = skin(figure, poses)
    assert vertices.shape == (2, 2, len(figure.vertices), 3)
    alone, alone_normals = skin(figure, poses[1, 0])
    np.testing.assert_allclose(vertices[1, 0], alone, atol=1e-13)
    np.testing.assert_allclose(normals[1, 0], alone_normals, atol=1e-13)


def test_skinned_normals_stay_close_to_those_of_the_skinned_triangles(figure: Character) -> None:
    vertices, normals = skin(figure, figure.clip("walk").at(0.3))
    corners = vertices[figure.triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(face, axis=1)
    mean = normals[figure.triangles].mean(axis=1)
    agree = np.sum(face * mean, axis=1) / area / np.linalg.norm(mean, axis=1)
    assert np.average(agree, weights=area) > 0.97
    assert np.percentile(agree[area > np.percentile(area, 5)], 1) > 0.5


def test_a_pose_of_another_skeleton_is_refused(figure: Character) -> None:
    with pytest.raises(ValueError, match="expected shape"):
        skin(figure, Motor.identity((7,)))
