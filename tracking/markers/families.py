"""Marker families: names, dictionaries and bits as printed, whatever the library's own order.

AprilTag families follow the images that their authors publish. Releases of OpenCV differ there:
some store these tags turned by 180 degrees. The dictionary made here is turned back where
needed, so that corners, boards and drawings all agree with the official print.

A marker's corners, and its side, are those of the square where black meets white all round. In
AprilTag 3's families bits stand outside of that square too, so that a print is larger than its
side; its inside is white in "Standard" and "Custom" families. Cells that a layout leaves open (the
corners round a circle, the middle of tagCustom48h12) stay white in drawings and are never read.

Sources: Olson 2011; Krogius, Haggenmiller & Olson 2019 (layouts of AprilTag 3).

Codes and layouts of AprilTag 3's newer families, from a table of our own.

AprilTag's generator takes codes from an arithmetic sequence modulo 2^bits and keeps those that lie
far enough from all before (Olson, "AprilTag: A robust and flexible visual fiducial system", 2011;
Krogius et al., "Flexible Layouts for Fiducial Tags", 2019), so a family is its first code and how
far each next one lies in that sequence: 158,000 codes in 0.3 MB. A test compares them with the
AprilTag library.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from math import comb
from typing import cast

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import nearest_name

NEWER_FAMILIES: tuple[str, ...] = (
    "tagStandard41h12",
    "tagStandard52h13",
    "tagCircle21h7",
    "tagCircle49h12",
    "tagCustom48h12",
)
STEP = 982_451_653
"""Between neighbours of the sequence that the codes are taken from."""


@dataclass(frozen=True, eq=False)
class AprilTagCodes:
    """What the table of a family says.

    Fields:
        words: ``(n,)`` uint64, the bits of each tag.
        bit_x, bit_y: ``(b,)`` cells from the marker's corner, the highest bit of words first.
        side_cells: along the square where black meets white.
        cells: along the whole print.
        white_inside: whether that square is white within.
    """

    words: NDArray[np.uint64]
    bit_x: IntArray
    bit_y: IntArray
    side_cells: int
    cells: int
    white_inside: bool


@cache
def newer_codes(family: str) -> AprilTagCodes:
    """The table of one of `NEWER_FAMILIES`.

    >>> from motorcade.tracking.markers.families import newer_codes
    >>> codes = newer_codes("tagCircle21h7")
    >>> len(codes.words), codes.cells, hex(codes.words[0])
    (38, 9, '0x157863')
    """
    with (
        as_file(files(__package__) / "apriltag_codes.npz") as path,
        np.load(path, allow_pickle=False) as table,
    ):
        first, steps, bits = (table[f"{family}_{key}"] for key in ("first", "steps", "bits"))
        side_cells, cells, white_inside = table[f"{family}_square"].tolist()
    place = np.concatenate([[0], np.cumsum(steps)]).astype(np.uint64)
    mask = np.uint64(2 ** bits.shape[1] - 1)
    words = (first + np.uint64(STEP) * place) & mask  # uint64 wraps, and the mask divides 2^64
    bit_x, bit_y = bits.astype(np.int64)
    return AprilTagCodes(words, bit_x, bit_y, side_cells, cells, bool(white_inside))


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
OPENCV_FAMILIES: tuple[str, ...] = tuple(_PREDEFINED)
"""Families that OpenCV knows: black squares, all bits inside; ChArUco boards are made of these."""
KALIBR_FAMILY = "tag36h11_border2"
"""AprilTags in a black border two cells wide, as Kalibr prints them."""
APRILTAG_FAMILIES: tuple[str, ...] = (*_OFFICIAL_TOP_ROW, *NEWER_FAMILIES, KALIBR_FAMILY)
FAMILIES: tuple[str, ...] = (*_PREDEFINED, *NEWER_FAMILIES, KALIBR_FAMILY)


@dataclass(frozen=True, eq=False)
class FamilyLayout:
    """Where a family's bits and borders stand, and what its markers' bits are.

    Fields:
        cells: of a whole print, across and down.
        margin: cells from the print's edge to the marker's side.
        white_inside: whether the marker's side has white within and black without.
        blank: ``(cells, cells)`` bool, a print whose bits are all black; True is white.
        known: ``(cells, cells)`` bool, cells that the layout does not leave open.
        bit_rows, bit_columns: ``(b,)`` where the bits stand, the highest of a word first.
        words: ``(n,)`` uint64, the bits of each marker.
        most_wrong: bits that may be read wrong before a marker is not taken for this one.

    >>> from motorcade.tracking.markers.families import layout
    >>> tag = layout("tagStandard41h12")
    >>> tag.cells, tag.side_cells, tag.white_inside, len(tag.bit_rows), len(tag.words)
    (9, 5, True, 41, 2115)
    """

    cells: int
    margin: int
    white_inside: bool
    blank: NDArray[np.bool_]
    known: NDArray[np.bool_]
    bit_rows: IntArray
    bit_columns: IntArray
    words: NDArray[np.uint64]
    most_wrong: int

    @property
    def side_cells(self) -> int:
        """Cells along the marker's side."""
        return self.cells - 2 * self.margin


@cache
def layout(family: str) -> FamilyLayout:
    """A family's layout and words.

    Raises:
        ValueError: an unknown family.
    """
    if family == KALIBR_FAMILY:
        return _opencv_layout(family.partition("_")[0], border=2)
    return _newer_layout(family) if family in NEWER_FAMILIES else _opencv_layout(family)


