"""What an image file notes beside its pixels (EXIF 2.3): orientation and focal length."""

from __future__ import annotations

import struct

from motorcade.tracking.cameras.camera import AS_STORED, ImageOrientation

_ORIENTATION, _EXIF, _FOCAL_35MM = 274, 34665, 41989
_SHORT, _LONG = 3, 4
_ORIENTATIONS = {
    1: AS_STORED,
    2: ImageOrientation(0, mirrored=True),
    3: ImageOrientation(2),
    4: ImageOrientation(2, mirrored=True),
    5: ImageOrientation(3, mirrored=True),
    6: ImageOrientation(1),
    7: ImageOrientation(1, mirrored=True),
    8: ImageOrientation(3),
}


def image_orientation(data: bytes) -> ImageOrientation:
    r"""How a JPEG or PNG file says that its image is to be shown; as stored where it does not.

    Args:
        data: a whole file, as `image_size` takes it.

    >>> from motorcade.replays.io.readers.frames.exif import image_orientation
    >>> entry = b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0"
    >>> body = b"Exif\0\0MM\0*\0\0\0\x08\0\x01" + entry
    >>> image_orientation(b"\xff\xd8\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body)
    ImageOrientation(quarter_turns=1, mirrored=False)
    """
    try:
        tiff = _tiff(data)
        value = 1 if tiff is None else _entries(tiff).get(_ORIENTATION, 1)
    except struct.error:  # cut short: viewers show such an image as it is stored
        value = 1
    return _ORIENTATIONS.get(value, AS_STORED)


def focal_35mm(data: bytes) -> int | None:
    r"""The focal length in mm that would see as much on 35 mm film (tag 41989); None without.

    Args:
        data: a whole file.

    >>> from motorcade.replays.io.readers.frames.exif import focal_35mm
    >>> first = b"\0\x01\x87\x69\0\x04\0\0\0\x01\0\0\0\x1a\0\0\0\0"
    >>> second = b"\0\x01\xa4\x05\0\x03\0\0\0\x01\0\x1a\0\0"
    >>> body = b"Exif\0\0MM\0*\0\0\0\x08" + first + second
    >>> focal_35mm(b"\xff\xd8\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body)
    26
    """
    try:
        tiff = _tiff(data)
        if tiff is None:
            return None
        inner = _entries(tiff).get(_EXIF)
        focal = None if inner is None else _entries(tiff, inner).get(_FOCAL_35MM)
    except struct.error:
        return None
    return focal or None  # 0: unknown


def _tiff(data: bytes) -> bytes | None:
    if data.startswith(b"\xff\xd8"):
        return _jpeg_exif(data)
    return _png_exif(data) if data.startswith(b"\x89PNG") else None


def _jpeg_exif(data: bytes) -> bytes | None:
    """The TIFF part of the first segment of EXIF, before the coded pixels."""
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
            continue
        if marker == 0xDA:
            return None
        (length,) = struct.unpack_from(">H", data, at + 2)
        if marker == 0xE1 and data[at + 4 : at + 10] == b"Exif\0\0":
            return data[at + 10 : at + 2 + length]
        at += 2 + length
    return None


def _png_exif(data: bytes) -> bytes | None:
    at = 8
    while at + 12 <= len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"eXIf":
            return data[at + 8 : at + 8 + length]
        at += 12 + length
    return None


def _entries(tiff: bytes, first: int | None = None) -> dict[int, int]:
    """Tags of a directory, the first by default, whose value is one short or long number."""
    order = {b"MM": ">", b"II": "<"}.get(tiff[:2])
    if order is None:
        return {}
    if first is None:
        (first,) = struct.unpack_from(f"{order}I", tiff, 4)
    (count,) = struct.unpack_from(f"{order}H", tiff, first)
    entries: dict[int, int] = {}
    for entry in range(first + 2, first + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from(f"{order}HH", tiff, entry)
        form = {_SHORT: "H", _LONG: "I"}.get(kind)
        if form is not None and tag not in entries:
            entries[tag] = int(struct.unpack_from(f"{order}{form}", tiff, entry + 8)[0])
    return entries
