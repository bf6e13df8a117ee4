"""The page of a report on consistency: one HTML file that needs nothing beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorcade.fusion.metrics.consistency import Consistency
from motorcade.ga import FloatArray
from motorcade.render.plots import plot_series
from motorcade.render.plots.style import COLOURS, with_own_ids
from motorcade.replays.consistency.experiment import PARTS, Experiment
from motorcade.replays.consistency.run import Plan, Verdict, as_json
from motorcade.replays.files.atomic import write_bytes

__all__ = ["write_page"]

_HERE = Path(__file__).parent
# The house style of pages, which the comparison of smoothers keeps.
_STYLE = _HERE.parent / "compare" / "report" / "templates"
# Steps that a line is drawn through, at most.
_DRAWN = 800
# Where 95 % of steps are expected within the bounds.
_GOOD = (0.90, 0.99)
_FILTERS = {
    "motor": "the filter on motors: errors on the right of a pair of motors",
    "quaternion": "the same filter, errors split into a turn in the moving frame and world "
    "coordinates",
    "euler": "angles as the state, integrated by their rates, measured with a noise of their own",
    "euler_exact": "angles as the state, motion and noise converted exactly",
}


@dataclass(frozen=True)
class _Plot:
    title: str
    caption: str
    svg: str


def write_page(plan: Plan, verdicts: Mapping[str, Mapping[str, Verdict]], folder: Path) -> Path:
    """Write `consistency.html` into a folder, and say where it is.

    Raises:
        OSError: a folder that cannot be written.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader([_HERE, _STYLE]), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.globals.update(COLOURS=COLOURS)
    page = environment.get_template("page.html").render(
        plan=plan,
        experiment=Experiment(plan.motions[0], plan.duration_s),
        parts=tuple(PARTS),
        rows=[_shown(row) for row in as_json(plan, verdicts)["rows"]],
        filters={name: _FILTERS[name] for name in plan.filters},
        plots={motion: _plots(motion, of) for motion, of in verdicts.items()},
    )
    path = folder / "consistency.html"
    write_bytes(path, page.encode())
    return path


def _shown(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row of the table: shares within and averages over what is expected, then errors."""
    judged = [f"nees_{part}" for part in PARTS] + ["nis"]
    shares = [float(row[f"{name}_share_within"]) for name in judged]
    return {
        "motion": row["motion"],
        "filter": row["filter"],
        "shares": [
            {
                "text": f"{100 * share:.1f} %",
                "tint": "b2" if _GOOD[0] <= share <= _GOOD[1] else "o3",
            }
            for share in shares
        ],
        "ratios": [f"{row[f'{name}_over_expected']:.3g}" for name in judged],
        "rotation": f"{row['rotation_rmse_deg']:.3g}°",
        "worst": f"{row['rotation_worst_deg']:.3g}°",
        "position": f"{1e3 * row['position_rmse_m']:.3g} mm",
        "left_out": row["left_out"],
    }


def _tint(share: float) -> str:
    return "b2" if _GOOD[0] <= share <= _GOOD[1] else "o3"


def _plots(motion: str, verdicts: Mapping[str, Verdict]) -> list[_Plot]:
    plots = []
    for part in PARTS:
        judged = {name: one.nees[part] for name, one in verdicts.items()}
        plots.append(_squares(motion, part, f"NEES of the {part}", judged, verdicts, 0))
    innovations = {name: one.nis for name, one in verdicts.items()}
    plots.append(_squares(motion, "nis", "NIS of the measured poses", innovations, verdicts, 1))
    turns = {name: _thinned(one.time_s, one.rotation_rms_deg) for name, one in verdicts.items()}
    svg = plot_series(turns, "", "degrees", log_scale=True, nested=True)
    plots.append(
        _Plot("Rotation error", "Root mean square over the runs.", _own(svg, motion, "rotation"))
    )
    return plots


def _squares(
    motion: str, name: str, title: str, judged: Mapping[str, Consistency],
    verdicts: Mapping[str, Verdict], skipped: int,
) -> _Plot:  # fmt: skip
    one = next(iter(judged.values()))
    series = {
        of: _thinned(verdicts[of].time_s[skipped:], found.average) for of, found in judged.items()
    }
    highest = max(float(values.max()) for _, values in series.values())
    svg = plot_series(
        series, "", "average", log_scale=True, nested=True, band=(one.low, one.high),
        limits=(0.5 * one.low, 1.2 * max(highest, one.high)),
    )  # fmt: skip
    caption = f"Expected {one.freedom}; tinted: {one.low:.2f} to {one.high:.2f}."
    return _Plot(title, caption, _own(svg, motion, name))


def _thinned(time_s: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    every = -(-len(time_s) // _DRAWN)
    return time_s[::every], values[::every]


def _own(svg: str, motion: str, name: str) -> str:
    return with_own_ids(svg, f"{motion}-{name}")
