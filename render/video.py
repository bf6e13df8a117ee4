"""Videos in and out: H.264, lossless FFV1, contact sheets; what a film keeps of its original.

A film's frame times are on the original's clock, colours are coded as there, and sound is copied
packet by packet, in step with the images.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import admit_file
from motorcade.ga.lookahead import ahead
from motorcade.ga.stamps import LONGEST_BRIDGE_S, segments
from motorcade.ga.unfinished import unfinished
from motorcade.render.scene import ImageArray

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.video.reformatter import VideoReformatter

__all__ = [
    "contact_sheet",
    "open_video",
    "read_frames",
    "read_original",
    "read_stamps_s",
    "write_video",
]

MAX_FILE_BYTES = 1 << 40
MAX_PIXELS = 100_000_000
TIME_LIMIT_S = 60.0
"""For opening a video, and for each reading of it: slow disks answer within seconds."""
_CONTAINERS = "mov,matroska,avi,mpeg,mpegts,mpegvideo,m4v"
CLOCKS_HZ = {".mp4": 90_000, ".mkv": 1000}
MOST_APART_S = 21_600.0  # MP4 counts a frame's ticks in 32 bits


def write_video(
    path: Path,
    frames: Iterable[ImageArray],
    time_ns: ArrayLike,
    original: OriginalVideo | None = None,
) -> None:
    """Write frames as an H.264 MP4 (yuv420p, BT.709, fast start), or as lossless FFV1 in Matroska.

    H.264 in this form needs even sizes: an odd last column or row is repeated once. FFV1 gives back
    every byte of every frame.

    Args:
        path: a name that ends in ".mp4" (H.264) or ".mkv" (FFV1). The file appears complete or not
            at all.
        frames: uint8 RGB images (h, w, 3) of one size, one for each stamp.
        time_ns: (N,) strictly increasing stamps in ns; the video starts at the first. Through a
            gap of more than ten seconds that splits them (see `motorcade.ga.stamps`) an MP4 shows
            the frame before it for ten seconds, and goes on; Matroska keeps the stamps.
        original: the video that the frames were made from, whose stamps `time_ns` are: an MP4 then
            keeps its frame times, its coding of colours and its sound (packets as they are).

    Raises:
        ValueError: another ending, an original with another ending than ".mp4", stamps that do not
            increase or are farther apart than six hours without being gaps (MP4), frames of other
            shapes, or another number of frames than stamps.
        OSError: the file cannot be written.
    """
    if path.suffix not in CLOCKS_HZ:
        raise ValueError(f"write_video(path): expected a name ending in .mp4 or .mkv, got {path}")
    if original is not None and path.suffix != ".mp4":
        raise ValueError(f"write_video(original): expected a film in .mp4, got {path.name}")
    clock = Fraction(1, CLOCKS_HZ[path.suffix]) if original is None else original.clock
    stamps = np.asarray(time_ns)
    ticks = _ticks(stamps, clock, bridged=path.suffix == ".mp4" and original is None)
    with unfinished(path.parent) as place:
        part = place / f"part{path.suffix}"
        if original is None:
            encode(part, frames, ticks, clock)
        else:
            with open_video(original.path) as container:
                encode(part, frames, ticks, clock, (original, container, int(stamps[0])))
        part.replace(path)


def open_video(path: Path, *, edited: bool = True) -> InputContainer:
    """Open a video that others made; close it, or use it as a context manager.

    Nothing but the file is opened: it must be a container of video itself (MP4, Matroska, AVI,
    MPEG), as playlists name other files, pipes and addresses. Images of more than `MAX_PIXELS`
    are not decoded. Where `edited` is False, images are there that an MP4's edit list cuts away.

    Raises:
        FileError: what `ga.files.admit_file` refuses.
        av.FFmpegError: no such container.
    """
    import av

    admit_file(path, MAX_FILE_BYTES)
    limits = {"protocol_whitelist": "file", "format_whitelist": _CONTAINERS}
    if not edited:
        limits["ignore_editlist"] = "1"
    container = av.open(
        str(path.resolve()), options=limits, metadata_errors="replace", timeout=TIME_LIMIT_S
    )
    for stream in container.streams.video:
        if stream.codec_context is not None:  # None where the coding is unknown
            stream.codec_context.options = {"max_pixels": str(MAX_PIXELS)}
    return container


def read_original(path: Path) -> OriginalVideo:
    """What a film made of a video keeps of it; `write_video` takes it.

    Raises:
        FileError: a file that cannot be read.
        OSError: one that holds no video.
    """
    from motorcade.render.video import OriginalVideo

    with open_video(path) as container:
        return OriginalVideo.of(path, container)


def read_stamps_s(path: Path) -> FloatArray:
    """When the frames of a video file begin ``(F,)``, in seconds of the film, in order.

    Raises:
        FileError: a file that cannot be read.
        OSError: one that holds no video.
    """
    with open_video(path) as container:
        if not container.streams.video:
            raise OSError(f"{path}: expected a video stream, got none")
        stream = container.streams.video[0]
        clock = stream.time_base
        ticks = [one.pts for one in container.demux(stream) if one.pts is not None]
    if clock is None:
        raise OSError(f"{path}: expected a clock of the video, got none")
    return np.sort(np.array(ticks, dtype=np.float64)) * float(clock)


def read_frames(path: Path, every: int = 1) -> Iterator[tuple[int, ImageArray]]:
    """The frames of a video file, decoded.

    Args:
        path: of the file.
        every: which of them: the first, and each n-th after it.

    Yields:
        stamp in ns from the start of the video, and the uint8 RGB image (h, w, 3).

    Raises:
        FileError: a file that cannot be read.
        OSError: one that holds no video.
        ValueError: `every` below 1.

    >>> import tempfile
    >>> import numpy as np
    >>> from pathlib import Path
    >>> from motorcade.render import read_frames, write_video
    >>> images = [np.full((48, 64, 3), grey, np.uint8) for grey in (0, 128)]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "grey.mkv")  # lossless; .mp4 is H.264
    ...     write_video(path, images, np.array([0, 40_000_000]))
    ...     again = [(time_ns, int(image[0, 0, 0])) for time_ns, image in read_frames(path)]
    >>> again
    [(0, 0), (40000000, 128)]
    """
    if every < 1:
        raise ValueError(f"read_frames(every): expected 1 or more, got {every}")
    with open_video(path) as container:
        if not container.streams.video:
            raise OSError(f"{path}: expected a video stream, got none")
        for frame in islice(container.decode(video=0), None, None, every):
            if frame.pts is None or frame.time_base is None:
                raise OSError(f"{path}: expected a stamp on every frame, got one without")
            stamp_ns = round(frame.pts * frame.time_base * 1_000_000_000)
            yield stamp_ns, np.asarray(frame.to_ndarray(format="rgb24"), dtype=np.uint8)


def _ticks(stamps: IntArray, clock: Fraction, *, bridged: bool) -> IntArray:
    """Stamps on the video's clock, from zero; long gaps made shorter where that is asked for."""
    if stamps.ndim != 1 or stamps.size == 0 or stamps.dtype.kind != "i":
        raise ValueError(
            "write_video(time_ns): expected integers of shape (N,), got "
            f"{stamps.dtype} {stamps.shape}"
        )
    if bridged:
        stamps = _without_long_gaps(stamps)
    per_ns = 1e-9 / float(clock)
    ticks: IntArray = np.rint((stamps - stamps[0]) * per_ns).astype(np.int64)
    if np.any(np.diff(ticks) <= 0):
        raise ValueError(
            f"write_video(time_ns): expected stamps at least {clock} s apart and increasing"
        )
    return ticks


