"""Fields of JSON files that others wrote: numbers, vectors, tables, lines; refused by name.

Parts and anchors of a scene as JSON holds them: defaults left out, keys in one order.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import fields
from pathlib import Path
from reprlib import Repr
from typing import Any

from motorcade.animation.authoring.parts import (
    JointKeyframe,
    SceneAnchor,
    SceneKeyframe,
    SceneLayer,
    ScenePart,
    SceneWalk,
)
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.files import read_bounded

MOST_BYTES = 16 * 2**20
MOST_LINES_BYTES = 64 * 2**20
_SHORT = Repr()
_SHORT.maxstring = _SHORT.maxlong = _SHORT.maxother = 70


def number(value: object, where: str) -> float:
    """A finite number of JSON. Raises ValueError: anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e9:
        raise ValueError(f"{where}: expected a number, got {short(value)}")
    return float(value)


def vector(value: object, where: str, size: int) -> FloatArray:
    """A list of finite numbers of JSON. Raises ValueError: anything else."""
    if not isinstance(value, list) or len(value) != size:
        raise ValueError(f"{where}: expected {size} numbers, got {short(value)}")
    return checked_floats([number(one, where) for one in value], where, ())


def text(value: object, where: str) -> str:
    """A text of 1 to 1000 printable letters. Raises ValueError: anything else."""
    if not isinstance(value, str) or not 1 <= len(value) <= 1000 or not value.isprintable():
        raise ValueError(f"{where}: expected a text, got {short(value)}")
    return value


def object_name(value: object, where: str) -> str:
    """A name: a text of 1 to 100 printable letters. Raises ValueError: anything else."""
    if not isinstance(value, str) or not 1 <= len(value) <= 100 or not value.isprintable():
        raise ValueError(f"{where}: expected a name, got {short(value)}")
    return value


def listed(value: object, where: str, most: int) -> list[Any]:
    """A list of JSON of at most so many entries. Raises ValueError: anything else."""
    if not isinstance(value, list) or len(value) > most:
        raise ValueError(f"{where}: expected a list of at most {most}, got {short(value)}")
    return value


def table(value: object, where: str, known: Iterable[str]) -> dict[str, Any]:
    """An object of JSON that has no keys but those known.

    Raises ValueError: anything else; the message names the first key that is not.
    """
    if not isinstance(value, dict):
        raise ValueError(f"{where}: expected an object of JSON, got {short(value)}")
    allowed = sorted(known)
    for key in value:
        if key not in allowed:
            raise ValueError(f"{where}: expected fields of {', '.join(allowed)}, got {short(key)}")
    return value


def read_json(path: Path) -> Any:
    """A file of JSON.

    Raises ValueError: a file that cannot be read, is larger than 16 MiB, or no JSON.
    """
    return parsed_json(_decoded(read_bounded(path, MOST_BYTES), path), path.name)


def read_json_lines(path: Path) -> Iterator[tuple[int, Any]]:
    """Line numbers and values of a file of JSON lines; empty lines are left out.

    Raises ValueError: a file that cannot be read or is too large, a line that is no JSON.
    """
    for at, line in enumerate(
        _decoded(read_bounded(path, MOST_LINES_BYTES), path).split("\n"), start=1
    ):
        if line.strip():
            yield at, parsed_json(line, f"{path.name}:{at}")


def _decoded(data: bytes, path: Path) -> str:
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as fault:
        raise ValueError(f"{path}: expected UTF-8, got other bytes") from fault


def parsed_json(text: str, where: str) -> Any:
    """JSON in which no key stands twice and every number is one.

    Raises ValueError: anything else; the message begins with `where`.
    """
    try:
        return json.loads(text, object_pairs_hook=_once, parse_constant=_no_number)
    except (ValueError, RecursionError) as fault:  # also numbers of thousands of digits
        raise ValueError(f"{where}: expected JSON, got {' '.join(str(fault).split())}") from fault


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    fields = dict(pairs)
    if len(fields) < len(pairs):
        twice = Counter(key for key, _ in pairs).most_common(1)[0][0]
        raise ValueError(f"expected different keys, got {short(twice)} twice")
    return fields


def _no_number(word: str) -> Any:
    raise ValueError(f"expected a number, got {word}")


def short(value: object) -> str:
    """What was given in 80 letters at most, however large it is."""
    text = _SHORT.repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _changed(value: Any, *names: str) -> dict[str, Any]:
    """Those fields of a dataclass that are not what they are when left out."""
    defaults = {field.name: field.default for field in fields(value)}
    own = {name: getattr(value, name) for name in names}
    return {name: entry for name, entry in own.items() if entry != defaults[name]}


def anchor_json(anchor: SceneAnchor) -> dict[str, Any]:
    """As an entry of `anchors`."""
    return {"on": anchor.on, **_changed(anchor, "marker", "floor_m")}


def pose_json(pose: Similarity) -> dict[str, Any]:
    """Position, turn and scale, as those of an object."""
    return {
        "position_m": pose.translation_m.tolist(),
        "wxyz": pose.rotor.as_quaternion().tolist(),
        "scale": float(pose.scale),
    }


def part_json(part: ScenePart) -> dict[str, Any]:
    """What an object has besides its name, parent and pose."""
    said = _changed(part, "height_m", "clip", "clip_start_s")
    if part.layers:
        said["layers"] = [layer_json(one) for one in part.layers]
    if part.walk is not None:
        said["walk"] = _walk_json(part.walk)
    if part.keyframes:
        said["keyframes"] = [_keyframe_json(one) for one in part.keyframes]
    said |= _changed(part, "interpolation")
    if part.joint_keyframes:
        said["joint_keyframes"] = [_pose_of_joints_json(one) for one in part.joint_keyframes]
    if part.visible_s is not None:
        said["visible"] = list(part.visible_s)
    return said


def _keyframe_json(scene_keyframe: SceneKeyframe) -> dict[str, Any]:
    keyframe_json = {"time_s": scene_keyframe.time_s, **pose_json(scene_keyframe.parent_T_object)}
    if scene_keyframe.angles_deg is not None:
        del keyframe_json["wxyz"]
        keyframe_json["euler_deg"] = list(scene_keyframe.angles_deg)
    return keyframe_json


def _pose_of_joints_json(joint_keyframe: JointKeyframe) -> dict[str, Any]:
    joints = {name: rotor.as_quaternion().tolist() for name, rotor in joint_keyframe.rotors.items()}
    return {"time_s": joint_keyframe.time_s, "joints": joints, **_changed(joint_keyframe, "end_s")}


def layer_json(layer: SceneLayer) -> dict[str, Any]:
    """As an entry of `layers`."""
    said = {"clip": layer.clip, "joints": layer.joints, "weight": layer.weight}
    return said | _changed(layer, "additive", "start_s", "end_s", "fade_s")


def _walk_json(walk: SceneWalk) -> dict[str, Any]:
    said = {"path_m": walk.path_m.tolist(), "start_s": walk.start_s}
    return said | _changed(walk, "speed_m_s") | {"gaits": list(walk.gaits)}
