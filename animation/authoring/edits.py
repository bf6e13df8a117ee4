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
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import count
from typing import Any

import numpy as np

from motorcade.animation.authoring.drags import (
    SAME_TIME_S,
    checked_pose,
    placed,
    room_for_keyframes,
    with_keyframe,
)
from motorcade.animation.authoring.fields import (
    listed,
    number,
    object_name,
    parsed_json,
    pose_json,
    short,
    table,
)
from motorcade.animation.authoring.parts import JointKeyframe, SceneKeyframe, ScenePart
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose
from motorcade.animation.authoring.scene import NOWHERE, Scene, in_order
from motorcade.animation.authoring.scene_file import (
    MOST_IN_A_LIST,
    MOST_OBJECTS,
    PART_KEYS,
    POSE_KEYS,
    anchor_of,
    layer_of,
    object_of,
    part_fields,
    rotor_of,
    similarity_of,
)
from motorcade.ga import Motor, Rotor, Similarity

Anchors = Mapping[str, Similarity]
Change = Callable[[Scene, Anchors], Scene]
# How far out of a plane, as a share of its size, a walk may be led that is hung elsewhere.
_FLAT = 1e-6


def added(line: Mapping[str, Any]) -> Change:
    """A new object at the end."""
    entry = object_of(line.get("object"), "object")

    def made(scene: Scene, _: Anchors) -> Scene:
        _check_new(scene, entry.name)
        _check_parent(scene, entry.parent)
        room_for_keyframes(scene, entry.part.keyframe_count)
        pose = scene.pose_kind.from_similarity(entry.pose.as_similarity())
        return _with(scene, [(entry.name, entry.parent, pose, entry.part)])

    return made


def removed(line: Mapping[str, Any]) -> Change:
    """An object with all that hang on it taken away."""
    name = _name(line, "object")

    def made(scene: Scene, _: Anchors) -> Scene:
        return scene.without(scene.branch(name))

    return made


def copied(line: Mapping[str, Any]) -> Change:
    """An object again, with all that hang on it."""
    name, new = _name(line, "object"), _name(line, "name")

    def made(scene: Scene, _: Anchors) -> Scene:
        _check_new(scene, new)
        names = scene.branch(name)
        taken = {*scene.parents, *scene.anchors, new}
        called = {name: new}
        for old in names[1:]:
            free = (f"{old[:90]} {k}" for k in count(2))
            called[old] = next(each for each in free if each not in taken)
            taken.add(called[old])
        room_for_keyframes(scene, sum(scene.part(one).keyframe_count for one in names))
        rows = []
        for old in names:
            above = scene.parents[old]
            parent = called.get(above, above) if above is not None else None
            rows.append((called[old], parent, scene.poses[old], scene.part(old)))
        return _with(scene, rows)

    return made


def renamed(line: Mapping[str, Any]) -> Change:
    """An object by another name."""
    name, new = _name(line, "object"), _name(line, "name")

    def made(scene: Scene, _: Anchors) -> Scene:
        scene.pose(name)
        if new == name:
            return scene
        _check_new(scene, new)

        def called(value: str) -> str:
            return new if value == name else value

        parents = {
            called(old): None if above is None else called(above)
            for old, above in scene.parents.items()
        }
        poses = {called(one): pose for one, pose in scene.poses.items()}
        parts = {called(one): part for one, part in scene.parts.items()}
        return Scene(parents, poses, parts, scene.anchors)

    return made


def grouped(line: Mapping[str, Any]) -> Change:
    """Objects hung on a new frame amid them; each stays where it is."""
    new, time_s = _name(line, "name"), _time(line)
    names = [object_name(one, "objects") for one in listed(line.get("objects"), "objects", 10_000)]
    if not names or len(set(names)) < len(names):
        raise ValueError("objects: expected one or more different names")

    def made(scene: Scene, world_T_anchor: Anchors) -> Scene:
        _check_new(scene, new)
        for name in names:
            for below in scene.branch(name)[1:]:
                if below in names:
                    raise ValueError(f"objects: expected none that hang on others, got '{below}'")
        parent = scene.parents[names[0]]
        frame = scene.pose_kind.from_similarity(Similarity.identity())
        grown = _with(scene, [(new, parent, frame, ScenePart())])
        world = grown.world_T_parent(new, time_s, world_T_anchor)
        at = [scene.world_T_object(one, time_s, world_T_anchor).translation_m for one in names]
        middle = world.inverse().apply(np.mean(at, axis=0))
        amid = Similarity.from_motor_scale(Motor.from_translation(middle))
        grown = grown.with_pose(new, checked_pose(type(frame).from_similarity(amid)))
        for name in names:
            grown = hung(grown, name, new, time_s, world_T_anchor)
        return grown

    return made


