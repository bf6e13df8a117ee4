"""Many runs at once: recordings times knobs times seeds, one table and one comparative report.

A sweep is a TOML file of recordings, knobs with alternatives, and seeds:

.. code-block:: toml

    recordings = ["flights/*", {path = "board.mp4", manifest = "board.toml"}]
    seeds = [0, 1, 2]            # without it, one run with the knobs' own seeds
    until = "errors"             # or any later stage, as with `motorcade run --until`

    [knobs]
    tracked.by = "simulated"    # the same in every run
    fused.gate = [0.99, 0.9999]          # each in turn; every combination is run

Paths are relative to the file, those of knobs too. A list is always a list of alternatives: a knob
that holds several values is written as text, as on the command line ("motor,euler").

Each run has a folder of its own; finished ones never run again, failures are kept apart.
The folder's name is a digest of the recording's content, the settings and the code; in it lies
`outcome` once the run is finished, and only then. It holds for as long as the files that the run
opened beside the recording, such as a character's, are as they were. Stages' outputs are cached for
all runs together, so that runs that differ in a late stage share the early ones.

The table has a row a run and path, with every knob that varied and every error figure; the page
medians of settings, small plots, and every run.
"""

from __future__ import annotations

import itertools
import logging
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from motorcade.ga.names import one_line
from motorcade.render.plots.errors import strip
from motorcade.render.plots.style import ON_PAGES
from motorcade.replays.engine.graph import Graph, parse_knobs
from motorcade.replays.engine.jobs import job_key, run_jobs
from motorcade.replays.engine.stage import GraphError, from_anywhere
from motorcade.replays.io.files import RecordingError, refusal, write_bytes, write_csv
from motorcade.replays.io.readers.manifest.section import Section, load_toml, setting_from
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.pipeline.job import Job, pipeline_graph, run_job
from motorcade.replays.pipeline.report.summary import COLUMNS, shown_value
from motorcade.replays.pipeline.results import require_writable
from motorcade.replays.web.pages import PageCell, page_environment

MOST_RUNS = 100_000
_KEYS = ("recordings", "seeds", "until", "knobs")
SEEDED = ("simulated_poses.seed", "imu.seed")
"""The knobs that a seed of the sweep sets."""


@dataclass(frozen=True)
class PlannedRun:
    """One run of a sweep.

    Fields:
        recording, manifest: what is run on.
        seed: of everything random; None for the knobs' own.
        varied: (knob, value) of the knobs that differ between runs, as text.
        settings: all settings, each "stage.knob=value".
        until: the last stage.

    >>> from pathlib import Path
    >>> from motorcade.replays.comparison.sweep import PlannedRun
    >>> setting = "smoothed.window_s=0.4"
    >>> run = PlannedRun(Path("V1_01_easy"), None, None, (("smoothed.window_s", "0.4"),),
    ...     (setting,), until="errors")
    >>> dict(run.varied)
    {'smoothed.window_s': '0.4'}
    """

    recording: Path
    manifest: Path | None
    seed: int | None
    varied: tuple[tuple[str, str], ...]
    settings: tuple[str, ...]
    until: str


@dataclass(frozen=True)
class Sweep:
    """A sweep as its file states it; its runs are all combinations.

    Fields:
        recordings: path and manifest of each.
        seeds: (None,) where the file names none.
        knobs: knob and its alternatives, as text.
        until: the last stage of every run.

    >>> from pathlib import Path
    >>> from motorcade.replays.comparison.sweep import Sweep
    >>> knobs = (("smoothed.window_s", ("0.2", "0.4")),)
    >>> sweep = Sweep(((Path("V1_01_easy"), None),), seeds=(1, 2), knobs=knobs, until="errors")
    >>> len(sweep), [(run.varied[0][1], run.seed) for run in sweep.runs()]
    (4, [('0.2', 1), ('0.2', 2), ('0.4', 1), ('0.4', 2)])
    """

    recordings: tuple[tuple[Path, Path | None], ...]
    seeds: tuple[int | None, ...]
    knobs: tuple[tuple[str, tuple[str, ...]], ...]
    until: str

    def __len__(self) -> int:
        count = len(self.recordings) * len(self.seeds)
        for _, values in self.knobs:
            count *= len(values)
        return count

    def runs(self) -> Iterator[PlannedRun]:
        """Every run, the seed changing fastest."""
        choices = [[(name, value) for value in values] for name, values in self.knobs]
        several = {name for name, values in self.knobs if len(values) > 1}
        combined = itertools.product(self.recordings, itertools.product(*choices), self.seeds)
        for (recording, manifest), chosen, seed in combined:
            settings = [f"{name}={value}" for name, value in chosen]
            if seed is not None:
                settings += [f"{name}={seed}" for name in SEEDED]
            varied = tuple(one for one in chosen if one[0] in several)
            yield PlannedRun(recording, manifest, seed, varied, tuple(settings), self.until)


