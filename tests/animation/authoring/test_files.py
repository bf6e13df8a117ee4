"""Scenes and gestures on disk: read back as written, replayed, and refused line by line."""

from __future__ import annotations

import json

import numpy as np
import pytest

from motorcade.animation.authoring import SceneEditor, read_gestures, read_scene, replay

SCENE = {
    "objects": [
        {"name": "table", "position_m": [0, 0, 0.7], "euler_deg": [0, 0, 90]},
        {"name": "cup", "parent": "table", "position_m": [0.1, 0, 0], "scale": 0.5},
    ]
}


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(SCENE))
    return path


def _gestures(tmp_path, *lines):
    path = tmp_path / "gestures.jsonl"
    path.write_text("\n".join(json.dumps(line) for line in lines))
    return path


def test_a_scene_is_read_as_written(scene_file, tmp_path):
    scene = read_scene(scene_file)
    np.testing.assert_allclose(
        scene.world_T_object("cup").apply([1.0, 0.0, 0.0]), [0.0, 0.6, 0.7], atol=1e-14
    )
    again = tmp_path / "again.json"
    again.write_text(json.dumps(scene.as_json()))
    for name in ("table", "cup"):
        np.testing.assert_allclose(
            read_scene(again).world_T_object(name).as_matrix(),
            scene.world_T_object(name).as_matrix(),
            atol=1e-15,
        )


def test_gestures_are_replayed(scene_file, tmp_path):
    path = _gestures(
        tmp_path,
        {
            "object": "cup",
            "do": "translate",
            "axis": [1, 0, 0],
            "frame": "global",
            "amounts_m": [0.1, 0.2, 0.3],
        },
        {"object": "table", "do": "rotate", "frame": "parent", "amounts_rad": [np.pi / 2]},
        {"object": "cup", "do": "scale", "factors": [1.5, 2.0]},
        {"do": "undo"},
    )
    final = replay(SceneEditor(read_scene(scene_file)), read_gestures(path))
    # The cup stood at (0, 0.1), went to (0.3, 0.1), and turned with the table to (-0.1, 0.3).
    at = final.world_T_object("cup")
    np.testing.assert_allclose(at.translation_m, [-0.1, 0.3, 0.7], atol=1e-14)
    assert float(at.scale) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ({"do": "shear"}, r"gestures.jsonl:2: do: expected one of rotate, translate, scale"),
        ({"do": "rotate", "object": 3}, "object: expected a name, got 3"),
        ({"do": "rotate", "object": "cup", "amounts_m": [1]}, "got 'amounts_m'"),
        ({"do": "rotate", "object": "cup", "amounts_rad": []}, "one number or more"),
        ({"do": "rotate", "object": "cup", "amounts_rad": [1e300]}, "expected a number, got 1e"),
        ({"do": "rotate", "object": "cup", "amounts_rad": [1], "axis": [0, 0, 0]}, "direction"),
        ({"do": "rotate", "object": "cup", "amounts_rad": [1], "frame": []}, "local, parent or"),
        ({"do": []}, r"do: expected one of rotate, .*, undo, redo, got \[\]"),
        ({"do": "rotate", "object": []}, r"object: expected a name, got \[\]"),
        ({"do": "undo", "object": "cup"}, "expected fields of do, got 'object'"),
        ([1, 2], "expected an object of JSON, got list"),
    ],
)
def test_a_line_that_is_no_gesture_is_named(tmp_path, line, message):
    path = _gestures(tmp_path, {"do": "undo"}, line)
    with pytest.raises(ValueError, match=message):
        read_gestures(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"objects": {}}, "expected a list of at most 10000"),
        ({}, "expected a list of at most 10000"),
        ({"objects": [{"name": ""}]}, r"objects\[0\].name"),
        ({"objects": [{"name": "a", "parent": "b"}]}, "expected an object named before, got 'b'"),
        ({"objects": [{"name": "a", "parent": []}]}, r"an object named before, got \[\]"),
        ({"objects": [{"name": "a"}, {"name": "a"}]}, "expected a name of its own, got 'a'"),
        ({"objects": [{"name": "a", "wxyz": [1, 0, 0, 0], "euler_deg": [0, 0, 0]}]}, "got both"),
        ({"objects": [{"name": "a", "wxyz": [0, 0, 0, 0]}]}, "scene.json.*wxyz"),
        ({"objects": [{"name": "a", "scale": True}]}, "scale: expected a number, got True"),
        ({"objects": [{"name": "a", "scale": 0}]}, "scale: expected 1e-6 to 1e6, got 0"),
        ({"objects": [{"name": "a", "wxyz": [1, 0, 0]}]}, "expected 4 numbers"),
        ({"objects": [{"name": "a", "size": 1}]}, "expected fields of"),
    ],
)
def test_a_scene_that_is_none_is_refused(tmp_path, change, message):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(change))
    with pytest.raises(ValueError, match=message):
        read_scene(path)


def test_hostile_files_are_refused(tmp_path):
    deep = tmp_path / "deep.json"
    deep.write_text("[" * 200_000)
    with pytest.raises(ValueError, match="expected JSON"):
        read_scene(deep)
    long = tmp_path / "long.json"
    long.write_text("[" + "1" * 5000 + "]")
    with pytest.raises(ValueError, match=r"long\.json: expected JSON"):
        read_scene(long)
    long.write_bytes(b"\xff\xfe[")
    with pytest.raises(ValueError, match="expected UTF-8, got other bytes"):
        read_scene(long)
    large = tmp_path / "large.json"
    large.write_bytes(b" " * (17 * 2**20))
    with pytest.raises(ValueError, match="at most"):
        read_scene(large)
    with pytest.raises(ValueError, match="the file is missing"):
        read_scene(tmp_path / "missing.json")


def test_more_gestures_than_the_limit_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("motorcade.animation.authoring.gestures.MOST_GESTURES", 2)
    path = _gestures(tmp_path, *[{"do": "undo"}] * 3)
    with pytest.raises(ValueError, match="expected at most 2 gestures, got more"):
        read_gestures(path)


def test_a_rotation_may_be_given_as_angles(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps({"objects": [{"name": "a", "euler_deg": [0, 0, 90]}]}))
    rotated = read_scene(path).world_T_object("a").apply([1.0, 0.0, 0.0])
    np.testing.assert_allclose(rotated, [0.0, 1.0, 0.0], atol=1e-15)
