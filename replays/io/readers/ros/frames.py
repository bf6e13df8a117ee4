"""Images of a topic of a ROS 1 or ROS 2 bag as a frame sequence, with depth beside them.

Encodings are those of `sensor_msgs/image_encodings.h`: grey, colour, Bayer mosaics and YUV 4:2:2,
of 8 bits, or of 16, of which the eight highest that the topic uses are kept. Depth (REP 118) is
16UC1 in millimetres or 32FC1 in metres, raw or as `compressed_depth_image_transport` packs it.

Stamps are those of the headers, in whose order images are read; one that came twice at once
counts once. Where images share a header stamp otherwise (drivers that leave it zero, or stamp in
batches), no header of the topic is taken, but the times at which the bag received the messages.
"""

from __future__ import annotations

import hashlib
import logging
import struct
import threading
import weakref
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import open_bounded, refusal
from motorcade.replays.io.readers.frames.images import FRAME_LIMIT, FRAME_PIXELS, image_size
from motorcade.replays.io.readers.ros.admission import FILE_LIMIT
from motorcade.replays.io.readers.ros.reader import Bag
from motorcade.replays.io.recording import DecodedFrames, DepthArray, Frame, ImageArray
from motorcade.tracking.cameras.camera import AS_STORED

if TYPE_CHECKING:
    from motorcade.tracking.cameras.camera import Camera

_LOG = logging.getLogger("motorcade.replays")
_RAW, _COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
IMAGE_TYPES = (_RAW, _COMPRESSED)


class _Pixels(NamedTuple):
    """A pixel's type of number, how many it has, and OpenCV's code to RGB; None: it is that."""

    number: str
    channels: int
    to_rgb: int | None = None


_MOSAICS = {
    "rggb": cv2.COLOR_BayerRGGB2RGB,
    "bggr": cv2.COLOR_BayerBGGR2RGB,
    "gbrg": cv2.COLOR_BayerGBRG2RGB,
    "grbg": cv2.COLOR_BayerGRBG2RGB,
}
ENCODINGS: dict[str, _Pixels] = {
    **dict.fromkeys(("mono8", "8UC1"), _Pixels("u1", 1)),
    "mono16": _Pixels("u2", 1),
    "rgb8": _Pixels("u1", 3),
    "rgb16": _Pixels("u2", 3),
    **dict.fromkeys(("bgr8", "8UC3"), _Pixels("u1", 3, cv2.COLOR_BGR2RGB)),
    "bgr16": _Pixels("u2", 3, cv2.COLOR_BGR2RGB),
    "rgba8": _Pixels("u1", 4, cv2.COLOR_RGBA2RGB),
    **dict.fromkeys(("bgra8", "8UC4"), _Pixels("u1", 4, cv2.COLOR_BGRA2RGB)),
    **dict.fromkeys(("yuv422", "uyvy"), _Pixels("u1", 2, cv2.COLOR_YUV2RGB_UYVY)),
    **dict.fromkeys(("yuv422_yuy2", "yuyv"), _Pixels("u1", 2, cv2.COLOR_YUV2RGB_YUY2)),
    **{f"bayer_{name}8": _Pixels("u1", 1, code) for name, code in _MOSAICS.items()},
    **{f"bayer_{name}16": _Pixels("u2", 1, code) for name, code in _MOSAICS.items()},
}
DEPTH_ENCODINGS = {"16UC1": ("u2", 1e-3), "32FC1": ("f4", 1.0)}
"""Type of a number, and how many metres one is."""
_DEPTH_HEADER = struct.Struct("<Iff")
_DEPTH_WORDS = ("depth", "disparity")


