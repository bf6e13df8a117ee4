"""Markers of one family in an image: found, refined to sub-pixels, read again, merged.

Quads are searched twice: with a threshold half-way between dark and bright nearby, which finds
small and shallow markers, and with one from the mean of a larger square, which finds markers beside
bright or dark things. What both pass on is decoded (`reading`). The sides are then fitted
(`edges`), which on exact renderings puts corners nearer than AprilTag's own and than
``cornerSubPix``. Last, the print is read again, and a quad that does not look like it is discarded.

Markers that are not AprilTags are searched by OpenCV's `ArucoDetector`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, checked_floats, frozen
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.markers.edges import refine_quads
from motorcade.tracking.markers.families import (
    APRILTAG_FAMILIES,
    KALIBR_FAMILY,
    border_share,
    check_family,
    dictionary,
    layout,
)
from motorcade.tracking.markers.native._quads import find_quads
from motorcade.tracking.markers.reading import (
    LEAST_CONTRAST,
    Quads,
    Reading,
    decode_quads,
    read_markers,
)

Backend = Literal["loops", "opencv"]
"""Loops of edges that four lines fit, or OpenCV's contours."""
_MOST_SIDE_PX = 32767
# Half the side of the square whose mean is the second threshold. OpenCV's largest is the same.
_REACH_PX = 2
# Quads of one id whose corners are nearer than this are one quad, found twice.
_SAME_QUAD_PX = 1.5
_PIXEL_ROUND = np.ones((3, 3), np.uint8)


def backend_for(family: str) -> Backend:
    """What finds more markers of a family: loops for AprilTags, OpenCV for the others."""
    return "loops" if family in APRILTAG_FAMILIES else "opencv"


def find_markers(image: GrayImage, family: str, backend: Backend) -> Quads:
    """Markers of a family, their corners right to a pixel or so; some may stand there twice.

    Raises:
        ValueError: an unknown family or backend, or a family that OpenCV does not know.
    """
    check_family(family)
    if backend == "opencv":
        return _find_opencv(image, family)
    if backend != "loops":
        raise ValueError(f"backend: expected loops or opencv, got {backend!r}")
    return _find_loops(image, family)


def _find_opencv(image: GrayImage, family: str) -> Quads:
    quads, ids, _ = _aruco(family).detectMarkers(image)
    if ids is None or len(ids) == 0:
        return Quads(np.empty(0, np.int64), np.empty((0, 4, 2)))
    corners = np.asarray(quads, np.float64).reshape(-1, 4, 2)
    return Quads(np.ravel(ids).astype(np.int64), corners)


def _find_loops(image: GrayImage, family: str) -> Quads:
    return _decoded(image, _loops(image, family), family)


def _loops(image: GrayImage, family: str) -> FloatArray:
    """Quads ``(m, 4, 2)`` that may be markers of a family."""
    if max(image.shape) > _MOST_SIDE_PX:
        raise ValueError(
            f"image: expected at most {_MOST_SIDE_PX} pixels a side, got {image.shape[::-1]}"
        )
    shape = layout(family)
    # Kalibr prints small squares that touch its tags' corners; white grown by a pixel parts them.
    grown = cv2.dilate(image, _PIXEL_ROUND) if family == KALIBR_FAMILY else image
    whole = np.ascontiguousarray(grown)
    quads = [
        find_quads(whole, shape.white_inside, float(shape.side_cells), reach)
        for reach in (0, _REACH_PX)
    ]
    return np.concatenate(quads).astype(np.float64)


def _decoded(image: GrayImage, loops: FloatArray, family: str) -> Quads:
    """Markers among quads ``(m, 4, 2)``, each once."""
    quads = decode_quads(image, loops, family)
    kept: list[int] = []
    for row, corners in enumerate(quads.corners_px):
        twins = [one for one in kept if quads.ids[one] == quads.ids[row]]
        apart = np.linalg.norm(quads.corners_px[twins] - corners, axis=-1).max(axis=-1, initial=0.0)
        if not twins or apart.min() > _SAME_QUAD_PX:
            kept.append(row)
    return Quads(quads.ids[kept], quads.corners_px[kept])


@cache
def _aruco(family: str) -> cv2.aruco.ArucoDetector:
    return cv2.aruco.ArucoDetector(dictionary(family))


