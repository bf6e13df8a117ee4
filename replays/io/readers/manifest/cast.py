"""Casts: a TOML file that says which characters act in the footage, and what each is asked to do.

`docs/manifests/every_cast_key.toml` shows all keys. Files are named relative to the cast's folder.

The files that a scene names: "mannequin", or glTF, Collada, MD5 and FBX beside the scene.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.animation.authoring import ScenePart, read_scene
from motorcade.animation.behaviour.actor import LASTING
from motorcade.animation.behaviour.crowd import MOST
from motorcade.ga.arrays import FloatArray
from motorcade.ga.names import one_line
from motorcade.replays.io.readers.manifest.section import FILE_KNOBS, Section, load_toml

MANNEQUIN, NOBODY = FILE_KNOBS["placed.character"], FILE_KNOBS["placed.cast"]
CAMERA = "camera"
AXES = ("x", "-x", "y", "-y", "z", "-z")
MASKS = ("whole", "upper", "left_arm", "right_arm", "head")
_TOP = ("gap_m", "characters")
_CHARACTER = (
    "name",
    "file",
    "up",
    "front",
    "motions",
    "height_m",
    "start",
    "path",
    "heading_deg",
    "facing_deg",
    "look_at",
    "gaits",
    "speed_m_s",
    "idle",
    "acts",
    "waits_s",
    "layers",
)
_LAYER = ("clip", "joints", "during", "weight", "additive")
_FARTHEST_M, _LONGEST_S, _MOST_POINTS, _LONGEST_NAME = 1e4, 600.0, 100, 100


@dataclass(frozen=True)
class LayerAsked:
    """A clip over the others; see `behaviour.ClipLayer`."""

    clip: str
    joints: str
    during: str
    weight: float
    additive: bool


@dataclass(frozen=True, eq=False)
class CastMember:
    """A character of a cast, as the file asks for it. None where the file is silent.

    Fields:
        name: what it is called.
        file: "mannequin", or where it is read from.
        up, front: axes of its file that are up, and that it faces, where the cast knows better.
        motions: files with further clips, which are retargeted to it.
        height_m: as tall as it shall stand.
        path_m: ``(P, 2)`` where it stands first, and what it walks through from there, if anything.
        heading_deg, facing_deg: where it looks at first, and at its goal.
        look_at: "camera", or ``(3,)`` a place on the plane, at which its head looks.
        gaits: names of clips that it walks by, blended to `speed_m_s` at the size of its file.
        idle: name of the clip by which it waits.
        acts: names of clips that it plays at its goal.
        waits_s: before it goes.
        layers: clips over the others.
    """

    name: str
    file: str
    up: str | None
    front: str | None
    motions: tuple[Path, ...]
    height_m: float | None
    path_m: FloatArray
    heading_deg: float | None
    facing_deg: float | None
    look_at: str | FloatArray | None
    gaits: tuple[str, ...]
    speed_m_s: float | None
    idle: str
    acts: tuple[str, ...]
    waits_s: float
    layers: tuple[LayerAsked, ...]


@dataclass(frozen=True, eq=False)
class Cast:
    """Characters, those first who have the right of way, and how far they keep apart.

    Fields:
        path: the file.
        gap_m: between two bodies; a tenth of the smaller one's height where it is None.
        members: one or more.
    """

    path: Path
    gap_m: float | None
    members: tuple[CastMember, ...]

    def files(self) -> Iterator[Path]:
        """Every file that the cast names."""
        for member in self.members:
            if member.file != MANNEQUIN:
                yield Path(member.file)
            yield from member.motions


def read_cast(path: Path) -> Cast:
    """Read a cast.

    Raises:
        RecordingError: no such file, no TOML, an unknown key, a wrong type, count or range; each in
            one line with table and key.
    """
    table = load_toml(path)
    top = Section(path, "", table, _TOP)
    listed = top["characters"]
    if not isinstance(listed, list) or not 1 <= len(listed) <= MOST:
        count = len(listed) if isinstance(listed, list) else one_line(listed)
        raise top.fault("characters", f"expected 1 to {MOST} [[characters]] tables, got {count}")
    gap_m = top.number("gap_m", 0.0, _FARTHEST_M) if "gap_m" in top else None
    members = tuple(_member(path, number, one) for number, one in enumerate(listed, 1))
    names = [member.name for member in members]
    for number, name in enumerate(names):
        if name in names[:number]:
            raise top.fault("characters", f"expected different names, got {name!r} twice")
    return Cast(path, gap_m, members)


def _member(path: Path, number: int, table: object) -> CastMember:
    section = Section(path, f"characters {number}", table, _CHARACTER)

    def maybe(key: str, low: float, high: float) -> float | None:
        return section.number(key, low, high) if key in section else None

    def texts(key: str, otherwise: tuple[str, ...] = ()) -> tuple[str, ...]:
        return section.texts(key) if key in section else otherwise

    file = section.text("file") if "file" in section else MANNEQUIN
    name = section.text("name") if "name" in section else f"character {number}"
    if not name.isprintable() or len(name) > _LONGEST_NAME:
        expected = f"expected up to {_LONGEST_NAME} printable letters"
        raise section.fault("name", f"{expected}, got {one_line(name)}")
    return CastMember(
        name,
        file if file == MANNEQUIN else str((path.parent / file).absolute()),
        section.text("up", AXES) if "up" in section else None,
        section.text("front", AXES) if "front" in section else None,
        tuple((path.parent / one).absolute() for one in texts("motions")),
        maybe("height_m", 1e-6, _FARTHEST_M),
        _path(section),
        maybe("heading_deg", -360.0, 360.0),
        maybe("facing_deg", -360.0, 360.0),
        _look_at(section),
        texts("gaits", ("walk",)),
        maybe("speed_m_s", 1e-6, _FARTHEST_M),
        section.text("idle") if "idle" in section else "idle",
        texts("acts"),
        maybe("waits_s", 0.0, _LONGEST_S) or 0.0,
        _layers(path, number, section),
    )


def _path(section: Section) -> FloatArray:
    """Points (P, 2) of the path, or the start alone."""
    section.only_one("start", "path")
    if "path" not in section:
        start = np.array(section.numbers("start", 2))
        if len(start) != 2 or np.abs(start).max() > _FARTHEST_M:
            expected = f"expected [x, y] within {_FARTHEST_M:g} m"
            raise section.fault("start", f"{expected}, got {one_line(start.tolist())}")
        return start.reshape(1, 2)
    listed = section["path"]
    if not isinstance(listed, list) or not 2 <= len(listed) <= _MOST_POINTS:
        expected = f"expected 2 to {_MOST_POINTS} points [x, y]"
        raise section.fault("path", f"{expected}, got {one_line(listed)}")
    points: list[tuple[float, ...]] = []
    for point in listed:
        pair = Section(section.path, section.title[1:-1], {"path": point}, ("path",))
        numbers = pair.numbers("path", 2)
        if len(numbers) != 2 or max(map(abs, numbers)) > _FARTHEST_M:
            expected = f"expected points [x, y] within {_FARTHEST_M:g} m"
            raise section.fault("path", f"{expected}, got {one_line(point)}")
        if points and np.hypot(*np.subtract(points[-1], numbers)) < 1e-6:
            place = one_line(list(numbers))
            raise section.fault("path", f"expected neighbours apart, got {place} twice")
        points.append(numbers)
    return np.array(points)


def _look_at(section: Section) -> str | FloatArray | None:
    """A word, or a place (3,) of the plane."""
    if "look_at" not in section:
        return None
    if isinstance(section["look_at"], str):
        return section.text("look_at", (CAMERA,))
    place = np.array(section.numbers("look_at", 3))
    if len(place) != 3 or np.abs(place).max() > _FARTHEST_M:
        expected = f"expected '{CAMERA}' or [x, y, z] within {_FARTHEST_M:g} m"
        raise section.fault("look_at", f"{expected}, got {one_line(place.tolist())}")
    return place


def _layers(path: Path, number: int, section: Section) -> tuple[LayerAsked, ...]:
    if "layers" not in section:
        return ()
    listed = section["layers"]
    if not isinstance(listed, list) or len(listed) > MOST:
        expected = f"expected up to {MOST} [[characters.layers]] tables"
        raise section.fault("layers", f"{expected}, got {one_line(listed)}")
    entries = []
    for entry in listed:
        layer = Section(path, f"characters {number} layers", entry, _LAYER)
        additive: object = False
        if "additive" in layer:
            additive = layer["additive"]
        if not isinstance(additive, bool):
            raise layer.fault("additive", f"expected true or false, got {one_line(additive)}")
        entries.append(
            LayerAsked(
                layer.text("clip"),
                layer.text("joints", MASKS) if "joints" in layer else "upper",
                layer.text("during", LASTING) if "during" in layer else "walk",
                layer.number("weight", 0.0, 1.0) if "weight" in layer else 1.0,
                additive,
            )
        )
    return tuple(entries)


def file_of(part: ScenePart, folder: Path) -> str:
    """The word "mannequin", or the whole name of the file of a character or prop."""
    return part.file if part.file == MANNEQUIN else str((folder / part.file).absolute())


def files_of_scene(path: Path) -> Iterator[Path]:
    """Every file that a scene file names.

    Raises:
        ValueError: see `read_scene`.
    """
    for part in read_scene(path).parts.values():
        if part.file not in ("", MANNEQUIN):
            yield Path(file_of(part, path.absolute().parent))
