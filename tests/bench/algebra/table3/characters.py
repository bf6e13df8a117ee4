"""Two poses of the paper's three characters: joints and rest poses from the rigs where they are.

The rigs are binary glTF files under ``rigs`` in the folder of recordings; only their list of nodes
is read. Where they are absent, random poses of as many joints stand in: what a blend costs does
not depend on the numbers.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor, Rotor

__all__ = ["BlendedCharacter", "characters", "random_character"]

# The paper names 43 to 54 joints and 4881 to 135976 triangles; its first character is Astroboy.
RIGS = (
    ("Character 1", 43, "astroboy/astro_max_dae.glb"),
    ("Character 2", 53, "arnaud/arnaud_fbx.glb"),
    ("Character 3", 53, "makehuman/mh_male_ge53_135k_dressed.glb"),
)
# How far the second pose turns the joints of the first, at most.
LARGEST_TURN_RAD = 2.0
_JSON_CHUNK = 20


@dataclass(frozen=True)
class BlendedCharacter:
    """Two poses of a character's joints as motors ``(joints,)``, and where they come from."""

    name: str
    source: str
    first: Motor
    second: Motor

    @property
    def joints(self) -> int:
        """How many joints it has."""
        return len(self.first.coefficients)


def characters(folder: Path | None) -> list[BlendedCharacter]:
    """The three characters, by the rigs in `folder` or, where they are absent, random."""
    return [_character(k, *row, folder) for k, row in enumerate(RIGS)]


def random_character(joints: int) -> BlendedCharacter:
    """A character of random poses, the same every time."""
    rng = np.random.default_rng(joints)
    return _posed(f"{joints} joints", "random poses", Motor.random(rng, (joints,)), rng)


def _character(
    seed: int, name: str, joints: int, rig: str, folder: Path | None
) -> BlendedCharacter:
    rng = np.random.default_rng(seed)
    file = folder / "rigs" / rig if folder else None
    if file is not None and file.exists():
        return _posed(name, file.name, _rest_pose(file), rng)
    return _posed(name, "random poses", Motor.random(rng, (joints,)), rng)


def _posed(name: str, source: str, first: Motor, rng: np.random.Generator) -> BlendedCharacter:
    """The character of a pose, and of that pose with every joint turned and moved."""
    axes = rng.normal(size=(len(first.coefficients), 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    half_angles = 0.5 * rng.uniform(0.0, LARGEST_TURN_RAD, (len(axes), 1))
    moves = 0.1 * rng.normal(size=axes.shape)
    moved = Motor.from_rotor_translation(Rotor.exp(half_angles * axes), moves)
    return BlendedCharacter(name, source, first, first @ moved)


def _rest_pose(file: Path) -> Motor:
    """The local rest poses of the joints of a glTF's first skin."""
    content = file.read_bytes()
    (size,) = struct.unpack_from("<I", content, 12)
    tree = json.loads(content[_JSON_CHUNK : _JSON_CHUNK + size])
    nodes = [tree["nodes"][joint] for joint in tree["skins"][0]["joints"]]
    return Motor.stack([_pose(node) for node in nodes])


def _pose(node: dict[str, Any]) -> Motor:
    if "matrix" in node:
        matrix = np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
        matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)
        return Motor.from_matrix(matrix)
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    wxyz = np.array([w, x, y, z]) / np.linalg.norm([w, x, y, z])
    return Motor.from_quaternion_translation(wxyz, node.get("translation", (0.0, 0.0, 0.0)))