def read_sweep(path: Path, graph: Graph) -> Sweep:
    r"""Read a sweep's file and check every name and value in it against the graph.

    Raises:
        RecordingError: the file is missing, not TOML, or a key is unknown or of the wrong kind.
        GraphError: a stage, knob or value that the graph does not have.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.replays import pipeline_graph
    >>> from motorcade.replays.comparison.sweep import read_sweep
    >>> config = "recordings = ['room']\nseeds = [1, 2]\nknobs.smoothed.window_s = [0.2, 0.4]"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = Path(folder, "sweep.toml").write_text(config)
    ...     sweep = read_sweep(Path(folder, "sweep.toml"), pipeline_graph())
    >>> len(sweep), sweep.seeds
    (4, (1, 2))
    """
    top = Section(path, "", load_toml(path), _KEYS)
    until = top.text("until") if "until" in top else "errors"
    seeds = _seeds(top)
    knobs = tuple(_knobs(top)) if "knobs" in top else ()
    try:
        graph.needed(until)
        for name, values in knobs:
            if seeds != (None,) and name in SEEDED:
                raise top.fault(f"knobs.{name}", "expected either this or seeds, got both")
            for value in values:
                parse_knobs([f"{name}={value}"], graph)
    except GraphError as fault:
        raise GraphError(f"{path}: {fault}") from fault
    sweep = Sweep(_recordings(top), seeds, knobs, until)
    if len(sweep) > MOST_RUNS:
        raise refusal(path, f"expected at most {MOST_RUNS} runs, got {len(sweep)}")
    return sweep


def _seeds(top: Section) -> tuple[int | None, ...]:
    if "seeds" not in top:
        return (None,)
    seeds = top["seeds"]
    if not isinstance(seeds, list) or not seeds:
        raise top.fault("seeds", f"expected a list of whole numbers, got {one_line(seeds)}")
    for seed in seeds:
        if not isinstance(seed, int) or isinstance(seed, bool) or not 0 <= seed < 2**31:
            raise top.fault("seeds", f"expected whole numbers of at least 0, got {one_line(seed)}")
    if len(set(seeds)) < len(seeds):
        raise top.fault("seeds", "expected different ones, got one twice")
    return tuple(seeds)


def _knobs(top: Section) -> Iterator[tuple[str, tuple[str, ...]]]:
    stages = top["knobs"]
    if not isinstance(stages, Mapping):
        raise top.fault("knobs", f"expected a table, got {one_line(stages)}")
    for stage, settings in stages.items():
        if not isinstance(settings, Mapping):
            raise top.fault(f"knobs.{stage}", f"expected stage.knob, got {one_line(settings)}")
        for knob, value in settings.items():
            name = f"{stage}.{knob}"
            values = value if isinstance(value, list) else [value]
            texts = tuple(_from_file(top, name, _text(top, name, one)) for one in values)
            if not texts or len(set(texts)) < len(texts):
                raise top.fault(
                    f"knobs.{name}", f"expected different values, got {one_line(value)}"
                )
            yield name, texts


def _text(top: Section, name: str, value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float | str):
        return str(value)
    raise top.fault(f"knobs.{name}", f"expected a number, text or truth, got {one_line(value)}")


def _from_file(top: Section, name: str, text: str) -> str:
    """The value of a knob; a file that it names is looked for beside the sweep's."""
    setting = setting_from(f"{name}={text}", lambda value: top.path.parent / value)
    return setting.partition("=")[2]


def _recordings(top: Section) -> tuple[tuple[Path, Path | None], ...]:
    patterns = top["recordings"]
    if not isinstance(patterns, list) or not patterns:
        raise top.fault("recordings", f"expected a list, got {one_line(patterns)}")
    recordings: dict[tuple[Path, Path | None], None] = {}
    for entry in patterns:
        if not isinstance(entry, str | Mapping):
            expected = "expected paths, or tables of path and manifest"
            raise top.fault("recordings", f"{expected}, got {one_line(entry)}")
        named = {"path": entry} if isinstance(entry, str) else entry
        section = Section(top.path, "recordings", named, ("path", "manifest"))
        manifest = top.path.parent / section.text("manifest") if "manifest" in section else None
        try:
            places = _places(top.path.parent, section.text("path"))
        except (NotImplementedError, ValueError) as fault:
            if isinstance(fault, RecordingError):
                raise
            raise section.fault("path", f"expected a path or pattern: {fault}") from fault
        if not places:
            raise section.fault("path", f"no recording is called {one_line(section.text('path'))}")
        recordings |= dict.fromkeys((place, manifest) for place in places)
    return tuple(recordings)


