"""Frames seen otherwise: a part of a sequence, or a zooming lens as one focal length.

A part is told by times rather than numbers, since damaged images are left out of one reading and
not of another. Images of a lens that zooms stay as taken for the film.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.recording import Frame, FrameSequence, ImageArray
from motorcade.tracking.cameras.camera import AS_STORED, Camera, ImageOrientation, Zoom


@dataclass(frozen=True, eq=False)
class ZoomedFrames:
    """A sequence of frames whose images are brought to a camera's focal length.

    Fields:
        taken: the images as they were taken, without depth.
        zoom: focal lengths over the camera's.
        camera: of the focal length that is wanted.

    >>> import numpy as np
    >>> from pathlib import Path
    >>> from motorcade.replays.io.readers.frames.files import ImageFrames
    >>> from motorcade.replays.io.readers.frames.views import ZoomedFrames
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.cameras.camera import Zoom
    >>> taken = ImageFrames((Path("0.png"), Path("1.png")), np.array([0, 10**9]))
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> [float(frame.zoom) for frame in ZoomedFrames(taken, Zoom([0, 1], [1.0, 2.0]), camera)]
    [1.0, 2.0]
    """

    taken: FrameSequence
    zoom: Zoom
    camera: Camera

    @property
    def time_ns(self) -> IntArray:
        """Stamps ``(N,)``, strictly increasing, read-only."""
        return self.taken.time_ns

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self.camera.width, self.camera.height

    @property
    def orientation(self) -> ImageOrientation:
        """How stored images are turned to be shown."""
        stored: ImageOrientation = getattr(self.taken, "orientation", AS_STORED)
        return stored

    def __len__(self) -> int:
        return len(self.taken)

    def __getitem__(self, index: int) -> Frame:
        frame = self.taken[index]
        return replace(
            frame,
            read_image=partial(self._shown, frame.image, frame.time_ns),
            read_mask=frame.read_mask and partial(self._shown, frame.read_mask, frame.time_ns),
            taken=frame,
            zoom=float(self.zoom.at(frame.time_ns)),
        )

    def _shown(self, read: Callable[[], ImageArray], time_ns: int) -> ImageArray:
        return self.zoom.unzoomed(read(), self.camera, time_ns)

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))

    def check(self, camera: Camera | None) -> None:
        """Look at every image; raises as the sequence of those taken."""
        self.taken.check(camera)

    def intact(self, camera: Camera | None) -> tuple[FrameSequence, tuple[str, ...]]:
        """Without damaged images, and what is said of these; raises as those taken."""
        whole, said = self.taken.intact(camera)
        return replace(self, taken=whole), said

    def content(self) -> Iterator[bytes]:
        """All that the images depend on, for a digest."""
        yield from self.taken.content()
        yield b"zoom" + self.zoom.time_s.tobytes() + self.zoom.ratio.tobytes()


def frames_between(frames: FrameSequence, start_ns: int, end_ns: int) -> FrameSequence:
    """The frames whose stamps lie from `start_ns` to `end_ns`, both included.

    Raises:
        ValueError: none does, or frames of a kind that has no parts (recorded corners, bags).

    >>> import numpy as np
    >>> from pathlib import Path
    >>> from motorcade.replays.io.readers.frames.files import ImageFrames
    >>> frames = ImageFrames((Path("0.png"), Path("1.png"), Path("2.png")), np.array([0, 5, 9]))
    >>> [path.name for path in frames_between(frames, 5, 9).files]
    ['1.png', '2.png']
    """
    rows = np.flatnonzero((frames.time_ns >= start_ns) & (frames.time_ns <= end_ns))
    if not len(rows):
        seconds = " to ".join(f"{1e-9 * time:g}" for time in frames.time_ns[[0, -1]])
        raise ValueError(
            f"expected frames from {1e-9 * start_ns:g} s to {1e-9 * end_ns:g} s, got {seconds} s"
        )
    if len(rows) == len(frames):
        return frames
    if isinstance(frames, VideoFrames):
        return _VideoSpan(frames, rows)
    if not isinstance(frames, ImageFrames):
        raise ValueError("expected a video or images in files, got frames that have no parts")
    kept = slice(int(rows[0]), int(rows[-1]) + 1)
    return replace(
        frames,
        files=frames.files[kept],
        time_ns=frames.time_ns[kept],
        depth_files=frames.depth_files[kept],
        right_files=frames.right_files[kept],
    )


class _VideoSpan(VideoFrames):
    """Neighbouring frames of a video; its decoder is shared with the whole."""

    def __init__(self, whole: VideoFrames, rows: IntArray) -> None:
        vars(self).update(vars(whole))  # what was read of the file
        self._whole, self._rows = whole, rows
        self._time_ns = whole.time_ns[rows]
        self._time_ns.setflags(write=False)
        later = whole.time_ns[rows[-1] + 1 :]
        self.followed_ns = int(later[0]) if len(later) else None

    def __reduce__(self) -> tuple[Any, ...]:
        return _VideoSpan, (self._whole, self._rows), {"masks": self.masks}

    def intact(self, camera: Camera | None) -> tuple[VideoFrames, tuple[str, ...]]:
        """As the whole's, of the same time."""
        whole, said = self._whole.intact(camera)
        if whole is self._whole:
            return self, said
        start_ns, end_ns = self._time_ns[[0, -1]]
        inside = (whole.time_ns >= start_ns) & (whole.time_ns <= end_ns)
        return _VideoSpan(whole, np.flatnonzero(inside)), said

    def content(self) -> Iterator[bytes]:
        """The file's digest, and which frames of it."""
        yield from self._whole.content()
        yield f"frames {self._rows[0]} to {self._rows[-1]}".encode()

    def _image(self, index: int) -> ImageArray:
        return self._whole._image(int(self._rows[index]))
