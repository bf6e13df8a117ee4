"""Images that no reader may trip over: giants by their headers, bombs, stumps, other formats."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np

from tests.fuzz.mutations import one_of

__all__ = ["hostile_images", "png"]


def png(width: int, height: int, data: bytes | None = None, *, depth: int = 8) -> bytes:
    """A PNG of that size by its header, without alpha; by default all of its pixels are black."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        check = zlib.crc32(kind + body)
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", check)

    header = struct.pack(">IIBBBBB", width, height, depth, 2, 0, 0, 0)
    if data is None:
        packer = zlib.compressobj(9)
        rows = [packer.compress(bytes(1 + 3 * width * depth // 8)) for _ in range(height)]
        data = b"".join(rows) + packer.flush()
    parts = (chunk(b"IHDR", header), chunk(b"IDAT", data), chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def hostile_images() -> list[bytes]:
    """Some of each kind; the largest that stands for what it says has 36 million pixels."""
    from PIL import Image

    whole: dict[str, bytes] = {}
    for name in ("PNG", "JPEG", "WEBP", "BMP", "TGA", "GIF", "TIFF"):
        made = io.BytesIO()
        Image.new("RGB", (8, 6), (200, 20, 0)).save(made, name)
        whole[name] = made.getvalue()
    nothing = zlib.compress(bytes(1 << 20))
    giants = [
        png(60_000, 60_000, nothing),
        png(2**31 - 1, 1, nothing),
        png(0, 5, nothing),
        _resized(whole["JPEG"], 60_000, 60_000),
        _resized(whole["JPEG"], 65_535, 1),
        _lossless(16_383, 16_383),
        b"RIFF" + struct.pack("<I", 30) + b"WEBPVP8X" + struct.pack("<I", 10) + b"\xff" * 10,
        whole["BMP"][:18] + struct.pack("<ii", 60_000, -60_000) + whole["BMP"][26:],
        whole["TGA"][:12] + struct.pack("<HH", 60_000, 60_000) + whole["TGA"][16:],
    ]
    bombs = [
        png(6_000, 6_000),
        png(7_000, 1_000)[:-400],
        png(3_000, 3_000, zlib.compress(bytes(400))),
        png(100, 100, nothing),
        png(64, 64, depth=16),
        b"\x89PNG\r\n\x1a\n",
    ]
    stumps = [one[: len(one) // 2] for one in whole.values()]
    return [*giants, *bombs, *whole.values(), *stumps]


def _resized(jpeg: bytes, width: int, height: int) -> bytes:
    """A JPEG whose frame says another size."""
    at = jpeg.index(b"\xff\xc0") + 5
    return jpeg[:at] + struct.pack(">HH", height, width) + jpeg[at + 4 :]


def _lossless(width: int, height: int) -> bytes:
    """The header of a lossless WebP, and nothing behind."""
    bits = (width - 1) | (height - 1) << 14
    body = b"\x2f" + struct.pack("<I", bits) + bytes(15)
    return b"RIFF" + struct.pack("<I", 12 + len(body)) + b"WEBPVP8L" + _sized(body)


def _sized(body: bytes) -> bytes:
    return struct.pack("<I", len(body)) + body


def broken(image: bytes, rng: np.random.Generator) -> bytes:
    """An image with a few other bytes, or cut off."""
    made = bytearray(image)
    for _ in range(int(rng.integers(1, 5))):
        made[int(rng.integers(len(made)))] = int(one_of([0, 255, rng.integers(256)], rng))
    return bytes(made[: int(rng.integers(1, len(made) + 1))] if rng.random() < 0.3 else made)
