"""The files that a scene names: "mannequin", or glTF, Collada, MD5 and FBX beside the scene."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from motorcade.animation.authoring import ScenePart, read_scene
from motorcade.replays.io.readers.manifest.section import FILE_KNOBS

MANNEQUIN = FILE_KNOBS["placed.character"]


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
