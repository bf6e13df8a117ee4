"""The two libraries that find markers, behind one signature: picture and family in, quads out.

Both know the position of a marker to a pixel or so only; `detection` refines and checks it.
OpenCV's `ArucoDetector` knows every family, `pupil_apriltags` (the AprilTag 3 library) three.
On AprilTags the latter misses fewer, above all small and shallow ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from threading import local
from typing import TYPE_CHECKING, Literal

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.markers.families import dictionary

if TYPE_CHECKING:
    from pupil_apriltags import Detector

__all__ = [
    "APRILTAG_FAMILIES",
    "Backend",
    "Quads",
    "apriltag_detector",
    "backend_for",
    "find_quads",
]

Backend = Literal["apriltag", "opencv"]
APRILTAG_FAMILIES = ("tag16h5", "tag25h9", "tag36h11")
_CLOCKWISE = [3, 2, 1, 0]  # AprilTag's corners run anticlockwise from the bottom left
_HALF_PX = 0.5  # AprilTag's pixel (0, 0) is the corner of the top-left pixel, not its centre
_LEAST_SIDE_PX = 6  # AprilTag crashes on pictures two pixels wide, and needs six for a quad


@dataclass(frozen=True, eq=False)
class Quads:
    """What a library found: ids ``(m,)`` and corners ``(m, 4, 2)``, clockwise from top left."""

    ids: IntArray
    corners_px: FloatArray


def backend_for(family: str) -> Backend:
    """The library that finds more markers of a family at no more than 1.2 times the time."""
    return "apriltag" if family in APRILTAG_FAMILIES else "opencv"


def find_quads(image: GrayImage, family: str, backend: Backend) -> Quads:
    """Ask a library for the markers of a family.

    Raises:
        ValueError: an unknown family or library, or a family that the library does not know.
    """
    if backend == "opencv":
        return _find_opencv(image, family)
    if backend != "apriltag":
        raise ValueError(f"backend: expected apriltag or opencv, got {backend!r}")
    if family not in APRILTAG_FAMILIES:
        dictionary(family)
        raise ValueError(
            f"family: apriltag knows {', '.join(APRILTAG_FAMILIES)}, got {family!r}; use opencv"
        )
    return _find_apriltag(image, family)


def _find_opencv(image: GrayImage, family: str) -> Quads:
    found, ids, _ = _aruco(family).detectMarkers(image)
    if ids is None or len(ids) == 0:
        return Quads(np.empty(0, np.int64), np.empty((0, 4, 2)))
    corners = np.asarray(found, np.float64).reshape(-1, 4, 2)
    return Quads(np.ravel(ids).astype(np.int64), corners)


def _find_apriltag(image: GrayImage, family: str) -> Quads:
    if min(image.shape) < _LEAST_SIDE_PX:
        return Quads(np.empty(0, np.int64), np.empty((0, 4, 2)))
    found = apriltag_detector(family).detect(np.ascontiguousarray(image))
    ids = np.array([one.tag_id for one in found], np.int64)
    corners = np.array([one.corners[_CLOCKWISE] for one in found]).reshape(-1, 4, 2)
    return Quads(ids, corners - _HALF_PX)


@cache
def _aruco(family: str) -> cv2.aruco.ArucoDetector:
    return cv2.aruco.ArucoDetector(dictionary(family))


_own = local()


def apriltag_detector(family: str) -> Detector:
    """The AprilTag detector of this thread; no two threads may use one, and making one is slow."""
    kept: dict[str, Detector] = _own.__dict__
    if family not in kept:
        from pupil_apriltags import Detector

        detector = Detector(families=family, nthreads=1, quad_decimate=1.0)
        # Its destructor frees the family before the detector that still writes into it, which
        # corrupts memory; not knowing the family, it leaves those few kilobytes alone.
        detector.tag_families.clear()
        kept[family] = detector
    return kept[family]
