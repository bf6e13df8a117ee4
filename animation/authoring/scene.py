"""A scene to be edited and played: named objects in a tree, each with its pose in its parent."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from motorcade.animation.authoring.fields import anchor_json, part_json, pose_json
from motorcade.animation.authoring.parts import SceneAnchor, ScenePart, between_keyframes
from motorcade.animation.authoring.poses import (
    EulerObjectPose,
    ObjectPose,
    VersorObjectPose,
    pose_of,
)
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray

SCHEMA, VERSION = "motorcade-scene", 1
NOWHERE: Mapping[str, Similarity] = MappingProxyType({})
DEEPEST = 64
_GROUP = ScenePart()


@dataclass(frozen=True, eq=False)
class Scene:
    """Objects by name; a parent is named before its children.

    Methods that are given the name of no object raise ValueError, which lists those there are.

    Args:
        parents: the parent of each object: an anchor, an object, or None for the world.
        poses: `parent_T_object` of each, all of one kind.
        parts: what each is and does; a group where nothing is said.
        anchors: by name, what tracking finds and objects may hang on. Where an anchor stands is
            not the scene's to say: here the world of what hangs on it is the anchor's own frame.

    Raises:
        ValueError: a parent that is not named before its child, poses or parts of other objects,
            an anchor of an object's name, objects more than 64 deep.

    >>> from motorcade.animation.authoring import Scene, VersorObjectPose
    >>> from motorcade.ga import Motor, Similarity
    >>> up = Similarity.from_motor_scale(Motor.from_translation([0.0, 0.0, 0.7]), 1.0)
    >>> poses = {name: VersorObjectPose(up) for name in ("table", "cup")}
    >>> scene = Scene({"table": None, "cup": "table"}, poses)
    >>> scene.world_T_object("cup").translation_m  # world_T_table @ table_T_cup
    array([0. , 0. , 1.4])
    """

    parents: Mapping[str, str | None]
    poses: Mapping[str, ObjectPose]
    parts: Mapping[str, ScenePart] = field(default_factory=dict)
    anchors: Mapping[str, SceneAnchor] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if set(self.parents) != set(self.poses):
            raise ValueError("Scene.poses: expected one pose for each object and no others")
        for name in ("parts", "anchors"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        strange = set(self.parts) - set(self.parents) | set(self.anchors) & set(self.parents)
        if strange:
            raise ValueError(
                "Scene: expected parts of its objects, and anchors of other names, got "
                f"'{min(strange)}'"
            )
        depth: dict[str, int] = dict.fromkeys(self.anchors, 0)
        for name, parent in self.parents.items():
            if parent is not None and parent not in depth:
                raise ValueError(
                    f"Scene.parents: expected the parent of '{name}' before it, got '{parent}'"
                )
            depth[name] = 1 + (0 if parent is None else depth[parent])
            if depth[name] > DEEPEST:
                raise ValueError(f"Scene.parents: expected at most {DEEPEST} deep, got '{name}'")

    def part(self, name: str) -> ScenePart:
        """What an object is and does."""
        self.pose(name)
        return self.parts.get(name, _GROUP)

    def anchor_of(self, name: str) -> str | None:
        """The name of the anchor that an object hangs on, however deep; None for the world."""
        self.pose(name)
        return self._above(name)[1]

    def _above(self, name: str) -> tuple[list[str], str | None]:
        """The objects that one hangs on, the nearest first, and their anchor or None."""
        chain, above = [], self.parents[name]
        while above is not None and above not in self.anchors:
            chain.append(above)
            above = self.parents[above]
        return chain, above

    def pose_at(self, name: str, time_s: float | FloatArray | None = None) -> Similarity:
        """`parent_T_object` at a time: between keyframes where it has some, else its pose.

        Args:
            name: which; one that walks is where it sets out.
            time_s: from the first frame, one time or ``(T,)``; None for what it has apart from
                keyframes.

        Returns:
            a batch ``(T,)`` where it has keyframes and several times are asked for, else one.
        """
        pose, part = self.pose(name).as_similarity(), self.part(name)
        if part.keyframes and time_s is not None:
            clock = np.asarray(time_s, dtype=np.float64)
            return between_keyframes(part, clock.reshape(-1)).reshape(*clock.shape)
        if part.walk is not None:
            x, y = part.walk.path_m[0]
            return pose_of(pose.rotor, np.array([x, y, pose.translation_m[2]]), pose.scale)
        return pose

    def world_T_parent(
        self,
        name: str,
        time_s: float | FloatArray | None = None,
        world_T_anchor: Mapping[str, Similarity] = NOWHERE,
    ) -> Similarity:
        """Where the frame stands in which an object has its pose.

        Args:
            name: which.
            time_s: see `pose_at`.
            world_T_anchor: where anchors stand; for one that is left out, its own frame is the
                world of what hangs on it.
        """
        self.pose(name)
        chain, anchor = self._above(name)
        world = Similarity.identity()
        if anchor is not None:
            world = world_T_anchor.get(anchor, world)
        for link in reversed(chain):
            world = world @ self.pose_at(link, time_s)
        return world

    def world_T_object(
        self,
        name: str,
        time_s: float | FloatArray | None = None,
        world_T_anchor: Mapping[str, Similarity] = NOWHERE,
    ) -> Similarity:
        """Where an object stands in the world; over times ``(T,)`` the path that it takes, a batch
        unless neither it nor what carries it moves. See `world_T_parent`.
        """
        return self.world_T_parent(name, time_s, world_T_anchor) @ self.pose_at(name, time_s)

    def branch(self, name: str) -> list[str]:
        """An object and all that hang on it, in their order."""
        self.pose(name)
        if name not in self.parents.values():
            return [name]
        names = {name}
        for child, parent in self.parents.items():
            if parent in names:
                names.add(child)
        return [one for one in self.parents if one in names]

    def pose(self, name: str) -> ObjectPose:
        """The pose of an object in its parent."""
        if name not in self.poses:
            raise ValueError(
                f"object: expected one of {', '.join(self.poses) or 'none'}, got '{name}'"
            )
        return self.poses[name]

    def with_pose(self, name: str, pose: ObjectPose) -> Scene:
        """The scene with one object somewhere else."""
        self.pose(name)
        return self.but(poses={**self.poses, name: pose})

    def with_part(self, name: str, part: ScenePart) -> Scene:
        """The scene with one object that is or does something else."""
        self.pose(name)
        changed = self.but(parts={**self.parts, name: part})
        more = part.keyframe_count - self.part(name).keyframe_count
        changed.__dict__["keyframe_count"] = self.keyframe_count + more
        return changed

    @cached_property
    def keyframe_count(self) -> int:
        """Of poses and of joints, of all objects."""
        return sum(part.keyframe_count for part in self.parts.values())

    def check_depth(self, name: str) -> None:
        """Refuse an object that hangs deeper than 64. Raises ValueError: it does."""
        if len(self._above(name)[0]) >= DEEPEST:
            raise ValueError(f"Scene.parents: expected at most {DEEPEST} deep, got '{name}'")

    def but(self, **fields: Mapping[str, Any]) -> Scene:
        """The same with fields that need no check: a drag of a large scene has no time for it."""
        scene: Scene = object.__new__(Scene)
        scene.__dict__.update(self.__dict__ | fields)
        if "parts" in fields:
            scene.__dict__.pop("keyframe_count", None)
        return scene

    def without(self, names: Iterable[str]) -> Scene:
        """The scene without some objects, on which nothing else may hang."""
        fields = {field: dict(getattr(self, field)) for field in ("parents", "poses", "parts")}
        for name in names:
            for entries in fields.values():
                entries.pop(name, None)
        return self.but(**fields)

    @property
    def pose_kind(self) -> type[ObjectPose]:
        """What the scene holds poses as."""
        first = next(iter(self.poses.values()), None)
        return EulerObjectPose if isinstance(first, EulerObjectPose) else VersorObjectPose

    def on_euler_angles(self) -> Scene:
        """The same scene with poses held as Euler angles."""
        poses = {
            name: EulerObjectPose.from_similarity(pose.as_similarity())
            for name, pose in self.poses.items()
        }
        return replace(self, poses=poses)

    def as_json(self) -> dict[str, Any]:
        """The tree that `read_scene` reads, its keys in one order."""
        anchors = {name: anchor_json(one) for name, one in self.anchors.items()}
        return {
            "schema": SCHEMA,
            "version": VERSION,
            **({"anchors": anchors} if anchors else {}),
            "objects": [self.object_json(name) for name in self.parents],
        }

    def object_json(self, name: str) -> dict[str, Any]:
        """An object's entry in a scene file."""
        part, parent = self.part(name), self.parents[name]
        return {
            "name": name,
            **({} if part.kind == "group" else {"kind": part.kind, "file": part.file}),
            **({} if parent is None else {"parent": parent}),
            **pose_json(self.poses[name].as_similarity()),
            **part_json(part),
        }


def in_order(parents: Mapping[str, str | None], anchors: Mapping[str, Any]) -> dict[str, Any]:
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
