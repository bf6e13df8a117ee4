"""A board described wrongly is told of: too few or too many corners, lengths not in metres."""

import logging

import cv2
import numpy as np
import pytest

from motorcade.replays.stages.camera.board_poses import warn_of_size
from motorcade.tracking import Checkerboard
from motorcade.tracking.targets import compare_layout

PRINTED = Checkerboard(9, 6, 0.03)
WARP = np.array([[0.9, 0.15, 40.0], [-0.1, 0.85, 60.0], [2e-4, 3e-4, 1.0]])


def picture() -> np.ndarray:
    """The print seen askew on a grey table."""
    drawn, _ = PRINTED.draw(1000.0)
    grey = cv2.warpPerspective(drawn, WARP, (480, 360), borderValue=(120.0,))
    return cv2.GaussianBlur(grey, (0, 0), 0.8)


@pytest.mark.parametrize(("columns", "rows"), [(8, 6), (9, 5), (8, 5), (9, 7), (10, 6), (10, 7)])
def test_a_board_of_another_count_is_named_with_its_mend(columns: int, rows: int) -> None:
    finding = compare_layout(Checkerboard(columns, rows, 0.03), [picture()] * 3)
    assert finding is not None
    assert finding.verdict == "contradicted"
    assert f"looks like 9 x 6 inner corners, not {columns} x {rows}" in finding.sentence
    assert finding.advice == "say columns = 9, rows = 6"


@pytest.mark.parametrize("stated", [PRINTED, Checkerboard(6, 9, 0.03)])
def test_a_board_of_the_right_count_is_not_doubted(stated: Checkerboard) -> None:
    finding = compare_layout(stated, [picture()] * 3)
    assert finding is not None
    assert finding.verdict == "consistent", finding.sentence


def test_a_board_whose_end_is_never_in_view_is_not_counted() -> None:
    cut = picture()[:, :300].copy()
    finding = compare_layout(Checkerboard(8, 6, 0.03), [cut] * 3)
    assert finding is not None
    assert finding.verdict == "unknown", finding.sentence


def test_lengths_that_are_hardly_metres_are_told_of(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "motorcade"):
        warn_of_size(Checkerboard(9, 6, 0.04))
        assert caplog.messages == []
        warn_of_size(Checkerboard(9, 6, 40.0))
    (message,) = caplog.messages
    assert "400 x 280 m large; are its lengths in metres?" in message
