"""Meshes and skins of a glTF document as surfaces.

Every vertex has one colour. Vertex colours, base colour textures and base colour factors are
multiplied, in linear light, as the format says; textures are sampled where the vertices are.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.animation.formats.errors import FormatError, expected
from motorcade.animation.formats.gltf.accessors import Accessors
from motorcade.animation.formats.gltf.container import (
    Document,
    floats,
    integer,
    listed,
    load,
    table,
    text,
)
from motorcade.animation.formats.gltf.nodes import Nodes
from motorcade.animation.formats.images import Texture, Textures
from motorcade.animation.formats.limits import MAX_VERTICES, check_count
from motorcade.animation.formats.rig.values import RigSurface, Skin
from motorcade.animation.srgb import to_linear, to_srgb
from motorcade.ga.arrays import FloatArray, IntArray

STRIP, FAN, TRIANGLES = 5, 6, 4
"""Primitive modes of glTF."""
PLAIN = 0.6
"""Linear grey in the place of a texture that is missing."""
SPECULAR = "KHR_materials_pbrSpecularGlossiness"


class GltfMaterials:
    """Reads the materials of one document; textures are decoded once.

    Args:
        document: whose materials.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self._textures = Textures()

    @property
    def notices(self) -> list[str]:
        """Textures that could not be read."""
        return self._textures.notices

    def colors(
        self,
        part: dict[str, Any],
        attributes: dict[str, Any],
        accessors: Accessors,
        name: str,
        count: int,
    ) -> FloatArray:
        """Colours (V, 3), sRGB, of a mesh primitive."""
        factor, texture, coordinates = self._base(part, name)
        linear = np.repeat(factor[None], count, axis=0)
        if "COLOR_0" in attributes:
            linear *= self._vertex_colors(attributes["COLOR_0"], accessors, name, count)
        if texture is not None and f"TEXCOORD_{coordinates}" in attributes:
            field = f"'{name}'.TEXCOORD_{coordinates}"
            uv = accessors.floats(attributes[f"TEXCOORD_{coordinates}"], field, "VEC2")
            if len(uv) != count or np.abs(uv).max() > 1e6:
                raise expected(field, f"{count} values up to 1e6", len(uv))
            linear *= to_linear(texture.at(uv))
        return to_srgb(linear)

    def _vertex_colors(
        self, index: object, accessors: Accessors, name: str, count: int
    ) -> FloatArray:
        number = integer(index, f"'{name}'.COLOR_0", 0, 1 << 30)
        entry = self._document.entry("accessors", number, f"'{name}'.COLOR_0")
        kind = "VEC3" if entry.get("type") == "VEC3" else "VEC4"
        values = accessors.floats(number, f"'{name}'.COLOR_0", kind)
        if len(values) != count:
            raise expected(f"'{name}'.COLOR_0", f"{count} values", len(values))
        return np.clip(values[:, :3], 0.0, 1.0)

    def _base(self, part: dict[str, Any], name: str) -> tuple[FloatArray, Texture | None, int]:
        """Base colour (3,) in linear light, texture, and which coordinates it goes by."""
        factor = np.ones(3)
        if "material" not in part:
            return factor, None, 0
        material = self._document.entry("materials", part["material"], f"'{name}'.material")
        base = table(material.get("pbrMetallicRoughness", {}), "pbrMetallicRoughness")
        key, image = "baseColorFactor", "baseColorTexture"
        extensions = table(material.get("extensions", {}), "material.extensions")
        if SPECULAR in extensions and not (base.keys() & {key, image}):
            base = table(extensions[SPECULAR], SPECULAR)
            key, image = "diffuseFactor", "diffuseTexture"
        if key in base:
            factor = np.clip(floats(base[key], key, 4)[:3], 0.0, 1.0)
        if image not in base:
            return factor, None, 0
        link = table(base[image], image)
        coordinates = integer(link.get("texCoord", 0), f"{image}.texCoord", 0, 15)
        texture = self._document.entry("textures", link.get("index"), f"{image}.index")
        if "source" not in texture:
            return factor, None, 0
        source = integer(texture["source"], "texture.source", 0, 1 << 30)
        picture = self._texture(source)
        return (factor * PLAIN if picture is None else factor), picture, coordinates

    def _texture(self, source: int) -> Texture | None:
        image = self._document.entry("images", source, "texture.source")
        name = str(image.get("uri", image.get("name", source)))[:100]
        return self._textures.read(
            name, lambda: self._bytes(image, f"images[{source}]"), str(source)
        )

    def _bytes(self, image: dict[str, Any], field: str) -> bytes:
        if "uri" in image:
            return load(text(image["uri"], f"{field}.uri"), self._document.folder, f"{field}.uri")
        view = self._document.entry("bufferViews", image.get("bufferView"), f"{field}.bufferView")
        buffers = self._document.buffers
        data = buffers[integer(view.get("buffer"), f"{field}.buffer", 0, len(buffers) - 1)]
        start = integer(view.get("byteOffset", 0), f"{field}.byteOffset", 0, len(data))
        size = integer(view.get("byteLength"), f"{field}.byteLength", 1, len(data) - start)
        return data[start : start + size]


