"""`motorcade blend`: cycles of a written character blended into glTF and video."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Clip, Skeleton, mannequin
from motorcade.animation.formats import read_character, write_gltf
from motorcade.ga import Motor
from motorcade.replays.cli.main import main
from motorcade.replays.tasks.blending import blend_character, character_with, write_blend


@pytest.fixture(scope="module")
def figure(tmp_path_factory):
    path = tmp_path_factory.mktemp("figure") / "figure.glb"
    write_gltf(path, mannequin())
    return path


def test_a_blend_written_as_gltf_moves_as_it_was_blended(figure, tmp_path, capsys):
    out = tmp_path / "blend.glb"
    arguments = ["blend", str(figure), "--clips", "idle,walk", "--weight", "0.3"]
    assert main([*arguments, "--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["in_phase"] is True
    assert told["differences_mm"]["motor - dual_quaternion"] < 1e-6
    assert told["differences_mm"]["motor - motor_linear"] < 50.0
    character = read_character(figure)
    blend = blend_character(character, ("idle", "walk"), 0.3)
    back = read_character(out).clips[0]
    assert back.duration_s == pytest.approx(blend.clip.duration_s)
    times = np.linspace(0.0, back.duration_s, 13)
    found, expected = (
        character.skeleton.world(clip.at(times)).translation_m for clip in (back, blend.clip)
    )
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_feet_that_stand_still_have_no_phase(figure):
    """A pose held as a cycle blends with a walk, which keeps its own phase."""
    character = read_character(figure)
    held = Clip(
        "held",
        np.array([0.0, 1.0]),
        Motor(np.repeat(character.skeleton.rest.coefficients[None], 2, axis=0)),
        looped=True,
    )
    character = replace(character, clips=(*character.clips, held))
    blend = blend_character(character, ("walk", "held"), 0.5)
    assert blend.in_phase
    assert blend.offset == 0.0


def test_names_of_feet_do_not_matter_to_the_phase(figure):
    character = read_character(figure)
    skeleton = character.skeleton
    names = tuple(f"joint{k}" for k in range(len(skeleton)))
    other = replace(character, skeleton=Skeleton(names, skeleton.parents, skeleton.rest))
    offsets = [blend_character(who, ("walk", "run"), 0.5).offset for who in (character, other)]
    assert offsets[0] == offsets[1] != 0.0


def test_motions_of_another_file_are_retargeted(figure):
    with pytest.raises(ValueError, match="expected different names"):
        character_with(figure, [figure])  # its own clips again


@pytest.mark.usefixtures("opengl")
def test_a_blend_is_drawn_as_video(figure, tmp_path):
    from motorcade.render.video import read_frames

    blend = blend_character(read_character(figure), ("idle", "walk"), 0.5)
    write_blend(blend, tmp_path / "blend.mp4", (96, 96))
    frames = [frame for _, frame in read_frames(tmp_path / "blend.mp4")]
    assert len(frames) >= 100
    assert frames[0].shape == (96, 96, 3)
    # The figure stands in the middle and moves; the wall above it does not.
    first, later = frames[0].astype(int), frames[20].astype(int)
    assert np.abs(first - later)[30:80, 30:66].max() > 40
    assert np.abs(first - later)[:8].max() < 12


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--clips", "idle"], "expected two names with a comma between"),
        (["--clips", "idle,dance"], "expected one of 'idle', 'walk'"),
        (["--clips=-1,0"], "got '-1'"),
        (["--clips", "1.5,True"], "got '1.5'"),
        (["--clips", "idle,"], "got ''"),
        (["--clips", "idle,walk", "--weight", "nan"], "expected 0 to 1, got nan"),
        (["--clips", "idle,walk", "--rate-hz", "1e12"], "expected at most 100000 samples"),
        (["--clips", "idle,walk", "--weight", "2"], "expected 0 to 1, got 2.0"),
        (["--clips", "idle,walk", "--method", "slerp"], "expected one of motor, motor_linear"),
        (["--clips", "idle,walk", "--out", "blend.avi"], "ending in .glb or .mp4"),
    ],
)
def test_refusals_are_one_line(figure, arguments, message, capsys):
    assert main(["blend", str(figure), *arguments]) == 1
    told = capsys.readouterr().err.strip()
    assert message in told
    assert "\n" not in told


def test_what_begins_with_a_dash_is_no_value_without_an_equals_sign(figure, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["blend", str(figure), "--clips", "-1,0"])
    assert "argument --clips: expected one argument" in capsys.readouterr().err
