"""Broken character files: every reader gives its own error or a valid character.

Small files of every format are made here and mutated: bytes, words, JSON values. Where the real
rigs lie in MOTORCADE_DATA, some of them are mutated too.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from motorcade.animation import Character, Clip
from motorcade.animation.formats import FormatError, NoMeshError, read_character, read_motion
from tests.animation.formats import samples
from tests.fuzz.mutations import mutated, one_of
from tests.fuzz.runner import Feed

REAL = [
    "astroboy/astro_maya_dae.glb",
    "md5/Bob.md5mesh",
    "md5/Bob.md5anim",
    "arnaud/run_fbx.glb",
    "bvh/jumping_jacks.bvh",
    "astroboy/astro_maya.dae",
]
REAL_SHARE = 0.01


def prepare(folder: Path) -> Feed:
    """Files of every format, mutated and read."""
    small = [
        (".glb", samples.gltf_tower().glb()),
        (".glb", samples.rich_gltf().glb()),
        (".gltf", samples.rich_gltf().gltf()),
        (".dae", samples.collada_tower("BEZIER")),
        (".dae", samples.collada_tower("STEP")),
        (".md5mesh", samples.md5_mesh_tower()),
        (".md5anim", samples.md5_motion_tower()),
        (".bvh", samples.BVH),
    ]
    data = Path(os.environ.get("MOTORCADE_DATA", "/nowhere")) / "rigs"
    files = [data / name for name in REAL]
    real = [(path.suffix, path.read_bytes()) for path in files if path.is_file()]

    def feed(rng: np.random.Generator) -> str:
        suffix, whole = one_of(real if real and rng.random() < REAL_SHARE else small, rng)
        path = folder / f"given{suffix}"
        path.write_bytes(mutated(suffix, whole, rng))
        return outcome(path)

    return feed


def outcome(path: Path) -> str:
    """Read a file; how it ended. Anything but a FormatError comes through."""
    try:
        character = read_character(path)
    except NoMeshError:
        pass
    except FormatError:
        return "refused"
    else:
        _check(character)
        return "character"
    try:
        motion = read_motion(path)
    except FormatError:
        return "refused"
    for clip in motion.clips:
        _check_clip(clip)
    return "motion"


def _check(character: Character) -> None:
    for name in ("vertices", "normals", "colors", "weights"):
        if not np.isfinite(getattr(character, name)).all():
            raise AssertionError(f"{name} are not finite")
    for clip in character.clips:
        _check_clip(clip)


def _check_clip(clip: Clip) -> None:
    middle = clip.at(0.5 * (clip.time_s[0] + clip.time_s[-1]))
    if not (np.isfinite(clip.poses.coefficients).all() and np.isfinite(middle.coefficients).all()):
        raise AssertionError(f"clip '{clip.name}' is not finite")
