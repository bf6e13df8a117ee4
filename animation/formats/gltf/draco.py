"""Meshes compressed by Draco (KHR_draco_mesh_compression), decoded by DracoPy in a process apart.

Source: Khronos Group, KHR_draco_mesh_compression; Google, Draco bitstream 2.2.
"""

from __future__ import annotations

import io
import os
import struct
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.gltf.accessors import Accessors
from motorcade.animation.formats.gltf.container import Document, integer, listed, table
from motorcade.animation.formats.limits import (
    MAX_FILE_BYTES,
    MAX_VALUES,
    FormatError,
    expected,
    shown,
)

DRACO = "KHR_draco_mesh_compression"
TIME_LIMIT_S = 30
MEMORY_LIMIT_BYTES = 2 << 30
MESH = 1
"""Draco's number for a mesh, beside clouds of points."""
TRIANGLES = 4


def unpack_draco(document: Document, accessors: Accessors) -> None:
    """Give `accessors` the arrays of all compressed primitives that have no plain data.

    Raises:
        FormatError: no mesh of Draco's, one that is broken or too large, or other attributes and
            counts than its accessors say.
        ModuleNotFoundError: DracoPy is not installed.
    """
    parts = _compressed(document)
    if not parts:
        return
    extensions = [table(part["extensions"][DRACO], DRACO) for part in parts]
    which = [
        integer(extension.get("bufferView"), f"{DRACO}.bufferView", 0, 1 << 30)
        for extension in extensions
    ]
    views = sorted(set(which))
    meshes = dict(zip(views, _decoded([_mesh(document, view) for view in views]), strict=True))
    for part, compressed, view in zip(parts, extensions, which, strict=True):
        attributes = table(part["attributes"], "attributes")
        for name, number in table(compressed.get("attributes"), f"{DRACO}.attributes").items():
            if name not in attributes:
                raise expected(f"{DRACO}.attributes", "those of its primitive", name)
            attribute = meshes[view].get(str(integer(number, f"{DRACO}.{name}", 0, 1 << 31)))
            if attribute is None:
                raise expected(f"{DRACO}.{name}", "an attribute of the mesh", number)
            accessors.unpacked(attributes[name], attribute, f"{DRACO}.{name}")
        if "indices" in part:
            faces = meshes[view]["faces"].reshape(-1, 1)
            accessors.unpacked(part["indices"], faces, f"{DRACO} indices")


def _compressed(document: Document) -> list[dict[str, Any]]:
    """Primitives that are there in Draco's form alone."""
    compressed = []
    for number, entry in enumerate(document.entries("meshes")):
        mesh = table(entry, f"meshes[{number}]")
        for primitive in listed(mesh.get("primitives"), f"meshes[{number}].primitives"):
            part = table(primitive, f"meshes[{number}]")
            if DRACO not in table(part.get("extensions", {}), f"meshes[{number}].extensions"):
                continue
            attributes = table(part.get("attributes"), f"meshes[{number}].attributes")
            place = document.entry("accessors", attributes.get("POSITION"), "POSITION")
            if "bufferView" in place or "sparse" in place:
                continue
            if part.get("mode", TRIANGLES) != TRIANGLES:
                raise expected(f"{DRACO} mode", "triangles (4)", part["mode"])
            compressed.append(part)
    return compressed


def _mesh(document: Document, view: int) -> bytes:
    """The bytes of a compressed mesh."""
    data = document.view(view, f"{DRACO}.bufferView")
    if data[:5] != b"DRACO" or len(data) < 11 or data[5] != 2 or data[7] != MESH:
        raise expected(f"bufferViews[{view}]", "a mesh of Draco 2", data[:8])
    return data


def _decoded(meshes: list[bytes]) -> list[dict[str, NDArray[Any]]]:
    """Attributes (n, width) by their numbers, and "faces" (T, 3), of each mesh."""
    if find_spec("DracoPy") is None:
        raise ModuleNotFoundError(
            'meshes compressed by Draco need DracoPy: pip install "motorcade[pipeline]"',
            name="DracoPy",
        )
    if os.name != "posix":
        raise FormatError(
            f"{DRACO}: its decoder runs within bounds of memory, which this system does not set; "
            "give meshes that are not compressed"
        )
    total = sum(map(len, meshes))
    if total > MAX_FILE_BYTES:
        raise expected(DRACO, f"at most {MAX_FILE_BYTES} bytes", total)
    limits = [str(one) for one in (MEMORY_LIMIT_BYTES, TIME_LIMIT_S, MAX_VALUES)]
    program = str(Path(__file__).with_name("draco_process.py"))
    try:
        done = subprocess.run(
            [sys.executable, "-P", program, *limits],
            input=b"".join(struct.pack("<Q", len(one)) + one for one in meshes),
            capture_output=True,
            timeout=2 * TIME_LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired as fault:
        raise FormatError(f"{DRACO}: expected an end within {2 * TIME_LIMIT_S} s") from fault
    if done.returncode != 0:
        lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
        why = lines[-1] if lines else f"an end by signal {-done.returncode}"
        raise FormatError(f"{DRACO}: expected meshes that can be decoded, got {shown(why, 200)}")
    decoded: list[dict[str, NDArray[Any]]] = [{} for _ in meshes]
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as arrays:
        for name in arrays.files:
            number, _, key = name.partition("/")
            decoded[int(number)][key] = arrays[name]
    return decoded
