"""The nodes of a glTF file that is being written: characters, a camera and points in one world.

Character space (z up, facing +x) becomes glTF's (y up, facing +z) by one node above all others.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.character import Character
from motorcade.animation.formats.gltf.writing.binary import (
    GENERATOR,
    VERTICES,
    BinaryBuffer,
    write_glb,
)
from motorcade.animation.formats.gltf.writing.looks import LookWriter
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

UPRIGHT_XYZW = [-0.5, -0.5, -0.5, 0.5]
"""From z up, facing +x, to y up, facing +z: x, y, z become z, x, y."""
LOOKING = Rotor.from_rotation_vector((np.pi, 0.0, 0.0))
"""From OpenCV's camera axes (z ahead, y down) to glTF's (z back, y up)."""


@dataclass(frozen=True)
class NodeNumbers:
    """Where a character stands among a document's nodes: its first joint, and what carries it."""

    first: int
    path: int


class SceneWriter:
    """A document that is being put together; `buffer` takes its arrays."""

    def __init__(self) -> None:
        self.buffer = BinaryBuffer()
        self._world: dict[str, Any] = {"name": "world", "rotation": UPRIGHT_XYZW, "children": []}
        self._document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": GENERATOR},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [self._world],
            "skins": [],
            "meshes": [],
        }
        self._looks = LookWriter(self.buffer, self._document)

    def add(self, character: Character, *, on_path: bool, name: str = "") -> NodeNumbers:
        """Joints, skin and mesh of a character, below a node that a path may move."""
        document, skeleton = self._document, character.skeleton
        nodes, label = document["nodes"], f"{name} " if name else ""
        above = self._world
        if on_path:
            self._world["children"].append(len(nodes))
            above = {"name": f"{label}path", "children": []}
            nodes.append(above)
        first = len(nodes)
        wxyz, places = skeleton.rest.as_quaternion_translation()
        for joint, parent in enumerate(skeleton.parents.tolist()):
            holder = above if parent < 0 else nodes[first + parent]
            holder.setdefault("children", []).append(first + joint)
            node = {
                "name": f"{label}{skeleton.names[joint]}",
                "rotation": wxyz[joint, [1, 2, 3, 0]].tolist(),
                "translation": places[joint].tolist(),
            }
            nodes.append(node)
        mesh = {"name": f"{label}mesh", "mesh": len(document["meshes"])}
        document["scenes"][0]["nodes"].append(len(nodes))
        nodes.append(mesh | {"skin": len(document["skins"])})
        columns = skeleton.rest_world_inverse.as_matrix().swapaxes(1, 2).reshape(-1, 16)
        joints = list(range(first, first + len(skeleton)))
        binds = self.buffer.add(columns)
        document["skins"].append({"joints": joints, "inverseBindMatrices": binds})
        document["meshes"].append(self._looks.mesh(character))
        return NodeNumbers(first, first - 1)

    def add_camera(self, vertical_field_rad: float, aspect: float) -> int:
        """A camera's node, below the world."""
        lens = {"yfov": vertical_field_rad, "aspectRatio": aspect, "znear": 0.01}
        self._document["cameras"] = [{"type": "perspective", "perspective": lens}]
        return self._add_below({"name": "camera", "camera": 0})

    def add_points(self, points_m: FloatArray) -> None:
        """A cloud of points below the world's node."""
        place = self.buffer.add(points_m, target=VERTICES, bounds=True)
        meshes = self._document["meshes"]
        meshes.append({"primitives": [{"attributes": {"POSITION": place}, "mode": 0}]})
        self._add_below({"name": "map", "mesh": len(meshes) - 1})

    def animate(self, animation: dict[str, Any]) -> None:
        """Add an animation."""
        self._document.setdefault("animations", []).append(animation)

    def write(self, path: Path) -> None:
        """Write the file; raises OSError as `write_glb` does."""
        write_glb(path, self._document, self.buffer)

    def _add_below(self, node: dict[str, Any]) -> int:
        nodes = self._document["nodes"]
        self._world["children"].append(len(nodes))
        nodes.append(node)
        return len(nodes) - 1
