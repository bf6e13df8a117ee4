"""Frames that come: from a camera, a stream, a pipe or a recording played at its own pace.

A stream has no length and no index: it is an iterator of `LiveFrame`. Whoever is slower than the
camera takes the newest frame and never sees those between (`newest`).
"""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import IntArray
from motorcade.render.video import MAX_PIXELS
from motorcade.replays.io.recording import Recording
from motorcade.replays.live.inertial import ImuSample
from motorcade.tracking.checks import GrayImage

_DEVICE = "/dev/video"
_OPEN_S, _READ_S = 15.0, 5.0
_NETWORK = ("rtsp", "rtsps")
_OPTIONS: dict[str, dict[str, str]] = {  # nothing may be opened but what carries the images
    "rtsp": {"protocol_whitelist": "rtsp,rtp,udp,tcp", "rtsp_transport": "tcp"},
    "rtsps": {"protocol_whitelist": "rtsp,rtp,tcp,tls", "rtsp_transport": "tcp"},
    "pipe": {"protocol_whitelist": "pipe"},
    "device": {},
}


@dataclass(frozen=True, eq=False)
class LiveFrame:
    """An image as it came.

    Args:
        time_ns: its stamp on the source's clock; later frames have later stamps.
        image: ``(height, width)`` grey or ``(height, width, 3)`` RGB, uint8.
        captured_s: when it was taken, or came here, on `time.monotonic`'s clock.
        imu: readings that came since the frame before.

    >>> import numpy as np
    >>> from motorcade.replays.live import LiveFrame
    >>> LiveFrame(0, np.zeros((48, 64, 3), np.uint8)).gray.shape
    (48, 64)
    """

    time_ns: int
    image: NDArray[np.uint8]
    captured_s: float = field(default_factory=time.monotonic)
    imu: tuple[ImuSample, ...] = ()

    @cached_property
    def gray(self) -> GrayImage:
        """Its luma (ITU-R BT.601), as recordings have it."""
        if self.image.ndim == 2:
            return self.image
        return np.asarray(cv2.cvtColor(self.image, cv2.COLOR_RGB2GRAY), np.uint8)


def open_frames(source: str) -> Iterator[LiveFrame]:
    """Open a source by its name.

    Args:
        source: a device (``/dev/video0``), an address (``rtsp://…``), ``-`` for a video that comes
            through the standard input (Matroska, MPEG-TS or YUV4MPEG), or a recording's path,
            which is played at its own pace.

    Raises RecordingError: a path that holds no recording; OSError: a device, stream or pipe that
    cannot be opened or says nothing.

    >>> from motorcade.replays.live import open_frames
    >>> next(open_frames("/dev/video99"))
    Traceback (most recent call last):
    FileNotFoundError: [Errno 2] No such file or directory: '/dev/video99'
    """
    kind = kind_of(source)
    if kind == "recording":
        from motorcade.replays.io.readers.opening import open_recording

        yield from paced(open_recording(source))
        return
    with closing(_opened(source, kind)) as container:
        yield from _decoded(container, source)


def kind_of(source: str) -> str:
    """What a source's name names: "device", "rtsp", "rtsps", "pipe" or "recording".

    Raises ValueError: an address of another kind, which would be opened as whatever it says.
    """
    scheme, separator, _ = source.partition("://")
    if separator:
        if scheme.lower() not in _NETWORK:
            raise ValueError(f"source: expected an address of rtsp:// or rtsps://, got {source}")
        return scheme.lower()
    if source == "-":
        return "pipe"
    return "device" if source.startswith(_DEVICE) else "recording"


def _opened(source: str, kind: str) -> Any:
    import av

    options = {**_OPTIONS[kind], "fflags": "nobuffer"}
    if kind == "device":
        if not Path(source).exists():
            raise FileNotFoundError(2, "No such file or directory", source)
        return av.open(source, format="v4l2", options=options, timeout=(_OPEN_S, _READ_S))
    if kind == "pipe":
        return av.open(sys.stdin.buffer, options=options)
    return av.open(source, options=options, timeout=(_OPEN_S, _READ_S))


