"""The video that a film is made from: what the film keeps of it besides the images.

Frame times are on the original's clock, colours are coded as there, and sound is copied packet by
packet, in step with the images.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from av.container import InputContainer

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
