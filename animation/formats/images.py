"""Textures as their files have them, and the colours of their nearest pixels at vertices.

Pillow decodes; nothing but the formats below is tried, and of all pictures of a file together no
more than MAX_IMAGE_PIXELS, in no more than MAX_IMAGE_BYTES. Both are taken from what is left before
a picture is decoded, so that broken ones cost as much as whole ones.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.errors import FormatError, shown
from motorcade.animation.formats.limits import MAX_IMAGE_BYTES, MAX_IMAGE_PIXELS
from motorcade.animation.srgb import to_linear, to_srgb
from motorcade.ga.arrays import FloatArray

if TYPE_CHECKING:
    from PIL.Image import Image

    from motorcade.animation.appearance import Material

FORMATS = ("PNG", "JPEG", "WEBP", "TGA", "BMP")
STRIP_PIXELS = 1 << 20
"""Converted at once: a picture's copies would fill the memory."""
NAMED_PICTURES = 4
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


def decode_texture(data: bytes, admit: Callable[[int, int], None]) -> Texture:
    """Decode a PNG, JPEG, WebP, TGA or BMP.

    Args:
        data: the file.
        admit: is told width and height before anything is decoded, and raises where that is too
            much.

    Raises:
        FormatError: another format, a broken picture, or one that is not admitted.
        ModuleNotFoundError: Pillow is not installed.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its own limit of size is replaced by ours
            with Image.open(io.BytesIO(data), formats=FORMATS) as opened:
                admit(opened.width, opened.height)
                kept = data if opened.format in ("PNG", "JPEG") else b""
                pixels = _pixels(opened)
                pixels.setflags(write=False)
                return Texture(pixels, kept)
    except FormatError:
        raise
    except Exception as fault:  # decoders raise whatever comes to hand on broken pictures
        raise FormatError(f"expected a picture, got {type(fault).__name__}") from fault


def _pixels(opened: Image) -> NDArray[np.uint8]:
    """All pixels (h, w, 4), 8 bits each; of 16 the upper half."""
    made = np.empty((opened.height, opened.width, 4), np.uint8)
    step = max(1, STRIP_PIXELS // opened.width)
    for top in range(0, opened.height, step):
        strip = opened.crop((0, top, opened.width, min(top + step, opened.height)))
        if strip.mode.startswith("I"):
            made[top : top + step, :, :3] = (np.asarray(strip).astype(np.int64) >> 8)[..., None]
            made[top : top + step, :, 3] = 255
            continue
        plain = strip if strip.mode in WITH_ALPHA else strip.convert("RGB")
        made[top : top + step] = np.asarray(plain.convert("RGBA"))
    return made


class Textures:
    """The pictures of one file, each decoded once."""

    def __init__(self) -> None:
        self._known: dict[str, Texture | None] = {}
        self._pixels_left = MAX_IMAGE_PIXELS
        self._bytes_left = MAX_IMAGE_BYTES
        self._problems: list[str] = []

    @property
    def notices(self) -> list[str]:
        """Those that could not be read: the first few by name, the others by their number."""
        more = len(self._problems) - NAMED_PICTURES
        told = [f"and {more} more textures were not read"] if more > 0 else []
        return [*self._problems[:NAMED_PICTURES], *told]

    def read(self, name: str, data: Callable[[], bytes], key: str = "") -> Texture | None:
        """A decoded picture; None, with a notice, where it is missing, broken or too large.

        Args:
            name: for the notice.
            data: gives the bytes; it is called once for each picture.
            key: what tells the picture from others; its name by default.
        """
        known = key or name
        if known not in self._known:
            self._known[known] = None
            try:
                self._known[known] = decode_texture(self._admitted(data), self._admit)
            except FormatError as fault:
                label = shown(name, 60)
                self._problems.append(
                    f"texture '{label}' was not read ({fault}): plain colours stand in"
                )
        return self._known[known]

    def _admitted(self, data: Callable[[], bytes]) -> bytes:
        if self._bytes_left <= 0:
            raise FormatError(f"expected at most {MAX_IMAGE_BYTES} bytes of pictures, got more")
        made = data()
        self._bytes_left -= len(made)
        return made

    def _admit(self, width: int, height: int) -> None:
        if width * height > self._pixels_left:
            raise FormatError(
                f"expected at most {self._pixels_left} more pixels, got {width} x {height}"
            )
        self._pixels_left -= width * height


def colors_at_vertices(
    material: Material,
    coordinates: tuple[NDArray[np.float32], ...],
    vertex_colors: FloatArray | None,
    count: int,
) -> FloatArray:
    """Colours (V, 3), sRGB, for renderers that sample no textures.

    Vertex colours (V, 4), the base colour and its picture are multiplied in linear light.
    """
    linear = np.repeat(np.clip(np.array([material.base_color[:3]]), 0.0, 1.0), count, axis=0)
    if vertex_colors is not None:
        linear *= vertex_colors[:, :3]
    base = material.base_map
    if base is not None and base.coordinate_set < len(coordinates):
        turned = np.array(base.transform)
        uv = coordinates[base.coordinate_set] @ turned[:, :2].T + turned[:, 2]
        linear *= to_linear(Texture(base.pixels).at(uv))
    return to_srgb(linear)
