"""Casts: what a file asks for is what is acted, and what it cannot ask for is refused by name."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.animation import mannequin
from motorcade.animation.behaviour import LookTarget
from motorcade.animation.formats import read_motion
from motorcade.ga import Motor
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.manifest.cast import read_cast
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.stages.view.acting import actor_of, character_named, check_cast, played

EVERY_KEY = Path(__file__).parents[3] / "docs" / "manifests" / "every_cast_key.toml"
# A figure in T-pose, 1.6 m tall, that lifts its left arm; written by hand.
JOINTS = """HIERARCHY
ROOT Hips
{ OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine { OFFSET 0 0.1 0 CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT Neck { OFFSET 0 0.4 0 CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT Head { OFFSET 0 0.1 0 CHANNELS 3 Zrotation Xrotation Yrotation
        End Site { OFFSET 0 0.2 0 } } }
%s  }
%s}
"""
ARM = """    JOINT {s}Arm {{ OFFSET {x} 0.35 0 CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT {s}ForeArm {{ OFFSET {x2} 0 0 CHANNELS 3 Zrotation Xrotation Yrotation
        JOINT {s}Hand {{ OFFSET {x2} 0 0 CHANNELS 3 Zrotation Xrotation Yrotation
          End Site {{ OFFSET {x} 0 0 }} }} }} }}
"""
LEG = """  JOINT {s}UpLeg {{ OFFSET {x} 0 0 CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT {s}Leg {{ OFFSET 0 -0.4 0 CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT {s}Foot {{ OFFSET 0 -0.4 0 CHANNELS 3 Zrotation Xrotation Yrotation
        End Site {{ OFFSET 0 -0.05 0.15 }} }} }} }}
"""


def bvh(path: Path, frames: int = 31) -> Path:
    """Write the figure; BVH's own y is up and it faces +z."""
    sides = (("Left", 1.0), ("Right", -1.0))
    arms = "".join(ARM.format(s=name, x=0.15 * sign, x2=0.27 * sign) for name, sign in sides)
    legs = "".join(LEG.format(s=name, x=0.1 * sign) for name, sign in sides)
    lines = [JOINTS % (arms, legs), "MOTION", f"Frames: {frames}", "Frame Time: 0.0333333"]
    for share in np.sin(np.pi * np.linspace(0.0, 1.0, frames)):
        row = np.zeros(6 + 3 * 15)
        row[1] = 0.85
        row[6 + 3 * 3] = 60.0 * share  # the left arm's turn about z
        lines.append(" ".join(f"{value:.6f}" for value in row))
    text = "\n".join(lines)
    path.write_text(
        text.replace("{", "\n{\n").replace("}", "\n}\n").replace(" CHANNELS", "\nCHANNELS")
    )
    return path


def cast(folder: Path, text: str) -> Path:
    path = folder / "cast.toml"
    path.write_text(text)
    return path


def test_every_key_is_read_and_acted() -> None:
    asked = read_cast(EVERY_KEY)
    assert asked.gap_m == 0.02
    guide = asked.members[0]
    assert guide.gaits == ("walk", "jog")
    assert guide.layers[0].joints == "right_arm"
    parts, apart_m = played(
        asked, Motor.identity(), 0.1, LookTarget([0.0], [[0.1, -0.6, 0.3]]), 12.0
    )
    assert [part.name for part in parts] == ["guide", "visitor"]
    assert apart_m >= 0.02
    states = [one.state for one in parts[0].states]
    assert states[0] == "idle"
    assert states[-3:] == ["turn", "act", "idle"]
    for member, part in zip(asked.members, parts, strict=True):
        height_m = part.placement.scale * 1.75
        assert height_m == pytest.approx(member.height_m)
        assert part.worst_slide_m is not None
        assert part.worst_slide_m < 0.01 * height_m
        root = part.placement.apply(part.poses[-1, 0].translation_m)
        np.testing.assert_allclose(root[:2], member.path_m[-1], atol=0.1 * height_m)


def test_a_motion_file_is_retargeted_and_acted(tmp_path: Path) -> None:
    bvh(tmp_path / "salute.bvh")
    text = '[[characters]]\nmotions = ["salute.bvh"]\nstart = [0, 0]\nacts = ["salute"]\n'
    asked = read_cast(cast(tmp_path, text))
    (clip,) = read_motion(tmp_path / "salute.bvh").clips
    assert clip.name == "salute"
    actor = actor_of(asked.members[0], 1.75)
    acted = (actor.acts or {})["salute"].clip
    hand, shoulder = (actor.skeleton.index(f"left_{name}") for name in ("hand", "upper_arm"))
    half = actor.skeleton.world(acted.at(0.5)).translation_m
    rise = half[hand] - half[shoulder]
    assert np.degrees(np.arcsin(rise[2] / np.linalg.norm(rise))) == pytest.approx(60.0, abs=12.0)


