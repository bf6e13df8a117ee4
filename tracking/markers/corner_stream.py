"""Marker corners that one camera saw over a whole recording, frame by frame.

What a detector leaves behind, or a recording that holds corners instead of images. Corners run
clockwise from the printed top-left one; pixel (0, 0) is the centre of the top-left pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.cameras.camera import Camera


@dataclass(frozen=True, eq=False)
class CornerStream:
    """All detections of one camera; frames without a marker count as frames.

    Args:
        camera: who saw them.
        time_ns: ``(F,)`` stamps of all frames, strictly increasing.
        frame: ``(N,)`` row of ``time_ns`` that each detection belongs to, never falling.
        marker_ids: ``(N,)``; an id stands at most once in a frame.
        corners_px: ``(N, 4, 2)`` pixels, clockwise from the printed top-left corner.

    Raises:
        ValueError: shapes that do not agree, stamps or frames out of order, an id twice in a
            frame, or corners that are not finite.
    """

    camera: Camera
    time_ns: IntArray
    frame: IntArray
    marker_ids: IntArray
    corners_px: FloatArray

    def __post_init__(self) -> None:
        stamps = checked_stamps(self.time_ns, "CornerStream.time_ns")
        frame, ids = checked_numbers(self.frame, self.marker_ids, len(stamps), "CornerStream")
        corners = frozen(checked_floats(self.corners_px, "CornerStream.corners_px", (4, 2)))
        if corners.shape != (len(ids), 4, 2):
            raise ValueError(
                f"CornerStream.corners_px: expected {(len(ids), 4, 2)}, got {corners.shape}"
            )
        for name, value in (("time_ns", stamps), ("frame", frame), ("marker_ids", ids)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "corners_px", corners)

    def __len__(self) -> int:
        """Number of detections."""
        return len(self.marker_ids)

    def where(self, kept: NDArray[np.bool_]) -> CornerStream:
        """The detections ``(N,)`` that are kept; all frames still count."""
        shown = self.frame[kept], self.marker_ids[kept], self.corners_px[kept]
        return CornerStream(self.camera, self.time_ns, *shown)


def checked_stamps(time_ns: IntArray, field: str) -> IntArray:
    """A read-only copy of strictly increasing stamps ``(F,)``.

    Raises:
        ValueError: naming the field.
    """
    stamps = np.array(time_ns)
    if stamps.ndim != 1 or (stamps.size and stamps.dtype.kind not in "iu"):
        raise ValueError(
            f"{field}: expected (F,) whole nanoseconds, got {stamps.dtype} {stamps.shape}"
        )
    stamps = stamps.astype(np.int64)
    if np.any(np.diff(stamps) <= 0):
        raise ValueError(f"{field}: expected strictly increasing stamps, got some out of order")
    stamps.setflags(write=False)
    return stamps


def checked_numbers(
    frame: IntArray, marker_ids: IntArray, frames: int, owner: str
) -> tuple[IntArray, IntArray]:
    """Read-only copies of the frame and the id of each detection ``(N,)``.

    Raises:
        ValueError: other shapes, frames out of order or out of range, an id twice in a frame.
    """
    rows, ids = np.array(frame, dtype=np.int64), np.array(marker_ids, dtype=np.int64)
    if rows.ndim != 1 or ids.shape != rows.shape:
        raise ValueError(f"{owner}.marker_ids: expected {rows.shape}, got {ids.shape}")
    if rows.size and (rows.min() < 0 or rows.max() >= frames or np.any(np.diff(rows) < 0)):
        raise ValueError(f"{owner}.frame: expected rows of 0 to {frames - 1} that never fall")
    if len(np.unique(np.stack([rows, ids]), axis=1).T) != len(rows):
        raise ValueError(f"{owner}.marker_ids: expected each id once in a frame, got one twice")
    for array in (rows, ids):
        array.setflags(write=False)
    return rows, ids
