"""A second reading of glTF files, written apart from the readers: one node, one time at once.

It follows the specification literally with scipy's rotations and shares no code with the library.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

Array = NDArray[np.float64]
WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
KIND = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


class Witness:
    """Nodes, skins and the animations of a `.glb`."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        (size,) = struct.unpack("<I", data[12:16])
        self.document: dict[str, Any] = json.loads(data[20 : 20 + size])
        self._binary = data[28 + size :]
        self.nodes = self.document["nodes"]
        self.parent = {
            child: node for node, one in enumerate(self.nodes) for child in one.get("children", [])
        }

    def accessor(self, number: int) -> Array:
        given = self.document["accessors"][number]
        view = self.document["bufferViews"][given["bufferView"]]
        kind, width = np.dtype(KIND[given["componentType"]]), WIDTH[given["type"]]
        start = view.get("byteOffset", 0) + given.get("byteOffset", 0)
        flat = np.frombuffer(self._binary, kind, given["count"] * width, start)
        return flat.reshape(-1, width).astype(np.float64)

    def span(self, animation: int = 0) -> tuple[float, float]:
        """First and last key of an animation."""
        given = self.document["animations"][animation]
        times = [self.accessor(sampler["input"]) for sampler in given["samplers"]]
        return min(float(t[0, 0]) for t in times), max(float(t[-1, 0]) for t in times)

    def world(self, time_s: float | None = None, animation: int = 0) -> dict[str, Array]:
        """World matrices (4, 4) of all nodes by name, at rest or at a time of an animation."""
        moved: dict[int, dict[str, Array]] = {}
        if time_s is not None:
            given = self.document["animations"][animation]
            for channel in given["channels"]:
                sampler = given["samplers"][channel["sampler"]]
                times = self.accessor(sampler["input"])[:, 0]
                values = self.accessor(sampler["output"])
                path = channel["target"]["path"]
                at = min(max(time_s, times[0]), times[-1])
                if path == "rotation" and len(times) > 1:
                    value = Slerp(times, Rotation.from_quat(values))(at).as_quat()
                else:
                    value = np.array([np.interp(at, times, column) for column in values.T])
                moved.setdefault(channel["target"]["node"], {})[path] = value
        made: dict[int, Array] = {}

        def place(node: int) -> Array:
            if node not in made:
                local = self._local(self.nodes[node], moved.get(node, {}))
                above = self.parent.get(node)
                made[node] = local if above is None else place(above) @ local
            return made[node]

        return {one.get("name", str(i)): place(i) for i, one in enumerate(self.nodes)}

    @staticmethod
    def _local(node: dict[str, Any], moved: dict[str, Array]) -> Array:
        if "matrix" in node and not moved:
            return np.array(node["matrix"]).reshape(4, 4).T
        made = np.eye(4)
        turn = moved.get("rotation", np.array(node.get("rotation", [0.0, 0.0, 0.0, 1.0])))
        scale = moved.get("scale", np.array(node.get("scale", [1.0, 1.0, 1.0])))
        made[:3, :3] = Rotation.from_quat(turn).as_matrix() * scale
        made[:3, 3] = moved.get("translation", np.array(node.get("translation", [0.0, 0.0, 0.0])))
        return made


def fitted(given: Array, wanted: Array) -> tuple[float, Array, Array]:
    """Scale, rotation (3, 3) and shift (3,) that bring points (n, 3) nearest to others.

    Source: Umeyama, Least-squares estimation of transformation parameters (1991).
    """
    a, b = given - given.mean(0), wanted - wanted.mean(0)
    u, s, vt = np.linalg.svd(b.T @ a)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    turn = u @ sign @ vt
    scale = float(np.sum(s * np.diag(sign)) / np.sum(a * a))
    return scale, turn, wanted.mean(0) - scale * turn @ given.mean(0)