# Texture that a library takes for a marker stays below 0.65, blurred small markers above 0.85.
_LEAST_AGREEMENT = 0.75
# Two observations of an id are one marker if their centres are nearer than this share of a side.
_SAME_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Detection:
    """One marker seen in an image.

    Args:
        family: one of `families.FAMILIES`.
        marker_id: its number in the family.
        corners_px: ``(4, 2)`` pixels, clockwise from the printed top-left corner.
        wrong_cells: cells of the print, black border included, that read the wrong colour.
        agreement: correlation of the image with the print, from 0.75 (hardly) to 1 (perfect).
        sharp: whether the corners are crossings of fitted sides; otherwise they are the library's
            own, right to a pixel, because a side does not show well enough (covered, no white
            beside it, out of the image).

    Raises:
        ValueError: corners of another shape or not finite.

    >>> import numpy as np
    >>> from motorcade.tracking import SingleMarker, detect_markers
    >>> image, _ = SingleMarker("tag36h11", 7, side_m=0.1).draw(pixels_per_m=1000.0)
    >>> [found] = detect_markers(image, "tag36h11")
    >>> found.marker_id, found.wrong_cells, found.sharp
    (7, 0, True)
    >>> np.ptp(found.corners_px, axis=0).round(1)  # pixels
    array([100., 100.])
    """

    family: str
    marker_id: int
    corners_px: FloatArray
    wrong_cells: int
    agreement: float
    sharp: bool

    def __post_init__(self) -> None:
        corners = frozen(checked_floats(self.corners_px, "Detection.corners_px", (2,)))
        if corners.shape != (4, 2):
            raise ValueError(f"Detection.corners_px: expected (4, 2), got {corners.shape}")
        object.__setattr__(self, "corners_px", corners)


def detect_markers(
    image: GrayImage,
    family: str,
    camera: Camera | None = None,
    *,
    backend: Backend | None = None,
) -> tuple[Detection, ...]:
    """Find every marker of a family in a grey image.

    Args:
        image: ``(height, width)`` uint8.
        family: one of `families.FAMILIES`.
        camera: undistorts the sides before they are fitted; without one they count as straight.
        backend: what searches; None takes what finds more.

    Returns:
        detections by rising id, then from left to right. An id may stand there more than once,
        where it is printed more than once. Where ``tag36h11`` is asked for and the image shows
        Kalibr's print of it (`families.KALIBR_FAMILY`), detections of that family.

    Raises:
        ValueError: not a grey uint8 image, an unknown family, or one that the backend lacks.
    """
    gray = checked_gray(image)
    if f"{family}_border2" != KALIBR_FAMILY or backend is not None:
        return _detected(
            gray, find_markers(gray, family, backend or backend_for(family)), family, camera
        )
    loops = _loops(gray, family)
    detections = _detected(gray, _decoded(gray, loops, family), family, camera)
    clear = any(one.wrong_cells == 0 for one in detections)
    if clear or len(decode_quads(gray, loops, KALIBR_FAMILY).ids) == 0:
        return detections
    wide = _detected(gray, find_markers(gray, KALIBR_FAMILY, "loops"), KALIBR_FAMILY, camera)
    return wide if len(wide) > len(detections) else detections


def _detected(
    gray: GrayImage, quads: Quads, family: str, camera: Camera | None
) -> tuple[Detection, ...]:
    """The quads that look like their prints, refined."""
    if len(quads.ids) == 0:
        return ()
    places, sharp = refine_quads(
        gray, quads.corners_px, border_share(family), camera, layout(family).white_inside
    )
    corners = np.where(sharp[:, None, None], places, quads.corners_px)
    reading = read_markers(gray, corners, family, quads.ids)
    kept = _merged(Quads(quads.ids, corners), reading)
    return tuple(
        Detection(
            family=family,
            marker_id=int(quads.ids[row]),
            corners_px=corners[row],
            wrong_cells=int(reading.wrong_cells[row]),
            agreement=float(reading.agreement[row]),
            sharp=bool(sharp[row]),
        )
        for row in kept
    )


def readable(reading: Reading) -> NDArray[np.bool_]:
    """Which markers look like their prints, ``(m,)``."""
    legible: NDArray[np.bool_] = reading.agreement >= _LEAST_AGREEMENT
    return legible & (reading.contrast >= LEAST_CONTRAST)


def _merged(quads: Quads, reading: Reading) -> list[int]:
    """Rows to keep: those that look like their print, the best of each marker, in order."""
    centres = quads.corners_px.mean(axis=1)
    legible = readable(reading)
    kept: list[int] = []
    for row in np.argsort(-reading.agreement, kind="stable"):
        twins = [one for one in kept if quads.ids[one] == quads.ids[row]]
        if legible[row] and not (twins and _overlaps(quads.corners_px[[row, *twins]])):
            kept.append(int(row))
    return sorted(kept, key=lambda index: (quads.ids[index], *centres[index]))


def _overlaps(quads: FloatArray) -> bool:
    """Whether the first of ``(n, 4, 2)`` lies where one of the others does."""
    centres = quads.mean(axis=1)
    sides = np.linalg.norm(np.roll(quads, 1, axis=1) - quads, axis=-1).mean(axis=1)
    apart = np.linalg.norm(centres[1:] - centres[0], axis=-1)
    return bool(np.any(apart < _SAME_SHARE * np.maximum(sides[1:], sides[0])))
