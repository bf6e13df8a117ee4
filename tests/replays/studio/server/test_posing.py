"""Hands, feet and heads dragged on the image: what the finger holds stays under it."""

import base64
import json
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation.authoring import SceneEditor, gesture_of, read_scene, scene_text
from motorcade.ga import Similarity
from motorcade.replays.studio.dragging import HELD_BY
from tests.replays.studio.server.stage import FRAMES, RunDesk, Visitor, desk, seen
from tests.replays.studio.server.test_session import LENSES

TOPS = {
    "head": "chest",
    "left_hand": "left_upper_arm",
    "right_hand": "right_upper_arm",
    "left_foot": "left_thigh",
    "right_foot": "right_thigh",
}


@pytest.fixture
def one(tmp_path: Path) -> Visitor:
    return Visitor(desk(tmp_path))


def joint_at(at: RunDesk, name: str, joint: str, frame: int) -> np.ndarray:
    """Where a joint is in the world, by what the page draws."""
    session = at.session
    scene = session.history.scene
    number, made = session.played.acted(scene, name)
    motion = session.played.motion(number)
    assert motion is not None
    index = made.character.skeleton.index(joint)
    return placed(at, name, frame, motion["joints"], index)


def placed(at: RunDesk, name: str, frame: int, joints: dict[str, object], index: int) -> np.ndarray:
    """A joint of packed poses in the world, as `Actor.joint` has it."""
    rows = np.frombuffer(base64.b64decode(str(joints["f32"])), "<f4").reshape(joints["shape"])
    session = at.session
    stands = session.played.world_T_object(session.history.scene, name)
    rigid, scale = stands[min(frame, stands.shape[0] - 1)].as_motor_scale()
    size = session.played.acted(session.history.scene, name)[1].size
    row = rows[min(frame, len(rows) - 1), index, :3].astype(float)
    return Similarity.from_motor_scale(rigid, scale * size).apply(row)


@pytest.mark.parametrize("lens", LENSES)
def test_a_joint_stays_under_the_finger(tmp_path: Path, lens: str) -> None:
    rng = np.random.default_rng(5)
    at = desk(tmp_path, LENSES[lens])
    one = Visitor(at)
    name = one.put()
    skeleton = at.session.played.acted(at.session.history.scene, name)[1].character.skeleton
    for joint, top in TOPS.items():
        frame = int(rng.integers(FRAMES))
        start = seen(at, frame, joint_at(at, name, joint, frame))
        limb = seen(at, frame, joint_at(at, name, top, frame)) - start
        # Towards the limb's beginning it reaches by bending; the head goes aside.
        way = 0.1 * limb[::-1] if joint == "head" else 0.15 * limb + rng.uniform(-1.0, 1.0, 2)
        one.done(
            "begin", object=name, gesture="joint", joint=joint, frame=frame, pixels=[start.tolist()]
        )
        told = one.done("drag", pixels=[(start + way).tolist()])["joints"][name]
        shown = seen(at, frame, placed(at, name, 0, told, skeleton.index(joint)))
        # The page has joints as f32: a thousandth of a pixel.
        np.testing.assert_allclose(shown, start + way, atol=0.01)
        assert np.linalg.norm(shown - start) > 0.5
        one.done("end")
        kept = seen(at, frame, joint_at(at, name, joint, frame))
        np.testing.assert_allclose(kept, shown, atol=0.01)
        one.done("undo")
        np.testing.assert_allclose(seen(at, frame, joint_at(at, name, joint, frame)), start)


def test_what_is_held_off_the_joint_does_not_jump(one: Visitor) -> None:
    at, name = one.at, one.put()
    start = seen(at, 0, joint_at(at, name, "left_hand", 0))
    finger = start + np.array([6.0, -4.0])
    one.done(
        "begin", object=name, gesture="joint", joint="left_hand", frame=0, pixels=[finger.tolist()]
    )
    told = one.done("drag", pixels=[finger.tolist()])["joints"][name]
    index = at.session.played.acted(at.session.history.scene, name)[1].character.skeleton.index(
        "left_hand"
    )
    np.testing.assert_allclose(seen(at, 0, placed(at, name, 0, told, index)), start, atol=0.01)


def test_a_finger_takes_the_nearest_where_no_joint_is_named(one: Visitor) -> None:
    at, name = one.at, one.put()
    for joint in HELD_BY:
        pixel = seen(at, 0, joint_at(at, name, joint, 0)) + 0.5
        one.done("begin", object=name, gesture="joint", frame=0, pixels=[pixel.tolist()])
        assert at.session._drags[1].joint == joint
        one.done("cancel")


def test_poses_are_one_step_each_and_replay_to_the_same_bytes(one: Visitor) -> None:
    at, name = one.at, one.put()
    before = scene_text(at.session.history.scene)
    for frame, joint in ((0, "left_hand"), (5, "left_hand"), (5, "right_foot"), (9, "head")):
        start = seen(at, frame, joint_at(at, name, joint, frame))
        one.done(
            "begin", object=name, gesture="joint", joint=joint, frame=frame, pixels=[start.tolist()]
        )
        for step in (3.0, 9.0, 5.0):
            one.done("drag", pixels=[(start + np.array([step, -step])).tolist()])
        one.done("end")
    made = scene_text(at.session.history.scene)
    times = at.session.history.scene.part(name).joint_keyframes
    assert [round(key.time_s, 3) for key in times] == [0.0, 0.2, 0.36]
    write_log = at.session.history.write_log
    editor = SceneEditor(read_scene(write_log.start))
    for line in write_log.gestures.read_text().splitlines():
        editor.do(gesture_of(json.loads(line), "line"))
    assert scene_text(editor.scene) == made
    for _ in range(4):
        one.done("undo")
    assert scene_text(at.session.history.scene) == before


def test_who_is_dragged_and_let_go_stands_as_before(one: Visitor) -> None:
    at, name = one.at, one.put()
    scene = at.session.history.scene
    held = {"object": name, "gesture": "joint", "joint": "left_hand", "frame": 0}
    one.done("begin", pixels=[[320.0, 200.0]], **held)
    assert one.news["holds"] == [name]
    assert not one.ask("begin", pixels=[[320.0, 200.0]], **held)["ok"]
    assert not one.ask("begin", pixels=[[320.0, 200.0]], object=name, gesture="move")["ok"]
    one.done("drag", pixels=[[330.0, 210.0]])
    assert one.news["joints"][name], "others see it"
    assert not one.ask("drag", pixels=[])["ok"]
    assert not one.ask("drag", amount=0.3)["ok"]
    assert one.done("cancel")["free"] == [name]
    assert at.session.history.scene is scene


@pytest.mark.parametrize(
    "wrong",
    [
        {"joint": "tail"},
        {"joint": "hips"},
        {"joint": 3},
        {"pixels": []},
        {"pixels": [[1, 2], [3, 4]]},
        {"frame": FRAMES},
        {"object": "Group"},
    ],
)
def test_what_cannot_be_held_is_refused(one: Visitor, wrong: dict[str, object]) -> None:
    name = one.put()
    one.done("edit", edit={"do": "group", "objects": [name], "name": "Group", "time_s": 0.0})
    asked = {"object": name, "gesture": "joint", "joint": "left_hand", "pixels": [[320, 240]]}
    assert not one.ask("begin", **{**asked, **wrong})["ok"]
    one.done("begin", **asked)
