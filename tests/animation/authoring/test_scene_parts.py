"""What objects of a scene do: read back as written, joined as said, refused by name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, logm
from scipy.spatial.transform import Rotation, Slerp

from motorcade.animation.authoring import (
    Scene,
    ScenePart,
    VersorObjectPose,
    between_keyframes,
    read_scene,
    scene_of,
)
from motorcade.animation.authoring.parts import SceneKeyframe
from motorcade.animation.authoring.scene_file import PART_KEYS, POSE_KEYS
from motorcade.ga import Motor, Similarity

EVERY_KEY = Path(__file__).parents[3] / "docs" / "manifests" / "every_scene_key.json"


def changed(number: int, **fields: Any) -> dict[str, Any]:
    tree: dict[str, Any] = json.loads(EVERY_KEY.read_text())
    tree["objects"][number] |= fields
    return tree


def test_every_key_is_read_and_written_back(tmp_path: Path) -> None:
    scene = read_scene(EVERY_KEY)
    assert scene.anchor_of("plane") == "table"
    assert scene.anchors["box"].marker == 7
    guide, guest = scene.part("guide"), scene.part("guest")
    assert guide.walk is not None
    assert guide.walk.gaits == ("walk", "jog")
    assert guide.layers[0].end_s == 4.0
    assert guest.joint_keyframes[1].rotors["left_hand"].as_quaternion()[2] == pytest.approx(0.6)
    assert scene.part("pair").kind == "group"
    assert scene.part("plane").keyframes[1].angles_deg == (170.0, 89.9, 170.0)
    asked = json.loads(EVERY_KEY.read_text())
    written = scene.as_json()
    for one, again in zip(asked["objects"], written["objects"], strict=True):
        assert set(one) - {"euler_deg"} <= set(again) | {"position_m"}
    file = tmp_path / "again.json"
    file.write_text(json.dumps(written))
    for one, again in zip(written["objects"], read_scene(file).as_json()["objects"], strict=True):
        assert again.keys() == one.keys()
        for key in one.keys() - {"position_m", "wxyz", "scale", "keyframes", "joint_keyframes"}:
            assert again[key] == one[key]
        assert again.get("scale") == pytest.approx(one.get("scale"), rel=1e-15)  # from a versor
    for name in scene.parents:
        pose, again = scene.world_T_object(name), read_scene(file).world_T_object(name)
        np.testing.assert_allclose(again.as_matrix(), pose.as_matrix(), atol=1e-15)


def test_the_example_shows_every_key_that_is_read() -> None:
    tree = json.loads(EVERY_KEY.read_text())
    shown = {key for one in tree["objects"] for key in one}
    assert shown == {"name", "parent", *POSE_KEYS, *PART_KEYS}
    assert {key for one in tree["anchors"].values() for key in one} == {"on", "marker", "floor_m"}


@pytest.mark.parametrize(
    ("tree", "said"),
    [
        (changed(0, kind="person"), r"objects\[0\]: ScenePart.kind: expected one of character"),
        (changed(0, colour="red"), r"objects\[0\]: expected fields of .*, got 'colour'"),
        (changed(0, walk={"path_m": [[0, 0]]}), r"\[0\].walk: SceneWalk.path_m: expected \(P, 2\)"),
        (changed(0, keyframes=[{"time_s": 1}]), "expected none beside a walk"),
        (changed(0, layers=[{"clip": "wave", "mask": 1}]), r"layers\[0\]: expected fields of"),
        (changed(0, layers=[{"clip": "wave", "joints": []}]), r"SceneLayer.joints: expected one"),
        (changed(0, visible=[3, 1]), "expected an end after 3 s, got 1 s"),
        (changed(0, file=3), r"objects\[0\].file: expected a text, got 3"),
        (changed(1, joint_keyframes=[{"time_s": 1, "joints": {}}]), "expected one joint or more"),
        (changed(2, file="a.glb"), "ScenePart.file: expected none for a group"),
        (changed(3, interpolation="slerp"), "interpolation: expected one of motor, quaternion"),
        (changed(3, keyframes=[{"time_s": 1}, {"time_s": 1}]), "expected times that rise"),
        (changed(3, name="box"), "expected a name of its own, got 'box'"),
        ({**changed(0), "version": 2}, "expected 'motorcade-scene' 1, got 'motorcade-scene' 2"),
        ({**changed(0), "lights": []}, "got 'lights'"),
        ({**changed(0), "anchors": {"a": {"on": "marker"}}}, "expected an id with on='marker'"),
        ({**changed(0), "anchors": {"a": {"on": "wall"}}}, "SceneAnchor.on: expected one of auto"),
        ({**changed(0), "anchors": {"table": {}, "box": {"marker": True}}}, "expected an id"),
    ],
)
def test_what_is_unknown_or_wrong_is_refused_by_name(tree: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        scene_of(tree, "scene.json")


def test_more_than_the_limits_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    deep = [{"name": "0"}, *({"name": str(k), "parent": str(k - 1)} for k in range(1, 65))]
    with pytest.raises(ValueError, match="at most 64 deep, got '64'"):
        scene_of({"objects": deep}, "scene.json")
    monkeypatch.setattr("motorcade.animation.authoring.scene_file.MOST_KEYFRAMES", 3)
    with pytest.raises(ValueError, match="at most 3 keyframes in all"):
        scene_of(changed(3), "scene.json")


def poses(rng: np.random.Generator) -> list[Similarity]:
    return [
        Similarity.from_motor_scale(Motor.random(rng, (), 0.3), scale) for scale in (0.5, 1.0, 3.0)
    ]


def flying(keys: list[Similarity], interpolation: Any) -> ScenePart:
    frames = tuple(SceneKeyframe(t, key) for t, key in zip((0.0, 1.0, 4.0), keys, strict=True))
    return ScenePart("prop", "ball.glb", keyframes=frames, interpolation=interpolation)


def test_motors_follow_the_one_parameter_group_of_scipy(rng: np.random.Generator) -> None:
    keys = poses(rng)
    made = between_keyframes(flying(keys, "motor"), np.array([0.0, 0.3, 1.0, 2.5, 4.0, 9.0]))
    a, b, c = (key.as_matrix() for key in keys)
    wanted = [a, a @ expm(0.3 * logm(np.linalg.inv(a) @ b)), b]
    wanted += [b @ expm(0.5 * logm(np.linalg.inv(b) @ c)), c, c]
    for k, one in enumerate(wanted):
        np.testing.assert_allclose(made[k].as_matrix(), one.real, atol=1e-9)


def test_quaternions_turn_as_scipy_s_slerp_and_move_straight(rng: np.random.Generator) -> None:
    keys = poses(rng)
    made = between_keyframes(flying(keys, "quaternion"), np.array([0.25]))
    turns = Rotation.from_matrix([key.rotor.as_matrix() for key in keys[:2]])
    turn = Slerp([0.0, 1.0], turns)(0.25)
    np.testing.assert_allclose(made[0].rotor.as_matrix(), turn.as_matrix(), atol=1e-12)
    straight = 0.75 * keys[0].translation_m + 0.25 * keys[1].translation_m
    np.testing.assert_allclose(made[0].translation_m, straight, atol=1e-12)


def test_euler_angles_are_joined_as_they_were_written() -> None:
    """From 170 to 190 degrees is 20 degrees, though the turns are told apart by no angle of 180."""
    tree = {"name": "a", "kind": "prop", "file": "a.glb", "interpolation": "euler"}
    keys = [{"time_s": 0, "euler_deg": [0, 80, 170]}, {"time_s": 1, "euler_deg": [0, 80, 190]}]
    part = scene_of({"objects": [{**tree, "keyframes": keys}]}, "scene.json").part("a")
    made = between_keyframes(part, np.array([0.5]))[0]
    wanted = Rotation.from_euler("XYZ", [0, 80, 180], degrees=True).as_matrix()
    np.testing.assert_allclose(made.rotor.as_matrix(), wanted, atol=1e-12)
    screw = between_keyframes(part, np.array([0.5]), "motor")[0]
    np.testing.assert_allclose(screw.rotor.as_matrix(), wanted, atol=1e-12)


def test_what_hangs_on_an_anchor_is_told_from_it() -> None:
    up = VersorObjectPose(Similarity.from_motor_scale(Motor.from_translation([0, 0, 1.0]), 2.0))
    scene = read_scene(EVERY_KEY)
    moved = Scene({"pair": "table", "plane": "pair"}, {"pair": up, "plane": up}, {}, scene.anchors)
    np.testing.assert_allclose(moved.world_T_object("plane").translation_m, [0.0, 0.0, 3.0])
    assert moved.with_pose("plane", up).anchors == scene.anchors
