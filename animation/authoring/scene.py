"""A scene to be edited and played: named objects in a tree, each with its pose in its parent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from motorcade.animation.authoring.parts import SceneAnchor, ScenePart
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose
from motorcade.animation.authoring.written import anchor_json, part_json, pose_json
from motorcade.ga import Similarity

SCHEMA, VERSION = "motorcade-scene", 1
DEEPEST = 64
_GROUP = ScenePart()


@dataclass(frozen=True, eq=False)
class Scene:
    """Objects by name; a parent is named before its children.

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
        """What an object is and does.

        Raises:
            ValueError: no such object.
        """
        self.pose(name)
        return self.parts.get(name, _GROUP)

    def anchor_of(self, name: str) -> str | None:
        """The name of the anchor that an object hangs on, however deep; None for the world.

        Raises:
            ValueError: no such object.
        """
        self.pose(name)
        above: str | None = name
        while above is not None and above not in self.anchors:
            above = self.parents[above]
        return above

    def world_T_parent(self, name: str) -> Similarity:
        """Where the frame stands in which an object has its pose, in the world or its anchor.

        Raises:
            ValueError: no such object.
        """
        self.pose(name)
        chain, above = [], self.parents[name]
        while above is not None and above not in self.anchors:
            chain.append(above)
            above = self.parents[above]
        world = Similarity.identity()
        for one in reversed(chain):
            world = world @ self.poses[one].as_similarity()
        return world

    def world_T_object(self, name: str) -> Similarity:
        """Where an object stands in the world, or in the frame of its anchor.

        Raises:
            ValueError: no such object.
        """
        return self.world_T_parent(name) @ self.pose(name).as_similarity()

    def pose(self, name: str) -> ObjectPose:
        """The pose of an object in its parent.

        Raises:
            ValueError: no such object; the message lists those there are.
        """
        if name not in self.poses:
            raise ValueError(
                f"object: expected one of {', '.join(self.poses) or 'none'}, got '{name}'"
            )
        return self.poses[name]

    def with_pose(self, name: str, pose: ObjectPose) -> Scene:
        """The scene with one object somewhere else."""
        return replace(self, poses={**self.poses, name: pose})

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
            "objects": [self._object_json(name) for name in self.parents],
        }

    def _object_json(self, name: str) -> dict[str, Any]:
        part, parent = self.part(name), self.parents[name]
        return {
            "name": name,
            **({} if part.kind == "group" else {"kind": part.kind, "file": part.file}),
            **({} if parent is None else {"parent": parent}),
            **pose_json(self.poses[name].as_similarity()),
            **part_json(part),
        }
