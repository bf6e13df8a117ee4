"""The comparative page of a sweep: medians of settings, small plots, every run in a table.

The table of a sweep: a row a run and path, every knob that varied, every error figure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from motorcade.render.plots.strips import strip
from motorcade.render.plots.style import ON_PAGES
from motorcade.replays.comparison.sweep.plan import PlannedRun, Sweep
from motorcade.replays.io.atomic import write_bytes
from motorcade.replays.pipeline.report.summary import COLUMNS, shown_value
from motorcade.replays.web.pages import page_environment
from motorcade.replays.web.pages.parts import PageCell

_TEMPLATES = Path(__file__).with_name("templates")
_MOST_SHOWN = 5_000
_MOST_VALUES = 12
_GREY = "var(--soft)"
_DRAWN = ("ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2", "angular_jitter_rad_s2")


def report_page(plan: Sweep, rows: Sequence[Row], left: int = 0) -> str:
    """The page as HTML text; it needs nothing beside it. `left` runs have no rows yet."""
    failures = [row for row in rows if row["status"] == "failed"]
    doubtful = list({row["run"]: row for row in rows if row["status"] == "doubtful"}.values())
    knobs = [name for name, values in plan.knobs if len(values) > 1]
    judged = [row for row in rows if row["path"] is not None]
    figures = [key for key in FIGURES if any(row[key] is not None for row in judged)]
    shown = rows[:_MOST_SHOWN]
    return (
        page_environment(_TEMPLATES)
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
            groups=_groups(judged, _axes(plan, knobs), figures),
            every=_every(shown, knobs, figures),
            table_caption=_caption(len(shown), len(rows)),
        )
    )


def _headline(plan: Sweep) -> str:
    varied = [f"{name} ({len(values)})" for name, values in plan.knobs if len(values) > 1]
    told = f"Every combination of {', '.join(varied)}." if varied else "No knob varies."
    fixed = [f"{name} = {values[0]}" for name, values in plan.knobs if len(values) == 1]
    if fixed:
        told += f" In all runs: {', '.join(fixed)}."
    return f"{told} Each run goes up to the stage “{plan.until}”."


def _caption(shown: int, count: int) -> str:
    if shown < count:
        return f"The first {shown} of {count} rows; all are in sweep.csv and sweep.parquet."
    return f"{count} rows, as in sweep.csv; a row a run and path. A click on a heading sorts."


def _axes(plan: Sweep, knobs: Sequence[str]) -> list[str]:
    axes = list(knobs)
    if len(plan.recordings) > 1:
        axes.append("recording")
    return axes


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
            *(_figure(key, one[key], best[key]) for key in figures),
        ]
        for named, one in values.items()
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
        pictures = []
        for key in figures:
            values = _spread(rows, axis, key) if key in _DRAWN else {}
            if 1 < len(values) <= _MOST_VALUES:
                svg = strip(values, colours, f"{_heading(key)} by {axis}")
                pictures.append({"title": _heading(key), "svg": svg})
        if pictures:
            groups.append({"axis": axis, "pictures": pictures, "legend": legend})
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
