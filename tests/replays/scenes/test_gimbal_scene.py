"""The film of the gimbal's spin is that of the scene file, and the run's knob joins likewise."""

from __future__ import annotations

import numpy as np
import pytest

from docs.making.gimbal_scene import SCENE, performer, rates_deg_s, spins
from motorcade.animation.authoring import compare_interpolations, read_scene
from motorcade.ga import Similarity
from motorcade.replays.stages.view.acting import performers
from motorcade.replays.stages.view.placed import placed
from tests.replays.carried_marker import TIME_NS, recorded, still


@pytest.mark.parametrize("way", ["motor", "quaternion", "euler"])
def test_runs_join_all_keyframes_as_they_are_asked_to(way) -> None:
    recording, smoothed, found = recorded(still)
    made = placed(recording, found, smoothed, scene=SCENE, interpolation=way)
    (one,) = performers(made)
    wanted = performer(read_scene(SCENE), "diver", way, TIME_NS)
    poses, told = one.world_T_character(TIME_NS), wanted.world_T_character(TIME_NS)
    assert isinstance(poses, Similarity)
    np.testing.assert_allclose(poses.as_matrix(), told.as_matrix(), atol=1e-9)
    figures = compare_interpolations(read_scene(SCENE).part("diver"))[way]
    assert wanted.motion is not None
    fastest = np.radians(rates_deg_s(wanted.motion).max())
    assert fastest == pytest.approx(figures.peak_rad_s, rel=1e-3)


def test_an_interpolation_without_a_scene_is_refused() -> None:
    recording, smoothed, found = recorded(still)
    with pytest.raises(ValueError, match=r"placed\.interpolation: expected none without placed"):
        placed(recording, found, smoothed, interpolation="euler")


@pytest.mark.slow
@pytest.mark.usefixtures("opengl")
def test_the_film_shows_the_spin_of_euler_angles_alone() -> None:
    """On the way Euler angles are off both others by more than these are off each other."""
    images = [one[40:440].astype(int) for _, one in spins(read_scene(SCENE), "diver", 2.0)]
    assert len(images) == 9
    for k, image in enumerate(images):
        euler, quaternion, motor = np.split(image, 3, axis=1)
        spun, beside = (np.abs(one - motor).mean() for one in (euler, quaternion))
        if k in (0, 8):  # all begin and end in the keyframes
            assert max(spun, beside) < 0.05
        elif 2 <= k <= 6:
            assert min(spun, np.abs(euler - quaternion).mean()) > beside