def _without_long_gaps(time_ns: IntArray) -> IntArray:
    """Stamps whose splitting gaps are ten seconds long."""
    steps = np.diff(time_ns)
    for part in segments(time_ns)[1:]:
        steps[part.start - 1] = round(LONGEST_BRIDGE_S * 1e9)
    longest_s = 1e-9 * float(steps.max(initial=0))
    if longest_s > MOST_APART_S:
        raise ValueError(
            f"write_video(time_ns): expected stamps at most {MOST_APART_S:g} s apart, got "
            f"{longest_s:.6g} s"
        )
    shorter: IntArray = time_ns[0] + np.append(0, np.cumsum(steps))
    return shorter


GAP_PX, PAPER = 6, 250


def contact_sheet(
    frames: Iterable[ImageArray], columns: int, width: int, labels: Sequence[str] = ()
) -> ImageArray:
    """Frames side by side, row by row, each made smaller and labelled in its corner.

    Args:
        frames: uint8 (h, w, 3) of one size, 1 or more.
        columns: a row holds, 1 or more.
        width: of each image on the sheet, pixels.
        labels: one a frame, or none; in plain ASCII.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ValueError: no frames, sizes that differ, labels that do not fit, or a count below 1.

    >>> import numpy as np
    >>> from motorcade.render.video import contact_sheet
    >>> contact_sheet(np.zeros((3, 48, 64, 3), np.uint8), columns=2, width=32).shape
    (66, 82, 3)
    """
    images = list(frames)
    if not images or any(one.shape != images[0].shape for one in images) or 0 in images[0].shape:
        shapes = sorted({one.shape for one in images})
        raise ValueError(f"contact_sheet(frames): expected frames of one size, got {shapes}")
    if columns < 1 or width < 1 or (labels and len(labels) != len(images)):
        raise ValueError(
            f"contact_sheet: expected columns and a width above 0 and a label a frame, got "
            f"{columns}, {width} and {len(labels)} labels for {len(images)} frames"
        )
    height = max(1, round(images[0].shape[0] * width / images[0].shape[1]))
    rows = -(-len(images) // columns)
    step = height + GAP_PX, width + GAP_PX
    across = min(columns, len(images))
    sheet = np.full((rows * step[0] + GAP_PX, across * step[1] + GAP_PX, 3), PAPER, np.uint8)
    for k, frame in enumerate(images):
        small = cv2.resize(frame, (width, height), interpolation=cv2.INTER_AREA)
        if labels:
            _write(small, labels[k])
        top, left = GAP_PX + (k // columns) * step[0], GAP_PX + (k % columns) * step[1]
        sheet[top : top + height, left : left + width] = small
    return sheet


def _write(image: ImageArray, text: str) -> None:
    """A label in the upper left corner, light with a dark rim."""
    size = max(0.35, min(1.0, image.shape[1] / 420.0))
    x, y = int(8 * size), int(22 * size)
    # The rim is made of shifted copies: thicker strokes would be spaced wider.
    rim = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy]
    for dx, dy, color in [(*step, (0, 0, 0)) for step in rim] + [(0, 0, (255, 255, 255))]:
        cv2.putText(
            image,
            text,
            (x + dx, y + dy),
            cv2.FONT_HERSHEY_SIMPLEX,
            0.6 * size,
            color,
            1,
            cv2.LINE_AA,
        )


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
    codec: Mapping[str, str] | None = None,
) -> None:
    """Encode and mux into a file that nobody reads yet.

    `original` is the video that the images come from, open, and the stamp in it of the first;
    `codec` are settings other than the usual, with as many threads as there are processors.
    """
    import av
    from av.video.reformatter import VideoReformatter

    from motorcade.render.video import ColourCoding, CopiedSound

    lossless = path.suffix == ".mkv"
    coding = ColourCoding() if original is None else original[0].coding
    kind, options = ("matroska", {}) if lossless else ("mp4", {"movflags": "+faststart"})
    with av.open(str(path), "w", format=kind, options={**options, "fflags": "+bitexact"}) as file:
        stream: Any = file.add_stream(
            "ffv1" if lossless else "libx264", rate=_usual_rate(ticks, clock)
        )
        set_up_codec(stream, lossless, clock, coding)
        if codec is not None:
            stream.options, stream.codec_context.thread_count = {**stream.options, **codec}, 0
        sound = None if original is None else CopiedSound(original[1], file, original[2])
        form = VideoReformatter()

        def packets(numbered: tuple[int, ImageArray]) -> Any:
            number, image = numbered
            frame = coded_frame(image, lossless, form, coding)
            if number == 0:
                stream.height, stream.width = frame.height, frame.width
            frame.pts, frame.time_base = int(ticks[number]), clock
            return stream.encode(frame)

        for number, some in enumerate(ahead(packets, _checked(frames, len(ticks)))):
            if sound is not None:
                file.mux(list(sound.until(float(ticks[number] * clock))))
            file.mux(some)
        file.mux(stream.encode(None))
        if original is not None and sound is not None:
            film, _, start_ns = original
            ends_s = math.inf if film.until_ns is None else 1e-9 * (film.until_ns - start_ns)
            file.mux(list(sound.until(ends_s)))


