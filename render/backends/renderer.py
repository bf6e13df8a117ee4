"""What every renderer offers: a scene shown, moved, lit and drawn; and OpenGL's projections."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from types import TracebackType
from typing import Self

import numpy as np

from motorcade.animation.vectors import perpendicular, unit
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.render.backends.platform import ContextLost, choose_platform, new_context
from motorcade.render.scene import Layer, Lighting, Surface
from motorcade.tracking.cameras.camera import Camera

NEAR_M, FAR_M = 0.02, 60.0
"""Nearest and farthest depth that is drawn where the scene does not tell."""
DEEPEST = 3000.0
"""Farthest over nearest depth around a camera that stands inside of its scene, as in 60 m over
2 cm: 24 bits then tell 0.2 mm apart at arm's length."""
OPENCV_T_OPENGL = Motor.from_quaternion_translation((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def clip_range(depths: FloatArray) -> tuple[float, float]:
    """Nearest and farthest depth to be drawn, from depths (N,) of what bounds the scene."""
    if not len(depths) or not float(depths.max()) > 0.0:
        return NEAR_M, FAR_M
    far = 1.01 * float(depths.max())
    near = 0.99 * float(depths.min())
    if near <= 0.0:
        near = max(far / DEEPEST, min(NEAR_M, 0.01 * far))
    return near, far


def projection(camera: Camera, near: float, far: float) -> FloatArray:
    """OpenGL's projection (4, 4) of a pinhole camera that sees depths from near to far."""
    x, y = camera.cx + 0.5, camera.cy + 0.5
    depth = far - near
    return np.array([
        [2.0 * camera.fx / camera.width, 0.0, 1.0 - 2.0 * x / camera.width, 0.0],
        [0.0, 2.0 * camera.fy / camera.height, 2.0 * y / camera.height - 1.0, 0.0],
        [0.0, 0.0, -(far + near) / depth, -2.0 * far * near / depth],
        [0.0, 0.0, -1.0, 0.0],
    ])  # fmt: skip


def looking_along(direction: FloatArray) -> Rotor:
    """The rotor that turns −z along a direction (3,), as OpenGL's lights and cameras look."""
    back = -unit(direction)
    side = perpendicular(back)
    return Rotor.from_matrix(np.stack([side, np.cross(back, side), back], axis=1))


def shadow_camera(lighting: Lighting) -> tuple[Motor, FloatArray]:
    """From where the shadow map is drawn, and over which depths.

    Returns:
        ``world_T_light`` in OpenGL's axes, and the nearest and farthest distance in metres. The map
        is twice `Lighting.shadow_radius_m` wide and high.
    """
    turn = looking_along(np.array(lighting.sun.direction))
    radius = lighting.shadow_radius_m
    behind = turn.apply(np.array([0.0, 0.0, 2.0 * radius]))
    pose = Motor.from_rotor_translation(turn, np.array(lighting.shadow_center_m) + behind)
    return pose, np.array([0.1 * radius, 8.0 * radius])


class Renderer(ABC):
    """Draws one scene into images of one size. Use it as a context manager, or `close` it.

    Args:
        width: of the images, pixels.
        height: of the images, pixels.

    Raises:
        RenderUnavailable: this machine has no OpenGL, or no memory for the images.
        ValueError: a size that is not positive, or larger than OpenGL's largest.

    >>> from motorcade.render import Renderer, new_renderer
    >>> def drawn(renderer: Renderer, surfaces, lighting, camera, world_T_camera):
    ...     renderer.show(surfaces, lighting)
    ...     return renderer.render(camera, world_T_camera)  # a Layer
    >>> with new_renderer("fast", 640, 0) as renderer:
    ...     pass
    Traceback (most recent call last):
    ValueError: renderer: expected a size of 1 pixel or more, got 640 x 0
    """

    def __init__(self, width: int, height: int) -> None:
        check_size(width, height)
        self._size = (width, height)
        self._lighting: Lighting | None = None
        self._shown = False
        self._context = new_context(choose_platform(), width, height)
        self._open = True
        try:
            self._set_up()
        except BaseException:
            self._open = False
            self._context.destroy()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free the scene and the OpenGL context; closing twice does nothing."""
        if self._open:
            self._open = False
            try:
                self._context.make_current()
                self._free()
            except ContextLost:
                self._forget()  # what it held went with the context
            finally:
                self._context.destroy()

    def show(self, surfaces: Sequence[Surface], lighting: Lighting | None) -> None:
        """Set the scene, in place of any earlier one.

        Args:
            surfaces: what is drawn.
            lighting: the light; None draws colours and textures as they are, for surfaces whose
                light is painted on.

        Raises:
            RuntimeError: the renderer is closed.
            ContextLost: its context is gone.
        """
        self._begin("show")
        self._show(surfaces, lighting)
        self._lighting, self._shown = lighting, True

    def relight(self, lighting: Lighting) -> None:
        """Light the scene that is shown anew, as light that follows a walker does.

        Args:
            lighting: with as many lamps as the scene was shown in.

        Raises:
            ValueError: another number of lamps, or a scene that was shown without light.
            RuntimeError: the renderer is closed.
            ContextLost: its context is gone.
        """
        shown = self._lighting
        if shown is None or len(shown.lamps) != len(lighting.lamps):
            expected = "a scene shown in light" if shown is None else f"{len(shown.lamps)} lamps"
            raise ValueError(
                f"relight(lighting): expected {expected}, got {len(lighting.lamps)} lamps"
            )
        self._begin("relight")
        self._light(lighting)
        self._lighting = lighting

    def move(self, surface: int, vertices: FloatArray, normals: FloatArray) -> None:
        """Give a surface of the scene new vertices and normals, as each pose of a character does.

        Args:
            surface: its number in the sequence that was shown.
            vertices: (V, 3) world, metres; V must stay the same.
            normals: (V, 3) unit.

        Raises:
            ValueError: another number of vertices.
            RuntimeError: the renderer is closed.
            ContextLost: its context is gone.
        """
        self._begin("move")
        self._move(surface, vertices, normals)

    def render(self, camera: Camera, world_T_camera: Motor) -> Layer:
        """Draw the scene.

        Args:
            camera: pinhole, of the renderer's size.
            world_T_camera: pose, OpenCV axes, batch shape ().

        Returns:
            The image with premultiplied alpha, and depth along the optical axis in metres.

        Raises:
            ValueError: a camera with distortion or of another size.
            RuntimeError: no scene was shown, the renderer is closed, or OpenGL failed.
            ContextLost: its context is gone.
        """
        if not self._shown:
            raise RuntimeError("render: call show() first, and not after close()")
        if camera.model != "pinhole" or (camera.width, camera.height) != self._size:
            raise ValueError(
                f"render(camera): expected a pinhole camera of {self._size[0]} x {self._size[1]}, "
                f"got {camera.model} of {camera.width} x {camera.height}"
            )
        self._begin("render")
        return self._render(camera, world_T_camera)

    def _begin(self, verb: str) -> None:
        if not self._open:
            raise RuntimeError(f"{verb}: the renderer was closed; call nothing after close()")
        self._context.make_current()

    @abstractmethod
    def _set_up(self) -> None:
        """Make what lasts as long as the renderer; the context is current."""

    @abstractmethod
    def _free(self) -> None:
        """Free everything; the context is current."""

    @abstractmethod
    def _forget(self) -> None:
        """Let go of what went with the context."""

    @abstractmethod
    def _show(self, surfaces: Sequence[Surface], lighting: Lighting | None) -> None: ...

    @abstractmethod
    def _light(self, lighting: Lighting) -> None: ...

    @abstractmethod
    def _move(self, surface: int, vertices: FloatArray, normals: FloatArray) -> None: ...

    @abstractmethod
    def _render(self, camera: Camera, world_T_camera: Motor) -> Layer: ...


def check_size(width: int, height: int, largest: int | None = None) -> None:
    """Refuse images without pixels, and such as OpenGL cannot hold.

    Raises ValueError: a size below 1 or above `largest`.
    """
    if width <= 0 or height <= 0:
        raise ValueError(f"renderer: expected a size of 1 pixel or more, got {width} x {height}")
    if largest is not None and max(width, height) > largest:
        raise ValueError(
            f"renderer: expected at most {largest} pixels a side, as much as this OpenGL holds, "
            f"got {width} x {height}"
        )


def check_vertices(shape: tuple[int, ...], vertices: FloatArray, normals: FloatArray) -> None:
    """Refuse vertices of another number than were shown. Raises ValueError: as said."""
    if vertices.shape != shape or normals.shape != shape:
        raise ValueError(
            f"move(vertices): expected shape {shape} for vertices and normals, got "
            f"{vertices.shape} and {normals.shape}"
        )
