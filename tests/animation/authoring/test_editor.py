"""The editor: drags end where arithmetic says, on rotors; on Euler angles they do what those do."""

from __future__ import annotations

import time
from contextlib import suppress

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.animation.authoring import (
    Drag,
    Scene,
    SceneAnchor,
    SceneEditor,
    Snapping,
    VersorObjectPose,
    gesture_of,
    scene_text,
)
from motorcade.animation.authoring.poses import EulerObjectPose
from motorcade.ga import Motor, Rotor, Similarity

# (from, to) in degrees, intrinsic x-y'-z'', and the Euler path over the geodesic.
GIMBAL_TABLE = [
    ((10, 85, 10), (-170, 85, -160), 24.7),
    ((0, 89.9, 0), (170, 89.9, 170), 17.0),
    ((0, 45, 0), (180, 45, -180), 1.53),
    ((0, 89, 0), (90, 89, 0), 1.00),
]


@pytest.fixture
def scene(rng) -> Scene:
    """A table that is turned and large, with a cup on it."""
    poses = {
        name: VersorObjectPose(Similarity.from_motor_scale(Motor.random(rng), scale))
        for name, scale in (("table", 2.0), ("cup", 0.5))
    }
    return Scene({"table": None, "cup": "table"}, poses)


def _matrix(scene: Scene, name: str = "cup") -> np.ndarray:
    return scene.world_T_object(name).as_matrix()


def _turn(axis, angle: float) -> np.ndarray:
    made = np.eye(4)
    unit = np.asarray(axis) / np.linalg.norm(axis)
    made[:3, :3] = Rotation.from_rotvec(angle * unit).as_matrix()
    return made


@pytest.mark.parametrize("frame", ["local", "parent", "global"])
def test_a_turn_is_about_the_objects_origin_and_an_axis_of_the_frame(scene, frame):
    axis, angle = [1.0, -2.0, 0.5], 0.8
    before, parent = _matrix(scene), _matrix(scene, "table")
    edited = SceneEditor(scene).apply(Drag("cup", "rotate", axis, frame), angle)
    own = {"local": before, "parent": parent, "global": np.eye(4)}[frame].copy()
    own[:3, :3] /= np.cbrt(np.linalg.det(own[:3, :3]))
    own[:3, 3] = before[:3, 3]
    expected = own @ _turn(axis, angle) @ np.linalg.inv(own) @ before
    np.testing.assert_allclose(_matrix(edited), expected, atol=1e-12)


@pytest.mark.parametrize("frame", ["local", "parent", "global"])
def test_a_shift_is_in_the_frames_metres(scene, frame):
    axis = np.array([0.0, 3.0, -4.0])
    before, parent = _matrix(scene), _matrix(scene, "table")
    edited = SceneEditor(scene).apply(Drag("cup", "translate", axis, frame), 0.7)
    own = {"local": before, "parent": parent, "global": np.eye(4)}[frame]
    translated = _matrix(edited)[:3, 3] - before[:3, 3]
    np.testing.assert_allclose(translated, own[:3, :3] @ (0.7 * axis / 5.0), atol=1e-12)
    np.testing.assert_allclose(_matrix(edited)[:3, :3], before[:3, :3], atol=1e-12)


def test_growing_keeps_the_origin_and_carries_children(scene):
    before = _matrix(scene)
    edited = SceneEditor(scene).apply(Drag("table", "scale"), 1.5)
    origin = _matrix(scene, "table")[:3, 3]
    expected = origin + 1.5 * (before[:3, 3] - origin)
    np.testing.assert_allclose(_matrix(edited)[:3, 3], expected, atol=1e-12)
    np.testing.assert_allclose(_matrix(edited)[:3, :3], 1.5 * before[:3, :3], atol=1e-12)


