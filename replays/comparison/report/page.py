"""The pages as HTML text, and their files.

A ratio is called a tie where its interval contains 1 or it is within 1 % of it: the rule of the
verdicts in the tables.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.comparison.report import matrix
from motorcade.replays.comparison.report.images import (
    Crossing,
    can_be_drawn,
    crossing,
    large_panels,
    method_apart,
    method_to_draw,
    replay,
    small_panels,
)
from motorcade.replays.comparison.report.matrix import CAUSAL, LABELS, METRICS, RATIOS, shown
from motorcade.replays.comparison.report.results import (
    REFERENCE,
    Figure,
    Key,
    Ratio,
    Results,
    listed,
    range_ends,
    tied,
)
from motorcade.replays.comparison.statistics import PRACTICAL_SHARE
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
    environment.globals.update(names=matrix, motion_file=motion_file)
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
        told=matrix.MOTIONS.get(motion, "a recording"),
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
    smoothers = f"{len(results.methods)} × {len(results.representations)}"
    return [
        ("smoothers: methods × representations", smoothers),
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


_FRAME_BOUND = 1e-10
_FEW = 3


@dataclass(frozen=True)
class ComparisonFindings:
    """Sentences by what they tell of; empty where the figures say nothing."""

    best: tuple[str, ...]
    representations: tuple[str, ...]
    at_their_best: tuple[str, ...]
    does_not_matter: tuple[str, ...]
    wins: tuple[str, ...]
    artifacts: tuple[str, ...]
    frames: tuple[str, ...]
    cost: tuple[str, ...]


def findings(results: Results) -> ComparisonFindings:
    """All that can be said."""
    several = len(results.motions) > 1
    return ComparisonFindings(
        best=tuple(_best(results)),
        representations=tuple(_over_all(results)),
        at_their_best=tuple(_at_their_best(results)) if several else (),
        does_not_matter=tuple(_by_motion(results)) if several else (),
        wins=tuple(_wins(results)),
        artifacts=tuple(_artifacts(results)),
        frames=tuple(_frames(results)),
        cost=tuple(_cost(results)),
    )


def percent(ratio: float) -> str:
    """A share as a percentage."""
    return f"{shown(100.0 * ratio)} %"


def compared(ratio: Ratio) -> str:
    """A ratio to motors in words with its interval, in percent where it is near 1."""
    if not 0.5 <= ratio.value <= 1.5:
        ends = f" ({shown(ratio.low)} to {shown(ratio.high)})" if _sure(ratio) else ""
        return f"{shown(ratio.value)} times{ends} what motors leave"
    ends = f" ({_signed(ratio.low)} to {_signed(ratio.high)} %)" if _sure(ratio) else ""
    word = "more" if ratio.value >= 1.0 else "less"
    return f"{shown(100.0 * abs(ratio.value - 1.0), 2)} % {word} than motors{ends}"


def _sure(ratio: Ratio) -> bool:
    return math.isfinite(ratio.low)


def _signed(ratio: float) -> str:
    share = 100.0 * (ratio - 1.0)
    return ("−" if share < 0.0 else "+") + shown(abs(share), 2)


def _best(results: Results) -> Iterator[str]:
    rows = [row for row in results.ranking() if row["method"] != "raw"]
    if not rows:
        return
    places = len(results.places())
    ties = [_name(row) for row in rows[1:] if row["ties_with_best"]]
    tie = f"It ties with {listed(ties)}." if ties else "No other one ties with it."
    yield (
        f"Of {len(rows)} smoothers (a method in a representation) with a result in every pair of "
        f"motion and degradation ({places}), {_name(rows[0])} leaves the least residual "
        f"error and jitter: {_left(rows[0])}. {tie}"
    )
    best_ratios = {name: results.best_ratio("all", name) for name in results.representations}
    first = sorted(
        ((name, *best) for name, best in best_ratios.items() if best),
        key=lambda named: named[1].value,
    )
    if len(first) > 1:
        each = [f"`{name}` {percent(left.value)} (`{method}`)" for name, left, method in first]
        yield (
            "With the method that serves it best over all, of those run on every one, each "
            f"representation leaves: {listed(each)}."
        )
    causal = [row for row in rows if row["method"] in CAUSAL]
    if causal and causal[0] is not rows[0]:
        yield f"Best of those that need no later pose is {_name(causal[0])}: {_left(causal[0])}."
    worse = [row for row in rows if row["ratio_to_raw"] > 1.0]
    if worse:
        names = _some([_name(row) for row in reversed(worse)])
        yield f"{len(worse)} leave more than the raw poses had, worst first: {names}."


def _over_all(results: Results) -> Iterator[str]:
    for name, ratio in _over_all_ratios(results).items():
        tie = " ties with motors over all: it" if tied(ratio) else ""
        yield f"`{name}`{tie} leaves {compared(ratio)}."


def _over_all_ratios(results: Results) -> dict[str, Ratio]:
    ratios = results.ratio_to_motor("all", "score")
    return {
        name: ratios["all", name]
        for name in results.representations
        if name != REFERENCE and ("all", name) in ratios
    }


def _by_motion(results: Results) -> Iterator[str]:
    """On which motions a representation ties with motors, leaves less, or leaves more."""
    for name in results.representations:
        if name == REFERENCE:
            continue
        ratios = {}
        for motion in results.motions:
            ratio = results.ratio_to_motor(f"motion:{motion}", "score").get(("all", name))
            if ratio is not None:
                ratios[motion] = ratio
        if not ratios:
            continue
        ties = [motion for motion, ratio in ratios.items() if tied(ratio)]
        less = [m for m, ratio in ratios.items() if m not in ties and ratio.value < 1.0]
        more = [m for m, ratio in ratios.items() if m not in ties and ratio.value > 1.0]
        parts = [f"`{name}` ties with motors on {len(ties)} of {len(ratios)} motions"]
        parts[0] += _named(ties, len(ratios))
        if less:
            parts.append(f"leaves less on {len(less)} ({_extreme(less, ratios)})")
        if more:
            parts.append(f"leaves more on {len(more)} ({_extreme(more, ratios)})")
        yield listed(parts) + "."


def _at_their_best(results: Results) -> Iterator[str]:
    """On which motions a representation's best method leaves as little as motors' best one."""
    for name in results.representations:
        ratios = {}
        for motion in results.motions:
            scope = f"motion:{motion}"
            ours, base = (results.best_ratio(scope, one) for one in (name, REFERENCE))
            if ours is not None and base is not None:
                ratios[motion] = ours[0].value / base[0].value
        if name == REFERENCE or not ratios:
            continue
        same = [motion for motion, ratio in ratios.items() if abs(ratio - 1.0) <= PRACTICAL_SHARE]
        less = [motion for motion, ratio in ratios.items() if ratio < 1.0 - PRACTICAL_SHARE]
        text = f"`{name}` comes within 1 % of motors on {len(same)} of {len(ratios)} motions"
        text += _named(same, len(ratios))
        far = max(ratios, key=lambda motion: ratios[motion])
        parts = [text]
        if less:
            low = min(ratios, key=lambda motion: ratios[motion])
            down = f"down to {shown(ratios[low])} times on {low}"
            parts.append(f"leaves less on {len(less)} ({down})")
        more = len(ratios) - len(same) - len(less)
        if more:
            parts.append(f"leaves more on {more} (up to {shown(ratios[far])} times on {far})")
        yield listed(parts) + "."


def _named(motions: list[str], of: int) -> str:
    """Names in brackets where they are some and not most."""
    return f" ({listed(motions)})" if 0 < len(motions) <= of / 2 else ""


def _extreme(motions: list[str], ratios: Mapping[str, Ratio]) -> str:
    far = sorted(motions, key=lambda motion: -abs(math.log(ratios[motion].value)))
    text = f"{far[0]}, {shown(ratios[far[0]].value)} times"
    return f"most on {text}" if len(far) > 1 else text


def _wins(results: Results) -> Iterator[str]:
    """The largest wins over motors, place by place."""
    best: dict[str, tuple[float, Key, Figure]] = {}
    for key, figure in results.figures.items():
        if figure.verdict != "better" or key[4] not in RATIOS:
            continue
        base = figure.mean - figure.versus_motor
        gain = figure.mean / base
        if key[3] not in best or gain < best[key[3]][0]:
            best[key[3]] = (gain, key, figure)
    for name in results.representations:
        if name in best:
            _, (motion, degradation, method, _, metric), figure = best[name]
            metric_text, motors = METRICS[metric], figure.mean - figure.versus_motor
            ours, theirs = (shown(metric_text.factor * value) for value in (figure.mean, motors))
            unit = metric_text.unit if metric_text.unit == "°" else f" {metric_text.unit}"
            yield (
                f"`{name}`: {metric_text.heading} of `{method}` on "
                f"{motion} with {LABELS[degradation]}, {ours}{unit} against {theirs}{unit}."
            )


def _artifacts(results: Results) -> Iterator[str]:
    """Where each representation turns fastest beside ground truth; the same method on motors."""
    if REFERENCE not in results.representations:
        return
    for name in results.representations:
        places = {
            key: figure.mean
            for key, figure in results.figures.items()
            if key[3] == name and key[4] == "peak_rate_ratio" and math.isfinite(figure.mean)
        }
        if name == REFERENCE or not places:
            continue
        worst = max(places, key=lambda key: places[key] / _motors(results, key))
        motion, degradation, method = worst[:3]
        base = _motors(results, worst)
        if not places[worst] > 1.5 * base:
            continue
        turns = results.figures[motion, degradation, method, name, "spurious_turns"].mean
        never = f", with {shown(turns, 2)} full revolutions a path that never happened"
        also = never if turns else ""
        yield (
            f"Worst place of `{name}`: `{method}` on {motion} with {LABELS[degradation]} turns at "
            f"{shown(places[worst])} times the true peak rate{also}; on motors at {shown(base)} "
            "times."
        )


def _motors(results: Results, key: Key) -> float:
    figure = results.figures.get((*key[:3], REFERENCE, key[4]))
    return figure.mean if figure is not None and math.isfinite(figure.mean) else math.inf


def _frames(results: Results) -> Iterator[str]:
    traits = [row for row in results.document["traits"] if not row["failure"]]
    for name in results.representations:
        ours = [row for row in traits if row["representation"] == name]
        if not ours:
            continue
        idle = [row for row in ours if results.does_nothing((row["method"], name))]
        ours = [row for row in ours if row not in idle]
        both = [f"`{row['method']}`" for row in ours if _defect(row) <= _FRAME_BOUND]
        world = [row for row in ours if _defect(row, ("left",)) <= _FRAME_BOUND]
        text = f"{len(both) or 'none'} of {len(ours)} methods give the same answer in every frame"
        if both:
            text += f" ({listed(both)})"
        yield f"On `{name}`, {text}; {len(world) or 'none'} in every world frame."
        if idle:
            names = [f"`{row['method']}`" for row in idle]
            yield f"On `{name}`, {listed(names)} found no parameters that help, and does nothing."


def _defect(row: Mapping[str, float], sides: tuple[str, ...] = ("left", "right")) -> float:
    return max(row[f"{side}_defect_{unit}"] for side in sides for unit in ("m", "rad"))


def _cost(results: Results) -> Iterator[str]:
    traits = [row for row in results.document["traits"] if not row["failure"]]
    if not traits:
        return
    fast, slow = (pick(traits, key=lambda row: row["time_us_per_pose"]) for pick in (min, max))
    yield (
        f"A pose costs from {shown(fast['time_us_per_pose'], 2)} µs ({_name(fast)}) to "
        f"{shown(slow['time_us_per_pose'], 2)} µs ({_name(slow)}), called from Python on "
        f"{fast['poses']} poses."
    )
    time = {(row["method"], row["representation"]): row["time_us_per_pose"] for row in traits}
    parts = []
    for name in results.representations:
        logs = [
            math.log(time[method, name] / time[method, REFERENCE])
            for method in results.methods
            if (method, name) in time and (method, REFERENCE) in time
        ]
        if logs and name != REFERENCE:
            parts.append(f"`{name}` {shown(math.exp(sum(logs) / len(logs)), 2)}")
    if parts:
        yield f"Times the cost of motors, over methods: {listed(parts)}."


def _name(row: Mapping[str, str]) -> str:
    return f"`{row['method']}` on `{row['representation']}`"


def _left(row: Mapping[str, Any]) -> str:
    share = f"{percent(row['ratio_to_raw'])} of the raw poses'"
    if row["ratio_low"] is None:
        return share
    return f"{share} ({percent(row['ratio_low'])} to {percent(row['ratio_high'])})"


def _some(names: list[str]) -> str:
    if len(names) <= _FEW + 1:
        return listed(names)
    return f"{', '.join(names[:_FEW])} and {len(names) - _FEW} more"
