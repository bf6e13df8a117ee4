"""Small video files of every coding, container and fault, each with the images that went in.

Images show a texture that moves, and their number as a row of black and white blocks that coding
keeps: so an image that comes out is known for what it is, whatever its stamp says.
"""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

__all__ = ["CASES", "COUNT", "Case", "number_of", "numbered_image", "write_case"]

COUNT, GROUP, RATE = 24, 8, 25
_BLOCK, _BITS = 12, 5
_CLOCK = Fraction(1, 1000)
Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Coding:
    """A codec and the containers that hold it.

    Fields:
        codec, pixels, options: of the encoder.
        suffixes: containers.
        even: whether only even sizes are coded.
        intra: whether every image is a keyframe.
    """

    codec: str
    suffixes: tuple[str, ...]
    pixels: str = "yuv420p"
    options: dict[str, str] = field(default_factory=dict)
    even: bool = True
    intra: bool = False


_X264 = {"crf": "12", "preset": "veryfast"}
CODINGS = {
    "h264": Coding("libx264", (".mp4", ".mkv", ".avi"), options=_X264 | {"bf": "0"}),
    "h264_b": Coding(
        "libx264", (".mp4", ".mkv", ".avi", ".ts", ".mov"), options=_X264 | {"bf": "2"}
    ),
    "mpeg4": Coding("mpeg4", (".mp4", ".avi", ".mkv"), options={"b": "4000000"}),
    "mpeg4_b": Coding("mpeg4", (".mp4", ".avi"), options={"b": "4000000", "bf": "2"}),
    "mpeg2": Coding("mpeg2video", (".ts", ".mpg"), options={"b": "4000000", "bf": "2"}),
    "mjpeg": Coding(
        "mjpeg", (".avi", ".mov", ".mkv"), "yuvj420p", {"b": "4000000"}, even=False, intra=True
    ),
    "vp8": Coding(
        "libvpx",
        (".webm",),
        options={"crf": "8", "b": "2M", "lag-in-frames": "16", "auto-alt-ref": "1"},
        even=False,
    ),
    "vp9": Coding(
        "libvpx-vp9", (".webm", ".mp4"), options={"crf": "15", "cpu-used": "8"}, even=False
    ),
    "hevc": Coding(
        "libx265",
        (".mp4", ".mkv", ".ts"),
        options={"crf": "14", "preset": "ultrafast", "x265-params": "log-level=none:bframes=2"},
    ),
    "av1": Coding("libsvtav1", (".mp4",), options={"crf": "20", "preset": "12"}),
    "ffv1": Coding(
        "ffv1", (".mkv", ".avi"), options={"level": "3", "slicecrc": "1"}, even=False, intra=True
    ),
}
FAULTS = ("none", "cut", "broken_image", "flipped_bytes", "no_first_key")


@dataclass(frozen=True)
class Case:
    """A file to be written.

    Fields:
        coding: of `CODINGS`.
        suffix: container.
        fault: of `FAULTS`, or one of the others that `write_case` knows.
    """

    coding: str
    suffix: str
    fault: str = "none"

    @property
    def name(self) -> str:
        """For files and tests."""
        return f"{self.coding}_{self.fault}{self.suffix}"


CASES = (
    *(
        Case(name, suffix, fault)
        for name, coding in CODINGS.items()
        for suffix in coding.suffixes
        for fault in FAULTS
        if name != "av1" or fault in ("none", "flipped_bytes")
    ),
    *(
        Case(name, suffix, fault)
        for name, suffix in (("h264_b", ".mp4"), ("h264", ".mkv"), ("hevc", ".mp4"))
        for fault in ("uneven_stamps", "repeated_stamps", "stored_order", "one_image")
        if (name, fault) != ("hevc", "one_image")  # the encoder hands out no single image
    ),
    *(Case(name, ".mp4", "edit_list") for name in ("h264_b", "mpeg4", "hevc")),
    *(Case("h264_b", suffix, "turned") for suffix in (".mp4", ".mov")),
    *(
        Case(name, CODINGS[name].suffixes[0], "odd_size")
        for name in ("mjpeg", "vp8", "vp9", "ffv1")
    ),
    *(Case("mjpeg", ".avi", fault) for fault in ("one_image",)),
)


def numbered_image(number: int, size: tuple[int, int]) -> Image:
    """The image of a number, RGB ``(h, w, 3)``."""
    width, height = size
    y, x = np.mgrid[:height, :width]
    wave = 120 + 60 * np.sin((x + 2 * number) / 9.0) * np.cos((y - number) / 11.0)
    image = np.stack([wave, 200 - 0.6 * wave, 60 + 0.6 * wave], axis=-1).astype(np.uint8)
    for bit in range(_BITS):
        image[:_BLOCK, bit * _BLOCK : (bit + 1) * _BLOCK] = 225 if number >> bit & 1 else 30
    return image


