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

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.authoring.fields import (
    MOST_BYTES,
    listed,
    number,
    object_name,
    read_json,
    short,
    table,
    text,
    vector,
)
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
from motorcade.animation.easing import FADE_S
from motorcade.ga import Motor, Rotor, Similarity

MOST_OBJECTS = 10_000
MOST_KEYFRAMES = 100_000
# A pose that was read is written within rounding of it, and must be read again.
FARTHEST_M, SCALES, _ROUNDING = 999e6, (1e-6, 1e6), 1e-6
MOST_IN_A_LIST = 1000
_TOP = ("schema", "version", "anchors", "objects")
POSE_KEYS = ("position_m", "wxyz", "euler_deg", "scale")


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
        raise ValueError(f"{where}: objects: expected a list of at most {MOST_OBJECTS} objects")
    top = table(tree, where, _TOP)
    version = top.get("version", VERSION)
    if top.get("schema", SCHEMA) != SCHEMA or type(version) is not int or version != VERSION:
        stated = f"{short(top.get('schema', SCHEMA))} {short(top.get('version', VERSION))}"
        raise ValueError(f"{where}: schema: expected '{SCHEMA}' {VERSION}, got {stated}")
    objects = top.get("objects")
    if not isinstance(objects, list) or len(objects) > MOST_OBJECTS:
        raise ValueError(f"{where}: objects: expected a list of at most {MOST_OBJECTS} objects")
    anchors = _anchors(top.get("anchors", {}), f"{where}: anchors")
    parents: dict[str, str | None] = {}
    poses: dict[str, ObjectPose] = {}
    parts: dict[str, ScenePart] = {}
    _count_keyframes(objects, where)
    for index, entry in enumerate(objects):
        here = f"{where}: objects[{index}]"
        placed = object_of(entry, here)
        if placed.name in parents or placed.name in anchors:
            raise ValueError(f"{here}.name: expected a name of its own, got {placed.name!r}")
        if placed.parent is not None and not (placed.parent in parents or placed.parent in anchors):
            raise ValueError(
                f"{here}.parent: expected an object named before, got {short(placed.parent)}"
            )
        parents[placed.name], poses[placed.name] = placed.parent, placed.pose
        if placed.part.kind != "group" or placed.part.keyframes:
            parts[placed.name] = placed.part
    try:
        return Scene(parents, poses, parts, anchors)
    except ValueError as fault:
        raise ValueError(f"{where}: {fault}") from fault


def _count_keyframes(objects: list[Any], where: str) -> None:
    """Refuse too many keyframes before any is looked at."""
    lists = [
        entry[key]
        for entry in objects
        if isinstance(entry, dict)
        for key in ("keyframes", "joint_keyframes")
        if isinstance(entry.get(key), list)
    ]
    if sum(map(len, lists)) > MOST_KEYFRAMES:
        raise ValueError(f"{where}: objects: expected at most {MOST_KEYFRAMES} keyframes in all")


@dataclass(frozen=True, eq=False)
class SceneEntry:
    """An object as a scene file lists it: what `Scene` holds of it by name."""

    name: str
    parent: str | None
    pose: ObjectPose
    part: ScenePart


def object_of(value: object, where: str) -> SceneEntry:
    """An entry of `objects`.

    Raises ValueError: a field that is unknown or wrong; the message begins with `where`.
    """
    entry = table(value, where, ("name", "parent", *POSE_KEYS, *_PART))
    name = object_name(entry.get("name"), f"{where}.name")
    parent = entry.get("parent")
    if parent is not None and not isinstance(parent, str):
        raise ValueError(f"{where}.parent: expected an object named before, got {short(parent)}")
    pose = VersorObjectPose(similarity_of(entry, where))
    part = prefixed(where, lambda: ScenePart(**part_fields(entry, where)))
    return SceneEntry(name, parent, pose, part)


