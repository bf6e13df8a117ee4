"""Runs jobs one after another, each in a process of its own, and keeps what they found.

python -m tests.bench.whole.running '{"suite": "accuracy"}' FOUND.json    (one job, here)
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from tests.bench.page import MACHINE, RUNS, machine
from tests.bench.tables import SUITES
from tests.bench.whole.jobs import MINUTES, Job

__all__ = ["run_whole"]

_LAST = 300


def run_whole(jobs: Sequence[Job], minutes: float = MINUTES) -> dict[str, Any]:
    """Figures by suite, the machine's, and of every job its seconds, the load, and what failed.

    Args:
        jobs: what to measure, in this order.
        minutes: after which no job runs on.
    """
    figures: dict[str, Any] = {}
    runs: dict[str, dict[str, Any]] = {}
    began, told = time.monotonic(), machine()
    for job in jobs:
        left_s = 60.0 * minutes - (time.monotonic() - began)
        run = runs[job.name] = {"suite": job.suite, "load": os.getloadavg()[0]}
        found, fault = _measured(job, min(job.limit_s, left_s)) if left_s > 0.0 else _NO_TIME
        run["seconds"] = 60.0 * minutes - left_s
        run["seconds"] = time.monotonic() - began - run["seconds"]
        if fault is not None:
            run["left_out"] = fault
        elif job.part is None:
            figures[job.suite] = found
        else:
            figures.setdefault(job.suite, {}).update(found)
        print(f"{job.name}: {fault or 'done'}, {run['seconds']:.0f} s", file=sys.stderr, flush=True)
    return figures | {MACHINE: told, RUNS: runs}


_NO_TIME = (None, "not begun: the time for all was over")


def _measured(job: Job, limit_s: float) -> tuple[Any, str | None]:
    """What a job found, or why it found nothing; its processes are gone afterwards."""
    given = {"suite": job.suite, "part": job.part, "sizes": dict(job.sizes)}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "found.json"
        running = subprocess.Popen(
            [sys.executable, "-m", "tests.bench.whole.running", json.dumps(given), str(file)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        try:
            _, said = running.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            return None, f"ended after {limit_s:.0f} s"
        finally:
            _end(running)
        if running.returncode == 0 and file.is_file():
            return json.loads(file.read_text()), None
    last = " ".join(said.split())[-_LAST:]
    return None, f"failed with {running.returncode}: {last or 'no word'}"


def _end(running: subprocess.Popen[str]) -> None:
    """End the processes of a job, those that it started among them."""
    try:
        os.killpg(running.pid, signal.SIGKILL)
    except ProcessLookupError:
        return
    finally:
        running.communicate()


def measure_here(given: Mapping[str, Any]) -> Any:
    """What a job finds, measured in this process."""
    module, measure, _ = SUITES[given["suite"]]
    sizes = dict(given.get("sizes") or {})
    if given.get("part"):
        sizes["parts"] = (given["part"],)
    return getattr(import_module(f"tests.bench.{module}"), measure)(**sizes)


if __name__ == "__main__":
    Path(sys.argv[2]).write_text(json.dumps(measure_here(json.loads(sys.argv[1]))))