def number_of(image: Image) -> int:
    """The number that an image shows."""
    inner = slice(3, _BLOCK - 3)
    blocks = (image[inner, bit * _BLOCK + 3 : (bit + 1) * _BLOCK - 3] for bit in range(_BITS))
    return sum(int(block.mean() > 128) << bit for bit, block in enumerate(blocks))


def write_case(folder: Path, case: Case, seed: int = 7) -> Path:
    """Write the file of a case; the seed draws where damage lies."""
    rng = np.random.default_rng(seed)
    path = folder / case.name
    packets, plain = _encoded(case)
    if case.fault == "no_first_key":
        packets = packets[1:]
    if case.fault == "broken_image":
        hit = packets[COUNT // 2]
        hit[0][len(hit[0]) // 3 : len(hit[0]) // 2] = rng.bytes(len(hit[0]) // 2 - len(hit[0]) // 3)
    if case.fault == "stored_order":
        packets = [(data, dts, dts, key) for data, _, dts, key in packets]
    if case.fault == "repeated_stamps":
        packets = [(data, pts - pts % 80, dts - 100, key) for data, pts, dts, key in packets]
    if case.coding == "av1":  # PyAV muxes only what it can encode by its decoder's name
        path.write_bytes(plain)
    else:
        _mux(path, packets, plain, case)
    if case.fault == "cut":
        whole = path.read_bytes()
        path.write_bytes(whole[: 2 * len(whole) // 3])
    if case.fault == "flipped_bytes":
        whole = np.frombuffer(path.read_bytes(), np.uint8).copy()
        first, last = len(whole) // 4, 3 * len(whole) // 4
        hit = rng.integers(first, last, 6)
        whole[hit] ^= rng.integers(1, 256, 6).astype(np.uint8)
        path.write_bytes(whole.tobytes())
    return path


def _encoded(case: Case) -> tuple[list[Any], bytes]:
    """Packets as bytes, pts, dts in ms and whether a keyframe; and a file of that coding."""
    coding = CODINGS[case.coding]
    size = (97, 65) if case.fault == "odd_size" else (96, 64)
    count = 1 if case.fault == "one_image" else COUNT
    plain = io.BytesIO()
    options = {**coding.options, "g": str(GROUP)}
    own = {"libvpx": "webm", "ffv1": "matroska", "mjpeg": "mov", "mpeg2video": "mpegts"}
    between = own.get(coding.codec, "mpegts" if case.suffix in (".avi", ".ts") else "mp4")
    if coding.codec == "mpeg4":
        between = "mp4"
    with av.open(plain, "w", format=between) as file:
        stream: Any = file.add_stream(coding.codec, rate=RATE, options=options)
        stream.width, stream.height, stream.pix_fmt = *size, coding.pixels
        if coding.codec == "mjpeg":
            stream.codec_context.color_range = 2
        for number in range(count):
            frame = av.VideoFrame.from_ndarray(numbered_image(number, size), format="rgb24")
            frame.pts, frame.time_base = number, Fraction(1, RATE)
            file.mux(stream.encode(frame))
        file.mux(stream.encode(None))
    packets = []
    with av.open(io.BytesIO(plain.getvalue())) as file:
        for one in file.demux(video=0):
            if one.size == 0:
                continue
            pts, dts = (round(1000 * at * one.time_base) for at in (one.pts, one.dts))
            if case.fault == "uneven_stamps":
                pts, dts = (at + at * at // 1000 * (at > 0) for at in (pts, dts))
            if case.fault == "edit_list":
                pts, dts = pts - 200, dts - 200
            packets.append((bytearray(bytes(one)), pts, dts, one.is_keyframe))
    return packets, plain.getvalue()


def _mux(path: Path, packets: list[Any], plain: bytes, case: Case) -> None:
    options = {"movflags": "faststart"} if case.fault == "cut" else {}
    with av.open(io.BytesIO(plain)) as template, av.open(str(path), "w", options=options) as file:
        stream = file.add_stream_from_template(template.streams.video[0])
        if case.fault == "turned":
            stream.set_display_matrix([0, 1 << 16, 0, -(1 << 16), 0, 0, 0, 0, 1 << 30])
        for data, pts, dts, key in packets:
            packet = av.Packet(bytes(data))
            packet.stream, packet.time_base = stream, _CLOCK
            packet.pts, packet.dts, packet.is_keyframe = pts, dts, key
            file.mux(packet)
