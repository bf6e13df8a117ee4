"""Character and motion files: read by their suffix into frozen values, and written as glTF.

Files are not trusted: sizes, depths and counts are limited (see `limits`), XML entities and
files outside the folder are refused, and whatever is wrong is a `FormatError`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from motorcade.animation.character import Character
from motorcade.animation.formats.bvh import read_bvh
from motorcade.animation.formats.collada import read_collada
from motorcade.animation.formats.fbx import read_fbx
from motorcade.animation.formats.gltf import read_gltf
from motorcade.animation.formats.gltf.write import (
    CameraPath,
    CharacterOnPath,
    write_cast_gltf,
    write_gltf,
)
from motorcade.animation.formats.limits import FormatError, NoMeshError, expected
from motorcade.animation.formats.md5 import read_md5_mesh, read_md5_motion
from motorcade.animation.formats.rig.assemble import (
    SkeletalMotion,
    assemble_character,
    assemble_motion,
)
from motorcade.animation.formats.rig.stance import Wanted
from motorcade.animation.formats.rig.values import Rig
from motorcade.ga.names import did_you_mean

__all__ = [
    "CameraPath",
    "CharacterOnPath",
    "FormatError",
    "NoMeshError",
    "read_character",
    "read_motion",
    "write_cast_gltf",
    "write_gltf",
]


READERS: dict[str, Callable[[Path], Rig]] = {
    ".glb": read_gltf,
    ".gltf": read_gltf,
    ".vrm": read_gltf,
    ".dae": read_collada,
    ".md5mesh": read_md5_mesh,
    ".md5anim": read_md5_motion,
    ".bvh": read_bvh,
    ".fbx": read_fbx,
}
SUFFIXES = tuple(READERS)
"""Suffixes of the files that can be read."""


def read_character(
    path: Path | str,
    *,
    unit_m: float | None = None,
    up: str | None = None,
    front: str | None = None,
    hide: Sequence[str] = (),
) -> Character:
    """Read a skinned mesh with its skeleton and clips: metres, z up, facing +x, soles at z = 0.

    Joint frames are rigid; constant scale of the rig ends in the mesh. `Character.notices`
    says what was left out or assumed.

    Args:
        path: `.glb`, `.gltf`, `.vrm`, `.dae`, `.md5mesh` (with the `.md5anim` of the same name
            beside it) or `.fbx`.
        unit_m: length of the file's unit, where the caller knows better than the file.
        up: the axis of the file that is up, such as "z", likewise.
        front: the axis of the file that the figure faces at rest, such as "-y", likewise.
        hide: names of meshes, or of nodes that bear some, that are left out.

    Raises:
        FormatError: a file that cannot be read, breaks its format or a limit of size, names a
            file outside its folder, has no mesh that joints carry, or none of a name to hide.
        NoMeshError: a FormatError too: the file holds a motion alone.

    >>> from motorcade.animation import read_character
    >>> read_character("figure.docx")
    Traceback (most recent call last):
    motorcade.animation.formats.limits.FormatError: figure.docx: suffix: expected one of .glb, ...
    """
    file = Path(path)
    with _named(file):
        rig = _without(_rig(file, unit_m), hide)
        return assemble_character(rig, Wanted(unit_m, up, front))


def _without(rig: Rig, hide: Sequence[str]) -> Rig:
    """A rig without the surfaces of these names."""
    named = [{surface.name, rig.tree.names[surface.node]} for surface in rig.surfaces]
    for name in hide:
        if not any(name in names for names in named):
            raise FormatError(f"hide: no mesh {name!r}; {did_you_mean(name, set().union(*named))}")
    kept = [not names & set(hide) for names in named]
    surfaces = tuple(surface for surface, keep in zip(rig.surfaces, kept, strict=True) if keep)
    return replace(rig, surfaces=surfaces) if hide else rig


def read_motion(
    path: Path | str,
    *,
    unit_m: float | None = None,
    up: str | None = None,
    front: str | None = None,
) -> SkeletalMotion:
    """Read a skeleton with its clips; meshes are not looked at.

    Args:
        path: any file that `read_character` takes, or `.bvh`, or `.md5anim`.
        unit_m: length of the file's unit, where the caller knows better than the file.
        up: the axis of the file that is up, such as "z", likewise.
        front: the axis of the file that the figure faces at rest, such as "-y", likewise.

    Raises:
        FormatError: see `read_character`; no joints.
    """
    file = Path(path)
    with _named(file):
        return assemble_motion(_rig(file, unit_m), Wanted(unit_m, up, front))


@contextmanager
def _named(file: Path) -> Iterator[None]:
    """Whatever is refused is a FormatError that begins with the name of the file."""
    try:
        yield
    except FormatError as fault:
        raise fault.in_file(file) from fault
    except ValueError as fault:  # what Skeleton, Clip or Character refuse
        raise FormatError(str(fault)).in_file(file) from fault


def _rig(path: Path, unit_m: float | None) -> Rig:
    if unit_m is not None and not 1e-6 <= unit_m <= 1e6:
        raise expected("unit_m", "metres from 1e-6 to 1e6", unit_m)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise expected("suffix", f"one of {', '.join(SUFFIXES)}", path.suffix or "none")
    return reader(path)
