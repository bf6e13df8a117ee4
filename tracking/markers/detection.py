"""Markers of one family in a picture: found, refined to sub-pixels, read again, merged.

Two libraries propose quads. Their sides are then fitted (`edges`), which on exact renderings puts
corners nearer than AprilTag's own and than ``cornerSubPix``. Last, the print is read again, and a
quad that does not look like it is discarded.

Both libraries know the position of a marker to a pixel or so only. OpenCV's `ArucoDetector` knows
every family, `pupil_apriltags` (the AprilTag 3 library) three. On AprilTags the latter misses
fewer, above all small and shallow ones.

Libraries accept some wrong bits and never look at the whole print, so texture passes for a marker
now and then. Here every cell, black border included, is compared with the print of the id, after a
linear change of the light across the marker has been taken out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from threading import local
from typing import TYPE_CHECKING, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.markers.edges import refine_quads
from motorcade.tracking.markers.families import border_share, dictionary, marker_cells, side_cells
from motorcade.tracking.pictures import grey_levels

if TYPE_CHECKING:
    from pupil_apriltags import Detector

# Places in a cell that are sampled, each way, as shares of its side: its inner part.
_INSIDE = np.array([0.35, 0.65])
Backend = Literal["apriltag", "opencv"]
APRILTAG_FAMILIES = ("tag16h5", "tag25h9", "tag36h11")
_CLOCKWISE = [3, 2, 1, 0]  # AprilTag's corners run anticlockwise from the bottom left
_HALF_PX = 0.5  # AprilTag's pixel (0, 0) is the corner of the top-left pixel, not its centre
_LEAST_SIDE_PX = 6  # AprilTag crashes on pictures two pixels wide, and needs six for a quad


@dataclass(frozen=True, eq=False)
class Reading:
    """How well the picture agrees with the print, for m markers.

    Fields:
        wrong_cells: ``(m,)`` cells whose colour is not the print's.
        agreement: ``(m,)`` correlation of the cells' brightness with the print, at most 1.
        contrast: ``(m,)`` grey levels from black to white.
    """

    wrong_cells: IntArray
    agreement: FloatArray
    contrast: FloatArray


def read_markers(
    image: GrayImage, corners_px: FloatArray, family: str, marker_ids: IntArray
) -> Reading:
    """Compare markers with their prints.

    Args:
        image: grey picture.
        corners_px: ``(m, 4, 2)`` clockwise from the printed top-left corner.
        family: of all of them.
        marker_ids: ``(m,)``.
    """
    if len(marker_ids) == 0:
        return Reading(np.empty(0, np.int64), np.empty(0), np.empty(0))
    prints = [_print(family, int(one)) for one in marker_ids]
    white = np.stack([one[0] for one in prints])
    print_ = np.stack([one[1] for one in prints])
    light = _without_plane(_cell_levels(image, corners_px, side_cells(family)))
    power = (print_ * print_).sum(axis=-1)
    contrast = (light * print_).sum(axis=-1) / power
    total = np.sqrt((light * light).sum(axis=-1) * power)
    agreement = contrast * power / np.maximum(total, 1e-9)
    # Brightness less half-way between black and white at each cell, the light's slope included.
    distance = light - contrast[:, None] * (print_ - white + 0.5)
    wrong = ((distance > 0.0) != white).sum(axis=-1)
    return Reading(wrong.astype(np.int64), agreement, contrast)


@cache
def _print(family: str, marker_id: int) -> tuple[NDArray[np.bool_], FloatArray]:
    """Whether each cell ``(side * side,)`` is white, and the same as numbers less their plane."""
    white = marker_cells(family, marker_id).ravel()
    return white, _without_plane(white[None].astype(np.float64))[0]


@cache
def _places(side: int) -> FloatArray:
    """The places sampled in the unit square, ``(side * side, samples, 2)``: x right, y down."""
    inside = np.stack(np.meshgrid(_INSIDE, _INSIDE), axis=-1).reshape(-1, 2)
    down, across = np.divmod(np.arange(side * side), side)
    places: FloatArray = (np.stack([across, down], axis=-1)[:, None] + inside) / side
    return places


def _cell_levels(image: GrayImage, corners_px: FloatArray, side: int) -> FloatArray:
    """Mean brightness ``(m, side * side)`` of the inner part of each cell."""
    places = _places(side)
    levels = grey_levels(image, _map_squares(corners_px, places.reshape(-1, 2)))
    mean: FloatArray = levels.reshape(len(corners_px), *places.shape[:2]).mean(axis=-1)
    return mean


def _map_squares(corners_px: FloatArray, places: FloatArray) -> FloatArray:
    """Map places ``(n, 2)`` of the unit square (y down) into quads ``(m, 4, 2)``: ``(m, n, 2)``.

    The homography of a square has a closed form (Heckbert 1989).
    """
    first, second, third, fourth = np.moveaxis(corners_px, 1, 0)
    to_second, to_fourth, gap = second - third, fourth - third, first - second + third - fourth
    area = _cross(to_second, to_fourth)
    area = np.where(np.abs(area) < 1e-12, 1e-12, area)
    along = (_cross(gap, to_fourth) / area)[:, None]
    down = (_cross(to_second, gap) / area)[:, None]
    x, y = places[:, 0, None], places[:, 1, None]
    across = second - first + along * second
    below = fourth - first + down * fourth
    above = across[:, None] * x + below[:, None] * y + first[:, None]
    scale = along[:, None] * x + down[:, None] * y + 1.0
    mapped: FloatArray = above / scale
    return mapped


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def _without_plane(values: FloatArray) -> FloatArray:
    """Values ``(m, side * side)`` less the plane that fits them best."""
    basis = _plane(values.shape[-1])
    less: FloatArray = values - (values @ basis.T) @ basis
    return less


@cache
def _plane(cells: int) -> FloatArray:
    """Orthonormal basis ``(3, cells)`` of the planes over a square of cells."""
    side = math.isqrt(cells)
    ramp = np.linspace(-1.0, 1.0, side)
    rows = np.stack([np.ones(cells), np.tile(ramp, side), np.repeat(ramp, side)])
    basis: FloatArray = rows / np.linalg.norm(rows, axis=-1, keepdims=True)
    return basis


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


# Texture that a library takes for a marker stays below 0.65, blurred small markers above 0.85.
_LEAST_AGREEMENT = 0.75
_LEAST_CONTRAST = 5.0  # grey levels
# Two sightings of an id are one marker if their centres are nearer than this share of a side.
_SAME_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Detection:
    """One marker seen in a picture.

    Args:
        family: one of `families.FAMILIES`.
        marker_id: its number in the family.
        corners_px: ``(4, 2)`` pixels, clockwise from the printed top-left corner.
        wrong_cells: cells of the print, black border included, that read the wrong colour.
        agreement: correlation of the picture with the print, from 0.75 (hardly) to 1 (perfect).
        sharp: whether the corners are crossings of fitted sides; otherwise they are the library's
            own, right to a pixel, because a side does not show well enough (covered, no white
            beside it, out of the picture).

    Raises:
        ValueError: corners of another shape or not finite.

    >>> import numpy as np
    >>> from motorcade.tracking import SingleMarker, detect_markers
    >>> picture, _ = SingleMarker("tag36h11", 7, side_m=0.1).draw(pixels_per_m=1000.0)
    >>> [found] = detect_markers(picture, "tag36h11")
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
    """Find every marker of a family in a grey picture.

    Args:
        image: ``(height, width)`` uint8.
        family: one of `families.FAMILIES`.
        camera: undistorts the sides before they are fitted; without one they count as straight.
        backend: the library that searches; None takes the one that finds more.

    Returns:
        detections by rising id, then from left to right. An id may stand there more than once,
        where it is printed more than once.

    Raises:
        ValueError: not a grey uint8 picture, an unknown family, or one that the library lacks.
    """
    gray = checked_gray(image)
    dictionary(family)
    quads = find_quads(gray, family, backend or backend_for(family))
    if len(quads.ids) == 0:
        return ()
    places, sharp = refine_quads(gray, quads.corners_px, border_share(family), camera)
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


def _merged(quads: Quads, reading: Reading) -> list[int]:
    """Rows to keep: those that look like their print, the best of each marker, in order."""
    centres = quads.corners_px.mean(axis=1)
    legible = (reading.agreement >= _LEAST_AGREEMENT) & (reading.contrast >= _LEAST_CONTRAST)
    kept: list[int] = []
    for row in np.argsort(-reading.agreement, kind="stable"):
        twins = [one for one in kept if quads.ids[one] == quads.ids[row]]
        if legible[row] and not (twins and _overlaps(quads.corners_px[[row, *twins]])):
            kept.append(int(row))
    return sorted(kept, key=lambda one: (quads.ids[one], *centres[one]))


def _overlaps(quads: FloatArray) -> bool:
    """Whether the first of ``(n, 4, 2)`` lies where one of the others does."""
    centres = quads.mean(axis=1)
    sides = np.linalg.norm(np.roll(quads, 1, axis=1) - quads, axis=-1).mean(axis=1)
    apart = np.linalg.norm(centres[1:] - centres[0], axis=-1)
    return bool(np.any(apart < _SAME_SHARE * np.maximum(sides[1:], sides[0])))
