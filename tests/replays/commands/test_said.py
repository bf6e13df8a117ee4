"""What commands print is for people: digits that mean something, no colours, quiet when asked."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.trajectories import write_trajectory
from tests.replays.tiny_recordings import write_tiny

RUN = "import sys; from motorcade.replays.cli import main; sys.exit(main())"
DECIMAL = re.compile(r"\d+\.\d+(?:e[+-]?\d+)?")


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    """A path of two hundred poses."""
    rng = np.random.default_rng(7)
    steps = Motor.exp(0.01 * rng.standard_normal((200, 6)))
    poses = [Motor.identity()]
    for step in steps:
        poses.append(poses[-1] @ step)
    stamps = 1_300_000_000_123_456_789 + 33_333_333 * np.arange(201)
    write_trajectory(Trajectory(stamps, Motor.stack(poses)), tmp_path / "walk.tum")
    return tmp_path / "walk.tum"


@pytest.mark.parametrize(
    "words", ["inspect {}", "trajectory {}", "evaluate {0} {0}", "smooth {} -o smooth.tum"]
)
def test_figures_have_the_digits_that_mean_something(words, walk, capsys, monkeypatch) -> None:
    monkeypatch.chdir(walk.parent)
    assert main([part.format(walk.name, walk.name) for part in words.split()]) == 0
    told = capsys.readouterr().out
    decimals = DECIMAL.findall(told)
    assert decimals
    for number in decimals:
        assert len(number.partition("e")[0].replace(".", "").lstrip("0")) <= 5, told
        assert not 0.0 < float(number) < 1e-12, told


@pytest.mark.parametrize("words", [["--help"], ["run", "--help"], ["run", "--outt"], ["doctor"]])
@pytest.mark.parametrize("forced", [{}, {"NO_COLOR": "1", "TERM": "xterm-256color"}])
def test_nothing_is_coloured_where_no_terminal_reads(words, forced) -> None:
    done = subprocess.run(
        [sys.executable, "-c", RUN, *words],
        env=os.environ | forced,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout + done.stderr
    assert "\x1b" not in done.stdout + done.stderr


@pytest.mark.parametrize("executor", ["local", pytest.param("processes", marks=pytest.mark.slow)])
def test_quiet_leaves_results_alone(executor, tmp_path) -> None:
    recordings = [write_tiny(tmp_path / name, 0.3) for name in ("one", "two")]
    words = ["run", "-q", *map(str, recordings), "--until", "smoothed", "--executor", executor]
    words += ["--out", str(tmp_path / "out"), "--set", "tracked.by=simulated"]
    done = subprocess.run(
        [sys.executable, "-c", RUN, *words], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert f"results in {tmp_path / 'out' / 'two'}" in done.stdout
