"""Vertices of a glTF file at a time, evaluated from its bytes: the witness of readers and skinning.

It follows the specification word by word, with matrices and scipy's rotations, and shares no code
with the library: no similarities, no clips that are sampled anew, no bind pose of its own.
"""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

__all__ = ["GltfVertices"]

Array = NDArray[np.float64]
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


class GltfVertices:
    """The scene that a `.glb` or `.gltf` shows."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        binary = b""
        if data[:4] == b"glTF":
            (size,) = struct.unpack("<I", data[12:16])
            data, binary = data[20 : 20 + size], data[28 + size :]
        self.document: dict[str, Any] = json.loads(data)
        self._buffers = [self._buffer(one, binary, path) for one in self.document["buffers"]]
        self._nodes = self.document["nodes"]
        self._known: dict[str, Any] = {}
        self._parent = {
            child: node for node, one in enumerate(self._nodes) for child in one.get("children", [])
        }

    @staticmethod
    def _buffer(given: dict[str, Any], binary: bytes, path: Path) -> bytes:
        uri = given.get("uri")
        if uri is None:
            return binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        return (path.parent / uri).read_bytes()

    def _view(self, view: int, kind: str, count: int, width: int, offset: int) -> Array:
        given = self.document["bufferViews"][view]
        dtype = np.dtype(kind)
        stride = given.get("byteStride", dtype.itemsize * width)
        start = given.get("byteOffset", 0) + offset
        buffer = self._buffers[given["buffer"]]
        return np.array(
            [np.frombuffer(buffer, dtype, width, start + row * stride) for row in range(count)]
        ).astype(np.float64)

    def accessor(self, number: int) -> Array:
        """Values (n, width)."""
        given = self.document["accessors"][number]
        width, kind = WIDTHS[given["type"]], KINDS[given["componentType"]]
        made = np.zeros((given["count"], width))
        if "bufferView" in given:
            offset = given.get("byteOffset", 0)
            made = self._view(given["bufferView"], kind, given["count"], width, offset)
        sparse = given.get("sparse")
        if sparse is not None:
            at, new = sparse["indices"], sparse["values"]
            rows = self._view(
                at["bufferView"], KINDS[at["componentType"]], sparse["count"], 1,
                at.get("byteOffset", 0),
            )  # fmt: skip
            made[rows[:, 0].astype(int)] = self._view(
                new["bufferView"], kind, sparse["count"], width, new.get("byteOffset", 0)
            )
        if given.get("normalized"):
            made = np.maximum(made / np.iinfo(kind).max, -1.0)
        return made

    def animations(self) -> list[tuple[int, Array]]:
        """Number and key times of each animation that moves a node or a weight."""
        made = []
        for number, given in enumerate(self.document.get("animations", [])):
            keys = [
                self.accessor(given["samplers"][one["sampler"]]["input"])[:, 0]
                for one in given["channels"]
                if "node" in one["target"] and one["target"]["path"] != "pointer"
            ]
            if keys:
                made.append((number, np.unique(np.concatenate(keys))))
        return made

    def _moved(self, animation: int, time_s: float) -> dict[int, dict[str, Array]]:
        given = self.document["animations"][animation]
        moved: dict[int, dict[str, Array]] = {}
        for channel in given["channels"]:
            sampler, target = given["samplers"][channel["sampler"]], channel["target"]
            if "node" not in target:
                continue
            value = self._sampled(sampler, target["path"], time_s)
            moved.setdefault(target["node"], {})[target["path"]] = value
        return moved

    def _sampled(self, sampler: dict[str, Any], path: str, time_s: float) -> Array:
        key = f"{sampler['input']} {sampler['output']}"
        if key not in self._known:
            self._known[key] = (
                self.accessor(sampler["input"])[:, 0],
                self.accessor(sampler["output"]),
            )
        keys, values = self._known[key]
        kind = sampler.get("interpolation", "LINEAR")
        values = values.reshape(len(keys), 3 if kind == "CUBICSPLINE" else 1, -1)
        time_s = float(np.clip(time_s, keys[0], keys[-1]))
        after = int(np.clip(np.searchsorted(keys, time_s, side="right"), 1, len(keys) - 1))
        before = after - 1
        if len(keys) == 1 or (time_s >= keys[-1] and kind != "LINEAR"):
            return np.asarray(values[-1, values.shape[1] // 2])
        step = float(keys[after] - keys[before])
        t = (time_s - float(keys[before])) / step
        if kind == "STEP":
            return np.asarray(values[before, 0])
        if kind == "CUBICSPLINE":
            a, out = values[before, 1], values[before, 2] * step
            b, into = values[after, 1], values[after, 0] * step
            made = (2 * t**3 - 3 * t**2 + 1) * a + (t**3 - 2 * t**2 + t) * out
            made = made + (3 * t**2 - 2 * t**3) * b + (t**3 - t**2) * into
            return made / np.linalg.norm(made) if path == "rotation" else made
        a, b = values[before, 0], values[after, 0]
        if path != "rotation":
            return (1.0 - t) * a + t * b
        first = Rotation.from_quat(a)
        way = (first.inv() * Rotation.from_quat(b)).as_rotvec()
        return (first * Rotation.from_rotvec(t * way)).as_quat()

    def _worlds(self, moved: dict[int, dict[str, Array]]) -> list[Array]:
        made: dict[int, Array] = {}

        def place(node: int) -> Array:
            if node not in made:
                above = self._parent.get(node)
                local = self._local(self._nodes[node], moved.get(node, {}))
                made[node] = local if above is None else place(above) @ local
            return made[node]

        return [place(node) for node in range(len(self._nodes))]

    @staticmethod
    def _local(node: dict[str, Any], moved: dict[str, Array]) -> Array:
        if "matrix" in node:
            return np.array(node["matrix"]).reshape(4, 4).T
        turn = moved.get("rotation", np.array(node.get("rotation", [0.0, 0.0, 0.0, 1.0])))
        scale = moved.get("scale", np.array(node.get("scale", [1.0, 1.0, 1.0])))
        made = np.eye(4)
        made[:3, :3] = Rotation.from_quat(turn).as_matrix() * scale
        made[:3, 3] = moved.get("translation", np.array(node.get("translation", [0.0, 0.0, 0.0])))
        return made

    def order(self) -> list[int]:
        """Shown nodes with a mesh, as listed; branch by branch where children stand first."""
        scene = self.document["scenes"][self.document.get("scene", 0)]["nodes"]
        if all(above < node for node, above in self._parent.items()):
            every = list(range(len(self._nodes)))
        else:
            every, waiting = [], [k for k in range(len(self._nodes)) if k not in self._parent][::-1]
            while waiting:
                every.append(waiting.pop())
                waiting += self._nodes[every[-1]].get("children", [])[::-1]
        shown, waiting = set(), list(scene)
        while waiting:
            shown.add(waiting.pop())
            waiting += [
                child
                for node in shown
                for child in self._nodes[node].get("children", [])
                if child not in shown
            ]
        return [node for node in every if "mesh" in self._nodes[node] and node in shown]

    def at(self, time_s: float | None = None, animation: int = 0) -> Array:
        """Vertices (V, 3) of triangles, in the axes and the unit of the file; None is the rest."""
        moved = {} if time_s is None else self._moved(animation, time_s)
        worlds, made = self._worlds(moved), []
        for node in self.order():
            given = self._nodes[node]
            mesh = self.document["meshes"][given["mesh"]]
            weights = moved.get(node, {}).get("weights", given.get("weights", mesh.get("weights")))
            for number, part in enumerate(mesh["primitives"]):
                if part.get("mode", 4) < 4:
                    continue
                points = self._points(f"{given['mesh']} {number}", part, weights)
                whole = np.column_stack([points, np.ones(len(points))])
                if "skin" in given:
                    each = self._skinned(given["skin"], part, worlds)
                    made.append(np.einsum("vij,vj->vi", each, whole)[:, :3])
                else:
                    made.append((whole @ worlds[node].T)[:, :3])
        return np.concatenate(made)

    def _cached(self, number: int) -> Array:
        key = f"accessor {number}"
        if key not in self._known:
            self._known[key] = self.accessor(number)
        return np.asarray(self._known[key])

    def _points(self, key: str, part: dict[str, Any], weights: Any) -> Array:
        points = self._cached(part["attributes"]["POSITION"]).copy()
        for share, target in zip(
            [] if weights is None else weights, part.get("targets", []), strict=False
        ):
            if "POSITION" in target:
                points += share * self._cached(target["POSITION"])
        return points

    def _skinned(self, skin: int, part: dict[str, Any], worlds: list[Array]) -> Array:
        """What carries each vertex, (V, 4, 4)."""
        given = self.document["skins"][skin]
        joints = np.array([worlds[joint] for joint in given["joints"]])
        if "inverseBindMatrices" in given:
            binds = self._cached(given["inverseBindMatrices"])[: len(joints)]
            joints = joints @ binds.reshape(-1, 4, 4).swapaxes(1, 2)
        attributes, total, made = part["attributes"], 0.0, 0.0
        for group in range(8):
            if f"JOINTS_{group}" not in attributes:
                break
            numbers = self._cached(attributes[f"JOINTS_{group}"]).astype(int)
            shares = self._cached(attributes[f"WEIGHTS_{group}"])
            made = made + np.einsum("vk,vkij->vij", shares, joints[numbers])
            total = total + shares.sum(axis=1)
        return np.asarray(made / np.asarray(total)[:, None, None])
