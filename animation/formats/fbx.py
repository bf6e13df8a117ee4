"""FBX by way of `assimp`: the program of that name turns the file into glTF, which is then read.

The program runs without a shell, in a folder of its own, within limits of time, memory and size;
its node names and numbers are taken as they come. FBX states its unit in centimetres, which the
program drops: it is read from the file here. Images are looked for beside the file.
"""

from __future__ import annotations

import os
import re
import shutil
import struct
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from motorcade.animation.appearance import to_linear
from motorcade.animation.formats.gltf import read_gltf
from motorcade.animation.formats.images import colors_at_vertices
from motorcade.animation.formats.limits import MAX_FILE_BYTES, FormatError, read_bounded, shown
from motorcade.animation.formats.rig.values import Rig, RigSurface
from motorcade.ga.files import off_record

TIME_LIMIT_S = 60.0
MEMORY_LIMIT_BYTES = 4 << 30
BINARY_UNIT = re.compile(
    rb"UnitScaleFactorS\x06\0\0\0doubleS\x06\0\0\0NumberS\0\0\0\0D(.{8})", re.S
)
TEXT_UNIT = re.compile(rb'"UnitScaleFactor",\s*"double",\s*"Number",\s*"",\s*([0-9.eE+-]{1,30})')


def read_fbx(path: Path) -> Rig:
    """Read an `.fbx`.

    Raises:
        FormatError: the program is not installed, fails, or takes too long; the system is not
            POSIX; or what `read_gltf` refuses.
    """
    if os.name != "posix":
        raise FormatError(
            "FBX is read by a program within bounds of memory, which this system does not set; "
            "give glTF instead"
        )
    program = shutil.which("assimp")
    if program is None:
        raise FormatError(
            "FBX is read by the program assimp, which is not installed; on Debian and Ubuntu "
            "the package assimp-utils brings it"
        )
    data = read_bounded(path)
    with tempfile.TemporaryDirectory(prefix="motorcade-fbx-") as folder:
        source = Path(folder) / "given.fbx"
        target = Path(folder) / "made.glb"
        source.write_bytes(data)
        _export(program, source, target)
        with off_record():
            rig = read_gltf(target, images=path.parent)
    rig = replace(rig, surfaces=tuple(_linear(one) for one in rig.surfaces))
    unit_m = _unit_m(data)
    if unit_m is not None:
        rig = replace(rig, unit_m=unit_m, unit_checked=False)
    return replace(
        rig, clips=tuple(replace(clip, name=clip.name or path.stem) for clip in rig.clips)
    )


def _linear(surface: RigSurface) -> RigSurface:
    """The surface with its colours in linear light: FBX has sRGB, which the program copies."""
    srgb = surface.material
    if srgb is None:
        return surface
    color = to_linear(np.clip(np.array(srgb.base_color[:3]), 0.0, 1.0))
    glow = to_linear(np.clip(np.array(srgb.emission), 0.0, 1.0))
    material = replace(
        srgb,
        base_color=(*color.tolist(), srgb.base_color[3]),
        emission=tuple(glow.tolist()),
    )
    tints, count = surface.vertex_colors, len(surface.vertices)
    colors = colors_at_vertices(material, surface.coordinates, tints, count)
    return replace(surface, material=material, colors=colors)


def _export(program: str, path: Path, target: Path) -> None:
    try:
        done = subprocess.run(
            [program, "export", str(path), str(target)],
            cwd=path.parent,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=TIME_LIMIT_S,
            preexec_fn=_limit,
            check=False,
        )
    except subprocess.TimeoutExpired as fault:
        raise FormatError(f"assimp: expected an end within {TIME_LIMIT_S:g} s, got none") from fault
    except OSError as fault:
        raise FormatError(f"assimp: cannot be run: {fault.strerror}") from fault
    if done.returncode != 0 or not target.is_file():
        lines = (done.stdout + done.stderr).decode("utf-8", "replace").strip().splitlines()
        raise FormatError(f"assimp: {shown(lines[-1] if lines else 'failed', 200)}")


def _limit() -> None:
    """In the program's own process: bounds of memory, of files and of processor time."""
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT_BYTES, MEMORY_LIMIT_BYTES))
    resource.setrlimit(resource.RLIMIT_FSIZE, (MAX_FILE_BYTES, MAX_FILE_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (int(TIME_LIMIT_S), int(TIME_LIMIT_S)))


def _unit_m(data: bytes) -> float | None:
    """Metres a unit, or None where the file does not say."""
    binary, text = BINARY_UNIT.search(data), TEXT_UNIT.search(data)
    value = 0.0
    if binary is not None:
        value = struct.unpack("<d", binary[1])[0]
    elif text is not None:
        try:
            value = float(text[1])
        except ValueError as fault:
            raise FormatError("UnitScaleFactor: expected a number, got another text") from fault
    if not 1e-4 <= value <= 1e6:
        return None
    return 0.01 * value
