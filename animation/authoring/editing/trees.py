"""Edits of a scene's tree: objects that come, go, are copied, renamed or hung elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import count
from types import MappingProxyType
from typing import Any

import numpy as np

from motorcade.animation.authoring.editing.drags import checked_pose, room_for_keyframes
from motorcade.animation.authoring.fields import listed, number, object_name
from motorcade.animation.authoring.parts import SceneKeyframe, ScenePart
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose, VersorObjectPose
from motorcade.animation.authoring.scene import Scene
from motorcade.animation.authoring.scene_file import MOST_OBJECTS, anchor_of, object_of
from motorcade.ga import Motor, Similarity

NOWHERE: Mapping[str, Similarity] = MappingProxyType({})
Change = Callable[[Scene, Mapping[str, Similarity]], Scene]
# How far out of a plane, as a share of its size, a walk may be led that is hung elsewhere.
_FLAT = 1e-6


def added(line: Mapping[str, Any]) -> Change:
    """A new object at the end."""
    entry = object_of(line.get("object"), "object")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        _check_new(scene, entry.name)
        _check_parent(scene, entry.parent)
        room_for_keyframes(scene, entry.part.keyframe_count)
        pose = pose_kind(scene).from_similarity(entry.pose.as_similarity())
        return _with(scene, [(entry.name, entry.parent, pose, entry.part)])

    return made


def removed(line: Mapping[str, Any]) -> Change:
    """An object with all that hang on it taken away."""
    name = _name(line, "object")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        return _without(scene, scene.branch(name))

    return made


def copied(line: Mapping[str, Any]) -> Change:
    """An object again, with all that hang on it."""
    name, new = _name(line, "object"), _name(line, "name")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
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

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
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

    def made(scene: Scene, world_T_anchor: Mapping[str, Similarity]) -> Scene:
        _check_new(scene, new)
        for name in names:
            for below in scene.branch(name)[1:]:
                if below in names:
                    raise ValueError(f"objects: expected none that hang on others, got '{below}'")
        parent = scene.parents[names[0]]
        frame = pose_kind(scene).from_similarity(Similarity.identity())
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

    def made(scene: Scene, world_T_anchor: Mapping[str, Similarity]) -> Scene:
        if scene.part(name).kind != "group":
            raise ValueError(f"object: expected a group, got '{name}'")
        for child, above in scene.parents.items():
            if above == name:
                scene = hung(scene, child, scene.parents[name], time_s, world_T_anchor)
        return _without(scene, [name])

    return made


def reparented(line: Mapping[str, Any]) -> Change:
    """An object hung on another parent; it stays where it is in the world."""
    name, time_s = _name(line, "object"), _time(line)
    if "parent" not in line:
        raise ValueError("parent: expected a name, or null for the world")
    parent = None if line["parent"] is None else object_name(line["parent"], "parent")

    def made(scene: Scene, world_T_anchor: Mapping[str, Similarity]) -> Scene:
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

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
        if name in scene.parents:
            raise ValueError(f"name: expected one that nothing else has, got '{name}'")
        return replace(scene, anchors={**scene.anchors, name: anchor})

    return made


def anchor_removed(line: Mapping[str, Any]) -> Change:
    """An anchor taken away."""
    name = _name(line, "name")

    def made(scene: Scene, _: Mapping[str, Similarity]) -> Scene:
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
    world_T_anchor: Mapping[str, Similarity],
) -> Scene:
    """The scene with an object on another parent, where it is in the world at that time.

    Keyframes and walks go along; where parents move, it is elsewhere at other times.
    """
    from_world = scene.world_T_parent(name, time_s, world_T_anchor)
    parents = _in_order({**scene.parents, name: parent}, scene.anchors)
    rehung = Scene(parents, {one: scene.poses[one] for one in parents}, scene.parts, scene.anchors)
    new_T_old = rehung.world_T_parent(name, time_s, world_T_anchor).inverse() @ from_world
    kind, part = pose_kind(scene), scene.part(name)

    def there(pose: Similarity) -> ObjectPose:
        still = Similarity.identity()
        return checked_pose(kind.from_similarity(pose).moved(new_T_old, "parent", still))

    if part.walk is not None:
        flat = np.column_stack([part.walk.path_m, np.zeros(len(part.walk.path_m))])
        path = new_T_old.apply(flat)
        if np.ptp(path[:, 2]) > _FLAT * np.abs(path).max() or _tilted(new_T_old):
            raise ValueError(f"parent: expected a plane like that in which '{name}' walks")
        part = replace(part, walk=replace(part.walk, path_m=path[:, :2]))
    keys = tuple(
        SceneKeyframe(keyframe.time_s, there(keyframe.parent_T_object).as_similarity())
        for keyframe in part.keyframes
    )
    rehung = rehung.with_pose(name, there(scene.poses[name].as_similarity()))
    return rehung.with_part(name, replace(part, keyframes=keys)) if name in scene.parts else rehung


def _tilted(motion: Similarity) -> bool:
    return float(motion.rotor.apply([0.0, 0.0, 1.0])[2]) < 1.0 - _FLAT


def pose_kind(scene: Scene) -> type[ObjectPose]:
    """What the scene holds poses as."""
    first = next(iter(scene.poses.values()), None)
    return EulerObjectPose if isinstance(first, EulerObjectPose) else VersorObjectPose


def _in_order(parents: Mapping[str, str | None], anchors: Mapping[str, Any]) -> dict[str, Any]:
    """The same, each parent before its children, else in their order."""
    ordered: dict[str, str | None] = {}
    waiting: dict[str, list[str]] = {}
    for name, parent in parents.items():
        if parent is not None and parent not in ordered and parent not in anchors:
            waiting.setdefault(parent, []).append(name)
            continue
        ready = [name]
        while ready:
            next_name = ready.pop()
            ordered[next_name] = parents[next_name]
            ready.extend(reversed(waiting.pop(next_name, [])))
    return ordered


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


def _without(scene: Scene, names: Iterable[str]) -> Scene:
    fields = {field: dict(getattr(scene, field)) for field in ("parents", "poses", "parts")}
    for name in names:
        for entries in fields.values():
            entries.pop(name, None)
    return scene.but(**fields)


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
