"""Pictures into the streams of a film: codecs, their settings, and how colours are coded."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.ga.lookahead import ahead
from motorcade.render.scene import ImageArray

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.video.reformatter import VideoReformatter

    from motorcade.render.original import ColourCoding, OriginalVideo

QUALITY = 18
KEYFRAME_FRAMES = 15
"""From one to the next at most, so that players and pages go to any frame at once; it adds a tenth
to films of a moving camera."""


def encode(
    path: Path,
    frames: Iterable[ImageArray],
    ticks: IntArray,
    clock: Fraction,
    original: tuple[OriginalVideo, InputContainer, int] | None = None,
) -> None:
    """Encode and mux into a file that nobody reads yet.

    `original` is the video that the pictures come from, open, and the stamp in it of the first.
    """
    import av
    from av.video.reformatter import VideoReformatter

    from motorcade.render.original import ColourCoding, CopiedSound

    lossless = path.suffix == ".mkv"
    coding = ColourCoding() if original is None else original[0].coding
    kind, options = ("matroska", {}) if lossless else ("mp4", {"movflags": "+faststart"})
    with av.open(str(path), "w", format=kind, options={**options, "fflags": "+bitexact"}) as file:
        stream: Any = file.add_stream(
            "ffv1" if lossless else "libx264", rate=_usual_rate(ticks, clock)
        )
        _set_up(stream, lossless, clock, coding)
        sound = None if original is None else CopiedSound(original[1], file, original[2])
        form = VideoReformatter()

        def packets(numbered: tuple[int, ImageArray]) -> Any:
            number, picture = numbered
            frame = _frame(picture, lossless, form, coding)
            if number == 0:
                stream.height, stream.width = frame.height, frame.width
            frame.pts, frame.time_base = int(ticks[number]), clock
            return stream.encode(frame)

        for number, some in enumerate(ahead(packets, _checked(frames, len(ticks)))):
            if sound is not None:
                file.mux(list(sound.until(float(ticks[number] * clock))))
            file.mux(some)
        file.mux(stream.encode(None))
        if sound is not None:
            file.mux(list(sound.until(math.inf)))


def _checked(frames: Iterable[ImageArray], expected: int) -> Iterator[tuple[int, ImageArray]]:
    """Frames with their numbers: as many as expected, all of the first one's shape."""
    count = 0
    shape: tuple[int, ...] = ()
    for count, picture in enumerate(frames, 1):
        shape = _checked_shape(picture, shape, count - 1, expected)
        yield count - 1, picture
    if count != expected:
        raise ValueError(f"write_video(frames): expected {expected} frames, got {count}")


def _set_up(stream: Any, lossless: bool, clock: Fraction, coding: ColourCoding) -> None:
    """The codec's settings."""
    from av.codec.context import Flags

    context = stream.codec_context
    context.thread_count = 1
    context.flags |= Flags.bitexact.value
    context.time_base = clock
    if lossless:
        stream.pix_fmt = "bgr0"
        # Version 3 with a checksum a slice: damage is found, and stays where it is.
        stream.options = {"level": "3", "slicecrc": "1", "slices": "4"}
        return
    stream.pix_fmt = "yuv420p"
    # As good as the preset "veryfast" (0.1 dB and 3 % of size) in two thirds of its time. x264's
    # macroblock tree has AVX-512 code whose result varies from run to run.
    params = f"mbtree=0:subme=2:keyint={KEYFRAME_FRAMES}"
    stream.options = {"crf": str(QUALITY), "preset": "superfast", "x264-params": params}
    context.color_range, context.colorspace = coding.levels, coding.matrix
    context.color_primaries, context.color_trc = coding.primaries, coding.transfer


def _frame(
    picture: ImageArray, lossless: bool, form: VideoReformatter, coding: ColourCoding
) -> Any:
    """A picture in the codec's own form."""
    import av

    if lossless:
        # Copied by hand: the library's conversion to the padded form may round.
        padded = np.zeros((*picture.shape[:2], 4), dtype=np.uint8)
        padded[..., :3] = picture[..., ::-1]
        return av.VideoFrame.from_ndarray(padded, format="bgra").reformat(format="bgr0")
    odd = picture.shape[0] % 2, picture.shape[1] % 2
    even = np.pad(picture, ((0, odd[0]), (0, odd[1]), (0, 0)), "edge") if any(odd) else picture
    matrix, levels = coding.converted_as
    rgb = av.VideoFrame.from_ndarray(even, format="rgb24")
    return form.reformat(rgb, format="yuv420p", dst_colorspace=matrix, dst_color_range=levels)


def _checked_shape(
    picture: ImageArray, before: tuple[int, ...], count: int, expected: int
) -> tuple[int, ...]:
    """The shape of a frame that fits those before it."""
    if count >= expected:
        raise ValueError(f"write_video(frames): expected {expected} frames, got more")
    shape = picture.shape
    if (
        picture.dtype != np.uint8
        or picture.ndim != 3
        or shape[2] != 3
        or 0 in shape
        or (before and shape != before)
    ):
        raise ValueError(
            f"write_video(frames): expected uint8 RGB pictures of shape {before or '(h, w, 3)'}, "
            f"got {picture.dtype} {shape} as number {count}"
        )
    return shape


def _usual_rate(ticks: IntArray, clock: Fraction) -> Fraction:
    """The frame rate of the middle gap, for players that show one; 30 for a single frame."""
    if len(ticks) < 2:
        return Fraction(30)
    return (1 / (clock * int(np.median(np.diff(ticks))))).limit_denominator(1001)
