"""Printed images: against OpenCV's, against the official tags, and back through the detector."""

import cv2
import numpy as np
import pytest

from motorcade.tracking import Board, CharucoBoard, Checkerboard, MarkerGrid, SingleMarker
from motorcade.tracking.markers.families import dictionary, marker_cells

BOARDS: list[Board] = [
    Checkerboard(9, 6, 0.03),
    MarkerGrid("tag36h11", 4, 3, 0.048, 0.018, first_id=3),
    MarkerGrid("aruco_4x4_50", 5, 3, 0.036, 0.012),
    SingleMarker("tag25h9", 5, 0.105),
    CharucoBoard("aruco_5x5_100", 7, 5, 0.045, 0.035),
]
NEWER: list[Board] = [
    MarkerGrid("tagStandard41h12", 4, 3, 0.03, 0.026, first_id=3),
    MarkerGrid("tagStandard52h13", 3, 2, 0.036, 0.03),
    SingleMarker("tagCircle21h7", 7, 0.1),
    MarkerGrid("tagCircle49h12", 2, 2, 0.04, 0.05),
    MarkerGrid("tagCustom48h12", 3, 2, 0.036, 0.024),  # prints that touch
]
every_board = pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.name)

# Tag 0 of each family, as in the tables of the AprilTag library.
OFFICIAL_CODES = {"tag36h11": (6, 0xD7E00984B), "tag25h9": (5, 0x156F1F4), "tag16h5": (4, 0x27C8)}


