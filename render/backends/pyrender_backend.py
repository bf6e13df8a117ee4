"""Offscreen renderer on pyrender 0.1.45: OpenGL through EGL or OSMesa, no window.

Takes OpenCV cameras: axes x right, y down, z forward, pixel (0, 0) at the centre of the top-left
pixel. OpenGL counts from the corner of that pixel, hence the half pixel added to the principal
point, and looks along −z with y up, hence the half turn about x.
Drawing is multisampled (4 samples a pixel); edges come out premultiplied by their coverage.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np

from motorcade.ga import FloatArray, Motor
from motorcade.render.backends.contexts import new_context
from motorcade.render.backends.platform import ContextLost, choose_platform
from motorcade.render.backends.renderer import (
    FAR_M,
    NEAR_M,
    OPENCV_T_OPENGL,
    check_camera,
    check_moved,
    check_relit,
    check_size,
    linear,
    shadow_camera,
)
from motorcade.render.scene import Lamp, Layer, Lighting, Sun, Surface
from motorcade.tracking.cameras.camera import Camera


class OffscreenRenderer:
    """Draws one scene into pictures of one size. Use it as a context manager, or `close` it.

    Args:
        width: of the pictures, pixels.
        height: of the pictures, pixels.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: a size that is not positive.
    """

    def __init__(self, width: int, height: int) -> None:
        check_size(width, height)
        self._pyrender = _import_pyrender()
        self._context = new_context(choose_platform(), width, height)
        self._renderer: Any = self._pyrender.renderer.Renderer(width, height)
        self._size = (width, height)
        self._open = True
        self._scene: Any = None
        self._lighting: Lighting | None = None
        self._primitives: list[Any] = []

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
                self._renderer.delete()
            except ContextLost:
                self._scene = None  # what it held went with the context
            finally:
                self._context.destroy()

    def show(self, surfaces: Sequence[Surface], lighting: Lighting | None) -> None:
        """Set the scene, in place of any earlier one.

        Args:
            surfaces: what is drawn.
            lighting: the light; None draws colours and textures as they are, for surfaces whose
                light is painted on.
        """
        pyrender = self._pyrender
        ambient = (0.0, 0.0, 0.0) if lighting is None else lighting.ambient
        self._scene = _ordered_scene(pyrender, ambient)
        self._lighting = lighting
        self._primitives = [self._primitive(surface) for surface in surfaces]
        nodes = [self._scene.add(pyrender.Mesh([one])) for one in self._primitives]
        self._renderer._sorted_mesh_nodes = lambda scene: nodes
        if lighting is not None:
            self._add_lights(lighting)
        self._camera: Any = self._scene.add(
            pyrender.IntrinsicsCamera(1.0, 1.0, 0.0, 0.0, znear=NEAR_M, zfar=FAR_M)
        )

    def relight(self, lighting: Lighting) -> None:
        """Light the scene that is shown anew, as light that follows a walker does.

        Args:
            lighting: with as many lamps as the scene was shown in.

        Raises:
            ValueError: another number of lamps, or a scene that was shown without light.
        """
        check_relit(self._lighting, lighting)
        self._lighting = lighting
        self._scene.ambient_light = lighting.ambient
        self._set_lights(lighting)

    def move(self, surface: int, vertices: FloatArray, normals: FloatArray) -> None:
        """Give a surface of the scene new vertices and normals, as each pose of a character does.

        Args:
            surface: its number in the sequence that was shown.
            vertices: (V, 3) world, metres; V must stay the same.
            normals: (V, 3) unit.

        Raises:
            ValueError: another number of vertices.
        """
        primitive = self._primitives[surface]
        check_moved(primitive.positions.shape, vertices, normals)
        bounds = primitive.bounds
        primitive.positions = vertices
        primitive.normals = normals
        # The shadow camera is set by `Lighting`, so nothing needs the bounds anew every frame.
        primitive._bounds = bounds
        if primitive._in_context():
            self._context.make_current()
            _upload(primitive)

    def render(self, camera: Camera, world_T_camera: Motor) -> Layer:
        """Draw the scene.

        Args:
            camera: pinhole, of the renderer's size.
            world_T_camera: pose, OpenCV axes, batch shape ().

        Returns:
            The picture with premultiplied alpha, and depth along the optical axis in metres.

        Raises:
            ValueError: a camera with distortion or of another size.
            RuntimeError: no scene was shown, or the renderer is closed.
            ContextLost: its context is gone.
        """
        if self._scene is None or not self._open:
            raise RuntimeError("render: call show() first, and not after close()")
        check_camera(camera, self._size)
        lens = self._camera.camera
        lens.fx, lens.fy = camera.fx, camera.fy
        lens.cx, lens.cy = camera.cx + 0.5, camera.cy + 0.5
        self._scene.set_pose(self._camera, world_T_camera.as_matrix() @ OPENCV_T_OPENGL)
        flags = self._pyrender.RenderFlags.OFFSCREEN | self._pyrender.RenderFlags.RGBA
        if self._lighting is not None:
            flags |= self._pyrender.RenderFlags.SHADOWS_DIRECTIONAL
        else:
            flags |= self._pyrender.RenderFlags.FLAT
        self._context.make_current()
        rgba, depth = self._renderer.render(self._scene, flags)
        return Layer(np.ascontiguousarray(rgba), np.ascontiguousarray(depth))

    def _primitive(self, surface: Surface) -> Any:
        """A surface in pyrender's form; vertex colours become linear unless they are shown flat."""
        pyrender = self._pyrender
        texture = None
        if surface.texture is not None:
            texture = pyrender.Texture(source=surface.texture, source_channels="RGB")
        colors = None
        if surface.colors is not None:
            shown = linear(surface.colors) if self._lighting is not None else surface.colors
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
            np.linalg.inv(world_T_light),
            lens.get_projection_matrix(),
        )
        poses = [world_T_light] + [np.eye(4) for _ in lighting.lamps]
        for pose, lamp in zip(poses[1:], lighting.lamps, strict=True):
            pose[:3, 3] = lamp.position_m
        shining: tuple[Sun | Lamp, ...] = (lighting.sun, *lighting.lamps)
        for node, pose, light in zip(self._scene.light_order, poses, shining, strict=True):
            node.light.color, node.light.intensity = light.color, light.intensity
            self._scene.set_pose(node, pose)


def _import_pyrender() -> Any:
    """pyrender, with the platform chosen first and a name restored that NumPy 2 took away."""
    choose_platform()
    vars(np).setdefault("infty", np.inf)
    import pyrender

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
