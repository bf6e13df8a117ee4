"""Video files as frame sequences: the container's own stamps, decoded lazily and in order.

Opening reads the packets' stamps only. Pictures asked for in order are decoded in one pass; going
back or far ahead seeks to the nearest keyframe first. Stamps are `pts · time_base`, to the
nanosecond. Pictures come upright, as the display matrix says, and with 8 bits a colour.
"""

from __future__ import annotations

import hashlib
import logging
import shlex
import threading
from collections.abc import Iterator
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from av.container import InputContainer
from av.error import FFmpegError
from av.video.frame import VideoFrame
from av.video.stream import VideoStream

from motorcade.ga.arrays import IntArray
from motorcade.render.video import MAX_FILE_BYTES, MAX_PIXELS, open_video
from motorcade.replays.errors import refusal
from motorcade.replays.files.door import open_bounded, refused
from motorcade.replays.readers.frames.decoded import DecodedFrames
from motorcade.replays.readers.frames.files import FRAME_LIMIT
from motorcade.replays.readers.frames.held import another_size
from motorcade.replays.readers.frames.whole import refuse_cut
from motorcade.replays.readers.gpmf import read_telemetry
from motorcade.replays.recording import ImageArray, Recording
from motorcade.tracking.cameras.orientation import AS_STORED, PictureOrientation

if TYPE_CHECKING:
    from motorcade.tracking.cameras.camera import Camera

_LOG = logging.getLogger("motorcade.replays")
_HDR = {16: "PQ", 18: "HLG"}  # transfer characteristics by their number in ITU-T H.273
_ORIENTATIONS = tuple(
    PictureOrientation(turns, mirrored) for mirrored in (False, True) for turns in range(4)
)

SUFFIXES = (
    *(".mp4", ".m4v", ".mov", ".qt", ".3gp", ".3g2", ".lrv"),  # of one kind: ISO 14496-12
    *(".mkv", ".webm", ".avi", ".mpg", ".mpeg", ".ts", ".mts", ".m2ts"),
)


def recognise(root: Path) -> bool:
    """Whether this is a file with a video's ending."""
    return root.is_file() and root.suffix.lower() in SUFFIXES


def read(root: Path, *, own_truth: bool = True) -> Recording:
    """Read a video file, with the IMU of a GoPro's telemetry where it holds one.

    Without a manifest nothing is known of its camera, nor of how that sits on the IMU.

    Raises:
        RecordingError: not a video, truncated, without stamps, or with damaged telemetry.
    """
    frames = VideoFrames(root)
    return Recording(
        name=root.stem, root=root, layout="video", frames=frames, imu=read_telemetry(root)
    )