REAL = """
[[characters]]
name = "sinbad"
file = "{rigs}/sinbad/sinbad.glb"
height_m = 0.2
path = [[-0.12, 0.2], [0.0, 0.05], [0.02, -0.18]]
gaits = ["RunBase"]
idle = "IdleBase"
acts = ["Dance"]
layers = [{{ clip = "RunTop", during = "walk" }}, {{ clip = "IdleTop", during = "idle" }}]

[[characters]]
name = "jumper"
motions = ["{rigs}/bvh/jumping_jacks.bvh"]
height_m = 0.23
path = [[0.1, -0.2], [0.02, 0.2]]
gaits = ["walk", "jog"]
speed_m_s = 1.7
acts = ["jumping_jacks"]
"""


@pytest.mark.slow
def test_real_rigs_keep_apart_and_their_feet_in_place(tmp_path: Path, data_dir: Path) -> None:
    """Paths that cross: no skin nears another, no foot slides by more than 1.5 % of the height."""
    asked = read_cast(cast(tmp_path, REAL.format(rigs=data_dir / "rigs")))
    parts, apart_m = played(asked, Motor.identity(), 0.2, LookTarget([0.0], [[0.5, 0.0, 0.3]]), 8.0)
    assert apart_m >= 0.02
    for part, height_m in zip(parts, (0.2, 0.23), strict=True):
        assert part.worst_slide_m is not None
        assert part.worst_slide_m < 0.015 * height_m
        states = [one.state for one in part.states]
        assert states.index("walk") < states.index("arrive") < states.index("act")


def test_heads_look_at_what_the_cast_says(tmp_path: Path) -> None:
    """At a place, at the camera, and nowhere: angles between the head's front and the camera."""
    camera, off = LookTarget([0.0], [[0.6, 0.5, 0.16]]), []
    for asked in ("", "look_at = 'camera'\n", "look_at = [0.6, 0.5, 0.16]\n"):
        text = ONE + "height_m = 0.175\nheading_deg = 0\n" + asked
        member = read_cast(cast(tmp_path, text))
        (part,), _ = played(member, Motor.identity(), 0.1, camera, 2.0)
        figure = mannequin()
        head = figure.skeleton.index("head")
        world = part.placement.world_T_character @ figure.skeleton.world(part.poses)[-1, head]
        rest = figure.skeleton.rest_world[head].rotor
        faces = world.rotor.apply(rest.inverse().apply([1.0, 0.0, 0.0]))
        off.append(np.degrees(np.arccos(faces @ [0.6, 0.5, 0.0] / np.hypot(0.6, 0.5))))
    assert off[0] > 30.0
    assert max(off[1:]) < 5.0


def test_a_person_knows_the_axes_of_a_file_better(tmp_path: Path, data_dir: Path) -> None:
    """One that is told to face the other way walks backwards by its own clips' lights."""
    file = data_dir / "rigs" / "kaykit" / "Knight.glb"
    found = []
    for axes in ("", "front = '-z'\n", "front = 'z'\n"):
        text = f"[[characters]]\nfile = '{file}'\nidle = 'Idle'\nstart = [0, 0]\n{axes}"
        asked = read_cast(cast(tmp_path, text))
        (part,), _ = played(asked, Motor.identity(), 0.2, LookTarget([0.0], [[1.0, 0, 0]]), 0.5)
        who = character_named(part.character, part.up, part.front)
        names = [who.skeleton.index(f"foot.{side}") for side in "lr"]
        at = part.placement.apply(who.skeleton.world(part.poses)[0, names].translation_m)
        found.append(np.sign(at[0, 1] - at[1, 1]))
    assert found == [1.0, -1.0, 1.0]


def test_a_taken_name_is_told_by_its_file(tmp_path: Path) -> None:
    bvh(tmp_path / "wave.bvh")
    text = '[[characters]]\nmotions = ["wave.bvh"]\nstart = [0, 0]\nacts = ["wave/wave", "wave"]\n'
    actor = actor_of(read_cast(cast(tmp_path, text)).members[0], 1.75)
    acts = actor.acts or {}
    assert acts["wave/wave"].clip.duration_s == pytest.approx(1.0, abs=0.01)
    assert acts["wave"].clip.duration_s > 2.0


