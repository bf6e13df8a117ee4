"""Parts of a mesh with materials of their own, in the memory of the renderer.

For facets spread as GGX says and hidden from each other as Smith says, the share of even light that
rough surfaces mirror to the eye is `F0 scale + offset` for a mirror of F0 at normal incidence with
Schlick's Fresnel, a table for shaders (Karis, "Real Shading in Unreal Engine 4", 2013).
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import (
    Appearance,
    Material,
    MaterialPart,
    TextureMap,
    to_linear,
    to_srgb,
)
from motorcade.render.backends.programs import SRGB8_ALPHA8, Programs
from motorcade.render.scene import Surface

log = logging.getLogger("motorcade.render")

MAPS = {
    "base_map": "BASE_MAP",
    "metallic_roughness_map": "ROUGH_MAP",
    "normal_map": "NORMAL_MAP",
    "occlusion_map": "OCCLUSION_MAP",
    "emission_map": "EMISSION_MAP",
}
ENCODED = ("base_map", "emission_map")
"""Maps whose images are sRGB."""
FIRST_UNIT = 1
"""Texture unit of the first map; the shadow map has the one before."""
TABLE_UNIT = FIRST_UNIT + len(MAPS)
TEXTURE_2D, WRAP_S, WRAP_T, MIRRORED_REPEAT = 0x0DE1, 0x2802, 0x2803, 0x8370


class Images:
    """Textures of one context; surfaces that show the same pixels share one.

    Args:
        set_parameter: OpenGL's glTexParameterf, for what moderngl cannot say.
    """

    def __init__(self, gl: Any, set_parameter: Callable[[int, int, float], None]) -> None:
        self._gl, self._set_parameter = gl, set_parameter
        self._made: dict[tuple[object, ...], tuple[Any, NDArray[np.uint8]]] = {}
        self._table: Any = None
        self._told = False

    def texture(self, texture_map: TextureMap, *, encoded: bool) -> Any:
        """A texture with the map's sampler; `encoded` pixels are turned into linear light."""
        sampling = texture_map.wrap, texture_map.magnify, texture_map.minify, texture_map.mipmaps
        key = id(texture_map.pixels), encoded, sampling
        if key not in self._made:
            # The pixels are kept, so that their number is not given to others.
            self._made[key] = self._upload(texture_map, encoded=encoded), texture_map.pixels
        return self._made[key][0]

    def use_table(self) -> None:
        """Bind what rough surfaces mirror to its unit."""
        if self._table is None:
            self._table = self._gl.texture((SIZE, SIZE), 2, mirrored_table(), dtype="f4")
            self._table.repeat_x = self._table.repeat_y = False
        self._table.use(TABLE_UNIT)

    def release(self) -> None:
        """Free them."""
        if self._table is not None:
            self._table.release()
            self._table = None
        for texture, _ in self._made.values():
            texture.release()
        self._made = {}

    def _upload(self, texture_map: TextureMap, *, encoded: bool) -> Any:
        import moderngl

        pixels = np.ascontiguousarray(texture_map.pixels)
        most = int(self._gl.info["GL_MAX_TEXTURE_SIZE"])
        step = -(-max(pixels.shape[:2]) // most)
        if step > 1:
            if not self._told:
                height, width = pixels.shape[:2]
                log.warning(
                    "textures of more than %d pixels a side are drawn smaller, as one of %d x %d",
                    most, width, height,
                )  # fmt: skip
            self._told = True
            pixels = _means(pixels, step, encoded=encoded)
        size = pixels.shape[1], pixels.shape[0]
        kind = {"internal_format": SRGB8_ALPHA8} if encoded else {}
        upload = self._gl.texture(size, 4, pixels, **kind)
        upload.repeat_x, upload.repeat_y = (way == "repeat" for way in texture_map.wrap)
        upload.use(FIRST_UNIT)
        for name, way in zip((WRAP_S, WRAP_T), texture_map.wrap, strict=True):
            if way == "mirror":
                self._set_parameter(TEXTURE_2D, name, MIRRORED_REPEAT)
        filters = {
            ("nearest", None): moderngl.NEAREST,
            ("linear", None): moderngl.LINEAR,
            ("nearest", "nearest"): moderngl.NEAREST_MIPMAP_NEAREST,
            ("linear", "nearest"): moderngl.LINEAR_MIPMAP_NEAREST,
            ("nearest", "linear"): moderngl.NEAREST_MIPMAP_LINEAR,
            ("linear", "linear"): moderngl.LINEAR_MIPMAP_LINEAR,
        }
        if texture_map.mipmaps is not None:
            upload.build_mipmaps()
        magnify = moderngl.NEAREST if texture_map.magnify == "nearest" else moderngl.LINEAR
        upload.filter = filters[texture_map.minify, texture_map.mipmaps], magnify
        return upload


def _means(pixels: NDArray[np.uint8], step: int, *, encoded: bool) -> NDArray[np.uint8]:
    """Means of squares of so many pixels to a side, in linear light where these are sRGB."""
    height, width = pixels.shape[:2]
    starts = np.arange(0, width, step)
    counts = np.diff([*starts, width])[:, None]
    means = np.empty((-(-height // step), len(starts), 4), np.uint8)
    for row in range(len(means)):
        part = pixels[row * step : (row + 1) * step] / 255.0
        if encoded:
            part[..., :3] = to_linear(part[..., :3])
        mean = np.add.reduceat(part.mean(axis=0), starts, axis=0) / counts
        if encoded:
            mean[:, :3] = to_srgb(mean[:, :3])
        means[row] = np.rint(255.0 * mean)
    return means


class DrawnPart:
    """Triangles of one material."""

    def __init__(
        self,
        programs: Programs,
        images: Images,
        part: MaterialPart,
        *,
        lit: bool,
        colored: bool,
        lamps: int,
    ) -> None:
        material = part.material
        self.part, self.material = part, material
        sets = sorted({one.coordinate_set for one in material.maps.values()})
        self.sets = sets[:2]
        self.maps = {
            name: texture
            for name, texture in material.maps.items()
            if texture.coordinate_set in self.sets
        }
        defined = {
            "LIT": lit and not material.unlit,
            "COLORED": colored,
            "FLAT": part.flat,
            "TWO_SIDED": material.double_sided,
            "FIRST_SET": len(self.sets) > 0,
            "SECOND_SET": len(self.sets) > 1,
            "SHARP": "normal_map" in self.maps,
        }
        heads = {name: "" for name, wanted in defined.items() if wanted}
        heads |= {
            MAPS[name]: ("first_set", "second_set")[self.sets.index(texture.coordinate_set)]
            for name, texture in self.maps.items()
        }
        heads["LAMPS"] = str(lamps)
        self.program = programs.blended(heads) if self.blended else programs.shaded(heads)
        covering = {"COLORED": "", "MASKED": ""} if colored else {"MASKED": ""}
        if "base_map" in self.maps:
            covering["BASE_MAP"] = ""
        self.covering = programs.covered(covering if self.masked else {})
        self._textures = {
            name: images.texture(texture, encoded=name in ENCODED)
            for name, texture in self.maps.items()
        }
        self.array: Any = None
        self.first_number = 0

    @property
    def blended(self) -> bool:
        """Whether what lies behind shines through."""
        return self.material.alpha_mode == "blend"

    @property
    def masked(self) -> bool:
        """Whether it is drawn where its alpha reaches a cutoff."""
        return self.material.alpha_mode == "mask"

    def use(self) -> None:
        """Tell the program of this material."""
        material, program = self.material, self.program
        tell(program, "base_color", material.base_color)
        tell(program, "emission", material.emission)
        tell(program, "mirrored_table", TABLE_UNIT)
        for name in ("metallic", "roughness", "normal_scale", "occlusion_strength"):
            tell(program, name, getattr(material, name))
        for unit, name in enumerate(self.maps, start=FIRST_UNIT):
            self._use_map(program, name, unit)
        if not self.blended:
            tell(program, "first_corner", 3 * self.part.first)

    def use_covering(self) -> None:
        """Tell the program that draws which triangles are seen."""
        self.covering["first"] = self.first_number
        if self.masked:
            tell(self.covering, "base_alpha", self.material.base_color[3])
            tell(self.covering, "alpha_cutoff", self.material.alpha_cutoff)
            if "base_map" in self.maps:
                self._use_map(self.covering, "base_map", FIRST_UNIT)

    def _use_map(self, program: Any, name: str, unit: int) -> None:
        self._textures[name].use(unit)
        tell(program, name, unit)
        place = np.array(self.maps[name].transform, np.float32).T
        tell(program, f"{name}_place", tuple(place.reshape(-1).tolist()))


def appearance_of(surface: Surface) -> Appearance:
    """A surface's own appearance; where it has none, one that looks as its other fields say."""
    if surface.appearance is not None:
        return surface.appearance
    base, coordinates = None, np.zeros((0, len(surface.vertices), 2), np.float32)
    if surface.texture is not None and surface.texture_coordinates is not None:
        pixels = np.full((*surface.texture.shape[:2], 4), 255, np.uint8)
        pixels[..., :3] = surface.texture
        base = TextureMap(pixels)
        # A surface's rows count from the bottom, those of materials from the top.
        turned = surface.texture_coordinates * (1.0, -1.0) + (0.0, 1.0)
        coordinates = turned[None].astype(np.float32)
    colors = None
    if surface.colors is not None:
        colors = np.ones((len(surface.colors), 4), np.float32)
        colors[:, :3] = to_linear(surface.colors)
    material = Material(metallic=0.0, roughness=surface.roughness, base_map=base)
    return Appearance((MaterialPart(material, 0, len(surface.triangles)),), coordinates, colors)


def tell(program: Any, name: str, value: object) -> None:
    """Set a uniform, where the program has it: compilers drop those that change nothing."""
    member = program.get(name, None)
    if member is None:
        return
    if isinstance(value, bytes):
        member.write(value)
    else:
        member.value = value


SIZE = 32
SAMPLES = 256
"""Facets that are looked at for each entry; the table is then good to a hundredth."""


@cache
def mirrored_table() -> NDArray[np.float32]:
    """Scale and offset (SIZE, SIZE, 2): rows by the cosine of the view, columns by roughness.

    Entries stand for the middles of their cells, as OpenGL reads textures.
    """
    cells = (np.arange(SIZE) + 0.5) / SIZE
    nv, rough = cells[:, None, None], cells[None, :, None]
    number = np.arange(SAMPLES)
    share, turn = (number + 0.5) / SAMPLES, 2.0 * np.pi * _reversed_bits(number)
    a2 = rough**4
    cosine = np.sqrt((1.0 - share) / (1.0 + (a2 - 1.0) * share))
    sine = np.sqrt(1.0 - cosine**2)
    vh = np.maximum(np.sqrt(1.0 - nv**2) * sine * np.cos(turn) + nv * cosine, 0.0)
    nl = 2.0 * vh * cosine - nv
    lit = nl > 0.0
    nl = np.where(lit, nl, 1.0)
    hidden = nl * np.sqrt(a2 + (1.0 - a2) * nv**2) + nv * np.sqrt(a2 + (1.0 - a2) * nl**2)
    seen = np.where(lit, 2.0 * nl * vh / np.maximum(hidden * cosine, 1e-12), 0.0)
    fresnel = (1.0 - vh) ** 5
    table = np.stack([((1.0 - fresnel) * seen).mean(-1), (fresnel * seen).mean(-1)], axis=-1)
    return np.ascontiguousarray(table, dtype=np.float32)


def _reversed_bits(number: NDArray[np.int64]) -> NDArray[np.float64]:
    """Van der Corput's sequence in base 2, 0 to 1."""
    reversed_bits = np.zeros(len(number))
    for bit in range(16):
        reversed_bits += ((number >> bit) & 1) * 2.0 ** -(bit + 1)
    return reversed_bits
