"""Image files: their pixels, how large they are, and what they note beside (EXIF 2.3).

Image files: their size and completeness from the bytes, and decoding to RGB, grey or depth.

PNG (chunks walked, checksums compared), JPEG (markers walked, end marker required), BMP and binary
PNM. Decoders tend to return the upper part of a truncated image without a word, so completeness
is looked at before anything is decoded, and sizes before any memory is taken. Images come
upright: turned as EXIF says (depth, which nothing turns, excepted).

What an image file notes beside its pixels (EXIF 2.3): orientation and focal length.
"""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.names import one_line
from motorcade.replays.io.files import DamagedError, read_bounded, refusal
from motorcade.replays.io.readers.frames.held import size_advice
from motorcade.replays.io.recording import DepthArray, ImageArray
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

    >>> from motorcade.replays.io.readers.frames.images import image_orientation
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

    >>> from motorcade.replays.io.readers.frames.images import focal_35mm
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


SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm")
FILE_LIMIT = 256 * 2**20
FRAME_LIMIT = 1_000_000
PIXEL_LIMIT = 100_000_000
FRAME_PIXELS = 50_000_000
"""Pixels of an image by itself, and of a frame, of which some are held at once."""
_BLOCK_ROWS = 512
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_PNM_HEADER = re.compile(rb"P[56]" + 3 * rb"(?:\s|#[^\n]*\n)+(\d{1,9})" + rb"\s")
_TRUNCATED = "the image is truncated"
_COPY_AGAIN = "copy the file again"
UNALIGNED = "depth on pixels of its own needs [depth_camera] in a manifest"
ANOTHER_DEPTH_SIZE = "correct the depth camera's width and height, or leave the image out"


def read_image_bytes(
    path: Path,
    field: str | None,
    size: tuple[int, int] | None,
    advice: str | None = None,
    orientation: ImageOrientation | None = None,
) -> bytes:
    """Read an image file and check that it is whole and has this size (width, height), upright.

    `advice` is what to do about another size, where that is not the camera's. A frame, which a
    field names, has at most `FRAME_PIXELS` pixels. An `orientation` overrules the file's own.

    Raises:
        DamagedError: empty, truncated, corrupt, no image at all, or another size than the camera's.
        RecordingError: missing, too large for a frame, or another size where `advice` stands.
    """
    data = read_bounded(path, FILE_LIMIT, field)
    try:
        width, height = (orientation or image_orientation(data)).size(image_size(data))
    except ValueError as fault:
        raise _damaged(path, str(fault), field) from fault
    if field is not None and width * height > FRAME_PIXELS:
        problem = f"expected frames of at most {FRAME_PIXELS} pixels, got {width} x {height}"
        raise refusal(path, problem, field=field, advice="make all images smaller alike")
    if size is not None and size != (width, height):
        usual = size_advice(size, (width, height))
        problem = f"expected {size[0]} x {size[1]} pixels as the camera has, got {width} x {height}"
        mismatch = refusal(path, problem, field=field, advice=advice or usual)
        raise mismatch if advice else DamagedError(str(mismatch))
    return data


def _damaged(path: Path, problem: str, field: str | None) -> DamagedError:
    return DamagedError(str(refusal(path, problem, field=field, advice=_COPY_AGAIN)))


def read_image(
    path: Path,
    field: str,
    size: tuple[int, int] | None,
    orientation: ImageOrientation | None = None,
) -> ImageArray:
    """Decode an image, upright: uint8, RGB ``(height, width, 3)`` or grey ``(height, width)``.

    16-bit files are reduced to 8 bits. An `orientation` overrules the file's own.

    Raises:
        RecordingError: as `read_image_bytes`, and what cannot be decoded.
    """
    data = read_image_bytes(path, field, size, orientation=orientation)
    flags = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION
    image = _decode(path, data, field, flags)
    if image.dtype != np.uint8:
        raise refusal(path, f"expected 8-bit pixels, got {image.dtype}", field=field)
    if image.ndim == 3:
        for row in range(0, len(image), _BLOCK_ROWS):  # in place, so that it is held once
            block = image[row : row + _BLOCK_ROWS]
            block[...] = cv2.cvtColor(block, cv2.COLOR_BGR2RGB)
    return (orientation or image_orientation(data)).upright(np.asarray(image, dtype=np.uint8))


def read_gray(
    path: Path,
    field: str | None,
    size: tuple[int, int] | None,
    orientation: ImageOrientation | None = None,
) -> ImageArray:
    """Decode an image of any kind to grey, upright: uint8 ``(height, width)`` (BT.601's luma).

    The brightest pixel of a 16-bit file becomes white, since such files seldom use all their bits.
    An `orientation` overrules the file's own.

    Raises:
        RecordingError: as `read_image_bytes`, and what cannot be decoded.
    """
    data = read_image_bytes(path, field, size, orientation=orientation)
    return decode_gray(path, data, field, orientation)


