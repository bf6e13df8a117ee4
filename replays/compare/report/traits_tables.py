"""Tables of what a method in a representation is on any path: frame-change defects, time, ties."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping
from typing import Any

from motorcade.replays.compare.report.matrix import Matrix
from motorcade.replays.compare.report.names import shown
from motorcade.replays.compare.report.results import REFERENCE, Results
from motorcade.replays.pages.parts import PageCell

__all__ = ["exact_ties", "trait_matrices", "verdict_counts"]

_DEFECTS = (1e-10, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
_DEFECT_TINTS = ("b3", "n", "o1", "o2", "o3", "o4", "o5")
_TIMES_US = (1.0, 3.0, 10.0, 100.0, 1000.0)
_TIME_TINTS = ("b3", "b1", "n", "o1", "o2", "o3")
_RATIO_METRICS = ("ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2", "angular_jitter_rad_s2")


def trait_matrices(results: Results) -> list[Matrix]:
    """Defects on the world's and the sensor's side, and the time a pose."""
    rows = {
        (row["method"], row["representation"]): row
        for row in results.told["traits"]
        if not row["failure"]
    }
    if not rows:
        return []
    poses = next(iter(rows.values()))["poses"]
    tables = (
        (
            "left",
            "world's frame",
            "Largest difference between smoothing and then changing the world's frame, and the "
            "other way round. Blue is none but rounding (at most 1e-10).",
        ),
        ("right", "sensor's frame", "The same for the frame of the sensor: another mount."),
        ("time", "time a pose", f"Microseconds a pose over {poses} poses, called from Python."),
    )
    made = []
    for key, title, caption in tables:
        body = [
            (method, [_cell(rows.get((method, one)), key) for one in results.representations])
            for method in results.methods
        ]
        made.append(
            Matrix(f"trait-{key}", "", title, caption, "method", results.representations, body)
        )
    return made


def _cell(row: Mapping[str, Any] | None, key: str) -> PageCell:
    if row is None:
        return PageCell("–", math.nan, "none")
    if key == "time":
        value = row["time_us_per_pose"]
        return PageCell(shown(value), value, _TIME_TINTS[bisect_left(_TIMES_US, value)])
    metres, radians = row[f"{key}_defect_m"], row[f"{key}_defect_rad"]
    value = max(metres, radians)
    tint = _DEFECT_TINTS[bisect_left(_DEFECTS, value)]
    text = f"{value:.0e}" if value <= _DEFECTS[0] else f"{shown(value, 2)}"
    unit = "m" if value == metres else "rad"
    note = f"{metres:.1e} m, {radians:.1e} rad"
    return PageCell(f"{text} {unit}", value, tint, note=note)


def exact_ties(results: Results) -> list[dict[str, Any]]:
    """A row a tie that theory predicts, over the methods it was tried on."""
    ties = results.told["exact_ties"]
    made = []
    for theory in dict.fromkeys(one["theory"] for one in ties):
        of = [one for one in ties if one["theory"] == theory]
        largest = {
            unit: max((one[f"largest_difference_{unit}"] or 0.0 for one in of), default=0.0)
            for unit in ("m", "rad")
        }
        made.append(
            {
                "theory": theory,
                "reason": of[0]["reason"],
                "methods": [one["method"] for one in of],
                "fails": [one["method"] for one in of if not one["holds"]],
                "holds": all(one["holds"] for one in of),
                "m": largest["m"],
                "rad": largest["rad"],
                "shown": " and ".join(
                    f"{value:.0e} {unit}" for unit, value in largest.items() if value > 0.0
                ),
            }
        )
    return made


def verdict_counts(results: Results) -> list[dict[str, Any]]:
    """Place by place, method by method: how often each representation beats or ties with motors.

    Over APE, rotation error and both jitters.
    """
    made = []
    for name in results.representations:
        rows = [
            row
            for row in results.told["verdicts"]
            if row["representation"] == name and row["metric"] in _RATIO_METRICS
        ]
        if name == REFERENCE or not rows:
            continue
        counts = {key: sum(row[key] for row in rows) for key in ("better", "tie", "equal", "worse")}
        total = sum(counts.values())
        shares = {key: 100.0 * count / total for key, count in counts.items()}
        made.append({"name": name, "total": total, "counts": counts, "shares": shares})
    return made