def scene_text(scene: Scene) -> str:
    """A scene file: the same text of the same scene.

    Raises:
        ValueError: more than 16 MiB, which could not be read again.

    >>> import json
    >>> from motorcade.animation.authoring import scene_of, scene_text
    >>> json.loads(scene_text(scene_of({"objects": [{"name": "cup"}]}, "")))["version"]
    1
    """
    document = json.dumps(scene.as_json(), indent=1, allow_nan=False) + "\n"
    if len(document) > MOST_BYTES:  # in ASCII
        raise ValueError(
            f"scene: expected at most {MOST_BYTES} bytes to write, got {len(document)}"
        )
    return document


def _anchors(value: object, where: str) -> dict[str, SceneAnchor]:
    anchors = {}
    if not isinstance(value, dict) or len(value) > MOST_IN_A_LIST:
        raise ValueError(f"{where}: expected at most {MOST_IN_A_LIST} anchors by name")
    for name, entry in value.items():
        anchors[name] = anchor_of(entry, f"{where}['{object_name(name, where)}']")
    return anchors


def anchor_of(value: object, where: str) -> SceneAnchor:
    """An entry of `anchors`. Raises ValueError: a wrong field; the message begins with `where`."""
    entry = table(value, where, ("on", "marker", "floor_m"))
    marker = entry.get("marker")
    if marker is not None and (type(marker) is not int or not 0 <= marker < 10**6):
        raise ValueError(f"{where}.marker: expected an id, got {short(marker)}")
    floor_m = number(entry.get("floor_m", 0.0), f"{where}.floor_m")
    on = _word(entry.get("on", "auto"))
    anchor: SceneAnchor = prefixed(where, lambda: SceneAnchor(on, marker, floor_m))
    return anchor


def part_fields(fields: Mapping[str, Any], where: str) -> dict[str, Any]:
    """What an object's keys say of its `ScenePart`, by its fields; null is the default.

    Raises ValueError: a wrong field; the message begins with `where`.
    """
    said = {}
    for key, (field, read) in _PART.items():
        if key in fields:
            at = f"{where}.{key}"
            value = fields[key]
            said[field] = _DEFAULTS[field] if value is None else prefixed(at, read, value, at)
    return said


def prefixed(where: str, read: Callable[..., Any], *arguments: Any) -> Any:
    """What is read; what is refused without saying where, says so."""
    try:
        return read(*arguments)
    except ValueError as fault:
        reason = str(fault)
        raise ValueError(reason if reason.startswith(where) else f"{where}: {reason}") from fault


def _rows(read: Callable[[object, str], Any], most: int) -> Callable[[object, str], Any]:
    def made(value: object, where: str) -> tuple[Any, ...]:
        rows = enumerate(listed(value, where, most))
        return tuple(prefixed(f"{where}[{k}]", read, one, f"{where}[{k}]") for k, one in rows)

    return made


def _span(value: object, where: str) -> tuple[float, float]:
    start, end = vector(value, where, 2).tolist()
    return start, end


def layer_of(value: object, where: str) -> SceneLayer:
    """An entry of `layers`. Raises ValueError: a wrong field; the message begins with `where`."""
    fields = table(
        value, where, ("clip", "joints", "weight", "additive", "start_s", "end_s", "fade_s")
    )
    additive = fields.get("additive", False)
    if not isinstance(additive, bool):
        raise ValueError(f"{where}.additive: expected true or false, got {short(additive)}")
    end = fields.get("end_s")
    return SceneLayer(
        text(fields.get("clip"), f"{where}.clip"),
        _word(fields.get("joints", "upper")),
        number(fields.get("weight", 1.0), f"{where}.weight"),
        additive,
        number(fields.get("start_s", 0.0), f"{where}.start_s"),
        None if end is None else number(end, f"{where}.end_s"),
        number(fields.get("fade_s", FADE_S), f"{where}.fade_s"),
    )


def _walk(value: object, where: str) -> SceneWalk:
    fields = table(value, where, ("path_m", "start_s", "speed_m_s", "gaits"))
    points = listed(fields.get("path_m"), f"{where}.path_m", MOST_IN_A_LIST)
    speed = fields.get("speed_m_s")
    gaits = listed(fields.get("gaits", ["walk"]), f"{where}.gaits", MOST_IN_A_LIST)
    return SceneWalk(
        np.array([vector(point, f"{where}.path_m", 2) for point in points]).reshape(-1, 2),
        number(fields.get("start_s", 0.0), f"{where}.start_s"),
        None if speed is None else number(speed, f"{where}.speed_m_s"),
        tuple(text(name, f"{where}.gaits") for name in gaits),
    )


