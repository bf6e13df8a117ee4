"""The pictures of a recording as JPEG: encoded when asked for, kept while there is room."""

from __future__ import annotations

import threading
from collections import OrderedDict

import cv2

from motorcade.replays.recording import FrameSequence

QUALITY = 82
WIDEST_PX = 1600
"""Wider pictures are made smaller: no screen beside a hand shows more."""
KEPT_BYTES = 192 << 20


class Footage:
    """Pictures by number. May be asked by several threads.

    Args:
        frames: of a recording.
    """

    def __init__(self, frames: FrameSequence) -> None:
        self._frames = frames
        self._kept: OrderedDict[int, bytes] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def jpeg(self, index: int) -> bytes:
        """A picture, colour or grey as it was taken.

        Raises:
            IndexError: there is no such picture.
            RecordingError: it cannot be read.
        """
        if not 0 <= index < len(self._frames):
            raise IndexError(f"Footage.jpeg: expected 0 to {len(self._frames) - 1}, got {index}")
        with self._lock:  # decoders go from one picture to the next
            if index in self._kept:
                self._kept.move_to_end(index)
                return self._kept[index]
            image = self._frames[index].image()
        wide = image.shape[1]
        if wide > WIDEST_PX:
            share = WIDEST_PX / wide
            image = cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
        if image.ndim == 3:
            image = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
        written, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        if not written:
            raise OSError(f"frame {index}: cannot be written as JPEG")
        with self._lock:
            self._keep(index, data.tobytes())
            return self._kept[index]

    def _keep(self, index: int, jpeg: bytes) -> None:
        self._bytes += len(jpeg) - len(self._kept.pop(index, b""))
        self._kept[index] = jpeg
        while self._bytes > KEPT_BYTES and len(self._kept) > 1:
            self._bytes -= len(self._kept.popitem(last=False)[1])
