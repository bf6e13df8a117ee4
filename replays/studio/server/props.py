"""What can be put into a scene: the mannequin, and the files that lie beside the scene.

A browser names one of these; no other file is ever read for it.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Character, mannequin
from motorcade.animation.authoring import Scene, ScenePart
from motorcade.replays.characters.acting import MANNEQUIN, character_named
from motorcade.replays.studio.server.filmed import Filmed
from motorcade.replays.studio.server.places import free_place_m

log = logging.getLogger("motorcade.studio")

SUFFIXES = (".glb", ".gltf", ".vrm", ".dae", ".fbx", ".md5mesh")
MOST_FILES = 200
GROUND = "ground"


@dataclass(frozen=True, eq=False)
class Props:
    """Characters and props on offer.

    Args:
        folder: that files are named from: the scene's.
        files: by their names there.
    """

    folder: Path
    files: tuple[str, ...] = ()
    _names: dict[str, list[str]] = field(default_factory=dict)

    def listed(self) -> list[dict[str, str]]:
        """For the page: files with labels, the mannequin first; none that cannot be read."""
        told = [{"file": MANNEQUIN, "label": "Person", "kind": "character"}]
        for file in self.files:
            try:
                kind = self._kind(file)
            except (ValueError, OSError, RuntimeError, ImportError) as fault:
                log.warning("not on offer: %s", " ".join(str(fault).split()))
                continue
            told.append({"file": file, "label": Path(file).stem, "kind": kind})
        return told

    def clips(self, part: ScenePart) -> list[str]:
        """What an object can do: clips of its own, and those that the mannequin lends."""
        if part.kind == "group":
            return []
        if part.file not in self._names:
            who = self._character(part.file)
            own = [clip.name for clip in who.clips]
            lent = [clip.name for clip in mannequin().clips]
            both = [*own, *(name for name in lent if name not in own)]
            self._names[part.file] = both if part.kind == "character" else own
        return self._names[part.file]

    def require_offered(self, line: Mapping[str, Any], scene: Scene) -> None:
        """Refuse an edit that names a file which is neither on offer nor in the scene.

        Raises:
            ValueError: it does.
        """
        given = line.get("object") if line.get("do") == "add" else line
        file = given.get("file") if isinstance(given, Mapping) else None
        known = {MANNEQUIN, *self.files, *(part.file for part in scene.parts.values())}
        if file is not None and (not isinstance(file, str) or file not in known):
            raise ValueError("file: expected one that is on offer")

    def entry(self, file: str, scene: Scene, filmed: Filmed, frame: int = 0) -> dict[str, Any]:
        """An object of a file as the scene's own, near the middle of the first anchor: where
        nothing stands, and in view at a frame if there is such a place.

        Raises:
            ValueError: a file that is not on offer, or cannot be read.
        """
        self.require_offered({"file": file}, scene)
        kind = self._kind(file)
        who = self._character(file)
        label = "Person" if file == MANNEQUIN else Path(file).stem
        anchor = next(iter(scene.anchors))
        ground = filmed.ground(scene.anchors[anchor])
        own = scene.anchors[anchor] == filmed.first
        place = np.array([*(filmed.place_m if own else ground.position_m), 0.0])
        height_m = filmed.height_m if own else ground.height_m
        place[:2] = free_place_m(
            scene, anchor, scene.anchors[anchor], place[:2], height_m, filmed, frame
        )
        plane_T_camera = ground.world_T_plane.inverse() @ filmed.world_T_camera[frame]
        towards = plane_T_camera.translation_m[:2] - place[:2]
        turn = np.degrees(np.arctan2(towards[1], towards[0]))
        entry = {
            "name": free_name(label, scene),
            "kind": kind,
            "file": file,
            "parent": anchor,
            "position_m": place.tolist(),
            "euler_deg": [0.0, 0.0, float(turn)],
        }
        tall = max(who.height_m, float(np.ptp(who.vertices, axis=0).max()))
        if kind == "character":
            entry["height_m"] = height_m
        elif not 0.02 * height_m < tall < 3.0 * height_m:
            entry["height_m"] = 0.4 * height_m * who.height_m / tall
        return entry

    def _kind(self, file: str) -> str:
        return "character" if len(self._character(file).skeleton) > 4 else "prop"

    def _character(self, file: str) -> Character:
        return character_named(file if file == MANNEQUIN else str((self.folder / file).absolute()))


def files_beside(folder: Path) -> tuple[str, ...]:
    """Names of files in a folder that may hold characters or props, in order."""
    if not folder.is_dir():
        return ()
    found = (one for one in folder.iterdir() if one.suffix.lower() in SUFFIXES and one.is_file())
    return tuple(sorted(one.name for one in found))[:MOST_FILES]


def free_name(label: str, scene: Scene) -> str:
    """A name that nothing has."""
    taken: Sequence[str] = [*scene.parents, *scene.anchors]
    if label not in taken:
        return label
    return next(f"{label} {k}" for k in range(2, len(taken) + 3) if f"{label} {k}" not in taken)
