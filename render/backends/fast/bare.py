"""OpenGL's own functions, for what moderngl has no name for."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray

TEXTURE_BUFFER = 0x8C2A
PAIRS, QUADS, NUMBERS = 0x8230, 0x8814, 0x8236
"""Formats of buffers that shaders look up: two floats, four, and whole numbers of 32 bits."""
SAMPLE_MASK = 0x8E51
_TEXTURE0, _SAMPLE_POSITION, _COLOR, _DEPTH = 0x84C0, 0x8E50, 0x1800, 0x1801
_UINT, _INT, _FLOAT, _POINTER = ctypes.c_uint, ctypes.c_int, ctypes.c_float, ctypes.c_void_p


class BareFunctions:
    """Those functions, in the context that is current when they are called.

    Args:
        address: where a function of OpenGL lies, by its name.
    """

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
        made = ctypes.c_uint()
        self._new_textures(1, ctypes.addressof(made))
        self._bind_texture(TEXTURE_BUFFER, made.value)
        self._texture_buffer(TEXTURE_BUFFER, form, buffer.glo)
        return made.value

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
