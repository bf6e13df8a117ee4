"""What this machine has and lacks: kernels, compiler, OpenGL, video, optional packages.

Kernels, compiler, OpenGL and video are tried, not only looked up. Of optional packages nothing is
imported: whether one can be found is enough, and torch alone takes seconds.
"""

from __future__ import annotations

import ctypes
import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Set
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motorcade.render.backends.platform import Context


@dataclass(frozen=True)
class Finding:
    """What was found out about one thing.

    Fields:
        group: "kernels", "compiler", "OpenGL", "video" or "packages".
        name: the thing.
        works: whether it can be used here.
        detail: version, device or count; what went wrong where it does not work.
        enables: what it is for.
        remedy: how to get it; empty where it works.
        needed: whether the install is broken without it.
    """

    group: str
    name: str
    works: bool
    detail: str
    enables: str
    remedy: str = ""
    needed: bool = False


_V2 = frozenset(["cx16", "lahf_lm", "popcnt", "pni", "sse4_1", "sse4_2", "ssse3"])
_V3 = _V2 | {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"}
_V4 = _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}


def flags(cpuinfo: Path = Path("/proc/cpuinfo")) -> frozenset[str]:
    """What the processor can do, in Linux's names; empty where the system does not tell."""
    if not cpuinfo.is_file():
        return frozenset()
    for line in cpuinfo.read_text().splitlines():
        name, _, value = line.partition(":")
        if name.strip() in ("flags", "Features"):
            return frozenset(value.split())
    return frozenset()


def simd(known: Set[str], machine: str = platform.machine()) -> str:
    """The level of x86-64 whose kernels are picked with these flags; other machines' own name."""
    if machine not in ("x86_64", "AMD64"):
        return f"{machine}, one version of the kernels"
    if known >= _V4:
        return "x86-64-v4 (AVX-512)"
    if known >= _V3:
        return "x86-64-v3 (AVX2 and FMA)"
    return "x86-64 (SSE2)"


OPTIONAL: dict[str, dict[str, tuple[str, str]]] = {
    "pipeline": {
        "opencv-contrib-python-headless": ("cv2", "images, markers, boards, visual SLAM"),
        "pyproj": ("pyproj", "latitudes and longitudes as metres"),
        "gtsam": ("gtsam", "poses and an IMU fused by a graph"),
        "rosbags": ("rosbags", "recordings in ROS bags and MCAP, without ROS"),
        "h5py": ("h5py", "inertial recordings in HDF5"),
        "scikit-image": ("skimage", "structural similarity, image measures"),
        "scipy": ("scipy", "fits, statistics, comparisons of trajectories"),
        "av": ("av", "videos in and out"),
        "matplotlib": ("matplotlib", "plots of reports"),
        "Jinja2": ("jinja2", "report pages"),
        "reportlab": ("reportlab", "boards to print"),
        "PyYAML": ("yaml", "calibration files"),
        "DracoPy": ("DracoPy", "meshes of characters that Draco compressed"),
        "pillow": ("PIL", "textures of characters"),
        "tqdm": ("tqdm", "progress bars"),
        "moderngl": ("moderngl", "drawing characters into footage, and skinning in shaders"),
    },
    "generate": {
        "casadi": ("casadi", "symbolic code from scripts and kernels"),
    },
    "logs": {
        "pyulog": ("pyulog", "logs of PX4"),
        "gpxpy": ("gpxpy", "tracks in GPX"),
        "pynmea2": ("pynmea2", "sentences of NMEA"),
    },
    "pyrender": {
        "pyrender": ("pyrender", "a second renderer, to compare with"),
    },
    "photometric": {
        "kornia": ("kornia", "markers refined on their whole print"),
        "torch": ("torch", "markers refined on their whole print; generated torch code"),
    },
    "viewer": {
        "rerun-sdk": ("rerun", "runs exported for the Rerun viewer"),
    },
    "usd": {
        "usd-core": ("pxr", "runs exported as USD"),
    },
    "studio": {
        "starlette": ("starlette", "the page of `motorcade author`"),
        "uvicorn": ("uvicorn", "its server"),
        "websockets": ("websockets", "what browsers say to it"),
        "segno": ("segno", "its link as a QR code"),
        "cryptography": ("cryptography", "https for `motorcade live --lan`"),
    },
    "people": {
        "ai-edge-litert": ("ai_edge_litert", "people who walk through footage masked"),
        "mediapipe": ("mediapipe", "the same: its weights alone, as it needs many packages"),
    },
    "scale": {
        "dask": ("dask", "sweeps on a cluster"),
        "distributed": ("distributed", "sweeps on a cluster"),
        "pyarrow": ("pyarrow", "sweep tables as Parquet"),
    },
}
"""Extra, distribution: the module it brings, and what that is for."""
_PEOPLE = "pip install ai-edge-litert && pip install --no-deps mediapipe==0.10.14"


