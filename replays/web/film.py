"""A copy of a film that can be sought frame by frame: often a keyframe, and an even clock.

Frame k stands at k / rate whatever the stamps of the recording were, so that a page asks for the
middle of a frame and gets that one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.ga.unfinished import unfinished
from motorcade.render.scene import ImageArray
from motorcade.render.video import encode

KEYFRAME_FRAMES, KEYFRAME_S = 12, 0.5
QUALITY = 23
_TICKS = 90_000


def film_rate_hz(time_ns: IntArray) -> float:
    """The even rate for stamps ``(F,)``: that of their middle step, so that clips play as taken."""
    return float(_rate(time_ns))


def _rate(time_ns: IntArray) -> Fraction:
    if len(time_ns) < 2:
        return Fraction(30)
    rate = 1e9 / float(np.median(np.diff(time_ns)))
    return Fraction(min(max(rate, 1.0), 240.0)).limit_denominator(1000)


def film_size(width: int, height: int, longest_px: int) -> tuple[int, int]:
    """Width and height of images made small enough that neither is above `longest_px`."""
    scale = min(1.0, longest_px / max(width, height))
    return max(1, round(width * scale)), max(1, round(height * scale))


def write_film(
    path: Path,
    images: Iterable[ImageArray],
    time_ns: IntArray,
    size: tuple[int, int] | None = None,
) -> None:
    """Write images as an H.264 MP4 for pages; the file appears complete or not at all.

    Args:
        path: a name that ends in `.mp4`.
        images: uint8 ``(h, w)`` or ``(h, w, 3)`` of one size, one a stamp.
        time_ns: ``(F,)`` the recording's stamps, which give the rate.
        size: width and height that the film has them in, by default their own.

    Raises ValueError: another ending, or another number of images than stamps; OSError: the file
    cannot be written.
    """
    if path.suffix != ".mp4":
        raise ValueError(f"write_film(path): expected a name that ends in .mp4, got '{path.name}'")
    rate = _rate(time_ns)
    ticks = np.array([round(number / rate * _TICKS) for number in range(len(time_ns))])
    apart = max(1, min(KEYFRAME_FRAMES, int(KEYFRAME_S * rate)))
    # No frames that wait for later ones, as seeking through those takes twice as long.
    text = f"keyint={apart}:min-keyint={apart}:scenecut=0:bframes=0:mbtree=0:subme=2"
    codec = {"crf": str(QUALITY), "x264-params": text}
    with unfinished(path.parent) as place:
        part = place / "film.mp4"
        encode(part, _sized(images, size), ticks, Fraction(1, _TICKS), codec=codec)
        part.replace(path)


def _sized(images: Iterable[ImageArray], size: tuple[int, int] | None) -> Iterator[ImageArray]:
    import cv2

    for image in images:
        rgb = image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)
        if size is not None and size != image.shape[1::-1]:
            rgb = np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA), np.uint8)
        yield rgb
