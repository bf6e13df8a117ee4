"""`motorcade author`: gestures replayed from files, by rotors and by Euler angles."""

from __future__ import annotations

import json

import numpy as np
import pytest

from motorcade.animation.authoring import SceneEditor, gesture_of, read_scene, scene_text
from motorcade.replays.cli.main import main
from tests.animation.authoring.made import busy_scene, drawn_gesture


@pytest.fixture
def files(tmp_path):
    scene, gestures = tmp_path / "scene.json", tmp_path / "drags.jsonl"
    scene.write_text(json.dumps({"objects": [{"name": "cup", "position_m": [1, 0, 0]}]}))
    drags = [
        {"object": "cup", "do": "rotate", "axis": axis, "amounts_rad": [0.5, np.pi / 2 + 0.02]}
        for axis in ([0, 0, 1], [1, 0, 0])
    ]
    gestures.write_text("\n".join(json.dumps(drag) for drag in drags))
    return scene, gestures


def test_rotors_and_euler_angles_end_apart_and_only_rotors_where_asked(files, tmp_path, capsys):
    scene, gestures = files
    out = tmp_path / "edited.json"
    command = ["author", str(scene), "--gestures", str(gestures), "--snap-deg", "90"]
    assert main([*command, "-o", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["gestures"] == 2
    pose = read_scene(out).world_T_object("cup")
    # About z, then about the object's own x, each by 90 degrees.
    expected = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], float)
    np.testing.assert_allclose(pose.rotor.as_matrix(), expected, atol=1e-14)
    assert main([*command, "--rotations", "euler"]) == 0
    assert "cup: at 1.000 0.000 0.000 m; 120.000°" in capsys.readouterr().out


def test_a_session_is_told_again_to_the_same_bytes(tmp_path, capsys):
    editor, lines = SceneEditor(busy_scene()), []
    rng = np.random.default_rng(11)
    while len(lines) < 120:
        line = drawn_gesture(rng, editor.scene)
        try:
            editor.do(gesture_of(line))
        except ValueError:
            continue
        lines.append(json.dumps(line))
    scene, gestures, out = (tmp_path / name for name in ("a.json", "a.jsonl", "out.json"))
    scene.write_text(scene_text(busy_scene()))
    gestures.write_text("\n".join(lines))
    # The session began from the file too, so that both begin from the same bits.
    session = SceneEditor(read_scene(scene))
    for line in lines:
        session.do(gesture_of(json.loads(line)))
    assert main(["author", str(scene), "--gestures", str(gestures), "-o", str(out)]) == 0
    assert out.read_text() == scene_text(session.scene)
    assert set(session.scene.parents) != set(busy_scene().parents)
    assert "120 gestures" in capsys.readouterr().out


def test_a_wrong_line_is_named(files, capsys):
    scene, gestures = files
    gestures.write_text(json.dumps({"object": "plate", "do": "scale", "factors": [2]}))
    assert main(["author", str(scene), "--gestures", str(gestures)]) == 1
    assert "object: expected one of cup, got 'plate'" in capsys.readouterr().err
