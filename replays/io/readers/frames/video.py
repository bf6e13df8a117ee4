"""Video files as frame sequences: upright images with their stamps, decoded lazily and in order.

Images asked for in order are decoded in one pass; going back or far ahead seeks to the nearest
keyframe first. Which there are, and when, says `packets`. Images come upright, as the display
matrix says, and with 8 bits a colour.
"""

from __future__ import annotations

import hashlib
import logging
import shlex
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from av.error import FFmpegError
from av.packet import Packet
from av.video.frame import VideoFrame
from av.video.stream import VideoStream

from motorcade.ga.files import admit_file
from motorcade.render.video import MAX_FILE_BYTES
from motorcade.replays.io.files import open_bounded, refusal, refused
from motorcade.replays.io.readers.frames.held import another_size
from motorcade.replays.io.readers.frames.packets import (
    ShownImages,
    Stored,
    decoded,
    look_through,
    open_stream,
    scan,
    stored_packets,
)
from motorcade.replays.io.readers.gopro import read_telemetry
from motorcade.replays.io.recording import DecodedFrames, ImageArray, Recording
from motorcade.tracking.cameras.camera import AS_STORED, ImageOrientation

if TYPE_CHECKING:
    from motorcade.tracking.cameras.camera import Camera

_LOG = logging.getLogger("motorcade.replays")
_HDR = {16: "PQ", 18: "HLG"}  # transfer characteristics by their number in ITU-T H.273
_ORIENTATIONS = tuple(
    ImageOrientation(turns, mirrored) for mirrored in (False, True) for turns in range(4)
)

_WHOLE_SHARE = 10
"""A video is refused of which less than one image in so many is whole."""
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
        RecordingError: not a video, nothing in it that can be decoded, or damaged telemetry.
    """
    frames = VideoFrames(root)
    return Recording(
        name=root.stem, root=root, layout="video", frames=frames, imu=read_telemetry(root)
    )


class VideoFrames(DecodedFrames):
    """Images of the first video stream of a file, upright, in the order they are shown.

    Stamps are the container's; see `packets` for those that it does not store. Opening decodes no
    more than that takes; `intact` decodes all, and leaves damaged images out.

    Args:
        path: the file.
        images: what was read of it already.

    Attributes:
        stored_size: width and height as coded.
        orientation: how the coded images are to be shown.
        size: width and height as shown.
        pixel_aspect: width of a pixel over its height, as stored; 1 for nearly all cameras.
        followed_ns: of a part, stamp of the image after its last; None at the file's end.

    Raises:
        RecordingError: not a video, nothing in it that can be decoded, or to be shown turned by
            anything but quarter turns.
    """

    followed_ns: int | None = None

    def __init__(self, path: Path, images: ShownImages | None = None) -> None:
        self._path = path
        with refused():
            admit_file(path, MAX_FILE_BYTES)
        if images is None:
            about = path.stat()
            images = scan(path, about.st_mtime_ns, about.st_size)
        self._images, self.stored_size = images, images.size
        self.orientation, self.pixel_aspect = _first_looked_at(path, images)
        self.size = self.orientation.size(self.stored_size)
        count = len(images.packets)
        self._places = np.array([k for k in range(count) if k not in images.damaged], np.int64)
        if _WHOLE_SHARE * len(self._places) < count + images.lost:
            raise refusal(path, self._left_out(), advice="copy the file again")
        self._time_ns = images.time_ns[self._places]
        self._time_ns.setflags(write=False)
        self._decoder: _Decoder | None = None
        self._lock = threading.Lock()

    def __reduce__(self) -> tuple[Any, ...]:
        """Reopen the file in another process: a decoder cannot be sent."""
        return VideoFrames, (self._path, self._images), {"masks": self.masks}

    @property
    def path(self) -> Path:
        """The file."""
        return self._path

    @property
    def notes(self) -> tuple[str, ...]:
        """What was taken for granted of stamps and of the file's end, and what is left out."""
        said = self._left_out()
        return (*self._images.notes, *([f"left out: {said}"] if said else []))

    def _left_out(self) -> str:
        """How many images are damaged, and when; empty where none is known to be."""
        images = self._images
        count = len(images.damaged) + images.lost
        if not count:
            return ""
        times = [f"{1e-9 * images.time_ns[place]:.3f}" for place in sorted(images.damaged)[:3]]
        when = f" (at {', '.join(times)} s{', …' if count > len(times) else ''})" if times else ""
        total = len(images.packets) + images.lost
        said = f"{count} of {total} images {'is' if count == 1 else 'are'} damaged{when}"
        return f"{said}; others before the next keyframe may show traces of that"

    def check(self, camera: Camera | None) -> None:
        """Compare the stream's size with the camera's.

        Raises:
            RecordingError: another size.
        """
        if camera is not None and self.size != (camera.width, camera.height):
            raise refusal(self._path, another_size((camera.width, camera.height), self.size))

    def intact(self, camera: Camera | None) -> tuple[VideoFrames, tuple[str, ...]]:
        """Without damaged images, for which all are decoded; what is said of them, if any are.

        Raises:
            RecordingError: as `check`, or hardly an image is whole.
        """
        self.check(camera)
        images = self._images
        if not images.looked:
            images = look_through(self._path, images)
        whole = self if images is self._images else VideoFrames(self._path, images)
        said = whole._left_out()
        return whole, (f"{self._path.name}: {said}",) if said else ()

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
                image = self._decoded(int(self._places[index]))
                if image.shape[1::-1] != self.stored_size:
                    size = self.stored_size
                    raise ValueError(f"expected {size} pixels, got {image.shape[1::-1]}")
                return self.orientation.upright(image)
            except (FFmpegError, ValueError, StopIteration) as fault:
                self._stop()
                raise refusal(
                    self._path,
                    f"the image cannot be decoded: {fault or 'the stream ends before it'}",
                    field=f"frame {index}",
                    advice="leave it out, as `intact` does",
                ) from fault

    def _decoded(self, place: int) -> ImageArray:
        """The image at a place of the order shown: the running decoder's, if it is before that.

        Else a new one starts at a keyframe, or at the start where seeking leads astray: indices of
        AVI files count images that were dropped, and some keyframes need what is before them.
        """
        keys = self._images.keys
        after = int(np.searchsorted(keys, place, side="right"))
        key = int(keys[after - 1]) if after else 0
        if self._decoder is None or not key - 1 <= self._decoder.at <= place:
            self._stop()
            self._decoder = _Decoder(self._path, self._images, key)
        frame = self._decoder.advance(place)
        if (frame is None or frame.is_corrupt) and self._decoder.seeks:
            self._stop()
            self._decoder = _Decoder(self._path, self._images, 0)
            frame = self._decoder.advance(place)
        if frame is None:
            raise ValueError("its packet holds none that can be shown")
        return np.asarray(frame.to_ndarray(format="rgb24"), dtype=np.uint8)

    def _stop(self) -> None:
        if self._decoder is not None:
            self._decoder.close()
        self._decoder = None