def official_print(bits: int, code: int) -> np.ndarray:
    """Lay out a code as the AprilTag library does: triangle after triangle, clockwise."""
    quarter = [(x, y) for y in range(bits // 2) for x in range(y, bits - 1 - y)]
    places = list(quarter)
    for _ in range(3):
        quarter = [(bits - 1 - y, x) for x, y in quarter]
        places += quarter
    if bits % 2 == 1:
        places.append((bits // 2, bits // 2))
    white = np.zeros((bits + 2, bits + 2), bool)
    for position, (x, y) in enumerate(reversed(places)):
        white[y + 1, x + 1] = code >> position & 1
    return white


@pytest.mark.parametrize("family", OFFICIAL_CODES)
def test_apriltags_are_the_official_print(family: str) -> None:
    np.testing.assert_array_equal(marker_cells(family, 0), official_print(*OFFICIAL_CODES[family]))


@pytest.mark.parametrize("family", ["aruco_4x4_50", "aruco_7x7_1000", "tag36h11"])
def test_markers_are_those_of_the_dictionary(family: str) -> None:
    book = dictionary(family)
    side = book.markerSize + 2
    for marker in (0, 7, 49):
        expected = cv2.aruco.generateImageMarker(book, marker, side, borderBits=1) > 0
        np.testing.assert_array_equal(marker_cells(family, marker), expected)


def test_marker_grids_are_opencvs() -> None:
    board = MarkerGrid("aruco_4x4_50", 5, 3, 0.036, 0.012, first_id=4)
    book = dictionary("aruco_4x4_50")
    theirs = cv2.aruco.GridBoard((5, 3), 0.036, 0.012, book, ids=np.arange(4, 19))
    image, origin = board.draw(1000.0)
    left, top = (round(place + 0.5) for place in origin)
    width, height = (round(1000 * side) for side in board.size_m)
    expected = theirs.generateImage((width, height), marginSize=0)
    np.testing.assert_array_equal(image[top : top + height, left : left + width], expected)
    points = np.concatenate(theirs.getObjPoints()) * (1, -1, -1)
    np.testing.assert_allclose(board.points_m, points, atol=1e-7)


@pytest.mark.parametrize("rows", [5, 6])
def test_charuco_boards_are_opencvs(rows: int) -> None:
    board = CharucoBoard("aruco_5x5_100", 7, rows, 0.049, 0.035)
    theirs = cv2.aruco.CharucoBoard((7, rows), 0.049, 0.035, dictionary("aruco_5x5_100"))
    image, origin = board.draw(1000.0)
    left, top = (round(place + 0.5) - 49 for place in origin)
    width, height = (round(1000 * side) for side in board.size_m)
    expected = theirs.generateImage((width, height), marginSize=0)
    ours = image[top : top + height, left : left + width]
    assert np.mean(ours != expected) < 1e-3
    corners = (theirs.getChessboardCorners() - (0.049, 0.049, 0.0)) * (1, -1, -1)
    np.testing.assert_allclose(board.points_m, corners, atol=1e-7)


@every_board
def test_a_drawing_keeps_its_quiet_zone_white_and_its_mean(board: Board) -> None:
    pattern = board.pattern
    areas = np.outer(np.diff(pattern.y_edges_m), np.diff(pattern.x_edges_m))
    np.testing.assert_allclose(areas.sum(), np.prod(board.size_m))
    ink_m2 = areas[~pattern.white].sum()
    for scale in (731.3, 2000.0):
        image, origin = board.draw(scale)
        np.testing.assert_allclose((1 - image / 255.0).sum() / scale**2, ink_m2, rtol=2e-3)
        band = int(pattern.quiet_m * scale) - 1
        assert band > 0
        assert image[:band].min() == image[:, :band].min() == 255
        assert image[-band:].min() == image[:, -band:].min() == 255
        assert 0 < origin[0] < image.shape[1]


def warped(image: np.ndarray, homography: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Warp by a homography of pixel centres, every pixel the mean of 6 x 6 samples."""
    samples = 6
    finer = np.array([[samples, 0, (samples - 1) / 2], [0, samples, (samples - 1) / 2], [0, 0, 1]])
    fine = cv2.warpPerspective(
        image,
        finer @ homography,
        (samples * size[0], samples * size[1]),
        flags=cv2.INTER_LINEAR,
        borderValue=255,
    )
    means = fine.reshape(size[1], samples, size[0], samples).astype(float).mean(axis=(1, 3))
    return np.rint(cv2.GaussianBlur(means, (0, 0), 0.6)).astype(np.uint8)


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("board", [*BOARDS, *NEWER], ids=lambda board: board.name)
@pytest.mark.parametrize("turn_deg", [0.0, 37.0, 180.0])
def test_corners_come_back_from_a_drawing(board: Board, turn_deg: float) -> None:
    scale = 4000.0
    image, origin = board.draw(scale)
    width, height = 640, 480
    turn = cv2.getRotationMatrix2D((image.shape[1] / 2, image.shape[0] / 2), turn_deg, 1.0)
    fit = 0.72 * min(width, height) / max(image.shape)
    place = np.array([[fit, 0.02, 0], [-0.01, fit, 0], [8e-5, -5e-5, 1]])
    homography = place @ np.vstack([turn, [0, 0, 1]])
    centre = homography @ [image.shape[1] / 2, image.shape[0] / 2, 1]
    shift = np.array([width / 2 + 0.37, height / 2 - 0.21]) - centre[:2] / centre[2]
    homography = np.array([[1, 0, shift[0]], [0, 1, shift[1]], [0, 0, 1]]) @ homography
    found = board.detect(warped(image, homography, (width, height)))
    assert found is not None
    assert len(found) >= 0.9 * len(board.points_m)
    printed = np.array(origin) + scale * found.points_m[:, :2] * (1, -1)
    expected = cv2.perspectiveTransform(printed[None], homography)[0]
    error = found.corners_px - expected
    assert np.abs(error.mean(axis=0)).max() < 0.02, "a bias: half-pixel conventions disagree"
    assert np.linalg.norm(error, axis=1).max() < 0.1


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_drawing_at_no_scale_is_refused(scale: float) -> None:
    with pytest.raises(ValueError, match="pixels_per_m"):
        BOARDS[0].draw(scale)
