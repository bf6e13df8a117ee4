"""A result that contradicts itself is called doubtful, and is a failure where that is asked for."""

import json
import shutil
from pathlib import Path

import pytest

from motorcade.replays.cli import main

MOSTLY_BRIDGED = ("--set", "camera_poses.blackouts_s=0.2,0.9")


def run(*arguments: object) -> int:
    return main([*map(str, arguments)])


def test_a_doubtful_run_says_so_and_fails_where_strict(
    board_recording: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
) -> None:
    asked = ("run", board_recording, "--out", tmp_path, "--until", "errors")
    assert run(*asked, "--strict") == 0
    assert caplog.messages[-1] == f"done as far as errors; look into {tmp_path}"
    assert run(*asked, *MOSTLY_BRIDGED) == 0
    closing = caplog.messages[-1]
    assert closing.startswith("DOUBTFUL: 14 of 24 frames have no pose (up to 12 may); ")
    assert run(*asked, *MOSTLY_BRIDGED, "--strict") == 1
    assert "the result is doubtful, see above" in capsys.readouterr().err.splitlines()[-1]
    kept = json.loads((tmp_path / "run.json").read_text())
    told = kept["integrity"]["doubts"][0]
    assert told.startswith("14 of 24 frames have no pose (up to 12 may); look at the images")
    assert kept["integrity"]["verdict"] == "doubtful"
    assert (tmp_path / "trajectories" / "smoothed_motor.tum").exists()


def test_of_several_the_doubtful_ones_are_named(
    board_recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = shutil.copytree(board_recording, tmp_path / "other")
    asked = ("run", board_recording, other, "--out", tmp_path / "out", "--until", "errors")
    cached = ("--cache", tmp_path / "cache")
    assert run(*asked, *cached, *MOSTLY_BRIDGED, "--strict") == 1
    last = capsys.readouterr().err.splitlines()[-1]
    assert "2 of 2 results are doubtful" in last


def test_nothing_is_called_sound_that_was_not_judged(
    board_recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ("run", board_recording, "--out", tmp_path, "--until", "fused", "--strict")
    assert run(*asked) == 1
    assert "--strict: expected a run up to integrity" in capsys.readouterr().err
    assert not (tmp_path / "run.json").exists()
