"""Poses of joints and layers: they end, move and go by lines of a gestures file."""

from __future__ import annotations

import pytest

from motorcade.animation.authoring import scene_of
from tests.animation.authoring.test_gestures import edited


def test_poses_end_move_and_go() -> None:
    scene = scene_of({"objects": [{"name": "who", "kind": "character", "file": "mannequin"}]}, "")
    turn = {"head": [0.8, 0.0, 0.0, 0.6]}
    for when in (1.0, 3.0):
        scene = edited(scene, do="joints", object="who", time_s=when, joints=turn)
    scene = edited(scene, do="end_joints", object="who", time_s=1.0, end_s=2.0)
    more = edited(
        scene, do="joints", object="who", time_s=1.0, joints={"chest": [1.0, 0.0, 0.0, 0.0]}
    )
    assert [one.end_s for one in more.part("who").joint_keyframes] == [2.0, None]
    moved = edited(more, do="move_joints", object="who", time_s=1.0, to_s=4.0)
    held = [(one.time_s, one.end_s) for one in moved.part("who").joint_keyframes]
    assert held == [(3.0, None), (4.0, 5.0)]
    over = edited(moved, do="move_joints", object="who", time_s=3.0, to_s=4.0)
    assert [(one.time_s, one.end_s) for one in over.part("who").joint_keyframes] == [(4.0, None)]
    gone = edited(moved, do="remove_joints", object="who", time_s=3.0)
    assert [one.time_s for one in gone.part("who").joint_keyframes] == [4.0]
    forever = edited(gone, do="end_joints", object="who", time_s=4.0, end_s=None)
    assert forever.part("who").joint_keyframes[0].end_s is None
    with pytest.raises(ValueError, match="expected an end after 4 s, got 3 s"):
        edited(gone, do="end_joints", object="who", time_s=4.0, end_s=3.0)


def test_layers_come_change_and_go() -> None:
    scene = scene_of({"objects": [{"name": "who", "kind": "character", "file": "mannequin"}]}, "")
    for clip in ("wave", "nod", "clap"):
        scene = edited(scene, do="layer", object="who", layer={"clip": clip})
    scene = edited(scene, do="layer", object="who", number=1, layer=None)
    scene = edited(
        scene, do="layer", object="who", number=0, layer={"clip": "wave", "fade_s": 1.0, "end_s": 2}
    )
    layers = scene.part("who").layers
    assert [(one.clip, one.end_s, one.fade_s) for one in layers] == [
        ("wave", 2.0, 1.0),
        ("clap", None, 0.3),
    ]
