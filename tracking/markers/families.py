"""Marker families: names, dictionaries and bits as printed, whatever the library's own order.

AprilTag families follow the pictures that their authors publish. Releases of OpenCV differ there:
some store these tags turned by 180 degrees. The dictionary made here is turned back where
needed, so that corners, boards and drawings all agree with the official print.
"""

from __future__ import annotations

from functools import cache
from typing import cast

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga.arrays import FloatArray

# The topmost row of bits of tag 0 as printed officially (AprilRobotics/apriltag-imgs).
_OFFICIAL_TOP_ROW = {
    "tag16h5": (0, 0, 1, 0),
    "tag25h9": (1, 0, 1, 0, 1),
    "tag36h10": (0, 0, 0, 1, 1, 1),
    "tag36h11": (1, 1, 0, 1, 0, 1),
}
_PREDEFINED = {name: f"DICT_APRILTAG_{name[3:]}" for name in _OFFICIAL_TOP_ROW} | {
    f"aruco_{n}x{n}_{count}": f"DICT_{n}X{n}_{count}"
    for n in (4, 5, 6, 7)
    for count in (50, 100, 250, 1000)
}
_PREDEFINED |= {"aruco_original": "DICT_ARUCO_ORIGINAL", "aruco_mip_36h12": "DICT_ARUCO_MIP_36h12"}
FAMILIES: tuple[str, ...] = tuple(_PREDEFINED)


@cache
def dictionary(family: str) -> cv2.aruco.Dictionary:
    """The family's dictionary with every marker the right way up.

    Raises:
        ValueError: an unknown family, or a library whose tags match the official print neither
            upright nor turned by 180 degrees.
    """
    if family not in _PREDEFINED:
        raise ValueError(f"family: expected one of {', '.join(FAMILIES)}, got {family!r}")
    stored = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, _PREDEFINED[family]))
    if family not in _OFFICIAL_TOP_ROW:
        return stored
    bits = _stored_bits(stored, 0)
    official = np.array(_OFFICIAL_TOP_ROW[family])
    if np.array_equal(bits[0], official):
        return stored
    if not np.array_equal(bits[-1, ::-1], official):
        raise ValueError(f"family: this OpenCV stores {family} in an orientation not known here")
    upright = [
        cv2.aruco.Dictionary.getByteListFromBits(
            np.ascontiguousarray(np.rot90(_stored_bits(stored, marker), 2))
        )
        for marker in range(len(stored.bytesList))
    ]
    return cv2.aruco.Dictionary(
        np.concatenate(upright), stored.markerSize, stored.maxCorrectionBits
    )


def family_size(family: str) -> int:
    """How many markers a family has.

    Raises:
        ValueError: an unknown family.
    """
    return len(dictionary(family).bytesList)


def side_cells(family: str) -> int:
    """Cells along a marker's side, the black border included.

    Raises:
        ValueError: an unknown family.
    """
    return int(dictionary(family).markerSize) + 2


def border_share(family: str) -> float:
    """Width of the black border over the marker's side.

    Raises:
        ValueError: an unknown family.
    """
    return 1.0 / side_cells(family)


_UNIT = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [0.0, -1.0, 0.0]])


def marker_points_m(side_m: ArrayLike) -> FloatArray:
    """Corners ``(*, 4, 3)`` of markers in their own frames, clockwise from the printed top left.

    >>> from motorcade.tracking.markers.families import marker_points_m
    >>> marker_points_m(0.1)[2]  # bottom right: x to the right, y up
    array([ 0.1, -0.1,  0. ])
    """
    points: FloatArray = np.asarray(side_m)[..., None, None] * _UNIT
    return points


@cache
def marker_cells(family: str, marker_id: int) -> NDArray[np.bool_]:
    """A marker as printed, black border included: ``(side, side)`` bool, True is white.

    Raises:
        ValueError: an unknown family, or an id that it does not have.
    """
    book = dictionary(family)
    if not 0 <= marker_id < len(book.bytesList):
        raise ValueError(
            f"marker_id: {family} expects 0 to {len(book.bytesList) - 1}, got {marker_id}"
        )
    cells = np.pad(_stored_bits(book, marker_id).astype(bool), 1)
    cells.setflags(write=False)
    return cells


def _stored_bits(book: cv2.aruco.Dictionary, marker: int) -> NDArray[np.uint8]:
    rows = book.bytesList[marker : marker + 1]
    return cast(
        "NDArray[np.uint8]", cv2.aruco.Dictionary.getBitsFromByteList(rows, book.markerSize)
    )