class VideoFrames(DecodedFrames):
    """Pictures of the first video stream of a file, upright, in the order they are shown.

    Args:
        path: the file.

    Attributes:
        stored_size: width and height as coded.
        orientation: how the coded pictures are to be shown.
        size: width and height as shown.
        pixel_aspect: width of a pixel over its height, as stored; 1 for nearly all cameras.

    Raises:
        RecordingError: not a video, truncated, without stamps, with equal stamps, or to be shown
            turned by anything but quarter turns.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._pts, self._keys, time_base, self.stored_size = _scan(path)
        self.orientation, self.pixel_aspect = _first_looked_at(path)
        self.size = self.orientation.size(self.stored_size)
        # Exact in Python's integers; a float would lose nanoseconds after some weeks.
        stamps = [round(int(pts) * time_base * 10**9) for pts in self._pts]
        if max(map(abs, stamps)) >= 2**62:
            raise refusal(path, "expected stamps within 146 years, got larger ones")
        self._time_ns = np.array(stamps, dtype=np.int64)
        self._time_ns.setflags(write=False)
        stalls = np.flatnonzero(np.diff(self._time_ns) <= 0)
        if stalls.size:
            problem = "expected stamps that increase, got equal ones"
            raise refusal(path, problem, field=f"frame {stalls[0] + 1}")
        self._decoder: _Decoder | None = None
        self._lock = threading.Lock()

    def __reduce__(self) -> tuple[type[VideoFrames], tuple[Path]]:
        """Reopen the file in another process: a decoder cannot be sent."""
        return VideoFrames, (self._path,)

    @property
    def path(self) -> Path:
        """The file."""
        return self._path

    def check(self, camera: Camera | None) -> None:
        """Compare the stream's size with the camera's; opening has looked for the file's end.

        Raises:
            RecordingError: another size.
        """
        if camera is not None and self.size != (camera.width, camera.height):
            raise refusal(self._path, another_size((camera.width, camera.height), self.size))

    def intact(self, camera: Camera | None) -> tuple[VideoFrames, tuple[str, ...]]:
        """All of it; raises as `check`."""
        self.check(camera)
        return self, ()

    def content(self) -> Iterator[bytes]:
        """Digest of the file's bytes, which are read once."""
        yield self._digest

    @cached_property
    def _digest(self) -> bytes:
        with open_bounded(self._path, MAX_FILE_BYTES) as file:
            return hashlib.file_digest(file, "sha256").digest()

    def _image(self, index: int) -> ImageArray:
        with self._lock:
            try:
                picture = self._decoder_for(index).image(index)
                if picture.shape[1::-1] != self.stored_size:
                    size = self.stored_size
                    raise ValueError(f"expected {size} pixels, got {picture.shape[1::-1]}")
                return self.orientation.upright(picture)
            except (FFmpegError, ValueError, StopIteration) as fault:
                self._stop()
                raise refusal(
                    self._path,
                    f"the picture cannot be decoded: {fault or 'the stream ends before it'}",
                    field=f"frame {index}",
                    advice="copy the file again",
                ) from fault

    def _decoder_for(self, index: int) -> _Decoder:
        """The running decoder if going on is the shortest way, or a new one from a keyframe."""
        place = int(np.searchsorted(self._keys, index, side="right")) - 1
        key = int(self._keys[place]) if place >= 0 else 0
        running = self._decoder
        if running is not None and key - 1 <= running.at <= index:
            return running
        self._stop()
        self._decoder = _Decoder(self._path, self._pts, key)
        return self._decoder

    def _stop(self) -> None:
        if self._decoder is not None:
            self._decoder.close()
        self._decoder = None


class _Decoder:
    """A running pass over the stream from a keyframe on, and the picture it stands on."""

    def __init__(self, path: Path, pts: IntArray, key: int) -> None:
        self._pts = pts
        self._start(path, key)
        # The index of an AVI that dropped pictures leads past the keyframe: then all is decoded.
        if key > 0 and self._read() > key:
            self.close()
            self._start(path, 0)

    def _start(self, path: Path, key: int) -> None:
        self._container = open_video(path)
        stream = self._container.streams.video[0]
        stream.thread_type = "AUTO"
        if key > 0:
            self._container.seek(int(self._pts[key]), stream=stream)
        self._frames = self._container.decode(stream)
        self._frame: VideoFrame | None = None
        self.at = key - 1

    def _read(self) -> int:
        """Decode the next picture; its place, or the first that is later, in the order shown."""
        self._frame = next(self._frames)
        self.at = int(np.searchsorted(self._pts, self._frame.pts or 0))
        return self.at

    def image(self, index: int) -> ImageArray:
        """Decode on up to this picture, RGB."""
        while self._frame is None or self.at < index:
            self._read()
        if self.at != index or self._frame.pts != self._pts[index]:
            raise ValueError(f"expected pts {self._pts[index]}, got {self._frame.pts}")
        return np.asarray(self._frame.to_ndarray(format="rgb24"), dtype=np.uint8)

    def close(self) -> None:
        self._container.close()


def _scan(path: Path) -> tuple[IntArray, IntArray, Fraction, tuple[int, int]]:
    """Read all packets: pts in the order shown, indices of keyframes, time base, size."""
    try:
        refuse_cut(path)
        with refused(), open_video(path) as container:
            if not container.streams.video:
                raise refusal(path, "expected a video stream, got none")
            stream = container.streams.video[0]
            if stream.codec_context is None:  # whatever the stubs say
                raise refusal(path, "expected a video of a known coding, got another")
            width, height = stream.codec_context.width, stream.codec_context.height
            shown = _shown_packets(path, container, stream)
            # An AVI counts pictures that were dropped as well.
            stated = stream.frames if "mov" in container.format.name else 0
            time_base = stream.time_base
    except (FFmpegError, OSError) as fault:
        reason = getattr(fault, "strerror", None) or fault
        raise refusal(
            path, f"cannot be read as a video: {reason}", advice="is the copy complete?"
        ) from fault
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS) or time_base is None:
        raise refusal(path, f"expected at most {MAX_PIXELS} pixels, got {width} x {height}")
    if not shown or (len(shown) < stated and _stored_pictures(path) < stated):
        raise refusal(
            path,
            f"the video is truncated: expected {stated or 'some'} pictures, got {len(shown)}",
            advice="copy the file again",
        )
    pts = np.array([place for place, _ in shown], dtype=np.int64)
    keys = np.flatnonzero([is_key for _, is_key in shown]).astype(np.int64)
    return pts, keys, time_base, (width, height)


