"""Draws a room of flat panels: a warp a tile, the nearest one a pixel; grey, depth, right image.

Along an image's rows and columns, the inverse depth of a plane, and its texture coordinates times
that, are affine: with ``[s t 1] / z = G [x y 1]`` all coverage and depth follow exactly, so only
the textures are resampled (bilinear, at the level of their pyramid that suits their distance).
Edges are not smoothed: a pixel shows what its centre's ray meets.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import Camera
from tests.textured_room.scene import Panel, Room

__all__ = ["Renderer", "Sensor", "View"]

NEAREST_M = 0.02
_LEVELS = 5
# Tiles reach this part of their size over their edges, so that rounding leaves no gaps.
_OVERLAP = 1e-5
Image = NDArray[np.uint8]
Depth = NDArray[np.float32]


_CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)


@dataclass(frozen=True)
class Sensor:
    """What looks at the room, and how badly.

    Fields:
        camera: pinhole; the right one of the pair is alike.
        baseline_m: how far the right camera stands to the right.
        noise: of a pixel, standard deviation in grey levels.
        depth_noise_px: of the depth, as disparity of the pair, standard deviation in pixels.
        exposures: images averaged into one, where it is taken over a path (motion blur).

    Raises:
        ValueError: a camera with distortion, a baseline or count that is not above zero, negative
            noise.
    """

    camera: Camera = _CAMERA
    baseline_m: float = 0.12
    noise: float = 1.0
    depth_noise_px: float = 0.0
    exposures: int = 5

    def __post_init__(self) -> None:
        if self.camera.model != "pinhole":
            raise ValueError(f"Sensor.camera: expected a pinhole, got {self.camera.model}")
        if not (np.isfinite(self.baseline_m) and self.baseline_m > 0.0):
            raise ValueError(f"Sensor.baseline_m: expected metres above 0, got {self.baseline_m}")
        for name in ("noise", "depth_noise_px"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"Sensor.{name}: expected a number from 0 on, got {value}")
        if self.exposures < 1:
            raise ValueError(f"Sensor.exposures: expected 1 or more, got {self.exposures}")


@dataclass(frozen=True, eq=False)
class View:
    """What the sensor sees from one pose.

    Args:
        gray: ``(h, w)`` uint8.
        depth_m: ``(h, w)`` float32, distance along the optical axis; NaN where nothing is.
        right: ``(h, w)`` uint8, the right image of the rectified pair.
    """

    gray: Image
    depth_m: Depth
    right: Image

    @classmethod
    def covered(cls, sensor: Sensor, rng: np.random.Generator) -> View:
        """What is seen with a hand over the lenses: noise on black, and no depth."""
        shape = (sensor.camera.height, sensor.camera.width)
        black = np.zeros(shape, dtype=np.float32)
        dark = [_exposed(black, sensor.noise, rng) for _ in range(2)]
        return cls(dark[0], np.full(shape, np.nan, dtype=np.float32), dark[1])


class Renderer:
    """Draws one room for one sensor.

    Args:
        room: what there is.
        sensor: what looks at it.
    """

    def __init__(self, room: Room, sensor: Sensor | None = None) -> None:
        self.sensor = Sensor() if sensor is None else sensor
        tiles = [tile for panel in room.panels for tile in panel.tiles()]
        self._pyramids = [_pyramid(tile) for tile in tiles]
        self._frames = np.array(
            [np.stack([tile.right_m, tile.down_m, tile.corner_m], axis=-1) for tile in tiles]
        )

    def view(self, world_T_camera: Motor, rng: np.random.Generator, *, light: float = 1.0) -> View:
        """See from one pose ``()``, or blurred over several ``(n,)``, whose middle is the view's.

        Args:
            world_T_camera: pose of the left camera.
            rng: of the noise; unused where there is none.
            light: how bright what is seen is, against full light; the depth needs none.

        Raises:
            ValueError: more than one leading dimension.
        """
        if len(world_T_camera.shape) > 1:
            raise ValueError(f"Renderer.view: expected one pose or a row, got {world_T_camera!r}")
        poses = Motor(np.atleast_2d(world_T_camera.coefficients))
        aside = Motor.from_twist(np.array([0.0, 0.0, 0.0, self.sensor.baseline_m, 0.0, 0.0]))
        left, right = ([self.draw(pose) for pose in path] for path in (poses, poses @ aside))
        depth = left[len(left) // 2][1]
        noise = self.sensor.noise
        gray = _exposed(np.float32(light) * _averaged(left), noise, rng)
        other = _exposed(np.float32(light) * _averaged(right), noise, rng)
        return View(gray, self._measured(depth, rng), other)

    def draw(self, world_T_camera: Motor) -> tuple[Image, Depth]:
        """The exact image and depth from one pose, without noise."""
        camera = self.sensor.camera
        camera_T_world = world_T_camera.inverse().as_matrix()
        turned = camera_T_world[:3, :3] @ self._frames
        turned[:, :, 2] += camera_T_world[:3, 3]
        image = np.zeros((camera.height, camera.width), dtype=np.uint8)
        nearness = np.full(image.shape, 0.0, dtype=np.float32)
        for index in self._in_view(turned):
            self._draw_tile(turned[index], self._pyramids[index], image, nearness)
        with np.errstate(divide="ignore"):
            depth = np.where(nearness > 0.0, 1.0 / nearness, np.float32(np.nan))
        return image, depth

    def _in_view(self, turned: FloatArray) -> NDArray[np.intp]:
        """Tiles that face the camera and are not wholly beside or behind what it sees."""
        camera = self.sensor.camera
        facing = np.linalg.det(turned) > 0.0
        edges = turned[:, :, :2]
        corner = turned[:, :, 2]
        corners = np.stack(
            [corner + a * edges[..., 0] + b * edges[..., 1] for a, b in _SQUARE], axis=1
        )
        pixels = corners @ camera.matrix.T
        x, y, z = np.moveaxis(pixels, -1, 0)
        beside = (
            np.all(z < NEAREST_M, axis=1)
            | np.all(x < -0.5 * z, axis=1)
            | np.all(y < -0.5 * z, axis=1)
            | np.all(x > (camera.width - 0.5) * z, axis=1)
            | np.all(y > (camera.height - 0.5) * z, axis=1)
        )
        return np.flatnonzero(facing & ~beside)

    def _draw_tile(
        self, turned: FloatArray, pyramid: list[Image], image: Image, nearness: Depth
    ) -> None:
        """Draw one tile where it is nearer than what is there."""
        to_pixels = self.sensor.camera.matrix @ turned
        outline = _clipped(to_pixels)
        if len(outline) < 3:
            return
        seen = outline[:, :2] / outline[:, 2:]
        low = np.maximum(np.floor(seen.min(axis=0)), 0).astype(int)
        size = (image.shape[1], image.shape[0])
        high = np.minimum(np.ceil(seen.max(axis=0)) + 1, size).astype(int)
        if np.any(high <= low):
            return
        inverse: FloatArray = np.asarray(np.linalg.inv(to_pixels), dtype=np.float64)
        level = min(_level(outline, inverse, seen, pyramid[0].shape), len(pyramid) - 1)
        inverse[:, 2] += inverse[:, :2] @ low  # pixels are counted from the window's corner
        window = np.s_[low[1] : high[1], low[0] : high[0]]
        inverse_depth, inside = _coverage(inverse, tuple(high - low))
        inside &= inverse_depth > nearness[window]
        texture = pyramid[level]
        to_texels = np.diag([texture.shape[1], texture.shape[0], 1.0])
        to_texels[:2, 2] = -0.5
        warped = cv2.warpPerspective(
            texture,
            to_texels @ inverse,
            tuple(map(int, high - low)),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        np.copyto(image[window], warped, where=inside)
        np.copyto(nearness[window], inverse_depth, where=inside)

    def _measured(self, depth_m: Depth, rng: np.random.Generator) -> Depth:
        """Depth with the noise of a disparity."""
        if self.sensor.depth_noise_px == 0.0:
            return depth_m
        reach = self.sensor.camera.fx * self.sensor.baseline_m
        noise = rng.standard_normal(depth_m.shape, dtype=np.float32)
        disparity = reach / depth_m + np.float32(self.sensor.depth_noise_px) * noise
        measured = np.where(disparity > 0.0, reach / disparity, np.nan)
        return np.asarray(measured, dtype=np.float32)


_SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def _pyramid(tile: Panel) -> list[Image]:
    """The tile's texture at halved sizes, finest first."""
    levels = [np.ascontiguousarray(tile.texture)]
    for _ in range(_LEVELS - 1):
        height, width = levels[-1].shape
        if min(height, width) < 4:
            break
        half = (max(width // 2, 1), max(height // 2, 1))
        levels.append(np.asarray(cv2.resize(levels[-1], half, interpolation=cv2.INTER_AREA)))
    return levels


def _clipped(to_pixels: FloatArray) -> FloatArray:
    """The tile's outline ``(n, 3)`` as homogeneous pixels, cut at the nearest depth."""
    corners = np.column_stack([_SQUARE, np.ones(4)]) @ to_pixels.T
    ahead = corners[:, 2] >= NEAREST_M
    if ahead.all():
        return corners
    kept = []
    for here, there, a, b in zip(
        corners, np.roll(corners, -1, axis=0), ahead, np.roll(ahead, -1), strict=True
    ):
        if a:
            kept.append(here)
        if a != b:
            part = (NEAREST_M - here[2]) / (there[2] - here[2])
            kept.append(here + part * (there - here))
    return np.array(kept).reshape(-1, 3)


def _coverage(inverse: FloatArray, size: tuple[int, ...]) -> tuple[Depth, NDArray[np.bool_]]:
    """Inverse depth of the tile's plane in a window, and which of its pixels the tile covers."""
    first, second, nearness = inverse
    reach = _OVERLAP * nearness
    forms = (
        nearness,
        first + reach,
        second + reach,
        nearness + reach - first,
        nearness + reach - second,
    )
    x, y = np.arange(size[0]), np.arange(size[1])
    planes = [
        (form[1] * y + form[2]).astype(np.float32)[:, None] + (form[0] * x).astype(np.float32)
        for form in forms
    ]
    inside = planes[1] >= 0.0
    for plane in planes[2:]:
        inside &= plane >= 0.0
    return planes[0], inside


def _level(
    outline: FloatArray, inverse: FloatArray, seen: FloatArray, shape: tuple[int, ...]
) -> int:
    """Which level of the pyramid has about a texel a pixel, over what is seen of the tile."""
    own = outline @ inverse.T
    own = own[:, :2] / own[:, 2:]
    texels = _area(own) * shape[0] * shape[1]
    ratio = texels / max(_area(seen), 1e-3)
    return int(np.floor(0.5 * np.log2(max(ratio, 1.0)) + 0.5))


def _area(polygon: FloatArray) -> float:
    x, y = polygon.T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def _averaged(drawn: list[tuple[Image, Depth]]) -> NDArray[np.float32]:
    """The mean of several images."""
    return np.asarray(np.mean([p for p, _ in drawn], axis=0), dtype=np.float32)


def _exposed(image: NDArray[np.float32], noise: float, rng: np.random.Generator) -> Image:
    """An image with noise, rounded."""
    if noise > 0.0:
        image = image + np.float32(noise) * rng.standard_normal(image.shape, np.float32)
    return np.asarray(np.clip(np.rint(image), 0, 255), dtype=np.uint8)
