"""Edits: what is done to a scene besides drags, each as a line of JSON in a file of gestures.

==================  ============================================================================
``do``              and its keys; those in brackets may be left out
==================  ============================================================================
``add``             ``object``: an entry as in a scene file
``remove``          ``object``: with all that hang on it
``copy``            ``object``, ``name``: with all that hang on it, in the same place
``rename``          ``object``, ``name``
``group``           ``objects``, ``name``, (``time_s``): a new frame amid them, in the first one's
                    parent
``ungroup``         ``object``, (``time_s``): what hangs on a group goes to the group's parent
``reparent``        ``object``, ``parent`` or null, (``time_s``): it stays where it is in the world
``set``             ``object``, (``time_s``), and any of an object's keys in a scene file
``keyframe``        ``object``, ``time_s``, and any of ``position_m``, ``wxyz``, ``euler_deg``,
                    ``scale``; the others are what they are at that time
``move_keyframe``   ``object``, ``time_s``, ``to_s``
``remove_keyframe`` ``object``, ``time_s``; after the last one it stays where that was
``joints``          ``object``, ``time_s``, ``joints``: ``wxyz`` by name, null to let one go
``move_joints``     ``object``, ``time_s``, ``to_s``: a pose of joints, its end with it
``end_joints``      ``object``, ``time_s``, ``end_s``: until when a pose is held, null for ever
``remove_joints``   ``object``, ``time_s``
``layer``           ``object``, (``number``), ``layer``: one as in a scene file, null to take it
                    away; without a number a new one on top
``anchor``          ``name``, ``on``, (``marker``, ``floor_m``): a new one, or another than it was
``remove_anchor``   ``name``, on which nothing hangs
==================  ============================================================================

Here are those of an object's fields and keyframes, of a character's joints and of clips laid over
its own; those of the tree are in `trees`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from motorcade.animation.authoring.editing import trees
from motorcade.animation.authoring.editing.drags import (
    SAME_TIME_S,
    checked_pose,
    placed,
    room_for_keyframes,
    with_keyframe,
)
from motorcade.animation.authoring.editing.trees import Change, pose_kind
from motorcade.animation.authoring.fields import (
    number,
    object_name,
    parsed_json,
    pose_json,
    short,
    table,
)
from motorcade.animation.authoring.parts import JointKeyframe
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose
from motorcade.animation.authoring.scene import Scene
from motorcade.animation.authoring.scene_file import (
    MOST_IN_A_LIST,
    PART_KEYS,
    POSE_KEYS,
    layer_of,
    part_fields,
    rotor_of,
    similarity_of,
)
from motorcade.ga import Rotor, Similarity

FIELDS = (*POSE_KEYS, *PART_KEYS)


def fields_set(line: Mapping[str, Any]) -> Change:
    """Some of an object's keys as given; null is what they are when left out."""
    name = object_name(line.get("object"), "object")
    time_s = None if line.get("time_s") is None else number(line["time_s"], "time_s")
    said = part_fields(line, "set")
    pose_fields = _pose_given(line)

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        if said:
            part = replace(scene.part(name), **said)
            room_for_keyframes(scene, part.keyframe_count - scene.part(name).keyframe_count)
            scene = scene.with_part(name, part)
        return (
            placed(scene, name, time_s, _posed(scene, name, time_s, pose_fields))
            if pose_fields
            else scene
        )

    return made


def keyframe_set(line: Mapping[str, Any]) -> Change:
    """A keyframe, where an object is at that time but for what is given."""
    name, time_s, pose_fields = (
        object_at(line, "time_s"),
        number(line.get("time_s"), "time_s"),
        _pose_given(line),
    )

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        room_for_keyframes(scene, 1)
        part = with_keyframe(scene.part(name), time_s, _posed(scene, name, time_s, pose_fields))
        return scene.with_part(name, part)

    return made