def _keyframe(value: object, where: str) -> SceneKeyframe:
    fields = table(value, where, ("time_s", *POSE_KEYS))
    angles = None
    if fields.get("euler_deg") is not None:
        x, y, z = vector(fields["euler_deg"], f"{where}.euler_deg", 3).tolist()
        angles = x, y, z
    return SceneKeyframe(
        number(fields.get("time_s"), f"{where}.time_s"), similarity_of(fields, where), angles
    )


def _joint_keyframe(value: object, where: str) -> JointKeyframe:
    fields = table(value, where, ("time_s", "joints", "end_s"))
    joints = fields.get("joints")
    if not isinstance(joints, dict) or len(joints) > MOST_IN_A_LIST:
        raise ValueError(f"{where}.joints: expected at most {MOST_IN_A_LIST} turns by joint")
    rotors = {
        text(name, f"{where}.joints"): rotor_of(wxyz, f"{where}.joints['{short(name)}']")
        for name, wxyz in joints.items()
    }
    end = fields.get("end_s")
    return JointKeyframe(
        number(fields.get("time_s"), f"{where}.time_s"),
        rotors,
        None if end is None else number(end, f"{where}.end_s"),
    )


def similarity_of(fields: Mapping[str, Any], where: str) -> Similarity:
    """A pose by its keys; what is left out is none.

    Raises ValueError: a wrong field; the message begins with `where`.
    """
    if "wxyz" in fields and "euler_deg" in fields:
        raise ValueError(f"{where}: expected wxyz or euler_deg, got both")
    rotor = Rotor.identity()
    if "wxyz" in fields:
        rotor = rotor_of(fields["wxyz"], f"{where}.wxyz")
    elif "euler_deg" in fields:
        angles = np.radians(vector(fields["euler_deg"], f"{where}.euler_deg", 3))
        rotor = Rotor.from_euler(angles)
    position = vector(fields.get("position_m", [0, 0, 0]), f"{where}.position_m", 3)
    scale = number(fields.get("scale", 1.0), f"{where}.scale")
    low, high = SCALES
    if not low * (1.0 - _ROUNDING) <= scale <= high * (1.0 + _ROUNDING):
        raise ValueError(f"{where}.scale: expected 1e-6 to 1e6, got {scale:g}")
    motor = Motor.from_rotor_translation(rotor, position)
    return Similarity.from_motor_scale(motor, scale)


def rotor_of(value: object, where: str) -> Rotor:
    """A turn ``wxyz``. Raises ValueError: no quaternion; the message begins with `where`."""
    wxyz = vector(value, where, 4)
    try:
        return Rotor.from_quaternion(wxyz)
    except ValueError as fault:
        raise ValueError(f"{where}: {fault}") from fault


def _word(value: object, where: str = "") -> Any:
    """A word that the value itself checks; whatever else JSON holds as text that is none."""
    return value if isinstance(value, str) else short(value)


# By the key of an object, the field of its part and how it is read.
_PART: dict[str, tuple[str, Callable[[object, str], Any]]] = {
    "kind": ("kind", _word),
    "file": ("file", text),
    "height_m": ("height_m", number),
    "clip": ("clip", text),
    "clip_start_s": ("clip_start_s", number),
    "layers": ("layers", _rows(layer_of, MOST_IN_A_LIST)),
    "walk": ("walk", _walk),
    "keyframes": ("keyframes", _rows(_keyframe, MOST_KEYFRAMES)),
    "interpolation": ("interpolation", _word),
    "joint_keyframes": ("joint_keyframes", _rows(_joint_keyframe, MOST_KEYFRAMES)),
    "visible": ("visible_s", _span),
}
PART_KEYS = tuple(_PART)
_DEFAULTS: dict[str, Any] = {one.name: getattr(ScenePart(), one.name) for one in fields(ScenePart)}
