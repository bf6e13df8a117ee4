"""The page of a report on consistency: one HTML file that needs nothing beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motorcade.fusion.metrics.consistency import Consistency
from motorcade.render.plots import Band, plot_bands, plot_squares
from motorcade.render.plots.style import with_own_ids
from motorcade.replays.comparison.consistency.experiment import PARTS, Experiment
from motorcade.replays.comparison.consistency.run import ConsistencyPlan, Verdict, as_json
from motorcade.replays.io.atomic import write_bytes
from motorcade.replays.web.pages import page_environment
from motorcade.replays.web.pages.parts import PageCell, PagePlot

_HERE = Path(__file__).parent
# Where 95 % of steps are expected within the bounds.
_GOOD = (0.90, 0.99)
_FILTERS = {
    "motor": "the filter on motors: errors on the right of a pair of motors",
    "quaternion": "the same filter, errors split into a turn in the moving frame and world "
    "coordinates",
    "euler": "angles as the state, integrated by their rates, measured with a noise of their own",
    "euler_exact": "angles as the state, motion and noise converted exactly",
}


def write_page(
    plan: ConsistencyPlan, verdicts: Mapping[str, Mapping[str, Verdict]], folder: Path
) -> Path:
    """Write `consistency.html` into a folder, and say where it is.

    Raises:
        OSError: a folder that cannot be written.
    """
    page = (
        page_environment(_HERE)
        .get_template("page.html")
        .render(
            plan=plan,
            experiment=Experiment(plan.motions[0], plan.duration_s),
            parts=tuple(PARTS),
            rows=[_shown(row) for row in as_json(plan, verdicts)["rows"]],
            filters={name: _FILTERS[name] for name in plan.filters},
            plots={motion: _plots(motion, of) for motion, of in verdicts.items()},
        )
    )
    path = folder / "consistency.html"
    write_bytes(path, page.encode())
    return path


def _shown(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row of the table: shares within and averages over what is expected, then errors."""
    judged = [f"nees_{part}" for part in PARTS] + ["nis"]
    shares = [float(row[f"{name}_share_within"]) for name in judged]
    position_mm = 1e3 * float(row["position_rmse_m"])
    return {
        "motion": row["motion"],
        "filter": row["filter"],
        "shares": [
            PageCell(f"{100 * share:.1f} %", share, "b2" if _GOOD[0] <= share <= _GOOD[1] else "o3")
            for share in shares
        ],
        "ratios": [_figure(row[f"{name}_over_expected"]) for name in judged],
        "errors": [
            _figure(row["rotation_rmse_deg"], "°"),
            _figure(row["rotation_worst_deg"], "°"),
            _figure(position_mm, " mm"),
            PageCell(str(row["left_out"]), float(row["left_out"])),
        ],
    }


def _figure(value: float, unit: str = "") -> PageCell:
    return PageCell(f"{value:.3g}{unit}", float(value))


def _plots(motion: str, verdicts: Mapping[str, Verdict]) -> list[PagePlot]:
    plots = []
    for part in PARTS:
        judged = {name: one.nees[part] for name, one in verdicts.items()}
        plots.append(_squares(motion, part, f"NEES of the {part}", judged, verdicts, 0))
    innovations = {name: one.nis for name, one in verdicts.items()}
    plots.append(_squares(motion, "nis", "NIS of the measured poses", innovations, verdicts, 1))
    spread = {name: Band(one.time_s, *one.rotation_spread_deg) for name, one in verdicts.items()}
    svg = plot_bands(spread, f"rotation error on {motion}", "rotation error (°)")
    caption = "Median over the runs, and where the middle 80 % of them lie."
    plots.append(PagePlot("Rotation error", caption, with_own_ids(svg, f"{motion}-rotation")))
    return plots


def _squares(
    motion: str,
    name: str,
    title: str,
    judged: Mapping[str, Consistency],
    verdicts: Mapping[str, Verdict],
    skipped: int,
) -> PagePlot:
    one = next(iter(judged.values()))
    series = {of: (verdicts[of].time_s[skipped:], found.average) for of, found in judged.items()}
    unit = "average over the runs"
    svg = plot_squares(series, one.freedom, (one.low, one.high), f"{title} on {motion}", unit)
    caption = f"Expected {one.freedom}, dashed; tinted: {one.low:.2f} to {one.high:.2f}."
    return PagePlot(title, caption, with_own_ids(svg, f"{motion}-{name}"))
