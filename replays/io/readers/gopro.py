"""What a GoPro says of itself in a video: its model, its view, how long its sensor is read.

Cameras note it in the user data of the film (``moov/udta``): ``FIRM`` is the firmware, whose first
letters name the model, ``GPMF`` holds settings since the HERO6. Sources: gpmf-parser's README (the
order of the IMU's columns by model, SROT); telemetry-parser (where MINF and SROT stand); exiftool's
tables of GoPro tags (MINF, VFOV, ZFOV).

The entries of GoPro's telemetry format (GPMF): key, type, size and repeat, then the values.

Values are big-endian and padded to 4 bytes; type 0 nests. Format: github.com/gopro/gpmf-parser.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.stamps import LONGEST_READOUT_S
from motorcade.render.video import MAX_FILE_BYTES
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.files import open_bounded

# First letters of the firmware: model, and the order of its IMU's columns where no ORIN tells it.
MODELS = {
    "HD5": ("HERO5", "ZXY"),
    "HD6": ("HERO6", "YxZ"),
    "HD7": ("HERO7", "YxZ"),
    "FS1": ("Fusion", "yXZ"),
    "HD8": ("HERO8", None),
    "HD9": ("HERO9", None),
    "H21": ("HERO10", None),
    "H22": ("HERO11", None),
    "H23": ("HERO12", None),
    "H24": ("HERO13", None),
}
DEFAULT_ORDER = "ZXY"
_MOST_HEADER = 2**26


@dataclass(frozen=True)
class GoProCamera:
    """A GoPro by its own words; None where it says nothing.

    Fields:
        model: as people call it.
        order: of the IMU's columns where their stream does not say it; a small letter is the
            opposite of an axis.
        diagonal_fov_deg: how wide the images see from corner to corner.
        linear: whether the camera took the lens's distortion out itself.
        readout_s: from the first row of an image to the last.
    """

    model: str | None = None
    order: str = DEFAULT_ORDER
    diagonal_fov_deg: float | None = None
    linear: bool | None = None
    readout_s: float | None = None


def gopro_camera(path: Path) -> GoProCamera | None:
    """What a video says of the GoPro that took it; None where it was none.

    Damaged notes count as none: poses do not hang on them.
    """
    firmware, settings = "", {}
    for kind, body in _user_data(path):
        if kind == b"FIRM":
            firmware = body.split(b"\0")[0].decode("ascii", "replace")
        elif kind == b"GPMF":
            settings = _settings(body, path)
    named = MODELS.get(firmware[:3])
    model = _text(settings.get(b"MINF")) or (None if named is None else named[0])
    if model is None:
        return None
    order = DEFAULT_ORDER if named is None else named[1] or DEFAULT_ORDER
    view = _text(settings.get(b"VFOV"))
    readout_ms = _number(settings.get(b"SROT"))
    known = readout_ms is not None and 0.0 < readout_ms <= 1e3 * LONGEST_READOUT_S
    fov = _number(settings.get(b"ZFOV"))
    return GoProCamera(
        model,
        order,
        fov if fov is not None and 10.0 < fov < 180.0 else None,
        None if not view else view == "L",
        1e-3 * readout_ms if known and readout_ms is not None else None,
    )


def _settings(body: bytes, path: Path) -> dict[bytes, bytes | float | None]:
    """Values of the entries of all devices: text as bytes, numbers as their first."""
    settings: dict[bytes, bytes | float | None] = {}
    try:
        for device in items(body, path):
            for item in items(device.body, path) if not device.kind else ():
                if item.kind == "c":
                    settings[item.key] = item.body.split(b"\0")[0]
                elif item.kind and item.kind not in "?UFG":
                    settings[item.key] = float(numbers(item, path).ravel()[0])
    except (ValueError, IndexError):
        return settings
    return settings


def _text(value: bytes | float | None) -> str | None:
    return value.decode("ascii", "replace") if isinstance(value, bytes) else None


def _number(value: bytes | float | None) -> float | None:
    return value if isinstance(value, float) and np.isfinite(value) else None


def _user_data(path: Path) -> Iterator[tuple[bytes, bytes]]:
    """Boxes of ``moov/udta`` of an MP4 or MOV file (ISO 14496-12)."""
    if not path.is_file():
        return
    with open_bounded(path, MAX_FILE_BYTES) as file:
        at, end = 0, path.stat().st_size
        while at + 8 <= end:
            file.seek(at)
            header = file.read(16)
            size, kind = struct.unpack_from(">I4s", header)
            if size == 1 and len(header) == 16:
                (size,) = struct.unpack_from(">Q", header, 8)
            if at == 0 and kind != b"ftyp":
                return
            if kind == b"moov" and 8 < size <= _MOST_HEADER:
                file.seek(at + 8)
                for inner, body in _boxes(file.read(size - 8)):
                    if inner == b"udta":
                        yield from _boxes(body)
                return
            if size < 8:
                return
            at += size


def _boxes(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 0
    while at + 8 <= len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if size < 8 or at + size > len(data):
            return
        yield kind, data[at + 8 : at + size]
        at += size


_TYPES = {"s": ">i2", "S": ">u2", "l": ">i4", "L": ">u4", "f": ">f4", "d": ">f8", "b": "i1"}


@dataclass(frozen=True)
class Item:
    """One entry: its key, its type as a letter ("" nests), the size of a sample, its bytes."""

    key: bytes
    kind: str
    size: int
    body: bytes


def items(data: bytes, path: Path) -> Iterator[Item]:
    """Take a run of entries apart.

    Raises:
        RecordingError: an entry that does not end inside `data`.
    """
    at = 0
    while at + 8 <= len(data):
        key, kind, size, repeat = struct.unpack_from(">4sBBH", data, at)
        if key == b"\0\0\0\0":
            return  # padding at the end
        end = at + 8 + size * repeat
        if end > len(data):
            problem = f"expected {size * repeat} bytes of {key!r}, got {len(data) - at - 8}"
            raise refusal(path, problem, field="telemetry")
        yield Item(key, "" if kind == 0 else chr(kind), size, data[at + 8 : end])
        at = end + -(size * repeat) % 4


def numbers(item: Item, path: Path) -> FloatArray:
    """Values ``(samples, values a sample)``."""
    kind = np.dtype(_TYPES[item.kind]) if item.kind in _TYPES else None
    if kind is None or item.size == 0 or item.size % kind.itemsize:
        problem = f"expected numbers, got type {item.kind!r} of {item.size} bytes"
        raise refusal(path, problem, field=f"telemetry {item.key!r}")
    values = np.frombuffer(item.body, kind).astype(np.float64)
    return values.reshape(-1, item.size // kind.itemsize)
