"""OpenGL contexts without a window, one a renderer, several side by side in a process.

Both kinds answer to the same three verbs, `make_current`, `address` and `destroy`. They are made
with bare `ctypes`: pyrender's platform classes close the display that other contexts share, and
for OSMesa they import functions that PyOpenGL 3.1.0, which pyrender pins, does not have.
"""

import ctypes
from typing import Protocol

import numpy as np

from motorcade.render.backends.platform import (
    ContextLost,
    Platform,
    RenderUnavailable,
    egl_displays,
    egl_library,
    new_egl_context,
    osmesa_library,
)

_OSMESA_RGBA = 0x1908
_GL_UNSIGNED_BYTE = 0x1401
# format RGBA, 24 depth bits, core profile, version 3.3
_OSMESA_CONTEXT = (0x22, _OSMESA_RGBA, 0x30, 24, 0x33, 0x34, 0x36, 3, 0x37, 3, 0)
_LOST = "the OpenGL context is lost ({} refused it): close this renderer and make a new one"


class Context(Protocol):
    """An OpenGL context that can be made current on this thread."""

    def make_current(self) -> None:
        """Direct this thread's OpenGL calls to the context; raises `ContextLost`."""
        ...

    def address(self, name: str) -> int:
        """Where an OpenGL function lies; 0 where there is none of the name."""
        ...

    def destroy(self) -> None:
        """Give the context back."""
        ...


class EglContext:
    """A context on an EGL device; drawing goes to framebuffer objects."""

    def __init__(self, device: int) -> None:
        library = egl_library()
        displays = [] if library is None else egl_displays(library)
        if library is None or device >= len(displays):
            raise RenderUnavailable("EGL disappeared between probing and use")
        self._egl, self._display = library, displays[device]
        made = None
        if library.eglInitialize(self._display, None, None):
            made = new_egl_context(library, self._display)
        if made is None:
            raise RenderUnavailable("EGL makes no further OpenGL 4.1 core context on this machine")
        self._context = made
        self.make_current()

    def make_current(self) -> None:
        """Direct this thread's OpenGL calls to the context; raises `ContextLost`."""
        if not self._egl.eglMakeCurrent(self._display, None, None, self._context):
            raise ContextLost(_LOST.format("EGL"))

    def address(self, name: str) -> int:
        """Where an OpenGL function lies; 0 where there is none of the name."""
        return self._egl.eglGetProcAddress(name.encode()) or 0

    def destroy(self) -> None:
        """Give the context back; the display stays open for others."""
        self._egl.eglMakeCurrent(self._display, None, None, None)
        self._egl.eglDestroyContext(self._display, self._context)


class OsmesaContext:
    """A software context in memory; drawing goes to framebuffer objects as with EGL."""

    def __init__(self, width: int, height: int) -> None:
        library = osmesa_library()
        if library is None:
            raise RenderUnavailable("OSMesa disappeared between probing and use")
        self._library = library
        library.OSMesaCreateContextAttribs.restype = ctypes.c_void_p
        library.OSMesaGetProcAddress.restype = ctypes.c_void_p
        attributes = (ctypes.c_int * len(_OSMESA_CONTEXT))(*_OSMESA_CONTEXT)
        made = library.OSMesaCreateContextAttribs(attributes, None)
        if not made:
            raise RenderUnavailable("OSMesa makes no OpenGL 3.3 core context on this machine")
        self._context: ctypes.c_void_p | None = ctypes.c_void_p(made)
        self._size = (width, height)
        self._picture = np.zeros((height, width, 4), dtype=np.uint8)
        self.make_current()

    def make_current(self) -> None:
        """Direct this thread's OpenGL calls to the context; raises `ContextLost`."""
        buffer = ctypes.c_void_p(self._picture.ctypes.data)
        # OSMesa trusts what it is given: a context that was destroyed would crash it.
        if self._context is None or not self._library.OSMesaMakeCurrent(
            self._context, buffer, _GL_UNSIGNED_BYTE, *self._size
        ):
            raise ContextLost(_LOST.format("OSMesa"))

    def address(self, name: str) -> int:
        """Where an OpenGL function lies; 0 where there is none of the name."""
        return self._library.OSMesaGetProcAddress(name.encode()) or 0

    def destroy(self) -> None:
        """Give the context back."""
        self._library.OSMesaDestroyContext(self._context)
        self._context = None


def new_context(platform: Platform, width: int, height: int) -> Context:
    """A context on the chosen platform, current on this thread."""
    if platform.name == "egl":
        return EglContext(platform.device)
    return OsmesaContext(width, height)
