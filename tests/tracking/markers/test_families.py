"""AprilTag 3's families, against what the AprilTag library itself draws and finds."""

import ctypes
import subprocess
import sys
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pupil_apriltags
import pytest

from motorcade.tracking import CharucoBoard, MarkerGrid, SingleMarker
from motorcade.tracking.markers import detect_markers
from motorcade.tracking.markers.families import (
    NEWER_FAMILIES,
    family_size,
    layout,
    marker_cells,
    newer_codes,
)
from motorcade.tracking.markers.native._quads import Words
from tests.bench.tracking.tag_markers import apriltag_detector


class Image(ctypes.Structure):
    _fields_ = [
        ("width", ctypes.c_int),
        ("height", ctypes.c_int),
        ("stride", ctypes.c_int),
        ("buf", ctypes.POINTER(ctypes.c_uint8)),
    ]


class Family(ctypes.Structure):
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
def _library() -> ctypes.CDLL:
    folder = Path(pupil_apriltags.__file__).parent
    return ctypes.CDLL(str(sorted(folder.glob("lib*/libapriltag*.so"))[0]))


@pytest.mark.parametrize("family", NEWER_FAMILIES)
def test_every_code_is_the_librarys(family: str) -> None:
    make = getattr(_library(), f"{family}_create")
    make.restype = ctypes.POINTER(Family)
    theirs, ours = make().contents, newer_codes(family)
    np.testing.assert_array_equal(ours.words, np.array(theirs.codes[: theirs.count], np.uint64))
    np.testing.assert_array_equal(ours.bit_x, theirs.bit_x[: theirs.bits])
    np.testing.assert_array_equal(ours.bit_y, theirs.bit_y[: theirs.bits])
    assert ours.side_cells == theirs.side_cells
    assert ours.cells == theirs.cells
    assert ours.white_inside == theirs.white_inside


def official_print(family: str, marker: int) -> np.ndarray:
    """What the library draws; cells that a layout leaves open are black there."""
    library = _library()
    make, draw = getattr(library, f"{family}_create"), library.apriltag_to_image
    make.restype, draw.restype = ctypes.c_void_p, ctypes.POINTER(Image)
    draw.argtypes = [ctypes.c_void_p, ctypes.c_uint32]
    made = draw(make(), marker).contents
    rows = np.ctypeslib.as_array(made.buf, (made.height, made.stride))
    return rows[:, : made.width] > 0


@pytest.mark.parametrize("family", NEWER_FAMILIES)
def test_prints_are_the_librarys(family: str) -> None:
    known = layout(family).known
    for marker in (0, 17, family_size(family) - 1):
        expected = official_print(family, marker)
        np.testing.assert_array_equal(marker_cells(family, marker)[known], expected[known])
    assert marker_cells(family, 0)[~known].all()


@pytest.mark.parametrize("family", ["tagStandard41h12", "tagCircle21h7"])  # the others' take long
def test_the_library_finds_the_same_corners_in_a_drawing(family: str) -> None:
    board = MarkerGrid(family, 3, 2, 0.04, 0.05, first_id=4)
    image, origin = board.draw(1500.0)
    image = cv2.GaussianBlur(image, (0, 0), 0.8)
    theirs = {one.tag_id: one.corners for one in apriltag_detector(family).detect(image)}
    ours = {one.marker_id: one.corners_px for one in detect_markers(image, family)}
    assert sorted(ours) == sorted(theirs) == list(range(4, 10))
    printed = origin + 1500.0 * board.points_m[:, :2].reshape(6, 4, 2) * (1, -1)
    for row, marker in enumerate(board.marker_ids):
        assert np.abs(ours[marker] - printed[row]).max() < 0.1
        # The library lists corners of tags that are white inside from another one.
        gaps = np.linalg.norm((theirs[marker] - 0.5)[:, None] - ours[marker], axis=-1)
        assert gaps.min(axis=1).max() < 1.0


@pytest.mark.parametrize("family", NEWER_FAMILIES)
@pytest.mark.parametrize("turns", [0, 1, 3])
def test_two_wrong_bits_are_corrected_and_three_are_not(family: str, turns: int) -> None:
    shape, marker = layout(family), 23
    rng = np.random.default_rng(turns)
    for wrong in (1, 2, 3):
        cells = marker_cells(family, marker).copy()
        bits = rng.choice(len(shape.bit_rows), wrong, replace=False)
        cells[shape.bit_rows[bits], shape.bit_columns[bits]] ^= True
        drawn = np.kron(np.pad(cells, 2, constant_values=True), np.full((9, 9), 200, np.uint8))
        image = cv2.GaussianBlur(np.rot90(drawn, turns) + np.uint8(20), (0, 0), 0.8)
        found = detect_markers(image, family)
        assert [one.marker_id for one in found] == ([marker] if wrong < 3 else [])
        assert all(one.wrong_cells == wrong for one in found)


@pytest.mark.parametrize("bits", [16, 21, 41, 64])
def test_words_are_those_of_a_plain_search(bits: int, rng: np.random.Generator) -> None:
    words = rng.integers(0, 2**bits, 300, np.uint64, endpoint=False) if bits < 64 else None
    if words is None:
        words = rng.integers(0, 2**64, 300, np.uint64)
    flips = np.array([sum(1 << int(k) for k in rng.choice(bits, n, False)) for n in (0, 1, 2, 3)])
    seen = (words[:40, None] ^ flips.astype(np.uint64)).ravel()
    apart = np.bitwise_count(seen[:, None] ^ words).min(axis=1)
    for most in (0, 1, 2):
        ids, wrong = Words(words, bits).match(seen, most)
        np.testing.assert_array_equal(wrong, np.minimum(apart, most + 1))
        np.testing.assert_array_equal(ids >= 0, apart <= most)
        known = ids >= 0
        np.testing.assert_array_equal(
            np.bitwise_count(seen[known] ^ words[ids[known]]), wrong[known]
        )


_ALL_FAMILIES = """
import resource
import numpy as np
from motorcade.tracking.markers import FAMILIES, detect_markers
image = np.random.default_rng(0).integers(0, 256, (120, 160)).astype(np.uint8)
detect_markers(image, "tag36h11")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for family in FAMILIES:
    detect_markers(image, family)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""


@pytest.mark.slow
def test_all_families_together_take_little_memory() -> None:
    """The library's own table of misreadings takes gigabytes for tagStandard52h13 alone."""
    done = subprocess.run([sys.executable, "-c", _ALL_FAMILIES], capture_output=True, check=True)
    assert float(done.stdout) < 100.0  # MiB


def test_what_a_layout_does_not_allow_is_refused() -> None:
    with pytest.raises(ValueError, match=r"gap_m: tagStandard41h12 .* at least 0\.08 m"):
        MarkerGrid("tagStandard41h12", 2, 2, 0.1, 0.07)
    MarkerGrid("tagStandard41h12", 2, 2, 0.1, 0.08)
    with pytest.raises(ValueError, match="OpenCV does not know tagCircle21h7"):
        CharucoBoard("tagCircle21h7", 4, 3, 0.04, 0.03)
    with pytest.raises(ValueError, match="tagCircle21h7 expects 0 to 37, got 38"):
        SingleMarker("tagCircle21h7", 38, 0.1)