class Meshes:
    """Reads the surfaces of one document; `notices` gathers what was left out.

    Args:
        document: whose meshes.
        accessors: its arrays.
        nodes: its nodes.
    """

    def __init__(self, document: Document, accessors: Accessors, nodes: Nodes) -> None:
        self._document = document
        self._accessors = accessors
        self._nodes = nodes
        self._materials = GltfMaterials(document)
        self._morphs = 0
        self._lines = 0
        self._total = 0

    @property
    def notices(self) -> list[str]:
        """What was left out or assumed."""
        notices = list(self._materials.notices)
        if self._morphs:
            notices.append(f"morph targets of {self._morphs} meshes are left out")
        if self._lines:
            notices.append(f"{self._lines} meshes of points or lines are left out")
        return notices

    def surfaces(self) -> tuple[tuple[RigSurface, ...], tuple[int, ...]]:
        """Surfaces of every node with a mesh, and the nodes that skins call joints.

        Raises:
            FormatError: attributes that are missing, of the wrong type or length, or out of range.
        """
        skins: dict[int, Skin] = {}
        joints: set[int] = set()
        for number in range(len(self._document.entries("skins"))):
            skins[number] = self._skin(number)
            joints.update(skins[number].nodes.tolist())
        made = []
        for node, given in enumerate(self._nodes.given):
            if "mesh" not in given:
                continue
            mesh = self._document.entry("meshes", given["mesh"], f"node {node} mesh")
            skin = None
            if "skin" in given:
                skin = skins[integer(given["skin"], f"node {node} skin", 0, len(skins) - 1)]
            name = str(given.get("name") or mesh.get("name") or f"mesh {given['mesh']}")[:100]
            for part in listed(mesh.get("primitives"), f"mesh '{name}'.primitives"):
                surface = self._surface(table(part, f"mesh '{name}'"), name, node, skin)
                if surface is not None:
                    made.append(surface)
        return tuple(made), tuple(sorted(joints))

    def _skin(self, number: int) -> Skin:
        given = table(self._document.entries("skins")[number], f"skins[{number}]")
        field = f"skins[{number}].joints"
        count = len(self._nodes.number)
        listed_joints = [
            integer(one, field, 0, count - 1) for one in listed(given.get("joints"), field)
        ]
        if not listed_joints or len(set(listed_joints)) < len(listed_joints):
            raise expected(field, "one or more different nodes", given.get("joints"))
        nodes = self._nodes.number[listed_joints]
        matrices = np.repeat(np.eye(4)[None], len(nodes), axis=0)
        if "inverseBindMatrices" in given:
            field = f"skins[{number}].inverseBindMatrices"
            read = self._accessors.floats(given["inverseBindMatrices"], field, "MAT4")
            if len(read) < len(nodes) or np.abs(read).max() > 1e9:
                raise expected(field, f"{len(nodes)} matrices of numbers up to 1e9", len(read))
            matrices = read[: len(nodes)].reshape(-1, 4, 4).swapaxes(1, 2)
        return Skin(nodes, matrices)

    def _surface(
        self, part: dict[str, Any], name: str, node: int, skin: Skin | None
    ) -> RigSurface | None:
        mode = integer(part.get("mode", TRIANGLES), f"mesh '{name}'.mode", 0, 6)
        if mode not in (TRIANGLES, STRIP, FAN):
            self._lines += 1
            return None
        self._morphs += "targets" in part
        given = table(part.get("attributes"), f"mesh '{name}'.attributes")
        if "KHR_draco_mesh_compression" in table(part.get("extensions", {}), "extensions"):
            raise expected(f"mesh '{name}'", "plain data", "KHR_draco_mesh_compression")
        if "POSITION" not in given:
            raise expected(f"mesh '{name}'.attributes", "POSITION", sorted(given))
        vertices = self._accessors.floats(given["POSITION"], f"'{name}'.POSITION", "VEC3")
        count = len(vertices)
        if np.abs(vertices).max() > 1e9:
            raise expected(f"'{name}'.POSITION", "numbers up to 1e9", np.abs(vertices).max())
        normals = None
        if "NORMAL" in given:
            normals = self._same(given["NORMAL"], f"'{name}'.NORMAL", "VEC3", count)
        triangles = self._triangles(part, name, count, mode)
        self._total += max(count, len(triangles))
        check_count("vertices and triangles", self._total, MAX_VERTICES)
        colors = self._materials.colors(part, given, self._accessors, name, count)
        if skin is None:
            return RigSurface(name, node, vertices, normals, triangles, colors)
        numbers, weights = self._influences(given, name, count, len(skin.nodes))
        return RigSurface(name, node, vertices, normals, triangles, colors, skin, numbers, weights)

    def _same(self, index: object, field: str, kind: str, count: int) -> FloatArray:
        values = self._accessors.floats(index, field, kind)
        if len(values) != count:
            raise expected(field, f"{count} values", len(values))
        return values

    def _triangles(self, part: dict[str, Any], name: str, count: int, mode: int) -> IntArray:
        if "indices" in part:
            field = f"'{name}'.indices"
            run = self._accessors.integers(part["indices"], field, "SCALAR")
            if run.min() < 0 or run.max() >= count:
                raise expected(field, f"numbers below {count}", run.max())
        else:
            run = np.arange(count)
        if mode == TRIANGLES:
            return run[: len(run) - len(run) % 3].reshape(-1, 3)
        if len(run) < 3:
            return np.zeros((0, 3), dtype=np.int64)
        if mode == FAN:
            first = np.full(len(run) - 2, run[0])
            return np.stack([first, run[1:-1], run[2:]], axis=1)
        made = np.stack([run[:-2], run[1:-1], run[2:]], axis=1)
        made[1::2] = made[1::2, ::-1]
        return made

    def _influences(
        self, given: dict[str, Any], name: str, count: int, joints: int
    ) -> tuple[IntArray, FloatArray]:
        numbers, weights = [], []
        for group in range(16):
            if f"JOINTS_{group}" not in given:
                break
            field = f"'{name}'.JOINTS_{group}"
            these = self._accessors.integers(given[f"JOINTS_{group}"], field, "VEC4")
            field = f"'{name}'.WEIGHTS_{group}"
            shares = self._same(given.get(f"WEIGHTS_{group}"), field, "VEC4", count)
            if len(these) != count:
                raise expected(field, f"{count} values", len(these))
            numbers.append(these)
            weights.append(shares)
        if not numbers:
            raise FormatError(f"'{name}': expected JOINTS_0 on a mesh with a skin, got none")
        all_numbers, all_weights = np.concatenate(numbers, 1), np.concatenate(weights, 1)
        used = all_weights != 0.0
        if np.any((all_numbers >= joints) & used) or np.any(all_numbers < 0):
            raise expected(f"'{name}'.JOINTS", f"numbers below {joints}", all_numbers.max())
        return np.where(used, all_numbers, 0), all_weights
