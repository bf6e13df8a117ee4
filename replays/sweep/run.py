"""Runs a sweep: each run in a folder of its own, finished ones never again, failures kept apart.

The folder's name is a digest of the recording's content, the settings and the code; in it lies
`outcome.json` once the run is finished, and only then. Stages' outputs are cached for all runs of
one machine together, so that runs that differ in a late stage share the early ones.
"""

from __future__ import annotations

import hashlib
import json
import logging
import platform
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorcade.replays.engine.executors import outcomes
from motorcade.replays.engine.progress import track
from motorcade.replays.engine.provenance import code_digest
from motorcade.replays.errors import one_line
from motorcade.replays.files.atomic import write_bytes
from motorcade.replays.pipeline import Job, require_writable, run_job
from motorcade.replays.recording import open_recording
from motorcade.replays.sweep.plan import PlannedRun, Sweep
from motorcade.replays.sweep.report import report_page
from motorcade.replays.sweep.table import Row, rows_of, write_csv, write_parquet

__all__ = ["Summary", "sweep"]

log = logging.getLogger("motorcade.sweep")

_OUTCOME = "outcome.json"


@dataclass(frozen=True)
class Summary:
    """How a sweep went: runs done now, done before, and failed; its rows and where they lie.

    Where it was stopped, `left` is how many runs have no row yet.
    """

    done: int
    done_before: int
    failed: int
    rows: tuple[Row, ...]
    files: tuple[Path, ...]
    left: int = 0


@dataclass(frozen=True)
class _Task:
    """A run that is to be done, and where."""

    run: PlannedRun
    folder: Path
    cache: Path


def sweep(plan: Sweep, out: Path, executor: str) -> Summary:
    """Run what of a sweep is not done yet, and gather all of it.

    Leaves `sweep.csv`, `sweep.parquet` (where pyarrow is installed), `sweep.html` and
    `runs/<recording>-<key>/` in `out`. Runs that failed are tried again by the next call. A
    KeyboardInterrupt ends what is running; then the table holds the runs that were finished, and no
    file is touched where there is none.

    Args:
        plan: the runs.
        out: the folder of results; on a cluster, one that all workers see.
        executor: see `motorcade.replays.engine.executors.outcomes`.

    Raises:
        OSError: nothing can be written in `out`.
        ValueError, RuntimeError: the executor is unknown or cannot be reached.
    """
    out = out.resolve()
    require_writable(out)
    tasks = list(_tasks(plan, out))
    finished = {task: stored for task in tasks if (stored := _finished(task.folder)) is not None}
    waiting = [task for task in tasks if task not in finished]
    failed: dict[_Task, str] = {}
    gathered: dict[_Task, dict[str, Any]] = dict(finished)
    results = outcomes(_run_task, waiting, executor)
    try:
        for task, outcome in track(results, "runs", len(waiting)):
            if isinstance(outcome, BaseException):
                failed[task] = " ".join(str(outcome).split()) or type(outcome).__name__
                log.warning("%s: %s", task.folder.name, failed[task])
            else:
                gathered[task] = outcome
    except KeyboardInterrupt:
        results.close()
        late = [task for task in waiting if task not in gathered and task not in failed]
        gathered |= {task: stored for task in late if (stored := _finished(task.folder))}
    told = [task for task in tasks if task in gathered or task in failed]
    rows = tuple(
        row
        for task in told
        for row in rows_of(task.run, task.folder.name, gathered.get(task), failed.get(task))
    )
    left = len(tasks) - len(told)
    files = _write(plan, rows, left, out) if rows else ()
    done = len(gathered) - len(finished)
    return Summary(done, len(finished), len(failed), rows, files, left)


def _tasks(plan: Sweep, out: Path) -> Iterator[_Task]:
    code = code_digest(run_job)
    contents: dict[tuple[Path, Path | None], str] = {}
    for run in plan.runs():
        place = (run.recording, run.manifest)
        if place not in contents:
            contents[place] = _content(*place)
        parts = [contents[place], str(run.recording.resolve()), *run.settings, run.until, code]
        key = hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]
        folder = out / "runs" / f"{run.recording.resolve().stem}-{key}"
        yield _Task(run, folder, out / ".cache")


def _content(recording: Path, manifest: Path | None) -> str:
    """Digest of a recording; one that cannot be read has none, and its runs will tell why."""
    try:
        return open_recording(recording, manifest).digest()
    except Exception as fault:  # its runs meet the same fault, and tell it in the table
        log.info("%s: %s", recording, fault)
        return "unreadable"


def _run_task(task: _Task) -> dict[str, Any]:
    """Do a run where this is called; its outcome is there whole or not at all."""
    stored = _finished(task.folder)
    if stored is not None:
        return stored  # a worker that was given up for lost had finished it
    run = task.run
    # Machines of a cluster may have processes of equal numbers, which caches are kept apart by.
    cache = task.cache / one_line(platform.node() or "here").strip("'").replace("/", "_")
    job = Job(run.recording, task.folder, run.manifest, cache, run.until, run.settings)
    account = run_job(job)
    outcome = {"errors": account.get("errors", {}), "align": account.get("align")}
    write_bytes(task.folder / _OUTCOME, (json.dumps(outcome, indent=2) + "\n").encode())
    return outcome


def _finished(folder: Path) -> dict[str, Any] | None:
    try:
        stored = json.loads((folder / _OUTCOME).read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as fault:
        log.warning("%s: run again, its outcome cannot be read: %s", folder, fault)
        return None
    return stored if isinstance(stored, dict) else None


def _write(plan: Sweep, rows: Sequence[Row], left: int, out: Path) -> tuple[Path, ...]:
    files = [out / "sweep.csv", out / "sweep.html"]
    write_csv(rows, files[0])
    write_bytes(files[1], report_page(plan, rows, left).encode())
    try:
        write_parquet(rows, out / "sweep.parquet")
        files.append(out / "sweep.parquet")
    except ModuleNotFoundError:
        log.warning('no sweep.parquet: pip install "motorcade[scale]" brings pyarrow')
    return tuple(files)