class _Decoder:
    """A running pass over the stream from a keyframe on, and the image it stands on."""

    def __init__(self, path: Path, images: ShownImages, key: int) -> None:
        self._order = images.packets
        self._place_of = {int(one): place for place, one in enumerate(self._order)}
        self._container, stream = open_stream(path)
        stream.thread_type = images.threads
        packets, number = stored_packets(self._container, stream), 0
        self.seeks = key > 0
        if self.seeks:
            wanted = int(self._order[key])
            pts, dts, *_ = images.stored[wanted]
            to = dts if pts is None else pts
            with suppress(FFmpegError):
                self._container.seek(0 if to is None else to, stream=stream)
            packets, number = _from_known(packets, images.stored, wanted)
        self._frames = decoded(packets, stream, number)
        self._frame: VideoFrame | None = None
        self.at = key - 1

    def advance(self, place: int) -> VideoFrame | None:
        """Decode on up to this image; None where it does not come."""
        while self.at < place:
            number, frame = next(self._frames, (-1, None))
            if frame is None:
                if number < 0:  # the end
                    return None
                continue
            follows = self.at + 1 < len(self._order) and self._order[self.at + 1] == number
            at = self.at + 1 if follows else self._place_of.get(number, -1)
            if at > self.at:
                self._frame, self.at = frame, at
        return self._frame if self.at == place else None

    def close(self) -> None:
        self._container.close()


def _from_known(
    packets: Iterator[Packet[VideoStream]], stored: Sequence[Stored], wanted: int
) -> tuple[Iterator[Packet[VideoStream]], int]:
    """Packets after seeking and the number of the first, no later than `wanted`; none else."""
    first = next(packets, None)
    if first is None:
        return iter(()), 0
    about = first.pts, first.dts, first.size, first.is_keyframe
    numbers = [number for number, one in enumerate(stored) if one == about]
    if len(numbers) != 1 or numbers[0] > wanted:
        return iter(()), 0
    return chain([first], packets), numbers[0]


@lru_cache(maxsize=4)
def _first_looked_at(path: Path, images: ShownImages) -> tuple[ImageOrientation, Fraction]:
    """How the images are to be shown, by the first; says what is assumed, and what is lost."""
    for note in images.notes:
        _LOG.warning("%s: %s", path, note)
    container, stream = open_stream(path)
    with container:
        frames = (one for _, one in decoded(stored_packets(container, stream), stream, 0))
        frame = next((one for one in frames if one is not None), None)
        aspect = stream.sample_aspect_ratio
    if frame is None:
        raise refusal(
            path,
            "none of its images can be decoded",
            field="frame 0",
            advice="copy the file again",
        )
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
            "%s: its images have %d bits a colour%s: they are read with 8, and so is the film%s",
            path,
            bits,
            "" if transfer is None else f" ({transfer}, high dynamic range)",
            "" if transfer is None else "; light that is estimated from them is rough",
        )
    return _orientation(path, frame), Fraction(aspect or 1)


def _orientation(path: Path, frame: VideoFrame) -> ImageOrientation:
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
            f"expected images that are shown turned by quarter turns, got one by "
            f"{-frame.rotation} degrees",
            advice="encode the video again turned: ffmpeg -i IN OUT does it",
        )
    return near[0]