@pytest.mark.parametrize("frame", ["local", "parent", "global"])
def test_on_euler_angles_shifts_and_growth_are_those_on_versors(scene, frame):
    """Only turns go another way."""
    drags = [(Drag("cup", "translate", (0.0, 3.0, -4.0), frame), 0.7), (Drag("cup", "scale"), 1.4)]
    found = []
    for start in (scene, scene.on_euler_angles()):
        editor = SceneEditor(start)
        for drag, amount in drags:
            editor.apply(drag, amount)
        found.append(_matrix(editor.scene))
    np.testing.assert_allclose(found[1], found[0], atol=1e-12)


def test_a_drag_counts_from_where_it_began(scene):
    editor = SceneEditor(scene)
    editor.begin(Drag("cup", "rotate", (0, 0, 1)))
    for amount in np.linspace(0.0, 1.0, 57):
        editor.drag_to(float(amount))
    editor.drag_to(0.25)
    once = SceneEditor(scene).apply(Drag("cup", "rotate", (0, 0, 1)), 0.25)
    np.testing.assert_array_equal(_matrix(editor.end()), _matrix(once))


def test_ten_thousand_small_drags_end_where_arithmetic_says(scene):
    editor = SceneEditor(scene)
    axis = (1.0, 2.0, 3.0)
    for _ in range(10_000):
        editor.apply(Drag("cup", "rotate", axis, "local"), 1e-3)
    before = scene.pose("cup").as_similarity()
    unit = np.array(axis) / np.linalg.norm(axis)
    expected = before.rotor @ Rotor.from_rotation_vector(10.0 * unit)
    found = editor.scene.pose("cup").as_similarity()
    assert abs(np.linalg.norm(found.rotor.coefficients) - 1.0) < 1e-12
    assert float((expected.inverse() @ found.rotor).angle()) < 1e-11
    np.testing.assert_allclose(found.translation_m, before.translation_m, atol=1e-11)


def test_turns_by_euler_angles_are_right_about_one_axis_and_wrong_about_two(scene):
    flat = Scene(
        scene.parents, {name: VersorObjectPose(Similarity.identity()) for name in scene.poses}
    )
    rotors, angles = SceneEditor(flat), SceneEditor(flat.on_euler_angles())
    for editor in (rotors, angles):
        editor.apply(Drag("cup", "rotate", (0, 0, 1), "local"), 0.9)
    np.testing.assert_allclose(_matrix(angles.scene), _matrix(rotors.scene), atol=1e-12)
    for editor in (rotors, angles):
        editor.apply(Drag("cup", "rotate", (1, 0, 0), "local"), 0.9)
    expected = _turn((0, 0, 1), 0.9) @ _turn((1, 0, 0), 0.9)
    np.testing.assert_allclose(_matrix(rotors.scene), expected, atol=1e-12)
    # The ring named x turns about the parent's x, not the object's own.
    wrong = _turn((1, 0, 0), 0.9) @ _turn((0, 0, 1), 0.9)
    np.testing.assert_allclose(_matrix(angles.scene), wrong, atol=1e-12)


def test_at_ninety_degrees_two_rings_turn_alike_and_rotors_do_not(scene):
    flat = Scene(
        scene.parents, {name: VersorObjectPose(Similarity.identity()) for name in scene.poses}
    )
    rotated = SceneEditor(flat).apply(Drag("cup", "rotate", (0, 1, 0)), np.pi / 2)
    held = rotated.on_euler_angles()
    x, z = (
        SceneEditor(held).apply(Drag("cup", "rotate", axis), 0.4) for axis in ((1, 0, 0), (0, 0, 1))
    )
    np.testing.assert_allclose(_matrix(x), _matrix(z), atol=1e-7)
    x, z = (
        SceneEditor(rotated).apply(Drag("cup", "rotate", axis), 0.4)
        for axis in ((1, 0, 0), (0, 0, 1))
    )
    assert np.abs(_matrix(x) - _matrix(z)).max() > 0.3


