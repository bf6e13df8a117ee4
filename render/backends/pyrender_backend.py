"""Offscreen renderer on pyrender 0.1.45: OpenGL through EGL or OSMesa, no window.

Takes OpenCV cameras: axes x right, y down, z forward, pixel (0, 0) at the centre of the top-left
pixel. OpenGL counts from the corner of that pixel, hence the half pixel added to the principal
point, and looks along −z with y up, hence the half turn about x.
Drawing is multisampled (4 samples a pixel); edges come out premultiplied by their coverage.
"""

from __future__ import annotations

import ctypes
import logging
from collections.abc import Sequence
from typing import Any

import numpy as np

from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.animation.vectors import box_corners
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.backends.platform import RenderUnavailable, choose_platform
from motorcade.render.backends.renderer import (
    OPENCV_T_OPENGL,
    Renderer,
    check_vertices,
    clip_range,
    shadow_camera,
)
from motorcade.render.scene import ImageArray, Lamp, Layer, Lighting, Sun, Surface
from motorcade.tracking.cameras.camera import Camera

log = logging.getLogger("motorcade.render")


class OffscreenRenderer(Renderer):
    """The renderer on pyrender; used as every `Renderer`.

    >>> from motorcade.render import OffscreenRenderer, Renderer
    >>> issubclass(OffscreenRenderer, Renderer)
    True
    >>> OffscreenRenderer(640, 0)
    Traceback (most recent call last):
    ValueError: renderer: expected a size of 1 pixel or more, got 640 x 0
    """

    def _set_up(self) -> None:
        self._pyrender = _import_pyrender()
        self._renderer: Any = self._pyrender.renderer.Renderer(*self._size)
        self._scene: Any = None
        self._primitives: list[Any] = []

    def _free(self) -> None:
        self._renderer.delete()

    def _forget(self) -> None:
        self._scene = None

    def _show(self, surfaces: Sequence[Surface], lighting: Lighting | None) -> None:
        pyrender = self._pyrender
        _name_left_out(surfaces)
        ambient = (0.0, 0.0, 0.0) if lighting is None else lighting.mean_ambient
        self._scene = _ordered_scene(pyrender, ambient)
        self._primitives = [
            self._primitive(surface, lit=lighting is not None) for surface in surfaces
        ]
        nodes = [self._scene.add(pyrender.Mesh([one])) for one in self._primitives]
        self._renderer._sorted_mesh_nodes = lambda scene: nodes
        if lighting is not None:
            self._add_lights(lighting)
        self._camera: Any = self._scene.add(
            pyrender.IntrinsicsCamera(1.0, 1.0, 0.0, 0.0, znear=1.0, zfar=2.0)
        )

    def _light(self, lighting: Lighting) -> None:
        self._scene.ambient_light = lighting.mean_ambient
        self._set_lights(lighting)

    def _move(self, surface: int, vertices: FloatArray, normals: FloatArray) -> None:
        primitive = self._primitives[surface]
        check_vertices(primitive.positions.shape, vertices, normals)
        bounds = primitive.bounds
        primitive.positions = vertices
        primitive.normals = normals
        # The shadow camera is set by `Lighting`, so nothing needs the bounds anew every frame.
        primitive._bounds = bounds
        if primitive._in_context():
            _upload(primitive)

    def _render(self, camera: Camera, world_T_camera: Motor) -> Layer:
        lens = self._camera.camera
        lens.fx, lens.fy = camera.fx, camera.fy
        lens.cx, lens.cy = camera.cx + 0.5, camera.cy + 0.5
        lens.znear, lens.zfar = self._depths(world_T_camera)
        self._scene.set_pose(self._camera, (world_T_camera @ OPENCV_T_OPENGL).as_matrix())
        flags = self._pyrender.RenderFlags.OFFSCREEN | self._pyrender.RenderFlags.RGBA
        if self._lighting is not None:
            flags |= self._pyrender.RenderFlags.SHADOWS_DIRECTIONAL
        else:
            flags |= self._pyrender.RenderFlags.FLAT
        rgba, depth = self._renderer.render(self._scene, flags)
        rgba = np.ascontiguousarray(rgba)
        if self._lighting is not None:
            _encode_anew(rgba)
        return Layer(rgba, np.ascontiguousarray(depth))

    def _depths(self, world_T_camera: Motor) -> tuple[float, float]:
        """Nearest and farthest depth of the primitives' boxes."""
        boxes = [box_corners(one.positions) for one in self._primitives if len(one.positions)]
        if not boxes:
            return clip_range(np.zeros(0))
        return clip_range(world_T_camera.inverse().apply(np.concatenate(boxes))[:, 2])

    def _primitive(self, surface: Surface, *, lit: bool) -> Any:
        """A surface in pyrender's form; vertex colours become linear unless they are shown flat."""
        pyrender = self._pyrender
        texture = None
        if surface.texture is not None:
            texture = pyrender.Texture(source=surface.texture, source_channels="RGB")
        colors = None
        if surface.colors is not None:
            shown = to_linear(surface.colors) if lit else surface.colors
            colors = np.concatenate([shown, np.ones((len(shown), 1))], axis=1)
        material = pyrender.MetallicRoughnessMaterial(
            baseColorFactor=(1.0, 1.0, 1.0, 1.0),
            baseColorTexture=texture,
            metallicFactor=0.0,
            roughnessFactor=surface.roughness,
        )
        return pyrender.Primitive(
            positions=surface.vertices,
            normals=surface.normals,
            texcoord_0=surface.texture_coordinates,
            color_0=colors,
            indices=surface.triangles,
            material=material,
        )

    def _add_lights(self, lighting: Lighting) -> None:
        pyrender = self._pyrender
        lights = [pyrender.DirectionalLight()] + [pyrender.PointLight() for _ in lighting.lamps]
        self._scene.light_order = [self._scene.add(light) for light in lights]
        self._set_lights(lighting)

    def _set_lights(self, lighting: Lighting) -> None:
        """Give every light of the scene its place, strength and colour."""
        radius = lighting.shadow_radius_m
        # pyrender fits the shadow map to the whole scene; a ball of ours keeps it sharp and still.
        world_T_light, (nearest, farthest) = shadow_camera(lighting)
        lens = self._pyrender.OrthographicCamera(radius, radius, znear=nearest, zfar=farthest)
        self._renderer._get_light_cam_matrices = lambda scene, node, flags: (
            world_T_light.inverse().as_matrix(),
            lens.get_projection_matrix(),
        )
        poses = [world_T_light.as_matrix()] + [np.eye(4) for _ in lighting.lamps]
        for pose, lamp in zip(poses[1:], lighting.lamps, strict=True):
            pose[:3, 3] = lamp.position_m
        shining: tuple[Sun | Lamp, ...] = (lighting.sun, *lighting.lamps)
        for node, pose, light in zip(self._scene.light_order, poses, shining, strict=True):
            node.light.color, node.light.intensity = light.color, light.intensity
            self._scene.set_pose(node, pose)


