"""Compressed parts of glTF files: buffer views of meshoptimizer, meshes of Draco.

meshoptimizer (EXT_ and KHR_meshopt_compression): streams hold bytes of vertices as differences, and
triangles by edges seen before; filters make directions, rotations, numbers and colours of bytes.
Where groups of bytes begin is told by those before; so are triangles. That is walked in Python, a
microsecond each; what the groups hold is unpacked for all of them at once. IndexError stands for a
stream that is cut off.

Draco (KHR_draco_mesh_compression) is decoded by DracoPy in a process apart (`draco_process`).

Sources: Khronos Group, the extensions of these names, whose appendices lay down every bit of
meshoptimizer's; Google, Draco bitstream 2.2.
"""

from __future__ import annotations

import io
import os
import struct
import subprocess
import sys
from array import array
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.gltf.document import (
    MESHOPT,
    Accessors,
    Document,
    integer,
    listed,
    table,
    text,
)
from motorcade.animation.formats.limits import (
    MAX_FILE_BYTES,
    MAX_VALUES,
    FormatError,
    expected,
    shown,
)

MAX_UNPACKED_BYTES = 4 * MAX_VALUES


def unpack_meshopt(document: Document) -> None:
    """Put plain buffers behind the compressed views of a document.

    Raises:
        FormatError: bytes that are none of the format's, unknown modes or filters, or more than
            `MAX_UNPACKED_BYTES` in all.
    """
    left = MAX_UNPACKED_BYTES
    for number, entry in enumerate(document.entries("bufferViews")):
        field = f"bufferViews[{number}]"
        view = table(entry, field)
        extensions = table(view.get("extensions", {}), f"{field}.extensions")
        for name in sorted(MESHOPT & extensions.keys())[:1]:
            packed = table(extensions[name], f"{field}.{name}")
            count = integer(packed.get("count"), f"{field}.count", 1, left)
            width = integer(packed.get("byteStride"), f"{field}.byteStride", 1, 256)
            left -= count * width
            if left < 0:
                raise expected(field, f"at most {MAX_UNPACKED_BYTES} bytes in all", "more")
            data = document.slice(packed, field)
            try:
                unpacked = _unpacked(packed, data, count, width)
            except (FormatError, IndexError) as fault:
                why = "one that is cut off" if isinstance(fault, IndexError) else str(fault)
                raise FormatError(f"{field}: expected a stream of {name}, got {why}") from fault
            length = integer(view.get("byteLength"), f"{field}.byteLength", 1, len(unpacked))
            view |= {"buffer": len(document.buffers), "byteOffset": 0, "byteLength": length}
            document.buffers.append(unpacked)