def how_to_install(module: str) -> str:
    """The command that brings a Python module: the extra that it belongs to, or the module itself.

    >>> how_to_install("casadi"), how_to_install("requests")
    ('pip install "motorcade[generate]"', 'pip install requests')
    """
    for extra, packages in OPTIONAL.items():
        if any(module == known for known, _ in packages.values()):
            return _PEOPLE if extra == "people" else f'pip install "motorcade[{extra}]"'
    return f"pip install {module}"


def examine_packages() -> list[Finding]:
    """One finding a package."""
    return [
        _package(extra, distribution, module, enables)
        for extra, packages in OPTIONAL.items()
        for distribution, (module, enables) in packages.items()
    ]


def _package(extra: str, distribution: str, module: str, enables: str) -> Finding:
    remedy = how_to_install(module)
    try:
        installed = version(distribution)
        works = find_spec(module) is not None
    except PackageNotFoundError:
        return Finding("packages", distribution, False, "not installed", enables, remedy)
    if not works:
        broken = f"{installed} is recorded, but its module {module} is missing"
        again = f"pip install --force-reinstall {distribution}"
        return Finding("packages", distribution, False, broken, enables, again)
    return Finding("packages", distribution, True, installed, enables)


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
        text = f"{type(fault).__name__}: {' '.join(str(fault).split())}"
        return [Finding("kernels", "kernels", False, text, enables, _REINSTALL, needed=True)]
    if not residue < 1e-12:
        text = f"{kernels.backend}, but a motor times its inverse is {residue:.1g} off the identity"
        return [Finding("kernels", "kernels", False, text, enables, _REINSTALL, needed=True)]
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
        text, remedy = "MOTORCADE_KERNELS asks for NumPy", "unset MOTORCADE_KERNELS"
    else:
        text, remedy = "the compiled kernels are absent", _REINSTALL
    return Finding("kernels", "SIMD", False, text, enables, remedy)


def _compiler() -> Finding:
    """The first C compiler that compiles and links a function."""
    enables = "building from source"
    for name in _COMPILERS:
        path = shutil.which(name)
        if path is not None and _compiles(path):
            command = [path, "--version"]
            answer = subprocess.run(
                command, capture_output=True, text=True, timeout=20, check=False
            )
            compiler = (answer.stdout.splitlines() or [path])[0]
            return Finding("compiler", "C compiler", True, compiler, enables)
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
    from motorcade.render.backends.platform import (
        REMEDY,
        EglContext,
        OsmesaContext,
        osmesa_library,
        working_egl_device,
    )

    device = working_egl_device()
    egl = None if device is None else _drawn_by(lambda: EglContext(device))
    software = osmesa_library() and _drawn_by(lambda: OsmesaContext(16, 16))
    remedy = "not needed, the other one works" if egl or software else REMEDY
    return [
        Finding("OpenGL", name, True, driver, enables)
        if driver
        else Finding("OpenGL", name, False, "makes no context here", enables, remedy)
        for name, driver in (("EGL", egl), ("OSMesa", software))
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
    """Write four images as H.264 and read them again."""
    enables = "overlay.mp4 written, videos read as recordings"
    try:
        import numpy as np

        from motorcade.render.video import read_frames, write_video

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "four.mp4"
            grey = [np.full((32, 32, 3), 60 * index, np.uint8) for index in range(4)]
            write_video(path, grey, 40_000_000 * np.arange(4))
            back = [int(image.mean()) for _, image in read_frames(path)]
        if len(back) != 4 or max(abs(b - 60 * i) for i, b in enumerate(back)) > 12:
            raise ValueError(f"four images went in, and these greys came out: {back}")
        import av

        library = ".".join(map(str, av.library_versions["libavcodec"]))
    except (ImportError, ValueError, OSError, LookupError) as fault:
        remedy = f"{_PIPELINE} brings PyAV with its codecs"
        return [Finding("video", "H.264", False, str(fault), enables, remedy)]
    return [
        Finding("video", "H.264", True, f"PyAV {av.__version__}, libavcodec {library}", enables)
    ]
