"""Parts of a board: corners keep their numbers, or are left out."""

import numpy as np
import pytest

from motorcade.tracking import Board, Camera, Checkerboard
from motorcade.tracking.targets import corners_in_view

BOARDS = [Checkerboard(8, 5, 0.03), Checkerboard(9, 7, 0.03), Checkerboard(6, 6, 0.03)]


def off_px(board: Checkerboard, ids: np.ndarray, px: np.ndarray, true_px: np.ndarray) -> float:
    """How far corners lie from their true places, under the best turn that the print allows."""
    return float(min(np.abs(true_px[turn[ids]] - px).max() for turn in board.turns))


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("board", BOARDS, ids=[board.name for board in BOARDS])
def test_a_board_that_slides_out_of_the_image_is_never_shifted_by_squares(
    board: Checkerboard, straight_camera: Camera, render, look_at
) -> None:
    rng = np.random.default_rng(731)
    used = 0
    for share in (0.0, 0.2, 0.35, 0.5):
        tilt, azimuth, roll = rng.uniform((5.0, 0.0, -30.0), (30.0, 360.0, 30.0))
        pose = look_at(board, 1.9 * max(board.size_m), tilt, azimuth, roll)
        image = render(board, straight_camera, pose, noise=2.0, seed=int(1000 * share))
        true_px = straight_camera.project(pose.inverse().apply(board.points_m))
        low = np.quantile(true_px[:, 0], share)
        from_px = int(low) if share else 0
        part = corners_in_view(board, image[:, from_px:])
        if part is not None:
            used += 1
            shifted = part.corners_px + np.array([from_px, 0.0])
            assert off_px(board, part.ids, shifted, true_px) < 0.5
    assert used >= 2


def test_a_part_that_is_open_on_both_sides_has_no_place(
    straight_camera: Camera, render, look_at
) -> None:
    board: Board = Checkerboard(11, 5, 0.03)
    image = render(board, straight_camera, look_at(board, 0.6, 15.0, 40.0), noise=2.0)
    assert corners_in_view(Checkerboard(11, 5, 0.03), image[:, 150:330]) is None
