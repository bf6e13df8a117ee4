"""The pages as HTML text, and their files."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.comparison.report import matrix, names
from motorcade.replays.comparison.report.findings import findings
from motorcade.replays.comparison.report.pictures import (
    Crossing,
    can_be_drawn,
    crossing,
    large_panels,
    method_apart,
    method_to_draw,
    replay,
    small_panels,
)
from motorcade.replays.comparison.report.results import Results, range_ends
from motorcade.replays.io.files import write_bytes
from motorcade.replays.web.pages import PagePlot, page_environment

if TYPE_CHECKING:
    from jinja2 import Environment

_TEMPLATES = Path(__file__).with_name("templates")
_CROSSINGS = (
    "gimbal_crossing",
    "gimbal_crossing_fast",
    "gimbal_crossing_slow",
    "gimbal_hover",
)
_TOP = 12
_DETAILS = (
    "ape_rmse_m",
    "rotation_rmse_deg",
    "linear_jitter_m_s2",
    "angular_jitter_rad_s2",
    "lag_ms",
    "angular_rate_lag_ms",
    "rotation_path_ratio",
    "peak_rate_ratio",
    "spurious_turns",
)


def write_report(results: Results, folder: Path) -> Path:
    """Write `report.html`, and a page a motion in `motions/`; returns the first.

    Each page is one file that needs no network; paths are smoothed once more to be drawn.

    Raises:
        OSError: a folder that cannot be written.
    """
    environment = _environment()
    for motion in results.motions:
        page = _motion_page(environment, results, motion)
        write_bytes(folder / motion_file(motion), page.encode())
    report = folder / "report.html"
    write_bytes(report, _overview(environment, results).encode())
    return report


def motion_file(motion: str) -> str:
    """Where the page of a motion lies, beside the report."""
    return f"motions/{re.sub(r'[^A-Za-z0-9_.-]', '_', motion)}.html"


def _environment() -> Environment:
    from markupsafe import Markup, escape

    environment = page_environment(_TEMPLATES)

    def sentence(text: str) -> Markup:
        """Names in backticks become code that may break after its underscores."""
        marked = re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text)))
        return Markup(marked)

    def name(text: str) -> Markup:
        return Markup(str(escape(text)).replace("_", "_<wbr>"))

    environment.filters.update(sentence=sentence, name=name)
    environment.globals.update(names=names, motion_file=motion_file)
    return environment


def _overview(environment: Environment, results: Results) -> str:
    plan = results.document["plan"]
    method = method_to_draw(results)
    drawable = [one for one in results.motions if can_be_drawn(results, one)]
    panels: list[PagePlot] = []
    if method is not None:
        degradation = results.degradations[0]
        panels = small_panels([replay(results, one, degradation, method) for one in drawable])
    motions = matrix.against_motor(
        results,
        "motion",
        results.motions,
        "Residual error and jitter, times what motors leave, over all methods and degradations.",
    )
    degradations = matrix.against_motor(
        results,
        "degradation",
        results.degradations,
        "The same by degradation, over all methods and motions.",
    )
    shown = _crossing(results)
    return environment.get_template("report.html").render(
        results=results,
        plan=plan,
        facts=_facts(results),
        findings=findings(results),
        crossing=shown,
        crossing_errors=shown and matrix.rotation_errors(results, shown.motion, shown.degradation),
        drawn_method=method,
        matrices=matrix.matrices(results, "all"),
        ranking=_ranking(results, "all"),
        unranked=results.unranked(),
        verdicts=matrix.verdict_counts(results),
        best_of_each=matrix.best_of_each(results),
        by_motion=motions,
        by_degradation=degradations,
        panels=panels,
        ties=matrix.exact_ties(results),
        traits=matrix.trait_matrices(results),
        seeds={name: _spans(plan[name]) for name in ("test_seeds", "tuning_seeds")},
        failures=results.document["failures"],
        range_ends=range_ends(results),
    )


def _motion_page(environment: Environment, results: Results, motion: str) -> str:
    scope = f"motion:{motion}"
    return environment.get_template("motion.html").render(
        results=results,
        motion=motion,
        told=names.MOTIONS.get(motion, "a recording"),
        matrices=matrix.matrices(results, scope),
        ranking=_ranking(results, scope),
        panels=_over_time(results, motion),
        metrics=_DETAILS,
        places=[
            (name, matrix.place_rows(results, motion, name, _DETAILS))
            for name in results.degradations
        ],
        parameters=[(one, _parameters(results, motion, one)) for one in results.degradations],
    )


def _over_time(results: Results, motion: str) -> list[tuple[str, list[PagePlot]]]:
    """Plots of the best method, of the one that tells most, and of the best among outliers."""
    best = method_to_draw(results)
    if best is None or not can_be_drawn(results, motion):
        return []
    plain = results.degradations[0]
    chosen = {(plain, best): "The method that is best over all."}
    telling = method_apart(results, motion, plain) or best
    chosen.setdefault((plain, telling), "With it the representations are furthest apart here.")
    for degradation in [one for one in results.degradations[1:] if "outliers" in one][:1]:
        chosen[degradation, best] = ""
    return [
        (remark, large_panels(replay(results, motion, degradation, method)))
        for (degradation, method), remark in chosen.items()
    ]


def _facts(results: Results) -> list[tuple[str, str]]:
    seeds = len(results.document["plan"]["test_seeds"])
    places = len(results.places())
    return [
        (
            "smoothers: methods × representations",
            f"{len(results.methods)} × {len(results.representations)}",
        ),
        ("motions × degradations", f"{len(results.motions)} × {len(results.degradations)}"),
        (f"test {results.drawn_from} a place", str(seeds)),
        ("paths to smooth", f"{places * seeds:,}"),
    ]


def _crossing(results: Results) -> Crossing | None:
    """The passage through gimbal lock, where the plan has one."""
    degradation = results.degradations[0]
    for motion in _CROSSINGS:
        if motion in results.motions and can_be_drawn(results, motion):
            method = method_apart(results, motion, degradation)
            if method is not None:
                return crossing(replay(results, motion, degradation, method))
    return None


def _ranking(results: Results, scope: str) -> list[dict[str, Any]]:
    """The best and the rest; rows with their places on logarithmic axes, in percent of the width.

    The two have an axis each, so that intervals of the best can be seen.
    """
    rows = results.ranking(scope)
    return [_on_axis(part) for part in (rows[:_TOP], rows[_TOP:]) if part]


def _on_axis(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    ends = [row[key] for row in rows for key in ("ratio_low", "ratio_to_raw", "ratio_high")]
    known = [math.log(end) for end in ends if end]
    low, width = min(known), max(max(known) - min(known), 1e-9)

    def place(ratio: float) -> float:
        return round(100.0 * (math.log(ratio) - low) / width, 2)

    placed = [
        dict(row)
        | {
            "at": place(row["ratio_to_raw"]),
            "start": place(row["ratio_low"] or row["ratio_to_raw"]),
            "end": place(row["ratio_high"] or row["ratio_to_raw"]),
        }
        for row in rows
    ]
    return {"rows": placed, "one": place(1.0) if low <= 0.0 <= low + width else None}


def _parameters(results: Results, motion: str, degradation: str) -> list[dict[str, Any]]:
    """A row a method: each representation's parameters as text."""
    tuned = results.parameters(motion, degradation)
    parameters = []
    for method in results.methods:
        cells = [_parameter_text(tuned.get((method, one))) for one in results.representations]
        parameters.append({"method": method, "cells": cells})
    return parameters


def _parameter_text(row: Mapping[str, Any] | None) -> list[str]:
    if row is None:
        return ["–"]
    lines = [f"{name} {value:.4g}" for name, value in row["parameters"].items()]
    return [*(lines or ["its own choice"]), *([] if row["how"] == "search" else [row["how"]])]


def _spans(seeds: list[int]) -> str:
    """``100–119`` or ``1, 4, 7``."""
    if len(seeds) > 2 and seeds == list(range(seeds[0], seeds[-1] + 1)):
        return f"{seeds[0]}–{seeds[-1]}"
    return ", ".join(map(str, seeds))
