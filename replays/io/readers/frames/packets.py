"""The images of a video in the order they are shown: which packets they come from, and when.

A packet gets its number in the file as its stamp before it is decoded, and decoders hand that on to
the image. So an image is known whatever stamps a container stores: none (AVI), those of storage
where images are shown in another order, or damaged ones. Where stored stamps tell the order,
`scan` decodes nothing; where they do not, or damage is looked for, `look_through` decodes all once.

Whether a video file is as long as its own outermost boxes say, so that a cut copy is named.

Players make the best of a cut file: they show what is there, and say nothing. Looked at are the
boxes of MP4 and MOV (ISO 14496-12), the segment of Matroska and WebM (RFC 9559), and the first
RIFF chunk of AVI. Files of which the length is not told, such as streams, pass.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from av.codec.context import ThreadType
from av.container import Flags, InputContainer
from av.error import EOFError as EndError
from av.error import FFmpegError, InvalidDataError
from av.packet import Packet
from av.video.frame import VideoFrame
from av.video.stream import VideoStream

from motorcade.ga.arrays import IntArray
from motorcade.ga.names import one_line
from motorcade.ga.progress import track
from motorcade.render.video import MAX_FILE_BYTES, MAX_PIXELS, open_video
from motorcade.replays.io.files import open_bounded, refusal, refused
from motorcade.replays.io.readers.frames.images import FRAME_LIMIT

_ASSUMED_HZ = Fraction(25)  # as FFmpeg takes it where neither stamps nor a rate are stored
_LEAST_APART_NS = 1_000_000  # between stamps that are counted: ticks of a film's clock
_LEAST_STEP_NS = 10_000.0
"""Nothing is filmed a hundred thousand times a second and shown as fast."""
_HIDDEN = 0x10  # of VP8's first byte: clear in an image that is for reference only (RFC 6386, 9.1)
_GUESSED: Any = Flags.gen_pts.value  # stamps that FFmpeg would make up of those that follow
Stored = tuple[int | None, int | None, int, bool]
"""What the container says of a packet: pts, dts, its size in bytes, and whether a keyframe."""


@dataclass(frozen=True, eq=False)
class ShownImages:
    """The images of a video that are shown, in that order.

    Fields:
        stored: what the container says of every packet, by number.
        hidden: numbers of packets that are decoded only for others' sake.
        packets: number of the packet ``(N,)`` that each image comes from.
        time_ns: stamps ``(N,)``, strictly increasing.
        keys: images from which decoding may start, as places in that order, increasing.
        size: width and height as coded.
        damaged: places of images that a decoder flags, or of which it lacks the reference.
        lost: how many packets gave no image.
        notes: what was taken for granted, for people.
        looked: whether all was decoded to know this.
    """

    stored: Sequence[Stored]
    hidden: frozenset[int]
    packets: IntArray
    time_ns: IntArray
    keys: IntArray
    size: tuple[int, int]
    damaged: frozenset[int] = frozenset()
    lost: int = 0
    notes: tuple[str, ...] = ()
    looked: bool = False

    @property
    def threads(self) -> ThreadType:
        """How to decode: on one thread where there is damage, whose traces else vary."""
        return ThreadType.NONE if self.damaged or self.lost else ThreadType.AUTO


def open_stream(path: Path) -> tuple[InputContainer, VideoStream]:
    """The file and its first video stream, with the stamps that are stored and no others.

    Raises:
        RecordingError: no video stream, or one of an unknown coding.
        FFmpegError: no video.
    """
    with refused():
        container = open_video(path)
    container.flags &= ~_GUESSED
    stream: Any = next(iter(container.streams.video), None)
    if stream is None or stream.codec_context is None:
        container.close()
        known = "stream, got none" if stream is None else "of a known coding, got another"
        raise refusal(path, f"expected a video {known}")
    return container, stream


def stored_packets(container: InputContainer, stream: VideoStream) -> Iterator[Packet[VideoStream]]:
    """Packets that hold something, to where the file ends or cannot be read on."""
    with suppress(InvalidDataError, EndError):
        for packet in container.demux(stream):
            if packet.size:
                yield packet


def decoded(
    packets: Iterator[Packet[VideoStream]], stream: VideoStream, number: int
) -> Iterator[tuple[int, VideoFrame | None]]:
    """Images as they are shown, each with the number of its packet, the first of which is given.

    Where a packet cannot be decoded, None comes with the number of the one that was tried.
    """
    for packet in packets:
        packet.pts = number
        try:
            for frame in packet.decode():
                yield -1 if frame.pts is None else frame.pts, frame
        except FFmpegError:
            yield number, None
        number += 1
    with suppress(FFmpegError):
        for frame in stream.decode(None):
            yield -1 if frame.pts is None else frame.pts, frame


@lru_cache(maxsize=4)
def scan(path: Path, changed_ns: int, size: int) -> ShownImages:
    """The images by the packets' stamps, or by decoding where those do not tell the order.

    Args:
        path: of the file.
        changed_ns: when the file was changed, as one that was is read anew.
        size: of the file, likewise.

    Raises:
        RecordingError: not a video, nothing in it, too many or too large images, or stamps too
            far apart.
    """
    cut = ""
    try:
        cut = said_of_cut(path)
        container, stream = open_stream(path)
        with container:
            context, base = stream.codec_context, stream.time_base
            width, height = context.width, context.height
            stored, hidden = _read_packets(path, container, stream)
            stated = stream.frames if "mov" in container.format.name else 0
            reordered = bool(context.has_b_frames)
    except (FFmpegError, OSError) as fault:
        reason = cut or f"cannot be read as a video: {getattr(fault, 'strerror', None) or fault}"
        raise refusal(path, reason, advice="is the copy complete?") from fault
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS) or base is None:
        raise refusal(path, f"expected at most {MAX_PIXELS} pixels, got {width} x {height}")
    if len(stored) < stated and not cut and _unedited(path) < stated:
        cut = f"the video is truncated: expected {stated} images, got {len(stored)}"
    shown = [number for number in range(len(stored)) if number not in hidden]
    if not shown:
        raise refusal(path, cut or "expected images, got none", advice="copy the file again")
    notes: tuple[str, ...] = (f"{cut}: what is there is read",) if cut else ()
    held = max(len(stored), stated)
    if 2 * len(shown) < held and not cut:
        notes += (
            f"its edit list, or a damaged time scale, hides {held - len(shown)} of {held} "
            "images, which are left out",
        )
    stamps = [stored[number][0] for number in shown]
    known = [one for one in stamps if one is not None]
    in_order = all(one < after for one, after in pairwise(known))
    if len(set(known)) < len(shown) or (in_order and reordered and len(shown) > 1):
        nothing = np.empty(0, np.int64)
        images = ShownImages(
            stored, hidden, nothing, nothing, nothing, (width, height), notes=notes
        )
        return look_through(path, images)
    packets = np.array(shown, np.int64)[np.argsort(np.array(known, np.int64), kind="stable")]
    time_ns = _nanoseconds(path, sorted(known), base)
    if len(time_ns) > 1 and float(np.median(np.diff(time_ns))) < _LEAST_STEP_NS:
        step_ns = float(np.median(np.diff(time_ns)))
        raise refusal(path, f"expected images 10 us or more apart, got {step_ns:g} ns")
    if np.any(np.diff(time_ns) <= 0):
        raise refusal(path, "expected stamps a nanosecond apart, got finer ones")
    places = np.flatnonzero([stored[number][3] for number in packets])
    return ShownImages(stored, hidden, packets, time_ns, places, (width, height), notes=notes)


def _read_packets(
    path: Path, container: InputContainer, stream: VideoStream
) -> tuple[list[Stored], frozenset[int]]:
    """What is stored of all packets, and the numbers of those that are hidden."""
    stored: list[Stored] = []
    hidden: list[int] = []
    hiding = stream.codec_context.name in ("vp8", "libvpx")
    for number, packet in enumerate(stored_packets(container, stream)):
        if number >= FRAME_LIMIT:
            raise refusal(path, f"expected at most {FRAME_LIMIT} images, got more")
        stored.append((packet.pts, packet.dts, packet.size, packet.is_keyframe))
        if packet.is_discard or (hiding and not memoryview(packet)[0] & _HIDDEN):
            hidden.append(number)
    return stored, frozenset(hidden)


def _unedited(path: Path) -> int:
    """How many images a file holds, those that its edit list cuts away included."""
    with refused(), open_video(path, edited=False) as container:
        return sum(1 for _ in stored_packets(container, container.streams.video[0]))


@lru_cache(maxsize=4)
def look_through(path: Path, before: ShownImages) -> ShownImages:
    """Decode all: which images are shown, in which order and when, and which are damaged.

    Raises:
        RecordingError: nothing in it can be decoded, or stamps too far apart.
    """
    images = _decode_all(path, before, before.threads)
    if images.threads != before.threads:
        images = _decode_all(path, before, images.threads)
    return images


def _decode_all(path: Path, before: ShownImages, threads: ThreadType) -> ShownImages:
    packets: list[int] = []
    dts: list[int | None] = []
    keys: list[int] = []
    damaged: set[int] = set()
    torn: set[int] = set()
    container, stream = open_stream(path)
    with container:
        stream.thread_type = threads
        base, rate = stream.time_base, stream.guessed_rate or stream.average_rate
        read = track(stored_packets(container, stream), "looking for damage", len(before.stored))
        for number, frame in decoded(_noting_torn(read, torn), stream, 0):
            if frame is None or not 0 <= number < len(before.stored):
                continue
            if frame.key_frame:
                keys.append(len(packets))
            bad = frame.is_corrupt or number in torn
            if bad or (frame.width, frame.height) != before.size:
                damaged.add(len(packets))
            packets.append(number)
            dts.append(frame.dts)
    if not packets or base is None:
        raise refusal(
            path,
            "none of its images can be decoded",
            field="frame 0",
            advice="copy the file again",
        )
    # An edit list may hide the keyframe that the first ones refer to.
    if keys and not any(before.stored[number][3] for number in before.hidden):
        damaged.update(range(keys[0]))
    stored = [before.stored[number][0] for number in packets]
    best = _best_stamps(stored, dts)
    step_ns = round(10**9 / (rate or _ASSUMED_HZ))
    known = {at: one for at, one in enumerate(best) if one is not None}
    in_ns = _nanoseconds(path, list(known.values()), base).tolist()
    time_ns, counted = _increasing(dict(zip(known, in_ns, strict=True)), len(best), step_ns)
    counted = max(counted, sum(one != was for one, was in zip(best, stored, strict=True)))
    notes = before.notes
    if counted:
        notes += (
            f"{counted} of {len(best)} images have no stamp, or one that is out of the "
            f"order in which they are shown: theirs are counted in that order, as FFmpeg does, at "
            f"{1e9 / step_ns:.4g} a second where nothing else tells",
        )
    missing = set(range(len(before.stored))).difference(before.hidden, packets)
    faults = sorted(missing.union(packets[place] for place in damaged))
    return ShownImages(
        before.stored,
        before.hidden,
        np.array(packets, np.int64),
        np.array(time_ns, np.int64),
        np.array(_clean_keys(keys, packets, faults), np.int64),
        before.size,
        frozenset(damaged),
        len(missing),
        notes,
        looked=True,
    )


def _noting_torn(
    packets: Iterable[Packet[VideoStream]], torn: set[int]
) -> Iterator[Packet[VideoStream]]:
    """Packets, with the numbers of those that the container knows to be incomplete added."""
    for number, packet in enumerate(packets):
        if packet.is_corrupt:
            torn.add(number)
        yield packet


def _clean_keys(keys: list[int], packets: list[int], faults: list[int]) -> list[int]:
    """Keyframes without a fault before the next: what is concealed depends on what came before."""
    ends = [*(packets[key] for key in keys), 1 + max(packets)][1:]  # of no key where all is hidden
    return [
        key
        for key, end in zip(keys, ends, strict=True)
        if bisect_left(faults, packets[key]) == bisect_left(faults, end)
    ]


def _nanoseconds(path: Path, stamps: Sequence[int], base: Fraction) -> IntArray:
    """Stamps in ns: exact in Python's integers; a float would lose nanoseconds after weeks."""
    exact = [round(one * base * 10**9) for one in stamps]
    if any(abs(one) >= 2**62 for one in exact):
        raise refusal(path, "expected stamps within 146 years, got larger ones")
    return np.array(exact, dtype=np.int64)


