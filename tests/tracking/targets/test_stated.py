"""What is stated of a board against images of it: each contradiction is named with its mend."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from motorcade.tracking import (
    Board,
    Camera,
    CharucoBoard,
    Checkerboard,
    MarkerGrid,
    SingleMarker,
    TrackingError,
    track_board,
)
from motorcade.tracking.targets import SeenMarkers, find_target
from motorcade.tracking.targets.layouts import layout_fits
from motorcade.tracking.targets.stated import compare_layout, name_target

GRID = MarkerGrid("tag36h11", 4, 3, 0.06, 0.018, first_id=5)
CHARUCO = CharucoBoard("aruco_5x5_50", 7, 6, 0.04, 0.028)
APRILGRID = MarkerGrid("tag36h11_border2", 4, 3, 0.06, 0.018, 0, "up", 0, True)
CAMERA = Camera(480, 360, 420.0, 420.0, 239.5, 179.5)


def images(board: Board, count: int = 3) -> list[np.ndarray]:
    """A print on a grey table, seen askew, in noise."""
    rng = np.random.default_rng(11)
    drawn, _ = board.draw(1200.0)
    height, width = drawn.shape
    shown = []
    for _ in range(count):
        corners = np.array([[40, 30], [440, 30], [440, 330], [40, 330]]) + rng.uniform(
            0, 45, (4, 2)
        )
        outline = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
        warp = cv2.getPerspectiveTransform(outline, corners.astype(np.float32))
        grey = cv2.warpPerspective(drawn, warp, (480, 360), flags=cv2.INTER_AREA, borderValue=120.0)
        noisy = cv2.GaussianBlur(grey, (0, 0), 0.8) + 2.0 * rng.standard_normal(grey.shape)
        shown.append(np.clip(noisy, 0, 255).astype(np.uint8))
    return shown


CONTRADICTIONS: list[tuple[Board, Board, str]] = [  # printed, stated, what names the mend
    (replace(GRID, order="up"), GRID, 'from the bottom row, not downwards; say order = "up"'),
    (GRID, replace(GRID, order="up"), 'from the top row, not upwards; say order = "down"'),
    (GRID, replace(GRID, columns=3, rows=4), "4 by 3, not 3 by 4; say columns = 4, rows = 3"),
    (replace(GRID, turned_deg=180), GRID, "not by 0°; say turned_deg = 180"),
    (replace(GRID, first_id=7), GRID, "ids count from 7, not from 5; say first_id = 7"),
    (GRID, replace(GRID, gap_m=0.03), "you say a gap of 30 mm; the tags stand 18."),
    (replace(CHARUCO, legacy=True), CHARUCO, "a legacy ChArUco board; say legacy = true"),
    (CHARUCO, replace(CHARUCO, legacy=True), "no legacy one; say legacy = false"),
    (CHARUCO, replace(CHARUCO, marker_m=0.024), "the squares say 28."),
]  # fmt: skip


@pytest.mark.parametrize(("printed", "stated", "mend"), CONTRADICTIONS)
def test_a_contradiction_is_named_with_its_mend(printed: Board, stated: Board, mend: str) -> None:
    shown = images(printed)
    found = compare_layout(stated, shown)
    assert found is not None
    assert found.verdict == "contradicted"
    assert mend in found.sentence
    as_printed = compare_layout(printed, shown)
    assert as_printed is not None
    assert as_printed.verdict == "consistent", as_printed.sentence


@pytest.mark.parametrize(
    "board", [APRILGRID, replace(GRID, turned_deg=90), MarkerGrid("aruco_4x4_50", 5, 3, 0.05, 0.01)]
)
def test_a_board_that_is_as_stated_is_not_doubted(board: MarkerGrid) -> None:
    found = compare_layout(board, images(board))
    assert found is not None
    assert found.verdict == "consistent", found.sentence


@pytest.mark.parametrize("board", [GRID, SingleMarker("tag36h11", 7, 0.1)])
def test_a_board_whose_markers_stand_there_twice_is_doubted(board: MarkerGrid) -> None:
    print_ = cv2.GaussianBlur(board.draw(pixels_per_m=800.0)[0], (0, 0), 0.6)
    once, twice = np.pad(print_, 20, constant_values=200), np.hstack([print_, print_])
    for shown, doubted in (([once] * 4, False), ([once, twice, twice, once], True)):
        finding = compare_layout(board, shown)
        assert (finding is not None and not finding.passed) == doubted
        assert not doubted or "stand twice in images" in finding.sentence  # type: ignore[union-attr]


def test_four_markers_of_which_three_stand_on_a_line_deny_no_layout() -> None:
    board = MarkerGrid("tag36h11", 3, 3, 0.05, 0.014)
    corners = 900.0 * board.points_m[:, :2].reshape(-1, 4, 2) * [1.0, -1.0]
    row = [0, 3, 6, 7]
    assert layout_fits(board, [SeenMarkers(np.array(row), corners[row])]) == []


def test_of_few_markers_nothing_is_told() -> None:
    few = MarkerGrid("tag36h11", 3, 1, 0.05, 0.02)
    found = compare_layout(few, images(few, 1))
    assert found is not None
    assert found.verdict == "unknown"
    of_corners = compare_layout(Checkerboard(5, 4, 0.03), images(few, 1))
    assert of_corners is not None
    assert of_corners.verdict == "unknown"


def test_rows_for_columns_end_no_tracking_with_a_number_that_is_none() -> None:
    stated = replace(GRID, columns=3, rows=4)
    stamped = [(40_000_000 * row, shown) for row, shown in enumerate(images(GRID, 6))]
    try:
        track = track_board(stamped, CAMERA, stated)
    except TrackingError:
        return
    assert all(np.isfinite(one.candidate_error_px).all() for one in track.observations)


def test_kalibr_s_grid_is_found_whole() -> None:
    for shown in images(APRILGRID):
        seen = APRILGRID.detect(shown)
        assert seen is not None
        assert len(seen) == len(APRILGRID.points_m)
    target = find_target(images(APRILGRID))
    assert target is not None
    assert target.family == APRILGRID.family


def test_what_is_seen_instead_of_a_board_is_named() -> None:
    shown = images(GRID)
    others = (replace(GRID, family="tag25h9"), replace(GRID, family=APRILGRID.family))
    for stated in (*others, SingleMarker("tag25h9", 3, 0.1), "tag25h9"):
        text = name_target(shown, stated)
        assert "4 x 3 markers tag36h11" in text
        assert text.endswith('say family = "tag36h11"')
    keys = 'say type = "marker_grid", family = "tag36h11", columns = 4, rows = 3, first_id = 5'
    assert keys in name_target(shown, CHARUCO)
    assert name_target([np.full((360, 480), 120, np.uint8)], GRID) == ""


def test_mirrored_images_are_named() -> None:
    mirrored = [np.ascontiguousarray(image[:, ::-1]) for image in images(GRID)]
    assert "the images are mirrored" in name_target(mirrored, GRID)
    assert "mirror them back, left to right" in name_target(mirrored, "tag36h11")