def _checked(frames: Iterable[ImageArray], expected: int) -> Iterator[tuple[int, ImageArray]]:
    """Frames with their numbers: as many as expected, all of the first one's shape."""
    count = 0
    shape: tuple[int, ...] = ()
    for count, image in enumerate(frames, 1):
        shape = _checked_shape(image, shape, count - 1, expected)
        yield count - 1, image
    if count != expected:
        raise ValueError(f"write_video(frames): expected {expected} frames, got {count}")


def set_up_codec(stream: Any, lossless: bool, clock: Fraction, coding: ColourCoding) -> None:
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


def coded_frame(
    image: ImageArray, lossless: bool, form: VideoReformatter, coding: ColourCoding
) -> Any:
    """An image in the codec's own form."""
    import av

    if lossless:
        # Copied by hand: the library's conversion to the padded form may round.
        padded = np.zeros((*image.shape[:2], 4), dtype=np.uint8)
        padded[..., :3] = image[..., ::-1]
        return av.VideoFrame.from_ndarray(padded, format="bgra").reformat(format="bgr0")
    odd = image.shape[0] % 2, image.shape[1] % 2
    even = np.pad(image, ((0, odd[0]), (0, odd[1]), (0, 0)), "edge") if any(odd) else image
    matrix, levels = coding.converted_as
    rgb = av.VideoFrame.from_ndarray(even, format="rgb24")
    return form.reformat(rgb, format="yuv420p", dst_colorspace=matrix, dst_color_range=levels)