ONE = "[[characters]]\nstart = [0, 0]\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("gap_m = 0.1\n", "characters: the key is missing"),
        ("characters = 3\n", r"expected 1 to 8 \[\[characters\]\] tables"),
        (9 * ONE, r"expected 1 to 8 \[\[characters\]\] tables, got 9"),
        ("[[characters]]\n", r"\[characters 1\] start: the key is missing"),
        (ONE + "path = [[0, 0], [1, 0]]\n", "either start or path"),
        (ONE + "act = ['wave']\n", "'act': unknown key; did you mean acts"),
        (ONE + "height_m = -1\n", r"\[characters 1\] height_m: expected a number from"),
        (ONE + "acts = 'wave'\n", "expected a list of texts"),
        ("[[characters]]\nstart = [0]\n", r"start: expected \[x, y\] within 10000 m"),
        ("[[characters]]\nstart = [1e12, 0]\n", r"start: expected \[x, y\] within 10000 m"),
        (ONE + 'name = "a\\u202e\\nb"\n', "name: expected up to 100 printable letters, got 'a.*b'"),
        (ONE + f"name = '{101 * 'a'}'\n", "name: expected up to 100 printable letters"),
        (ONE + "up = 'w'\n", r"\[characters 1\] up: expected one of x, -x"),
        (ONE + "look_at = 'lens'\n", r"\[characters 1\] look_at: expected one of camera"),
        (ONE + "look_at = [1, 2]\n", r"look_at: expected 'camera' or \[x, y, z\] within 10000 m"),
        (ONE + "look_at = [1, 2, 1e9]\n", r"look_at: expected 'camera' or \[x, y, z\] within"),
        (ONE + "waits_s = 3600\n", "waits_s: expected a number from 0 to 600"),
        (ONE + "layers = 'wave'\n", r"tables, got 'wave'"),
        ("[[characters]]\npath = [[0, 0]]\n", "expected 2 to 100 points"),
        ("[[characters]]\npath = [[0, 0], [0, 0]]\n", "expected neighbours apart"),
        ("[[characters]]\npath = [[0, 0], [1]]\n", r"expected points \[x, y\]"),
        (ONE + "name = 'a'\n" + ONE + "name = 'a'\n", "expected different names, got 'a' twice"),
        (ONE + "layers = [{clip = 'wave', joints = 'leg'}]\n", "layers.*expected one of whole"),
        (ONE + "layers = [{clip = 'wave', additive = 1}]\n", "expected true or false"),
        ("gap_m = 'x'\n" + ONE, "gap_m: expected a number"),
    ],
)
def test_what_a_cast_gets_wrong_is_refused_by_table_and_key(
    tmp_path: Path, text: str, said: str
) -> None:
    with pytest.raises(RecordingError, match=said):
        read_cast(cast(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (ONE + "acts = ['wawe']\n", "cast, 'character 1': no clip 'wawe'.*'wave'"),
        (ONE + "file = 'none.glb'\n", "cast, 'character 1': .*none.glb"),
        (ONE + f"file = '{900 * 'x'}.glb'\n", "cast, 'character 1': file: expected 'mannequin' or"),
        (
            "[[characters]]\npath = [[0, 0], [1, 0]]\ngaits = []\n",
            r"gait_between\(clips\): expected one gait or more, got none",
        ),
        (ONE + "up = 'z'\n", "cast, 'character 1': up: expected none for the mannequin"),
        (ONE + "motions = ['none.bvh']\n", "cast, 'character 1': .*none.bvh"),
        (
            "[[characters]]\npath = [[0, 0], [1, 0]]\ngaits = ['idle']\n",
            "cast, 'character 1': .*'idle'",
        ),
        (
            "[[characters]]\npath = [[0, 0], [1, 0]]\nspeed_m_s = 9\n",
            "expected a speed that the gaits have",
        ),
    ],
)
def test_what_a_cast_names_and_is_not_there_is_refused(
    tmp_path: Path, text: str, said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        check_cast(read_cast(cast(tmp_path, text)))


def test_a_cast_found_in_a_recording_names_no_file_outside_it(tmp_path: Path) -> None:
    folder = tmp_path / "recording"
    folder.mkdir()
    (folder / "motorcade.toml").write_text(
        "settings = ['placed.cast=cast.toml']\n[frames]\nrate_hz = 30\n"
    )
    assert cv2.imwrite(str(folder / "0.png"), np.zeros((8, 8), np.uint8))
    cast(folder, ONE + f"file = '{tmp_path / 'hero.glb'}'\n")
    with pytest.raises(RecordingError, match="expected files inside"):
        open_recording(folder)
