"""Ctrl-C keeps what a command of many jobs has done, and the same command does the rest."""

import contextlib
import csv
import functools
import importlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from motorcade.replays.cli import main

Config = Callable[..., Path]
MAIN = "import sys; from motorcade.replays.cli import main; sys.exit(main(sys.argv[1:]))"
COMPARE = "compare --quick --trajectories screw --degradations gaussian --methods exponential"
CONSISTENCY = "consistency --motions tumble --filters quaternion --duration-s 10"
JOBS = {
    "sweep": (
        "motorcade.replays.comparison.sweep",
        "run_job",
        "runs/*/outcome",
        ("sweep.csv",),
    ),
    "compare": (
        "motorcade.replays.comparison.run",
        "run_cell",
        ".finished/*",
        ("cells.csv", "groups.csv"),
    ),
    "consistency": (
        "motorcade.replays.comparison.consistency",
        "run_seeds",
        ".finished/*",
        ("consistency.csv",),
    ),
}
"""Of each command: the module and function of a job, where results are kept, and its tables."""


@pytest.fixture
def words(config: Config, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], list[str]]:
    """A command of four jobs; those of a comparison come after the search for parameters."""

    def small(command: str) -> list[str]:
        if command == "sweep":
            path = config(knobs="smoothed.representations = 'motor'")
            return ["sweep", str(path)]
        if command == "compare":
            return [*COMPARE.split(), "--representations", "motor", "--seeds", "4"]
        monkeypatch.setattr("motorcade.replays.comparison.consistency._RUNS_A_JOB", 1)
        return [*CONSISTENCY.split(), "--runs", "4"]

    return small


def stopping_at(command: str, number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C strikes in the job of that number, from 0."""
    module, function, _, _ = JOBS[command]
    original = getattr(importlib.import_module(module), function)
    called: list[Any] = []

    @functools.wraps(original)
    def stopped(job: Any) -> Any:
        called.append(job)
        if len(called) > number:
            raise KeyboardInterrupt
        return original(job)

    monkeypatch.setattr(f"{module}.{function}", stopped)


def kept(command: str, out: Path) -> dict[Path, int]:
    """When each result was written."""
    values = out.glob(f"{JOBS[command][2]}/value.json")
    return {path: path.stat().st_mtime_ns for path in values}


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("command", JOBS)
def test_the_same_command_does_the_rest(
    command: str,
    words: Callable[[str], list[str]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    out, whole = tmp_path / "out", tmp_path / "whole"
    given = [*words(command), "--executor", "local", "--out"]
    assert main([*given, str(whole)]) == 0
    with monkeypatch.context() as patch:
        stopping_at(command, 2, patch)
        # Of a loop that takes five seconds, as on a busy machine, a line of progress is said.
        patch.setattr("motorcade.ga.progress.LINE_EVERY_S", float("inf"))
        capsys.readouterr()
        assert main([*given, str(out)]) == 130
    told = capsys.readouterr().err
    assert told.startswith("motorcade: stopped; 2 of 4 ")
    assert told.endswith("the same command does the rest\n")
    assert told.count("\n") == 1
    before = kept(command, out)
    assert main([*given, str(out)]) == 0
    after = kept(command, out)
    assert after.items() >= before.items()
    assert len(after) == len(kept(command, whole))
    for name in JOBS[command][3]:
        assert (out / name).read_bytes() == (whole / name).read_bytes()


def test_the_table_of_a_sweep_holds_what_is_done(
    words: Callable[[str], list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    given = [*words("sweep"), "--executor", "local", "--out", str(out)]
    with monkeypatch.context() as patch:
        stopping_at("sweep", 2, patch)
        assert main(given) == 130
    first = table(out)
    assert len({row["run"] for row in first}) == 2
    assert "<b>2</b><span>not run yet</span>" in (out / "sweep.html").read_text()
    assert main(given) == 0
    assert table(out)[: len(first)] == first
    assert "not run yet" not in (out / "sweep.html").read_text()


def table(out: Path) -> list[dict[str, str]]:
    with (out / "sweep.csv").open() as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("command", JOBS)
def test_no_table_is_written_where_nothing_is_done(
    command: str,
    words: Callable[[str], list[str]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    stopping_at(command, 0, monkeypatch)
    out = tmp_path / "out"
    assert main([*words(command), "--out", str(out), "--executor", "local"]) == 130
    assert "stopped; 0 of 4 " in capsys.readouterr().err
    assert not [*out.glob("*.csv"), *out.glob("*.html"), *out.glob("*.parquet")]


def living(group: int) -> list[str]:
    """Processes of a group that are more than names; none where the system does not tell."""
    told = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            told.append(path.read_text().rpartition(")")[2].split())
    return [" ".join(one[:3]) for one in told if int(one[2]) == group and one[0] != "Z"]


def heeding_interrupts() -> None:
    """Tests may themselves be run where Ctrl-C is ignored, as in the background of a shell."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.slow
@pytest.mark.parametrize("everybody", [True, False])
@pytest.mark.parametrize("command", JOBS)
def test_processes_end_at_once_and_quietly(
    command: str, config: Config, tmp_path: Path, everybody: bool
) -> None:
    """By a terminal's Ctrl-C, which reaches all of them, and by a signal to the command alone."""
    path = config(knobs="smoothed.representations = 'motor'", seeds=str(list(range(40))))
    given = {
        "sweep": ["sweep", str(path)],
        "compare": ["compare", "--trajectories", "screw", "handheld"],
        "consistency": ["consistency"],
    }
    out = tmp_path / "out"
    process = subprocess.Popen(
        [sys.executable, "-c", MAIN, *given[command], "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=heeding_interrupts,
    )
    until = time.monotonic() + 240.0
    while not kept(command, out) and time.monotonic() < until:
        time.sleep(0.05)
    if everybody:
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=120)
    assert process.returncode == 130
    *progress, last = told.splitlines()
    assert last.startswith("motorcade: stopped; ")
    assert all(" left" in line for line in progress), told  # a line every ten seconds, no traceback
    assert kept(command, out)
    until = time.monotonic() + 30.0
    while living(process.pid) and time.monotonic() < until:
        time.sleep(0.1)
    assert not living(process.pid)


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_has_gone_is_no_error(unbuffered: str) -> None:
    """As `head` goes after its lines: with what is printed at once, and at the end."""
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-c", MAIN, "smooth", "--list"],
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
        timeout=60,
    )
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")