def _checked_shape(
    image: ImageArray, before: tuple[int, ...], count: int, expected: int
) -> tuple[int, ...]:
    """The shape of a frame that fits those before it."""
    if count >= expected:
        raise ValueError(f"write_video(frames): expected {expected} frames, got more")
    shape = image.shape
    if (
        image.dtype != np.uint8
        or image.ndim != 3
        or shape[2] != 3
        or 0 in shape
        or (before and shape != before)
    ):
        raise ValueError(
            f"write_video(frames): expected uint8 RGB images of shape {before or '(h, w, 3)'}, "
            f"got {image.dtype} {shape} as number {count}"
        )
    return shape


def _usual_rate(ticks: IntArray, clock: Fraction) -> Fraction:
    """The frame rate of the middle gap, for players that show one; 30 for a single frame."""
    if len(ticks) < 2:
        return Fraction(30)
    return (1 / (clock * int(np.median(np.diff(ticks))))).limit_denominator(1001)


log = logging.getLogger("motorcade.overlay")

_NANOSECOND_S = Fraction(1, 10**9)
"""To which a film's start is rounded."""
_LEAST_TICKS = 1000
"""A second on a film's clock: an AVI's counts images, which lie closer where some are mended."""
_SOUND_HZ = 48_000
"""To which sound is moved with the images."""
BT_709, UNSPECIFIED, LIMITED, FULL = 1, 2, 1, 2
_CONVERTED = {1: 1, 2: 5, 4: 4, 5: 5, 6: 5, 7: 7, 9: 9}
"""Matrices by their number in ITU-T H.273, and as what images are converted with them: those that
say none are read as BT.601 has it, so they are written so too. 10 (constant luminance) and those of
RGB are not among them.
"""


@dataclass(frozen=True)
class ColourCoding:
    """How a video's numbers stand for colours, by the numbers of ITU-T H.273; BT.709 by default.

    Fields:
        matrix, primaries, transfer: 2 where the video does not say.
        levels: 1 limited (16 to 235), 2 full; 0 where the video does not say: limited.
    """

    matrix: int = BT_709
    primaries: int = BT_709
    transfer: int = BT_709
    levels: int = LIMITED

    @property
    def converted_as(self) -> tuple[int, int]:
        """Matrix and levels by which images become numbers of this coding."""
        return _CONVERTED[self.matrix], FULL if self.levels == FULL else LIMITED


