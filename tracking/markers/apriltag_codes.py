"""Codes and layouts of AprilTag 3's newer families, from a table of our own.

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

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import IntArray

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

    >>> from motorcade.tracking.markers.apriltag_codes import newer_codes
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
