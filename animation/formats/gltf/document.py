"""A glTF document: its JSON, its binary buffers, and the typed arrays (accessors) in them.

What is not as it must be in the JSON is refused by name. Arrays are decoded once each: normalised
integers become numbers from 0 or −1 to 1, sparse entries are written over what they replace,
interleaved data is taken apart.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.limits import (
    MAX_ENTRIES,
    MAX_FILE_BYTES,
    MAX_TEXT_BYTES,
    MAX_VALUES,
    FormatError,
    beside,
    check_count,
    expected,
    read_bounded,
)
from motorcade.ga.arrays import FloatArray, IntArray

MAGIC = b"glTF"
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
UNDERSTOOD = {
    "EXT_texture_webp",
    "EXT_meshopt_compression",
    "FB_ngon_encoding",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
}
"""Extensions that may be required, beside those of materials: they are read, or change nothing."""
MESHOPT = {"EXT_meshopt_compression", "KHR_meshopt_compression"}
OF_MATERIALS = "KHR_materials_"
"""How names of extensions begin that a notice names where they are not drawn."""
CONVERTED = {
    "KHR_texture_basisu": "gltf-transform ktxdecompress",
}
"""Programs that bring files to what is read here."""


def table(value: object, field: str) -> dict[str, Any]:
    """A JSON object."""
    if not isinstance(value, dict):
        raise expected(field, "an object", value)
    return value


def listed(value: object, field: str) -> list[Any]:
    """A JSON array."""
    if not isinstance(value, list):
        raise expected(field, "an array", value)
    return value


def text(value: object, field: str) -> str:
    """A string."""
    if not isinstance(value, str):
        raise expected(field, "a string", value)
    return value


def integer(value: object, field: str, low: int, high: int) -> int:
    """A whole number in a range."""
    if type(value) is int and low <= value <= high:
        return value
    if isinstance(value, float) and value.is_integer() and low <= value <= high:
        return int(value)
    raise expected(field, f"a whole number from {low} to {high}", value)


def number(value: object, field: str) -> float:
    """A finite number."""
    return float(floats([value], field, 1)[0])


def boolean(value: object, field: str) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise expected(field, "true or false", value)
    return value


def floats(value: object, field: str, count: int) -> FloatArray:
    """An array of `count` finite numbers."""
    parts = listed(value, field)
    if len(parts) != count or not all(type(part) in (int, float) for part in parts):
        raise expected(field, f"{count} numbers", parts)
    try:
        numbers = np.array(parts, dtype=np.float64)
    except OverflowError as fault:
        raise expected(field, f"{count} numbers", "one that is too large") from fault
    if not np.isfinite(numbers).all() or np.abs(numbers).max(initial=0.0) > 1e9:
        raise expected(field, "finite numbers up to 1e9", parts)
    return numbers


class Document:
    """A glTF document: its JSON, its buffers and the folder that it lies in.

    Args:
        folder: where files that it names are looked for.
        images: where images are looked for whatever folder they are said to be in, if another.
    """

    def __init__(
        self, root: dict[str, Any], buffers: list[bytes], folder: Path, images: Path | None = None
    ) -> None:
        self.root = root
        self.buffers = buffers
        self.folder = folder
        self.images = images

    def entries(self, name: str) -> list[Any]:
        """A list of the document; empty where it is missing."""
        return listed(self.root.get(name, []), name)

    def entry(self, name: str, index: object, field: str) -> dict[str, Any]:
        """One entry of a list of the document; `field` is what pointed at it."""
        entries = self.entries(name)
        number = integer(index, field, 0, len(entries) - 1)
        return table(entries[number], f"{name}[{number}]")

    def view(self, index: object, field: str) -> bytes:
        """The bytes of a buffer view; `field` is what pointed at it."""
        return self.slice(self.entry("bufferViews", index, field), field)

    def slice(self, entry: dict[str, Any], field: str) -> bytes:
        """The bytes of a buffer that an entry names by `buffer`, `byteOffset`, `byteLength`."""
        which = integer(entry.get("buffer"), f"{field}.buffer", 0, len(self.buffers) - 1)
        data = self.buffers[which]
        start = integer(entry.get("byteOffset", 0), f"{field}.byteOffset", 0, len(data))
        size = integer(entry.get("byteLength"), f"{field}.byteLength", 1, len(data) - start)
        return data[start : start + size]


def open_gltf(path: Path, images: Path | None = None) -> Document:
    """Read a `.glb` or `.gltf` with its buffers.

    Raises:
        FormatError: not glTF 2.0, cut off, a required extension that is not understood, or
            buffers that are missing, shorter than said or outside the file's folder.
    """
    data = read_bounded(path)
    binary = None
    if data[:4] == MAGIC:
        data, binary = _chunks(data)
    if len(data) > MAX_TEXT_BYTES:
        raise expected("JSON", f"at most {MAX_TEXT_BYTES} bytes", len(data))
    # Signs within texts count too: buffers that are embedded have none of them.
    entries = sum(data.count(sign) for sign in (b",", b"[", b"{"))
    check_count("entries of the JSON document", entries, MAX_ENTRIES)
    try:
        root = json.loads(data.decode("utf-8-sig"), parse_constant=_refuse_constant)
    except (UnicodeDecodeError, json.JSONDecodeError) as fault:
        raise FormatError(f"JSON: expected a document, got {fault}") from fault
    except RecursionError as fault:
        raise FormatError("JSON: expected a document, got one nested too deeply") from fault
    except ValueError as fault:  # integers of thousands of digits
        raise FormatError(f"JSON: {fault}") from fault
    root = table(root, "document")
    version = text(table(root.get("asset"), "asset").get("version"), "asset.version")
    if version.split(".")[0] != "2":
        raise expected("asset.version", "2.0", version)
    for name in listed(root.get("extensionsRequired", []), "extensionsRequired"):
        _check_required(text(name, "extensionsRequired"))
    folder = path.parent
    return Document(root, _buffers(root, binary, folder), folder, images)


def _check_required(name: str) -> None:
    """Refuse an extension without which a file means something else."""
    if name in UNDERSTOOD or name.startswith(OF_MATERIALS):
        return
    if name in CONVERTED:
        raise compressed("extensionsRequired", name)
    raise expected("extensionsRequired", "extensions that are understood here", name)


def compressed(field: str, name: str) -> FormatError:
    """The error for a compression that is not read; it says what undoes it."""
    return expected(field, f"plain data (`{CONVERTED[name]} IN OUT` makes it)", name)


def _embedded(uri: str, field: str) -> bytes:
    """The bytes of a `data:` address."""
    head, comma, body = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise expected(field, "base64 data", uri)
    try:
        return base64.b64decode(body, validate=True)
    except (binascii.Error, ValueError) as fault:
        raise expected(field, "base64 data", fault) from fault


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """JSON and binary chunk of a `.glb`."""
    if len(data) < 20:
        raise expected("header", "20 bytes or more", len(data))
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise expected("header version", "2", version)
    if length > len(data):
        raise expected("header length", f"at most {len(data)}, the size of the file", length)
    document, binary, start = None, None, 12
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", data, start)
        body = data[start + 8 : start + 8 + size]
        if len(body) < size:
            raise expected("chunk length", f"at most {len(body)}, what is left", size)
        if kind == JSON_CHUNK and document is None:
            document = body
        elif kind == BINARY_CHUNK and binary is None:
            binary = body
        start += 8 + size
    if document is None:
        raise FormatError("chunks: expected a JSON chunk, got none")
    return document, binary


def _buffers(root: dict[str, Any], binary: bytes | None, folder: Path) -> list[bytes]:
    """The bytes of every buffer."""
    buffers: list[bytes] = []
    total = 0
    for number, fields in enumerate(listed(root.get("buffers", []), "buffers")):
        field = f"buffers[{number}]"
        entry = table(fields, field)
        length = integer(entry.get("byteLength"), f"{field}.byteLength", 0, MAX_FILE_BYTES)
        if "uri" in entry:
            data = load(text(entry["uri"], f"{field}.uri"), folder, f"{field}.uri")
        elif number == 0 and binary is not None:
            data = binary
        else:
            data = b""  # as of compressed meshes, whose extension brings its own
            if MESHOPT & table(entry.get("extensions", {}), f"{field}.extensions").keys():
                length = 0
        if len(data) < length:
            raise expected(f"{field}.byteLength", f"at most {len(data)}, what there is", length)
        total += len(data)
        if total > 2 * MAX_FILE_BYTES:
            raise expected("buffers", f"at most {2 * MAX_FILE_BYTES} bytes", total)
        buffers.append(data[:length] if length < len(data) else data)
    return buffers


def load(uri: str, folder: Path, field: str) -> bytes:
    """Bytes behind an address: embedded, or in a file of the same folder."""
    if uri.startswith("data:"):
        return _embedded(uri, field)
    return load_file(beside(folder, uri, field), field)


def load_file(named: Path, field: str) -> bytes:
    """Bytes of a file that a document names."""
    try:
        return read_bounded(named)
    except FormatError as fault:
        raise FormatError(f"{field} '{named.name}': {fault}") from fault


def _refuse_constant(name: str) -> float:
    raise FormatError(f"JSON: expected numbers, got {name}")


TYPES: dict[int, np.dtype[Any]] = {
    5120: np.dtype("<i1"),
    5121: np.dtype("<u1"),
    5122: np.dtype("<i2"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class Accessors:
    """Reads the accessors of one document."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._entries = document.entries("accessors")
        self._views = document.entries("bufferViews")
        self._read: dict[int, NDArray[Any]] = {}
        self._total = 0

    def floats(self, index: object, field: str, kind: str) -> FloatArray:
        """Values (n, width), or (n,) for scalars, as float64; normalised integers are divided.

        Raises:
            FormatError: another type, out of range, NaN or infinity.
        """
        raw = self._raw(index, field, kind)
        if raw.dtype.kind == "f":
            numbers = widened(raw)
            if not np.isfinite(numbers).all():
                raise expected(field, "finite numbers", "NaN or infinity")
            return numbers
        number = integer(index, field, 0, len(self._entries) - 1)
        entry = table(self._entries[number], field)
        numbers = raw.astype(np.float64)
        if entry.get("normalized") is True:
            numbers = np.maximum(numbers / np.iinfo(raw.dtype).max, -1.0)
        return numbers

    def integers(self, index: object, field: str, kind: str) -> IntArray:
        """Whole numbers (n, width), or (n,) for scalars.

        Raises:
            FormatError: another type, or out of range.
        """
        raw = self._raw(index, field, kind)
        if raw.dtype.kind == "f":
            raise expected(field, "integers", "floating-point numbers")
        return raw.astype(np.int64)

    def unread(self, index: object, field: str, kind: str) -> NDArray[Any]:
        """Values as they are stored, perhaps in the buffer's own memory; NaN may be among them."""
        return self._raw(index, field, kind)

    def unpacked(self, index: object, values: NDArray[Any], field: str) -> None:
        """Take the values (n, width) of an accessor, which were compressed.

        There may be fewer or more than it counts: encoders merge vertices that are alike and drop
        triangles without area, and viewers take what is decoded.

        Raises:
            FormatError: none, or of another width or kind than the accessor says.
        """
        number = integer(index, field, 0, len(self._entries) - 1)
        entry = table(self._entries[number], field)
        kind, width = _component(entry, field), WIDTHS.get(str(entry.get("type")))
        if width is None or values.ndim != 2 or not len(values) or values.shape[1] != width:
            said = f"one or more {entry.get('type')}, as accessors[{number}]"
            raise expected(field, said, " x ".join(map(str, values.shape)) + " numbers")
        self._count(values.size)
        decoded = values.astype(kind)
        if kind.kind != "f" and not np.array_equal(decoded, values):
            raise expected(field, f"numbers of {kind}, as accessors[{number}]", values.dtype)
        self._read[number] = decoded[:, 0] if width == 1 else decoded

    def _count(self, values: int) -> None:
        self._total += values
        if self._total > MAX_VALUES:
            raise FormatError(f"accessors: expected at most {MAX_VALUES} numbers in all, got more")

    def _raw(self, index: object, field: str, kind: str) -> NDArray[Any]:
        number = integer(index, field, 0, len(self._entries) - 1)
        known = self._read.get(number)
        entry = table(self._entries[number], field)
        if entry.get("type") != kind:
            raise expected(f"accessors[{number}].type", kind, entry.get("type"))
        if known is not None:
            return known
        raw = self._decode(entry, number)
        self._read[number] = raw
        return raw

    def _decode(self, entry: dict[str, Any], number: int) -> NDArray[Any]:
        width = WIDTHS[entry["type"]]
        kind = _component(entry, "accessor")
        count = integer(entry.get("count"), "accessor.count", 1, MAX_VALUES // width)
        self._count(count * width)
        if "bufferView" in entry:
            offset = entry.get("byteOffset", 0)
            elements = self._view(entry["bufferView"], offset, number, kind, count, width)
        else:
            elements = np.zeros((count, width), kind)
        if "sparse" in entry:
            elements = self._sparse(
                table(entry["sparse"], f"accessors[{number}].sparse"), number, elements
            )
        return elements[:, 0] if width == 1 else elements

    def _view(
        self, view: object, offset: object, number: int, kind: np.dtype[Any], count: int, width: int
    ) -> NDArray[Any]:
        """An array (count, width) over a buffer view; nothing is copied."""
        which = integer(view, "accessor.bufferView", 0, len(self._views) - 1)
        entry = table(self._views[which], "bufferView")
        buffers = self._document.buffers
        whole = integer(entry.get("buffer"), "bufferView.buffer", 0, len(buffers) - 1)
        data = buffers[whole]
        start = integer(entry.get("byteOffset", 0), "bufferView.byteOffset", 0, len(data))
        length = integer(entry.get("byteLength"), "bufferView.byteLength", 1, len(data) - start)
        item = kind.itemsize * width
        stride = entry.get("byteStride", item)
        if stride != item:
            stride = integer(stride, "bufferView.byteStride", item, 252)
        first = offset if type(offset) is int and 0 <= offset <= length else -1
        if first < 0 or first + (count - 1) * stride + item > length:
            raise expected(
                f"accessors[{number}].count", f"values within the {length} bytes of its view", count
            )
        return np.ndarray((count, width), kind, data, start + first, (stride, kind.itemsize))

    def _sparse(self, entry: dict[str, Any], number: int, base: NDArray[Any]) -> NDArray[Any]:
        field = f"accessors[{number}].sparse"
        count = integer(entry.get("count"), f"{field}.count", 1, len(base))
        at = table(entry.get("indices"), f"{field}.indices")
        kind = _component(at, f"{field}.indices")
        if kind.kind != "u":
            raise expected(f"{field}.indices.componentType", "unsigned integers", "others")
        rows = self._view(at.get("bufferView"), at.get("byteOffset", 0), number, kind, count, 1)
        values = table(entry.get("values"), f"{field}.values")
        new = self._view(
            values.get("bufferView"),
            values.get("byteOffset", 0),
            number,
            base.dtype,
            count,
            base.shape[1],
        )
        where = rows[:, 0].astype(np.int64)
        if where.max() >= len(base) or np.any(np.diff(where) <= 0):
            raise expected(f"{field}.indices", f"increasing numbers below {len(base)}", "others")
        sparse = base.copy()
        sparse[where] = new
        return sparse


def widened(raw: NDArray[Any]) -> FloatArray:
    """Numbers as float64; NaN that would signal stays quiet, to be refused by name."""
    with np.errstate(invalid="ignore"):
        return raw.astype(np.float64)


def _component(entry: dict[str, Any], field: str) -> np.dtype[Any]:
    """The type that a number stands for."""
    value = entry.get("componentType")
    kind = TYPES.get(value) if type(value) is int else None
    if kind is None:
        raise expected(f"{field}.componentType", "5120 to 5126", value)
    return kind
