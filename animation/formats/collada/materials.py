"""Materials of a Collada document, as metallic-roughness has them.

Colours are sRGB, by habit of the programs that write them. What Phong, Blinn and Lambert say
becomes a dielectric of the diffuse colour whose roughness follows from the exponent of its
highlight; its own specular colour, and images for anything but colour, transparency and emission,
are left out.

Sources: Khronos Group, COLLADA 1.4.1. Roughness is that whose GGX lobe is as high as Blinn's of
exponent n: α² = 2 / (n + 2), α its square (Walter et al., Microfacet models for refraction, 2007).
Phong's exponent is a quarter of Blinn's (Fisher and Woo, R.E versus N.H specular highlights, 1994).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.appearance import Filter, Material, TextureMap, Wrap, to_linear
from motorcade.animation.formats.collada.library import Element, Library
from motorcade.animation.formats.images import Texture, Textures
from motorcade.animation.formats.limits import image_beside, read_bounded, shown
from motorcade.ga.arrays import FloatArray

PLAIN = (0.8, 0.8, 0.8)
SHADERS = ("phong", "blinn", "lambert", "constant")
WRAPS: dict[str, Wrap] = {"WRAP": "repeat", "MIRROR": "mirror"}
BLINN_OF_PHONG = 4.0
LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
"""Of the specification, for transparency by colour."""


def roughness_of(exponent: float) -> float:
    """Roughness of the GGX lobe that is as high as Blinn's of an exponent.

    >>> roughness_of(0.0), round(roughness_of(30.0), 3)
    (1.0, 0.5)
    """
    return float((2.0 / (max(exponent, 0.0) + 2.0)) ** 0.25)


class ColladaMaterials:
    """Reads the materials of one document, each once; textures are looked for in `folder`."""

    def __init__(self, library: Library, folder: Path) -> None:
        self._library = library
        self._folder = folder
        self._textures = Textures()
        self._made: dict[str, Material] = {}
        self._lost: set[str] = set()

    @property
    def notices(self) -> list[str]:
        """Textures that could not be read, and what is not drawn."""
        notes = list(self._textures.notices)
        if self._lost:
            notes.append(f"materials are drawn without {shown(', '.join(sorted(self._lost)), 400)}")
        return notes

    def material(self, symbol: str, instance: Element) -> Material:
        """What an instance of a mesh binds to a symbol; plain grey where that is nothing."""
        bound = next(
            (one for one in instance.every("instance_material") if one.get("symbol") == symbol),
            None,
        )
        target = "" if bound is None else bound.get("target")
        if target not in self._made:
            self._made[target] = self._material(target)
        return self._made[target]

    def _material(self, target: str) -> Material:
        entry = self._library.find(target)
        link = None if entry is None else entry.first("instance_effect")
        effect = None if link is None else self._library.find(link.get("url"))
        name = "" if entry is None else (entry.get("name") or entry.get("id"))[:100]
        plain = Material(name, (*to_linear(np.array(PLAIN)).tolist(), 1.0), 0.0)
        technique = None if effect is None else effect.first("profile_COMMON", "technique")
        if effect is None or technique is None:
            return plain
        for kind in SHADERS:
            shader = technique.first(kind)
            if shader is not None:
                return self._shaded(plain, effect, kind, shader)
        return plain

    def _shaded(self, plain: Material, effect: Element, kind: str, shader: Element) -> Material:
        color, image = self._value(effect, shader.first("diffuse"))
        glow, lamp = self._value(effect, shader.first("emission"))
        if kind == "constant" and shader.first("diffuse") is None:
            color, image, glow, lamp = glow, lamp, None, None
        base = np.array(plain.base_color[:3])
        if image is not None:
            base = np.ones(3)
        elif color is not None:
            base = to_linear(np.clip(color[:3], 0.0, 1.0))
        alpha, see_through = self._alpha(effect, shader, image, plain.name)
        emission = (0.0, 0.0, 0.0) if glow is None else to_linear(np.clip(glow[:3], 0, 1)).tolist()
        self._note_left_out(effect, shader)
        return replace(
            plain,
            base_color=(*base.tolist(), alpha),
            base_map=image,
            roughness=_roughness(kind, shader),
            emission=(1.0, 1.0, 1.0) if lamp is not None else tuple(emission),
            emission_map=lamp,
            alpha_mode="blend" if alpha < 1.0 or see_through else "opaque",
            double_sided=_is_double_sided(effect),
            unlit=kind == "constant",
        )

    def _alpha(
        self, effect: Element, shader: Element, image: TextureMap | None, name: str
    ) -> tuple[float, bool]:
        """Opacity, and whether the image's own alpha is meant."""
        transparent = shader.first("transparent")
        share = _number(shader.first("transparency"), 1.0)
        if transparent is None:
            return 1.0, False
        color, veil = self._value(effect, transparent)
        if veil is not None:
            own = image is not None and veil.pixels is image.pixels
            if not own:
                self._lost.add("images of transparency")
            return 1.0, own and bool((veil.pixels[..., 3] < 255).any())
        tint = np.ones(4) if color is None or len(color) < 4 else color[:4]
        alpha = float(tint[3]) * share
        if transparent.get("opaque") == "RGB_ZERO":
            alpha = 1.0 - float(LUMINANCE @ tint[:3]) * share
        if not alpha > 0.0:  # programs differ on which end is clear; nobody draws what is not seen
            self._lost.add(f"the transparency of '{shown(name, 40)}', which would hide it")
            return 1.0, False
        return min(alpha, 1.0), False

    def _note_left_out(self, effect: Element, shader: Element) -> None:
        """Note what is left out."""
        for name in ("specular", "ambient", "reflective", "shininess"):
            if shader.first(name, "texture") is not None:
                self._lost.add(f"images of {name} light" if name != "shininess" else name)
        if next(effect.every("bump"), None) is not None:
            self._lost.add("bump maps")

    def _value(
        self, effect: Element, element: Element | None
    ) -> tuple[FloatArray | None, TextureMap | None]:
        """A colour of three numbers or more, or an image."""
        if element is None:
            return None, None
        color, texture = element.first("color"), element.first("texture")
        if color is not None:
            values = color.floats()
            return (values if len(values) >= 3 else None), None
        return None, None if texture is None else self._map(effect, texture.get("texture"))

    def _map(self, effect: Element, name: str) -> TextureMap | None:
        """The image that a sampler of the effect leads to, as it says."""
        profile = effect.needed("profile_COMMON")
        sampler: Element | None = None
        for _ in range(2):  # sampler, then surface
            parameter = next(
                (one for one in profile.all("newparam") if one.get("sid") == name), None
            )
            if parameter is None:
                break
            sampler = parameter.first("sampler2D") or sampler
            source = next(parameter.every("source"), None) or next(
                parameter.every("init_from"), None
            )
            if source is None:
                break
            name = source.text.strip()
        stored = self._library.find(f"#{name}")
        start = None if stored is None else next(stored.every("init_from"), None)
        image = None if start is None else self._image(start.text.strip())
        if image is None:
            return None
        return TextureMap(image.pixels, encoded=image.encoded, **_sampling(sampler))

    def _image(self, uri: str) -> Texture | None:
        return self._textures.read(
            uri, lambda: read_bounded(image_beside(self._folder, uri, "texture"))
        )


