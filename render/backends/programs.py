"""What the fast renderer keeps on the graphics card: shader programs and framebuffers.

OpenGL's own functions, for what moderngl has no name for.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import kernels
from motorcade.ga.arrays import FloatArray

_SHADERS = Path(__file__).parent / "shaders"
_CARRYING = Path(kernels.__file__).parent / "generated" / "glsl" / "skinning.glsl"
_VERSION = "#version 330 core\n"


class Programs:
    """The programs of one context, by what they are for."""

    def __init__(self, gl: Any) -> None:
        self._gl = gl
        self._made: dict[tuple[object, ...], Any] = {}

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
        """Draws the image as it is read."""
        return self._whole("resolved", {"BLENDED": ""} if blended else {}, "")

    def shadow(self) -> Any:
        """Draws surfaces into the shadow map."""
        return self._program(
            ("shadow",),
            vertex_shader=_VERSION + _text("shadow.vert"),
            fragment_shader=_VERSION + _text("shadow.frag"),
        )

    def carry(self, function: str, rows: int, *, signed: bool, more: bool = False) -> Any:
        """Carries vertices by a palette with one of the generated functions."""
        defined = {"CARRY": function, "ROWS": str(rows)} | ({"SIGNED": ""} if signed else {})
        defined |= {"MORE": ""} if more else {}
        return self._program(
            ("carry", function, str(more)),
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


class ShadowMap:
    """Depth as the sun sees it, to compare with, on a square of `size` texels."""

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


TEXTURE_BUFFER = 0x8C2A
PAIRS, QUADS, NUMBERS = 0x8230, 0x8814, 0x8236
"""Formats of buffers that shaders look up: two floats, four, and whole numbers of 32 bits."""
SAMPLE_MASK = 0x8E51
_TEXTURE0, _SAMPLE_POSITION, _COLOR, _DEPTH = 0x84C0, 0x8E50, 0x1800, 0x1801
_UINT, _INT, _FLOAT, _POINTER = ctypes.c_uint, ctypes.c_int, ctypes.c_float, ctypes.c_void_p


class BareFunctions:
    """Those functions, in the context that is current when they are called."""

    def __init__(self, address: Callable[[str], int]) -> None:
        def function(name: str, *kinds: Any) -> Any:
            return ctypes.CFUNCTYPE(None, *kinds)(address(name))

        # Other threads of Python go on meanwhile, which moderngl's own calls keep waiting.
        self.finish = function("glFinish")
        self.texture_parameter = function("glTexParameterf", _UINT, _UINT, _FLOAT)
        self._sample_mask = function("glSampleMaski", _UINT, _UINT)
        self._sample_place = function("glGetMultisamplefv", _UINT, _UINT, _POINTER)
        self._clear = function("glClearBufferuiv", _UINT, _INT, _POINTER)
        self._clear_depth = function("glClearBufferfv", _UINT, _INT, _POINTER)
        self._new_textures = function("glGenTextures", _INT, _POINTER)
        self._delete_textures = function("glDeleteTextures", _INT, _POINTER)
        self._unit = function("glActiveTexture", _UINT)
        self._bind_texture = function("glBindTexture", _UINT, _UINT)
        self._texture_buffer = function("glTexBuffer", _UINT, _UINT, _UINT)
        self._use_program = function("glUseProgram", _UINT)
        self._uniform = function("glUniform1i", _INT, _INT)

    def sample_places(self, count: int) -> FloatArray:
        """Where in a pixel the samples of what is drawn into lie: (count, 2) from its corner."""
        places = np.zeros((count, 2), np.float32)
        for number in range(count):
            self._sample_place(_SAMPLE_POSITION, number, places[number].ctypes.data)
        return places.astype(np.float64)

    def draw_samples(self, bits: int) -> None:
        """Which samples of each pixel are drawn, while `SAMPLE_MASK` is enabled."""
        self._sample_mask(0, bits)

    def clear_numbers(self) -> None:
        """Empty a framebuffer of whole numbers and depth."""
        # Named, since what OpenGL reads must live until it has: other threads allocate meanwhile.
        nothing, far = np.zeros(4, np.uint32), np.ones(1, np.float32)
        self._clear(_COLOR, 0, nothing.ctypes.data)
        self._clear_depth(_DEPTH, 0, far.ctypes.data)

    def look_up(self, buffer: Any, form: int) -> int:
        """A new texture that shows a buffer's content, to be deleted by `forget`."""
        texture = ctypes.c_uint()
        self._new_textures(1, ctypes.addressof(texture))
        self._bind_texture(TEXTURE_BUFFER, texture.value)
        self._texture_buffer(TEXTURE_BUFFER, form, buffer.glo)
        return texture.value

    def use(self, texture: int, unit: int) -> None:
        """Bind what `look_up` gave to a unit."""
        self._unit(_TEXTURE0 + unit)
        self._bind_texture(TEXTURE_BUFFER, texture)

    def forget(self, texture: int) -> None:
        """Delete what `look_up` gave."""
        gone = ctypes.c_uint(texture)
        self._delete_textures(1, ctypes.addressof(gone))

    def tell_unit(self, program: Any, name: str, unit: int) -> None:
        """Set a sampler of buffers, where the program has it."""
        member = program.get(name, None)
        if member is not None:
            self._use_program(program.glo)
            self._uniform(member.location, unit)