def keyframe_moved(line: Mapping[str, Any]) -> Change:
    """A keyframe at another time, in place of one that is there."""
    name = object_at(line, "time_s")
    time_s, to_s = number(line.get("time_s"), "time_s"), number(line.get("to_s"), "to_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        keyframe, others = _keyframes(scene, name, time_s)
        kept = [one for one in others if abs(one.time_s - to_s) >= SAME_TIME_S]
        keys = sorted([*kept, replace(keyframe, time_s=to_s)], key=lambda key: key.time_s)
        return scene.with_part(name, replace(scene.part(name), keyframes=tuple(keys)))

    return made


def keyframe_removed(line: Mapping[str, Any]) -> Change:
    """A keyframe taken away; after the last, the object stays where that was."""
    name, time_s = object_at(line, "time_s"), number(line.get("time_s"), "time_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        keyframe, others = _keyframes(scene, name, time_s)
        left = scene.with_part(name, replace(scene.part(name), keyframes=tuple(others)))
        if others:
            return left
        return left.with_pose(name, pose_kind(scene).from_similarity(keyframe.parent_T_object))

    return made


def object_at(line: Mapping[str, Any], key: str) -> str:
    """The object of a line that must say when."""
    if line.get(key) is None:
        raise ValueError(f"{key}: expected a number, got none")
    return object_name(line.get("object"), "object")


def _keyframes(scene: Scene, name: str, time_s: float) -> tuple[Any, list[Any]]:
    """The keyframe at a time, and the others."""
    keys = scene.part(name).keyframes
    near = [one for one in keys if abs(one.time_s - time_s) < SAME_TIME_S]
    if not near:
        raise ValueError(f"time_s: expected that of a keyframe of '{name}', got {time_s:g}")
    return near[0], [one for one in keys if one is not near[0]]


def _pose_given(line: Mapping[str, Any]) -> dict[str, Any]:
    """What a line says of a pose, checked as that of an object; null is what is left out."""
    pose = {key: line[key] for key in POSE_KEYS if line.get(key) is not None}
    similarity_of(pose, "pose")
    return pose


def _posed(scene: Scene, name: str, time_s: float | None, fields: Mapping[str, Any]) -> ObjectPose:
    """The pose of an object at a time, with some of it as given."""
    pose, kind = scene.pose_at(name, time_s), pose_kind(scene)
    if not fields:
        return kind.from_similarity(pose)
    kept = pose_json(pose)
    if "euler_deg" in fields:
        del kept["wxyz"]
    asked = {**kept, **fields}
    posed = kind.from_similarity(similarity_of(asked, "pose"))
    if isinstance(posed, EulerObjectPose) and "euler_deg" in fields:
        posed = EulerObjectPose(np.radians(fields["euler_deg"]), posed.position_m, posed.scale)
    return checked_pose(posed)


_MOST_JOINTS = 1000


def joints_set(line: Mapping[str, Any]) -> Change:
    """Turns of joints at a time, beside those that are there."""
    name, time_s = object_at(line, "time_s"), number(line.get("time_s"), "time_s")
    joint_values = line.get("joints")
    if not isinstance(joint_values, dict) or not 1 <= len(joint_values) <= _MOST_JOINTS:
        raise ValueError(f"joints: expected 1 to {_MOST_JOINTS} turns by joint")
    turns: dict[str, Rotor | None] = {
        object_name(joint, "joints"): None if wxyz is None else rotor_of(wxyz, f"joints['{joint}']")
        for joint, wxyz in joint_values.items()
    }

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        part = scene.part(name)
        near = [one for one in part.joint_keyframes if abs(one.time_s - time_s) < SAME_TIME_S]
        if not near:
            room_for_keyframes(scene, 1)
        there: Mapping[str, Rotor] = near[0].rotors if near else {}
        rotors = {joint: one for joint, one in {**there, **turns}.items() if one is not None}
        kept = [one for one in part.joint_keyframes if one not in near]
        if rotors and near:
            kept.append(replace(near[0], rotors=rotors))
        elif rotors:
            kept.append(JointKeyframe(time_s, rotors))
        return _with_poses(scene, name, kept)

    return made


def joints_moved(line: Mapping[str, Any]) -> Change:
    """A pose at another time, its end as long after it, in place of one that is there."""
    name = object_at(line, "time_s")
    time_s, to_s = number(line.get("time_s"), "time_s"), number(line.get("to_s"), "to_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        keyframe, others = _poses(scene, name, time_s)
        kept = [one for one in others if abs(one.time_s - to_s) >= SAME_TIME_S]
        end_s = None if keyframe.end_s is None else keyframe.end_s + to_s - keyframe.time_s
        return _with_poses(scene, name, [*kept, replace(keyframe, time_s=to_s, end_s=end_s)])

    return made


def joints_ended(line: Mapping[str, Any]) -> Change:
    """A pose held until a time, or for ever."""
    name, time_s = object_at(line, "time_s"), number(line.get("time_s"), "time_s")
    if "end_s" not in line:
        raise ValueError("end_s: expected a number, or null for ever")
    end_s = None if line["end_s"] is None else number(line["end_s"], "end_s")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        keyframe, others = _poses(scene, name, time_s)
        return _with_poses(scene, name, [*others, replace(keyframe, end_s=end_s)])

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
    near = [one for one in keys if abs(one.time_s - time_s) < SAME_TIME_S]
    if not near:
        raise ValueError(f"time_s: expected that of a pose of '{name}', got {time_s:g}")
    return near[0], [one for one in keys if one is not near[0]]


def _with_poses(scene: Scene, name: str, poses: list[JointKeyframe]) -> Scene:
    keys = tuple(sorted(poses, key=lambda key: key.time_s))
    return scene.with_part(name, replace(scene.part(name), joint_keyframes=keys))


Anchors = Mapping[str, Similarity]
_KINDS: dict[str, tuple[tuple[str, ...], Callable[[Mapping[str, Any]], Change]]] = {
    "add": (("object",), trees.added),
    "remove": (("object",), trees.removed),
    "copy": (("object", "name"), trees.copied),
    "rename": (("object", "name"), trees.renamed),
    "group": (("objects", "name", "time_s"), trees.grouped),
    "ungroup": (("object", "time_s"), trees.ungrouped),
    "reparent": (("object", "parent", "time_s"), trees.reparented),
    "set": (("object", "time_s", *FIELDS), fields_set),
    "keyframe": (("object", "time_s", *POSE_KEYS), keyframe_set),
    "move_keyframe": (("object", "time_s", "to_s"), keyframe_moved),
    "remove_keyframe": (("object", "time_s"), keyframe_removed),
    "joints": (("object", "time_s", "joints"), joints_set),
    "move_joints": (("object", "time_s", "to_s"), joints_moved),
    "end_joints": (("object", "time_s", "end_s"), joints_ended),
    "remove_joints": (("object", "time_s"), joints_removed),
    "layer": (("object", "number", "layer"), layer_set),
    "anchor": (("name", "on", "marker", "floor_m"), trees.anchor_set),
    "remove_anchor": (("name",), trees.anchor_removed),
}
EDITS = tuple(_KINDS)
_OF_THE_TREE = ("remove", "copy", "rename", "group", "ungroup", "reparent", "remove_anchor")


@dataclass(frozen=True, eq=False)
class Edit:
    """A change of a scene that is no drag.

    Args:
        line: as the module lists them.

    Raises:
        ValueError: a line that is no edit; the message names the key.

    >>> from motorcade.animation.authoring import Edit, Scene, VersorObjectPose
    >>> from motorcade.ga import Similarity
    >>> scene = Scene({"cup": None}, {"cup": VersorObjectPose(Similarity.identity())})
    >>> two = Edit({"do": "copy", "object": "cup", "name": "mug"}).applied(scene)
    >>> list(two.parents)
    ['cup', 'mug']
    >>> Edit({"do": "rename", "object": "cup", "name": "mug"}).applied(two)
    Traceback (most recent call last):
    ValueError: name: expected one that nothing else has, got 'mug'
    """

    line: Mapping[str, Any]
    _change: Change = field(init=False, repr=False)

    def __post_init__(self) -> None:
        own = self.line
        kind = own.get("do") if isinstance(own, Mapping) else None
        if not isinstance(kind, str) or kind not in _KINDS:
            raise ValueError(f"do: expected one of {', '.join(_KINDS)}, got {short(kind)}")
        keys, make_change = _KINDS[kind]
        try:
            own = parsed_json(json.dumps(dict(own)), kind)
        except (TypeError, RecursionError) as fault:
            raise ValueError(f"{kind}: expected what JSON holds, got {short(fault)}") from fault
        table(own, kind, ("do", *keys))
        object.__setattr__(self, "line", own)
        object.__setattr__(self, "_change", make_change(own))

    @property
    def touched(self) -> set[str] | None:
        """Names of all that it can change; None where the scene decides that."""
        kind = self.line["do"]
        if kind == "add":
            return {self.line["object"]["name"]}
        if kind == "anchor":
            return {self.line["name"]}
        return None if kind in _OF_THE_TREE else {self.line["object"]}

    def applied(self, scene: Scene, world_T_anchor: Anchors = trees.NOWHERE) -> Scene:
        """The scene after it.

        Args:
            scene: which is changed.
            world_T_anchor: where anchors stand now; see `Scene.world_T_parent`.

        Raises:
            ValueError: what the scene does not have, or may not have.
        """
        return self._change(scene, world_T_anchor)

    def as_json(self) -> dict[str, Any]:
        """Its line."""
        return dict(self.line)