@dataclass(frozen=True)
class ImageTopic:
    """What an image topic holds, by its first message.

    Fields:
        kind: "colour", "grey", "depth", or "lossy depth", whose values a JPEG has changed.
        frame_id: of the camera's axes.
        size: width and height of a raw image; None of a compressed one.
    """

    name: str
    kind: str
    frame_id: str
    size: tuple[int, int] | None

    @classmethod
    def of(cls, name: str, message: Any) -> ImageTopic:
        """By the topic's name and a message."""
        size, frame_id = None, str(message.header.frame_id).removeprefix("/")
        if hasattr(message, "encoding"):
            encoding, size = str(message.encoding), (int(message.width), int(message.height))
            lossy = False
        else:
            encoding, _, packing = str(message.format).partition(";")
            lossy = "jp" in packing or bytes(message.data[:2]) == b"\xff\xd8"
            if "compressedDepth" in packing:
                return cls(name, "depth", frame_id, size)
        if encoding in DEPTH_ENCODINGS:
            return cls(name, "lossy depth" if lossy else "depth", frame_id, size)
        named = any(word in part for part in name.split("/") for word in _DEPTH_WORDS)
        grey = encoding.startswith(("mono", "8UC1")) or (lossy and _is_grey(message))
        if grey and lossy and named:
            return cls(name, "lossy depth", frame_id, size)
        return cls(name, "grey" if grey else "colour", frame_id, size)


def _is_grey(message: Any) -> bool:
    """Whether a compressed image has one channel; what cannot be read has none."""
    try:
        image_size(bytes(message.data))
        stored = cv2.imdecode(np.asarray(message.data, np.uint8), cv2.IMREAD_UNCHANGED)
    except (ValueError, cv2.error):
        return False
    return stored is not None and stored.ndim == 2


class Stamps(NamedTuple):
    """Stamps of a topic's messages.

    Fields:
        time_ns: ``(N,)``, strictly increasing.
        rows: ``(N,)`` which of the messages, as they were recorded, each belongs to.
        by_receipt: whether they are the bag's times of receipt rather than the headers'.
        latency_ns: the median of receipt minus header.
        said: what a user is told; empty where headers are as they should be.
    """

    time_ns: IntArray
    rows: IntArray
    by_receipt: bool
    latency_ns: int
    said: str


def choose_stamps(recorded_ns: IntArray, header_ns: IntArray, digests: IntArray) -> Stamps | None:
    """Stamps of messages by the rule of this module.

    Args:
        recorded_ns: ``(N,)`` times of receipt, in the order of the bag.
        header_ns: ``(N,)`` stamps of the headers.
        digests: ``(N,)`` of what the messages hold, to tell a repeat from another.

    Returns:
        None where neither tells all of them apart.
    """
    rows = np.argsort(header_ns, kind="stable")
    equal = (np.diff(header_ns[rows]) == 0) & (np.diff(digests[rows]) == 0)
    at_once = 0.5 * float(np.median(np.diff(recorded_ns))) if len(rows) > 1 else 0.0
    repeated = np.concatenate([[False], equal & (np.diff(recorded_ns[rows]) < at_once)])
    rows, said = rows[~repeated], list[str]()
    if repeated.any():
        said.append(f"{np.count_nonzero(repeated)} came twice, and count once")
    latency_ns = int(np.median(recorded_ns - header_ns)) if len(header_ns) else 0
    shared = int(np.count_nonzero(np.diff(header_ns[rows]) == 0))
    if shared:
        rows = np.sort(rows)
        if np.any(np.diff(recorded_ns[rows]) <= 0):
            return None
        said.append(
            f"{shared} share the header stamp of another, so that all are stamped by the times at "
            "which the bag received them"
        )
    elif np.any(np.diff(rows) < 0):
        late = int(np.count_nonzero(np.diff(header_ns) < 0))
        said.append(f"{late} were recorded late, and stand in the order of their header stamps")
    time_ns = (recorded_ns if shared else header_ns)[rows]
    return Stamps(time_ns, rows, bool(shared), latency_ns, "; ".join(said))


