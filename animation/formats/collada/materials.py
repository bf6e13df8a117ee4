"""Colours of Collada parts: from the vertices, from a diffuse texture, or from a diffuse colour."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.animation.formats.collada.geometry import PolygonGroup
from motorcade.animation.formats.collada.library import Library
from motorcade.animation.formats.collada.xml import Element
from motorcade.animation.formats.images import Texture, Textures
from motorcade.animation.formats.limits import beside, read_bounded
from motorcade.ga.arrays import FloatArray

__all__ = ["ColladaMaterials"]

PLAIN = (0.8, 0.8, 0.8)
SHADERS = ("phong", "blinn", "lambert", "constant")


class ColladaMaterials:
    """Reads the materials of one document.

    Args:
        library: the document.
        folder: where textures are looked for.
    """

    def __init__(self, library: Library, folder: Path) -> None:
        self._library = library
        self._folder = folder
        self._textures = Textures()

    @property
    def notices(self) -> list[str]:
        """Textures that could not be read."""
        return self._textures.notices

    def colors(self, part: PolygonGroup, instance: Element) -> FloatArray:
        """Colours (V, 3), sRGB, of a part of a mesh, as an instance binds its material."""
        if part.colors is not None:
            return np.clip(part.colors, 0.0, 1.0)
        color, texture = self._diffuse(part.material, instance)
        if texture is not None and part.uv is not None and np.abs(part.uv).max() < 1e6:
            return texture.at(part.uv * (1.0, -1.0) + (0.0, 1.0))
        return np.repeat(np.clip(color, 0.0, 1.0)[None], len(part.vertices), axis=0)

    def _diffuse(self, symbol: str, instance: Element) -> tuple[FloatArray, Texture | None]:
        plain = np.array(PLAIN)
        bound = next(
            (one for one in instance.every("instance_material") if one.get("symbol") == symbol),
            None,
        )
        material = None if bound is None else self._library.find(bound.get("target"))
        link = None if material is None else material.first("instance_effect")
        effect = None if link is None else self._library.find(link.get("url"))
        if effect is None:
            return plain, None
        for shader in SHADERS:
            diffuse = effect.first("profile_COMMON", "technique", shader, "diffuse")
            if diffuse is None:
                continue
            color, texture = diffuse.first("color"), diffuse.first("texture")
            if color is not None:
                values = color.floats()
                return (values[:3] if len(values) >= 3 else plain), None
            if texture is not None:
                return plain, self._texture(effect, texture.get("texture"))
        return plain, None

    def _texture(self, effect: Element, name: str) -> Texture | None:
        """The picture that a sampler of the effect leads to."""
        profile = effect.needed("profile_COMMON")
        for _ in range(2):  # sampler, then surface
            found = next((one for one in profile.all("newparam") if one.get("sid") == name), None)
            if found is None:
                break
            source = next(found.every("source"), None) or next(found.every("init_from"), None)
            if source is None:
                break
            name = source.text.strip()
        image = self._library.find(f"#{name}")
        start = None if image is None else next(image.every("init_from"), None)
        if start is None:
            return None
        return self._picture(start.text.strip())

    def _picture(self, uri: str) -> Texture | None:
        return self._textures.read(uri, lambda: read_bounded(beside(self._folder, uri, "texture")))
