"""What is set into footage is what would have been rendered there, by truth and by tracking."""

import numpy as np
import pytest

from motorcade.render.light.estimate import LightEstimate
from tests.bench.view.ground_truth import (
    Shots,
    alike,
    drawn_silhouettes,
    found_light,
    found_lighting,
    overlap,
    room_light,
    set_into,
    sheet,
    take_shots,
    tracked_path,
    true_light,
)

pytestmark = [pytest.mark.usefixtures("opengl"), pytest.mark.slow]


@pytest.fixture(scope="module")
def shots() -> Shots:
    return take_shots()


@pytest.fixture(scope="module")
def light(shots: Shots) -> LightEstimate:
    return found_light(shots)


def test_true_pose_and_light_give_the_directly_rendered_image(shots: Shots) -> None:
    made = set_into(shots, shots.poses, true_light())
    for direct, empty, one in zip(shots.direct, shots.empty, made, strict=True):
        found = alike(direct, one, empty)
        assert found.pixels > 4000
        assert found.mean_of_255 <= 2.0
        assert found.similarity >= 0.98
    assert sheet(shots, made, made).shape[2] == 3


def test_true_poses_give_the_true_silhouette(shots: Shots) -> None:
    for true, drawn in zip(shots.silhouette, drawn_silhouettes(shots, shots.poses), strict=True):
        assert overlap(true, drawn) >= 0.995


def test_the_rooms_own_light_is_found_within_20_degrees(light: LightEstimate) -> None:
    apart_deg = np.rad2deg(np.arccos(light.towards_light @ room_light()))
    assert apart_deg <= 20.0
    assert light.contrast > 0.3


def test_tracked_poses_and_found_light_keep_the_silhouette_and_most_of_the_image(
    shots: Shots, light: LightEstimate
) -> None:
    poses = tracked_path(shots)
    assert len(poses) == 3
    for true, drawn in zip(shots.silhouette, drawn_silhouettes(shots, poses), strict=True):
        assert overlap(true, drawn) >= 0.97
    made = set_into(shots, poses, found_lighting(shots, light))
    for direct, one, there in zip(shots.direct, made, shots.silhouette, strict=True):
        assert np.abs(direct.astype(int) - one)[there].mean() < 40.0