class BagFrames(DecodedFrames):
    """Images of one topic of a bag.

    Args:
        path: the bag.
        topic: of images, raw or compressed.
        size: (width, height) that every image must have; None where the camera is unknown.
        depth_topic: of depth on the same pixels; None where there is none.

    Raises:
        RecordingError: damaged, stamps that tell nothing, too many images, or depth for images.
    """

    orientation = AS_STORED

    def __init__(
        self,
        path: Path,
        topic: str,
        size: tuple[int, int] | None = None,
        depth_topic: str | None = None,
    ) -> None:
        self._path, self._topic, self._size = path, topic, size
        self._lock = threading.Lock()
        self._bag: Bag | None = None
        self._bits = 8
        with Bag(path) as bag:
            self.stamps, self._recorded_ns, self._header_ns = self._scan(bag, topic)
            self._time_ns = self.stamps.time_ns
            self.depth_topic = depth_topic
            self._depth = self._beside(bag, depth_topic) if depth_topic else {}
        self._time_ns.setflags(write=False)

    def _scan(self, bag: Bag, topic: str) -> tuple[Stamps, IntArray, IntArray]:
        """Stamps of a topic's messages, and when each was received and taken by its header."""
        rows, highest = [], 0
        for recorded_ns, stamp, message in bag.recorded([topic], IMAGE_TYPES):
            rows.append((recorded_ns, stamp, zlib.crc32(memoryview(message.data))))
            pixels = ENCODINGS.get(_encoding(message))
            if pixels is not None and pixels.number == "u2" and hasattr(message, "encoding"):
                highest = max(highest, int(_numbers(message, "u2").max(initial=0)))
            if len(rows) > FRAME_LIMIT:
                raise refusal(self._path, f"expected at most {FRAME_LIMIT} images, got more")
        self._bits = max(self._bits, highest.bit_length())
        table = np.array(rows, dtype=np.int64).reshape(-1, 3)
        stamps = choose_stamps(*table.T)
        if stamps is None:
            problem = "expected header stamps, or times of receipt, that tell images apart"
            raise refusal(self._path, f"{problem}, got equal ones", field=one_line(topic))
        return stamps, table[stamps.rows, 0], table[stamps.rows, 1]

    def _beside(self, bag: Bag, topic: str) -> dict[int, tuple[int, int]]:
        """For frames that have depth, when it was received and taken: the nearest in time."""
        stamps, recorded_ns, header_ns = self._scan(bag, topic)
        if stamps.by_receipt != self.stamps.by_receipt:
            stamps = stamps._replace(time_ns=recorded_ns)
            frames_ns = self._recorded_ns
        else:
            frames_ns = self._time_ns
        if not len(stamps.time_ns) or len(frames_ns) < 2:
            return {}
        within = 0.5 * float(np.median(np.diff(frames_ns)))
        places = np.searchsorted(0.5 * (stamps.time_ns[1:] + stamps.time_ns[:-1]), frames_ns)
        near = np.abs(stamps.time_ns[places] - frames_ns) < within
        return {
            frame: (int(recorded_ns[place]), int(header_ns[place]))
            for frame, place in enumerate(places.tolist())
            if near[frame]
        }

    def __reduce__(self) -> tuple[Any, ...]:
        """Reopen the file in another process."""
        about = self._path, self._topic, self._size, self.depth_topic
        return BagFrames, about, {"masks": self.masks}

    def __getitem__(self, index: int) -> Frame:
        frame, index = super().__getitem__(index), range(len(self))[index]
        if index not in self._depth:
            return frame
        return replace(frame, read_depth=partial(self._depth_m, index))

    @property
    def named(self) -> Path:
        """What opens these very images again: `BAG:/topic`."""
        return Path(f"{self._path}:{self._topic}")

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the first image; raises as `Frame.image`."""
        height, width = self._image(0).shape[:2]
        return width, height

    @property
    def depth_count(self) -> int:
        """How many frames have depth."""
        return len(self._depth)

    def check(self, camera: Camera | None) -> None:
        """Compare the first image's size with the camera's.

        Raises:
            RecordingError: another size.
        """
        if camera is not None and len(self):
            self._size = (camera.width, camera.height)
            self._image(0)

    def intact(self, camera: Camera | None) -> tuple[BagFrames, tuple[str, ...]]:
        """All of it; raises as `check`."""
        self.check(camera)
        return self, ()

    def content(self) -> Iterator[bytes]:
        """The topics, and a digest of the bag's bytes, which are read once."""
        yield f"{self._topic}\n{self.depth_topic}".encode()
        yield from self._digests

    @cached_property
    def _digests(self) -> list[bytes]:
        root, digests = self._path, []
        for path in sorted(root.iterdir()) if root.is_dir() else [root]:
            if path.is_file() and path.stat().st_size:
                with open_bounded(path, FILE_LIMIT) as file:
                    digests.append(hashlib.file_digest(file, "sha256").digest())
        return digests

    def _message(self, topic: str, recorded_ns: int, header_ns: int, field: str) -> Any:
        with self._lock:
            if self._bag is None:
                self._bag = Bag(self._path)
                weakref.finalize(self, self._bag.close)
            messages = self._bag.messages([topic], IMAGE_TYPES, recorded_ns)
            message = next((value for stamp, value in messages if stamp == header_ns), None)
        if message is None:
            raise refusal(self._path, "the image is gone", field=field)
        return message

    def _image(self, index: int) -> ImageArray:
        field = f"{one_line(self._topic)} frame {index}"
        places = int(self._recorded_ns[index]), int(self._header_ns[index])
        message = self._message(self._topic, *places, field)
        image = decode_image(message, self._path, field, self._bits)
        if self._size is not None and image.shape[1::-1] != self._size:
            problem = f"expected {self._size} pixels as the camera has, got {image.shape[1::-1]}"
            raise refusal(self._path, problem, field=field)
        return image

    def _depth_m(self, index: int) -> DepthArray:
        topic = str(self.depth_topic)
        field = f"{one_line(topic)} of frame {index}"
        message = self._message(topic, *self._depth[index], field)
        return decode_depth(message, self._path, field)


