"""Parts and anchors of a scene as JSON holds them: defaults left out, keys in one order."""

from __future__ import annotations

from typing import Any

from motorcade.animation.authoring.parts import (
    JointKeyframe,
    SceneAnchor,
    SceneKeyframe,
    SceneLayer,
    ScenePart,
    SceneWalk,
)
from motorcade.animation.easing import FADE_S
from motorcade.ga import Similarity


def anchor_json(anchor: SceneAnchor) -> dict[str, Any]:
    """As an entry of `anchors`."""
    made: dict[str, Any] = {"on": anchor.on}
    if anchor.marker is not None:
        made["marker"] = anchor.marker
    if anchor.floor_m:
        made["floor_m"] = anchor.floor_m
    return made


def pose_json(pose: Similarity) -> dict[str, Any]:
    """Position, turn and scale, as those of an object."""
    return {
        "position_m": pose.translation_m.tolist(),
        "wxyz": pose.rotor.as_quaternion().tolist(),
        "scale": float(pose.scale),
    }


def part_json(part: ScenePart) -> dict[str, Any]:
    """What an object has besides its name, parent and pose."""
    made: dict[str, Any] = {}
    if part.height_m is not None:
        made["height_m"] = part.height_m
    if part.clip is not None:
        made["clip"] = part.clip
    if part.clip_start_s:
        made["clip_start_s"] = part.clip_start_s
    if part.layers:
        made["layers"] = [layer_json(one) for one in part.layers]
    if part.walk is not None:
        made["walk"] = _walk_json(part.walk)
    if part.keyframes:
        made["keyframes"] = [_keyframe_json(one) for one in part.keyframes]
    if part.interpolation != "motor":
        made["interpolation"] = part.interpolation
    if part.joint_keyframes:
        made["joint_keyframes"] = [_pose_of_joints_json(one) for one in part.joint_keyframes]
    if part.visible_s is not None:
        made["visible"] = list(part.visible_s)
    return made


def _keyframe_json(one: SceneKeyframe) -> dict[str, Any]:
    made = {"time_s": one.time_s, **pose_json(one.parent_T_object)}
    if one.angles_deg is not None:
        del made["wxyz"]
        made["euler_deg"] = list(one.angles_deg)
    return made


def _pose_of_joints_json(one: JointKeyframe) -> dict[str, Any]:
    joints = {name: rotor.as_quaternion().tolist() for name, rotor in one.rotors.items()}
    made: dict[str, Any] = {"time_s": one.time_s, "joints": joints}
    if one.end_s is not None:
        made["end_s"] = one.end_s
    return made


def layer_json(layer: SceneLayer) -> dict[str, Any]:
    """As an entry of `layers`."""
    made: dict[str, Any] = {"clip": layer.clip, "joints": layer.joints, "weight": layer.weight}
    if layer.additive:
        made["additive"] = True
    if layer.start_s:
        made["start_s"] = layer.start_s
    if layer.end_s is not None:
        made["end_s"] = layer.end_s
    if layer.fade_s != FADE_S:
        made["fade_s"] = layer.fade_s
    return made


def _walk_json(walk: SceneWalk) -> dict[str, Any]:
    made: dict[str, Any] = {"path_m": walk.path_m.tolist(), "start_s": walk.start_s}
    if walk.speed_m_s is not None:
        made["speed_m_s"] = walk.speed_m_s
    made["gaits"] = list(walk.gaits)
    return made
