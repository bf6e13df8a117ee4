"""What the gallery says of meshes between whole poses."""

from __future__ import annotations

import numpy as np
import pytest

from docs.making.between_poses import by_field, by_joints, compared
from motorcade.animation import mannequin, skin

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def result():
    return compared()


def test_both_ways_begin_in_the_first_pose_and_end_near_the_second(result):
    figure, ways, _ = result
    start, end = figure.clip("idle").at(0.0), figure.clip("wave").at(1.7)
    np.testing.assert_allclose(
        ways["field"].vertices_m[0], skin(figure, start, "motor")[0], atol=1e-12
    )
    wanted = skin(figure, end, "motor")[0]
    np.testing.assert_allclose(ways["joints"].vertices_m[-1], wanted, atol=1e-9)
    apart = np.linalg.norm(ways["field"].vertices_m[-1] - wanted, axis=1)
    assert np.median(apart) < 0.005
    assert apart.max() < 0.2


def test_the_field_moves_every_vertex_at_one_speed_along_its_own_screw(result):
    _, _, found = result
    assert found["field"]["unevenness"] < 1.001
    assert found["joints"]["unevenness"] > 1.2


def test_joints_keep_the_volume_and_the_field_nearly(result):
    _, _, found = result
    assert found["joints"]["volume off"] < 0.002
    assert 0.002 < found["field"]["volume off"] < 0.03


def test_between_a_pose_and_itself_nothing_moves():
    figure = mannequin()
    pose = figure.clip("idle").at(0.0)
    for way in (by_field, by_joints):
        made = way(figure, pose, pose, np.array([0.0, 0.5, 1.0]))
        assert np.abs(made.vertices_m - made.vertices_m[:1]).max() < 1e-9