@pytest.mark.parametrize(("start", "end", "ratio"), GIMBAL_TABLE)
def test_the_gimbal_table(start, end, ratio):
    poses = [EulerObjectPose(np.radians(angles), np.zeros(3)) for angles in (start, end)]
    angles = SceneEditor(Scene({"cup": None}, {"cup": poses[0]}))
    rotors = SceneEditor(Scene({"cup": None}, {"cup": VersorObjectPose(Similarity.identity())}))
    versors = [VersorObjectPose(pose.as_similarity()) for pose in poses]
    geodesic = float(
        (versors[0].as_similarity().rotor.inverse() @ versors[1].as_similarity().rotor).angle()
    )
    for editor, ends, expected in ((angles, poses, ratio), (rotors, versors, 1.0)):
        path = editor.path("cup", *ends, steps=1000).rotor
        length = float(np.sum((path[:-1].inverse() @ path[1:]).angle()))
        digits = (
            1e-6
            if expected == 1.0 and editor is rotors
            else 0.5 * 10 ** (-1 if expected > 2 else -2)
        )
        assert length / geodesic == pytest.approx(expected, abs=digits)


def test_snapping_rounds_what_is_dragged_and_not_where_it_lies(scene):
    snapping = Snapping(angle_rad=np.radians(15.0), distance_m=0.1, scale=0.25)
    editor = SceneEditor(scene, snapping)
    editor.begin(Drag("cup", "rotate", (0, 0, 1)))
    editor.drag_to(np.radians(20.0))
    snapped = editor.end()
    exact = SceneEditor(scene).apply(Drag("cup", "rotate", (0, 0, 1)), np.radians(15.0))
    np.testing.assert_allclose(_matrix(snapped), _matrix(exact), atol=1e-14)
    assert [snapping.rounded("scale", x) for x in (1.1, 1.2, 0.01)] == [1.0, 1.25, 0.25]
    assert snapping.rounded("translate", 0.26) == pytest.approx(0.3)


def test_undo_and_redo_walk_through_the_history(scene):
    editor = SceneEditor(scene)
    states = [scene]
    for k in range(3):
        states.append(editor.apply(Drag("cup", "translate", (1, 0, 0)), 0.1 * (k + 1)))
    for expected in (states[2], states[1]):
        _assert_same_poses(editor.undo(), expected)
    _assert_same_poses(editor.redo(), states[2])
    changed = editor.apply(Drag("cup", "scale"), 2.0)
    assert editor.redo() is changed  # what was undone is gone
    assert not editor.can_redo
    for _ in range(9):
        editor.undo()
    _assert_same_poses(editor.scene, scene)
    assert not editor.can_undo


def _assert_same_poses(one: Scene, other: Scene) -> None:
    """The very values, not equal ones."""
    assert list(one.parents) == list(other.parents)
    assert all(one.poses[name] is other.poses[name] for name in one.parents)


def test_a_cancelled_drag_leaves_no_trace(scene):
    editor = SceneEditor(scene)
    editor.begin(Drag("cup", "rotate"))
    editor.drag_to(1.0)
    assert editor.cancel() is scene
    assert editor.undo() is scene


def test_refusals(scene):
    editor = SceneEditor(scene)
    with pytest.raises(ValueError, match="expected one of table, cup, got 'plate'"):
        editor.begin(Drag("plate", "rotate"))
    with pytest.raises(RuntimeError, match="begin a drag first"):
        editor.drag_to(1.0)
    editor.begin(Drag("cup", "rotate"))
    for verb in (lambda: editor.begin(Drag("cup", "rotate")), editor.undo, editor.redo):
        with pytest.raises(RuntimeError, match="end or cancel the drag that is going on first"):
            verb()
    editor.cancel()
    with pytest.raises(ValueError, match="expected a factor above 0, got 0"):
        editor.apply(Drag("cup", "scale"), 0.0)
    assert editor.scene is scene
    with pytest.raises(ValueError, match="expected a direction"):
        Drag("cup", "rotate", (0, 0, 0))
    with pytest.raises(ValueError, match="expected one of rotate, translate, scale, similarity"):
        Drag("cup", "shear")
    with pytest.raises(ValueError, match="expected two poses of type VersorObjectPose"):
        editor.path("cup", EulerObjectPose(np.zeros(3), np.zeros(3)), scene.pose("cup"))


