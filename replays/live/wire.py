"""What goes over the WebSocket: frames of a browser's camera in, images with their poses out.

A frame in: "MLY1", its number (uint32), its stamp (float64, ms), width and height (uint16), how
long the frame before took from capture to drawn (float32, ms; NaN for none), then height × width
bytes of luma, rows from the top. Numbers are little-endian.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.tracking.checks import GrayImage

HEADER = struct.Struct("<4sIdHHf")
MAGIC = b"MLY1"
SMALLEST_SIDE, MAX_SIDE, MAX_FRAME_PIXELS = 64, 2048, 1 << 21
MAX_FRAME_BYTES = MAX_FRAME_PIXELS + HEADER.size
MAX_DRIFT_S = 60.0
"""By how much a browser's clock and ours may part while it is connected."""
_LATEST_MS = 1e13


@dataclass(frozen=True, eq=False)
class CameraFrame:
    """A frame as a browser sent it, by its own clock; `latency_ms` is that of the one before."""

    number: int
    stamp_ms: float
    gray: GrayImage
    latency_ms: float | None


def read_frame(data: bytes) -> CameraFrame:
    """A frame of the bytes of a message.

    Raises:
        ValueError: another header, sizes out of bounds or not those of the bytes, a stamp that is
            none.

    >>> from motorcade.replays.live.wire import HEADER, read_frame
    >>> head = HEADER.pack(b"MLY1", 7, 1000.0, 80, 64, float("nan"))
    >>> frame = read_frame(head + bytes(80 * 64))
    >>> frame.number, frame.gray.shape, frame.latency_ms
    (7, (64, 80), None)
    """
    if len(data) < HEADER.size or data[:4] != MAGIC:
        raise ValueError("frame: expected a header of MLY1")
    _, number, stamp_ms, width, height, latency_ms = HEADER.unpack_from(data)
    if not (SMALLEST_SIDE <= width <= MAX_SIDE and SMALLEST_SIDE <= height <= MAX_SIDE):
        raise ValueError(
            f"frame: expected sides of {SMALLEST_SIDE} to {MAX_SIDE}, got {width} x {height}"
        )
    if len(data) != HEADER.size + width * height:
        raise ValueError(
            f"frame: expected {width * height} bytes of luma, got {len(data) - HEADER.size}"
        )
    if not 0.0 <= stamp_ms < _LATEST_MS:
        raise ValueError("frame: expected a stamp in milliseconds")
    gray = np.frombuffer(data, np.uint8, offset=HEADER.size).reshape(height, width)
    drawn = latency_ms if math.isfinite(latency_ms) and 0.0 <= latency_ms < 1e5 else None
    return CameraFrame(number, stamp_ms, gray, drawn)


@dataclass
class BrowserClock:
    """A browser's stamps, the first at `begun_ns`: they rise, and go as fast as our clock."""

    begun_ns: int
    now_s: float
    _first_ms: float | None = None
    _last_ns: int = -1

    def stamp_ns(self, stamp_ms: float, now_s: float) -> int:
        """Where a stamp is put.

        Raises:
            ValueError: it is not later than the one before, or has jumped.
        """
        if self._first_ms is None:
            self._first_ms, self.now_s = stamp_ms, now_s
        passed_s = 1e-3 * (stamp_ms - self._first_ms)
        stamp_ns = self.begun_ns + round(1e9 * passed_s)
        if stamp_ns <= self._last_ns:
            raise ValueError("frame: expected a stamp after the one before")
        if abs(passed_s - (now_s - self.now_s)) > MAX_DRIFT_S:
            raise ValueError("frame: expected a clock that goes as fast as this one, got a jump")
        self._last_ns = stamp_ns
        return stamp_ns


def image_message(about: Mapping[str, Any], jpeg: bytes) -> bytes:
    """An image and what is known of it: the length of JSON (uint32), JSON, JPEG."""
    text = json.dumps(about, separators=(",", ":"), allow_nan=False).encode()
    return struct.pack("<I", len(text)) + text + jpeg
