"""Video through PyAV: H.264, or lossless FFV1; whole or not at all, same frames to same bytes.

Stamps are kept, so uneven recordings play at their own pace: to 1/90000 s in MP4, to 1 ms in
Matroska, which knows no finer. The encoders run on one thread, H.264 with its default rate control
at a fixed quality, and neither dates nor version strings of the container enter the file.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import IntArray
from motorcade.render.scene import ImageArray
from motorcade.render.video.ahead import ahead

CLOCKS_HZ = {".mp4": 90_000, ".mkv": 1000}
QUALITY = 18
BT_709 = 1


def write_video(path: Path, frames: Iterable[ImageArray], time_ns: ArrayLike) -> None:
    """Write frames as an H.264 MP4 (yuv420p, BT.709, fast start), or as lossless FFV1 in Matroska.

    H.264 in this form needs even sizes: an odd last column or row is repeated once. FFV1 gives back
    every byte of every frame.

    Args:
        path: a name that ends in ".mp4" (H.264) or ".mkv" (FFV1). The file appears complete or not
            at all.
        frames: uint8 RGB pictures (h, w, 3) of one size, one for each stamp.
        time_ns: (N,) strictly increasing stamps in ns; the video starts at the first.

    Raises:
        ValueError: another ending, stamps that do not increase, frames of other shapes, or
            another number of frames than stamps.
        OSError: the file cannot be written.
    """
    if path.suffix not in CLOCKS_HZ:
        raise ValueError(f"write_video(path): expected a name ending in .mp4 or .mkv, got {path}")
    stamps = _ticks(time_ns, CLOCKS_HZ[path.suffix])
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        _encode(part, frames, stamps)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def read_frames(path: Path, every: int = 1) -> Iterator[tuple[int, ImageArray]]:
    """The frames of a video file, decoded.

    Args:
        path: of the file.
        every: which of them: the first, and each n-th after it.

    Yields:
        stamp in ns from the start of the video, and the uint8 RGB picture (h, w, 3).

    Raises:
        OSError: a file that cannot be read or holds no video.
        ValueError: `every` below 1.
    """
    import av

    if every < 1:
        raise ValueError(f"read_frames(every): expected 1 or more, got {every}")
    with av.open(str(path)) as container:
        if not container.streams.video:
            raise OSError(f"{path}: expected a video stream, got none")
        for frame in islice(container.decode(video=0), None, None, every):
            if frame.pts is None or frame.time_base is None:
                raise OSError(f"{path}: expected a stamp on every frame, got one without")
            stamp_ns = round(frame.pts * frame.time_base * 1_000_000_000)
            yield stamp_ns, np.asarray(frame.to_ndarray(format="rgb24"), dtype=np.uint8)


def _ticks(time_ns: ArrayLike, clock_hz: int) -> IntArray:
    """Stamps on the video's clock, from zero."""
    stamps = np.asarray(time_ns)
    if stamps.ndim != 1 or stamps.size == 0 or stamps.dtype.kind != "i":
        raise ValueError(
            "write_video(time_ns): expected integers of shape (N,), got "
            f"{stamps.dtype} {stamps.shape}"
        )
    ticks: IntArray = np.rint((stamps - stamps[0]) * (clock_hz * 1e-9)).astype(np.int64)
    if np.any(np.diff(ticks) <= 0):
        raise ValueError(
            f"write_video(time_ns): expected stamps at least 1/{clock_hz} s apart and increasing"
        )
    return ticks


def _encode(path: Path, frames: Iterable[ImageArray], ticks: IntArray) -> None:
    """Encode and mux into a file that nobody reads yet."""
    import av

    lossless = path.suffix == ".mkv"
    clock = Fraction(1, CLOCKS_HZ[path.suffix])
    kind, options = ("matroska", {}) if lossless else ("mp4", {"movflags": "+faststart"})
    with av.open(str(path), "w", format=kind, options={**options, "fflags": "+bitexact"}) as file:
        stream: Any = file.add_stream(
            "ffv1" if lossless else "libx264", rate=_usual_rate(ticks, clock)
        )
        _set_up(stream, lossless, clock)

        def packets(numbered: tuple[int, ImageArray]) -> Any:
            number, picture = numbered
            frame = _frame(picture, lossless)
            if number == 0:
                stream.height, stream.width = frame.height, frame.width
            frame.pts, frame.time_base = int(ticks[number]), clock
            return stream.encode(frame)

        for some in ahead(packets, _checked(frames, len(ticks))):
            file.mux(some)
        file.mux(stream.encode(None))


def _checked(frames: Iterable[ImageArray], expected: int) -> Iterator[tuple[int, ImageArray]]:
    """Frames with their numbers: as many as expected, all of the first one's shape."""
    count = 0
    shape: tuple[int, ...] = ()
    for count, picture in enumerate(frames, 1):
        shape = _checked_shape(picture, shape, count - 1, expected)
        yield count - 1, picture
    if count != expected:
        raise ValueError(f"write_video(frames): expected {expected} frames, got {count}")


def _set_up(stream: Any, lossless: bool, clock: Fraction) -> None:
    """The codec's settings."""
    from av.codec.context import Flags
    from av.video.reformatter import ColorRange, Colorspace

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
    # x264's macroblock tree has AVX-512 code whose result varies from run to run.
    stream.options = {"crf": str(QUALITY), "preset": "veryfast", "x264-params": "mbtree=0"}
    context.color_range = ColorRange.MPEG.value
    context.colorspace = Colorspace.ITU709.value
    context.color_primaries = BT_709
    context.color_trc = BT_709


def _frame(picture: ImageArray, lossless: bool) -> Any:
    """A picture in the codec's own form."""
    import av
    from av.video.reformatter import ColorRange, Colorspace

    if lossless:
        # Copied by hand: the library's conversion to the padded form may round.
        padded = np.zeros((*picture.shape[:2], 4), dtype=np.uint8)
        padded[..., :3] = picture[..., ::-1]
        return av.VideoFrame.from_ndarray(padded, format="bgra").reformat(format="bgr0")
    even = np.pad(picture, ((0, picture.shape[0] % 2), (0, picture.shape[1] % 2), (0, 0)), "edge")
    return av.VideoFrame.from_ndarray(even, format="rgb24").reformat(
        format="yuv420p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
    )


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
