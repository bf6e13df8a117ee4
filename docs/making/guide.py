"""`docs/which_smoother.md` from a finished comparison; see its own first lines.

python -m docs.making.guide out/compare > docs/which_smoother.md
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from motorcade.replays.compare.figures.statistics import PRACTICAL_SHARE
from motorcade.replays.compare.report.findings import findings, percent
from motorcade.replays.compare.report.matrix import Matrix, best_of_each, exact_ties
from motorcade.replays.compare.report.names import (
    CAUSAL,
    DEGRADATIONS,
    LABELS,
    METHODS,
    MOTIONS,
    REPRESENTATIONS,
    listed,
    shown,
)
from motorcade.replays.compare.report.results import REFERENCE, Results, grid_ends

__all__ = ["guide", "main"]

_TEMPLATE = Path(__file__).with_name("guide.md.jinja")
_COLUMNS = (
    "score",
    "ape_rmse_m",
    "rotation_rmse_deg",
    "linear_jitter_m_s2",
    "angular_jitter_rad_s2",
)


def guide(results: Results) -> str:
    """The page as Markdown.

    Raises:
        ValueError: a comparison in which nothing could be ranked, or without motors.
    """
    from jinja2 import Environment, StrictUndefined

    if not results.ranking() or REFERENCE not in results.representations:
        raise ValueError("results: expected a comparison with motors and complete smoothers")
    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    plan = results.told["plan"]
    return environment.from_string(_TEMPLATE.read_text(encoding="utf-8")).render(
        results=results,
        plan=plan,
        scope=_plain(results),
        findings=findings(results),
        choices=_choices(results),
        offline=_example(results, False),
        live=_example(results, True),
        methods=_method_rows(results),
        motions=_rows(best_of_each(results)),
        starts=_starts(results),
        reasons=_reasons(results),
        grid_ends=grid_ends(results),
        left_out=_left_out(plan),
        ties=exact_ties(results),
        REPRESENTATIONS=REPRESENTATIONS,
        METHODS=METHODS,
        MOTIONS=MOTIONS,
        DEGRADATIONS=DEGRADATIONS,
        CAUSAL=CAUSAL,
    )


def _plain(results: Results) -> str:
    """The scope in which methods are compared with each other: plain noise, where all ran."""
    return f"degradation:{results.degradations[0]}"


def _choices(results: Results) -> list[dict[str, str]]:
    """What leaves least by need; the same method on motors stands beside it."""
    needs = [
        ("all poses are there already", "all", False),
        ("poses arrive one by one", "all", True),
    ]
    for name in (
        "gaussian_strong",
        "outliers",
        "outliers_and_flips",
        "dropped_frames",
        "quantised",
    ):
        if name in results.degradations:
            needs.append((f"all poses, {LABELS[name]}", f"degradation:{name}", False))
    made = []
    for need, scope, causal in needs:
        row = _best(results, scope, causal)
        if row is None:
            continue
        motors = results.ratio_to_raw(scope, "score").get((row["method"], REFERENCE))
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
                "ties": ", ".join(ties) or "–",
            }
        )
    return made


def _near(row: Mapping[str, Any], best: Mapping[str, Any]) -> bool:
    return bool(row["ratio_to_raw"] <= 1.01 * best["ratio_to_raw"])


def _best(results: Results, scope: str, causal: bool) -> Mapping[str, Any] | None:
    for row in results.ranking(scope):
        if row["method"] != "raw" and (row["method"] in CAUSAL or not causal):
            return row
    return None


def _method_rows(results: Results) -> list[tuple[str, list[str]]]:
    """Every method on motors with plain noise, best first: left of raw, lags, time."""
    scope = _plain(results)
    ratios = [results.ratio_to_raw(scope, metric) for metric in _COLUMNS]
    time_us = {
        row["method"]: row["time_us_per_pose"]
        for row in results.told["traits"]
        if row["representation"] == REFERENCE and not row["failure"]
    }
    ranked = [row["method"] for row in results.ranking(scope) if row["representation"] == REFERENCE]
    made = []
    for method in ranked:
        pair = (method, REFERENCE)
        cells = [percent(of[pair].value) for of in ratios]
        lags = [results.mean_size(scope, pair, m) for m in ("lag_ms", "angular_rate_lag_ms")]
        made.append((method, [*cells, *map(_whole, lags), shown(time_us.get(method), 2)]))
    return made


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
        "near gimbal lock angles turn many times as fast as "
        "the camera, and smoothing cuts their corners",
    ),
)


def _reasons(results: Results) -> list[str]:
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


def _left_out(plan: Mapping[str, Any]) -> list[str]:
    """Sentences on what was not run, a line a method and reason."""
    made = []
    for one in plan["left_out"]:
        on = [f"`{name}`" for name in one["representations"]]
        every = len(on) == len(plan["representations"])
        where = "" if every else f" on {listed(on)}"
        whole = len(one["degradations"]) == len(plan["degradations"])
        degraded = "" if whole else f" with {listed([LABELS[d] for d in one['degradations']])}"
        part = len(one["motions"]) < len(plan["motions"])
        on_motions = (
            f" over {len(one['motions'])} of {len(plan['motions'])} motions" if part else ""
        )
        made.append(f"`{one['method']}`{where}{degraded}{on_motions}: {one['reason']}.")
    return made


def _rows(table: Matrix) -> list[tuple[str, list[str]]]:
    return [(name, [cell.text for cell in cells]) for name, cells in table.rows]


def _starts(results: Results) -> list[tuple[str, str]]:
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
    told = [one["parameter"] for one in results.told["grids"].get(method, [])]
    values: dict[str, list[float]] = {}
    for motion in results.motions:
        row = results.parameters(motion, results.degradations[0]).get((method, REFERENCE))
        for name, value in (row["parameters"] if row else {}).items():
            if name in told or not searched_only:
                values.setdefault(name, []).append(value)
    return values


def _example(results: Results, causal: bool) -> dict[str, str]:
    """The best method that the examples can call, with the median of what was found."""
    for row in results.ranking():
        method = row["method"]
        if row["representation"] == REFERENCE and (method in CAUSAL) == causal:
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


def main(arguments: Sequence[str] | None = None) -> None:
    """Read a comparison's folder, print the page."""
    parser = argparse.ArgumentParser(prog="python -m docs.making.guide")
    parser.add_argument("folder", type=Path, help="of a finished `motorcade compare`")
    sys.stdout.write(guide(Results.read(parser.parse_args(arguments).folder)))


if __name__ == "__main__":
    main()