def _places(folder: Path, text: str) -> list[Path]:
    """What a path or pattern names; a path that is missing stays, so that its run tells of it."""
    if not any(letter in text for letter in "*?["):
        return [folder / text]
    pattern = Path(text)
    base = Path(pattern.anchor) if pattern.is_absolute() else folder
    return sorted(base.glob(str(pattern.relative_to(pattern.anchor))))


log = logging.getLogger("motorcade.sweep")

_OUTCOME = "outcome"


@dataclass(frozen=True)
class Summary:
    """How a sweep went: runs done now, done before, and failed; its rows and where they lie.

    Of those done, `doubtful` contradict themselves or the images. Where it was stopped, `left` is
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
        executor: see `motorcade.replays.engine.jobs.outcomes`.

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


_MOST_SHOWN = 5_000
_MOST_VALUES = 12
_GREY = "var(--soft)"
_DRAWN = ("ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2", "angular_jitter_rad_s2")


def report_page(plan: Sweep, rows: Sequence[Row], left: int = 0) -> str:
    """The page as HTML text; it needs nothing beside it. `left` runs have no rows yet."""
    failures = [row for row in rows if row["status"] == "failed"]
    doubtful = list({row["run"]: row for row in rows if row["status"] == "doubtful"}.values())
    knobs = [name for name, values in plan.knobs if len(values) > 1]
    axes = [*knobs, "recording"] if len(plan.recordings) > 1 else knobs
    judged = [row for row in rows if row["path"] is not None]
    figures = [key for key in FIGURES if any(row[key] is not None for row in judged)]
    shown = rows[:_MOST_SHOWN]
    return (
        page_environment(Path(__file__).parent)
        .get_template("sweep.html")
        .render(
            headline=_headline(plan),
            facts=[
                {"label": "runs", "value": len(plan)},
                {"label": "failed", "value": len(failures)},
                {"label": "doubtful", "value": len(doubtful)},
                *([{"label": "not run yet", "value": left}] if left else []),
                {"label": "recordings", "value": len(plan.recordings)},
                {"label": "seeds", "value": len(plan.seeds)},
            ],
            failures=failures[:_MOST_SHOWN],
            doubtful=doubtful[:_MOST_SHOWN],
            medians=_medians(judged, knobs, figures),
            groups=_groups(judged, axes, figures),
            every=_every(shown, knobs, figures),
            table_caption=_caption(len(shown), len(rows)),
        )
    )


def _headline(plan: Sweep) -> str:
    varied = [f"{name} ({len(values)})" for name, values in plan.knobs if len(values) > 1]
    text = f"Every combination of {', '.join(varied)}." if varied else "No knob varies."
    fixed = [f"{name} = {values[0]}" for name, values in plan.knobs if len(values) == 1]
    if fixed:
        text += f" In all runs: {', '.join(fixed)}."
    return f"{text} Each run goes up to the stage “{plan.until}”."


def _caption(shown: int, count: int) -> str:
    if shown < count:
        return f"The first {shown} of {count} rows; all are in sweep.csv and sweep.parquet."
    return f"{count} rows, as in sweep.csv; a row a run and path. A click on a heading sorts."


def _heading(key: str) -> str:
    return f"{COLUMNS[key][0]} ({COLUMNS[key][1]})"


def _figure(key: str, value: Any, best: float | None = None) -> PageCell:
    """A figure; the best and those that look equal to it share the honour."""
    if value is None:
        return PageCell("–")
    shown = shown_value(key, value)
    honoured = best is not None and shown.lstrip("-") == shown_value(key, best)
    return PageCell(shown, float(value), best=honoured)


def _medians(
    rows: Sequence[Row], knobs: Sequence[str], figures: Sequence[str]
) -> dict[str, list[Any]]:
    """A row a setting and path, over recordings and seeds."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault((*(str(row[name]) for name in knobs), str(row["path"])), []).append(row)
    values = {
        named: {key: _median([row[key] for row in members]) for key in figures}
        for named, members in groups.items()
    }
    best = {}
    for key in figures:
        sizes = [abs(size) for one in values.values() if (size := one[key]) is not None]
        best[key] = min(sizes) if len(sizes) > 1 else None
    heads = [*knobs, "path", "runs", *map(_heading, figures)]
    cells = [
        [
            *map(_label, named),
            PageCell(str(len(groups[named])), len(groups[named])),
            *(_figure(key, value[key], best[key]) for key in figures),
        ]
        for named, value in values.items()
    ]
    return {"heads": heads, "rows": cells}


