"""The table of a sweep: a row a run and path, every knob that varied, every error figure."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from motorcade.replays.files.atomic import write_bytes
from motorcade.replays.sweep.plan import PlannedRun

__all__ = ["FIGURES", "Row", "rows_of", "write_csv", "write_parquet"]

Row = Mapping[str, str | int | float | None]
"""One row; all rows of a sweep have the same columns."""

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


def rows_of(
    run: PlannedRun, folder: str, outcome: Mapping[str, Any] | None, error: str | None
) -> list[Row]:
    """A run's rows: one a path that it judged, or a single one where it failed or judged none."""
    about: dict[str, str | int | float | None] = {"recording": str(run.recording), "seed": run.seed}
    about |= dict(run.varied)
    about["status"] = "failed" if outcome is None else "done"
    paths: Mapping[str, Any] = {} if outcome is None else outcome["errors"]
    end: dict[str, str | int | float | None] = {"error": error, "run": folder}
    rows: list[Row] = []
    for path, figures in paths.items():
        values = {key: figures.get(key) for key in FIGURES}
        rows.append(about | {"path": path} | values | end)
    return rows or [about | {"path": None} | dict.fromkeys(FIGURES) | end]


def write_csv(rows: Sequence[Row], path: Path) -> None:
    """Write the table as CSV; an empty cell where there is no value."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_bytes(path, text.getvalue().encode())


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
