"""Colours of a glTF mesh at its vertices.

Vertex colours, base colour textures and base colour factors are multiplied, in linear light, as
the format says; textures are sampled where the vertices are.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.animation.formats.errors import expected
from motorcade.animation.formats.gltf.accessors import Accessors
from motorcade.animation.formats.gltf.container import Document, load
from motorcade.animation.formats.gltf.fields import floats, integer, table, text
from motorcade.animation.formats.images import Texture, Textures
from motorcade.animation.srgb import to_linear, to_srgb
from motorcade.ga.arrays import FloatArray

__all__ = ["GltfMaterials"]

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