def _median(values: Sequence[Any]) -> float | None:
    known = [float(value) for value in values if value is not None]
    return median(known) if known else None


def _label(text: str) -> PageCell:
    """A name, sorted as a number where it is one."""
    try:
        value = float(text)
    except ValueError:
        return PageCell(text)
    return PageCell(text, value if math.isfinite(value) else None)


def _groups(
    rows: Sequence[Row], axes: Sequence[str], figures: Sequence[str]
) -> list[dict[str, Any]]:
    """Plots of each axis that has more than one value, and not too many to be drawn."""
    paths = list(dict.fromkeys(str(row["path"]) for row in rows))
    colours = {path: ON_PAGES.get(path, _GREY) for path in paths}
    legend = [{"name": path, "colour": colours[path]} for path in paths]
    groups = []
    for axis in axes:
        images = []
        for key in figures:
            values = _spread(rows, axis, key) if key in _DRAWN else {}
            if 1 < len(values) <= _MOST_VALUES:
                svg = strip(values, colours, f"{_heading(key)} by {axis}")
                images.append({"title": _heading(key), "svg": svg})
        if images:
            groups.append({"axis": axis, "images": images, "legend": legend})
    return groups


def _spread(rows: Sequence[Row], axis: str, key: str) -> dict[str, dict[str, list[float]]]:
    spread: dict[str, dict[str, list[float]]] = {}
    for row in rows:
        if row[key] is not None:
            name = Path(str(row[axis])).name if axis == "recording" else str(row[axis])
            figures = spread.setdefault(name, {}).setdefault(str(row["path"]), [])
            figures.append(float(row[key] or 0.0) * COLUMNS[key][2])
    return spread


def _every(
    rows: Sequence[Row], knobs: Sequence[str], figures: Sequence[str]
) -> dict[str, list[Any]]:
    names = ["recording", "seed", *knobs, "path"]
    heads = [*names, *map(_heading, figures), "run"]
    cells = [
        [
            PageCell(Path(str(row["recording"])).name),
            *(_label("–" if row[name] is None else str(row[name])) for name in names[1:]),
            *(_figure(key, row[key]) for key in figures),
            PageCell(str(row["run"])),
        ]
        for row in rows
    ]
    return {"heads": heads, "rows": cells}


Row = Mapping[str, str | int | float | None]
"""One row; all rows of a sweep have the same columns."""

PathFigures = dict[str, dict[str, float | None]]
"""Of each path that a run judged, what stands in the columns of figures."""

FIGURES = (
    "ape_rmse_m",
    "rotation_rmse_deg",
    "rpe_trans_rmse_m",
    "rpe_rot_rmse_deg",
    "angular_jitter_rad_s2",
    "linear_jitter_m_s2",
    "lag_ms",
    "registration_rmse_px",
)
"""Columns of figures; None where a run has none of them."""


@dataclass(frozen=True)
class RunFigures:
    """What stands in the table of a run: figures of its paths, and why they are doubtful if so.

    >>> RunFigures({"motor": {"ape_rmse_m": 0.01}}, doubts=()).status
    'done'
    """

    paths: PathFigures
    doubts: tuple[str, ...]

    @property
    def status(self) -> str:
        """Done or doubtful."""
        return "doubtful" if self.doubts else "done"


def rows_of(
    run: PlannedRun, folder: str, judged: RunFigures | None, error: str | None
) -> list[Row]:
    """A run's rows: one a path that it judged, or a single one where it failed or judged none."""
    about: dict[str, str | int | float | None] = {"recording": str(run.recording), "seed": run.seed}
    about |= dict(run.varied)
    about["status"] = "failed" if judged is None else judged.status
    about["doubts"] = "; ".join(judged.doubts) if judged and judged.doubts else None
    end: dict[str, str | int | float | None] = {"error": error, "run": folder}
    rows: list[Row] = []
    for path, figures in (judged.paths if judged else {}).items():
        rows.append(about | {"path": path} | figures | end)
    return rows or [about | {"path": None} | dict.fromkeys(FIGURES) | end]


def write_parquet(rows: Sequence[Row], path: Path) -> None:
    """Write the table as Parquet, each column of one type; ModuleNotFoundError without pyarrow."""
    import pyarrow
    import pyarrow.parquet

    kinds = {"seed": pyarrow.int64()} | {name: pyarrow.float64() for name in FIGURES}
    columns = {
        name: pyarrow.array([row[name] for row in rows], kinds.get(name, pyarrow.string()))
        for name in rows[0]
    }
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(pyarrow.table(columns), sink)
    write_bytes(path, sink.getvalue().to_pybytes())
