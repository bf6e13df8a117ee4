"""What the figures say, in sentences that are made from them; names stand in backticks.

A ratio is called a tie where its interval contains 1 or it is within 1 % of it: the rule of the
verdicts in the tables.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from motorcade.replays.comparison.report.names import CAUSAL, LABELS, METRICS, RATIOS, listed, shown
from motorcade.replays.comparison.report.results import REFERENCE, Figure, Key, Ratio, Results, tied
from motorcade.replays.comparison.statistics import PRACTICAL_SHARE

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
            parts.append(
                f"leaves less on {len(less)} (down to {shown(ratios[low])} times on {low})"
            )
        more = len(ratios) - len(same) - len(less)
        if more:
            parts.append(f"leaves more on {more} (up to {shown(ratios[far])} times on {far})")
        yield listed(parts) + "."


def _named(motions: list[str], of: int) -> str:
    """Names in brackets where they are some and not most."""
    return f" ({listed(motions)})" if 0 < len(motions) <= of / 2 else ""


def _extreme(motions: list[str], ratios: Mapping[str, Ratio]) -> str:
    far = sorted(motions, key=lambda motion: -abs(math.log(ratios[motion].value)))
    most = f"most on {far[0]}, {shown(ratios[far[0]].value)} times"
    return most if len(far) > 1 else f"{far[0]}, {shown(ratios[far[0]].value)} times"


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
            metric_text = METRICS[metric]
            ours, theirs = (
                shown(metric_text.factor * value)
                for value in (figure.mean, figure.mean - figure.versus_motor)
            )
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
        also = (
            f", with {shown(turns, 2)} full revolutions a path that never happened" if turns else ""
        )
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
    share = percent(row["ratio_to_raw"])
    if row["ratio_low"] is None:
        return f"{share} of the raw poses'"
    return (
        f"{share} of the raw poses' ({percent(row['ratio_low'])} to {percent(row['ratio_high'])})"
    )


def _some(names: list[str]) -> str:
    if len(names) <= _FEW + 1:
        return listed(names)
    return f"{', '.join(names[:_FEW])} and {len(names) - _FEW} more"
