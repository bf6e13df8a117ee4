"""Runs a sweep: each run in a folder of its own, finished ones never again, failures kept apart.

The folder's name is a digest of the recording's content, the settings and the code; in it lies
`outcome` once the run is finished, and only then. It holds for as long as the files that the run
opened beside the recording, such as a character's, are as they were. Stages' outputs are cached for
all runs together, so that runs that differ in a late stage share the early ones.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from motorcade.replays.comparison.sweep.plan import PlannedRun, Sweep
from motorcade.replays.comparison.sweep.report import (
    FIGURES,
    Row,
    RunFigures,
    report_page,
    rows_of,
    write_parquet,
)
from motorcade.replays.engine.graph import Graph
from motorcade.replays.engine.jobs import job_key, run_jobs
from motorcade.replays.engine.knobs import parse_knobs
from motorcade.replays.engine.stage import from_anywhere
from motorcade.replays.io.atomic import write_bytes, write_csv
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.pipeline.job import Job, pipeline_graph, run_job
from motorcade.replays.pipeline.results import require_writable

log = logging.getLogger("motorcade.sweep")

_OUTCOME = "outcome"


@dataclass(frozen=True)
class Summary:
    """How a sweep went: runs done now, done before, and failed; its rows and where they lie.

    Of those done, `doubtful` contradict themselves or the pictures. Where it was stopped, `left` is
    how many runs have no row yet.

    >>> from motorcade.replays.comparison.sweep import Summary
    >>> stopped = Summary(done=3, done_before=2, failed=1, rows=(), files=(), left=4)
    >>> stopped.done + stopped.done_before + stopped.failed + stopped.left
    10
    """

    done: int
    done_before: int
    failed: int
    rows: tuple[Row, ...]
    files: tuple[Path, ...]
    left: int = 0
    doubtful: int = 0


@dataclass(frozen=True)
class _Task:
    """A run that is to be done, and where."""

    run: PlannedRun
    folder: Path
    cache: Path


def run_sweep(plan: Sweep, out: Path, executor: str) -> Summary:
    """Run what of a sweep is not done yet, and gather all of it.

    Leaves `sweep.csv`, `sweep.parquet` (where pyarrow is installed), `sweep.html` and
    `runs/<recording>-<key>/` in `out`. Runs that failed are tried again by the next call. After
    Ctrl-C the table holds the runs that were finished; no file is touched where there is none.

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
    jobs = {task: task.folder / _OUTCOME for task in _tasks(plan, out)}
    batch = run_jobs(_run_task, jobs, executor, "runs")
    rows = tuple(
        row
        for task in jobs
        if task in batch.results or task in batch.failures
        for row in rows_of(
            task.run, task.folder.name, batch.results.get(task), batch.failures.get(task)
        )
    )
    files = _write(plan, rows, batch.left, out) if rows else ()
    done = len(batch.results) - batch.done_before
    doubtful = sum(bool(one.doubts) for one in batch.results.values())
    return Summary(done, batch.done_before, len(batch.failures), rows, files, batch.left, doubtful)


def _tasks(plan: Sweep, out: Path) -> Iterator[_Task]:
    graph = pipeline_graph()
    contents: dict[tuple[Path, Path | None], tuple[str, ...]] = {}
    for run in plan.runs():
        place = (run.recording, run.manifest)
        if place not in contents:
            contents[place] = _content(*place, graph)
        digest, *own = contents[place]
        knobs = {
            stage: {name: repr(from_anywhere(value)) for name, value in chosen.items()}
            for stage, chosen in parse_knobs((*own, *run.settings), graph).items()
        }
        resolved = os.path.realpath(run.recording)  # of links in a circle too: the run tells of it
        about = [digest, resolved, knobs, run.until]
        name = f"{Path(resolved).stem}-{job_key(run_job, about)}"
        yield _Task(run, out / "runs" / name, out / ".cache")


def _content(recording: Path, manifest: Path | None, graph: Graph) -> tuple[str, ...]:
    """Digest and settings of a recording; one that cannot be read has none: its runs tell why."""
    try:
        opened = open_recording(recording, manifest)
        parse_knobs(opened.settings, graph)
        return (opened.digest(), *opened.settings)
    except Exception as fault:  # its runs meet the same fault, and tell it in the table
        log.info("%s: %s", recording, fault)
        return ("unreadable",)


def _run_task(task: _Task) -> RunFigures:
    """Do a run where this is called; the figures of the paths that it judged."""
    run = task.run
    job = Job(run.recording, task.folder, run.manifest, task.cache, run.until, run.settings)
    report = run_job(job)
    judged = report.get("errors", {})
    return RunFigures(
        {path: {key: of.get(key) for key in FIGURES} for path, of in judged.items()},
        tuple(report.get("integrity", {}).get("doubts", ())),
    )


def _write(plan: Sweep, rows: Sequence[Row], left: int, out: Path) -> tuple[Path, ...]:
    files = [out / "sweep.csv", out / "sweep.html"]
    write_csv(files[0], list(rows[0]), [list(row.values()) for row in rows])
    write_bytes(files[1], report_page(plan, rows, left).encode())
    try:
        write_parquet(rows, out / "sweep.parquet")
        files.append(out / "sweep.parquet")
    except ModuleNotFoundError:
        log.warning('no sweep.parquet: pip install "motorcade[scale]" brings pyarrow')
    return tuple(files)
