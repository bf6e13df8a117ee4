"""Pictures of a topic of a ROS 1 or ROS 2 bag as a frame sequence."""

from __future__ import annotations

import hashlib
import threading
import weakref
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from motorcade.ga.names import one_line
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.files import open_bounded
from motorcade.replays.io.readers.frames.files import FRAME_LIMIT
from motorcade.replays.io.readers.frames.pictures import PIXEL_LIMIT, picture_size
from motorcade.replays.io.readers.ros.admission import FILE_LIMIT
from motorcade.replays.io.readers.ros.reader import Bag
from motorcade.replays.io.recording import DecodedFrames, ImageArray

if TYPE_CHECKING:
    from motorcade.tracking.cameras.camera import Camera

_RAW, _COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
IMAGE_TYPES = (_RAW, _COMPRESSED)
_CHANNELS = {
    "mono8": 1,
    "8UC1": 1,
    "rgb8": 3,
    "bgr8": 3,
    "8UC3": 3,
    "rgba8": 4,
    "bgra8": 4,
}
_TO_RGB = {"bgr8": [2, 1, 0], "8UC3": [2, 1, 0], "rgba8": [0, 1, 2], "bgra8": [2, 1, 0]}


class BagFrames(DecodedFrames):
    """Pictures of one topic of a bag, in the order of their header stamps.

    Args:
        path: the bag.
        topic: of images, raw or compressed.
        size: (width, height) that every picture must have; None where the camera is unknown.

    Raises:
        RecordingError: damaged, stamps that do not increase, or too many pictures.
    """

    def __init__(self, path: Path, topic: str, size: tuple[int, int] | None = None) -> None:
        self._path, self._topic, self._size = path, topic, size
        self._lock = threading.Lock()
        self._bag: Bag | None = None
        places = []
        with Bag(path) as bag:
            for recorded_ns, stamp, _ in bag.recorded([topic], IMAGE_TYPES):
                places.append((recorded_ns, stamp))
                if len(places) > FRAME_LIMIT:
                    raise refusal(path, f"expected at most {FRAME_LIMIT} pictures, got more")
        self._recorded_ns = [recorded for recorded, _ in places]
        self._time_ns = np.array([stamp for _, stamp in places], dtype=np.int64)
        self._time_ns.setflags(write=False)
        stalls = np.flatnonzero(np.diff(self._time_ns) <= 0)
        if stalls.size:
            problem = "expected header stamps that increase, got equal or earlier ones"
            raise refusal(path, problem, field=f"{one_line(topic)} frame {stalls[0] + 1}")

    def __reduce__(self) -> tuple[type[BagFrames], tuple[Any, ...]]:
        """Reopen the file in another process."""
        return BagFrames, (self._path, self._topic, self._size)

    def check(self, camera: Camera | None) -> None:
        """Compare the first picture's size with the camera's.

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
        """The topic, and a digest of the bag's bytes, which are read once."""
        yield self._topic.encode()
        yield from self._digests

    @cached_property
    def _digests(self) -> list[bytes]:
        root, digests = self._path, []
        for path in sorted(root.iterdir()) if root.is_dir() else [root]:
            if path.is_file() and path.stat().st_size:
                with open_bounded(path, FILE_LIMIT) as file:
                    digests.append(hashlib.file_digest(file, "sha256").digest())
        return digests

    def _image(self, index: int) -> ImageArray:
        field = f"{one_line(self._topic)} frame {index}"
        with self._lock:
            if self._bag is None:
                self._bag = Bag(self._path)
                weakref.finalize(self, self._bag.close)
            messages = self._bag.messages([self._topic], IMAGE_TYPES, self._recorded_ns[index])
            wanted = int(self._time_ns[index])
            message = next((one for stamp, one in messages if stamp == wanted), None)
        if message is None:
            raise refusal(self._path, "the picture is gone", field=field)
        decode = _raw if hasattr(message, "encoding") else _compressed
        picture = decode(message, self._path, field)
        if self._size is not None and picture.shape[1::-1] != self._size:
            problem = f"expected {self._size} pixels as the camera has, got {picture.shape[1::-1]}"
            raise refusal(self._path, problem, field=field)
        return picture


def _raw(message: Any, path: Path, field: str) -> ImageArray:
    encoding = str(message.encoding)
    if encoding not in _CHANNELS:
        problem = f"expected one of {', '.join(_CHANNELS)}, got {one_line(encoding)}"
        raise refusal(path, problem, field=field)
    channels, (height, width, step) = (
        _CHANNELS[encoding],
        (int(message.height), int(message.width), int(message.step)),
    )
    fits = 0 < height * width <= PIXEL_LIMIT and step >= width * channels
    if not fits or message.data.size != height * step:
        problem = f"expected {height} rows of {step} bytes, got {message.data.size}"
        raise refusal(path, problem, field=field)
    rows = message.data.reshape(height, step)[:, : width * channels]
    if channels == 1:
        return np.array(rows, dtype=np.uint8)
    picture = rows.reshape(height, width, channels)
    return np.ascontiguousarray(picture[..., _TO_RGB.get(encoding, [0, 1, 2])], dtype=np.uint8)


def _compressed(message: Any, path: Path, field: str) -> ImageArray:
    flags = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        picture_size(bytes(message.data))
    except ValueError as fault:
        raise refusal(path, str(fault), field=field) from fault
    try:
        picture = cv2.imdecode(np.asarray(message.data, dtype=np.uint8), flags)
    except cv2.error as fault:
        raise refusal(path, f"cannot be decoded: {one_line(fault)}", field=field) from fault
    if picture is None or picture.dtype != np.uint8:
        raise refusal(path, "expected an 8-bit PNG or JPEG picture", field=field)
    if picture.ndim == 3:
        picture = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
    return np.asarray(picture, dtype=np.uint8)
