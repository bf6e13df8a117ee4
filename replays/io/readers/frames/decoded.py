"""Frames that are decoded one by one from a single file: a video, or a topic of a bag."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from functools import partial

from motorcade.ga.arrays import IntArray
from motorcade.replays.io.recording import Frame, ImageArray


class DecodedFrames(ABC):
    """A sequence of frames by their number; `_time_ns` holds their stamps."""

    _time_ns: IntArray

    @property
    def time_ns(self) -> IntArray:
        """Stamps ``(N,)``, strictly increasing, read-only."""
        return self._time_ns

    def __len__(self) -> int:
        return len(self._time_ns)

    def __getitem__(self, index: int) -> Frame:
        index = range(len(self))[index]
        return Frame(int(self._time_ns[index]), f"frame {index}", partial(self._image, index))

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))

    @abstractmethod
    def _image(self, index: int) -> ImageArray:
        """The picture of a frame."""
