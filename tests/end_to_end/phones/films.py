"""What a film keeps of the clip it was made from: upright images, their times, colours, sound.

All is read with PyAV from both files; nothing of this library has a part in it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["Video", "faults_of_film", "read_video"]

_NEAR_S = 1e-4
_PACKET_S = 0.02
_ALIKE = 0.5
_SMALL = (96, 96)


@dataclass(frozen=True, eq=False)
class Video:
    """A video as a player shows it.

    Fields:
        size: width and height, upright.
        turned: whether a player turns the stored images.
        time_s: of its frames; the first is at 0.
        coding: colour matrix, primaries, transfer and levels, by their numbers.
        codec: of the images, and its pixels' form.
        first: a small grey image of the first frame, upright.
        sound: by track its codec, and digest and time (from the first frame) of each packet
            (of samples as they are: of all).
    """

    size: tuple[int, int]
    turned: bool
    time_s: NDArray[np.float64]
    coding: tuple[int, ...]
    codec: tuple[str, str]
    first: NDArray[np.uint8]
    sound: tuple[tuple[str, tuple[tuple[str, float], ...]], ...]


def read_video(path: Path) -> Video:
    """Read all of it but the images after the first."""
    with av.open(str(path)) as file:
        stream = file.streams.video[0]
        frame = next(file.decode(stream))
        context: Any = stream.codec_context
        upright = np.rot90(frame.to_ndarray(format="gray"), round(frame.rotation / 90.0))
        coding = context.colorspace, context.color_primaries, context.color_trc
        levels = 2 if str(context.pix_fmt).startswith("yuvj") else int(context.color_range)
        codec = str(context.name), str(context.pix_fmt).replace("yuvj", "yuv")
        turned = bool(frame.rotation)
    with av.open(str(path)) as file:
        packets = [one for one in file.demux() if one.size and one.pts is not None]
        packets = [one for one in packets if not one.is_discard]  # which an edit list hides
        base: Fraction = file.streams.video[0].time_base or Fraction(1)
        shown = sorted(one.pts for one in packets if one.stream.type == "video")
        start = shown[0] * base
        tracks = {one.index: (one.codec_context.name, []) for one in file.streams.audio}
        for one in packets:
            if one.stream.index in tracks:
                late = float(one.pts * one.time_base - start)
                tracks[one.stream.index][1].append((bytes(one), late))
    return Video(
        (upright.shape[1], upright.shape[0]),
        turned,
        np.array([float(one * base - start) for one in shown]),
        (*map(int, coding), levels),
        codec,
        np.asarray(cv2.resize(upright, _SMALL, interpolation=cv2.INTER_AREA), np.uint8),
        tuple((name, _digests(name, heard)) for name, heard in tracks.values()),
    )


def _digests(name: str, heard: list[tuple[bytes, float]]) -> tuple[tuple[str, float], ...]:
    """Digest and time of each packet; of plain samples, which have no packets, of all at once.

    AAC of a stream has a header a packet (ADTS, ISO 14496-3), which files leave out.
    """
    if name.startswith("pcm_") and heard:
        heard = [(b"".join(data for data, _ in heard), heard[0][1])]
    if name == "aac":
        heard = [(data[7:] if data[:1] == b"\xff" else data, late) for data, late in heard]
    return tuple((hashlib.sha256(data).hexdigest(), late) for data, late in heard)


def faults_of_film(clip: Video, film: Video) -> list[str]:
    """What a film has not kept, in a few words each; empty where it kept all."""
    faults = []
    even = (clip.size[0] + clip.size[0] % 2, clip.size[1] + clip.size[1] % 2)  # as H.264 needs
    if film.size != even or film.turned:
        faults.append(
            f"size {film.size}{' turned' if film.turned else ''}, of the clip {clip.size}"
        )
    else:
        # A figure may hide much of it, so it is the other ways up that it is held against.
        ways = [np.rot90(one, k) for one in (clip.first, clip.first[:, ::-1]) for k in range(4)]
        alike = [float(np.corrcoef(one.ravel(), film.first.ravel())[0, 1]) for one in ways]
        if not alike[0] >= max(_ALIKE, *alike):
            faults.append(f"its first image is unlike the clip's upright one: {alike[0]:.2f}")
    if len(film.time_s) != len(clip.time_s):
        faults.append(f"{len(film.time_s)} frames of {len(clip.time_s)}")
    elif np.abs(film.time_s - clip.time_s).max() > _NEAR_S:
        faults.append(f"frame times off by {np.abs(film.time_s - clip.time_s).max():.4f} s")
    if film.coding != clip.coding:
        faults.append(f"colours {film.coding}, of the clip {clip.coding}")
    if film.codec != ("h264", "yuv420p"):
        faults.append(f"coded as {film.codec}")
    return faults + _faults_of_sound(clip, film)


def _while_shown(video: Video) -> list[list[tuple[str, float]]]:
    """Sound by track, without what ends before the first image."""
    tracks = [track for _, track in video.sound]
    return [[one for one in track if one[1] > -_PACKET_S] for track in tracks]


def _faults_of_sound(clip: Video, film: Video) -> list[str]:
    if [name for name, _ in clip.sound] != [name for name, _ in film.sound]:
        return [f"{len(film.sound)} tracks of sound of {len(clip.sound)}"]
    faults = []
    for told, heard in zip(_while_shown(clip), _while_shown(film), strict=True):
        if [one for one, _ in told] != [one for one, _ in heard]:
            faults.append(f"sound: packets differ ({len(heard)} of {len(told)})")
        elif (
            max((abs(a - b) for (_, a), (_, b) in zip(told, heard, strict=True)), default=0) > 1e-3
        ):
            faults.append("sound: out of step with the images")
    return faults