def ungrouped(line: Mapping[str, Any]) -> Change:
    """A group taken away; what hangs on it stays where it is."""
    name, time_s = _name(line, "object"), _time(line)

    def made(scene: Scene, world_T_anchor: Anchors) -> Scene:
        if scene.part(name).kind != "group":
            raise ValueError(f"object: expected a group, got '{name}'")
        for child, above in scene.parents.items():
            if above == name:
                scene = hung(scene, child, scene.parents[name], time_s, world_T_anchor)
        return scene.without([name])

    return made


def reparented(line: Mapping[str, Any]) -> Change:
    """An object hung on another parent; it stays where it is in the world."""
    name, time_s = _name(line, "object"), _time(line)
    if "parent" not in line:
        raise ValueError("parent: expected a name, or null for the world")
    parent = None if line["parent"] is None else object_name(line["parent"], "parent")

    def made(scene: Scene, world_T_anchor: Anchors) -> Scene:
        _check_parent(scene, parent)
        if parent in scene.branch(name):
            raise ValueError(f"parent: expected none that hangs on '{name}', got '{parent}'")
        if scene.parents[name] == parent:
            return scene
        return hung(scene, name, parent, time_s, world_T_anchor)

    return made


def anchor_set(line: Mapping[str, Any]) -> Change:
    """An anchor, new or other than it was."""
    name = _name(line, "name")
    anchor = anchor_of(
        {key: one for key, one in line.items() if key not in ("do", "name")}, "anchor"
    )

    def made(scene: Scene, _: Anchors) -> Scene:
        if name in scene.parents:
            raise ValueError(f"name: expected one that nothing else has, got '{name}'")
        return replace(scene, anchors={**scene.anchors, name: anchor})

    return made


def anchor_removed(line: Mapping[str, Any]) -> Change:
    """An anchor taken away."""
    name = _name(line, "name")

    def made(scene: Scene, _: Anchors) -> Scene:
        if name not in scene.anchors:
            raise ValueError(f"name: expected an anchor, got '{name}'")
        kept = {one: anchor for one, anchor in scene.anchors.items() if one != name}
        for child, above in scene.parents.items():
            if above == name:
                raise ValueError(f"name: expected an anchor on which nothing hangs, '{child}' does")
        return replace(scene, anchors=kept)

    return made


def hung(
    scene: Scene,
    name: str,
    parent: str | None,
    time_s: float | None,
    world_T_anchor: Anchors,
) -> Scene:
    """The scene with an object on another parent, where it is in the world at that time.

    Keyframes and walks go along; where parents move, it is elsewhere at other times.
    """
    from_world = scene.world_T_parent(name, time_s, world_T_anchor)
    parents = in_order({**scene.parents, name: parent}, scene.anchors)
    rehung = Scene(parents, {one: scene.poses[one] for one in parents}, scene.parts, scene.anchors)
    new_T_old = rehung.world_T_parent(name, time_s, world_T_anchor).inverse() @ from_world
    kind, part = scene.pose_kind, scene.part(name)

    def there(pose: Similarity) -> ObjectPose:
        still = Similarity.identity()
        return checked_pose(kind.from_similarity(pose).moved(new_T_old, "parent", still))

    if part.walk is not None:
        flat = np.column_stack([part.walk.path_m, np.zeros(len(part.walk.path_m))])
        path = new_T_old.apply(flat)
        tilted = new_T_old.rotor.apply([0.0, 0.0, 1.0])[2] < 1.0 - _FLAT
        if tilted or np.ptp(path[:, 2]) > _FLAT * np.abs(path).max():
            raise ValueError(f"parent: expected a plane like that in which '{name}' walks")
        part = replace(part, walk=replace(part.walk, path_m=path[:, :2]))
    keys = tuple(
        SceneKeyframe(keyframe.time_s, there(keyframe.parent_T_object).as_similarity())
        for keyframe in part.keyframes
    )
    rehung = rehung.with_pose(name, there(scene.poses[name].as_similarity()))
    return rehung.with_part(name, replace(part, keyframes=keys)) if name in scene.parts else rehung


