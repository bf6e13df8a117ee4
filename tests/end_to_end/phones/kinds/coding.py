"""Writes images and sound into a file of any container, codec, turn, colours and frame times."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray

__all__ = ["Coded", "Image", "encode", "upright_images"]

Image = NDArray[np.uint8]
"""Upright RGB ``(h, w, 3)``."""
_CLOCK = Fraction(1, 90_000)
_CONVERTED = {2: 5, 6: 5}
"""Matrices by their number in ITU-T H.273, as what FFmpeg converts colours with them."""


@dataclass(frozen=True)
class Coded:
    """How a file is written.

    Fields:
        suffix: of the file, which tells the container.
        codec, pixels, options: of the images, no codec where nothing is encoded.
        tag: four letters by which a container names the codec.
        turned_deg: by how much a player turns the stored images, clockwise.
        colours: matrix, primaries, transfer (ITU-T H.273) and levels (1 limited, 2 full).
        pixel_aspect: width of a pixel over its height.
        sound: codec, "" for none; sound_hz: its rate.
        skipped: images before the start that an edit list hides.
        muxing: options of the container.
    """

    suffix: str = ".mp4"
    codec: str = "libx264"
    pixels: str = "yuv420p"
    options: dict[str, str] = field(default_factory=lambda: {"crf": "19", "preset": "veryfast"})
    tag: str = ""
    turned_deg: int = 0
    colours: tuple[int, int, int, int] = (1, 1, 1, 1)
    pixel_aspect: Fraction = Fraction(1)
    sound: str = "aac"
    sound_hz: int = 48_000
    skipped: int = 0
    muxing: dict[str, str] = field(default_factory=dict)


def upright_images(path: Path) -> Iterable[Image]:
    """The images of a clip as a player shows them."""
    with av.open(str(path)) as file:
        file.streams.video[0].thread_type = "AUTO"
        for frame in file.decode(video=0):
            image = frame.to_ndarray(format="rgb24")
            yield np.ascontiguousarray(np.rot90(image, round(frame.rotation / 90.0)))


def encode(path: Path, images: Iterable[Image], time_s: FloatArray, coded: Coded) -> None:
    """Write a file; times ``(N,)`` of its frames are from its start, those skipped below 0."""
    if not coded.codec:
        return
    with av.open(str(path), "w", options=coded.muxing) as file:
        stream: Any = file.add_stream(coded.codec, rate=30, options=coded.options)
        stream.pix_fmt = coded.pixels
        context = stream.codec_context
        if coded.codec != "gif":
            context.time_base = _CLOCK
        context.colorspace, context.color_primaries, context.color_trc = coded.colours[:3]
        context.color_range = coded.colours[3]
        if coded.tag:
            context.codec_tag = coded.tag
        if coded.pixel_aspect != 1:
            context.sample_aspect_ratio = coded.pixel_aspect
        if coded.turned_deg:
            stream.set_display_matrix(_matrix(coded.turned_deg))
        sound = _sound_stream(file, coded)
        form = VideoReformatter()
        for number, image in enumerate(images):
            stored = np.ascontiguousarray(np.rot90(image, coded.turned_deg // 90))
            if number == 0:
                stream.height, stream.width = stored.shape[:2]
            frame = _converted(stored, form, coded)
            frame.pts, frame.time_base = round(time_s[number] / _CLOCK), _CLOCK
            file.mux(stream.encode(frame))
        file.mux(stream.encode(None))
        if sound is not None:
            _add_tone(file, sound, float(time_s[0]), float(time_s[-1]), coded)


def _converted(stored: Image, form: VideoReformatter, coded: Coded) -> Any:
    rgb = av.VideoFrame.from_ndarray(stored, format="rgb24")
    if coded.codec == "gif":
        return rgb.reformat(format=coded.pixels)
    matrix = _CONVERTED.get(coded.colours[0], coded.colours[0])
    return form.reformat(
        rgb, format=coded.pixels, dst_colorspace=matrix, dst_color_range=coded.colours[3]
    )


def _matrix(turned_deg: int) -> list[int]:
    """The display matrix that turns clockwise (FFmpeg, libavutil/display.h)."""
    one = 1 << 16
    cosine = {90: 0, 180: -one, 270: 0}[turned_deg]
    sine = {90: one, 180: 0, 270: -one}[turned_deg]
    return [cosine, sine, 0, -sine, cosine, 0, 0, 0, 1 << 30]


def _sound_stream(file: Any, coded: Coded) -> Any:
    if not coded.sound:
        return None
    return file.add_stream(coded.sound, rate=coded.sound_hz, layout="mono")


def _add_tone(file: Any, sound: Any, start_s: float, end_s: float, coded: Coded) -> None:
    """A rising tone, so that a shift would be heard."""
    rate = coded.sound_hz
    at = np.arange(int((end_s - start_s) * rate)) / rate
    wave = 0.3 * np.sin(2.0 * np.pi * (220.0 + 60.0 * at) * at)
    size = 960 if rate == 48_000 else 160
    shape = av.AudioResampler(sound.codec_context.format.name, "mono", rate)
    for number in range(len(at) // size):
        part = np.asarray(wave[None, number * size : (number + 1) * size], np.float32)
        heard = av.AudioFrame.from_ndarray(part, format="flt", layout="mono")
        heard.sample_rate, heard.pts = rate, number * size + round(start_s * rate)
        heard.time_base = Fraction(1, rate)
        for one in shape.resample(heard):
            file.mux(sound.encode(one))
    file.mux(sound.encode(None))