def _best_stamps(pts: Sequence[int | None], dts: Sequence[int | None]) -> list[int | None]:
    """Of each image, pts or dts: what has increased more often up to it.

    Source: FFmpeg, libavcodec/decode.c, `guess_correct_pts` (its `best_effort_timestamp`).
    """
    chosen: list[int | None] = []
    last: list[int | None] = [None, None]
    faults = [0, 0]
    for pair in zip(pts, dts, strict=True):
        for kind in (0, 1):
            stamp, before = pair[kind], last[kind]
            faults[kind] += stamp is not None and before is not None and stamp <= before
            last[kind] = pair[1 - kind] if stamp is None else stamp
        own = pair[0] is not None and (pair[1] is None or faults[0] <= faults[1])
        chosen.append(pair[0] if own else pair[1])
    return chosen


def _increasing(stated: dict[int, int], count: int, step_ns: int) -> tuple[list[int], int]:
    """Stamps of all images, and how many were counted: the most that increase are kept.

    Those between two that are kept are spread evenly, those before and after all are `step_ns`
    apart.
    """
    apart_ns = min(_LEAST_APART_NS, step_ns)
    ends: list[int] = []  # the least last stamp of a chain of each length, less what is between
    tails: list[int] = []
    before: dict[int, int] = {}
    for at, stamp in stated.items():
        spare = stamp - apart_ns * at
        length = bisect_right(ends, spare)
        ends[length : length + 1], tails[length : length + 1] = [spare], [at]
        before[at] = tails[length - 1] if length else -1
    at, kept = tails[-1] if tails else -1, []
    while at >= 0:
        kept.append(at)
        at = before[at]
    kept.reverse()
    first = kept[0] if kept else 0
    origin = stated[first] if kept else 0
    times = [origin + (place - first) * step_ns for place in range(count)]
    for place, after in pairwise(kept):
        span, start = stated[after] - stated[place], stated[place]
        for between in range(place, after):
            times[between] = start + span * (between - place) // (after - place)
    for place in range(kept[-1] if kept else count, count):
        times[place] = stated[kept[-1]] + (place - kept[-1]) * step_ns
    return times, count - len(kept)


