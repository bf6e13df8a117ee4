"""Boards as labs have them, by Kalibr's files and by names, in every command that takes a board."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.replays.cli import main
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.manifest.section import camera_toml, read_board
from motorcade.tracking import Checkerboard, board_named
from motorcade.tracking.boards import CircleGrid
from motorcade.tracking.boards.names import kalibr_grid
from tests.end_to_end.contradictions.drawing import PINHOLE, sheet_of, write_sheet

TARGETS = {
    "aprilgrid": (
        "target_type: 'aprilgrid' #gridtype\ntagCols: 5\ntagRows: 4 # rows\n"
        "tagSize: 0.05\ntagSpacing: 0.3\n",
        kalibr_grid(5, 4, 0.05, 0.015),
    ),
    "checkerboard": (
        "target_type: 'checkerboard'\ntargetCols: 6\ntargetRows: 7\n"
        "rowSpacingMeters: 0.06\ncolSpacingMeters: 0.06\n",
        Checkerboard(6, 7, 0.06),
    ),
    "circlegrid": (
        "target_type: 'circlegrid'\ntargetCols: 4\ntargetRows: 7\n"
        "spacingMeters: 0.03\nasymmetricGrid: True\n",
        CircleGrid(4, 7, 0.03, 0.015, asymmetric=True),
    ),
}


def target(folder: Path, kind: str) -> Path:
    path = folder / "target.yaml"
    path.write_text(TARGETS[kind][0])
    return path


@pytest.mark.parametrize("kind", TARGETS)
def test_kalibr_s_targets_are_boards(kind: str, tmp_path: Path) -> None:
    board = read_board(str(target(tmp_path, kind)))
    assert board == TARGETS[kind][1]
    assert board_named(board.name) == board


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("tagCols: 5", "tagCols: 5.5", "tagCols and tagRows"),
        ("tagSize: 0.05", "tagSize: wide", "tagSize"),
        ("'aprilgrid'", "'apriltag'", "target_type"),
        ("tagRows: 4", "tagRows: 400", "aprilgrid"),
    ],
)
def test_what_is_wrong_in_a_target_is_named(old: str, new: str, field: str, tmp_path: Path) -> None:
    path = target(tmp_path, "aprilgrid")
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(RecordingError, match=field):
        read_board(str(path))


@pytest.mark.parametrize("kind", ["aprilgrid", "circlegrid"])
def test_detect_and_print_take_a_board(kind: str, tmp_path: Path, capsys) -> None:
    path, board = target(tmp_path, kind), TARGETS[kind][1]
    drawn = write_sheet(tmp_path / "seen", sheet_of(board), PINHOLE, np.random.default_rng(8), 2)
    (tmp_path / "camera.toml").write_text(camera_toml(PINHOLE))
    images = sorted(map(str, (drawn.folder / "images").iterdir()))
    asked = ["detect", *images, "--board", str(path), "--camera", str(tmp_path / "camera.toml")]
    assert main([*asked, "--json", "--draw", str(tmp_path / "drawn")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["board"] == board.name
    for image in found["images"]:
        assert len(image["corners"]) >= 0.9 * len(board.points_m)
        assert image["reprojection_rmse_px"] < 0.2
        assert 0.1 < image["camera_T_board"]["translation_m"][2] < 2.0
    assert cv2.imread(str(tmp_path / "drawn" / "0000.png")) is not None
    assert main(["print", str(path), "-o", str(tmp_path / "sheet.pdf"), "--paper", "a2"]) == 0
    assert read_board(str(tmp_path / "sheet.toml")) == board
