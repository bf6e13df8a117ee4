"""H.264 video through PyAV: written whole or not at all, with the same bytes for the same frames.

Stamps are kept to 1/90000 s, so uneven recordings play at their own pace. The encoder runs on one
thread with its default rate control at a fixed quality, and neither dates nor version strings of
the container enter the file.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import IntArray
from motorcade.render.scene import ImageArray

CLOCK_HZ = 90_000
QUALITY = 18
BT_709 = 1


def write_video(path: Path, frames: Iterable[ImageArray], time_ns: ArrayLike) -> None:
    """Write frames as an H.264 MP4 (yuv420p, BT.709, fast start).

    H.264 in this form needs even sizes: an odd last column or row is repeated once.

    Args:
        path: a name that ends in ".mp4". The file appears complete or not at all.
        frames: uint8 RGB pictures (h, w, 3) of one size, one for each stamp.
        time_ns: (N,) strictly increasing stamps in ns; the video starts at the first.

    Raises:
        ValueError: another ending, stamps that do not increase, frames of other shapes, or
            another number of frames than stamps.
        OSError: the file cannot be written.
    """
    stamps = _ticks(time_ns)
    if path.suffix != ".mp4":
        raise ValueError(f"write_video(path): expected a name ending in .mp4, got {path}")
    part = path.with_name(f".{path.stem}.{os.getpid()}.part.mp4")
    try:
        _encode(part, frames, stamps)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def read_frames(path: Path) -> Iterator[tuple[int, ImageArray]]:
    """The frames of a video file, decoded.

    Yields:
        stamp in ns from the start of the video, and the uint8 RGB picture (h, w, 3).

    Raises:
        OSError: a file that cannot be read or holds no video.
    """
    import av

    with av.open(str(path)) as container:
        if not container.streams.video:
            raise OSError(f"{path}: expected a video stream, got none")
        for frame in container.decode(video=0):
            if frame.pts is None or frame.time_base is None:
                raise OSError(f"{path}: expected a stamp on every frame, got one without")
            stamp_ns = round(frame.pts * frame.time_base * 1_000_000_000)
            yield stamp_ns, np.asarray(frame.to_ndarray(format="rgb24"), dtype=np.uint8)


def _ticks(time_ns: ArrayLike) -> IntArray:
    """Stamps on the video's clock, from zero."""
    stamps = np.asarray(time_ns)
    if stamps.ndim != 1 or stamps.size == 0 or stamps.dtype.kind != "i":
        raise ValueError(
            "write_video(time_ns): expected integers of shape (N,), got "
            f"{stamps.dtype} {stamps.shape}"
        )
    ticks: IntArray = np.rint((stamps - stamps[0]) * (CLOCK_HZ * 1e-9)).astype(np.int64)
    if np.any(np.diff(ticks) <= 0):
        raise ValueError(
            f"write_video(time_ns): expected stamps at least 1/{CLOCK_HZ} s apart and increasing"
        )
    return ticks


def _encode(path: Path, frames: Iterable[ImageArray], ticks: IntArray) -> None:
    """Encode and mux into a file that nobody reads yet."""
    import av
    from av.codec.context import Flags
    from av.video.reformatter import ColorRange, Colorspace

    options = {"movflags": "+faststart", "fflags": "+bitexact"}
    with av.open(str(path), "w", format="mp4", options=options) as container:
        stream = container.add_stream("libx264", rate=_usual_rate(ticks))
        stream.pix_fmt = "yuv420p"
        # x264's macroblock tree has AVX-512 code whose result varies from run to run.
        stream.options = {
            "crf": str(QUALITY),
            "preset": "veryfast",
            "x264-params": "mbtree=0",
        }
        stream.codec_context.thread_count = 1
        stream.codec_context.flags |= Flags.bitexact.value
        stream.codec_context.time_base = Fraction(1, CLOCK_HZ)
        stream.codec_context.color_range = ColorRange.MPEG.value
        stream.codec_context.colorspace = Colorspace.ITU709.value
        stream.codec_context.color_primaries = BT_709
        stream.codec_context.color_trc = BT_709
        count = 0
        shape: tuple[int, ...] = ()
        for picture in frames:
            shape = _checked_shape(picture, shape, count, len(ticks))
            even = np.pad(picture, ((0, shape[0] % 2), (0, shape[1] % 2), (0, 0)), mode="edge")
            if count == 0:
                stream.height, stream.width = even.shape[:2]
            frame = av.VideoFrame.from_ndarray(even, format="rgb24").reformat(
                format="yuv420p",
                dst_colorspace=Colorspace.ITU709,
                dst_color_range=ColorRange.MPEG,
            )
            frame.pts = int(ticks[count])
            frame.time_base = Fraction(1, CLOCK_HZ)
            container.mux(stream.encode(frame))
            count += 1
        if count != len(ticks):
            raise ValueError(f"write_video(frames): expected {len(ticks)} frames, got {count}")
        container.mux(stream.encode(None))


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
        or (before and shape != before)
    ):
        raise ValueError(
            f"write_video(frames): expected uint8 RGB pictures of shape {before or '(h, w, 3)'}, "
            f"got {picture.dtype} {shape} as number {count}"
        )
    return shape


def _usual_rate(ticks: IntArray) -> Fraction:
    """The frame rate of the middle gap, for players that show one; 30 for a single frame."""
    if len(ticks) < 2:
        return Fraction(30)
    return Fraction(CLOCK_HZ, int(np.median(np.diff(ticks)))).limit_denominator(1001)