def _stored_pictures(path: Path) -> int:
    """How many pictures a file holds, those that its edit list cuts away included."""
    with refused(), open_video(path, edited=False) as container:
        return sum(one.size > 0 for one in container.demux(video=0))


def _first_looked_at(path: Path) -> tuple[PictureOrientation, Fraction]:
    """How the pictures are to be shown, by the first; says where reading takes something away."""
    try:
        with refused(), open_video(path) as container:
            frame = next(container.decode(video=0))
            aspect = container.streams.video[0].sample_aspect_ratio
    except (FFmpegError, OSError, StopIteration) as fault:
        raise refusal(
            path,
            f"the picture cannot be decoded: {fault or 'the stream ends before it'}",
            field="frame 0",
            advice="copy the file again",
        ) from fault
    if frame.interlaced_frame:
        _LOG.warning(
            "%s: its frames are interlaced, two fields taken one after the other: where the camera "
            "moves, poses and lens may be off by a pixel and more; turn fields into frames first: "
            "ffmpeg -i %s -vf bwdif OUT.mp4",
            path,
            shlex.quote(path.name),
        )
    bits = max(component.bits for component in frame.format.components)
    if bits > 8:
        transfer = _HDR.get(int(frame.color_trc))
        _LOG.warning(
            "%s: its pictures have %d bits a colour%s: they are read with 8, and so is the film%s",
            path,
            bits,
            "" if transfer is None else f" ({transfer}, high dynamic range)",
            "" if transfer is None else "; light that is estimated from them is rough",
        )
    return _orientation(path, frame), Fraction(aspect or 1)


def _orientation(path: Path, frame: VideoFrame) -> PictureOrientation:
    """Of the eight orientations the one that a frame's display matrix has.

    The matrix holds nine 32-bit numbers, (a, b, u, c, d, v, x, y, w): a pixel (p, q) is shown at
    (a p + c q + x, b p + d q + y). Source: FFmpeg, libavutil/display.h.
    """
    stated: Any = frame.side_data.get("DISPLAYMATRIX")
    if stated is None:
        return AS_STORED
    a, b, _, c, d = np.frombuffer(bytes(stated), np.int32)[:5].astype(float).tolist()
    shown = np.array([[a, c], [b, d]])
    length = np.linalg.norm(shown, axis=0)
    if not np.all(length > 0.0):  # none at all: players show such a video as it is stored
        return AS_STORED
    near = [one for one in _ORIENTATIONS if np.abs(shown / length - one.matrix).max() < 0.01]
    if not near:
        raise refusal(
            path,
            f"expected pictures that are shown turned by quarter turns, got one by "
            f"{-frame.rotation} degrees",
            advice="encode the video again turned: ffmpeg -i IN OUT does it",
        )
    return near[0]


def _shown_packets(
    path: Path, container: InputContainer, stream: VideoStream
) -> list[tuple[int, bool]]:
    """Stamp of each packet that is shown, and whether it is a keyframe, in the order shown."""
    shown: list[tuple[int, bool]] = []
    for packet in container.demux(stream):
        if packet.size == 0 or packet.is_discard:
            continue
        if packet.pts is None:
            raise refusal(
                path,
                "expected a stamp for each picture, got none",
                field=f"frame {len(shown)}",
                advice="put the stream into an MP4 or Matroska file",
            )
        shown.append((packet.pts, packet.is_keyframe))
        if len(shown) > FRAME_LIMIT:
            raise refusal(path, f"expected at most {FRAME_LIMIT} pictures, got more")
    return sorted(shown)