def decode_gray(
    path: Path, data: bytes, field: str | None, orientation: ImageOrientation | None = None
) -> ImageArray:
    """The same of a file that was read (`read_image_bytes`).

    Raises:
        RecordingError: what cannot be decoded.
    """
    flags = cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
    image = _decode(path, data, field, flags)
    if image.dtype == np.uint16:
        shown = image.astype(np.float64) * (255.0 / max(int(image.max()), 1))
        image = np.rint(shown).astype(np.uint8)
    if image.dtype != np.uint8:
        raise refusal(path, f"expected 8 or 16 bits a pixel, got {image.dtype}", field=field)
    return (orientation or image_orientation(data)).upright(np.asarray(image, dtype=np.uint8))


def read_depth(
    path: Path, field: str, size: tuple[int, int] | None, units_per_m: float
) -> DepthArray:
    """Decode a 16-bit depth image: float32 metres ``(height, width)``, NaN for 0 and 65535.

    Raises:
        RecordingError: as `read_image_bytes`, and what is not one channel of 16 bits.
    """
    data = read_image_bytes(path, field, size, UNALIGNED)
    stored = _decode(path, data, field, cv2.IMREAD_UNCHANGED)
    if stored.dtype != np.uint16 or stored.ndim != 2:
        raise refusal(
            path, f"expected one channel of uint16, got {stored.dtype} {stored.shape}", field=field
        )
    unknown = (stored == 0) | (stored == 65535)
    metres = stored.astype(np.float32) / np.float32(units_per_m)
    metres[unknown] = np.nan
    return np.asarray(metres, dtype=np.float32)


def image_size(data: bytes) -> tuple[int, int]:
    """Find the width and height of a whole image file, as stored.

    Raises:
        ValueError: truncated, corrupt, an unknown format, or more than 100 million pixels.
    """
    if data.startswith(b"\x89PNG\r\n\x1a\n"):
        size = _png_size(data)
    elif data.startswith(b"\xff\xd8"):
        size = _jpeg_size(data)
    elif data.startswith(b"BM"):
        size = _bmp_size(data)
    elif data.startswith((b"P5", b"P6")):
        size = _pnm_size(data)
    else:
        raise ValueError(f"expected a PNG, JPEG, BMP, PGM or PPM file, got {one_line(data[:8])}")
    width, height = size
    if not (width > 0 and height > 0 and width * height <= PIXEL_LIMIT):
        raise ValueError(f"expected at most {PIXEL_LIMIT} pixels, got {width} x {height}")
    return size


def _decode(path: Path, data: bytes, field: str | None, flags: int) -> NDArray[np.generic]:
    problem = "the image cannot be decoded"
    try:
        image = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), flags)
    except cv2.error as fault:
        raise _damaged(path, problem, field) from fault
    if image is None:
        raise _damaged(path, problem, field)
    return np.asarray(image)


def _png_size(data: bytes) -> tuple[int, int]:
    at, size = 8, None
    while at + 12 <= len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        end = at + 12 + length
        if end > len(data):
            break
        body = memoryview(data)[at + 4 : end - 4]
        if zlib.crc32(body) != struct.unpack_from(">I", data, end - 4)[0]:
            raise ValueError("the image is corrupt (a PNG checksum does not fit)")
        if size is None:
            if kind != b"IHDR" or length != 13:
                raise ValueError("the image is corrupt (a PNG without header)")
            size = struct.unpack_from(">II", data, at + 8)
        if kind == b"IEND":
            return (size[0], size[1])
        at = end
    raise ValueError(f"{_TRUNCATED} (a PNG without end)")


def _jpeg_size(data: bytes) -> tuple[int, int]:
    at, size = 2, None
    while at + 4 <= len(data):
        if data[at] != 0xFF:
            raise ValueError("the image is corrupt (a JPEG marker is missing)")
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
            continue
        length = struct.unpack_from(">H", data, at + 2)[0]
        if marker in _JPEG_FRAMES and at + 9 <= len(data):
            height, width = struct.unpack_from(">HH", data, at + 5)
            size = (width, height)
        at += 2 + length
        if marker == 0xDA:
            if size is None:
                raise ValueError("the image is corrupt (a JPEG without header)")
            # Inside the coded pixels a byte FF is always followed by 00 or a restart marker.
            if data.find(b"\xff\xd9", at) < 0:
                break
            return size
    raise ValueError(f"{_TRUNCATED} (a JPEG without end)")


def _bmp_size(data: bytes) -> tuple[int, int]:
    if len(data) < 26 or len(data) < struct.unpack_from("<I", data, 2)[0]:
        raise ValueError(f"{_TRUNCATED} (a BMP shorter than its header says)")
    if struct.unpack_from("<I", data, 14)[0] < 40:
        width, height = struct.unpack_from("<HH", data, 18)
    else:
        width, height = struct.unpack_from("<ii", data, 18)
    return (width, abs(height))


def _pnm_size(data: bytes) -> tuple[int, int]:
    header = _PNM_HEADER.match(data[:4096])
    if header is None:
        raise ValueError("the image is corrupt (a PNM without header)")
    width, height, top = (int(number) for number in header.groups())
    needed = width * height * (3 if data.startswith(b"P6") else 1) * (2 if top > 255 else 1)
    if len(data) < header.end() + needed:
        raise ValueError(f"{_TRUNCATED} (a PNM shorter than its header says)")
    return (width, height)
