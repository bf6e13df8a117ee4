"""Frames of a lens that zooms, as one focal length shows them, and for the film as taken."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

from motorcade.ga.arrays import IntArray
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
    >>> from motorcade.replays.io.readers.frames.zoomed import ZoomedFrames
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
