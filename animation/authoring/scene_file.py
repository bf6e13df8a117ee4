"""Scene files, read strictly: what is unknown is refused, never dropped.

On disk a scene is JSON; `docs/manifests/every_scene_key.json` shows all keys::

    {"schema": "motorcade-scene", "version": 1,
     "anchors": {"table": {"on": "board"}},
     "objects": [
      {"name": "guide", "kind": "character", "file": "mannequin", "parent": "table",
       "height_m": 0.1, "walk": {"path_m": [[0.0, -0.1], [0.2, -0.1]]}},
      {"name": "cup", "kind": "prop", "file": "cup.glb", "parent": "table",
       "position_m": [0.1, 0, 0], "wxyz": [1, 0, 0, 0], "scale": 0.5}
    ]}

A rotation is given as ``wxyz`` or as ``euler_deg`` (intrinsic x-y'-z''); what is left out is none.
An object without a kind is a group: a frame on which others hang. Schema and version may be
left out, as in files of earlier versions.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.authoring.fields import listed, number, read_json, table, text, vector
from motorcade.animation.authoring.parts import (
    JointKeyframe,
    SceneAnchor,
    SceneKeyframe,
    SceneLayer,
    ScenePart,
    SceneWalk,
)
from motorcade.animation.authoring.poses import ObjectPose, VersorObjectPose
from motorcade.animation.authoring.scene import SCHEMA, VERSION, Scene
from motorcade.ga import Motor, Rotor, Similarity

MOST_OBJECTS = 10_000
MOST_KEYFRAMES = 100_000
_MOST_IN_A_LIST = 1000
_TOP = ("schema", "version", "anchors", "objects")
_POSE = ("position_m", "wxyz", "euler_deg", "scale")
_OBJECT = (
    "name",
    "kind",
    "file",
    "parent",
    *_POSE,
    "height_m",
    "clip",
    "clip_start_s",
    "layers",
    "walk",
    "keyframes",
    "interpolation",
    "joint_keyframes",
    "visible",
)


def read_scene(path: Path) -> Scene:
    """Read a scene; poses are held as versors.

    Raises:
        ValueError: a file that cannot be read, is larger than 16 MiB or no JSON, a field that is
            unknown or wrong, more than 10,000 objects, 100,000 keyframes or 64 objects deep; the
            message names file, object and field.
    """
    return scene_of(read_json(path), str(path))


def scene_of(tree: object, where: str) -> Scene:
    """The scene of a tree of JSON, as `Scene.as_json` gives it; `where` opens what is refused.

    Raises:
        ValueError: see `read_scene`.
    """
    if not isinstance(tree, dict):
        raise ValueError(f"{where}: objects: expected a list of 1 to {MOST_OBJECTS} objects")
    top = table(tree, where, _TOP)
    if top.get("schema", SCHEMA) != SCHEMA or top.get("version", VERSION) != VERSION:
        told = f"{top.get('schema', SCHEMA)!r} {top.get('version', VERSION)!r}"[:80]
        raise ValueError(f"{where}: schema: expected '{SCHEMA}' {VERSION}, got {told}")
    objects = top.get("objects")
    if not isinstance(objects, list) or not 1 <= len(objects) <= MOST_OBJECTS:
        raise ValueError(f"{where}: objects: expected a list of 1 to {MOST_OBJECTS} objects")
    anchors = _anchors(top.get("anchors", {}), f"{where}: anchors")
    parents: dict[str, str | None] = {}
    poses: dict[str, ObjectPose] = {}
    parts: dict[str, ScenePart] = {}
    keyframes = 0
    for index, given in enumerate(objects):
        here = f"{where}: objects[{index}]"
        table(given, here, _OBJECT)
        name = given.get("name")
        if not isinstance(name, str) or not name or name in parents or name in anchors:
            raise ValueError(f"{here}.name: expected a name of its own, got {str(name)[:80]!r}")
        parent = given.get("parent")
        if parent is not None and not (
            isinstance(parent, str) and (parent in parents or parent in anchors)
        ):
            told = repr(parent)[:80]
            raise ValueError(f"{here}.parent: expected an object named before, got {told}")
        parents[name] = parent
        poses[name] = VersorObjectPose(_similarity(given, here))
        for key in ("keyframes", "joint_keyframes"):
            keyframes += len(listed(given.get(key, []), f"{here}.{key}", MOST_KEYFRAMES))
        if keyframes > MOST_KEYFRAMES:
            raise ValueError(f"{here}: expected at most {MOST_KEYFRAMES} keyframes in all")
        part = _part(given, here)
        if part is not None:
            parts[name] = part
    try:
        return Scene(parents, poses, parts, anchors)
    except ValueError as fault:
        raise ValueError(f"{where}: {fault}") from fault


def _anchors(given: object, where: str) -> dict[str, SceneAnchor]:
    made = {}
    if not isinstance(given, dict) or len(given) > _MOST_IN_A_LIST:
        raise ValueError(f"{where}: expected at most {_MOST_IN_A_LIST} anchors by name")
    for name, one in given.items():
        here = f"{where}['{text(name, where)}']"
        entry = table(one, here, ("on", "marker", "floor_m"))
        marker = entry.get("marker")
        if marker is not None and (type(marker) is not int or not 0 <= marker < 10**6):
            raise ValueError(f"{here}.marker: expected an id, got {str(marker)[:80]!r}")
        floor_m = number(entry.get("floor_m", 0.0), f"{here}.floor_m")
        try:
            made[name] = SceneAnchor(_word(entry.get("on", "auto")), marker, floor_m)
        except ValueError as fault:
            raise ValueError(f"{here}: {fault}") from fault
    return made


def _part(given: Mapping[str, Any], where: str) -> ScenePart | None:
    """What an object is and does; None for a group that does nothing."""
    said: dict[str, Any] = {}
    for key in ("kind", "interpolation"):
        if key in given:
            said[key] = _word(given[key])
    for key in ("file", "clip"):
        if given.get(key) is not None:
            said[key] = text(given[key], f"{where}.{key}")
    for key in ("height_m", "clip_start_s"):
        if given.get(key) is not None:
            said[key] = number(given[key], f"{where}.{key}")
    try:
        if "layers" in given:
            layers = listed(given["layers"], f"{where}.layers", _MOST_IN_A_LIST)
            said["layers"] = tuple(
                _layer(one, f"{where}.layers[{k}]") for k, one in enumerate(layers)
            )
        if given.get("walk") is not None:
            said["walk"] = _walk(given["walk"], f"{where}.walk")
        said["keyframes"] = tuple(
            _keyframe(one, f"{where}.keyframes[{k}]")
            for k, one in enumerate(given.get("keyframes", []))
        )
        said["joint_keyframes"] = tuple(
            _joint_keyframe(one, f"{where}.joint_keyframes[{k}]")
            for k, one in enumerate(given.get("joint_keyframes", []))
        )
        if given.get("visible") is not None:
            said["visible_s"] = tuple(vector(given["visible"], f"{where}.visible", 2).tolist())
        made = ScenePart(**said)
    except ValueError as fault:
        told = str(fault)
        raise ValueError(told if told.startswith(where) else f"{where}: {told}") from fault
    return None if made.kind == "group" and not made.keyframes else made


def _layer(given: object, where: str) -> SceneLayer:
    one = table(given, where, ("clip", "joints", "weight", "additive", "start_s", "end_s"))
    additive = one.get("additive", False)
    if not isinstance(additive, bool):
        raise ValueError(f"{where}.additive: expected true or false, got {str(additive)[:80]!r}")
    end = one.get("end_s")
    return SceneLayer(
        text(one.get("clip"), f"{where}.clip"),
        _word(one.get("joints", "upper")),
        number(one.get("weight", 1.0), f"{where}.weight"),
        additive,
        number(one.get("start_s", 0.0), f"{where}.start_s"),
        None if end is None else number(end, f"{where}.end_s"),
    )


def _walk(given: object, where: str) -> SceneWalk:
    one = table(given, where, ("path_m", "start_s", "speed_m_s", "gaits"))
    points = listed(one.get("path_m"), f"{where}.path_m", _MOST_IN_A_LIST)
    speed = one.get("speed_m_s")
    gaits = listed(one.get("gaits", ["walk"]), f"{where}.gaits", _MOST_IN_A_LIST)
    return SceneWalk(
        np.array([vector(point, f"{where}.path_m", 2) for point in points]).reshape(-1, 2),
        number(one.get("start_s", 0.0), f"{where}.start_s"),
        None if speed is None else number(speed, f"{where}.speed_m_s"),
        tuple(text(name, f"{where}.gaits") for name in gaits),
    )


def _keyframe(given: object, where: str) -> SceneKeyframe:
    one = table(given, where, ("time_s", *_POSE))
    angles = None
    if one.get("euler_deg") is not None:
        x, y, z = vector(one["euler_deg"], f"{where}.euler_deg", 3).tolist()
        angles = x, y, z
    return SceneKeyframe(
        number(one.get("time_s"), f"{where}.time_s"), _similarity(one, where), angles
    )


def _joint_keyframe(given: object, where: str) -> JointKeyframe:
    one = table(given, where, ("time_s", "joints"))
    joints = one.get("joints")
    if not isinstance(joints, dict) or len(joints) > _MOST_IN_A_LIST:
        raise ValueError(f"{where}.joints: expected at most {_MOST_IN_A_LIST} turns by joint")
    rotors = {
        text(name, f"{where}.joints"): _rotor(wxyz, f"{where}.joints['{name}']")
        for name, wxyz in joints.items()
    }
    return JointKeyframe(number(one.get("time_s"), f"{where}.time_s"), rotors)


def _similarity(given: Mapping[str, Any], where: str) -> Similarity:
    if "wxyz" in given and "euler_deg" in given:
        raise ValueError(f"{where}: expected wxyz or euler_deg, got both")
    rotor = Rotor.identity()
    if "wxyz" in given:
        rotor = _rotor(given["wxyz"], f"{where}.wxyz")
    elif "euler_deg" in given:
        angles = np.radians(vector(given["euler_deg"], f"{where}.euler_deg", 3))
        rotor = Rotor.from_euler(angles)
    position = vector(given.get("position_m", [0, 0, 0]), f"{where}.position_m", 3)
    scale = number(given.get("scale", 1.0), f"{where}.scale")
    if not 1e-6 <= scale <= 1e6:
        raise ValueError(f"{where}.scale: expected 1e-6 to 1e6, got {scale:g}")
    motor = Motor.from_rotor_translation(rotor, position)
    return Similarity.from_motor_scale(motor, scale)


def _rotor(given: object, where: str) -> Rotor:
    wxyz = vector(given, where, 4)
    try:
        return Rotor.from_quaternion(wxyz)
    except ValueError as fault:
        raise ValueError(f"{where}: {fault}") from fault


def _word(given: object) -> Any:
    """A word that the value itself checks; whatever else JSON holds as text that is none."""
    return given if isinstance(given, str) else repr(given)[:80]
