"""Looks at this machine: kernels, compiler, OpenGL and video are tried, not only looked up."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.replays.doctor.findings import Finding
from motorcade.replays.doctor.packages import examine_packages
from motorcade.replays.doctor.processor import flags, simd

if TYPE_CHECKING:
    from motorcade.render.backends.contexts import Context

__all__ = ["examine"]

_COMPILERS = ("cc", "gcc", "clang")
_GL_RENDERER = 0x1F01
_PIPELINE = 'pip install "motorcade[pipeline]"'
_REINSTALL = "pip install --force-reinstall --no-deps motorcade; a compiler builds the kernels"


def examine() -> list[Finding]:
    """Everything looked for, in groups; takes about a second.

    OpenGL and video are left out where the kernels do not load, since nothing else of ours does.
    """
    kernels = _kernels()
    drawing = [*_opengl(), *_video()] if kernels[0].works else []
    return [*kernels, _compiler(), *drawing, *examine_packages()]


def _kernels() -> list[Finding]:
    """Load the kernels and compare one product of theirs with what it must be."""
    enables = "all arithmetic on poses"
    try:
        import numpy as np

        from motorcade.ga import Motor, kernels

        motors = Motor.random(np.random.default_rng(0), (33,))
        residue = float(np.abs((motors @ motors.inverse()).as_matrix() - np.eye(4)).max())
    except Exception as fault:  # whatever keeps them from loading is what is asked for here
        told = f"{type(fault).__name__}: {' '.join(str(fault).split())}"
        return [Finding("kernels", "kernels", False, told, enables, _REINSTALL, needed=True)]
    if not residue < 1e-12:
        told = f"{kernels.backend}, but a motor times its inverse is {residue:.1g} off the identity"
        return [Finding("kernels", "kernels", False, told, enables, _REINSTALL, needed=True)]
    return [
        Finding("kernels", "kernels", True, kernels.backend, enables, needed=True),
        _speed(kernels.backend),
        Finding(
            "kernels",
            "threads",
            True,
            f"{kernels.threads()} of {os.cpu_count()} processors",
            "large batches shared among them; MOTORCADE_THREADS sets the count",
        ),
    ]


def _speed(backend: str) -> Finding:
    enables = "batches at the processor's full width"
    if backend == "compiled":
        return Finding("kernels", "SIMD", True, simd(flags()), enables)
    if os.environ.get("MOTORCADE_KERNELS"):
        told, remedy = "MOTORCADE_KERNELS asks for NumPy", "unset MOTORCADE_KERNELS"
    else:
        told, remedy = "the compiled kernels are absent", _REINSTALL
    return Finding("kernels", "SIMD", False, told, enables, remedy)


def _compiler() -> Finding:
    """The first C compiler that compiles and links a function."""
    enables = "building from source"
    for name in _COMPILERS:
        path = shutil.which(name)
        if path is not None and _compiles(path):
            command = [path, "--version"]
            told = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
            found = (told.stdout.splitlines() or [path])[0]
            return Finding("compiler", "C compiler", True, found, enables)
    told_missing = f"none of {', '.join(_COMPILERS)} compiles a function"
    remedy = "apt-get install gcc g++"
    return Finding("compiler", "C compiler", False, told_missing, enables, remedy)


def _compiles(compiler: str) -> bool:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "one.c"
        source.write_text("#include <math.h>\ndouble one(double x) { return sin(x); }\n")
        command = [compiler, "-shared", "-fPIC", str(source), "-o", str(source.with_suffix(".so"))]
        try:
            done = subprocess.run(command, capture_output=True, timeout=60, check=False)
        except (OSError, subprocess.TimeoutExpired):
            return False
        return done.returncode == 0


def _opengl() -> list[Finding]:
    enables = "characters drawn into footage (overlay.mp4, `motorcade blend`)"
    from motorcade.render.backends.contexts import EglContext, OsmesaContext
    from motorcade.render.backends.platform import REMEDY, osmesa_library, working_egl_device

    device = working_egl_device()
    egl = None if device is None else _drawn_by(lambda: EglContext(device))
    software = osmesa_library() and _drawn_by(lambda: OsmesaContext(16, 16))
    remedy = "not needed, the other one works" if egl or software else REMEDY
    return [
        Finding("OpenGL", name, True, told, enables)
        if told
        else Finding("OpenGL", name, False, "makes no context here", enables, remedy)
        for name, told in (("EGL", egl), ("OSMesa", software))
    ]


def _drawn_by(new_context: Callable[[], Context]) -> str | None:
    """What draws behind a context, in its own words; None where none can be made."""
    from motorcade.render.backends.platform import RenderUnavailable

    try:
        context = new_context()
    except RenderUnavailable:
        return None
    try:
        address = context.address("glGetString")
        name = ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.c_uint)(address)(_GL_RENDERER)
        return "unnamed" if name is None else name.decode("utf-8", "replace")
    finally:
        context.destroy()


def _video() -> list[Finding]:
    """Write four pictures as H.264 and read them again."""
    enables = "overlay.mp4 written, videos read as recordings"
    try:
        import numpy as np

        from motorcade.render.video import read_frames, write_video

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "four.mp4"
            grey = [np.full((32, 32, 3), 60 * index, np.uint8) for index in range(4)]
            write_video(path, grey, 40_000_000 * np.arange(4))
            back = [int(picture.mean()) for _, picture in read_frames(path)]
        if len(back) != 4 or max(abs(b - 60 * i) for i, b in enumerate(back)) > 12:
            raise ValueError(f"four pictures went in, and these greys came out: {back}")
        import av

        library = ".".join(map(str, av.library_versions["libavcodec"]))
    except (ImportError, ValueError, OSError, LookupError) as fault:
        remedy = f"{_PIPELINE} brings PyAV with its codecs"
        return [Finding("video", "H.264", False, str(fault), enables, remedy)]
    return [
        Finding("video", "H.264", True, f"PyAV {av.__version__}, libavcodec {library}", enables)
    ]
