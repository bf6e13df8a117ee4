"""Offscreen renderer on bare OpenGL 3.3 through moderngl: a few calls a frame.

It draws what the pyrender renderer draws, in the same light and from the same cameras (see there
for the axes), several times as fast. Meshes may be moved by the caller, or carried by their joints
in a shader that calls the generated kernels (`bind`, `pose`).
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from motorcade.animation import Character, Placement
from motorcade.ga import FloatArray, Motor
from motorcade.render.backends.contexts import Context, new_context
from motorcade.render.backends.fast.meshes import Carried, Mesh, column_major
from motorcade.render.backends.fast.pictures import Box, Picture, ShadowMap
from motorcade.render.backends.fast.programs import Programs
from motorcade.render.backends.platform import ContextLost, RenderUnavailable, choose_platform
from motorcade.render.backends.renderer import (
    FAR_M,
    NEAR_M,
    OPENCV_T_OPENGL,
    check_camera,
    check_relit,
    check_size,
    shadow_camera,
)
from motorcade.render.scene import Layer, Lighting, Surface
from motorcade.tracking.cameras.camera import Camera

_SHADOW_UNIT, _TEXTURE_UNIT = 0, 1
# Texels of the shadow map's side; pictures larger than this get the larger one.
_SHADOW_SIZE, _LARGE_SHADOW_SIZE = 1024, 2048
# Keeps triangles that the sun grazes from shading themselves.
_SLOPE, _UNITS = 2.0, 1.0


class FastRenderer:
    """Draws one scene into pictures of one size. Use it as a context manager, or `close` it.

    Args:
        width: of the pictures, pixels.
        height: of the pictures, pixels.

    Raises:
        RenderUnavailable: this machine has no OpenGL, or no memory for the pictures.
        ValueError: a size that is not positive, or larger than OpenGL's largest.
    """

    def __init__(self, width: int, height: int) -> None:
        check_size(width, height)
        self._size = (width, height)
        self._context = new_context(choose_platform(), width, height)
        self._open = True
        self._meshes: list[Mesh] = []
        self._carried: dict[int, Carried] = {}
        self._shadows: ShadowMap | None = None
        self._lighting: Lighting | None = None
        self._shown = False
        try:
            self._gl = _moderngl_context(self._context)
            check_size(width, height, self._gl.info["GL_MAX_RENDERBUFFER_SIZE"])
            finish = ctypes.CFUNCTYPE(None)(self._context.address("glFinish"))
            self._picture = Picture(self._gl, self._size, finish)
        except BaseException:
            self._open = False
            self._context.destroy()
            raise
        self._programs = Programs(self._gl)
        self._gl.enable_only(self._gl.CULL_FACE | self._gl.DEPTH_TEST)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def driver(self) -> str:
        """What draws: the OpenGL driver's name of itself."""
        return str(self._gl.info["GL_RENDERER"])

    def close(self) -> None:
        """Free the scene and the OpenGL context; closing twice does nothing."""
        if self._open:
            self._open = False
            try:
                self._context.make_current()
                self._free()
            except ContextLost:
                # What it held went with it.
                self._meshes, self._carried = [], {}
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
        self._clear()
        lamps = 0 if lighting is None else len(lighting.lamps)
        for surface in surfaces:
            lit = lighting is not None
            self._meshes.append(Mesh(self._gl, self._programs, surface, lit=lit, lamps=lamps))
        self._lighting = lighting
        self._shown = True
        if lighting is not None:
            self._light(lighting)

    def relight(self, lighting: Lighting) -> None:
        """Light the scene that is shown anew, as light that follows a walker does.

        Args:
            lighting: with as many lamps as the scene was shown in.

        Raises:
            ValueError: another number of lamps, or a scene that was shown without light.
            RuntimeError: the renderer is closed.
            ContextLost: its context is gone.
        """
        check_relit(self._lighting, lighting)
        self._begin("relight")
        self._lighting = lighting
        self._light(lighting)

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
        self._meshes[surface].move(vertices, normals)

    def bind(self, surface: int, character: Character, method: str = "motor") -> None:
        """Have a shader carry a surface by the joints of a character.

        Args:
            surface: its number in the sequence that was shown: the character's mesh.
            character: rest pose, joints and weights.
            method: one of `SKIN_METHODS`.

        Raises:
            ValueError: an unknown method, or another number of vertices.
            RuntimeError: the renderer is closed.
            ContextLost: its context is gone.
        """
        self._begin("bind")
        carried = Carried(self._gl, self._programs, self._meshes[surface], character, method)
        earlier = self._carried.pop(surface, None)
        if earlier is not None:
            earlier.release()
        self._carried[surface] = carried

    def pose(self, surface: int, entries: FloatArray, placement: Placement | None = None) -> None:
        """Carry a bound surface; positions are good to about 1e-6 of the character's height.

        Args:
            surface: its number in the sequence that was shown.
            entries: (J, 8 or 12), as `palette` or `PoseRuntime.palette` gives them.
            placement: of the character in the world; by default it stands at the origin.

        Raises:
            ValueError: a palette of another shape, or a surface that was not bound.
            RuntimeError: the renderer is closed.
            ContextLost: its context is gone.
        """
        self._begin("pose")
        if surface not in self._carried:
            raise ValueError(f"pose(surface): expected a surface that was bound, got {surface}")
        # Nothing is drawn, but without a framebuffer OpenGL refuses.
        self._picture.drawn.use()
        self._carried[surface].pose(entries, placement)

    def vertices(self, surface: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Vertices and normals (V, 3) of a surface as they are drawn, world, read back.

        Raises:
            RuntimeError: the renderer is closed.
            ContextLost: its context is gone.
        """
        self._begin("vertices")
        return self._meshes[surface].read()

    def render(self, camera: Camera, world_T_camera: Motor) -> Layer:
        """Draw the scene.

        Args:
            camera: pinhole, of the renderer's size.
            world_T_camera: pose, OpenCV axes, batch shape ().

        Returns:
            The picture with premultiplied alpha, and depth along the optical axis in metres.

        Raises:
            ValueError: a camera with distortion or of another size.
            RuntimeError: no scene was shown, the renderer is closed, or OpenGL failed.
            ContextLost: its context is gone.
        """
        if not self._shown:
            raise RuntimeError("render: call show() first, and not after close()")
        check_camera(camera, self._size)
        self._begin("render")
        if self._lighting is not None:
            self._draw_shadows()
        self._draw(camera, world_T_camera)
        layer = self._picture.read()
        failed = self._gl.error
        if failed != "GL_NO_ERROR":
            raise RuntimeError(f"render: OpenGL failed: {failed}")
        return layer

    def _begin(self, verb: str) -> None:
        if not self._open:
            raise RuntimeError(f"{verb}: the renderer was closed; call nothing after close()")
        self._context.make_current()

    def _free(self) -> None:
        self._clear()
        self._picture.release()
        self._programs.release()
        if self._shadows is not None:
            self._shadows.release()

    def _clear(self) -> None:
        for carried in self._carried.values():
            carried.release()
        for mesh in self._meshes:
            mesh.release()
        self._meshes, self._carried = [], {}

    def _light(self, lighting: Lighting) -> None:
        """Tell the programs of the light, which stays until the scene is lit anew."""
        if self._shadows is None:
            large = max(self._size) > _SHADOW_SIZE
            self._shadows = ShadowMap(self._gl, _LARGE_SHADOW_SIZE if large else _SHADOW_SIZE)
        seen = column_major(_light_from_world(lighting))
        shadow = self._programs.shadow()
        shadow["light_from_world"].write(seen)
        travels = np.array(lighting.sun.direction)
        for program in {mesh.program for mesh in self._meshes}:
            program["light_from_world"].write(seen)
            program["shadow_map"] = _SHADOW_UNIT
            program["ambient"] = lighting.ambient
            program["to_sun"] = tuple(-travels / np.linalg.norm(travels))
            program["sun"] = tuple(lighting.sun.intensity * np.array(lighting.sun.color))
            if lighting.lamps:
                places = np.array([lamp.position_m for lamp in lighting.lamps], np.float32)
                light = [lamp.intensity * np.array(lamp.color) for lamp in lighting.lamps]
                program["lamp_position"].write(places.tobytes())
                program["lamp"].write(np.array(light, np.float32).tobytes())

    def _draw_shadows(self) -> None:
        assert self._shadows is not None  # made when the light was shown
        self._shadows.drawn.use()
        self._shadows.drawn.clear(depth=1.0)
        self._gl.polygon_offset = _SLOPE, _UNITS
        for mesh in self._meshes:
            mesh.in_shadow_map.render()
        self._gl.polygon_offset = 0.0, 0.0
        self._shadows.use(_SHADOW_UNIT)

    def _draw(self, camera: Camera, world_T_camera: Motor) -> None:
        pose = world_T_camera.as_matrix() @ OPENCV_T_OPENGL
        seen = column_major(_projection(camera) @ np.linalg.inv(pose))
        self._picture.begin(_seen_box(self._meshes, camera, world_T_camera))
        for mesh in self._meshes:
            mesh.program["clip_from_world"].write(seen)
            if self._lighting is not None:
                mesh.program["eye"] = tuple(pose[:3, 3])
                mesh.program["roughness"] = mesh.roughness
            if mesh.texture is not None:
                mesh.texture.use(_TEXTURE_UNIT)
                mesh.program["surface_texture"] = _TEXTURE_UNIT
            mesh.in_picture.render()


class _Loader:
    """A context of ours in the form in which moderngl takes contexts."""

    def __init__(self, context: Context) -> None:
        self.load = context.address

    def __enter__(self) -> None: ...

    def __exit__(self, *reason: object) -> None: ...

    def release(self) -> None: ...


def _moderngl_context(context: Context) -> Any:
    try:
        import moderngl
    except ModuleNotFoundError as missing:
        raise RenderUnavailable(
            'the fast renderer needs moderngl: pip install "motorcade[pipeline]"'
        ) from missing
    loader: Any = _Loader(context)
    return moderngl.create_context(context=loader)


def _seen_box(meshes: Sequence[Mesh], camera: Camera, world_T_camera: Motor) -> Box | None:
    """The part of the picture that can hold anything, or None where all of it can."""
    corners = [mesh.corners_m for mesh in meshes if mesh.corners_m is not None]
    if len(corners) < len(meshes) or not corners:
        return None
    seen = world_T_camera.inverse().apply(np.concatenate(corners))
    # A box that reaches behind the camera is not bounded by the pictures of its corners.
    if not np.all(seen[:, 2] > NEAR_M):
        return None
    pixels = camera.project(seen)
    size = np.array([camera.width, camera.height])
    # A pixel's samples lie up to half a pixel about its centre.
    first = np.clip(np.floor(pixels.min(axis=0) - 0.5), 0, size - 1).astype(int)
    last = np.clip(np.ceil(pixels.max(axis=0) + 0.5), 0, size - 1).astype(int)
    wide, high = last - first + 1
    return int(first[0]), int(camera.height - 1 - last[1]), int(wide), int(high)


def _projection(camera: Camera) -> FloatArray:
    """OpenGL's projection of a pinhole camera, whose pixels it counts from their corners."""
    x, y = camera.cx + 0.5, camera.cy + 0.5
    depth = FAR_M - NEAR_M
    return np.array([
        [2.0 * camera.fx / camera.width, 0.0, 1.0 - 2.0 * x / camera.width, 0.0],
        [0.0, 2.0 * camera.fy / camera.height, 2.0 * y / camera.height - 1.0, 0.0],
        [0.0, 0.0, -(FAR_M + NEAR_M) / depth, -2.0 * FAR_M * NEAR_M / depth],
        [0.0, 0.0, -1.0, 0.0],
    ])  # fmt: skip


def _light_from_world(lighting: Lighting) -> FloatArray:
    """The parallel projection of the shadow map."""
    pose, (nearest, farthest) = shadow_camera(lighting)
    radius, depth = lighting.shadow_radius_m, farthest - nearest
    projection = np.diag([1.0 / radius, 1.0 / radius, -2.0 / depth, 1.0])
    projection[2, 3] = -(farthest + nearest) / depth
    return np.asarray(projection @ np.linalg.inv(pose))
