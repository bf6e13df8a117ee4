"""The outer shape of glTF files: the JSON document and its binary buffers.

What is not as it must be in the JSON is refused by name.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.formats.limits import (
    MAX_ENTRIES,
    MAX_FILE_BYTES,
    MAX_TEXT_BYTES,
    FormatError,
    beside,
    check_count,
    expected,
    read_bounded,
)
from motorcade.ga.arrays import FloatArray

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
