"""Frames of a recording that holds marker corners instead of images."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import partial
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import IntArray
from motorcade.replays.io.files import refusal
from motorcade.replays.io.recording import Frame, ImageArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.scenes import MarkerScene


@dataclass(frozen=True, eq=False)
class CornerFrames:
    """What the cameras of a rig saw of markers; its frames are those of the first camera.

    Fields:
        path: where the corners were read from.
        streams: by the name of the camera, the one whose path is looked for first.
        rig_T_camera: of the cameras whose place on the rig is known, at least one.
        side_m: side of the black square of each marker that was seen, by id.
        scene: what else is stated of markers, bodies and cameras, where anything is.
    """

    path: Path
    streams: Mapping[str, CornerStream]
    rig_T_camera: Mapping[str, Motor]
    side_m: Mapping[int, float]
    scene: MarkerScene | None = None

    @property
    def first(self) -> CornerStream:
        """The stream of the camera whose path is looked for."""
        return next(iter(self.streams.values()))

    @property
    def time_ns(self) -> IntArray:
        """Stamps ``(N,)`` of the first camera's frames, read-only."""
        return self.first.time_ns

    def __len__(self) -> int:
        return len(self.time_ns)

    def __getitem__(self, index: int) -> Frame:
        index = range(len(self))[index]
        return Frame(int(self.time_ns[index]), f"frame {index}", partial(self._no_image, index))

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))

    def check(self, camera: Camera | None) -> None:
        """Nothing is left to look at: all was read when the recording was opened."""

    def intact(self, camera: Camera | None) -> tuple[CornerFrames, tuple[str, ...]]:
        """All of it: nothing can be damaged that was read."""
        return self, ()

    def content(self) -> Iterator[bytes]:
        """All numbers, in the order of the cameras."""
        for name, stream in self.streams.items():
            yield f"camera {name} {stream.camera!r} {len(stream)}\n".encode()
            for array in (stream.time_ns, stream.frame, stream.marker_ids, stream.corners_px):
                yield np.ascontiguousarray(array).tobytes()
        for name, pose in sorted(self.rig_T_camera.items()):
            yield name.encode() + pose.coefficients.tobytes()
        yield repr(sorted(self.side_m.items())).encode()
        yield from _content(self.scene)

    def _no_image(self, index: int) -> ImageArray:
        problem = "the recording holds corners of markers, and no images"
        raise refusal(self.path, problem, field=f"frame {index}")


def _content(value: object) -> Iterator[bytes]:
    """All that a tree of values holds."""
    if isinstance(value, Motor):
        yield value.coefficients.tobytes()
    elif isinstance(value, np.ndarray):
        yield value.tobytes()
    elif isinstance(value, Trajectory):
        yield value.time_ns.tobytes() + value.motors.coefficients.tobytes()
    elif is_dataclass(value):
        for field in fields(value):
            yield field.name.encode()
            yield from _content(getattr(value, field.name))
    elif isinstance(value, Mapping):
        for key in sorted(value):
            yield repr(key).encode()
            yield from _content(value[key])
    elif isinstance(value, tuple):
        for row in value:
            yield from _content(row)
    else:
        yield repr(value).encode()
