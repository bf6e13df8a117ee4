"""OpenGL contexts without a window, one a renderer, several side by side in a process.

Both kinds answer to the same two verbs, `make_current` and `destroy`. pyrender's own platform
classes are not used for OSMesa (PyOpenGL 3.1.0, which pyrender pins, lacks the functions they
import) nor to destroy EGL contexts (they close the display that other contexts share).
"""

import ctypes
from typing import Any, Protocol

import numpy as np

from motorcade.render.backends.platform import Platform, RenderUnavailable, osmesa_library

_OSMESA_RGBA = 0x1908
_GL_UNSIGNED_BYTE = 0x1401
# format RGBA, 24 depth bits, core profile, version 3.3
_OSMESA_CONTEXT = (0x22, _OSMESA_RGBA, 0x30, 24, 0x33, 0x34, 0x36, 3, 0x37, 3, 0)


class Context(Protocol):
    """An OpenGL context that can be made current on this thread."""

    def make_current(self) -> None:
        """Direct this thread's OpenGL calls to the context."""
        ...

    def destroy(self) -> None:
        """Give the context back."""
        ...


class EglContext:
    """A context on an EGL device, through pyrender's platform class."""

    def __init__(self, width: int, height: int, device: int) -> None:
        from pyrender.platforms import egl

        self._platform: Any = egl.EGLPlatform(width, height, device=egl.get_device_by_index(device))
        self._platform.init_context()

    def make_current(self) -> None:
        """Direct this thread's OpenGL calls to the context."""
        self._platform.make_current()

    def destroy(self) -> None:
        """Give the context back; the display stays open for others."""
        from OpenGL.EGL import eglDestroyContext

        eglDestroyContext(self._platform._egl_display, self._platform._egl_context)


class OsmesaContext:
    """A software context in memory; drawing goes to framebuffer objects as with EGL."""

    def __init__(self, width: int, height: int) -> None:
        library = osmesa_library()
        if library is None:
            raise RenderUnavailable("OSMesa disappeared between probing and use")
        self._library = library
        library.OSMesaCreateContextAttribs.restype = ctypes.c_void_p
        attributes = (ctypes.c_int * len(_OSMESA_CONTEXT))(*_OSMESA_CONTEXT)
        made = library.OSMesaCreateContextAttribs(attributes, None)
        if not made:
            raise RenderUnavailable("OSMesa makes no OpenGL 3.3 core context on this machine")
        self._context = ctypes.c_void_p(made)
        _let_contexts_be_keys()
        self._size = (width, height)
        self._picture = np.zeros((height, width, 4), dtype=np.uint8)
        self.make_current()

    def make_current(self) -> None:
        """Direct this thread's OpenGL calls to the context."""
        buffer = ctypes.c_void_p(self._picture.ctypes.data)
        done = self._library.OSMesaMakeCurrent(
            self._context, buffer, _GL_UNSIGNED_BYTE, *self._size
        )
        if not done:
            raise RenderUnavailable("OSMesa refused to make its context current")

    def destroy(self) -> None:
        """Give the context back."""
        self._library.OSMesaDestroyContext(self._context)


def _let_contexts_be_keys() -> None:
    """Have PyOpenGL know OSMesa contexts by number: as keys of a dictionary, pointers fail."""
    from OpenGL import platform

    platform.PLATFORM.GetCurrentContext.restype = ctypes.c_void_p


def new_context(platform: Platform, width: int, height: int) -> Context:
    """A context on the chosen platform, current on this thread."""
    if platform.name == "egl":
        return EglContext(width, height, platform.device)
    return OsmesaContext(width, height)
