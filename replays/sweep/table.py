"""The table of a sweep: a row a run and path, every knob that varied, every error figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from motorcade.replays.files.atomic import write_bytes
from motorcade.replays.sweep.plan import PlannedRun

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