def _sampling(element: Element | None) -> dict[str, Any]:
    """How a sampler reads its image; smoothly and repeating where it does not say."""
    if element is None:
        return {}
    wrap = []
    for axis in ("wrap_s", "wrap_t"):
        said = element.first(axis)
        wrap.append("repeat" if said is None else WRAPS.get(said.text.strip(), "clamp"))
    nearest: dict[str, Filter] = {}
    for ours, theirs in (("magnify", "magfilter"), ("minify", "minfilter")):
        said = element.first(theirs)
        if said is not None and said.text.strip().startswith("NEAREST"):
            nearest[ours] = "nearest"
    return {"wrap": tuple(wrap), **nearest}


def _roughness(kind: str, shader: Element) -> float:
    """1 without a highlight."""
    specular = shader.first("specular", "color")
    dark = specular is not None and not specular.floats()[:3].any()
    if kind not in ("phong", "blinn") or shader.first("specular") is None or dark:
        return 1.0
    exponent = _number(shader.first("shininess"), 0.0)
    return roughness_of(exponent * (BLINN_OF_PHONG if kind == "phong" else 1.0))


def _number(element: Element | None, default: float) -> float:
    """The number of `<float>` within an element."""
    inside = None if element is None else element.first("float")
    if inside is None:
        return default
    values = inside.floats()
    return float(values[0]) if len(values) else default


def _is_double_sided(effect: Element) -> bool:
    """As the extension of Google Earth has it, which most programs write."""
    return any(one.text.strip() in ("1", "true") for one in effect.every("double_sided"))
