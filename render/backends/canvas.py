"""What materials are drawn into: which triangle each sample shows, light, and what is read.

A frame of surfaces with materials, drawn in passes onto a canvas.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.backends.materials import DrawnPart, Images, tell
from motorcade.render.backends.meshes import MeshParts, draw_triangles
from motorcade.render.backends.platform import RenderUnavailable
from motorcade.render.backends.programs import (
    FRAMEBUFFER_SRGB,
    SAMPLE_MASK,
    SAMPLES,
    SRGB8_ALPHA8,
    BareFunctions,
    Box,
    Programs,
)
from motorcade.render.scene import Layer
from motorcade.tracking.cameras.camera import Camera

MOST_PARTS = 1 << 16
"""Depths that mark parts of meshes; more of them than this cannot be told apart."""
NUMBER_UNIT, LIGHT_UNIT, DEPTH_UNIT, BEFORE_UNIT = 12, 13, 14, 15


class Canvas:
    """Images of one size in the making.

    First the number of the triangle that each of four samples a pixel shows (`cover`), and what one
    sees through (`blend`); then light, where there is anything (`shade`); then all is put together
    and read (`read`). A pixel's light is computed once for each triangle in it, however many
    triangles were drawn there.

    Raises RenderUnavailable: the memory for it cannot be had.
    """

    def __init__(
        self, gl: Any, bare: BareFunctions, programs: Programs, size: tuple[int, int]
    ) -> None:
        import moderngl

        self._gl, self._bare, self._programs, self._size = gl, bare, programs, size
        self._box: Box = (0, 0, *size)
        self._held: list[Any] = []
        self._over: tuple[Any, Any, Any] | None = None
        self._blended, self._parts = False, 0
        self._wholes: dict[Any, Any] = {}
        try:
            self._numbers = self._hold(gl.texture(size, 1, samples=SAMPLES, dtype="u4"))
            self._depth = self._hold(gl.depth_texture(size, samples=SAMPLES))
            self._covered = self._hold(gl.framebuffer([self._numbers], self._depth))
            self._light = self._hold(gl.texture(size, 4, dtype="f2"))
            marks = self._hold(gl.depth_renderbuffer(size))
            self._lit = self._hold(gl.framebuffer([self._light], marks))
            image = self._hold(gl.texture(size, 4))
            metres = self._hold(gl.texture(size, 1, dtype="f4"))
            self._resolved = self._hold(gl.framebuffer([image, metres]))
        except moderngl.Error as refused:
            self.release()
            raise RenderUnavailable(
                f"no memory for images of {size[0]} x {size[1]} with {SAMPLES} samples: {refused}"
            ) from refused
        self._covered.use()
        self.sample_places = np.floor(2.0 * bare.sample_places(SAMPLES)) / 2.0 + 0.25

    def use(self) -> None:
        """Have some framebuffer in use: without one OpenGL refuses what draws nothing, too."""
        self._covered.use()

    def cover(self, box: Box) -> None:
        """Draw numbers of triangles from now on, after clearing; nothing lies outside a box."""
        self._box, self._blended = box, False
        self._covered.scissor = self._box
        self._covered.use()
        self._gl.enable_only(self._gl.DEPTH_TEST)
        self._bare.clear_numbers()

    def blend(self) -> None:
        """Draw what one sees through, from now on, over what it covers."""
        if self._over is None:
            kind = {"internal_format": SRGB8_ALPHA8}
            drawn = self._hold(self._gl.texture(self._size, 4, samples=SAMPLES, **kind))
            shown = self._hold(self._gl.texture(self._size, 4, **kind))
            into = self._hold(self._gl.framebuffer([drawn], self._depth))
            self._over = into, shown, self._hold(self._gl.framebuffer([shown]))
        into, _, _ = self._over
        self._blended = True
        into.scissor, into.depth_mask = self._box, False
        into.color_mask = (True,) * 4
        into.use()
        into.clear(0.0, 0.0, 0.0, 0.0)
        self._gl.enable_only(self._gl.DEPTH_TEST | self._gl.BLEND)
        self._gl.enable_direct(FRAMEBUFFER_SRGB)
        self._gl.blend_func = self._gl.ONE, self._gl.ONE_MINUS_SRC_ALPHA

    def blend_depth(self) -> None:
        """Draw the depth of the same from now on."""
        assert self._over is not None  # made by blend
        into, _, resolved = self._over
        resolved.scissor = self._box
        self._gl.copy_framebuffer(resolved, into)
        self._gl.disable_direct(FRAMEBUFFER_SRGB)
        into.depth_mask, into.color_mask = True, (False,) * 4
        into.use()

    def shade(self) -> None:
        """Draw light from now on, by `light`."""
        self._lit.scissor = self._box
        self._lit.depth_mask = True
        self._lit.use()
        self._lit.clear(0.0, 0.0, 0.0, 0.0, depth=1.0)
        self._lit.depth_mask = False
        self._gl.blend_func = self._gl.ONE, self._gl.ONE
        self._numbers.use(NUMBER_UNIT)
        self._parts = 0

    def light(self, program: Any, first: int, stop: int, box: Box) -> None:
        """Add the light of triangles from `first` to before `stop`, which lie in a box."""
        self._lit.scissor = box
        self._parts += 1
        mark = self._parts / MOST_PARTS
        marked = self._programs.marked()
        # One framebuffer for both: to change it costs a flush.
        self._lit.color_mask, self._lit.depth_mask = (False,) * 4, True
        self._lit.use()
        self._gl.depth_func = "1"
        self._gl.enable_only(self._gl.DEPTH_TEST)
        for shader in (marked, program):
            tell(shader, "mark", mark)
            tell(shader, "covered", NUMBER_UNIT)
            tell(shader, "first", first)
            tell(shader, "stop", stop)
        self._fill(marked)
        self._lit.color_mask, self._lit.depth_mask = (True,) * 4, False
        self._lit.use()
        self._gl.depth_func = "=="
        self._gl.enable_only(self._gl.DEPTH_TEST | self._gl.BLEND)
        self._fill(program)
        self._gl.depth_func = "<"

    def _fill(self, program: Any) -> None:
        """Have a program draw every pixel of the box."""
        if program not in self._wholes:
            self._wholes[program] = self._hold(self._gl.vertex_array(program, []))
        self._wholes[program].render(vertices=3)

    def read(self, depths: tuple[float, float]) -> Layer:
        """What was drawn from near to far, top row first, with depth in metres."""
        near, far = depths
        program = self._programs.resolved(blended=self._blended)
        self._resolved.scissor = self._box
        self._resolved.use()
        self._gl.enable_only(self._gl.NOTHING)
        self._light.use(LIGHT_UNIT)
        self._depth.use(DEPTH_UNIT)
        program["light"], program["depths"] = LIGHT_UNIT, DEPTH_UNIT
        program["near_and_fall"] = near, near / (far - near)
        if self._blended:
            assert self._over is not None  # made by blend
            self._over[1].use(BEFORE_UNIT)
            program["before"] = BEFORE_UNIT
        self._fill(program)
        self._bare.finish()
        width, height = self._size
        left, bottom, wide, high = self._box
        rgba, metres = np.empty((high, wide, 4), np.uint8), np.empty((high, wide), np.float32)
        self._resolved.read_into(rgba, self._box, 4)
        self._resolved.read_into(metres, self._box, 1, attachment=1, dtype="f4")
        layer = Layer(np.zeros((height, width, 4), np.uint8), np.zeros((height, width), np.float32))
        # OpenGL's rows begin at the bottom.
        held = slice(height - bottom - high, height - bottom), slice(left, left + wide)
        layer.rgba[held], layer.depth_m[held] = rgba[::-1], metres[::-1]
        return layer

    def release(self) -> None:
        """Free it."""
        for part in reversed(self._held):
            part.release()
        self._held, self._wholes, self._over = [], {}, None

    def _hold(self, resource: Any) -> Any:
        self._held.append(resource)
        return resource


def draw_materials(
    gl: Any,
    bare: BareFunctions,
    canvas: Canvas,
    images: Images,
    scene: Sequence[tuple[MeshParts, Box | None]],
    clip_from_world: bytes,
    camera: Camera,
    world_T_camera: Motor,
) -> None:
    """Draw which triangles are seen, over them what one sees through, then the light.

    Each mesh comes with the part of the image that can show it, or with None where none can.
    """
    eye = tuple(world_T_camera.translation_m)
    in_view = [(mesh, box) for mesh, box in scene if box is not None]
    canvas.cover(_around([box for _, box in in_view]))
    for mesh, _ in in_view:
        for part in mesh.covering:
            tell(part.covering, "clip_from_world", clip_from_world)
            part.use_covering()
            _cull(gl, part)
            _cover(gl, bare, canvas, part)
    images.use_table()
    _blend(gl, canvas, [mesh for mesh, _ in in_view], clip_from_world, world_T_camera)
    canvas.shade()
    rays = _rays(camera, world_T_camera)
    places = canvas.sample_places.astype(np.float32).tobytes()
    for mesh, box in in_view:
        for part in mesh.covering:
            mesh.use(part)
            program = part.program
            for name, value in (
                ("samples", places),
                ("ray_from_pixel", rays),
                ("seen_from", eye),
                ("eye", eye),
            ):
                tell(program, name, value)
            first = part.first_number
            canvas.light(program, first, first + part.part.stop - part.part.first, box)


def _around(boxes: Sequence[Box]) -> Box:
    """The smallest box that holds all of them, of one pixel without any."""
    corners = np.array(boxes or [(0, 0, 1, 1)])
    low, high = corners[:, :2].min(axis=0), (corners[:, :2] + corners[:, 2:]).max(axis=0)
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])


def _cover(gl: Any, bare: BareFunctions, canvas: Canvas, part: DrawnPart) -> None:
    """The numbers of a part's triangles; where a map cuts them out, each sample by itself."""
    if not part.masked:
        draw_triangles(part)
        return
    gl.enable_direct(SAMPLE_MASK)
    for number, place in enumerate(canvas.sample_places):
        bare.draw_samples(1 << number)
        tell(part.covering, "sample_place", tuple(place))
        draw_triangles(part)
    gl.disable_direct(SAMPLE_MASK)


