"""What is drawn, and in what light, without a word about how: surfaces, lamps, images.

World coordinates in metres, right-handed. Colours and textures are sRGB; light is linear.
Texture coordinate (0, 0) is the lower left corner of the image, (1, 1) the upper right.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import Appearance
from motorcade.ga.arrays import FloatArray, IntArray

ImageArray = NDArray[np.uint8]
DepthArray = NDArray[np.float32]
BRIGHTEST = 250
"""A byte from which on an image may be overexposed."""
Triple = tuple[float, float, float]
"""Of a point or direction in the world, or of red, green and blue."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangle mesh with one look.

    Attributes:
        vertices: (V, 3) world, metres.
        normals: (V, 3) unit, outward.
        triangles: (T, 3) counter-clockwise seen from outside; the back is not drawn.
        colors: (V, 3) sRGB 0 to 1, or None for white.
        texture: (h, w, 3) uint8 sRGB, or None.
        texture_coordinates: (V, 2), needed with a texture.
        roughness: 0 mirror-like to 1 chalk.
        appearance: materials and textures for renderers that draw them (the fast one), in place of
            `colors`, `texture` and `roughness`; or None.

    Raises:
        ValueError: shapes that do not fit, or a texture without coordinates.

    >>> import numpy as np
    >>> from motorcade.render import Surface
    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1.0, 0]])
    >>> tile = Surface(corners, np.tile([0, 0, 1.0], (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]))
    >>> tile.roughness, tile.colors is None
    (0.6, True)
    """

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    colors: FloatArray | None = None
    texture: ImageArray | None = None
    texture_coordinates: FloatArray | None = None
    roughness: float = 0.6
    appearance: Appearance | None = None

    def __post_init__(self) -> None:
        count = len(self.vertices)
        for name, width in (
            ("vertices", 3),
            ("normals", 3),
            ("colors", 3),
            ("texture_coordinates", 2),
        ):
            values = getattr(self, name)
            if values is not None and values.shape != (count, width):
                raise ValueError(
                    f"Surface.{name}: expected shape ({count}, {width}), got {values.shape}"
                )
        if self.appearance is not None:
            self.appearance.check(self.vertices, self.triangles, "Surface")
        if (self.texture is None) != (self.texture_coordinates is None):
            raise ValueError("Surface: expected texture and texture_coordinates both or neither")
        if self.texture is not None and (self.texture.ndim != 3 or self.texture.shape[2] != 3):
            raise ValueError(f"Surface.texture: expected shape (h, w, 3), got {self.texture.shape}")


@dataclass(frozen=True)
class Sun:
    """Parallel light that casts shadows.

    Attributes:
        direction: (3,) the way the light travels.
        intensity: irradiance in pyrender's units; about 3 lights white paper fully.
        color: linear RGB.
        radius_rad: apparent radius; the shadow of a larger one is softer.

    >>> from motorcade.render import Sun
    >>> Sun(direction=(0.0, 0.0, -1.0), intensity=3.0).color  # from the zenith; white
    (1.0, 1.0, 1.0)
    """

    direction: Triple
    intensity: float
    color: Triple = (1.0, 1.0, 1.0)
    radius_rad: float = 0.12


@dataclass(frozen=True)
class Lamp:
    """A point of light without shadow, to lighten what the sun leaves dark.

    Attributes:
        position_m: (3,) world.
        intensity: falls off with the square of the distance in metres.
        color: linear RGB.

    >>> from motorcade.render import Lamp
    >>> lamp = Lamp(position_m=(0.0, 0.0, 3.0), intensity=9.0)
    >>> lamp.intensity / lamp.position_m[2] ** 2, lamp.color  # on the floor below it; white
    (1.0, (1.0, 1.0, 1.0))
    """

    position_m: Triple
    intensity: float
    color: Triple = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Lighting:
    """All the light of a scene.

    Attributes:
        ambient: linear RGB that reaches every surface equally.
        sun: the light that casts shadows.
        lamps: lights that cast none.
        shadow_center_m: (3,) middle of what can throw shadows.
        shadow_radius_m: radius of the ball around it that holds everything that throws them.
        surroundings: nine rows of linear RGB: spherical harmonics to band 2 of the radiance from
            all around, in the world and besides `ambient`, which surfaces mirror too; or none.

    Raises:
        ValueError: another number of rows.

    >>> import numpy as np
    >>> from motorcade.render import Lamp, Lighting, Sun
    >>> sun, lamp = Sun((0, 0, -1.0), 3.0), Lamp((1.0, 0, 2.0), 4.0)
    >>> noon = Lighting((0.3, 0.3, 0.3), sun, (lamp,), (0, 0, 0), shadow_radius_m=2.0)
    >>> noon.translated_by(np.array([5.0, 0, 0])).lamps[0].position_m
    (6.0, 0.0, 2.0)
    """

    ambient: Triple
    sun: Sun
    lamps: tuple[Lamp, ...]
    shadow_center_m: Triple
    shadow_radius_m: float
    surroundings: tuple[Triple, ...] = ()

    def __post_init__(self) -> None:
        if len(self.surroundings) not in (0, 9):
            raise ValueError(
                f"Lighting.surroundings: expected 9 rows or none, got {len(self.surroundings)}"
            )

    @property
    def mean_ambient(self) -> Triple:
        """Linear RGB that reaches surfaces in the mean, but for sun and lamps."""
        if not self.surroundings:
            return self.ambient
        r, g, b = np.add(self.ambient, np.array(self.surroundings[0]) / np.sqrt(4.0 * np.pi))
        return float(r), float(g), float(b)

    def translated_by(self, offset_m: FloatArray) -> "Lighting":
        """The same light about another place: lamps and shadows moved by (3,) metres, world."""
        lamps = tuple(
            replace(lamp, position_m=_translated(lamp.position_m, offset_m)) for lamp in self.lamps
        )
        center_m = _translated(self.shadow_center_m, offset_m)
        return replace(self, lamps=lamps, shadow_center_m=center_m)


def _translated(place_m: Triple, by_m: FloatArray) -> Triple:
    x, y, z = (float(value) for value in np.add(place_m, by_m))
    return x, y, z


@dataclass(frozen=True, eq=False)
class Layer:
    """A rendered image that can be laid over another.

    Attributes:
        rgba: (h, w, 4) uint8, colour premultiplied by alpha; empty pixels are all zero.
        depth_m: (h, w) float32 along the optical axis, metres; 0 where nothing was drawn.

    >>> import numpy as np
    >>> from motorcade.render import Layer, over
    >>> rgba, depth_m = np.zeros((1, 2, 4), np.uint8), np.zeros((1, 2), np.float32)
    >>> rgba[0, 1], depth_m[0, 1] = (200, 0, 0, 255), 2.0  # one pixel is drawn, two metres away
    >>> over(np.full((1, 2, 3), 50, np.uint8), Layer(rgba, depth_m))[0]
    array([[ 50,  50,  50],
           [200,   0,   0]], dtype=uint8)
    """

    rgba: ImageArray
    depth_m: DepthArray