def _opencv_layout(family: str, border: int = 1) -> FamilyLayout:
    book = dictionary(family)
    size = int(book.markerSize)
    prints = np.stack([_stored_bits(book, marker) for marker in range(len(book.bytesList))])
    rows, columns = np.divmod(np.arange(size * size), size)
    cells = size + 2 * border
    return FamilyLayout(
        cells=cells,
        margin=0,
        white_inside=False,
        blank=np.zeros((cells, cells), bool),
        known=np.ones((cells, cells), bool),
        bit_rows=rows + border,
        bit_columns=columns + border,
        words=words_of(prints.reshape(len(prints), -1)),
        most_wrong=min(_most_wrong(len(prints), size * size), int(book.maxCorrectionBits)),
    )


def _newer_layout(family: str) -> FamilyLayout:
    codes = newer_codes(family)
    cells, margin = codes.cells, (codes.cells - codes.side_cells) // 2
    blank, known = np.ones((cells, cells), bool), np.zeros((cells, cells), bool)
    for ring, white in ((margin, codes.white_inside), (margin - 1, not codes.white_inside)):
        square = _ring(cells, ring)
        blank[square], known[square] = white, True
    rows, columns = codes.bit_y + margin, codes.bit_x + margin
    blank[rows, columns], known[rows, columns] = False, True
    return FamilyLayout(
        cells,
        margin,
        codes.white_inside,
        blank,
        known,
        rows,
        columns,
        codes.words,
        _most_wrong(len(codes.words), len(rows)),
    )


# As the AprilTag library does by default; and how often texture may pass for a marker, of the
# squares with a border all round that it shows.
_MOST_WRONG = 2
_MOST_BY_CHANCE = 0.02


def _most_wrong(count: int, bits: int) -> int:
    """How many bits of a marker may be wrong: fewer where a family's words fill what bits can say.

    A square of random bits is one of `count` words, in one of four turns, up to k wrong bits, with
    a probability of at most 4 count sum(C(bits, i), i <= k) / 2^bits.

    >>> _most_wrong(30, 16), _most_wrong(587, 36)  # tag16h5, tag36h11
    (0, 2)
    """
    chances = np.cumsum([comb(bits, wrong) for wrong in range(_MOST_WRONG + 1)])
    rare = 4.0 * count * chances / 2.0**bits <= _MOST_BY_CHANCE
    return max(int(np.count_nonzero(rare)) - 1, 0)


def _ring(cells: int, inset: int) -> NDArray[np.bool_]:
    """The outermost cells ``(cells, cells)`` of the square that lies `inset` cells within."""
    place = np.minimum(np.arange(cells), np.arange(cells)[::-1])
    ring: NDArray[np.bool_] = np.minimum.outer(place, place) == inset
    return ring


def words_of(bits: NDArray[np.integer] | NDArray[np.bool_]) -> NDArray[np.uint64]:
    """Words ``(*,)`` of bits ``(*, b)``, the highest first.

    >>> import numpy as np
    >>> int(words_of(np.array([1, 0, 1])))
    5
    """
    places = np.arange(bits.shape[-1] - 1, -1, -1).astype(np.uint64)
    return cast("NDArray[np.uint64]", (bits.astype(np.uint64) << places).sum(-1, dtype=np.uint64))


@cache
def dictionary(family: str) -> cv2.aruco.Dictionary:
    """OpenCV's dictionary of a family with every marker the right way up.

    Raises:
        ValueError: a family that OpenCV does not know, or a library whose tags match the official
            print neither upright nor turned by 180 degrees.
    """
    check_family(family)
    if family not in _PREDEFINED:
        raise ValueError(
            f"family: OpenCV does not know {family}; it knows {', '.join(_PREDEFINED)}"
        )
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


def check_family(family: str) -> None:
    """Refuse an unknown family.

    Raises:
        ValueError: naming those that there are.
    """
    if family not in FAMILIES:
        known = f"expected one of {', '.join(FAMILIES)}"
        raise ValueError(f"family: {known}, got {family!r}{nearest_name(family, FAMILIES)}")


def family_size(family: str) -> int:
    """How many markers a family has.

    Raises:
        ValueError: an unknown family.
    """
    check_family(family)
    return len(layout(family).words)


def border_share(family: str) -> float:
    """Width of the border within a marker's side over that side.

    Raises:
        ValueError: an unknown family.
    """
    check_family(family)
    return 1.0 / layout(family).side_cells


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
    """A marker's whole print: ``(cells, cells)`` bool, True is white.

    Raises:
        ValueError: an unknown family, or an id that it does not have.
    """
    check_family(family)
    shape = layout(family)
    if not 0 <= marker_id < len(shape.words):
        raise ValueError(
            f"marker_id: {family} expects 0 to {len(shape.words) - 1}, got {marker_id}"
        )
    cells = shape.blank.copy()
    places = np.arange(len(shape.bit_rows) - 1, -1, -1).astype(np.uint64)
    bits = (shape.words[marker_id] >> places) & np.uint64(1)
    cells[shape.bit_rows, shape.bit_columns] = bits.astype(bool)
    cells.setflags(write=False)
    return cells


def _stored_bits(book: cv2.aruco.Dictionary, marker: int) -> NDArray[np.uint8]:
    rows = book.bytesList[marker : marker + 1]
    return cast(
        "NDArray[np.uint8]", cv2.aruco.Dictionary.getBitsFromByteList(rows, book.markerSize)
    )