def _encoding(message: Any) -> str:
    text = getattr(message, "encoding", None)
    return str(message.format).partition(";")[0].strip() if text is None else str(text)


def _numbers(message: Any, number: str) -> NDArray[Any]:
    """All whole numbers of a raw message's bytes, in the order of bytes that it states."""
    size = np.dtype(number).itemsize
    data = message.data[: message.data.size // size * size]
    return np.frombuffer(data, np.dtype(number).newbyteorder(_order(message)))


def _order(message: Any) -> Literal["<", ">"]:
    return ">" if message.is_bigendian else "<"


def decode_image(message: Any, path: Path, field: str, bits: int = 8) -> ImageArray:
    """An image ``(height, width, 3)`` in RGB, or grey ``(height, width)``, of 8 bits.

    Args:
        message: raw or compressed.
        path: the bag, for messages.
        field: the topic and the frame, likewise.
        bits: how many bits of 16 the topic uses.

    Raises:
        RecordingError: depth, another encoding, bytes that do not fit, or a damaged image.
    """
    encoding = _encoding(message)
    if encoding in DEPTH_ENCODINGS:
        raise refusal(
            path,
            f"expected images, got depth ({encoding})",
            field=field,
            advice="name a topic of images; `motorcade inspect` lists them",
        )
    if not hasattr(message, "encoding"):
        return _compressed(message, path, field, ENCODINGS.get(encoding))
    if encoding not in ENCODINGS:
        problem = f"expected one of {', '.join(ENCODINGS)}, got {one_line(encoding)}"
        raise refusal(path, problem, field=field)
    pixels = ENCODINGS[encoding]
    stored = _rows(message, path, field, pixels.number, pixels.channels)
    if pixels.number == "u2":
        stored = np.asarray(stored >> (bits - 8), dtype=np.uint8)
    return _to_rgb(stored, pixels.to_rgb, path, field)


def _to_rgb(stored: NDArray[Any], code: int | None, path: Path, field: str) -> ImageArray:
    try:
        image = np.array(stored) if code is None else cv2.cvtColor(np.array(stored), code)
    except cv2.error as fault:
        raise refusal(path, f"cannot be converted: {one_line(fault, 100)}", field=field) from fault
    return np.asarray(image, dtype=np.uint8)


def _rows(message: Any, path: Path, field: str, number: str, count: int) -> NDArray[Any]:
    """Pixels ``(height, width)`` or ``(height, width, count)`` of a raw message."""
    height, width, step = (int(value) for value in (message.height, message.width, message.step))
    least = width * count * np.dtype(number).itemsize
    fits = 0 < height * width <= FRAME_PIXELS and step >= least
    if not fits or message.data.size != height * step:
        problem = f"expected {height} rows of {step} bytes, got {message.data.size}"
        raise refusal(path, problem, field=field)
    order = np.dtype(number).newbyteorder(_order(message))
    rows = np.ascontiguousarray(message.data.reshape(height, step)[:, :least]).view(order)
    stored = rows.astype(np.dtype(number))
    return stored if count == 1 else stored.reshape(height, width, count)


def _compressed(message: Any, path: Path, field: str, pixels: _Pixels | None) -> ImageArray:
    flags = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION
    image = _unpacked(message.data, path, field, flags)
    if image.dtype != np.uint8:
        raise refusal(path, "expected an 8-bit PNG or JPEG image", field=field)
    if image.ndim == 3:
        return _to_rgb(image, cv2.COLOR_BGR2RGB, path, field)
    mosaic = pixels is not None and pixels.channels == 1
    return _to_rgb(image, pixels.to_rgb if mosaic and pixels else None, path, field)


def _unpacked(data: Any, path: Path, field: str, flags: int) -> NDArray[Any]:
    try:
        width, height = image_size(bytes(data))
        if width * height > FRAME_PIXELS:
            raise ValueError(f"expected at most {FRAME_PIXELS} pixels, got {width} x {height}")
        image = cv2.imdecode(np.asarray(data, dtype=np.uint8), flags)
    except ValueError as fault:
        raise refusal(path, str(fault), field=field) from fault
    except cv2.error as fault:
        raise refusal(path, f"cannot be decoded: {one_line(fault)}", field=field) from fault
    if image is None:
        raise refusal(path, "cannot be decoded", field=field)
    return np.asarray(image)


def decode_depth(message: Any, path: Path, field: str) -> DepthArray:
    """Depth ``(height, width)`` in metres, NaN where the sensor saw nothing.

    Raises:
        RecordingError: no depth, depth as JPEG, bytes that do not fit, a damaged image.
    """
    encoding = _encoding(message)
    if encoding not in DEPTH_ENCODINGS:
        raise refusal(path, f"expected depth, got {one_line(encoding)}", field=field)
    number, metres_a_unit = DEPTH_ENCODINGS[encoding]
    if hasattr(message, "encoding"):
        stored = _rows(message, path, field, number, 1)
    else:
        stored = _packed_depth(message, path, field, number)
        metres_a_unit = 1.0 if stored.dtype == np.float32 else metres_a_unit
    unknown = ~np.isfinite(stored) | (stored <= 0)
    if number == "u2":
        unknown |= stored == 65535
    metres = stored.astype(np.float32) * np.float32(metres_a_unit)
    metres[unknown] = np.nan
    return np.asarray(metres, dtype=np.float32)


def _packed_depth(message: Any, path: Path, field: str, number: str) -> NDArray[Any]:
    """What `compressedDepth` or PNG holds: units of 16UC1, or metres of 32FC1 (float32)."""
    packing, data = str(message.format), message.data
    depth_header = "compressedDepth" in packing
    if "rvl" in packing or (not depth_header and "png" not in packing):
        problem = f"expected depth as PNG, got {one_line(packing)}"
        raise refusal(path, problem, field=field, advice="a JPEG has changed its values")
    if depth_header and len(data) > _DEPTH_HEADER.size:
        _, scale, offset = _DEPTH_HEADER.unpack(bytes(data[: _DEPTH_HEADER.size]))
        data = data[_DEPTH_HEADER.size :]
    stored = _unpacked(data, path, field, cv2.IMREAD_UNCHANGED)
    if stored.dtype != np.uint16 or stored.ndim != 2:
        raise refusal(path, "expected depth of 16 bits", field=field)
    if number == "u2":
        return stored
    with np.errstate(divide="ignore", invalid="ignore"):  # inverse depth, 0 where unknown
        metres = np.float32(scale) / (stored.astype(np.float32) - np.float32(offset))
    return np.where(stored == 0, np.float32(np.nan), metres)


def depth_beside(images: ImageTopic, topics: Mapping[str, ImageTopic]) -> ImageTopic | None:
    """The depth topic on the same pixels: of the same frame of axes and, where known, size."""
    for topic in topics.values():
        same = topic.frame_id == images.frame_id != ""
        sizes = {topic.size, images.size} - {None}
        if topic.kind == "depth" and same and len(sizes) <= 1:
            return topic
    return None
