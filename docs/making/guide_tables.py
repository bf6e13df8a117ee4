"""The tables of `docs/which_smoother.md`: rows of text from a finished comparison."""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from typing import Any

from motorcade.replays.comparison.plan import OWN
from motorcade.replays.comparison.report.matrix import CAUSAL, LABELS, METHODS, Matrix, shown
from motorcade.replays.comparison.report.page import percent
from motorcade.replays.comparison.report.results import REFERENCE, Results
from motorcade.replays.comparison.statistics import PRACTICAL_SHARE

COLUMNS = (
    "score",
    "ape_rmse_m",
    "rotation_rmse_deg",
    "linear_jitter_m_s2",
    "angular_jitter_rad_s2",
)


def choices(results: Results) -> list[dict[str, str]]:
    """What leaves least by need; `auto` and the same method on motors stand beside it."""
    needs = [("all poses are there already", "all", False), ("one by one", "all", True)]
    needs += [
        (LABELS[name], f"degradation:{name}", False)
        for name in results.degradations
        if len(results.degradations) > 1
    ]
    made = []
    for need, scope, causal in needs:
        row = _best(results, scope, causal)
        if row is None:
            continue
        ratios = results.ratio_to_raw(scope, "score")
        motors, auto = ratios.get((row["method"], REFERENCE)), ratios.get(("auto", OWN))
        ties = [
            f"`{other['representation']}`"
            for other in results.ranking(scope)
            if other["method"] == row["method"] and _near(other, row) and other is not row
        ]
        made.append(
            {
                "need": need,
                "method": row["method"],
                "representation": row["representation"],
                "left": percent(row["ratio_to_raw"]),
                "motors": percent(motors.value) if motors is not None else "–",
                "auto": percent(auto.value) if auto is not None and not causal else "–",
                "ties": ", ".join(ties) or "–",
            }
        )
    return made


def _near(row: Mapping[str, Any], best: Mapping[str, Any]) -> bool:
    return bool(row["ratio_to_raw"] <= (1.0 + PRACTICAL_SHARE) * best["ratio_to_raw"])


def _best(results: Results, scope: str, causal: bool) -> Mapping[str, Any] | None:
    """What leaves least of all that is tuned."""
    for row in results.ranking(scope):
        if row["method"] not in ("raw", "auto") and (row["method"] in CAUSAL or not causal):
            return row
    return None


def method_rows(results: Results) -> list[tuple[str, list[str]]]:
    """Every method on motors over all, best first: left of raw, lags, time."""
    ratios = [results.ratio_to_raw("all", metric) for metric in COLUMNS]
    time_us = {
        row["method"]: row["time_us_per_pose"]
        for row in results.document["traits"]
        if row["representation"] == REFERENCE and not row["failure"]
    }
    made = []
    for method in _on_motors(results):
        pair = (method, REFERENCE)
        cells = [percent(of[pair].value) for of in ratios]
        lags = [results.mean_size("all", pair, m) for m in ("lag_ms", "angular_rate_lag_ms")]
        made.append((method, [*cells, *map(_whole, lags), shown(time_us.get(method), 2)]))
    return made


def degradation_rows(results: Results) -> list[tuple[str, list[str]]]:
    """Every method on motors, best first over all: left of raw with each degradation."""
    ratios = [results.ratio_to_raw(f"degradation:{one}", "score") for one in results.degradations]
    made = []
    for method in _on_motors(results):
        found = [of.get((method, REFERENCE)) for of in ratios]
        made.append((method, [percent(one.value) if one else "–" for one in found]))
    return made


def _on_motors(results: Results) -> list[str]:
    return [row["method"] for row in results.ranking() if row["representation"] == REFERENCE]


def _whole(value: float) -> str:
    return shown(value, 2) if value >= 1.0 or not value >= 0.0 else "< 1"


# Why a representation leaves more or less than motors on a motion, for where the figures say so.
_REASONS = (
    (
        "rotor",
        "screw",
        1,
        "a constant screw is one constant twist, which motors follow without "
        "error, while the position beside a turn runs along an arc",
    ),
    (
        "rotor",
        "fast_spin",
        -1,
        "a body that spins while it drifts is no screw: its position goes "
        "nearly straight in the world, but round and round in the body, where motors keep it",
    ),
    (
        "dual_quaternion",
        "fast_spin",
        1,
        "components are averaged along the chords of large turns, not along the turns",
    ),
    (
        "euler_unwrapped",
        "gimbal_crossing",
        1,
        "it passes 1° from the gimbal lock of x-y′-z″, where angles turn many times as fast as "
        "the camera and smoothing cuts their corners; orders whose lock lies elsewhere, as that of "
        "`euler_best` does, do not suffer",
    ),
)


def reasons(results: Results) -> list[str]:
    """What the differences come from, with the figures that show them."""
    made = []
    for name, motion, sign, reason in _REASONS:
        scope = f"motion:{motion}"
        ours, base = (results.best_ratio(scope, one) for one in (name, REFERENCE))
        if ours is None or base is None:
            continue
        ratio = ours[0].value / base[0].value
        if sign * (ratio - 1.0) > PRACTICAL_SHARE:
            made.append(f"`{name}` leaves {shown(ratio)} times as much on {motion}: {reason}.")
    return made


def text_rows(table: Matrix) -> list[tuple[str, list[str]]]:
    """A table without its tints."""
    return [(name, [cell.text for cell in cells]) for name, cells in table.rows]


def starting_values(results: Results) -> list[tuple[str, str]]:
    """Where to start: each parameter's median over motions with plain noise, on motors."""
    made = []
    for method in results.methods:
        values = _found(results, method)
        if values:
            told = [
                f"`{name}={_short(statistics.median(of))}` ({_short(min(of))} to {_short(max(of))})"
                for name, of in values.items()
            ]
            made.append((method, ", ".join(told)))
    return made


def _found(results: Results, method: str, searched_only: bool = True) -> dict[str, list[float]]:
    told = [one["parameter"] for one in results.document["ranges"].get(method, [])]
    values: dict[str, list[float]] = {}
    for motion in results.motions:
        row = results.parameters(motion, results.degradations[0]).get((method, REFERENCE))
        for name, value in (row["parameters"] if row else {}).items():
            if name in told or not searched_only:
                values.setdefault(name, []).append(value)
    return values


def example(results: Results, causal: bool) -> dict[str, str]:
    """The best method that the examples can call, with the median of what was found."""
    for row in results.ranking():
        method = row["method"]
        tuned = method not in ("auto", "raw") and (method in CAUSAL) == causal
        if row["representation"] == REFERENCE and tuned:
            found = _found(results, method, searched_only=False)
            arguments = [f"{name}={_short(statistics.median(of))}" for name, of in found.items()]
            return {
                "method": method,
                "arguments": ",\n    ".join(arguments),
                "class": _CLASSES[method],
            }
    raise ValueError("results: expected methods of both kinds, with and without look-ahead")


_CLASSES = dict.fromkeys(METHODS, "") | {
    "exponential": "Exponential",
    "double_exponential": "DoubleExponential",
    "one_euro": "OneEuro",
    "constant_velocity": "ConstantVelocityFilter",
    "constant_acceleration": "ConstantAccelerationFilter",
}


def _short(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}"
