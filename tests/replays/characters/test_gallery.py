"""What the gallery's captions say: volumes by method of skinning, measured on the closed mesh."""

from __future__ import annotations

import numpy as np
import pytest

from docs.making.gallery import ELBOW, SHOULDER, bent, volumes_l
from motorcade.animation import mannequin


@pytest.fixture(scope="module")
def figure():
    return mannequin()


def test_the_mesh_is_closed_and_its_volume_that_of_its_height(figure):
    rest = volumes_l(figure, figure.skeleton.rest)
    for name, volume in rest.items():
        assert volume == pytest.approx(rest["rest"], rel=1e-9), name
    assert 120.0 < rest["rest"] < 190.0  # a big head and a padded jacket
    trimesh = pytest.importorskip("trimesh")
    body = trimesh.Trimesh(figure.vertices, figure.triangles, process=False)
    body.merge_vertices(merge_tex=True, merge_norm=True)  # at seams of the texture
    assert body.is_watertight
    assert rest["rest"] == pytest.approx(1e3 * body.volume, rel=1e-9)


def test_a_twisted_elbow_keeps_its_volume_under_rigid_methods_alone(figure):
    found = volumes_l(figure, bent(figure, *ELBOW))
    lost = {name: found["rest"] - volume for name, volume in found.items()}
    assert lost["linear"] > 0.3
    for name in ("dual_quaternion", "motor", "similarity"):
        assert abs(lost[name]) < 5e-4 * found["rest"]
    assert found["motor"] == pytest.approx(found["dual_quaternion"], rel=1e-12)
    assert found["motor"] == pytest.approx(found["similarity"], rel=1e-9)


def test_a_raised_shoulder_loses_volume_under_linear_and_gains_some_under_the_others(figure):
    found = volumes_l(figure, bent(figure, *SHOULDER))
    assert found["linear"] < found["motor"] - 0.2
    assert abs(found["motor"] / found["rest"] - 1.0) < 0.02


def test_bending_turns_one_joint_in_its_own_axes(figure):
    pose = bent(figure, "left_hand", (0.0, 0.5, 0.0))
    turn = (figure.skeleton.rest.inverse() @ pose).rotor.as_rotation_vector()
    number = figure.skeleton.index("left_hand")
    np.testing.assert_allclose(turn[number], [0.0, 0.5, 0.0], atol=1e-12)
    assert np.abs(np.delete(turn, number, axis=0)).max() < 1e-12