_EBML, _SEGMENT = b"\x1a\x45\xdf\xa3", b"\x18\x53\x80\x67"


def said_of_cut(path: Path) -> str:
    """What is said of a file that ends before its outermost boxes do; empty of a whole one.

    Raises:
        OSError: it cannot be read.
    """
    end = path.stat().st_size
    with open_bounded(path, MAX_FILE_BYTES) as file:
        start = file.read(12)
        file.seek(0)
        if start[4:8] == b"ftyp":
            return _cut_box(file, end)
        if start[:4] == _EBML:
            return _cut_segment(file, end)
        if start[:4] == b"RIFF" and start[8:12] == b"AVI ":
            size = int.from_bytes(start[4:8], "little")
            if size + 8 > end:  # 0 where recording was never ended, which tells nothing
                return _cut("RIFF", size, 0)
    return ""


def _cut_box(file: BinaryIO, end: int) -> str:
    """Walk the outermost boxes of an MP4 or MOV file."""
    at = 0
    while at + 8 <= end:
        file.seek(at)
        header = file.read(16)
        size = int.from_bytes(header[:4], "big")
        if size == 1:
            size = int.from_bytes(header[8:], "big")
        elif size == 0:
            break
        if size < 8 or at + size > end:
            return _cut(one_line(header[4:8]), size, at)
        at += size
    return ""


def _cut_segment(file: BinaryIO, end: int) -> str:
    """Look at the length of a Matroska file's segment, which holds all of it but the header."""
    file.seek(len(_EBML))
    header = _length(file)
    if header is None:
        return ""
    at = file.tell() + header
    file.seek(at)
    if file.read(len(_SEGMENT)) != _SEGMENT:
        return ""
    size = _length(file)
    if size is not None and file.tell() + size > end:
        return _cut("Segment", size, at)
    return ""


def _length(file: BinaryIO) -> int | None:
    """An EBML length: the first byte's leading zeros say how long it is; None where not told."""
    first = file.read(1)
    if not first or not first[0]:
        return None
    more = 8 - first[0].bit_length()
    bits = 7 * (more + 1)
    size = int.from_bytes(first + file.read(more), "big") & ((1 << bits) - 1)
    return None if size == (1 << bits) - 1 else size


def _cut(box: str, size: int, at: int) -> str:
    return f"the video is truncated: its box {box} of {size} bytes at {at} is not whole"
