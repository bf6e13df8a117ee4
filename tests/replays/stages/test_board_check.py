"""A board described wrongly is told of: too few or too many corners, lengths not in metres."""

import logging
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.replays.stages.camera.board_audit import audited_board
from motorcade.replays.stages.camera.board_poses import warn_of_contradictions, warn_of_size
from motorcade.tracking import Checkerboard, MarkerGrid
from motorcade.tracking.boards.checkerboard import extent_in_picture, extent_seen
from motorcade.tracking.measurements import MarkerObservation

PRINTED = Checkerboard(9, 6, 0.03)
WARP = np.array([[0.9, 0.15, 40.0], [-0.1, 0.85, 60.0], [2e-4, 3e-4, 1.0]])


def picture() -> tuple[np.ndarray, np.ndarray]:
    """The print seen askew on a grey table, and its corners (6, 9, 2) in the picture."""
    drawn, first = PRINTED.draw(1000.0)
    flat = PRINTED.points_m[:, :2] * [1000.0, -1000.0] + first
    corners = cv2.perspectiveTransform(flat[None], WARP)[0].reshape(6, 9, 2)
    grey = cv2.warpPerspective(drawn, WARP, (480, 360), borderValue=(120.0,))
    return cv2.GaussianBlur(grey, (0, 0), 0.8), corners


def observed(ids: np.ndarray, corners: np.ndarray) -> MarkerObservation:
    return MarkerObservation(7, ids, corners, Motor.identity((2,)), np.array([0.1, 0.2]))


def told(board: Any, observation: MarkerObservation, caplog: pytest.LogCaptureFixture) -> list[str]:
    frame = SimpleNamespace(time_ns=7, gray=lambda: picture()[0])
    recording: Any = SimpleNamespace(frames=[frame], camera=None)
    tracked: Any = SimpleNamespace(observations=(observation,))
    with caplog.at_level(logging.WARNING, "motorcade"):
        warn_of_contradictions(audited_board(recording, board, tracked)[0])
    return caplog.messages


@pytest.mark.parametrize(
    ("rows", "columns", "looks"),
    [
        (slice(0, 6), slice(0, 9), (9, 6)),
        (slice(0, 6), slice(0, 8), (9, 6)),
        (slice(0, 6), slice(1, 9), (9, 6)),
        (slice(0, 5), slice(0, 9), (9, 6)),
        (slice(1, 6), slice(0, 9), (9, 6)),
        (slice(1, 5), slice(0, 8), (9, 5)),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_a_print_that_goes_on_is_seen(
    rows: slice, columns: slice, looks: tuple[int, int], turned: bool
) -> None:
    grey, corners = picture()
    part = corners[rows, columns]
    part = part[::-1, ::-1] if turned else part
    board = Checkerboard(part.shape[1], part.shape[0], 0.03)
    assert extent_in_picture(board, grey, part.reshape(-1, 2)) == looks


def test_the_picture_s_edge_is_no_further_line() -> None:
    grey, corners = picture()
    cut = grey[:, : int(corners[:, 8, 0].min()) - 2].copy()
    board = Checkerboard(8, 6, 0.03)
    assert extent_in_picture(board, cut, corners[:, :8].reshape(-1, 2)) == (8, 6)


def test_a_line_that_is_never_seen_is_not_there() -> None:
    ids = np.arange(7 * 9).reshape(7, 9)
    corners = np.zeros((63, 2))
    short = np.append(ids[:6].ravel(), 57)  # one corner of the seventh row by chance
    board = Checkerboard(9, 7, 0.03)
    assert extent_seen(board, [observed(short, corners[short])]) == (9, 6)
    right = ids[:, 1:].ravel()
    assert extent_seen(board, [observed(right, corners[right])]) == (8, 7)
    both = [observed(short, corners[short]), observed(right, corners[right])]
    assert extent_seen(board, both) == (9, 7)


def test_a_wrong_board_is_told_of_and_a_right_one_is_not(caplog: pytest.LogCaptureFixture) -> None:
    corners = picture()[1]
    whole = observed(np.arange(54), corners.reshape(-1, 2))
    assert told(PRINTED, whole, caplog) == []
    assert told(MarkerGrid("tag36h11", 4, 3, 0.05, 0.015), whole, caplog) == []
    short = observed(np.arange(48), corners[:, :8].reshape(-1, 2))
    (message,) = told(Checkerboard(8, 6, 0.03), short, caplog)
    assert "looks like 9 x 6 inner corners, not 8 x 6" in message
    caplog.clear()
    (message,) = told(Checkerboard(9, 7, 0.03), whole, caplog)
    assert "looks like 9 x 6 inner corners, not 9 x 7" in message


def test_lengths_that_are_hardly_metres_are_told_of(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "motorcade"):
        warn_of_size(Checkerboard(9, 6, 0.04))
        assert caplog.messages == []
        warn_of_size(Checkerboard(9, 6, 40.0))
    (message,) = caplog.messages
    assert "400 x 280 m large; are its lengths in metres?" in message
