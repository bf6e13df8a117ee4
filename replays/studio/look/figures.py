"""Characters for a page: each as glTF, with the poses of its joints at every frame."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Character, write_gltf
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import off_record, read_bounded
from motorcade.render import Performer
from motorcade.replays.studio.look.packing import packed, packed_smooth, text
from motorcade.replays.studio.look.paths import rows_of

FINEST = 2e-4
"""Of joints, in the character's metres: half of it shows nowhere that a character is seen whole."""
GLTF_LIMIT = 256 * 2**20
"""Bytes of a character as it is written here."""


def shown_character(name: str, figure: Performer, time_ns: IntArray) -> dict[str, Any]:
    """A character as the film draws it at the stamps ``(F,)``, its clip begun at the first.

    Joints are told in the character's space, so that no number is large wherever it stands.
    """
    since_s = 1e-9 * (time_ns - time_ns[0])
    world = figure.character.skeleton.world(figure.clip.at(since_s))
    weights = figure.clip.morph_weights(since_s)
    stands = figure.world_T_character(time_ns)
    seen = figure.visible_s
    return {
        "name": name,
        "gltf": text(gltf_bytes(figure.character)),
        "joints": packed_smooth(_rows(world), FINEST),
        "morphs": None if weights is None else packed(weights),
        "world_T_character": packed(_rows(stands), "f64"),
        "visible_s": None if seen is None else [float(one) for one in seen],
        "height_m": float(stands.as_motor_scale()[1][0]) * figure.character.height_m,
    }


def gltf_bytes(character: Character) -> bytes:
    """The character's mesh, skeleton and materials as `.glb`, without clips."""
    with tempfile.TemporaryDirectory() as folder, off_record():  # a file of our own
        path = Path(folder, "character.glb")
        write_gltf(path, character, [])
        return read_bounded(path, GLTF_LIMIT)


def _rows(poses: Motor | Similarity) -> FloatArray:
    """Poses ``(*, 8)``: x y z, w x y z, scale."""
    if isinstance(poses, Motor):
        rows = rows_of(poses)
        return np.concatenate([rows, np.ones_like(rows[..., :1])], axis=-1)
    rigid, scale = poses.as_motor_scale()
    return np.concatenate([rows_of(rigid), scale[..., None]], axis=-1)
