"""A walker in the pipeline: from standing to standing, and alive where it has arrived."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, Clip, legs_of, mannequin, place_on_plane
from motorcade.animation.ik import fitted_legs
from motorcade.animation.place.anchors import standing_height_m
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.stages.values.view import PlacedCharacter
from motorcade.replays.stages.view.acting import IDLE_HZ, character_named, performers, walked

PATH_M = np.array([[0.0, 0.0], [1.5, 0.0]])
LASTING_S = 8.0


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


@pytest.fixture(scope="module")
def walk(figure: Character) -> Clip:
    return walked(figure, figure.clip("walk"), PATH_M, 1.0, Motor.identity(), LASTING_S)


def joint_m(figure: Character, clip: Clip, name: str, time_s: FloatArray) -> FloatArray:
    poses = clip.at(time_s)
    return figure.skeleton.world(poses).translation_m[:, figure.skeleton.index(name)]


def test_it_arrives_and_its_feet_stay_where_they_came_to_stand(
    figure: Character, walk: Clip
) -> None:
    arrived_s = walked(figure, figure.clip("walk"), PATH_M, 1.0, Motor.identity()).duration_s
    assert arrived_s + 2.0 < walk.duration_s <= LASTING_S
    late_s = np.arange(arrived_s, walk.duration_s, 1.0 / 60.0)
    ankles = [name for name in figure.skeleton.names if "foot" in name.lower()]
    assert len(ankles) == 2
    for name in ankles:
        stood = joint_m(figure, walk, name, late_s)
        assert np.ptp(stood, axis=0).max() < 0.01
        assert abs(stood[:, 0].mean() - PATH_M[-1, 0]) < 0.25


def test_it_idles_on_without_a_jump(figure: Character, walk: Clip) -> None:
    late_s = np.arange(walk.duration_s - 2.5, walk.duration_s, 1.0 / IDLE_HZ)
    head = joint_m(figure, walk, "head", late_s)
    assert np.ptp(head, axis=0).max() > 5e-4  # it breathes
    whole_s = np.arange(0.0, walk.duration_s, 1.0 / 60.0)
    places = figure.skeleton.world(walk.at(whole_s)).translation_m
    steps_m = np.linalg.norm(np.diff(places, axis=0), axis=-1).max(axis=1)
    after = whole_s[1:] > walk.duration_s - 2.5
    assert steps_m[after].max() < 0.01


def test_a_long_recording_is_idled_for_two_minutes(figure: Character) -> None:
    long = walked(figure, figure.clip("walk"), PATH_M, 1.0, Motor.identity(), 1e6)
    assert 120.0 < long.duration_s < 130.0


def test_a_clip_that_its_author_left_sunk_is_drawn_on_its_soles(data_dir: Path):
    file = data_dir / "rigs" / "kaykit" / "Knight.glb"
    who = character_named(str(file))
    legs = fitted_legs(legs_of(who.skeleton), who)
    placement = place_on_plane(who, height_m=0.2)
    (shown,) = performers(PlacedCharacter(str(file), "Dodge_Left", placement, "a floor"))
    levels = [standing_height_m(who, legs, one) for one in (who.clip("Dodge_Left"), shown.clip)]
    assert levels[0] is not None
    assert levels[1] is not None
    assert levels[0] < -0.01 * who.height_m
    assert abs(levels[1]) < 1e-6
