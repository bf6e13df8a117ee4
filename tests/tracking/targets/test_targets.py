"""Targets that nobody named: found in exact renderings and photographs, and nowhere else."""

from pathlib import Path

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
)
from motorcade.tracking.targets import SeenMarkers, find_target
from motorcade.tracking.targets.chessboards import checkerboard_seen
from motorcade.tracking.targets.families import families_seen
from motorcade.tracking.targets.layouts import board_of_markers

VIEWS = [(0.0, 0.0, 0.0), (25.0, 0.0, 5.0), (30.0, 120.0, -20.0), (20.0, 240.0, 90.0)]
BOARDS: list[Board] = [
    Checkerboard(9, 6, 0.03),
    Checkerboard(7, 7, 0.03),
    Checkerboard(5, 4, 0.03),
    MarkerGrid("tag36h11", 4, 3, 0.05, 0.015),
    MarkerGrid("tag16h5", 3, 3, 0.05, 0.02),
    MarkerGrid("tag25h9", 5, 2, 0.05, 0.02, first_id=5),
    MarkerGrid("aruco_4x4_50", 5, 3, 0.04, 0.01),
    MarkerGrid("aruco_6x6_50", 2, 2, 0.04, 0.03, first_id=11),
    MarkerGrid("tagStandard41h12", 3, 2, 0.05, 0.05),
    CharucoBoard("aruco_5x5_50", 7, 5, 0.04, 0.028),
    CharucoBoard("aruco_4x4_50", 6, 8, 0.04, 0.03),
]


def images_of(board: Board, camera: Camera, render, look_at) -> list[np.ndarray]:
    far = 1.9 * max(board.size_m)
    return [
        render(board, camera, look_at(board, far, *view), noise=2.0, seed=number)
        for number, view in enumerate(VIEWS)
    ]


def in_units(board: Board) -> Board:
    """The same with squares, or sides of bare markers, of length 1."""
    if isinstance(board, MarkerGrid):
        gap = board.gap_m / board.marker_m
        return MarkerGrid(board.family, board.columns, board.rows, 1.0, gap, board.first_id)
    if isinstance(board, CharucoBoard):
        share = board.marker_m / board.square_m
        return CharucoBoard(board.family, board.columns, board.rows, 1.0, share)
    assert isinstance(board, Checkerboard)
    return Checkerboard(board.columns, board.rows, 1.0)


@pytest.mark.quick_every(4)
@pytest.mark.parametrize("board", BOARDS, ids=[board.name for board in BOARDS])
def test_a_board_is_found_with_its_counts_and_shares(
    board: Board, straight_camera: Camera, render, look_at
) -> None:
    found = find_target(images_of(board, straight_camera, render, look_at))
    assert found is not None
    assert found.board is not None
    wanted = in_units(board)
    assert type(found.board) is type(wanted)
    for name in vars(wanted):
        if name.endswith("_m"):
            assert getattr(found.board, name) == pytest.approx(getattr(wanted, name), rel=0.02)
        elif name in ("family", "columns", "rows", "first_id"):
            assert getattr(found.board, name) == getattr(wanted, name)
    assert len(found.images) >= 3


def test_a_marker_alone_of_a_small_family_is_found_if_several_images_show_it(
    straight_camera: Camera, render, look_at
) -> None:
    marker = SingleMarker("aruco_4x4_50", 3, 0.1)
    shown = images_of(marker, straight_camera, render, look_at)
    found = find_target(shown)
    assert found is not None
    assert (found.board, found.family, found.marker_ids) == (None, "aruco_4x4_50", (3,))
    assert find_target(shown[:1]) is None  # one image alone may show it by chance


@pytest.mark.slow
def test_texture_holds_no_family() -> None:
    rng = np.random.default_rng(3)
    for size in (12, 24, 48):  # squares of random bits, as a marker's worst likeness
        blocks = rng.integers(0, 2, (480 // size, 640 // size)).astype(np.uint8) * 200 + 25
        image = np.kron(blocks, np.ones((size, size), np.uint8))
        shifted = [np.roll(image, 3 * step, axis=1) for step in range(4)]
        assert families_seen(shifted) == ()
        assert find_target(shifted) is None


def test_ids_in_no_order_make_up_no_board() -> None:
    print_ = MarkerGrid("tag36h11", 4, 3, 0.05, 0.02)
    corners = 2000.0 * print_.points_m[:, :2].reshape(-1, 4, 2) * [1.0, -1.0]
    serpentine = np.arange(12).reshape(3, 4)
    serpentine[1] = serpentine[1, ::-1]
    for ids in (serpentine.ravel(), np.random.default_rng(1).permutation(12)):
        order = np.argsort(ids)
        assert board_of_markers("tag36h11", [SeenMarkers(ids[order], corners[order])]) is None


def test_a_board_that_is_partly_hidden_is_counted_where_it_is_whole(
    straight_camera: Camera, render, look_at
) -> None:
    board = Checkerboard(8, 5, 0.03)
    shown = images_of(board, straight_camera, render, look_at)
    for image in shown[2:]:
        image[:, : image.shape[1] // 2] = 120
    counted = checkerboard_seen(shown)
    assert counted is not None
    assert (counted.columns, counted.rows, counted.images) == (8, 5, (0, 1))


PHOTOGRAPHS = {  # what of them is known otherwise: AprilTag's own reference, or nothing to find
    "tags/multi/*.png": ("tag36h11", 6),
    "tags/rotations/*.png": ("tag36h11", 1),
    "tags/photos/*.jpg": ("tag36h11", 1),
    "replays/kitti_short/image_l/*0.png": None,
    "replays/7scenes_redkitchen/*0.color.jpg": None,
    "replays/euroc_V1_01/mav0/cam0/data/*.png": (None, 42),  # a small checkerboard on the wall
}


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("pattern", PHOTOGRAPHS)
def test_photographs_show_what_is_in_them_and_nothing_else(pattern: str, data_dir: Path) -> None:
    files = sorted(data_dir.glob(pattern))[:20]
    if not files:
        pytest.skip(f"no {pattern} below {data_dir}; set MOTORCADE_DATA")
    found = find_target([cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in files])
    points = 0 if found is None or found.board is None else len(found.board.points_m)
    assert (found and (found.family, len(found.marker_ids) or points)) == PHOTOGRAPHS[pattern]