@dataclass(frozen=True)
class OriginalVideo:
    """What a film keeps of the video that it is made from.

    Fields:
        clock: of its frames, seconds a tick.
        coding: of its colours.
        until_ns: stamp at which a film of a part of it ends, its sound too; None at its own end.
    """

    path: Path
    clock: Fraction
    coding: ColourCoding
    until_ns: int | None = None

    @classmethod
    def of(cls, path: Path, container: InputContainer) -> OriginalVideo:
        """What an open video is; see `motorcade.render.video.read_original`.

        Raises OSError: it holds no video.
        """
        stream = next(iter(container.streams.video), None)
        if stream is None or stream.time_base is None:
            raise OSError(f"{path}: expected a video stream with a clock, got none")
        ticks = stream.time_base.denominator
        clock = Fraction(1, ticks * max(1, -(-_LEAST_TICKS // ticks)))
        context: Any = stream.codec_context
        codes = context.colorspace, context.color_primaries, context.color_trc
        matrix, primaries, transfer = map(int, codes)
        if matrix not in _CONVERTED:
            return cls(path, clock, ColourCoding())
        # Older names of pixel forms say full levels by themselves, whatever the container says.
        old = str(context.pix_fmt).startswith("yuvj")
        levels = FULL if old else int(context.color_range)
        return cls(path, clock, ColourCoding(matrix, primaries, transfer, levels))


class CopiedSound:
    """The sound of a video on its way into a film.

    What sounds before the film starts is left out, to a packet. Where packets' stamps repeat, as of
    AVI files that store several a chunk, they are counted by how long each sounds.

    Args:
        container: the video, open.
        film: an open container, to which its tracks are added; those that it cannot hold are left
            out, which is said.
        start_ns: stamp of the original at which the film starts.
    """

    def __init__(self, container: InputContainer, film: Any, start_ns: int) -> None:
        self._start_s = Fraction(start_ns, 10**9)
        self._tracks: dict[int, Any] = {}
        for stream in container.streams.audio:
            context = stream.codec_context
            try:
                if context is None:
                    raise ValueError("its coding is unknown")
                self._tracks[stream.index] = film.add_stream_from_template(stream)
            except ValueError as fault:
                name = "an unknown coding" if context is None else context.name
                log.warning(
                    "overlay: sound of %s (%s) is left out: the film cannot hold it: %s",
                    container.name,
                    name,
                    fault,
                )
        chosen = [container.streams[index] for index in self._tracks]
        packets = container.demux(chosen) if chosen else iter(())
        self._packets = _counted(packets)
        self._next: Any = None

    def until(self, time_s: float) -> Iterator[Any]:
        """Packets that begin before a time of the film and were not given yet."""
        while True:
            packet = self._next if self._next is not None else next(self._packets, None)
            self._next = None
            if packet is None:
                return
            starts_s = packet.dts * packet.time_base - self._start_s
            if starts_s <= -_NANOSECOND_S and packet.dts >= 0:
                continue  # before the film; what is below zero in the original fills a decoder
            if float(starts_s) >= time_s:
                self._next = packet
                return
            finer = max(1, int(packet.time_base * _SOUND_HZ))  # an AVI's clock counts packets
            fine = packet.time_base / finer
            shift = round(self._start_s / fine)
            dts, pts, lasts = packet.dts, packet.pts, packet.duration
            packet.stream = self._tracks[packet.stream_index]
            packet.time_base = Fraction(fine.numerator, fine.denominator)
            packet.dts = finer * dts - shift
            packet.pts = None if pts is None else finer * pts - shift
            packet.duration = None if lasts is None else finer * lasts
            yield packet


def _counted(packets: Iterator[Any]) -> Iterator[Any]:
    """The packets of tracks that have stamps; of a track where these repeat, stamps by counting."""
    first: dict[int, Fraction] = {}
    last: dict[int, int] = {}
    sounded: dict[int, Fraction] = {}  # ticks since a track's first packet
    repeat: set[int] = set()
    for packet in packets:
        if packet.size == 0 or packet.dts is None or packet.time_base is None:
            continue  # the end of a track
        track, context = packet.stream_index, packet.stream.codec_context
        ticks = Fraction(packet.duration or 0)
        if context.frame_size and context.sample_rate:
            ticks = Fraction(context.frame_size, context.sample_rate) / packet.time_base
        start = first.setdefault(track, Fraction(packet.dts)) + sounded.get(track, Fraction(0))
        sounded[track] = sounded.get(track, Fraction(0)) + ticks
        if packet.dts <= last.get(track, packet.dts - 1):
            repeat.add(track)
        if track in repeat:
            packet.dts = packet.pts = max(round(start), last[track] + 1)
        last[track] = packet.dts
        yield packet
