"""A scene to be edited: named objects in a tree, each with its pose in its parent.

On disk a scene is JSON::

    {"objects": [
      {"name": "table", "position_m": [0, 0, 0.7]},
      {"name": "cup", "parent": "table", "position_m": [0.1, 0, 0], "wxyz": [1, 0, 0, 0],
       "scale": 0.5}
    ]}

A rotation is given as ``wxyz`` or as ``euler_deg`` (intrinsic x-y'-z''); what is left out is none.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose, VersorObjectPose
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.files import read_bounded

MOST_BYTES = 16 * 2**20
MOST_OBJECTS = 10_000
_FIELDS = {"name", "parent", "position_m", "wxyz", "euler_deg", "scale"}


@dataclass(frozen=True, eq=False)
class Scene:
    """Objects by name; a parent is named before its children.

    Args:
        parents: the parent of each object, or None for one that stands in the world.
        poses: `parent_T_object` of each, all of one kind.

    Raises:
        ValueError: a parent that is not named before its child, or poses of other objects.

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

    def __post_init__(self) -> None:
        if set(self.parents) != set(self.poses):
            raise ValueError("Scene.poses: expected one pose for each object and no others")
        seen: set[str] = set()
        for name, parent in self.parents.items():
            if parent is not None and parent not in seen:
                raise ValueError(
                    f"Scene.parents: expected the parent of '{name}' before it, got '{parent}'"
                )
            seen.add(name)

    def world_T_parent(self, name: str) -> Similarity:
        """Where the frame stands in which an object has its pose.

        Raises:
            ValueError: no such object.
        """
        self.pose(name)
        chain, above = [], self.parents[name]
        while above is not None:
            chain.append(above)
            above = self.parents[above]
        world = Similarity.identity()
        for one in reversed(chain):
            world = world @ self.poses[one].as_similarity()
        return world

    def world_T_object(self, name: str) -> Similarity:
        """Where an object stands in the world.

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
        return Scene(self.parents, {**self.poses, name: pose})

    def on_euler_angles(self) -> Scene:
        """The same scene with poses held as Euler angles."""
        poses = {
            name: EulerObjectPose.from_similarity(pose.as_similarity())
            for name, pose in self.poses.items()
        }
        return Scene(self.parents, poses)

    def as_json(self) -> dict[str, Any]:
        """The tree that `read_scene` reads."""
        return {"objects": [self._object_json(name) for name in self.parents]}

    def _object_json(self, name: str) -> dict[str, Any]:
        pose = self.poses[name].as_similarity()
        return {
            "name": name,
            **({} if self.parents[name] is None else {"parent": self.parents[name]}),
            "position_m": pose.translation_m.tolist(),
            "wxyz": pose.rotor.as_quaternion().tolist(),
            "scale": float(pose.scale),
        }


def read_scene(path: Path) -> Scene:
    """Read a scene; poses are held as versors.

    Raises:
        ValueError: a file that cannot be read, is larger than 16 MiB or no JSON, a field that is
            unknown or wrong; the message names file, object and field.
    """
    tree = _json(path.name, _text(path))
    objects = tree.get("objects") if isinstance(tree, dict) else None
    if not isinstance(objects, list) or not 1 <= len(objects) <= MOST_OBJECTS:
        raise ValueError(f"{path}: objects: expected a list of 1 to {MOST_OBJECTS} objects")
    parents: dict[str, str | None] = {}
    poses: dict[str, ObjectPose] = {}
    for index, given in enumerate(objects):
        where = f"{path}: objects[{index}]"
        if not isinstance(given, dict) or set(given) - _FIELDS:
            raise ValueError(f"{where}: expected fields of {', '.join(sorted(_FIELDS))}")
        name = given.get("name")
        if not isinstance(name, str) or not name or name in parents:
            raise ValueError(f"{where}.name: expected a name of its own, got {name!r}")
        parent = given.get("parent")
        if parent is not None and not (isinstance(parent, str) and parent in parents):
            raise ValueError(f"{where}.parent: expected an object named before, got {parent!r}")
        parents[name] = parent
        poses[name] = VersorObjectPose(_similarity(given, where))
    return Scene(parents, poses)


def _similarity(given: Mapping[str, Any], where: str) -> Similarity:
    if "wxyz" in given and "euler_deg" in given:
        raise ValueError(f"{where}: expected wxyz or euler_deg, got both")
    rotor = Rotor.identity()
    if "wxyz" in given:
        wxyz = vector(given["wxyz"], f"{where}.wxyz", 4)
        try:
            rotor = Rotor.from_quaternion(wxyz)
        except ValueError as fault:
            raise ValueError(f"{where}.wxyz: {fault}") from fault
    elif "euler_deg" in given:
        angles = np.radians(vector(given["euler_deg"], f"{where}.euler_deg", 3))
        rotor = Rotor.from_euler(angles)
    position = vector(given.get("position_m", [0, 0, 0]), f"{where}.position_m", 3)
    scale = number(given.get("scale", 1.0), f"{where}.scale")
    if not 1e-6 <= scale <= 1e6:
        raise ValueError(f"{where}.scale: expected 1e-6 to 1e6, got {scale:g}")
    motor = Motor.from_rotor_translation(rotor, position)
    return Similarity.from_motor_scale(motor, scale)


def number(given: object, where: str) -> float:
    """A finite number of JSON.

    Raises:
        ValueError: anything else.
    """
    if isinstance(given, bool) or not isinstance(given, int | float) or not abs(given) < 1e9:
        raise ValueError(f"{where}: expected a number, got {given!r}")
    return float(given)


def vector(given: object, where: str, size: int) -> FloatArray:
    """A list of finite numbers of JSON.

    Raises:
        ValueError: anything else.
    """
    if not isinstance(given, list) or len(given) != size:
        raise ValueError(f"{where}: expected {size} numbers, got {given!r}")
    return checked_floats([number(one, where) for one in given], where, ())


def read_json_lines(path: Path) -> list[tuple[int, Any]]:
    """Line numbers and values of a file of JSON lines; empty lines are left out.

    Raises:
        ValueError: a file that cannot be read or is too large, a line that is no JSON.
    """
    lines = enumerate(_text(path).splitlines(), start=1)
    return [(at, _json(f"{path.name}:{at}", line)) for at, line in lines if line.strip()]


def _text(path: Path) -> str:
    try:
        return read_bounded(path, MOST_BYTES).decode("utf-8")
    except UnicodeDecodeError as fault:
        raise ValueError(f"{path}: expected UTF-8, got other bytes") from fault


def _json(where: str, text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as fault:  # also numbers of thousands of digits
        raise ValueError(f"{where}: expected JSON, got {' '.join(str(fault).split())}") from fault
