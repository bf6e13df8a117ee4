"""Drags, edits and their history: bit for bit back and forth, and again from a file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.animation.authoring import (
    Drag,
    Edit,
    Gesture,
    Scene,
    SceneEditor,
    Snapping,
    gesture_of,
    read_gestures,
    replay,
    scene_of,
    scene_text,
)
from motorcade.animation.authoring.gestures import gestures_text
from motorcade.ga import Motor, Rotor, Similarity
from tests.animation.authoring.made import BUSY, busy_scene, drawn_gesture

STILL = Similarity.identity()


def bits(scene: Scene) -> tuple[Any, ...]:
    """All that a scene holds, poses by their bits."""
    poses = {name: one.as_similarity().coefficients.tobytes() for name, one in scene.poses.items()}
    return list(scene.parents.items()), poses, scene_text(scene)


def held(scene: Scene) -> tuple[Any, ...]:
    """The same, with parts by being the very ones."""
    poses = [one.as_similarity().coefficients.tobytes() for one in scene.poses.values()]
    return list(scene.parents.items()), poses, dict(scene.parts), dict(scene.anchors)


def edited(scene: Scene, **line: Any) -> Scene:
    return SceneEditor(scene).do(gesture_of(line))


def random_session(seed: int, count: int) -> tuple[SceneEditor, list[Gesture]]:
    """An editor after random gestures, and those that were taken."""
    rng = np.random.default_rng(seed)
    editor, taken = SceneEditor(busy_scene()), []
    while len(taken) < count:
        gesture = gesture_of(json.loads(json.dumps(drawn_gesture(rng, editor.scene))))
        before = bits(editor.scene) if len(taken) % 50 == 0 else None
        try:
            editor.do(gesture)
        except ValueError:
            assert before is None or bits(editor.scene) == before
            continue
        taken.append(gesture)
    return editor, taken


def test_a_thousand_random_gestures_are_undone_and_done_again_bit_for_bit() -> None:
    editor, taken = random_session(3, 1000)
    kinds = {type(one).__name__ for one in taken} | {one.as_json()["do"] for one in taken}
    assert len(kinds) >= 22, kinds
    last, states = bits(editor.scene), []
    while editor.can_undo:
        states.append(held(editor.scene))
        editor.undo()
    assert bits(editor.scene) == bits(busy_scene())
    assert len(states) > 300
    for expected in reversed(states):
        assert held(editor.redo()) == expected
    assert bits(editor.scene) == last
    assert not editor.can_redo


@pytest.mark.parametrize("seed", [1, 2])
def test_gestures_from_a_file_give_the_same_bytes(tmp_path: Path, seed: int) -> None:
    editor, taken = random_session(seed, 400)
    file = tmp_path / "gestures.jsonl"
    file.write_text(gestures_text(taken))
    again = SceneEditor(scene_of(BUSY, "busy"))
    assert bits(replay(again, read_gestures(file))) == bits(editor.scene)
    assert gestures_text(read_gestures(file)) == file.read_text()


@pytest.mark.parametrize("seed", range(4))
def test_what_was_edited_is_read_back_where_it_stood(seed: int) -> None:
    editor, _ = random_session(10 + seed, 150)
    scene = editor.scene
    again = scene_of(json.loads(scene_text(scene)), "again")
    assert list(again.parents.items()) == list(scene.parents.items())
    for name in scene.parents:
        for time_s in (None, 0.7):
            one, other = scene.world_T_object(name, time_s), again.world_T_object(name, time_s)
            size = max(1.0, float(np.abs(one.as_matrix()).max()))
            np.testing.assert_allclose(other.as_matrix(), one.as_matrix(), atol=1e-9 * size)


@pytest.mark.slow
def test_rotors_keep_their_length_over_a_hundred_thousand_gestures() -> None:
    rng = np.random.default_rng(5)
    scene = scene_of({"objects": [{"name": "a"}, {"name": "b", "parent": "a"}]}, "")
    editor = SceneEditor(scene)
    turns = Similarity.random(rng, (100_000,), 1e-3, 1e-3)
    for k in range(100_000):
        frame = ("local", "parent", "global")[k % 3]
        editor.apply(Drag("ab"[k % 2], "similarity", frame=frame), turns[k])
        if k % 1000 == 0:
            for pose in editor.scene.poses.values():
                rotor = pose.as_similarity().rotor.coefficients
                assert abs(float(np.linalg.norm(rotor)) - 1.0) < 1e-12
    while editor.can_undo:
        editor.undo()
    assert bits(editor.scene) == bits(scene)


@pytest.mark.parametrize("frame", ["local", "parent", "global"])
def test_a_similarity_drag_is_a_matrix_product_in_its_frame(frame: str, rng: Any) -> None:
    scene, motion = busy_scene(), Similarity.random(rng)
    anchors = {"table": Similarity.from_motor_scale(Motor.random(rng))}
    editor = SceneEditor(scene)
    editor.stand(anchors)
    moved = editor.apply(Drag("guide", "similarity", frame=frame), motion)  # type: ignore[arg-type]
    before, after = (
        one.world_T_object("guide", None, anchors).as_matrix() for one in (scene, moved)
    )
    parent, own = scene.world_T_parent("guide", None, anchors).as_matrix(), motion.as_matrix()
    expected = {
        "local": before @ own,
        "parent": parent @ own @ np.linalg.inv(parent) @ before,
        "global": own @ before,
    }[frame]
    np.testing.assert_allclose(after, expected, atol=1e-12)
    # On Euler angles it ends in the same place: a drag of this kind is no ring.
    angled = SceneEditor(scene.on_euler_angles())
    angled.stand(anchors)
    angled.apply(Drag("guide", "similarity", frame=frame), motion)  # type: ignore[arg-type]
    found = angled.scene.world_T_object("guide", None, anchors).as_matrix()
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_one_gesture_may_go_on_about_other_axes_and_is_one_step() -> None:
    editor = SceneEditor(busy_scene())
    editor.begin(Drag("guide", "rotate", (0, 0, 1), "local"))
    editor.drag_to(0.5)
    editor.go_on(Drag("guide", "rotate", (0, 1, 0), "global"))
    editor.drag_to(9.0)
    editor.drag_to(0.3)
    editor.go_on(Drag("cup", "translate", (1, 0, 0)))
    editor.drag_to(0.1)
    once = bits(editor.end())
    other = SceneEditor(busy_scene())
    other.apply(Drag("guide", "rotate", (0, 0, 1), "local"), 0.5)
    other.apply(Drag("guide", "rotate", (0, 1, 0), "global"), 0.3)
    other.apply(Drag("cup", "translate", (1, 0, 0)), 0.1)
    assert bits(other.scene) == once
    assert bits(editor.undo()) == bits(busy_scene())
    editor.begin(Drag("guide", "rotate", (0, 0, 1)))
    editor.drag_to(0.5)
    editor.go_on(Drag("cup", "scale"))
    editor.drag_to(3.0)
    assert bits(editor.cancel()) == bits(busy_scene())


def test_what_changes_nothing_is_no_step() -> None:
    editor = SceneEditor(busy_scene())
    editor.apply(Drag("cup", "translate"), 1.0)
    editor.undo()
    editor.begin(Drag("cup", "rotate"))
    editor.drag_to(1.0)
    editor.drag_to(0.0)
    editor.end()
    editor.begin(Drag("cup", "scale"))
    editor.end()
    editor.apply(Drag("cup", "similarity"), STILL)
    for line in (
        {"do": "rename", "object": "cup", "name": "cup"},
        {"do": "set", "object": "guide", "clip": "idle"},
        {"do": "reparent", "object": "cup", "parent": "guide"},
        {"do": "anchor", "name": "table", "on": "board"},
    ):
        editor.do(gesture_of(line))
    assert not editor.can_undo
    assert editor.can_redo  # nor did it take away what may be done again


@pytest.mark.parametrize("parent", [None, "box", "frame", "bird"])
@pytest.mark.parametrize("name", ["cup", "guide", "bird", "frame"])
def test_what_is_hung_elsewhere_stays_in_the_world(rng: Any, parent: str, name: str) -> None:
    anchors = {one: Similarity.random(rng) for one in ("table", "box")}
    editor = SceneEditor(busy_scene())
    editor.stand(anchors)
    before = {
        one: editor.scene.world_T_object(one, 0.7, anchors) for one in editor.scene.branch(name)
    }
    if parent in before:
        with pytest.raises(ValueError, match="expected none that hangs on"):
            editor.do(Edit({"do": "reparent", "object": name, "parent": parent, "time_s": 0.7}))
        return
    after = editor.do(Edit({"do": "reparent", "object": name, "parent": parent, "time_s": 0.7}))
    assert after.parents[name] == parent
    for one, place in before.items():
        found = after.world_T_object(one, 0.7, anchors)
        np.testing.assert_allclose(found.as_matrix(), place.as_matrix(), atol=1e-11)


def test_groups_carry_what_is_put_in_them_and_leave_it_where_it_is() -> None:
    editor = SceneEditor(busy_scene())
    before = {one: editor.scene.world_T_object(one).as_matrix() for one in ("cup", "walker")}
    scene = editor.do(Edit({"do": "group", "objects": ["walker", "cup"], "name": "pair"}))
    assert (scene.parents["pair"], scene.parents["cup"]) == ("table", "pair")
    for one, matrix in before.items():
        np.testing.assert_allclose(scene.world_T_object(one).as_matrix(), matrix, atol=1e-12)
    scene = editor.do(Edit({"do": "ungroup", "object": "pair"}))
    assert "pair" not in scene.parents
    with pytest.raises(ValueError, match="expected a plane like that in which 'walker' walks"):
        editor.do(Edit({"do": "reparent", "object": "walker", "parent": "guide"}))
    for one, matrix in before.items():
        np.testing.assert_allclose(scene.world_T_object(one).as_matrix(), matrix, atol=1e-12)


def test_a_drag_at_a_time_sets_the_keyframe_there_and_no_other() -> None:
    scene = busy_scene()
    with pytest.raises(ValueError, match="time_s: expected a time, as 'bird' has keyframes"):
        SceneEditor(scene).apply(Drag("bird", "translate"), 1.0)
    old = scene.part("bird").keyframes
    for time_s, count in ((0.5, 2), (1.0, 3)):
        at = scene.pose_at("bird", time_s).translation_m
        drag = Drag("bird", "translate", (0, 0, 1), "parent", time_s)
        moved = SceneEditor(scene).apply(drag, 0.25)
        keys = moved.part("bird").keyframes
        assert len(keys) == count
        found = moved.pose_at("bird", time_s).translation_m
        np.testing.assert_allclose(found, at + np.array([0, 0, 0.25]), atol=1e-12)
        assert keys[-1] is old[-1]


def test_a_walk_is_dragged_with_its_way() -> None:
    scene = busy_scene()
    turned = SceneEditor(scene).apply(Drag("walker", "rotate", (0, 0, 1), "parent"), np.pi / 2)
    walk = turned.part("walker").walk
    assert walk is not None
    np.testing.assert_allclose(walk.path_m, [[0, 0], [-0.1, 0.3], [-0.5, 0.3]], atol=1e-12)


def test_keyframes_come_move_and_go() -> None:
    scene = edited(busy_scene(), do="keyframe", object="cup", time_s=1.0, position_m=[1, 0, 0])
    scene = edited(scene, do="keyframe", object="cup", time_s=2.0, position_m=[3, 0, 0])
    assert scene.pose_at("cup", 1.5).translation_m[0] == pytest.approx(2.0)
    scene = edited(scene, do="move_keyframe", object="cup", time_s=2.0, to_s=3.0)
    assert scene.pose_at("cup", 1.5).translation_m[0] == pytest.approx(1.5)
    for time_s in (1.0, 3.0):
        scene = edited(scene, do="remove_keyframe", object="cup", time_s=time_s)
    assert scene.part("cup").keyframes == ()
    assert scene.pose("cup").as_similarity().translation_m[0] == pytest.approx(3.0)
    turn = Rotor.from_euler([0.1, 0.2, 0.3]).as_quaternion().tolist()
    posed = edited(scene, do="joints", object="guide", time_s=1.0, joints={"head": turn})
    posed = edited(posed, do="joints", object="guide", time_s=1.0, joints={"left_hand": turn})
    assert list(posed.part("guide").joint_keyframes[0].rotors) == ["head", "left_hand"]
    gone = {"head": None, "left_hand": None}
    assert not edited(
        posed, do="joints", object="guide", time_s=1.0, joints=gone
    ).part("guide").joint_keyframes  # fmt: skip


def test_fields_are_set_as_a_scene_file_says_them() -> None:
    scene = edited(
        busy_scene(), do="set", object="guide", clip="walk", height_m=0.3, visible=[1, 2],
        layers=[{"clip": "wave", "joints": "right_arm"}], position_m=[1, 2, 3], scale=0.5,
    )  # fmt: skip
    part = scene.part("guide")
    assert (part.clip, part.height_m, part.visible_s) == ("walk", 0.3, (1.0, 2.0))
    assert part.layers[0].joints == "right_arm"
    pose = scene.pose("guide").as_similarity()
    np.testing.assert_allclose(pose.translation_m, [1, 2, 3])
    assert float(pose.scale) == pytest.approx(0.5)
    before = busy_scene().pose("guide").as_similarity().rotor
    assert float((pose.rotor.inverse() @ before).angle()) < 1e-7
    assert edited(scene, do="set", object="guide", layers=None).part("guide").layers == ()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ({"do": "add", "object": {"name": "cup"}}, "expected one that nothing else has, got 'cup'"),
        ({"do": "add", "object": {"name": "x", "parent": "y"}}, "expected an object or an anchor"),
        ({"do": "add"}, "object: expected an object of JSON, got None"),
        ({"do": "add", "object": {"name": "x\n"}}, "object.name: expected a name"),
        ({"do": "copy", "object": "plate", "name": "x"}, "expected one of frame, .*, got 'plate'"),
        ({"do": "rename", "object": "cup", "name": "table"}, "expected one that nothing else has"),
        ({"do": "group", "objects": [], "name": "x"}, "expected one or more different names"),
        ({"do": "group", "objects": ["cup", "guide"], "name": "x"}, "none that hang on others"),
        ({"do": "ungroup", "object": "cup"}, "expected a group, got 'cup'"),
        ({"do": "reparent", "object": "cup"}, "parent: expected a name, or null"),
        ({"do": "reparent", "object": "guide", "parent": "cup"}, "none that hangs on 'guide'"),
        ({"do": "set", "object": "cup", "colour": 1}, "expected fields of .*, got 'colour'"),
        ({"do": "set", "object": "cup", "walk": {"path_m": [[0, 0], [1, 0]]}}, "none for a prop"),
        ({"do": "set", "object": "cup", "scale": 0}, "pose.scale: expected 1e-6 to 1e6"),
        ({"do": "set", "object": "bird", "scale": 2}, "time_s: expected a time"),
        ({"do": "keyframe", "object": "cup"}, "time_s: expected a number, got none"),
        ({"do": "keyframe", "object": "walker", "time_s": 1}, "expected none beside a walk"),
        ({"do": "move_joints", "object": "cup", "time_s": 9, "to_s": 1}, "a pose of 'cup', got 9"),
        ({"do": "end_joints", "object": "cup", "time_s": 9}, "end_s: expected a number, or null"),
        ({"do": "remove_joints", "object": "cup"}, "time_s: expected a number, got none"),
        ({"do": "layer", "object": "guide"}, "layer: expected one as in a scene file"),
        ({"do": "layer", "object": "guide", "layer": None}, "number: expected that of the layer"),
        ({"do": "layer", "object": "guide", "number": 9, "layer": None}, "one of . layers, got 9"),
        ({"do": "layer", "object": "cup", "layer": {"clip": "a"}}, "expected none for a prop"),
        ({"do": "remove_keyframe", "object": "bird", "time_s": 9}, "that of a keyframe of 'bird'"),
        ({"do": "joints", "object": "guide", "time_s": 1, "joints": {}}, "expected 1 to 1000"),
        ({"do": "remove_anchor", "name": "box"}, "on which nothing hangs, 'bird' does"),
        ({"do": "anchor", "name": "cup", "on": "board"}, "expected one that nothing else has"),
        ({"do": "anchor", "name": "x", "on": "marker"}, "expected an id with on='marker'"),
        ({"do": "together", "gestures": []}, "expected one or more"),
        ({"do": "together", "gestures": [{"do": "undo"}]}, "expected one of rotate"),
        ({"do": "anchors", "world_T_anchor": {"table": [1] * 12}}, "expected unit versors"),
        ({"object": "cup", "do": "similarity", "similarities": [[1]]}, "expected 12 numbers"),
        ({"object": "cup", "do": "scale", "factors": [0]}, "expected a factor above 0"),
        ({"object": "cup", "do": "scale", "factors": [1e8]}, "scale: expected 1e-06 to 1e"),
        ({"object": "cup", "do": "translate", "amounts_m": [9.995e8]}, "position_m: expected less"),
        ({"do": "set", "object": "x" * 10**6}, "expected a name, got 'xxx"),
    ],
)
def test_what_cannot_be_is_refused_and_leaves_the_scene(line: dict[str, Any], said: str) -> None:
    editor = SceneEditor(busy_scene())
    with pytest.raises(ValueError, match=said) as fault:
        editor.do(gesture_of(line))
    assert len(str(fault.value)) < 500
    assert bits(editor.scene) == bits(busy_scene())
    editor.apply(Drag("cup", "rotate"), 1.0)


def test_similarities_are_snapped_about_the_object() -> None:
    editor = SceneEditor(busy_scene(), Snapping(np.radians(15), 0.1, 0.25))
    angle = np.radians(20)
    turn = Rotor.from_rotation_vector([0, 0, angle])
    motion = Similarity.from_rotor_translation_scale(turn, [0.27, 0.0, 0.02], 1.3)
    before = editor.scene.pose("cup").as_similarity()
    after = editor.apply(Drag("cup", "similarity", frame="parent"), motion)
    pose = after.pose("cup").as_similarity()
    np.testing.assert_allclose(pose.translation_m - before.translation_m, [0.3, 0, 0], atol=1e-12)
    assert float(pose.scale) == pytest.approx(1.25)
    assert float((before.rotor.inverse() @ pose.rotor).angle()) == pytest.approx(np.radians(15))


def test_where_an_object_stands_over_time_is_where_it_stands_at_each(rng: Any) -> None:
    scene = busy_scene()
    anchors = {name: Similarity.random(rng) for name in ("table", "box")}
    times = np.array([-1.0, 0.5, 1.1, 2.0, 9.0])
    path = scene.world_T_object("bird", times, anchors)
    assert path.shape == (5,)
    for k, time_s in enumerate(times):
        one = scene.world_T_object("bird", float(time_s), anchors)
        np.testing.assert_allclose(path[k].as_matrix(), one.as_matrix(), atol=1e-12)
