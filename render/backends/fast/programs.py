"""What the fast renderer keeps on the graphics card: shader programs and framebuffers."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import kernels
from motorcade.render.backends.platform import RenderUnavailable
from motorcade.render.scene import DepthArray, Layer

_SHADERS = Path(__file__).parent / "shaders"
_CARRYING = Path(kernels.__file__).parent / "generated" / "glsl" / "skinning.glsl"
_VERSION = "#version 330 core\n"


class Programs:
    """The programs of one context, by what they are for.

    Args:
        gl: moderngl's context.
    """

    def __init__(self, gl: Any) -> None:
        self._gl = gl
        self._made: dict[tuple[object, ...], Any] = {}

    def surface(self, *, lit: bool, colored: bool, textured: bool, lamps: int) -> Any:
        """Draws surfaces into the picture."""
        names = ("LIT", lit), ("COLORED", colored), ("TEXTURED", textured)
        defined = {name: "" for name, wanted in names if wanted} | {"LAMPS": str(lamps)}
        head = _head(defined)
        return self._program(
            ("surface", lit, colored, textured, lamps),
            vertex_shader=head + _text("surface.vert"),
            fragment_shader=head + _text("surface.frag"),
        )

    def blended(self, defined: dict[str, str]) -> Any:
        """Draws parts of meshes with one kind of material through which one sees."""
        return self._of_material("blended", defined, _text("reflect.glsl"))

    def covered(self, defined: dict[str, str]) -> Any:
        """Draws which triangle each sample shows."""
        return self._of_material("covered", defined, "")

    def shaded(self, defined: dict[str, str]) -> Any:
        """Draws the light of one kind of material where samples show it."""
        return self._whole("shaded", defined, _text("reflect.glsl"))

    def marked(self) -> Any:
        """Draws where a part of a mesh is seen."""
        return self._whole("marked", {}, "")

    def resolved(self, *, blended: bool) -> Any:
        """Draws the picture as it is read."""
        return self._whole("resolved", {"BLENDED": ""} if blended else {}, "")

    def shadow(self) -> Any:
        """Draws surfaces into the shadow map."""
        return self._program(
            ("shadow",),
            vertex_shader=_VERSION + _text("shadow.vert"),
            fragment_shader=_VERSION + _text("shadow.frag"),
        )

    def carry(self, function: str, rows: int, *, signed: bool) -> Any:
        """Carries vertices by a palette with one of the generated functions."""
        defined = {"CARRY": function, "ROWS": str(rows)} | ({"SIGNED": ""} if signed else {})
        return self._program(
            ("carry", function),
            vertex_shader=_head(defined) + _generated() + _text("carry.vert"),
            varyings=("position", "normal"),
        )

    def _of_material(self, name: str, defined: dict[str, str], above: str) -> Any:
        head = _head(defined)
        return self._program(
            (name, *sorted(defined.items())),
            vertex_shader=head + _text(f"{name}.vert"),
            fragment_shader=head + above + _text(f"{name}.frag"),
        )

    def _whole(self, name: str, defined: dict[str, str], above: str) -> Any:
        return self._program(
            (name, *sorted(defined.items())),
            vertex_shader=_VERSION + _text("whole.vert"),
            fragment_shader=_head(defined) + above + _text(f"{name}.frag"),
        )

    def release(self) -> None:
        """Free them."""
        for program in self._made.values():
            program.release()
        self._made = {}

    def _program(self, key: tuple[object, ...], **sources: Any) -> Any:
        if key not in self._made:
            self._made[key] = self._gl.program(**sources)
        return self._made[key]


def _head(defined: dict[str, str]) -> str:
    return _VERSION + "".join(f"#define {name} {value}\n" for name, value in defined.items())


@cache
def _text(name: str) -> str:
    return (_SHADERS / name).read_text(encoding="ascii")


@cache
def _generated() -> str:
    return _CARRYING.read_text(encoding="ascii")


Box = tuple[int, int, int, int]
"""Left, bottom, width and height in pixels, rows from the bottom."""

SAMPLES = 4
SRGB8_ALPHA8, FRAMEBUFFER_SRGB = 0x8C43, 0x8DB9


class Framebuffer:
    """Colour and depth of one size, four samples a pixel, and the same resolved.

    Args:
        gl: moderngl's context.
        size: width and height, pixels.
        finish: OpenGL's glFinish, to wait for what is drawn while other threads of Python go on,
            which moderngl's own calls keep waiting.

    Raises:
        RenderUnavailable: the memory for it cannot be had.
    """

    def __init__(self, gl: Any, size: tuple[int, int], finish: Callable[[], None]) -> None:
        self._gl, self._size, self._finish = gl, size, finish
        self._box: Box = (0, 0, *size)
        self._depths = (1.0, 2.0)
        self._parts: list[Any] = []
        import moderngl

        try:
            self.drawn = self._framebuffer(min(SAMPLES, gl.max_samples))
            self._resolved = self._framebuffer(0)
        except moderngl.Error as refused:
            self.release()
            raise RenderUnavailable(
                f"no memory for pictures of {size[0]} x {size[1]} with {SAMPLES} samples: {refused}"
            ) from refused

    def begin(self, box: Box | None, depths: tuple[float, float]) -> None:
        """Draw depths from near to far from now on, after clearing; nothing lies outside a box."""
        self._depths = depths
        self._box = (0, 0, *self._size) if box is None else box
        self._resolved.scissor = self._box
        self.drawn.scissor = self._box
        self.drawn.use()
        self.drawn.clear(0.0, 0.0, 0.0, 0.0, depth=1.0)

    def read(self) -> Layer:
        """What was drawn, top row first, with depth in metres."""
        width, height = self._size
        self._finish()
        self._gl.copy_framebuffer(self._resolved, self.drawn)
        self._finish()
        left, bottom, wide, high = self._box
        rgba, depth = np.empty((high, wide, 4), np.uint8), np.empty((high, wide), np.float32)
        self._resolved.read_into(rgba, viewport=self._box, components=4)
        self._resolved.read_into(depth, self._box, 1, attachment=-1, dtype="f4")
        layer = Layer(np.zeros((height, width, 4), np.uint8), np.zeros((height, width), np.float32))
        # OpenGL's rows begin at the bottom.
        held = slice(height - bottom - high, height - bottom), slice(left, left + wide)
        layer.rgba[held], layer.depth_m[held] = rgba[::-1], _metres(depth, *self._depths)[::-1]
        return layer

    def release(self) -> None:
        """Free it."""
        for part in self._parts:
            part.release()
        self._parts = []

    def _framebuffer(self, samples: int) -> Any:
        color = self._gl.texture(self._size, 4, samples=samples)
        self._parts.append(color)
        depth = self._gl.depth_renderbuffer(self._size, samples=samples)
        self._parts.append(depth)
        made = self._gl.framebuffer([color], depth)
        self._parts.append(made)
        return made


class ShadowMap:
    """Depth as the sun sees it, to compare with.

    Args:
        gl: moderngl's context.
        size: of the square, texels.
    """

    def __init__(self, gl: Any, size: int) -> None:
        self._texture = gl.depth_texture((size, size))
        self._texture.compare_func = "<="
        self._texture.filter = gl.LINEAR, gl.LINEAR
        self._texture.repeat_x = self._texture.repeat_y = False
        self.drawn = gl.framebuffer(depth_attachment=self._texture)

    def use(self, unit: int) -> None:
        """Bind it to a texture unit."""
        self._texture.use(unit)

    def release(self) -> None:
        """Free it."""
        self.drawn.release()
        self._texture.release()


def _metres(stored: DepthArray, near: float, far: float) -> DepthArray:
    """Depth along the optical axis from OpenGL's, which is 1 where nothing was drawn."""
    empty = stored == 1.0
    # 1 - d has no rounding; a projection matrix is undone in one division.
    np.subtract(np.float32(1.0), stored, out=stored)
    fall = near / (far - near)
    stored += np.float32(fall)
    np.divide(np.float32(near * (1.0 + fall)), stored, out=stored)
    stored[empty] = 0.0
    return stored
