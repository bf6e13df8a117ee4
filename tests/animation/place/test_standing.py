"""Which clips stand, and how high: by soles at rest, witnessed by the raw file and by names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, Clip, legs_of, mannequin, skin
from motorcade.animation.formats import read_character
from motorcade.animation.ik import Leg, fitted_legs
from motorcade.animation.place import on_its_soles
from motorcade.animation.place.anchors import standing_height_m
from motorcade.ga import Motor, Rotor
from tests.animation.formats.gltf_vertices import GltfVertices


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


@pytest.fixture(scope="module")
def legs(figure: Character) -> list[Leg]:
    return fitted_legs(legs_of(figure.skeleton), figure)


def moved(clip: Clip, by: Motor) -> Clip:
    poses = clip.poses.rigid.coefficients.copy()
    poses[:, 0] = (by @ Motor(poses[:, 0])).coefficients
    return replace(clip, poses=Motor.normalize(poses))


@pytest.mark.parametrize("name", ["idle", "wave", "walk"])
def test_clips_on_feet_stand_on_the_ground(figure, legs, name):
    height_m = standing_height_m(figure, legs, figure.clip(name))
    assert height_m is not None
    assert abs(height_m) < 0.01 * figure.height_m


@pytest.mark.parametrize("off", [-0.04, -0.011, 0.02, 0.045])
def test_what_floats_or_is_sunk_is_put_on_its_soles(figure, legs, off):
    """The witness is the skin itself."""
    clip = moved(figure.clip("idle"), Motor.from_translation([0.0, 0.0, off * figure.height_m]))
    raised, by_m = on_its_soles(figure, legs, clip)
    assert by_m == pytest.approx(-off * figure.height_m, abs=0.003 * figure.height_m)
    skinned = skin(figure, raised.at(raised.time_s[0] + 0.5).rigid, "linear")[0]
    assert skinned[:, 2].min() == pytest.approx(0.0, abs=0.004 * figure.height_m)


def test_what_lies_floats_high_or_jumps_does_not_stand_and_stays(figure, legs):
    idle = figure.clip("idle")
    lying = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([0.0, -0.5 * np.pi, 0.0]), np.array([0.0, 0.0, 0.1])
    )
    high = Motor.from_translation([0.0, 0.0, 0.3])
    up_m = 0.15 * np.abs(np.sin(6.0 * idle.time_s))
    jumps = Motor.from_translation(up_m[:, None] * [0.0, 0.0, 1.0])
    for clip in (moved(idle, lying), moved(idle, high), moved(replace(idle, looped=False), jumps)):
        assert standing_height_m(figure, legs, clip) is None
        assert on_its_soles(figure, legs, clip) == (clip, 0.0)


def test_a_pose_of_one_moment_stands(figure, legs):
    rest = Clip("rest", np.zeros(1), figure.skeleton.rest[None])
    height_m = standing_height_m(figure, legs, rest)
    assert height_m is not None
    assert abs(height_m) < 0.002


@pytest.fixture(scope="module")
def knight(data_dir: Path) -> tuple[Path, Character, dict[str, float | None]]:
    path = data_dir / "rigs" / "kaykit" / "Knight.glb"
    who = read_character(path)
    legs = fitted_legs(legs_of(who.skeleton), who)
    return path, who, {clip.name: standing_height_m(who, legs, clip) for clip in who.clips}


def test_an_authors_clips_stand_that_their_names_say_do(knight):
    _, _, found = knight
    stand = ("Idle", "Block", "Aiming", "Reload", "Walking", "Spellcast", "Cheer", "Use", "T-Pose")
    other = ("Death_A", "Death_B", "Lie_", "Sit_Chair", "Sit_Floor_Idle", "Running", "Jump_Idle")
    for name, height_m in found.items():
        if any(part in name for part in other):
            assert height_m is None, name
        elif any(part in name for part in stand):
            assert height_m is not None, name


def test_dodges_are_sunk_in_the_file_itself(knight):
    """Evaluated from the file's bytes: soles are below those of the rest, at z = 0 once read."""
    path, who, found = knight
    raw = GltfVertices(path)
    numbers = {one["name"]: k for k, one in enumerate(raw.document["animations"])}
    unit_m = who.height_m / np.ptp(raw.at()[:, 1])
    own = raw.at()[:, 1].min()
    for name in ("Dodge_Left", "Dodge_Right", "Dodge_Forward", "Idle"):
        clip = who.clip(name)
        clock = np.linspace(clip.time_s[0], clip.time_s[-1], 9)
        lows = [raw.at(at, numbers[name])[:, 1].min() - own for at in clock]
        height_m = found[name]
        assert height_m is not None
        assert height_m == pytest.approx(unit_m * np.median(lows), abs=0.01 * who.height_m), name
        assert (height_m < -0.01 * who.height_m) == (name != "Idle")
