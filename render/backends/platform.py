"""Ways to draw without a window: EGL, else OSMesa, else one line that says what is missing.

PyOpenGL binds itself to a platform once, when it is first imported, and cannot change it later.
So the platform is probed here with bare `ctypes`, which leaves no trace in PyOpenGL, and only then
is `PYOPENGL_PLATFORM` set. A value that the user has set ("egl" or "osmesa") is the only one tried.

Contexts are one a renderer, several side by side in a process; both kinds answer to the same three
verbs, `make_current`, `address` and `destroy`. They too are made with bare `ctypes`: pyrender's
platform classes close the display that other contexts share, and for OSMesa they import functions
that PyOpenGL 3.1.0, which pyrender pins, does not have.
"""

import ctypes
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import numpy as np

VARIABLE = "PYOPENGL_PLATFORM"
REMEDY = (
    "install libegl1 and libgl1-mesa-dri, or libosmesa6 (Debian, Ubuntu: "
    "apt-get install libegl1 libgl1-mesa-dri)"
)

_EGL_PLATFORM_DEVICE = 0x313F
_EGL_OPENGL_API = 0x30A2
_EGL_NONE = 0x3038
# surface type: pbuffer; renderable type: OpenGL; depth size: 24
_EGL_CONFIG = (0x3033, 0x0001, 0x3040, 0x0008, 0x3025, 24, _EGL_NONE)
# version 4.1, core profile: what pyrender asks for
_EGL_CONTEXT = (0x3098, 4, 0x30FB, 1, 0x30FD, 1, _EGL_NONE)
_MOST_DEVICES = 16
_OSMESA_NAMES = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


class RenderUnavailable(RuntimeError):
    """No OpenGL can be used on this machine; the message says what to install."""


class ContextLost(RuntimeError):
    """An OpenGL context that was there is gone; a new renderer has to be made."""


@dataclass(frozen=True)
class Platform:
    """A way to draw offscreen that has been tried.

    Attributes:
        name: "egl" or "osmesa", the value of PYOPENGL_PLATFORM.
        device: number of the EGL device; 0 for OSMesa.
    """

    name: str
    device: int


@cache
def choose_platform() -> Platform:
    """The first of EGL and OSMesa that works; it also sets PYOPENGL_PLATFORM for this process.

    Raises RenderUnavailable: neither works, PyOpenGL is already bound to another platform, or
    PYOPENGL_PLATFORM names something else.
    """
    wanted = os.environ.get(VARIABLE)
    if wanted is not None and wanted not in ("egl", "osmesa"):
        raise RenderUnavailable(f"{VARIABLE} is '{wanted}': expected egl, osmesa, or unset")
    if wanted is None and "OpenGL" in sys.modules:
        raise RenderUnavailable(
            f"PyOpenGL was imported before rendering began: set {VARIABLE} to egl or osmesa"
        )
    platform = _first_that_works(wanted)
    if platform is None:
        tried = wanted or "EGL and OSMesa"
        raise RenderUnavailable(f"no OpenGL for rendering ({tried} tried): {REMEDY}")
    os.environ[VARIABLE] = platform.name
    return platform


def _first_that_works(wanted: str | None) -> Platform | None:
    if wanted in (None, "egl"):
        device = working_egl_device()
        if device is not None:
            return Platform("egl", device)
    if wanted in (None, "osmesa") and osmesa_library() is not None:
        return Platform("osmesa", 0)
    return None


def osmesa_library() -> ctypes.CDLL | None:
    """The OSMesa library with a core profile, or None where it is not installed."""
    for name in _OSMESA_NAMES:
        try:
            library = ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
        except OSError:
            continue
        if hasattr(library, "OSMesaCreateContextAttribs"):
            return library
    return None


def working_egl_device() -> int | None:
    """Number of the first EGL device on which an OpenGL context can be made, or None."""
    egl = egl_library()
    if egl is None:
        return None
    for number, display in enumerate(egl_displays(egl)):
        if display and egl.eglInitialize(display, None, None):
            context = new_egl_context(egl, display)
            if context is not None:
                egl.eglDestroyContext(display, context)
            egl.eglTerminate(display)
            if context is not None:
                return number
    return None


def egl_library() -> ctypes.CDLL | None:
    """The EGL library, or None where it is not installed."""
    try:
        egl = ctypes.CDLL("libEGL.so.1")
        egl.eglGetProcAddress.restype = ctypes.c_void_p
        egl.eglCreateContext.restype = ctypes.c_void_p
    except (OSError, AttributeError):
        return None
    return egl


def egl_displays(egl: ctypes.CDLL) -> list[ctypes.c_void_p]:
    """The display of every EGL device, not yet initialised; a null pointer where it has none."""
    query = _extension(egl, "eglQueryDevicesEXT", ctypes.c_uint)
    display_of = _extension(egl, "eglGetPlatformDisplayEXT", ctypes.c_void_p)
    devices = (ctypes.c_void_p * _MOST_DEVICES)()
    count = ctypes.c_int(0)
    if query is None or display_of is None:
        return []
    if not query(ctypes.c_int(_MOST_DEVICES), devices, ctypes.byref(count)):
        return []
    kind = ctypes.c_uint(_EGL_PLATFORM_DEVICE)
    return [
        ctypes.c_void_p(display_of(kind, ctypes.c_void_p(device), None))
        for device in devices[: count.value]
    ]


def new_egl_context(egl: ctypes.CDLL, display: ctypes.c_void_p) -> ctypes.c_void_p | None:
    """An OpenGL 4.1 core context on an initialised display, or None where it makes none."""
    config, count = ctypes.c_void_p(), ctypes.c_int(0)
    wanted = (ctypes.c_int * len(_EGL_CONFIG))(*_EGL_CONFIG)
    chosen = egl.eglChooseConfig(display, wanted, ctypes.byref(config), 1, ctypes.byref(count))
    if not (chosen and count.value and egl.eglBindAPI(_EGL_OPENGL_API)):
        return None
    attributes = (ctypes.c_int * len(_EGL_CONTEXT))(*_EGL_CONTEXT)
    context = egl.eglCreateContext(display, config, None, attributes)
    return ctypes.c_void_p(context) if context else None


def _extension(egl: ctypes.CDLL, name: str, result: type[Any]) -> Callable[..., Any] | None:
    """An EGL extension function by name, or None."""
    address = egl.eglGetProcAddress(name.encode())
    return None if not address else ctypes.CFUNCTYPE(result)(address)


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
        context = None
        if library.eglInitialize(self._display, None, None):
            context = new_egl_context(library, self._display)
        if context is None:
            raise RenderUnavailable("EGL makes no further OpenGL 4.1 core context on this machine")
        self._context = context
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
        context = library.OSMesaCreateContextAttribs(attributes, None)
        if not context:
            raise RenderUnavailable("OSMesa makes no OpenGL 3.3 core context on this machine")
        self._context: ctypes.c_void_p | None = ctypes.c_void_p(context)
        self._size = (width, height)
        self._image = np.zeros((height, width, 4), dtype=np.uint8)
        self.make_current()

    def make_current(self) -> None:
        """Direct this thread's OpenGL calls to the context; raises `ContextLost`."""
        buffer = ctypes.c_void_p(self._image.ctypes.data)
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
