"""The orientation that a picture file notes beside its pixels (EXIF 2.3, tag 274)."""

from __future__ import annotations

import struct

from motorcade.tracking.cameras.orientation import AS_STORED, PictureOrientation

_ORIENTATION, _SHORT = 274, 3
_ORIENTATIONS = {
    1: AS_STORED,
    2: PictureOrientation(0, mirrored=True),
    3: PictureOrientation(2),
    4: PictureOrientation(2, mirrored=True),
    5: PictureOrientation(3, mirrored=True),
    6: PictureOrientation(1),
    7: PictureOrientation(1, mirrored=True),
    8: PictureOrientation(3),
}


def picture_orientation(data: bytes) -> PictureOrientation:
    r"""How a JPEG or PNG file says that its picture is to be shown; as stored where it does not.

    Args:
        data: a whole file, as `picture_size` takes it.

    >>> from motorcade.replays.readers.frames.exif import picture_orientation
    >>> entry = b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0"
    >>> body = b"Exif\0\0MM\0*\0\0\0\x08\0\x01" + entry
    >>> picture_orientation(b"\xff\xd8\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body)
    PictureOrientation(quarter_turns=1, mirrored=False)
    """
    try:
        if data.startswith(b"\xff\xd8"):
            tiff = _jpeg_exif(data)
        elif data.startswith(b"\x89PNG"):
            tiff = _png_exif(data)
        else:
            tiff = None
        value = 1 if tiff is None else _tiff_orientation(tiff)
    except struct.error:  # cut short: viewers show such a picture as it is stored
        value = 1
    return _ORIENTATIONS.get(value, AS_STORED)


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


def _tiff_orientation(tiff: bytes) -> int:
    order = {b"MM": ">", b"II": "<"}.get(tiff[:2])
    if order is None:
        return 1
    (first,) = struct.unpack_from(f"{order}I", tiff, 4)
    (count,) = struct.unpack_from(f"{order}H", tiff, first)
    for entry in range(first + 2, first + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from(f"{order}HH", tiff, entry)
        if tag == _ORIENTATION and kind == _SHORT:
            return int(struct.unpack_from(f"{order}H", tiff, entry + 8)[0])
    return 1
