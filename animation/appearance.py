"""What surfaces look like: materials as glTF 2.0 has them, where on a mesh each lies, and sRGB.

Factors are linear light; images hold what their use says: sRGB for base colour and emission,
linear numbers for the rest. Texture coordinate (0, 0) is the upper left corner of an image,
(1, 1) the lower right.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.ga.names import check_word

Wrap = Literal["repeat", "mirror", "clamp"]
Filter = Literal["nearest", "linear"]
AlphaMode = Literal["opaque", "mask", "blend"]
MOST_SETS = 4
"""Sets of texture coordinates that one mesh may have."""


@dataclass(frozen=True, eq=False)
class TextureMap:
    """An image on a surface.

    Attributes:
        pixels: (h, w, 4) uint8, top row first.
        coordinate_set: which of the mesh's sets of texture coordinates places it.
        wrap: beyond the image's sides, and beyond its top and bottom.
        magnify: how it is read where a pixel of it is larger than one of the drawn image.
        minify: the same where it is smaller.
        mipmaps: how reduced copies of it are read there; None reads none.
        transform: (2, 3) matrix that acts on texture coordinates (u, v, 1).
        encoded: the file that the image was in, PNG or JPEG, to be written as it came; or none.

    Raises:
        ValueError: pixels of another shape or type, or values that are not among those listed.

    >>> import numpy as np
    >>> from motorcade.animation.appearance import TextureMap
    >>> squares = np.zeros((2, 2, 4), np.uint8)
    >>> squares[[0, 1], [0, 1]] = squares[..., 3] = 255
    >>> TextureMap(squares, wrap=("clamp", "repeat")).coordinate_set
    0
    """

    pixels: NDArray[np.uint8]
    coordinate_set: int = 0
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    magnify: Filter = "linear"
    minify: Filter = "linear"
    mipmaps: Filter | None = "linear"
    transform: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    encoded: bytes = b""

    def __post_init__(self) -> None:
        shape = self.pixels.shape
        if len(shape) != 3 or shape[2] != 4 or 0 in shape or self.pixels.dtype != np.uint8:
            raise ValueError(
                f"TextureMap.pixels: expected uint8 of shape (h, w, 4), got {self.pixels.dtype} "
                f"{shape}"
            )
        if not set(self.wrap) <= set(get_args(Wrap)):
            raise ValueError(f"TextureMap.wrap: expected two of {get_args(Wrap)}, got {self.wrap}")
        if np.shape(self.transform) != (2, 3):
            raise ValueError(
                f"TextureMap.transform: expected (2, 3) numbers, got {np.shape(self.transform)}"
            )
        if not 0 <= self.coordinate_set < MOST_SETS:
            raise ValueError(
                f"TextureMap.coordinate_set: expected 0 to {MOST_SETS - 1}, got "
                f"{self.coordinate_set}"
            )


@dataclass(frozen=True, eq=False)
class Material:
    """What a surface does to light, in the words of glTF 2.0's metallic-roughness model.

    Attributes:
        name: what it is called; may be empty.
        base_color: (4,) linear RGB and alpha, which `base_map` and vertex colours multiply.
        metallic: 0 a dielectric to 1 a metal; blue of `metallic_roughness_map` multiplies it.
        roughness: 0 a mirror to 1 chalk; green of `metallic_roughness_map` multiplies it.
        emission: (3,) linear RGB given off, which `emission_map` multiplies; may exceed 1.
        base_map: sRGB and alpha.
        metallic_roughness_map: linear.
        normal_map: tangent space, times `normal_scale` in its plane.
        occlusion_map: red dims ambient light, by `occlusion_strength`.
        emission_map: sRGB.
        alpha_mode: "opaque" leaves alpha out, "mask" draws where it reaches `alpha_cutoff`, "blend"
            lets shine through what lies behind.
        double_sided: whether the back is drawn too.
        unlit: whether the base colour is drawn as it is, whatever the light.

    Raises:
        ValueError: an unknown mode, or factors of another count or below zero.

    >>> from motorcade.animation.appearance import Material
    >>> Material("brass", base_color=(0.9, 0.7, 0.3, 1.0), metallic=1.0, roughness=0.3).alpha_mode
    'opaque'
    """

    name: str = ""
    base_color: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    metallic: float = 1.0
    roughness: float = 1.0
    emission: tuple[float, ...] = (0.0, 0.0, 0.0)
    base_map: TextureMap | None = None
    metallic_roughness_map: TextureMap | None = None
    normal_map: TextureMap | None = None
    normal_scale: float = 1.0
    occlusion_map: TextureMap | None = None
    occlusion_strength: float = 1.0
    emission_map: TextureMap | None = None
    alpha_mode: AlphaMode = "opaque"
    alpha_cutoff: float = 0.5
    double_sided: bool = False
    unlit: bool = False

    def __post_init__(self) -> None:
        check_word(self.alpha_mode, get_args(AlphaMode), "Material.alpha_mode")
        for name, count in (("base_color", 4), ("emission", 3)):
            values = np.asarray(getattr(self, name), dtype=np.float64)
            if values.shape != (count,) or not np.all(values >= 0.0):
                raise ValueError(f"Material.{name}: expected {count} numbers from 0, got {values}")

    @property
    def maps(self) -> dict[str, TextureMap]:
        """The images that it has, by the names of its fields."""
        names = (
            "base_map",
            "metallic_roughness_map",
            "normal_map",
            "occlusion_map",
            "emission_map",
        )
        by_name = {name: getattr(self, name) for name in names}
        return {name: one for name, one in by_name.items() if one is not None}


@dataclass(frozen=True, eq=False)
class MaterialPart:
    """Triangles of a mesh that share a material.

    Attributes:
        material: of all of them.
        first: number of the first triangle.
        stop: number after the last.
        flat: whether each triangle is shaded by its own plane, as where a file has no normals.

    >>> from motorcade.animation.appearance import Material, MaterialPart
    >>> part = MaterialPart(Material("felt"), 0, 12)
    >>> part.stop - part.first
    12
    """

    material: Material
    first: int
    stop: int
    flat: bool = False


@dataclass(frozen=True, eq=False)
class Appearance:
    """Materials of a mesh of V vertices and T triangles.

    Attributes:
        parts: one after another, which together hold all triangles.
        coordinates: (S, V, 2) float32, S sets of texture coordinates.
        colors: (V, 4) float32 linear RGB and alpha, which multiply the base colour; None for white.
        tangents: (V, 4) float32 for normal maps: a unit vector along which the first coordinate
            grows, zero where the file does not say, and 1 or −1 for the side on which the second
            axis lies (their product with the normal times it); None to follow the coordinates.

    Raises:
        ValueError: parts that leave gaps, shapes that do not fit, or a material's image placed by
            coordinates that are not there.

    >>> import numpy as np
    >>> from motorcade.animation.appearance import Appearance, Material, MaterialPart
    >>> parts = (MaterialPart(Material("coat"), 0, 10), MaterialPart(Material("hat"), 10, 14))
    >>> Appearance(parts, np.zeros((0, 20, 2), np.float32)).triangle_count
    14
    """

    parts: tuple[MaterialPart, ...]
    coordinates: NDArray[np.float32]
    colors: NDArray[np.float32] | None = None
    tangents: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        shape = self.coordinates.shape
        if len(shape) != 3 or shape[2] != 2:
            raise ValueError(f"Appearance.coordinates: expected (S, V, 2), got {shape}")
        for name, values in (("colors", self.colors), ("tangents", self.tangents)):
            if values is not None and values.shape != (shape[1], 4):
                raise ValueError(
                    f"Appearance.{name}: expected shape ({shape[1]}, 4), got {values.shape}"
                )
        at = 0
        for part in self.parts:
            if part.first != at or part.stop < at:
                raise ValueError(
                    f"Appearance.parts: expected one to begin at triangle {at}, got {part.first} "
                    f"to {part.stop}"
                )
            at = part.stop
            for name, texture in part.material.maps.items():
                if texture.coordinate_set >= shape[0]:
                    raise ValueError(
                        f"Appearance.parts: expected coordinates for {name} of "
                        f"'{part.material.name}' in set {texture.coordinate_set}, got {shape[0]}"
                    )

    @property
    def triangle_count(self) -> int:
        """How many triangles the parts hold."""
        return self.parts[-1].stop if self.parts else 0

    def check(self, vertices: FloatArray, triangles: NDArray[np.int64], name: str) -> None:
        """Refuse to be of a mesh of another size.

        Raises ValueError: as said; `name` is whose mesh it is.
        """
        counts = self.coordinates.shape[1], self.triangle_count
        if counts != (len(vertices), len(triangles)):
            raise ValueError(
                f"{name}.appearance: expected {len(vertices)} vertices and {len(triangles)} "
                f"triangles as the mesh has, got {counts[0]} and {counts[1]}"
            )


def to_linear(srgb: FloatArray) -> FloatArray:
    """Linear light of sRGB values from 0 to 1.

    >>> import numpy as np
    >>> from motorcade.animation.appearance import to_linear, to_srgb
    >>> to_linear(np.array([0.0, 0.5, 1.0])).round(3)
    array([0.   , 0.214, 1.   ])
    >>> to_srgb(to_linear(np.array([0.25]))).round(6)
    array([0.25])
    """
    return np.where(srgb <= 0.04045, srgb / 12.92, ((np.maximum(srgb, 0.0) + 0.055) / 1.055) ** 2.4)


def to_srgb(linear: FloatArray) -> FloatArray:
    """Values (sRGB) of linear light, both from 0 to 1; what lies outside is clipped."""
    inside = np.clip(linear, 0.0, 1.0)
    encoded = np.where(inside <= 0.0031308, 12.92 * inside, 1.055 * inside ** (1.0 / 2.4) - 0.055)
    return np.clip(encoded, 0.0, 1.0)
