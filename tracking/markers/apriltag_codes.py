"""Codes and layouts of AprilTag 3's families, read from the AprilTag library.

The library lists each family as a table of words with the places of their bits. Its Python wrapper
shows none of that, and its detector would spend gigabytes on the larger families, so the tables
alone are copied out of it.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache
from pathlib import Path

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


@dataclass(frozen=True, eq=False)
class AprilTagCodes:
    """What the library's table of a family says.

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


class _Family(ctypes.Structure):
    """``apriltag_family_t`` of AprilTag 3."""

    _fields_ = [
        ("count", ctypes.c_uint32),
        ("codes", ctypes.POINTER(ctypes.c_uint64)),
        ("side_cells", ctypes.c_int),
        ("cells", ctypes.c_int),
        ("white_inside", ctypes.c_bool),
        ("bits", ctypes.c_uint32),
        ("bit_x", ctypes.POINTER(ctypes.c_int32)),
        ("bit_y", ctypes.POINTER(ctypes.c_int32)),
    ]


@cache
def newer_codes(family: str) -> AprilTagCodes:
    """The table of one of `NEWER_FAMILIES`.

    Raises:
        RuntimeError: a library without it, or with another layout of its tables.
    """
    library = _library()
    try:
        make, free = getattr(library, f"{family}_create"), getattr(library, f"{family}_destroy")
    except AttributeError as missing:
        raise RuntimeError(f"the AprilTag library installed here lacks {family}") from missing
    make.restype = ctypes.POINTER(_Family)
    free.argtypes = [ctypes.POINTER(_Family)]
    pointer = make()
    table: _Family = pointer.contents
    try:
        if table.bits > 64 or f"{table.bits}h" not in family or table.count > 2**20:
            raise RuntimeError(f"the AprilTag library installed here lays {family} out otherwise")
        return AprilTagCodes(
            words=np.array(table.codes[: table.count], np.uint64),
            bit_x=np.array(table.bit_x[: table.bits], np.int64),
            bit_y=np.array(table.bit_y[: table.bits], np.int64),
            side_cells=table.side_cells,
            cells=table.cells,
            white_inside=table.white_inside,
        )
    finally:
        free(pointer)


@cache
def _library() -> ctypes.CDLL:
    import pupil_apriltags

    folder = Path(pupil_apriltags.__file__).parent
    libraries = sorted(folder.glob("lib*/libapriltag*.so")) + sorted(
        folder.glob("lib*/*apriltag*.d*")
    )
    if not libraries:
        raise RuntimeError(f"{folder}: expected the AprilTag library in it, found none")
    return ctypes.CDLL(str(libraries[0]))