def _with(scene: Scene, rows: Sequence[tuple[str, str | None, ObjectPose, ScenePart]]) -> Scene:
    if len(scene.parents) + len(rows) > MOST_OBJECTS:
        raise ValueError(f"object: expected at most {MOST_OBJECTS} in a scene, got more")
    parents = {**scene.parents, **{name: parent for name, parent, _, _ in rows}}
    poses = {**scene.poses, **{name: pose for name, _, pose, _ in rows}}
    parts = {**scene.parts, **{name: part for name, _, _, part in rows}}
    grown = scene.but(parents=parents, poses=poses, parts=parts)
    for name, *_ in rows:  # all else of a scene was checked when it was made
        grown.check_depth(name)
    return grown


def _check_new(scene: Scene, name: str) -> None:
    if name in scene.parents or name in scene.anchors:
        raise ValueError(f"name: expected one that nothing else has, got '{name}'")


def _check_parent(scene: Scene, parent: str | None) -> None:
    if parent is not None and parent not in scene.parents and parent not in scene.anchors:
        known = ", ".join([*scene.anchors, *scene.parents][:20]) or "none"
        raise ValueError(f"parent: expected an object or an anchor ({known}), got '{parent}'")


def _name(line: Mapping[str, Any], key: str) -> str:
    return object_name(line.get(key), key)


def _time(line: Mapping[str, Any]) -> float | None:
    value = line.get("time_s")
    return None if value is None else number(value, "time_s")


FIELDS = (*POSE_KEYS, *PART_KEYS)


def fields_set(line: Mapping[str, Any]) -> Change:
    """Some of an object's keys as given; null is what they are when left out."""
    name, time_s = _name(line, "object"), _time(line)
    said = part_fields(line, "set")
    pose_fields = _pose_given(line)

    def made(scene: Scene, _: Anchors) -> Scene:
        if said:
            part = replace(scene.part(name), **said)
            room_for_keyframes(scene, part.keyframe_count - scene.part(name).keyframe_count)
            scene = scene.with_part(name, part)
        if not pose_fields:
            return scene
        return placed(scene, name, time_s, _posed(scene, name, time_s, pose_fields))

    return made


def keyframe_set(line: Mapping[str, Any]) -> Change:
    """A keyframe, where an object is at that time but for what is given."""
    (name, time_s), pose_fields = _object_at(line), _pose_given(line)

    def made(scene: Scene, _: Anchors) -> Scene:
        room_for_keyframes(scene, 1)
        part = with_keyframe(scene.part(name), time_s, _posed(scene, name, time_s, pose_fields))
        return scene.with_part(name, part)

    return made


def key_moved(line: Mapping[str, Any], field: str) -> Change:
    """A keyframe of a field at another time, its end as long after it, in place of one there."""
    (name, time_s), to_s = _object_at(line), number(line.get("to_s"), "to_s")

    def made(scene: Scene, _: Anchors) -> Scene:
        key, others = _keys(scene, name, time_s, field)
        kept = [one for one in others if abs(one.time_s - to_s) >= SAME_TIME_S]
        times = {"time_s": to_s}
        if field == "joint_keyframes" and key.end_s is not None:
            times["end_s"] = key.end_s + to_s - key.time_s
        return _with_keys(scene, name, field, [*kept, replace(key, **times)])

    return made


def key_removed(line: Mapping[str, Any], field: str) -> Change:
    """A keyframe taken away; after the last of an object's own, it stays where that was."""
    name, time_s = _object_at(line)

    def made(scene: Scene, _: Anchors) -> Scene:
        key, others = _keys(scene, name, time_s, field)
        left = _with_keys(scene, name, field, others)
        if others or field != "keyframes":
            return left
        return left.with_pose(name, scene.pose_kind.from_similarity(key.parent_T_object))

    return made


def _object_at(line: Mapping[str, Any]) -> tuple[str, float]:
    """The object of a line that must say when, and when."""
    if line.get("time_s") is None:
        raise ValueError("time_s: expected a number, got none")
    return _name(line, "object"), number(line["time_s"], "time_s")


def _keys(scene: Scene, name: str, time_s: float, field: str) -> tuple[Any, list[Any]]:
    """The keyframe of a field at a time, and the others."""
    keys = getattr(scene.part(name), field)
    near = [one for one in keys if abs(one.time_s - time_s) < SAME_TIME_S]
    if not near:
        kind = "keyframe" if field == "keyframes" else "pose"
        raise ValueError(f"time_s: expected that of a {kind} of '{name}', got {time_s:g}")
    return near[0], [one for one in keys if one is not near[0]]