def _unpacked(packed: dict[str, Any], data: bytes, count: int, width: int) -> bytes:
    """The bytes (count times width) that a stream stands for."""
    mode, filtering = packed.get("mode"), text(packed.get("filter", "NONE"), "filter")
    if mode == "ATTRIBUTES":
        if width % 4:
            raise expected("byteStride", "a multiple of 4", width)
        attributes = unpack_attributes(data, count, width)
        if filtering == "NONE":
            return attributes.tobytes()
        if filtering not in FILTERS:
            raise expected("filter", f"NONE, {', '.join(FILTERS)}", filtering)
        return FILTERS[filtering](attributes).tobytes()
    if filtering != "NONE" or width not in (2, 4):
        raise expected("indices", "2 or 4 bytes and no filter", f"{width} and {filtering}")
    numbers: NDArray[np.int64]
    if mode == "TRIANGLES":
        if count % 3:
            raise expected("count", "a multiple of 3", count)
        numbers = unpack_triangles(data, count // 3)
    elif mode == "INDICES":
        numbers = unpack_indices(data, count)
    else:
        raise expected("mode", "ATTRIBUTES, TRIANGLES or INDICES", mode)
    if numbers.max() >= 1 << (8 * width):
        raise expected("indices", f"numbers of {width} bytes", numbers.max())
    return numbers.astype(f"<u{width}").tobytes()


GROUP = 16
"""Vertices whose bytes of one column are packed alike."""
BITS = ((0, 2, 4, 8), (0, 1, 2, 4), (1, 2, 4, 8))
"""Of each byte of a group, by its mode: of version 0, and of the two kinds of version 1."""
NO_BYTES, PLAIN_BYTES = 2, 3
"""Kinds of a column of version 1 beside these two."""
SENTINELS = {
    bits: bytes(
        sum((byte >> at) % (1 << bits) == (1 << bits) - 1 for at in range(0, 8, bits))
        for byte in range(256)
    )
    for bits in (1, 2, 4)
}
"""How many values of a byte say that they follow behind, by bits a value."""
RECENT_EDGES, RECENT_VERTICES = 16, 16
AT_ONCE = 1 << 16
"""Groups that are unpacked at once."""
MASK = 0xFFFFFFFF


def unpack_attributes(data: bytes, count: int, width: int) -> NDArray[np.uint8]:
    """Rows (count, width) of bytes.

    Raises FormatError: another version, or a length that does not fit.
    """
    if data[0] not in (0xA0, 0xA1):
        raise expected("header", "0xa0 or 0xa1", hex(data[0]))
    version = data[0] & 1
    tail = width + version * width // 4
    padded = max(tail, 24 if version else 32)
    groups, begins = _walked(data, count, width, version, len(data) - padded)
    deltas = _gathered(np.frombuffer(data, np.uint8), groups, begins)
    deltas = deltas.reshape(width, -1)[:, :count]
    first = np.frombuffer(data, np.uint8, width, len(data) - tail)
    channels = data[len(data) - tail + width :] if version else bytes(width // 4)
    rows = np.empty((count, width), np.uint8)
    for start in range(0, width, 4):
        four, origin = deltas[start : start + 4], first[start : start + 4]
        rows[:, start : start + 4] = _summed(four, origin, channels[start // 4])
    return rows


def _walked(
    data: bytes, count: int, width: int, version: int, end: int
) -> tuple[bytearray, array[int]]:
    """Bits a value and first byte of every group, by column, then along the vertices."""
    block = min((8192 // width) & ~(GROUP - 1), 256)
    rows = -(-count // GROUP)
    bits_of, begins = bytearray(width * rows), array("q", bytes(8 * width * rows))
    at = 1
    for base in range(0, count, block):
        here = min(block, count - base)
        many = -(-here // GROUP)
        controls = at
        at += version * width // 4
        for column in range(width):
            place = column * rows + base // GROUP
            kind = (data[controls + column // 4] >> 2 * (column % 4)) & 3 if version else 0
            if kind == NO_BYTES and version:
                continue
            if kind == PLAIN_BYTES:
                bits_of[place : place + many] = bytes([8]) * many
                begins[place : place + many] = array("q", range(at, at + GROUP * many, GROUP))
                at += here
                continue
            modes, heads = BITS[kind + version], at
            at += -(-many // 4)
            for group in range(many):
                bits = modes[(data[heads + group // 4] >> 2 * (group % 4)) & 3]
                bits_of[place + group], begins[place + group] = bits, at
                at += 2 * bits
                if 0 < bits < 8:
                    at += sum(data[at - 2 * bits : at].translate(SENTINELS[bits]))
        if at > end:
            raise expected("length", f"at least {at} bytes before the tail", end)
    if at != end:
        raise expected("length", f"{at} bytes before the tail", end)
    return bits_of, begins


def _gathered(data: NDArray[np.uint8], bits_of: bytearray, begins: array[int]) -> NDArray[np.uint8]:
    """What the groups (G,) hold, (G, 16)."""
    every, starts = np.frombuffer(bits_of, np.uint8), np.frombuffer(begins, np.int64)
    gathered = np.zeros((len(every), GROUP), np.uint8)
    for bits in (1, 2, 4, 8):
        which = np.flatnonzero(every == bits)
        for first in range(0, len(which), AT_ONCE):
            some = which[first : first + AT_ONCE]
            gathered[some] = _values(data, starts[some, None], bits)
    return gathered


def _values(data: NDArray[np.uint8], starts: NDArray[np.int64], bits: int) -> NDArray[np.uint8]:
    """Bytes (n, 16) of groups that begin at starts (n, 1) with so many bits each."""
    if bits == 8:
        # the very last group may end within the tail, where nothing is taken from
        return np.asarray(data[np.minimum(starts + np.arange(GROUP), len(data) - 1)])
    raw = data[starts + np.arange(2 * bits)]
    shifts = np.arange(0, 8, bits, dtype=np.uint8)
    shifts = shifts if bits == 1 else shifts[::-1]
    most = (1 << bits) - 1
    values = ((raw[:, :, None] >> shifts) & most).reshape(-1, GROUP)
    behind = values == most
    places = starts + 2 * bits + np.cumsum(behind, axis=1) - 1
    return np.asarray(np.where(behind, data[np.where(behind, places, 0)], values))


def _summed(
    deltas: NDArray[np.uint8], origin: NDArray[np.uint8], channel: int
) -> NDArray[np.uint8]:
    """Bytes (n, 4) from their differences (4, n), as a channel says: bytes, pairs, or all four."""
    kind, turn = channel & 3, channel >> 4
    if kind == 3:
        raise expected("channel", "0 to 2", kind)
    steps = np.ascontiguousarray(deltas.T)
    if kind == 2:
        words = steps.view("<u4")[:, 0]
        turned = (words >> np.uint32(turn)) | (words << np.uint32((32 - turn) % 32))
        begun = np.concatenate([origin.copy().view("<u4"), turned if turn else words])
        sums = np.asarray(np.bitwise_xor.accumulate(begun)[1:])
        return np.asarray(sums.reshape(-1, 1).view(np.uint8))
    signed = _signed(steps.view("<u2") if kind == 1 else steps)
    start = origin.copy().view(signed.dtype)
    return np.asarray(np.cumsum(signed, axis=0, dtype=signed.dtype) + start).view(np.uint8)


def _signed(values: NDArray[Any]) -> NDArray[Any]:
    """Differences, of which 0, 1, 2, 3 … stand for 0, −1, 1, −2 …, modulo their range."""
    return np.asarray((values >> 1) ^ (0 - (values & 1)))


def unpack_triangles(data: bytes, count: int) -> NDArray[np.int64]:
    """Corners (3 count,) of triangles. Raises FormatError: another version."""
    if data[0] != 0xE1:
        raise expected("header", "0xe1", hex(data[0]))
    reader = _Numbers(data, 1 + count)
    codes, shortcuts = data[1 : 1 + count], data[-16:]
    if len(codes) < count or len(data) < 17 + count:
        raise IndexError
    edges: list[tuple[int, int]] = [(0, 0)] * RECENT_EDGES
    seen: list[int] = [0] * RECENT_VERTICES
    indices = array("I")
    following = 0
    for code in codes:
        high, low = code >> 4, code & 15
        if high < 15:
            a, b = edges[-1 - high]
            if low == 0:
                c, following = following, following + 1
            elif low < 13:
                c = seen[-1 - low]
            else:
                c = reader.moved((-1, 1)[low - 13]) if low < 15 else reader.number()
            if low == 0 or low >= 13:
                seen.append(c)
            edges += ((c, b), (a, c))
        else:
            if low < 14:
                second = shortcuts[low]
            else:
                second = reader.byte()
                following = 0 if second == 0 else following
            if low == 15:
                a = reader.number()
            else:
                a, following = following, following + 1
            corners = [a]
            fresh = [a]
            for part in (second >> 4, second & 15):
                if part == 0:
                    corners.append(following)
                    following += 1
                elif part == 15 and low >= 14:
                    corners.append(reader.number())
                else:
                    corners.append(seen[-part])
                    continue
                fresh.append(corners[-1])
            a, b, c = corners
            seen += fresh
            edges += ((b, a), (c, b), (a, c))
        indices.extend((a, b, c))
        if len(edges) > 4096:
            del edges[:-RECENT_EDGES]
            del seen[:-RECENT_VERTICES]
    return np.frombuffer(indices, np.uint32).astype(np.int64)


def unpack_indices(data: bytes, count: int) -> NDArray[np.int64]:
    """Numbers (count,), each told by its step from one of the two before.

    Raises FormatError: another version.
    """
    if data[0] != 0xD1:
        raise expected("header", "0xd1", hex(data[0]))
    reader, last, indices = _Numbers(data, 1), [0, 0], array("I")
    for _ in range(count):
        value = reader.unsigned()
        which, step = value & 1, value >> 1
        last[which] = (last[which] + ((step >> 1) ^ -(step & 1))) & MASK
        indices.append(last[which])
    return np.frombuffer(indices, np.uint32).astype(np.int64)


class _Numbers:
    """Numbers of varied length in a stream, and the last that one of them led to."""

    def __init__(self, data: bytes, at: int) -> None:
        self._data, self._at, self._last = data, at, 0

    def byte(self) -> int:
        """The next byte."""
        self._at += 1
        return self._data[self._at - 1]

    def unsigned(self) -> int:
        """The next number: seven bits a byte, the lowest first."""
        number = 0
        for shift in range(0, 35, 7):
            byte = self.byte()
            number |= (byte & 127) << shift
            if byte < 128:
                return number & MASK
        raise expected("number", "at most 5 bytes", "more")

    def number(self) -> int:
        """The last number moved by the next one."""
        value = self.unsigned()
        return self.moved((value >> 1) ^ -(value & 1))

    def moved(self, step: int) -> int:
        """The last number moved by a step."""
        self._last = (self._last + step) & MASK
        return self._last


Bytes = NDArray[np.uint8]


def _octahedral(rows: Bytes) -> NDArray[Any]:
    """Unit vectors from an octahedron that is laid flat; the fourth number is kept."""
    values, most = _signed_integers(rows)
    full = values[:, 2].astype(np.float64)
    if not full.all():
        raise expected("octahedral vectors", "lengths above 0", "0")
    x, y = values[:, 0] / full, values[:, 1] / full
    z = 1.0 - np.abs(x) - np.abs(y)
    under = np.maximum(-z, 0.0)
    x, y = x - np.where(x >= 0.0, under, -under), y - np.where(y >= 0.0, under, -under)
    length = np.sqrt(x * x + y * y + z * z)
    for column, part in enumerate((x, y, z)):
        values[:, column] = _rounded(part / length * most)
    return values


def _quaternion(rows: Bytes) -> NDArray[Any]:
    """Unit quaternions from their three smaller parts."""
    if rows.shape[1] != 8:
        raise expected("byteStride of quaternions", "8", rows.shape[1])
    values = rows.view("<i2")
    last = values[:, 3].astype(np.int64)
    parts = values[:, :3] * (np.sqrt(0.5) / (last | 3))[:, None]
    largest = np.sqrt(np.maximum(1.0 - (parts * parts).sum(axis=1), 0.0))
    every = np.concatenate([largest[:, None], parts], axis=1)
    quaternion = np.zeros_like(values)
    places = (last[:, None] + np.arange(4)) % 4
    np.put_along_axis(quaternion, places, _rounded(every * 32767.0).astype(np.int16), axis=1)
    return quaternion


def _exponential(rows: Bytes) -> NDArray[Any]:
    """Floating-point numbers from 8 bits of exponent and 24 of mantissa."""
    values = rows.view("<i4")
    with np.errstate(over="ignore", under="ignore"):  # infinity is refused with its accessor
        numbers = np.ldexp(((values << 8) >> 8).astype(np.float32), values >> 24)
    return np.asarray(numbers, dtype="<f4")


def _color(rows: Bytes) -> NDArray[Any]:
    """Red, green, blue and alpha from lightness and two differences."""
    signed, _ = _signed_integers(rows)
    y, orange, green, alpha = (signed[:, k].astype(np.int64) for k in range(4))
    most = (1 << (2 * rows.shape[1])) - 1
    y, alpha = y & most, alpha & most
    bits = np.frexp(alpha.astype(np.float64))[1]  # of its highest bit, which tells the range
    whole = (1 << bits) - 1
    scaled_alpha = alpha & (whole >> 1)
    parts = (
        y + orange - green,
        y + green,
        y - orange - green,
        (scaled_alpha << 1) | (scaled_alpha & 1),
    )
    if not whole.all():
        raise expected("colours", "an alpha above 0, which tells their range", "0")
    colors = np.stack(parts, axis=1) * (most / whole)[:, None]
    return np.clip(_rounded(colors), 0, most).astype(f"<u{rows.shape[1] // 4}")


def _signed_integers(rows: Bytes) -> tuple[NDArray[Any], int]:
    """Four signed numbers a row, in memory of their own, and the largest that there is."""
    if rows.shape[1] not in (4, 8):
        raise expected("byteStride of four numbers", "4 or 8", rows.shape[1])
    kind = np.dtype(f"<i{rows.shape[1] // 4}")
    return rows.view(kind).copy(), int(np.iinfo(kind).max)


def _rounded(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nearest whole numbers, halves away from zero."""
    return np.trunc(values + np.copysign(0.5, values))


FILTERS: dict[str, Callable[[Bytes], NDArray[Any]]] = {
    "OCTAHEDRAL": _octahedral,
    "QUATERNION": _quaternion,
    "EXPONENTIAL": _exponential,
    "COLOR": _color,
}
"""By name; each takes rows (n, stride) in memory of their own."""


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