def _name_left_out(surfaces: Sequence[Surface]) -> None:
    """Say what of materials is not drawn: colours of vertices stand for all of it."""
    parts = [
        part
        for surface in surfaces
        if surface.appearance is not None
        for part in surface.appearance.parts
    ]
    left = {name.replace("_", " ") for part in parts for name in part.material.maps}
    left |= {"transparency" for part in parts if part.material.alpha_mode != "opaque"}
    if left:
        log.warning(
            "pyrender draws the colours of vertices, without %s; the fast renderer draws them",
            ", ".join(sorted(left)),
        )


def _encode_anew(rgba: ImageArray) -> None:
    """Light by sRGB's curve, in place, from pyrender's, a power of 1 / 2.2; still times alpha."""
    seen = rgba[..., 3] > 0
    values = rgba[seen].astype(np.float64)
    alpha = values[:, 3:]
    own = to_srgb(np.minimum(values[:, :3] / alpha, 1.0) ** 2.2)
    rgba[seen, :3] = np.rint(own * alpha)


def _import_pyrender() -> Any:
    """pyrender, with the platform chosen first and a name restored that NumPy 2 took away."""
    choose_platform()
    vars(np).setdefault("infty", np.inf)
    try:
        import pyrender
    except ModuleNotFoundError as missing:
        raise RenderUnavailable(
            'this renderer needs pyrender: pip install "motorcade[pyrender]"'
        ) from missing

    _let_contexts_be_keys()
    # When it is collected, its renderer deletes framebuffers once more, by number and in whatever
    # context is then current: another renderer's.
    if "__del__" in vars(pyrender.renderer.Renderer):
        del pyrender.renderer.Renderer.__del__
    return pyrender


def _let_contexts_be_keys() -> None:
    """Have PyOpenGL know OSMesa contexts by number: as keys of a dictionary, pointers fail."""
    from OpenGL import platform

    if choose_platform().name == "osmesa":
        platform.PLATFORM.GetCurrentContext.restype = ctypes.c_void_p


def _ordered_scene(pyrender: Any, ambient: tuple[float, float, float]) -> Any:
    """A pyrender scene whose lights keep their order.

    pyrender holds meshes and lights in sets, whose order changes from run to run: what lies at
    the same depth, and the last bit of summed light, would change with it.
    """
    ordered = type(
        "OrderedScene",
        (pyrender.Scene,),
        {"light_order": [], "light_nodes": property(lambda scene: scene.light_order)},
    )
    return ordered(bg_color=(0.0, 0.0, 0.0, 0.0), ambient_light=ambient)


def _upload(primitive: Any) -> None:
    """Write positions and normals into the vertex buffer that pyrender made for a primitive."""
    from OpenGL import GL

    rows = [primitive.positions, primitive.normals]
    rows += [part for part in (primitive.texcoord_0, primitive.color_0) if part is not None]
    data = np.ascontiguousarray(np.hstack(rows), dtype=np.float32)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, primitive._buffers[0])
    GL.glBufferSubData(GL.GL_ARRAY_BUFFER, 0, data.nbytes, data)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, 0)