@pytest.mark.parametrize("step", [-0.1, np.nan, np.inf])
@pytest.mark.parametrize("name", ["angle_rad", "distance_m", "scale"])
def test_steps_that_are_none_are_refused(name, step):
    with pytest.raises(ValueError, match=rf"Snapping\.{name}: expected 0 or a step above 0"):
        Snapping(**{name: step})


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (([0.0, 0.0], [0.0] * 3, 1.0), r"EulerObjectPose\.angles_rad"),
        ((np.zeros((2, 3)), [0.0] * 3, 1.0), r"angles_rad: expected \(3,\), got \(2, 3\)"),
        (([0.0] * 3, [0.0, np.nan, 0.0], 1.0), r"position_m: expected finite"),
        (([0.0] * 3, [0.0] * 3, 0.0), "scale: expected a number above 0, got 0"),
        (([0.0] * 3, [0.0] * 3, np.nan), "scale: expected a number above 0, got nan"),
    ],
)
def test_poses_that_are_none_are_refused(fields, message):
    with pytest.raises(ValueError, match=message):
        EulerObjectPose(*fields)


def test_scenes_that_are_no_trees_are_refused(scene):
    cup, table = scene.pose("cup"), scene.pose("table")
    with pytest.raises(ValueError, match="one pose for each object and no others"):
        Scene({"table": None, "cup": "table"}, {"table": table})
    with pytest.raises(ValueError, match="the parent of 'cup' before it, got 'table'"):
        Scene({"cup": "table", "table": "cup"}, {"table": table, "cup": cup})
    with pytest.raises(ValueError, match=r"one similarity, got a batch of shape \(2,\)"):
        VersorObjectPose(Similarity.identity((2,)))


def test_additions_cost_the_history_what_they_add() -> None:
    editor, began = SceneEditor(Scene({}, {})), time.process_time()
    for number in range(4000):
        editor.do(gesture_of({"do": "add", "object": {"name": f"cup {number}"}}))
    assert time.process_time() - began < 2.0  # 5 s where each step held the scenes on both sides
    assert list(editor.undo().parents)[-1] == "cup 3998"
    assert list(editor.redo().parents)[-1] == "cup 3999"


@pytest.mark.parametrize("seed", range(3))
def test_edits_of_the_tree_go_back_and_forth_exactly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    editor = SceneEditor(Scene({}, {}, {}, {"ground": SceneAnchor()}))
    texts = [scene_text(editor.scene)]
    for number in range(120):
        names = list(editor.scene.parents)
        line = {"do": "add", "object": {"name": f"new {number}", "parent": "ground"}}
        if len(names) > 2:
            name, other = (str(one) for one in rng.choice(names, 2, replace=False))
            line = [
                line,
                {"do": "remove", "object": name},
                {"do": "copy", "object": name, "name": f"copy {number}"},
                {"do": "rename", "object": name, "name": f"name {number}"},
                {"do": "group", "objects": [name], "name": f"group {number}"},
                {"do": "reparent", "object": name, "parent": other},
                {"do": "set", "object": name, "position_m": rng.normal(size=3).tolist()},
                {"do": "anchor", "name": f"floor {number}", "on": "floor"},
            ][int(rng.integers(8))]
        with suppress(ValueError):
            editor.do(gesture_of(line))
        if scene_text(editor.scene) != texts[-1]:
            texts.append(scene_text(editor.scene))
    for text in texts[-2::-1]:
        assert scene_text(editor.undo()) == text
    assert not editor.can_undo
    for text in texts[1:]:
        assert scene_text(editor.redo()) == text
