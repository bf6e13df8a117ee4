"""Progress: bars with rate and remaining time on a terminal, lines elsewhere."""

import io
import logging
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, progress
from motorcade.replays.cli.main import _Lines, _Once
from motorcade.replays.io.readers.tables import read_table
from motorcade.tracking import Camera, Checkerboard, self_calibrate_board
from motorcade.tracking.boards import BoardCorners


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def shown(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """Make standard error a terminal, with bars that show at once."""
    made = Terminal()
    monkeypatch.setattr(sys, "stderr", made)
    monkeypatch.setattr(progress, "DELAY_S", 0.0)
    monkeypatch.setattr(progress, "_TICK_S", 0.02)
    return made


class Clock:
    """Time that passes when a test says so."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 100.0
        monkeypatch.setattr(progress.time, "monotonic", lambda: self.now_s)
        progress._lines.begin()


def slowly(count: int) -> list[int]:
    return [time.sleep(0.03) or k for k in progress.track(range(count), "walking", count)]


def test_a_loop_tells_its_rate_and_what_remains(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = shown(monkeypatch)

    def steps():
        for k in range(8):
            time.sleep(0.05)
            yield k

    assert list(progress.track(steps(), "walking", 8)) == list(range(8))
    told = terminal.getvalue()
    assert "walking:" in told
    assert "/8 [" in told
    assert "it/s]" in told
    assert "<00:00" in told


def test_a_loop_tells_in_lines_what_remains_where_there_is_no_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = Clock(monkeypatch)
    for letter in progress.track("abcd", "cells", 4):
        clock.now_s += {"a": 2.0, "b": 4.0, "c": 1.0, "d": 6.0}[letter]
    assert capsys.readouterr().err == "cells: 3 of 4, 75 %, 0:02 left\n"


def test_nobody_waits_long_without_a_line_whoever_writes_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "_TICK_S", 0.01)
    monkeypatch.setattr(progress, "LINE_EVERY_S", 0.2)
    with progress.working("thinking"):
        slowly(20)  # a loop inside, with lines of its own
        time.sleep(0.5)
    told = capsys.readouterr().err.splitlines()
    assert any(line.startswith("walking: ") for line in told[:3])
    assert told[-1] == "thinking: 1 s so far"
    assert 3 <= len(told) <= 6


def test_short_steps_one_after_another_within_a_long_one_do_not_hush_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "_TICK_S", 0.01)
    monkeypatch.setattr(progress, "LINE_EVERY_S", 0.2)
    with progress.working("thinking"):
        for _ in range(6):
            with progress.working("looking"):
                time.sleep(0.15)
    assert len(capsys.readouterr().err.splitlines()) >= 2


def test_a_long_step_tells_that_it_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = shown(monkeypatch)
    with progress.working("thinking"):
        time.sleep(0.2)
    assert "thinking: 00:00" in terminal.getvalue()


def test_what_takes_less_than_a_second_is_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = shown(monkeypatch)
    monkeypatch.setattr(progress, "DELAY_S", 60.0)
    with progress.working("thinking"):
        slowly(3)
    assert "thinking" not in terminal.getvalue()
    assert "walking" not in terminal.getvalue()


def test_long_tables_tell_how_much_is_read(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    terminal = shown(monkeypatch)
    path = tmp_path / "long.txt"
    path.write_text("".join(f"{k} 0.5\n" for k in range(60_000)))
    table = read_table(path, ("x",), unit="s")
    np.testing.assert_array_equal(table.values[:, 0], np.full(60_000, 0.5))
    assert "long.txt:" in terminal.getvalue()


def test_what_is_quick_says_nothing_where_there_is_no_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "DELAY_S", 0.0)
    with progress.working("thinking"), progress.reading("file", 10) as told:
        told(5)
        assert list(progress.track(iter("ab"), "walking", 2)) == ["a", "b"]
    assert capsys.readouterr() == ("", "")


def test_a_warning_is_told_once_and_above_the_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = shown(monkeypatch)
    handler = _Lines()
    handler.addFilter(_Once())
    logger = logging.getLogger("motorcade.test_of_progress")
    logger.propagate = False
    logger.addHandler(handler)
    try:
        for _ in progress.track(range(3), "walking", 3):
            logger.warning("gap of %d s", 2)
            logger.warning("gap of %d s", 3)
    finally:
        logger.removeHandler(handler)
    lines = terminal.getvalue().replace("\r", "\n").splitlines()
    assert [line.strip() for line in lines if line.startswith("gap")] == [
        "gap of 2 s",
        "gap of 3 s",
    ]


def test_finding_a_camera_says_how_far_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "LINE_EVERY_S", -1.0)
    camera, points = Camera(640, 480, 500.0, 500.0, 319.5, 239.5), Checkerboard(6, 5, 1.0).points_m
    tilt = 0.4 * np.array([[np.sin(k), np.cos(k), 0.0] for k in range(10)])
    turn = Rotor.from_rotation_vector(tilt) @ Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    poses = Motor.from_rotor_translation(turn, np.tile([-2.5, -2.0, 10.0], (10, 1)))
    px = camera.project(poses[:, None].apply(points))
    views = [BoardCorners(np.arange(30), seen, points) for seen in px]
    self_calibrate_board(views, (640, 480), 100_000_000 * np.arange(10))
    assert "trying lenses: 1 of " in capsys.readouterr().err
