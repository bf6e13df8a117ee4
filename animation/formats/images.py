"""Textures as their files have them, and the colours of their nearest pixels at vertices.

Pillow decodes; nothing but the four formats below is tried, and no picture of more than
MAX_IMAGE_PIXELS.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.errors import FormatError, shown
from motorcade.animation.formats.limits import MAX_IMAGE_PIXELS
from motorcade.ga.arrays import FloatArray

FORMATS = ("PNG", "JPEG", "TGA", "BMP")
WITH_ALPHA = ("RGBA", "LA", "PA", "P")
"""Modes of Pillow that may hold alpha."""


class Texture:
    """An sRGB picture to be sampled.

    Args:
        pixels: (h, w, 4) uint8, top row first, with alpha.
        encoded: the file it was in, where that is PNG or JPEG.
    """

    def __init__(self, pixels: NDArray[np.uint8], encoded: bytes = b"") -> None:
        self.pixels, self.encoded = pixels, encoded

    def at(self, uv: FloatArray) -> FloatArray:
        """Colours (V, 3), sRGB, at coordinates (V, 2) from the upper left corner, repeating."""
        height, width = self.pixels.shape[:2]
        parts = np.mod(uv, 1.0)
        columns = np.minimum((parts[:, 0] * width).astype(np.int64), width - 1)
        rows = np.minimum((parts[:, 1] * height).astype(np.int64), height - 1)
        return self.pixels[rows, columns, :3] / 255.0

    @property
    def pixel_count(self) -> int:
        """Width times height."""
        return int(self.pixels.shape[0] * self.pixels.shape[1])


def decode_texture(data: bytes, limit: int = MAX_IMAGE_PIXELS) -> Texture:
    """Decode a PNG, JPEG, TGA or BMP of at most `limit` pixels.

    Raises:
        FormatError: another format, a broken picture, or one that is too large.
        ModuleNotFoundError: Pillow is not installed.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its own limit of size is replaced by ours
            with Image.open(io.BytesIO(data), formats=FORMATS) as opened:
                if opened.width * opened.height > limit:
                    raise FormatError(
                        f"expected at most {limit} pixels, got {opened.width} x {opened.height}"
                    )
                kept = data if opened.format in ("PNG", "JPEG") else b""
                plain = opened if opened.mode in WITH_ALPHA else opened.convert("RGB")
                pixels = np.asarray(plain.convert("RGBA"))
                pixels.setflags(write=False)
                return Texture(pixels, kept)
    except FormatError:
        raise
    except Exception as fault:  # decoders raise whatever comes to hand on broken pictures
        raise FormatError(f"expected a picture, got {type(fault).__name__}") from fault


class Textures:
    """The pictures of one file, each decoded once; `notices` tells of those that cannot be read."""

    def __init__(self) -> None:
        self._known: dict[str, Texture | None] = {}
        self._pixels_left = MAX_IMAGE_PIXELS
        self.notices: list[str] = []

    def read(self, name: str, data: Callable[[], bytes], key: str = "") -> Texture | None:
        """A decoded picture; None, with a notice, where it is missing or broken.

        Args:
            name: for the notice.
            data: gives the bytes; it is called once for each picture.
            key: what tells the picture from others; its name by default.
        """
        known = key or name
        if known not in self._known:
            self._known[known] = None
            try:
                made = decode_texture(data(), self._pixels_left)
            except FormatError as fault:
                label = shown(name, 60)
                self.notices.append(
                    f"texture '{label}' was not read ({fault}): plain colours stand in"
                )
            else:
                self._known[known] = made
                self._pixels_left -= made.pixel_count
        return self._known[known]