def _with_keys(scene: Scene, name: str, field: str, keys: list[Any]) -> Scene:
    changed: dict[str, Any] = {field: tuple(sorted(keys, key=lambda key: key.time_s))}
    return scene.with_part(name, replace(scene.part(name), **changed))


def _pose_given(line: Mapping[str, Any]) -> dict[str, Any]:
    """What a line says of a pose, checked as that of an object; null is what is left out."""
    pose = {key: line[key] for key in POSE_KEYS if line.get(key) is not None}
    similarity_of(pose, "pose")
    return pose


def _posed(scene: Scene, name: str, time_s: float | None, fields: Mapping[str, Any]) -> ObjectPose:
    """The pose of an object at a time, with some of it as given."""
    pose, kind = scene.pose_at(name, time_s), scene.pose_kind
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
    name, time_s = _object_at(line)
    joint_values = line.get("joints")
    if not isinstance(joint_values, dict) or not 1 <= len(joint_values) <= _MOST_JOINTS:
        raise ValueError(f"joints: expected 1 to {_MOST_JOINTS} turns by joint")
    turns: dict[str, Rotor | None] = {
        object_name(joint, "joints"): None if wxyz is None else rotor_of(wxyz, f"joints['{joint}']")
        for joint, wxyz in joint_values.items()
    }

    def made(scene: Scene, _: Anchors) -> Scene:
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
        return _with_keys(scene, name, "joint_keyframes", kept)

    return made


def joints_ended(line: Mapping[str, Any]) -> Change:
    """A pose held until a time, or for ever."""
    name, time_s = _object_at(line)
    if "end_s" not in line:
        raise ValueError("end_s: expected a number, or null for ever")
    end_s = None if line["end_s"] is None else number(line["end_s"], "end_s")

    def made(scene: Scene, _: Anchors) -> Scene:
        keyframe, others = _keys(scene, name, time_s, "joint_keyframes")
        ended = [*others, replace(keyframe, end_s=end_s)]
        return _with_keys(scene, name, "joint_keyframes", ended)

    return made


def layer_set(line: Mapping[str, Any]) -> Change:
    """A clip over the others: new, other than it was, or taken away."""
    name, at = _name(line, "object"), line.get("number")
    if "layer" not in line:
        raise ValueError("layer: expected one as in a scene file, or null to take it away")
    if at is None and line["layer"] is None:
        raise ValueError("number: expected that of the layer to take away, got none")
    if at is not None and (type(at) is not int or at < 0):
        raise ValueError(f"number: expected 0 or more, got {short(at)}")
    layer = None if line["layer"] is None else layer_of(line["layer"], "layer")

    def made(scene: Scene, _: Anchors) -> Scene:
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


_KINDS: dict[str, tuple[tuple[str, ...], Callable[[Mapping[str, Any]], Change]]] = {
    "add": (("object",), added),
    "remove": (("object",), removed),
    "copy": (("object", "name"), copied),
    "rename": (("object", "name"), renamed),
    "group": (("objects", "name", "time_s"), grouped),
    "ungroup": (("object", "time_s"), ungrouped),
    "reparent": (("object", "parent", "time_s"), reparented),
    "set": (("object", "time_s", *FIELDS), fields_set),
    "keyframe": (("object", "time_s", *POSE_KEYS), keyframe_set),
    "move_keyframe": (("object", "time_s", "to_s"), partial(key_moved, field="keyframes")),
    "remove_keyframe": (("object", "time_s"), partial(key_removed, field="keyframes")),
    "joints": (("object", "time_s", "joints"), joints_set),
    "move_joints": (("object", "time_s", "to_s"), partial(key_moved, field="joint_keyframes")),
    "end_joints": (("object", "time_s", "end_s"), joints_ended),
    "remove_joints": (("object", "time_s"), partial(key_removed, field="joint_keyframes")),
    "layer": (("object", "number", "layer"), layer_set),
    "anchor": (("name", "on", "marker", "floor_m"), anchor_set),
    "remove_anchor": (("name",), anchor_removed),
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

    def applied(self, scene: Scene, world_T_anchor: Anchors = NOWHERE) -> Scene:
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