def _blend(
    gl: Any,
    canvas: Canvas,
    scene: Sequence[MeshParts],
    clip_from_world: bytes,
    world_T_camera: Motor,
) -> None:
    """What one sees through, from the farthest on, and then its depth."""
    camera_T_world = world_T_camera.inverse()
    eye = tuple(world_T_camera.translation_m)
    waiting = []
    for mesh in scene:
        for part, middle_m in zip(mesh.blended, mesh.middles_m, strict=True):
            waiting.append((float(camera_T_world.apply(middle_m)[2]), part))
    if not waiting:
        return
    waiting.sort(key=lambda layer: -layer[0])
    canvas.blend()
    for _, part in waiting:
        part.use()
        tell(part.program, "clip_from_world", clip_from_world)
        tell(part.program, "eye", eye)
        _cull(gl, part)
        if part.material.double_sided:
            # Backs first: they lie behind.
            gl.enable(gl.CULL_FACE)
            gl.cull_face = "front"
            draw_triangles(part)
            gl.cull_face = "back"
        draw_triangles(part)
    canvas.blend_depth()
    for _, part in waiting:
        _cull(gl, part)
        draw_triangles(part)


def _cull(gl: Any, part: DrawnPart) -> None:
    """Whether the backs of triangles are drawn too."""
    if part.material.double_sided:
        gl.disable(gl.CULL_FACE)
    else:
        gl.enable(gl.CULL_FACE)


def _rays(camera: Camera, world_T_camera: Motor) -> bytes:
    """What takes a place in OpenGL's image (x, y from the bottom, 1) to its ray, one metre deep.

    Column by column, in the world.
    """
    x, y = camera.cx + 0.5, camera.height - camera.cy - 0.5
    in_camera: FloatArray = np.array(
        [[1.0 / camera.fx, 0.0, -x / camera.fx], [0.0, -1.0 / camera.fy, y / camera.fy], [0, 0, 1]]
    )
    turned = world_T_camera.rotor.as_matrix() @ in_camera
    return np.ascontiguousarray(turned.T, np.float32).tobytes()
