"""Ctrl-C keeps what a sweep has done: its table is written, and the next call does the rest."""

import contextlib
import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from motorcade.replays.cli import main
from motorcade.replays.pipeline import Job, pipeline, run_job
from motorcade.replays.sweep import read_sweep, sweep
from motorcade.replays.sweep import run as runner

Config = Callable[..., Path]
MAIN = "import sys; from motorcade.replays.cli import main; sys.exit(main(sys.argv[1:]))"


@pytest.fixture(autouse=True)
def _steady_code(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The sources may be edited while tests run; here a key changes only by what a test does."""
    monkeypatch.setattr(runner, "code_digest", lambda function: "code")
    return


def stopping_at(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    """Ctrl-C strikes in the run of that number, from 0."""
    called: list[Job] = []

    def stopped(job: Job) -> dict[str, Any]:
        called.append(job)
        if len(called) > number:
            raise KeyboardInterrupt
        return run_job(job)

    monkeypatch.setattr(runner, "run_job", stopped)


def table(out: Path) -> list[dict[str, str]]:
    with (out / "sweep.csv").open() as file:
        return list(csv.DictReader(file))


def test_the_table_of_what_is_done_is_left_and_the_rest_follows(
    config: Config,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = config(knobs="smoothed.representations = 'motor'")
    command = ["sweep", str(path), "--executor", "local", "--out"]
    whole = sweep(read_sweep(path, pipeline()), tmp_path / "whole", "local")
    stopping_at(monkeypatch, 2)
    out = tmp_path / "out"
    assert main([*command, str(out)]) == 130
    told = capsys.readouterr().err
    assert told.startswith("motorcade: stopped; 2 of 4 runs are done, results in ")
    assert told.count("\n") == 1
    first = table(out)
    assert len({row["run"] for row in first}) == 2
    assert "<b>2</b><span>not run yet</span>" in (out / "sweep.html").read_text()
    monkeypatch.setattr(runner, "run_job", run_job)
    summary = sweep(read_sweep(path, pipeline()), out, "local")
    assert (summary.done, summary.done_before, summary.left) == (2, 2, 0)
    assert summary.rows == whole.rows
    assert table(out)[: len(first)] == first
    assert table(out) == table(tmp_path / "whole")
    assert "not run yet" not in (out / "sweep.html").read_text()


def test_nothing_is_written_where_nothing_is_done(
    config: Config,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    stopping_at(monkeypatch, 0)
    out = tmp_path / "out"
    path = str(config(seeds="[0]"))
    assert main(["sweep", path, "--out", str(out), "--executor", "local"]) == 130
    assert "stopped; 0 of 2 runs are done, no table yet;" in capsys.readouterr().err
    assert not list(out.glob("sweep.*"))


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
def test_processes_end_at_once_and_quietly(config: Config, tmp_path: Path, everybody: bool) -> None:
    """By a terminal's Ctrl-C, which reaches all of them, and by a signal to the command alone."""
    path = config(knobs="smoothed.representations = 'motor'", seeds=str(list(range(40))))
    out = tmp_path / "out"
    process = subprocess.Popen(
        [sys.executable, "-c", MAIN, "sweep", str(path), "--out", str(out)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=heeding_interrupts,
    )  # fmt: skip
    until = time.monotonic() + 240.0
    while not list(out.glob("runs/*/outcome.json")) and time.monotonic() < until:
        time.sleep(0.05)
    if everybody:
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=120)
    assert process.returncode == 130
    assert told.startswith("motorcade: stopped; ")
    assert told.count("\n") == 1
    assert 1 <= len({row["run"] for row in table(out)}) < 80
    until = time.monotonic() + 30.0
    while living(process.pid) and time.monotonic() < until:
        time.sleep(0.1)
    assert not living(process.pid)
