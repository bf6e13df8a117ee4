"""Edits of what an object is and where it is when: its fields and keyframes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from motorcade.animation.authoring.editing.drags import (
    SAME_TIME_S,
    checked_pose,
    placed,
    room_for_keyframes,
    with_keyframe,
)
from motorcade.animation.authoring.editing.trees import Change, pose_kind
from motorcade.animation.authoring.fields import number, object_name
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose
from motorcade.animation.authoring.scene import Scene
from motorcade.animation.authoring.scene_file import (
    PART_KEYS,
    POSE_KEYS,
    part_fields,
    similarity_of,
)
from motorcade.animation.authoring.written import pose_json
from motorcade.ga import Similarity

__all__ = ["FIELDS", "POSE_KEYS"]
FIELDS = (*POSE_KEYS, *PART_KEYS)


def fields_set(line: Mapping[str, Any]) -> Change:
    """Some of an object's keys as given; null is what they are when left out."""
    name = object_name(line.get("object"), "object")
    time_s = None if line.get("time_s") is None else number(line["time_s"], "time_s")
    said = part_fields(line, "set")
    given = _pose_given(line)

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        if said:
            part = replace(scene.part(name), **said)
            room_for_keyframes(scene, part.keyframe_count - scene.part(name).keyframe_count)
            scene = scene.with_part(name, part)
        return placed(scene, name, time_s, _posed(scene, name, time_s, given)) if given else scene

    return made


def keyframe_set(line: Mapping[str, Any]) -> Change:
    """A keyframe, where an object is at that time but for what is given."""
    name, time_s, given = (
        object_at(line, "time_s"),
        number(line.get("time_s"), "time_s"),
        _pose_given(line),
    )

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        room_for_keyframes(scene, 1)
        part = with_keyframe(scene.part(name), time_s, _posed(scene, name, time_s, given))
        return scene.with_part(name, part)

    return made


def keyframe_moved(line: Mapping[str, Any]) -> Change:
    """A keyframe at another time, in place of one that is there."""
    name = object_at(line, "time_s")
    time_s, to_s = number(line.get("time_s"), "time_s"), number(line.get("to_s"), "to_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        found, others = _keyframes(scene, name, time_s)
        kept = [one for one in others if abs(one.time_s - to_s) >= SAME_TIME_S]
        keys = sorted([*kept, replace(found, time_s=to_s)], key=lambda one: one.time_s)
        return scene.with_part(name, replace(scene.part(name), keyframes=tuple(keys)))

    return made


def keyframe_removed(line: Mapping[str, Any]) -> Change:
    """A keyframe taken away; after the last, the object stays where that was."""
    name, time_s = object_at(line, "time_s"), number(line.get("time_s"), "time_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        found, others = _keyframes(scene, name, time_s)
        left = scene.with_part(name, replace(scene.part(name), keyframes=tuple(others)))
        if others:
            return left
        return left.with_pose(name, pose_kind(scene).from_similarity(found.parent_T_object))

    return made


def object_at(line: Mapping[str, Any], key: str) -> str:
    """The object of a line that must say when."""
    if line.get(key) is None:
        raise ValueError(f"{key}: expected a number, got none")
    return object_name(line.get("object"), "object")


def _keyframes(scene: Scene, name: str, time_s: float) -> tuple[Any, list[Any]]:
    """The keyframe at a time, and the others."""
    keys = scene.part(name).keyframes
    found = [one for one in keys if abs(one.time_s - time_s) < SAME_TIME_S]
    if not found:
        raise ValueError(f"time_s: expected that of a keyframe of '{name}', got {time_s:g}")
    return found[0], [one for one in keys if one is not found[0]]


def _pose_given(line: Mapping[str, Any]) -> dict[str, Any]:
    """What a line says of a pose, checked as that of an object; null is what is left out."""
    given = {key: line[key] for key in POSE_KEYS if line.get(key) is not None}
    similarity_of(given, "pose")
    return given


def _posed(scene: Scene, name: str, time_s: float | None, given: Mapping[str, Any]) -> ObjectPose:
    """The pose of an object at a time, with some of it as given."""
    pose, kind = scene.pose_at(name, time_s), pose_kind(scene)
    if not given:
        return kind.from_similarity(pose)
    kept = pose_json(pose)
    if "euler_deg" in given:
        del kept["wxyz"]
    asked = {**kept, **given}
    made = kind.from_similarity(similarity_of(asked, "pose"))
    if isinstance(made, EulerObjectPose) and "euler_deg" in given:
        made = EulerObjectPose(np.radians(given["euler_deg"]), made.position_m, made.scale)
    return checked_pose(made)
