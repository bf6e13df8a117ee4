"""Part of a sequence of frames: those between two times, with all else as it was.

Times rather than numbers, since damaged images are left out of one reading and not of another.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.recording import FrameSequence, ImageArray
from motorcade.tracking.cameras.camera import Camera


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
