"""What a glTF file that is being written holds: arrays in its buffer, materials, images, morphs."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.appearance import Material, TextureMap, to_linear
from motorcade.animation.character import Character
from motorcade.animation.formats.gltf.materials import MAPS, TRANSFORM, WRAPS
from motorcade.ga.arrays import FloatArray, IntArray

KINDS = {"<f4": 5126, "<u4": 5125, "<u2": 5123, "|u1": 5121}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
GENERATOR = "Motorcade"
"""What files say that are written here: metres, figures on the ground at z = 0 of their space."""

VERTICES, INDICES = 34962, 34963


class BinaryBuffer:
    """Gathers arrays; each becomes a view and an accessor."""

    def __init__(self) -> None:
        self._data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    @property
    def data(self) -> bytes:
        """All arrays, one after the other."""
        return bytes(self._data)

    def add_bytes(self, data: bytes) -> int:
        """Add a file, such as an image; returns the number of its view."""
        self._data += b"\0" * (-len(self._data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self._data), "byteLength": len(data)})
        self._data += data
        return len(self.views) - 1

    def add(
        self, values: ArrayLike, kind: str = "<f4", *, target: int = 0, bounds: bool = False
    ) -> int:
        """Add an array (n,) or (n, width); returns the number of its accessor.

        Args:
            values: what to store.
            kind: NumPy's name of the type to store it as.
            target: what the array is for, where the format wants that said.
            bounds: whether to state the smallest and largest values.
        """
        array: NDArray[Any] = np.ascontiguousarray(values, dtype=kind)
        width = 1 if array.ndim == 1 else array.shape[1]
        self._data += b"\0" * (-len(self._data) % 4)
        view: dict[str, Any] = {
            "buffer": 0,
            "byteOffset": len(self._data),
            "byteLength": array.nbytes,
        }
        if target:
            view["target"] = target
        self._data += array.tobytes()
        accessor: dict[str, Any] = {
            "bufferView": len(self.views),
            "componentType": KINDS[array.dtype.str],
            "count": len(array),
            "type": TYPES[width],
        }
        if bounds:
            columns = array.reshape(len(array), width)
            accessor["min"] = [float(value) for value in columns.min(axis=0)]
            accessor["max"] = [float(value) for value in columns.max(axis=0)]
        self.views.append(view)
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def add_few(self, values: FloatArray, *, bounds: bool = False) -> int:
        """Add an array (n, width) of which most rows are zero: only the others are stored.

        Of an array of zeros the first row stands in the file, for programs that want some data.
        """
        rows = np.flatnonzero(np.any(values != 0.0, axis=1))
        rows = rows if len(rows) else np.zeros(1, dtype=np.int64)
        parts: list[dict[str, Any]] = []
        for part, kind in ((rows, "<u4"), (values[rows], "<f4")):
            parts.append({"bufferView": self.add_bytes(np.asarray(part, dtype=kind).tobytes())})
        accessor: dict[str, Any] = {
            "componentType": KINDS["<f4"],
            "count": len(values),
            "type": TYPES[values.shape[1]],
            "sparse": {
                "count": len(rows),
                "indices": {**parts[0], "componentType": KINDS["<u4"]},
                "values": parts[1],
            },
        }
        if bounds:
            stored = values.astype(np.float32)
            accessor["min"] = [float(value) for value in stored.min(axis=0)]
            accessor["max"] = [float(value) for value in stored.max(axis=0)]
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def write_glb(path: Path, document: dict[str, Any], buffer: BinaryBuffer) -> None:
    """Write a document with its buffer; the file appears whole or not at all.

    Raises OSError: the file cannot be written.
    """
    data = buffer.data + b"\0" * (-len(buffer.data) % 4)
    whole = {
        **document,
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": buffer.views,
        "accessors": buffer.accessors,
    }
    text = json.dumps(whole, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    parts = (
        struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)),
        struct.pack("<I4s", len(text), b"JSON"),
        text,
        struct.pack("<I4s", len(data), b"BIN\0"),
        data,
    )
    unfinished = path.with_name(path.name + ".part")
    try:
        unfinished.write_bytes(b"".join(parts))
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


PLAIN = {"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.9}}
"""The material of a character that has colours alone."""
WRAP_CODES = {name: code for code, name in WRAPS.items()}
MAGNIFY = {"nearest": 9728, "linear": 9729}
MINIFY = {
    ("nearest", None): 9728,
    ("linear", None): 9729,
    ("nearest", "nearest"): 9984,
    ("linear", "nearest"): 9985,
    ("nearest", "linear"): 9986,
    ("linear", "linear"): 9987,
}


class LookWriter:
    """Writes what a character looks like into a document, each image once."""

    def __init__(self, buffer: BinaryBuffer, document: dict[str, Any]) -> None:
        self._buffer, self._document = buffer, document
        self._images: dict[int, int] = {}
        self._materials: dict[int, int] = {}
        self._extensions: set[str] = set()

    def mesh(self, character: Character) -> dict[str, Any]:
        """The mesh, a primitive for each part with a material of its own."""
        look = character.appearance
        if look is None:
            everything = np.arange(len(character.vertices))
            primitive = self._primitive(character, everything, character.triangles, flat=False)
            colors = to_linear(character.colors)
            primitive["attributes"]["COLOR_0"] = self._buffer.add(colors, target=VERTICES)
            primitive["material"] = _number(self._document.setdefault("materials", []), PLAIN)
            return self._with_names(character, [primitive])
        primitives = []
        for part in look.parts:
            if part.stop == part.first:
                continue
            rows, numbers = np.unique(
                character.triangles[part.first : part.stop], return_inverse=True
            )
            primitive = self._primitive(character, rows, numbers.reshape(-1, 3), flat=part.flat)
            for number, uv in enumerate(look.coordinates):
                key = f"TEXCOORD_{number}"
                primitive["attributes"][key] = self._buffer.add(uv[rows], target=VERTICES)
            if look.colors is not None:
                primitive["attributes"]["COLOR_0"] = self._buffer.add(
                    look.colors[rows], target=VERTICES
                )
            if look.tangents is not None and look.tangents[rows, :3].any(axis=1).all():
                primitive["attributes"]["TANGENT"] = self._buffer.add(
                    look.tangents[rows], target=VERTICES
                )
            primitive["material"] = self._material(part.material)
            primitives.append(primitive)
        if self._extensions:
            self._document["extensionsUsed"] = sorted(self._extensions)
        return self._with_names(character, primitives)

    def _with_names(self, character: Character, primitives: list[Any]) -> dict[str, Any]:
        mesh: dict[str, Any] = {"primitives": primitives}
        if character.morphs:
            mesh["weights"] = [target.weight for target in character.morphs]
            mesh["extras"] = {"targetNames": [target.name for target in character.morphs]}
        return mesh

    def _primitive(
        self, character: Character, rows: IntArray, triangles: IntArray, *, flat: bool
    ) -> dict[str, Any]:
        """Vertices (R,) and triangles that count among them."""
        kind = "|u1" if len(character.skeleton) <= 256 else "<u2"
        wide = "<u2" if len(rows) < 2**16 else "<u4"
        add = self._buffer.add
        attributes = {"POSITION": add(character.vertices[rows], target=VERTICES, bounds=True)}
        if not flat:
            attributes["NORMAL"] = add(character.normals[rows], target=VERTICES)
        joints, weights = character.joints, character.weights
        for group in range(joints.shape[1] // 4):
            four = slice(4 * group, 4 * group + 4)
            attributes[f"JOINTS_{group}"] = add(joints[rows, four], kind, target=VERTICES)
            attributes[f"WEIGHTS_{group}"] = add(weights[rows, four], target=VERTICES)
        primitive: dict[str, Any] = {
            "attributes": attributes,
            "indices": add(triangles.reshape(-1), wide, target=INDICES),
        }
        targets = []
        for target in character.morphs:
            whole = np.zeros((2, len(character.vertices), 3))
            whole[0, target.rows], whole[1, target.rows] = target.positions, target.normals
            rest = {"POSITION": self._buffer.add_few(whole[0, rows], bounds=True)}
            if not flat:
                rest["NORMAL"] = self._buffer.add_few(whole[1, rows])
            targets.append(rest)
        if targets:
            primitive["targets"] = targets
        return primitive

    def _material(self, material: Material) -> int:
        if id(material) not in self._materials:
            listed = self._document.setdefault("materials", [])
            self._materials[id(material)] = len(listed)
            listed.append(self._described(material))
        return self._materials[id(material)]

    def _described(self, material: Material) -> dict[str, Any]:
        """A material as it stands in the file."""
        base: dict[str, Any] = {
            "baseColorFactor": list(material.base_color),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        described: dict[str, Any] = {
            "pbrMetallicRoughness": base,
            "alphaMode": material.alpha_mode.upper(),
        }
        if material.name:
            described["name"] = material.name
        if material.alpha_mode == "mask":
            described["alphaCutoff"] = material.alpha_cutoff
        if material.double_sided:
            described["doubleSided"] = True
        strength = max(1.0, *material.emission)
        if any(material.emission):
            described["emissiveFactor"] = [part / strength for part in material.emission]
        extensions: dict[str, Any] = {}
        if strength > 1.0:
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        if material.unlit:
            extensions["KHR_materials_unlit"] = {}
        if extensions:
            self._extensions |= extensions.keys()
            described["extensions"] = extensions
        for key, name in MAPS.items():
            texture = material.maps.get(name)
            if texture is not None:
                holder = base if name in ("base_map", "metallic_roughness_map") else described
                holder[key] = self._link(texture)
        if material.normal_map is not None:
            described["normalTexture"]["scale"] = material.normal_scale
        if material.occlusion_map is not None:
            described["occlusionTexture"]["strength"] = material.occlusion_strength
        return described

    def _link(self, texture_map: TextureMap) -> dict[str, Any]:
        sampler = {
            "magFilter": MAGNIFY[texture_map.magnify],
            "minFilter": MINIFY[texture_map.minify, texture_map.mipmaps],
            "wrapS": WRAP_CODES[texture_map.wrap[0]],
            "wrapT": WRAP_CODES[texture_map.wrap[1]],
        }
        texture = {
            "source": self._image(texture_map),
            "sampler": _number(self._document.setdefault("samplers", []), sampler),
        }
        link: dict[str, Any] = {
            "index": _number(self._document.setdefault("textures", []), texture),
            "texCoord": texture_map.coordinate_set,
        }
        moved = np.array(texture_map.transform)
        if not np.array_equal(moved, np.eye(2, 3)):
            self._extensions.add(TRANSFORM)
            link["extensions"] = {TRANSFORM: _parts_of(moved)}
        return link

    def _image(self, texture_map: TextureMap) -> int:
        if id(texture_map.pixels) not in self._images:
            images = self._document.setdefault("images", [])
            self._images[id(texture_map.pixels)] = len(images)
            data = texture_map.encoded or _as_png(texture_map.pixels)
            kind = "image/png" if data.startswith(b"\x89PNG") else "image/jpeg"
            images.append({"bufferView": self._buffer.add_bytes(data), "mimeType": kind})
        return self._images[id(texture_map.pixels)]


def _number(listed: list[Any], entry: dict[str, Any]) -> int:
    """Where an entry stands in a list, to which it is added if need be."""
    if entry not in listed:
        listed.append(entry)
    return listed.index(entry)


def _parts_of(matrix: NDArray[np.float64]) -> dict[str, Any]:
    """Offset, turn and scale of KHR_texture_transform, from a matrix (2, 3) without shear."""
    turn = float(np.arctan2(-matrix[1, 0], matrix[0, 0]))
    c, s = np.cos(turn), np.sin(turn)
    wide = c * matrix[0, 0] - s * matrix[1, 0]
    high = s * matrix[0, 1] + c * matrix[1, 1]
    return {"offset": matrix[:, 2].tolist(), "rotation": turn, "scale": [float(wide), float(high)]}


def _as_png(pixels: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    png = io.BytesIO()
    Image.fromarray(pixels).save(png, "PNG")
    return png.getvalue()
