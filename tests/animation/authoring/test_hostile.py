"""Scenes and gestures from strangers: whatever they hold, they are read or refused in one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from motorcade.animation.authoring import gesture_of, read_gestures, read_scene, scene_of

CUP = {"name": "cup"}
DEEP: Any = 0
for _ in range(500):
    DEEP = [DEEP]


def refused(tmp_path: Path, text: str, read: Any = read_scene) -> str:
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(ValueError, match="expected") as fault:
        read(path)
    told = str(fault.value)
    assert "\n" not in told
    assert len(told) < 1000
    return told


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("key", ["", "objects", "anchors", "joints", "object"])
def test_a_million_keys_are_refused(tmp_path: Path, key: str) -> None:
    many = dict.fromkeys((f"k{k}" for k in range(1_000_000)), 0)
    keyframe = {"time_s": 0, "joints": many}
    tree: dict[str, Any] = {
        "": many,
        "objects": {"objects": many},
        "anchors": {"objects": [], "anchors": many},
        "joints": {"objects": [{**CUP, "joint_keyframes": [keyframe]}]},
        "object": {"objects": [{**CUP, **many}]},
    }[key]
    refused(tmp_path, json.dumps(tree))


@pytest.mark.parametrize("text", [
    "[" * 500_000,
    '{"objects": ' + "[" * 500_000,
    '{"a":' * 100_000,
    '{"objects": [{"name": "a", "position_m": [NaN, 0, 0]}]}',
    '{"objects": [{"name": "a", "position_m": [Infinity, 0, 0]}]}',
    '{"objects": [{"name": "a", "position_m": [1e999, 0, 0]}]}',
    '{"objects": [{"name": "a", "position_m": [1' + "0" * 4000 + ", 0, 0]}]}",
    '{"objects": [{"name": "a", "scale": -1}]}',
    '{"objects": [{"name": "a", "scale": 1e-320}]}',
    '{"objects": [{"name": "a", "wxyz": [1e-200, 0, 0, 0]}]}',
    '{"objects": [{"name": "a", "wxyz": [1e300, 0, 0, 0]}]}',
    '{"objects": [{"name": "a", "position_m": "abc"}]}',
    '{"objects": [{"name": "a", "position_m": {"0": 1}}]}',
    '{"objects": [{"name": "a", "scale": 1, "scale": 2}]}',
    '{"objects": [{"name": "a"}], "objects": []}',
    '{"objects": [{"name": "a"}, {"name": "a"}]}',
    '{"objects": [{"name": "a", "parent": "a"}]}',
    '{"objects": [{"name": "a", "parent": "b"}, {"name": "b", "parent": "a"}]}',
    '{"objects": [{"name": "\\ud800"}]}',
    '{"objects": [{"name": "a\\u202eb"}]}',
    '{"objects": [{"name": "a\\u0000"}]}',
    '{"objects": [{"name": "' + "a" * 10_000_000 + '"}]}',
    '{"objects": [{"name": "a", "parent": "' + "b" * 10_000_000 + '"}]}',
    '{"version": true, "objects": []}',
    '{"version": 1e999, "objects": []}',
    '{"schema": ["motorcade-scene"], "objects": []}',
    '{"objects": [{"name": "a", "kind": "prop", "file": "a\\nb"}]}',
    '{"objects": [], "anchors": {"a": {"on": "marker", "marker": 1e3}}}',
    '{"objects": [], "anchors": {"": {}}}',
    "null", "0", '""', "[]", "{}", '{"objects": null}', "\ufeff{}", "{'objects': []}",
])  # fmt: skip
def test_what_is_no_scene_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    refused(tmp_path, text)


def test_more_than_the_limits_are_refused(tmp_path: Path) -> None:
    objects = [{"name": f"o{k}"} for k in range(10_001)]
    assert "at most 10000 objects" in refused(tmp_path, json.dumps({"objects": objects}))
    chain = [{"name": "o0"}]
    chain += [{"name": f"o{k}", "parent": f"o{k - 1}"} for k in range(1, 65)]
    assert "at most 64 deep" in refused(tmp_path, json.dumps({"objects": chain}))
    assert len(scene_of({"objects": chain[:64]}, "").parents) == 64
    keys = [{"time_s": k} for k in range(60_000)]
    two = [{"name": name, "keyframes": keys} for name in "ab"]
    assert "at most 100000 keyframes" in refused(tmp_path, json.dumps({"objects": two}))
    layers = [{"clip": "wave"}] * 1001
    guide = {**CUP, "kind": "character", "file": "mannequin", "layers": layers}
    assert "at most 1000" in refused(tmp_path, json.dumps({"objects": [guide]}))


@pytest.mark.parametrize("text", [
    '{"do": "rotate", "object": "cup", "amounts_rad": [NaN]}',
    '{"do": "rotate", "object": "cup", "amounts_rad": [1], "amounts_rad": [2]}',
    '{"do": "rotate", "object": "cup", "amounts_rad": [1], "axis": [1e-300, 0, 0]}',
    '{"do": "together", "gestures": [{"do": "together", "gestures": []}]}',
    '{"do": "together", "gestures": ' + "[" * 400_000,
    '{"do": "add", "object": ' + '{"a":' * 400 + "0" + "}" * 401,
    '{"do": "' + "x" * 1_000_000 + '"}',
    "[" * 300_000,
    "\x00",
    '{"do": "anchors", "world_T_anchor": {"a": [0,0,0,0,0,0,0,0,0,0,0,0]}}',
    '{"do": "joints", "object": "cup", "time_s": 1, "joints": {"a": [0, 0, 0, 0]}}',
])  # fmt: skip
def test_a_line_that_is_no_gesture_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    assert "a.json" in refused(tmp_path, text, read_gestures)


@pytest.mark.parametrize("given", [
    None, 3, "undo", [], {}, {"do": None}, {"do": {}}, {"do": "undo", "x": 1}, {"do": DEEP},
    {"do": "set", "object": "cup", "layers": DEEP}, {"do": "add", "object": DEEP},
    {"do": "scale", "object": "cup", "factors": [True]},
    {"do": "scale", "object": "cup", "factors": "12"},
    {"do": "rename", "object": "cup", "name": {1, 2}},
    {"do": "rename", "object": "cup", "name": float("nan")},
    {1: 2, "do": "remove", "object": "cup"},
])  # fmt: skip
def test_a_value_that_is_no_gesture_is_refused(given: Any) -> None:
    with pytest.raises(ValueError, match="expected") as fault:
        gesture_of(given, "line 3")
    assert str(fault.value).startswith("line 3: ")
    assert len(str(fault.value)) < 1000
