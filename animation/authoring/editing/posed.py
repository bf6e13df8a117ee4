"""Edits of what a character's joints do: poses that were dragged, and clips laid over its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from motorcade.animation.authoring.editing.drags import SAME_TIME_S, room_for_keyframes
from motorcade.animation.authoring.editing.keyed import object_at
from motorcade.animation.authoring.editing.trees import Change
from motorcade.animation.authoring.fields import number, object_name, short
from motorcade.animation.authoring.parts import JointKeyframe
from motorcade.animation.authoring.scene import Scene
from motorcade.animation.authoring.scene_file import MOST_IN_A_LIST, layer_of, rotor_of
from motorcade.ga import Rotor, Similarity

_MOST_JOINTS = 1000


def joints_set(line: Mapping[str, Any]) -> Change:
    """Turns of joints at a time, beside those that are there."""
    name, time_s = object_at(line, "time_s"), number(line.get("time_s"), "time_s")
    given = line.get("joints")
    if not isinstance(given, dict) or not 1 <= len(given) <= _MOST_JOINTS:
        raise ValueError(f"joints: expected 1 to {_MOST_JOINTS} turns by joint")
    turns: dict[str, Rotor | None] = {
        object_name(joint, "joints"): None if wxyz is None else rotor_of(wxyz, f"joints['{joint}']")
        for joint, wxyz in given.items()
    }

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        part = scene.part(name)
        found = [one for one in part.joint_keyframes if abs(one.time_s - time_s) < SAME_TIME_S]
        if not found:
            room_for_keyframes(scene, 1)
        there: Mapping[str, Rotor] = found[0].rotors if found else {}
        rotors = {joint: one for joint, one in {**there, **turns}.items() if one is not None}
        kept = [one for one in part.joint_keyframes if one not in found]
        if rotors and found:
            kept.append(replace(found[0], rotors=rotors))
        elif rotors:
            kept.append(JointKeyframe(time_s, rotors))
        return _with_poses(scene, name, kept)

    return made


def joints_moved(line: Mapping[str, Any]) -> Change:
    """A pose at another time, its end as long after it, in place of one that is there."""
    name = object_at(line, "time_s")
    time_s, to_s = number(line.get("time_s"), "time_s"), number(line.get("to_s"), "to_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        found, others = _poses(scene, name, time_s)
        kept = [one for one in others if abs(one.time_s - to_s) >= SAME_TIME_S]
        end_s = None if found.end_s is None else found.end_s + to_s - found.time_s
        return _with_poses(scene, name, [*kept, replace(found, time_s=to_s, end_s=end_s)])

    return made


def joints_ended(line: Mapping[str, Any]) -> Change:
    """A pose held until a time, or for ever."""
    name, time_s = object_at(line, "time_s"), number(line.get("time_s"), "time_s")
    if "end_s" not in line:
        raise ValueError("end_s: expected a number, or null for ever")
    end_s = None if line["end_s"] is None else number(line["end_s"], "end_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        found, others = _poses(scene, name, time_s)
        return _with_poses(scene, name, [*others, replace(found, end_s=end_s)])

    return made


def joints_removed(line: Mapping[str, Any]) -> Change:
    """A pose taken away."""
    name, time_s = object_at(line, "time_s"), number(line.get("time_s"), "time_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        return _with_poses(scene, name, _poses(scene, name, time_s)[1])

    return made


def layer_set(line: Mapping[str, Any]) -> Change:
    """A clip over the others: new, other than it was, or taken away."""
    name, at = object_name(line.get("object"), "object"), line.get("number")
    if "layer" not in line:
        raise ValueError("layer: expected one as in a scene file, or null to take it away")
    if at is None and line["layer"] is None:
        raise ValueError("number: expected that of the layer to take away, got none")
    if at is not None and (type(at) is not int or at < 0):
        raise ValueError(f"number: expected 0 or more, got {short(at)}")
    layer = None if line["layer"] is None else layer_of(line["layer"], "layer")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        part = scene.part(name)
        layers = list(part.layers)
        if at is not None and at >= len(layers):
            raise ValueError(f"number: expected one of {len(layers)} layers, got {at}")
        where = len(layers) if at is None else at
        layers[where : where + 1] = [] if layer is None else [layer]
        if len(layers) > MOST_IN_A_LIST:
            raise ValueError(f"layer: expected at most {MOST_IN_A_LIST} of '{name}'")
        return scene.with_part(name, replace(part, layers=tuple(layers)))

    return made


def _poses(scene: Scene, name: str, time_s: float) -> tuple[JointKeyframe, list[JointKeyframe]]:
    """The pose at a time, and the others."""
    keys = scene.part(name).joint_keyframes
    found = [one for one in keys if abs(one.time_s - time_s) < SAME_TIME_S]
    if not found:
        raise ValueError(f"time_s: expected that of a pose of '{name}', got {time_s:g}")
    return found[0], [one for one in keys if one is not found[0]]


def _with_poses(scene: Scene, name: str, poses: list[JointKeyframe]) -> Scene:
    keys = tuple(sorted(poses, key=lambda one: one.time_s))
    return scene.with_part(name, replace(scene.part(name), joint_keyframes=keys))
