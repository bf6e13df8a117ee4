"""A copy of a film that can be sought frame by frame: often a keyframe, and an even clock.

Frame k stands at k / rate whatever the stamps of the recording were, so that a page asks for the
middle of a frame and gets that one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.ga.lookahead import ahead
from motorcade.ga.unfinished import unfinished
from motorcade.render.scene import ImageArray

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

    Raises:
        ValueError: another ending, or another number of images than stamps.
        OSError: the file cannot be written.
    """
    if path.suffix != ".mp4":
        raise ValueError(f"write_film(path): expected a name that ends in .mp4, got '{path.name}'")
    with unfinished(path.parent) as place:
        part = place / "film.mp4"
        count = _encode(part, _sized(images, size), _rate(time_ns))
        if count != len(time_ns):
            raise ValueError(f"write_film: expected {len(time_ns)} images, got {count}")
        part.replace(path)


def _sized(images: Iterable[ImageArray], size: tuple[int, int] | None) -> Iterator[ImageArray]:
    import cv2

    for image in images:
        if size is None or size == image.shape[1::-1]:
            yield image
        else:
            yield np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)


def _encode(path: Path, images: Iterable[ImageArray], rate: Fraction) -> int:
    """Encode and mux; returns how many images came."""
    import av
    from av.video.reformatter import VideoReformatter

    from motorcade.render.video import ColourCoding, coded_frame, set_up_codec

    apart = max(1, min(KEYFRAME_FRAMES, int(KEYFRAME_S * rate)))
    coding, form, clock, count = ColourCoding(), VideoReformatter(), Fraction(1, _TICKS), 0
    with av.open(str(path), "w", options={"movflags": "+faststart", "fflags": "+bitexact"}) as file:
        stream: Any = file.add_stream("libx264", rate=rate)
        set_up_codec(stream, False, clock, coding)
        stream.codec_context.thread_count = 0  # as many as there are processors
        # No frames that wait for later ones, as seeking through those takes twice as long.
        text = f"keyint={apart}:min-keyint={apart}:scenecut=0:bframes=0:mbtree=0:subme=2"
        stream.options = {**stream.options, "crf": str(QUALITY), "x264-params": text}

        def packets(numbered: tuple[int, ImageArray]) -> Any:
            number, image = numbered
            rgb = image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)
            frame = coded_frame(rgb, False, form, coding)
            if number == 0:
                stream.height, stream.width = frame.height, frame.width
            frame.pts, frame.time_base = round(number / rate * _TICKS), clock
            return stream.encode(frame)

        for some in ahead(packets, enumerate(images)):
            file.mux(some)
            count += 1
        file.mux(stream.encode(None))
    return count
