"""`motorcade inspect` on characters and motions: what the library reads is what it tells."""

import json
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import mannequin
from motorcade.animation.formats import write_gltf
from motorcade.replays.cli import main
from motorcade.replays.tasks.inspection import describe_character

BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 1 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  End Site
  {
    OFFSET 0 1 0
  }
}
MOTION
Frames: 2
Frame Time: 0.5
0 1 0 0 0 0
0 1 2 0 0 0
"""


@pytest.fixture(scope="module")
def figure(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("figures") / "figure.glb"
    write_gltf(path, mannequin())
    return path


def test_a_character_is_told_in_metres_and_seconds(
    figure: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", str(figure), "--json", "--pose", "walk@0.25"]) == 0
    told = json.loads(capsys.readouterr().out)
    made = mannequin()
    assert told["triangles"] == len(made.triangles)
    assert told["joint_count"] == len(made.skeleton) == len(told["joints"])
    assert told["height_m"] == pytest.approx(made.height_m, abs=1e-6)
    parents = [joint["parent"] for joint in told["joints"]]
    names = made.skeleton.names
    assert parents == [None if p < 0 else names[p] for p in made.skeleton.parents.tolist()]
    rest = [joint["rest_position_m"] for joint in told["joints"]]
    np.testing.assert_allclose(rest, made.skeleton.rest_world.translation_m, atol=1e-6)
    posed = [joint["position_m"] for joint in told["pose"]["joints"]]
    wanted = made.skeleton.world(made.clip("walk").at(0.25)).translation_m
    np.testing.assert_allclose(posed, wanted, atol=1e-5)
    seconds = {clip["name"]: clip["seconds"] for clip in told["clips"]}
    assert seconds["walk"] == pytest.approx(made.clip("walk").duration_s)


def test_lines_for_people_name_every_joint_and_clip(
    figure: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", str(figure)]) == 0
    told = capsys.readouterr().out
    assert all(f"  {name}  parent " in told for name in mannequin().skeleton.names)
    assert "walk  seconds" in told


def test_a_motion_is_told_without_a_mesh(tmp_path: Path) -> None:
    path = tmp_path / "motion.bvh"
    path.write_text(BVH)
    told = describe_character(path)
    assert "triangles" not in told
    assert [(clip["name"], clip["seconds"], clip["keys"]) for clip in told["clips"]] == [
        ("motion", 0.5, 2)
    ]
    assert any("unit" in notice for notice in told["notices"])


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        ("somersault@0", "one of 'idle', 'walk'"),
        ("-1@0", "one of 'idle', 'walk'.*got '-1@0'"),
        ("0", "one of 'idle', 'walk'.*got '0'"),
        ("walk@soon", "CLIP@SECONDS"),
        ("walk@nan", "finite seconds, got 'walk@nan'"),
    ],
)
def test_poses_that_are_none_are_refused(figure: Path, pose: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        describe_character(figure, pose)


def test_a_broken_file_ends_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "broken.glb"
    path.write_bytes(b"glTF")
    assert main(["inspect", str(path)]) == 1
    told = capsys.readouterr().err
    assert "header: expected 20 bytes or more, got 4" in told
    assert told.count("\n") == 1
