"""Offscreen renderer on bare OpenGL 3.3 through moderngl: a few calls a frame.

It draws what the pyrender renderer draws, in the same light and from the same cameras (see there
for the axes), several times as fast. Meshes may be moved by the caller, or carried by their joints
in a shader that calls the generated kernels (`bind`, `pose`). They are drawn as numbers of
triangles first, then lit where they are seen (see `passes`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation import Character, Placement
from motorcade.animation.vectors import box_corners
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.backends.canvas import Canvas, draw_materials
from motorcade.render.backends.materials import Images, tell
from motorcade.render.backends.meshes import MeshParts, RenderMesh, SkinnedMesh, column_major
from motorcade.render.backends.platform import Context, RenderUnavailable
from motorcade.render.backends.programs import BareFunctions, Box, Programs, ShadowMap
from motorcade.render.backends.renderer import (
    OPENCV_T_OPENGL,
    Renderer,
    check_size,
    clip_range,
    projection,
    shadow_camera,
)
from motorcade.render.lens import seen_extent
from motorcade.render.scene import Layer, Lighting, Surface
from motorcade.tracking.cameras.camera import Camera

_SHADOW_UNIT = 0
FAR = 64.0
"""Sizes of a scene from the world's origin at which it is counted from its own middle: seven digits
of coordinates are five of the scene there."""
# Texels of the shadow map's side; images larger than this get the larger one.
_SHADOW_SIZE, _LARGE_SHADOW_SIZE = 1024, 2048
# Keeps triangles that the sun grazes from shading themselves.
_SLOPE, _UNITS = 2.0, 1.0


class FastRenderer(Renderer):
    """The renderer that draws several times as fast as pyrender's.

    It is used as every `Renderer`. Besides, a surface can be bound to the joints of a character
    (`bind`), which then carry its vertices in a shader (`pose`).
    """

    def _set_up(self) -> None:
        self._meshes: list[RenderMesh] = []
        self._origin_m = np.zeros(3)
        self._skinned: dict[int, SkinnedMesh] = {}
        self._shadow_map: ShadowMap | None = None
        self._gl = _moderngl_context(self._context)
        check_size(*self._size, self._gl.info["GL_MAX_RENDERBUFFER_SIZE"])
        self._bare = BareFunctions(self._context.address)
        self._images = Images(self._gl, self._bare.texture_parameter)
        self._programs = Programs(self._gl)
        self._canvas = Canvas(self._gl, self._bare, self._programs, self._size)
        self._gl.enable_only(self._gl.CULL_FACE | self._gl.DEPTH_TEST)

    @property
    def driver(self) -> str:
        """What draws: the OpenGL driver's name of itself."""
        return str(self._gl.info["GL_RENDERER"])

    def _show(self, surfaces: Sequence[Surface], lighting: Lighting | None) -> None:
        self._clear()
        lamps = 0 if lighting is None else len(lighting.lamps)
        lit, first = lighting is not None, 1
        self._origin_m = _origin(surfaces)

        def parts(surface: Surface, vertices: Any) -> MeshParts:
            return MeshParts(
                self._gl,
                self._bare,
                self._programs,
                self._images,
                surface,
                vertices,
                lit=lit,
                lamps=lamps,
                first_number=first,
            )

        for surface in surfaces:
            self._meshes.append(
                RenderMesh(self._gl, self._programs, surface, parts, self._origin_m, lit=lit)
            )
            first += len(surface.triangles)
        if lighting is not None:
            self._light(lighting)

    def _move(self, surface: int, vertices: FloatArray, normals: FloatArray) -> None:
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
        skinned = SkinnedMesh(self._gl, self._programs, self._meshes[surface], character, method)
        earlier = self._skinned.pop(surface, None)
        if earlier is not None:
            earlier.release()
        self._skinned[surface] = skinned

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
        if surface not in self._skinned:
            raise ValueError(f"pose(surface): expected a surface that was bound, got {surface}")
        # Nothing is drawn, but without a framebuffer OpenGL refuses.
        self._canvas.use()
        self._skinned[surface].pose(entries, placement)

    def vertices(self, surface: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Vertices and normals (V, 3) of a surface as they are drawn, world, read back.

        Raises RuntimeError: the renderer is closed. ContextLost: its context is gone.
        """
        self._begin("vertices")
        return self._meshes[surface].read()

    def _render(self, camera: Camera, world_T_camera: Motor) -> Layer:
        if self._lighting is not None:
            self._draw_shadow_map()
        from_origin = Motor.from_translation(-self._origin_m)
        layer = self._draw(camera, from_origin @ world_T_camera)
        failed = self._gl.error
        if failed != "GL_NO_ERROR":
            raise RuntimeError(f"render: OpenGL failed: {failed}")
        return layer

    def _free(self) -> None:
        self._clear()
        self._canvas.release()
        self._programs.release()
        if self._shadow_map is not None:
            self._shadow_map.release()

    def _forget(self) -> None:
        self._meshes, self._skinned = [], {}

    def _clear(self) -> None:
        for skinned in self._skinned.values():
            skinned.release()
        for mesh in self._meshes:
            mesh.release()
        self._images.release()
        self._forget()

    def _light(self, lighting: Lighting) -> None:
        """Tell the programs of the light, which stays until the scene is lit anew."""
        lighting = lighting.translated_by(-self._origin_m)
        if self._shadow_map is None:
            large = max(self._size) > _SHADOW_SIZE
            self._shadow_map = ShadowMap(self._gl, _LARGE_SHADOW_SIZE if large else _SHADOW_SIZE)
        seen = column_major(_light_from_world(lighting))
        shadow = self._programs.shadow()
        shadow["light_from_world"].write(seen)
        travels = np.array(lighting.sun.direction)
        for program in set[Any]().union(*(mesh.parts.programs for mesh in self._meshes)):
            if "light_from_world" in program:
                program["light_from_world"].write(seen)
            tell(program, "shadow_map", _SHADOW_UNIT)
            tell(program, "ambient", lighting.ambient)
            around = np.array(lighting.surroundings or np.zeros((9, 3)), np.float32)
            tell(program, "around", around.tobytes())
            tell(program, "to_sun", tuple(-travels / np.linalg.norm(travels)))
            tell(program, "sun", tuple(lighting.sun.intensity * np.array(lighting.sun.color)))
            if lighting.lamps and "lamp" in program:
                places = np.array([lamp.position_m for lamp in lighting.lamps], np.float32)
                light = [lamp.intensity * np.array(lamp.color) for lamp in lighting.lamps]
                program["lamp_position"].write(places.tobytes())
                program["lamp"].write(np.array(light, np.float32).tobytes())

    def _draw_shadow_map(self) -> None:
        assert self._shadow_map is not None  # made when the light was shown
        self._shadow_map.drawn.use()
        self._gl.enable_only(self._gl.CULL_FACE | self._gl.DEPTH_TEST)
        self._shadow_map.drawn.clear(depth=1.0)
        self._gl.polygon_offset = _SLOPE, _UNITS
        for mesh in self._meshes:
            self._cull(both_sides=mesh.parts.both_sides)
            if mesh.in_shadow_map is not None:
                mesh.in_shadow_map.render()
        self._gl.polygon_offset = 0.0, 0.0
        self._shadow_map.use(_SHADOW_UNIT)

    def _draw(self, camera: Camera, world_T_camera: Motor) -> Layer:
        opengl_T_world = (world_T_camera @ OPENCV_T_OPENGL).inverse()
        depths = _depths(self._meshes, world_T_camera)
        seen = column_major(projection(camera, *depths) @ opengl_T_world.as_matrix())
        boxes = [_seen_box(mesh, camera, world_T_camera, depths[0]) for mesh in self._meshes]
        draw_materials(
            self._gl,
            self._bare,
            self._canvas,
            self._images,
            [(mesh.parts, box) for mesh, box in zip(self._meshes, boxes, strict=True)],
            seen,
            camera,
            world_T_camera,
        )
        return self._canvas.read(depths)

    def _cull(self, *, both_sides: bool) -> None:
        """Whether the backs of triangles are drawn too."""
        if both_sides:
            self._gl.disable(self._gl.CULL_FACE)
        else:
            self._gl.enable(self._gl.CULL_FACE)


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


def _origin(surfaces: Sequence[Surface]) -> FloatArray:
    """The place (3,) from which shaders count: the world's, or what is drawn if that is far."""
    boxes = [box_corners(one.vertices) for one in surfaces if len(one.vertices)]
    if not boxes:
        return np.zeros(3)
    corners = np.concatenate(boxes)
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    size = np.linalg.norm(corners.max(axis=0) - corners.min(axis=0))
    return middle if np.linalg.norm(middle) > FAR * size else np.zeros(3)


def _depths(meshes: Sequence[RenderMesh], world_T_camera: Motor) -> tuple[float, float]:
    """Nearest and farthest depth of what the meshes reach."""
    corners = [mesh.reach_m for mesh in meshes if len(mesh.reach_m)]
    if not corners:
        return clip_range(np.zeros(0))
    return clip_range(world_T_camera.inverse().apply(np.concatenate(corners))[:, 2])


def _seen_box(mesh: RenderMesh, camera: Camera, world_T_camera: Motor, near: float) -> Box | None:
    """The part of the image that can hold any of a mesh: None of one that is not in view.

    All of the image where a shader carries the mesh, so that nobody knows where it is.
    """
    if mesh.corners_m is None:
        return None if len(mesh.reach_m) == 0 else (0, 0, camera.width, camera.height)
    seen = world_T_camera.inverse().apply(mesh.corners_m)
    before, behind = seen[seen[:, 2] >= near], seen[seen[:, 2] < near]
    # Where edges and diagonals of its box come through the plane from which on things are drawn.
    share = (before[:, None, 2:] - near) / (before[:, None, 2:] - behind[None, :, 2:])
    cut = before[:, None] + share * (behind[None] - before[:, None])
    hull = np.concatenate([before, cut.reshape(-1, 3)])
    if not len(hull):
        return None
    # A pixel's samples lie up to half a pixel about its centre, and half of one is for rounding.
    first, last = seen_extent(camera, hull, -np.inf, 1.0)
    wide, high = last - first + 1
    return int(first[0]), int(camera.height - 1 - last[1]), int(wide), int(high)


def _light_from_world(lighting: Lighting) -> FloatArray:
    """The parallel projection of the shadow map."""
    world_T_light, (nearest, farthest) = shadow_camera(lighting)
    radius, depth = lighting.shadow_radius_m, farthest - nearest
    matrix = np.diag([1.0 / radius, 1.0 / radius, -2.0 / depth, 1.0])
    matrix[2, 3] = -(farthest + nearest) / depth
    return np.asarray(matrix @ world_T_light.inverse().as_matrix())
