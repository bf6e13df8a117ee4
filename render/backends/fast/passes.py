"""A frame of surfaces with materials, drawn in passes onto a canvas."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.backends.fast.bare import SAMPLE_MASK, BareFunctions
from motorcade.render.backends.fast.canvas import Canvas
from motorcade.render.backends.fast.materials import DrawnPart, Pictures, tell
from motorcade.render.backends.fast.parts import MeshParts, draw_triangles
from motorcade.render.backends.fast.programs import Box
from motorcade.tracking.cameras.camera import Camera


def draw_materials(
    gl: Any,
    bare: BareFunctions,
    canvas: Canvas,
    pictures: Pictures,
    scene: Sequence[MeshParts],
    clip_from_world: bytes,
    camera: Camera,
    world_T_camera: Motor,
    box: Box | None,
) -> None:
    """Draw which triangles are seen, over them what one sees through, then the light."""
    eye = tuple(world_T_camera.translation_m)
    canvas.cover(box)
    for mesh in scene:
        for part in mesh.covering:
            tell(part.covering, "clip_from_world", clip_from_world)
            part.use_covering()
            _cull(gl, part)
            _cover(gl, bare, canvas, part)
    pictures.use_table()
    _blend(gl, canvas, scene, clip_from_world, world_T_camera)
    canvas.shade()
    rays = _rays(camera, world_T_camera)
    places = canvas.sample_places.astype(np.float32).tobytes()
    for mesh in scene:
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
            canvas.light(program, first, first + part.part.stop - part.part.first)


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
    waiting.sort(key=lambda one: -one[0])
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
    """What takes a place in OpenGL's picture (x, y from the bottom, 1) to its ray, one metre deep.

    Column by column, in the world.
    """
    x, y = camera.cx + 0.5, camera.height - camera.cy - 0.5
    in_camera: FloatArray = np.array(
        [[1.0 / camera.fx, 0.0, -x / camera.fx], [0.0, -1.0 / camera.fy, y / camera.fy], [0, 0, 1]]
    )
    turned = world_T_camera.rotor.as_matrix() @ in_camera
    return np.ascontiguousarray(turned.T, np.float32).tobytes()