def _decoded(container: Any, source: str) -> Iterator[LiveFrame]:
    """Images as they come. Stamps that are missing or go back are those of their coming."""
    stream = next(iter(container.streams.video), None)
    if stream is None or stream.codec_context is None:
        raise OSError(f"{source}: expected a video stream, got none")
    stream.codec_context.options = {"max_pixels": str(MAX_PIXELS), "flags": "low_delay"}
    last_ns = -1
    for frame in container.decode(stream):
        stamp = None if frame.pts is None else int(frame.pts * frame.time_base * 1_000_000_000)
        if stamp is None or stamp <= last_ns:
            stamp = max(last_ns + 1, time.monotonic_ns())
        last_ns = stamp
        yield LiveFrame(stamp, frame.to_ndarray(format="rgb24"))


def paced(
    recording: Recording,
    *,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Iterator[LiveFrame]:
    """A recording's frames, each when its stamp is due.

    It waits for nobody, as no camera does: of those that are overdue the newest comes.
    """
    stamps: IntArray = recording.frames.time_ns
    readings = _readings(recording)
    began_s = clock()
    due_s = began_s + 1e-9 * (stamps - stamps[0])
    index = 0
    while index < len(stamps):
        image = recording.frames[index].image()
        if (wait_s := float(due_s[index]) - clock()) > 0.0:
            sleep(wait_s)
        until_ns, since = int(stamps[index]), []
        while readings and readings[0].time_ns <= until_ns:
            since.append(readings.popleft())
        yield LiveFrame(until_ns, image, float(due_s[index]), tuple(since))
        index = max(index + 1, int(np.searchsorted(due_s, clock(), side="right")) - 1)


def _readings(recording: Recording) -> deque[ImuSample]:
    """What its IMU reads from its first frame on."""
    imu = recording.imu
    if imu is None:
        return deque()
    first = int(np.searchsorted(imu.time_ns, recording.frames.time_ns[0]))
    columns = (imu.time_ns.tolist(), imu.angular_rate_rad_s, imu.specific_force_m_s2)
    return deque(map(ImuSample, *(column[first:] for column in columns)))


def newest(frames: Iterable[LiveFrame]) -> Iterator[LiveFrame]:
    """Of a stream the newest frame, each time that one is asked for; those between are dropped.

    A thread of its own takes the frames, and ends with the stream or with this iterator.

    >>> import numpy as np, time
    >>> from motorcade.replays.live import LiveFrame, newest
    >>> stream = newest(LiveFrame(k, np.zeros((2, 2), np.uint8)) for k in range(5))
    >>> time.sleep(0.1)  # meanwhile all five have come
    >>> [frame.time_ns for frame in stream]
    [4]
    """
    changed = threading.Condition()
    held: deque[LiveFrame | Exception | None] = deque(maxlen=1)  # a fault or None is the last
    left = threading.Event()

    def fill() -> None:
        last: Exception | None = None
        try:
            for frame in frames:
                with changed:
                    if held and isinstance(held[0], LiveFrame):  # its readings are not dropped
                        frame = replace(frame, imu=held[0].imu + frame.imu)
                    held.append(frame)
                    changed.notify()
                if left.is_set():
                    return
        except Exception as fault:  # whatever it is, the reader is told
            last = fault
        with changed:
            changed.wait_for(lambda: not held or left.is_set())
            held.append(last)
            changed.notify()

    def taken() -> Iterator[LiveFrame]:
        try:
            while True:
                with changed:
                    changed.wait_for(lambda: held)
                    frame = held.pop()
                    changed.notify()
                if isinstance(frame, Exception):
                    raise frame
                if frame is None:
                    return
                yield frame
        finally:
            with changed:
                left.set()
                changed.notify()

    threading.Thread(target=fill, daemon=True, name="frames").start()
    return taken()
