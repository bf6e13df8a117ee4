"""What every renderer offers, which there are, and the checks that they share."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import Literal, Protocol, Self, get_args

import numpy as np

from motorcade.ga import FloatArray, Motor
from motorcade.render.scene import Layer, Lighting, Surface
from motorcade.tracking.cameras.camera import Camera

NEAR_M, FAR_M = 0.02, 60.0
# From OpenGL's camera axes to OpenCV's: half a turn about x.
OPENCV_T_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])

RendererName = Literal["fast", "pyrender"]
RENDERERS: tuple[RendererName, ...] = get_args(RendererName)


class Renderer(Protocol):
    """Draws one scene into pictures of one size; a context manager."""

    def __enter__(self) -> Self:
        """The renderer itself."""
        ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close it."""
        ...

    def show(self, surfaces: Sequence[Surface], lighting: Lighting | None) -> None:
        """Set the scene, in place of any earlier one; without light, colours as they are."""
        ...

    def relight(self, lighting: Lighting) -> None:
        """Move the light of the scene: as many lamps as were shown, in other places."""
        ...

    def move(self, surface: int, vertices: FloatArray, normals: FloatArray) -> None:
        """Give a surface new vertices and normals, world, (V, 3); V must stay the same."""
        ...

    def render(self, camera: Camera, world_T_camera: Motor) -> Layer:
        """Draw the scene as a pinhole camera of the renderer's size sees it."""
        ...

    def close(self) -> None:
        """Free everything; closing twice does nothing."""
        ...


def new_renderer(name: str, width: int, height: int) -> Renderer:
    """The renderer of a name.

    Args:
        name: one of `RENDERERS`; docs/rendering.md says when to take which.
        width: of the pictures, pixels.
        height: of the pictures, pixels.

    Raises:
        ValueError: another name, or a size that is not positive.
        RenderUnavailable: this machine has no OpenGL.
    """
    if name == "fast":
        from motorcade.render.backends.fast.renderer import FastRenderer

        return FastRenderer(width, height)
    if name == "pyrender":
        from motorcade.render.backends.pyrender_backend import OffscreenRenderer

        return OffscreenRenderer(width, height)
    raise ValueError(f"renderer: expected one of {', '.join(RENDERERS)}, got {name!r}")


def check_size(width: int, height: int, largest: int | None = None) -> None:
    """Refuse pictures without pixels, and such as OpenGL cannot hold.

    Raises:
        ValueError: a size below 1 or above `largest`.
    """
    if width <= 0 or height <= 0:
        raise ValueError(f"renderer: expected a size of 1 pixel or more, got {width} x {height}")
    if largest is not None and max(width, height) > largest:
        raise ValueError(
            f"renderer: expected at most {largest} pixels a side, as much as this OpenGL holds, "
            f"got {width} x {height}"
        )


def check_camera(camera: Camera, size: tuple[int, int]) -> None:
    """Refuse cameras with distortion, or of another size than the renderer's.

    Raises:
        ValueError: as said.
    """
    if camera.model != "pinhole" or (camera.width, camera.height) != size:
        raise ValueError(
            f"render(camera): expected a pinhole camera of {size[0]} x {size[1]}, "
            f"got {camera.model} of {camera.width} x {camera.height}"
        )


def check_relit(shown: Lighting | None, lighting: Lighting) -> None:
    """Refuse light for a scene that was shown without, or in another number of lamps.

    Raises:
        ValueError: as said.
    """
    if shown is None or len(shown.lamps) != len(lighting.lamps):
        expected = "a scene shown in light" if shown is None else f"{len(shown.lamps)} lamps"
        raise ValueError(f"relight(lighting): expected {expected}, got {len(lighting.lamps)} lamps")


def check_moved(shape: tuple[int, ...], vertices: FloatArray, normals: FloatArray) -> None:
    """Refuse vertices of another number than were shown.

    Raises:
        ValueError: as said.
    """
    if vertices.shape != shape or normals.shape != shape:
        raise ValueError(
            f"move(vertices): expected shape {shape} for vertices and normals, got "
            f"{vertices.shape} and {normals.shape}"
        )


def linear(color: FloatArray) -> FloatArray:
    """Linear light of sRGB values from 0 to 1 (IEC 61966-2-1)."""
    return np.asarray(np.where(color < 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4))


def looking_along(direction: FloatArray) -> FloatArray:
    """A pose (4, 4) whose −z points along a direction, as OpenGL's lights and cameras look."""
    back = -direction / np.linalg.norm(direction)
    side = np.cross([0.0, 0.0, 1.0] if abs(back[2]) < 0.9 else [1.0, 0.0, 0.0], back)
    side /= np.linalg.norm(side)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([side, np.cross(back, side), back], axis=1)
    return pose


def shadow_camera(lighting: Lighting) -> tuple[FloatArray, FloatArray]:
    """From where the shadow map is drawn, and over which depths.

    Returns:
        ``world_T_light`` (4, 4), OpenGL's axes, and the nearest and farthest distance in metres.
        The map is twice `Lighting.shadow_radius_m` wide and high.
    """
    pose = looking_along(np.array(lighting.sun.direction))
    radius = lighting.shadow_radius_m
    pose[:3, 3] = np.array(lighting.shadow_center_m) + pose[:3, 2] * 2.0 * radius
    return pose, np.array([0.1 * radius, 8.0 * radius])
