"""Textures as their files have them, and the colours of their nearest pixels at vertices.

Pillow decodes; nothing but the formats below is tried, and of all images of a file together no
more than MAX_IMAGE_PIXELS are kept, in files of no more than MAX_IMAGE_BYTES. Further ones are kept
smaller, of MAX_REDUCED_PIXELS in all before that. Each limit is taken from what is left before a
image is decoded, so that broken ones cost as much as whole ones.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.animation.formats.limits import (
    MAX_IMAGE_BYTES,
    MAX_IMAGE_PIXELS,
    MAX_REDUCED_PIXELS,
    FormatError,
    shown,
)
from motorcade.ga.arrays import FloatArray

if TYPE_CHECKING:
    from PIL.Image import Image

    from motorcade.animation.appearance import Material

FORMATS = ("PNG", "JPEG", "WEBP", "TGA", "BMP")
STRIP_PIXELS = 1 << 20
"""Converted at once: an image's copies would fill the memory."""
SMALLER_PIXELS = 1 << 20
"""What images have at most that are kept smaller."""
NAMED_IMAGES = 4
WITH_ALPHA = ("RGBA", "LA", "PA", "P")
"""Modes of Pillow that may hold alpha."""


class Texture:
    """An sRGB image to be sampled.

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


def decode_texture(data: bytes, admit: Callable[[int, int], int]) -> Texture:
    """Decode a PNG, JPEG, WebP, TGA or BMP.

    Args:
        data: the file.
        admit: is told width and height before anything is decoded, and says how many pixels to a
            side become one by their mean, a power of two; it raises where that is too much.

    Raises:
        FormatError: another format, a broken image, or one that is not admitted.
        ModuleNotFoundError: Pillow is not installed.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its own limit of size is replaced by ours
            with Image.open(io.BytesIO(data), formats=FORMATS) as opened:
                factor = admit(opened.width, opened.height)
                kept = data if opened.format in ("PNG", "JPEG") else b""
                pixels = _pixels(opened, factor)
                pixels.setflags(write=False)
                return Texture(pixels, kept)
    except FormatError:
        raise
    except Exception as fault:  # decoders raise whatever comes to hand on broken images
        raise FormatError(f"expected an image, got {type(fault).__name__}") from fault


def _pixels(opened: Image, factor: int) -> NDArray[np.uint8]:
    """All pixels (h, w, 4), 8 bits each, or the means of squares of so many to a side."""
    if factor > 1:
        largest = max(opened.size)
        wanted = -(-opened.width // factor), -(-opened.height // factor)
        opened.draft(opened.mode, wanted)  # JPEG alone: halved in decoding, some times
        factor //= round(largest / max(opened.size))
    width, height = -(-opened.width // factor), -(-opened.height // factor)
    pixels = np.empty((height, width, 4), np.uint8)
    step = max(1, STRIP_PIXELS // (opened.width * factor))
    for top in range(0, height, step):
        bottom = min((top + step) * factor, opened.height)
        strip = _plain(opened.crop((0, top * factor, opened.width, bottom)))
        pixels[top : top + step] = np.asarray(strip.reduce(factor) if factor > 1 else strip)
    return pixels


def _plain(strip: Image) -> Image:
    """The same as RGBA; of 16 bits the upper half."""
    from PIL import Image

    if not strip.mode.startswith("I"):
        kept = strip if strip.mode in WITH_ALPHA else strip.convert("RGB")
        return kept.convert("RGBA")
    grey = (np.asarray(strip).astype(np.int64) >> 8).astype(np.uint8)
    return Image.fromarray(grey).convert("RGBA")


class Textures:
    """The images of one file, each decoded once."""

    def __init__(self) -> None:
        self._known: dict[str, Texture | None] = {}
        self._pixels_left, self._reduced_left = MAX_IMAGE_PIXELS, MAX_REDUCED_PIXELS
        self._bytes_left = MAX_IMAGE_BYTES
        self._problems: list[str] = []
        self._smaller: list[str] = []
        self._reduced = ""

    @property
    def notices(self) -> list[str]:
        """Those that could not be read or were reduced: the first few by name, others by number."""
        more = len(self._problems) - NAMED_IMAGES
        notes = [f"and {more} more textures were not read"] if more > 0 else []
        if self._smaller:
            rest = len(self._smaller) - NAMED_IMAGES
            named = ", ".join(self._smaller[:NAMED_IMAGES])
            notes.append(
                f"textures of more than {MAX_IMAGE_PIXELS} pixels in all: kept smaller are {named}"
                + (f" and {rest} more" if rest > 0 else "")
            )
        return [*self._problems[:NAMED_IMAGES], *notes]

    def read(self, name: str, data: Callable[[], bytes], key: str = "") -> Texture | None:
        """A decoded image; None, with a notice, where it is missing, broken or too large.

        Args:
            name: for the notice.
            data: gives the bytes; it is called once for each image.
            key: what tells the image from others; its name by default.
        """
        known = key or name
        if known not in self._known:
            self._known[known], self._reduced = None, ""
            label = shown(name, 60)
            try:
                self._known[known] = decode_texture(self._admitted(data), self._admit)
                self._smaller += [f"'{label}' ({self._reduced})"] if self._reduced else []
            except FormatError as fault:
                self._problems.append(
                    f"texture '{label}' was not read ({fault}): plain colours stand in"
                )
        return self._known[known]

    def _admitted(self, data: Callable[[], bytes]) -> bytes:
        if self._bytes_left <= 0:
            raise FormatError(f"expected at most {MAX_IMAGE_BYTES} bytes of images, got more")
        admitted = data()
        self._bytes_left -= len(admitted)
        return admitted

    def _admit(self, width: int, height: int) -> int:
        count = width * height
        if count <= self._pixels_left:
            self._pixels_left -= count
            return 1
        if count > min(self._reduced_left, MAX_IMAGE_PIXELS):
            raise FormatError(
                f"expected at most {MAX_IMAGE_PIXELS} pixels, and {self._reduced_left} more of "
                f"all that are kept smaller, got {width} x {height}"
            )
        self._reduced_left -= count
        factor = 1
        while count > SMALLER_PIXELS * factor**2:
            factor *= 2
        self._reduced = f"{width} x {height}" if factor > 1 else ""
        return factor


def colors_at_vertices(
    material: Material,
    coordinates: tuple[NDArray[np.float32], ...],
    vertex_colors: FloatArray | None,
    count: int,
) -> FloatArray:
    """Colours (V, 3), sRGB, for renderers that sample no textures.

    Vertex colours (V, 4), the base colour and its image are multiplied in linear light.
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
