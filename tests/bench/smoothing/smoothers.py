"""`make bench SUITE=smoothers`: `auto` beside scipy's smoothers on recorded motions under noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from tests.bench.data import data_folder
from tests.bench.smoothing.cells import JUDGED, OUTLIERS, cells, left

__all__ = ["bench_smoothers", "smoothers_table"]

_WINDOW, _ORDER = 9, 2


def _by_columns(way: Callable[[FloatArray, FloatArray], FloatArray], path: Trajectory) -> Motor:
    """Quaternions, their signs made continuous, and positions, each component for itself."""
    turned, position = path.motors.as_quaternion_translation()
    flips = np.sum(turned[1:] * turned[:-1], axis=1) < 0.0
    signs = np.cumprod(np.concatenate([[1.0], np.where(flips, -1.0, 1.0)]))
    made = [
        np.stack([way(path.time_s, column) for column in part.T], axis=-1)
        for part in (turned * signs[:, None], position)
    ]
    unit = made[0] / np.linalg.norm(made[0], axis=1, keepdims=True)
    return Motor.from_quaternion_translation(unit, made[1])


def _cross_validated(time_s: FloatArray, column: FloatArray) -> FloatArray:
    from scipy.interpolate import make_smoothing_spline

    return np.asarray(make_smoothing_spline(time_s, column)(time_s), dtype=np.float64)


def _savitzky_golay(time_s: FloatArray, column: FloatArray) -> FloatArray:
    from scipy.signal import savgol_filter

    return np.asarray(savgol_filter(column, _WINDOW, _ORDER), dtype=np.float64)


def bench_smoothers() -> dict[str, Any]:
    """What each leaves of error (e2), and of error and jitter (s4), on every cell at hand."""
    peers = {"scipy's spline, GCV": _cross_validated, "Savitzky-Golay": _savitzky_golay}
    rows = []
    for one in cells(tuple(JUDGED), data_folder()):
        found = {"auto": smooth(one.raw)}
        for name, way in peers.items():
            poses = _by_columns(way, one.raw)
            found[name] = Trajectory(one.raw.time_ns, poses, one.raw.parent, one.raw.child)
        for name, path in found.items():
            shares = left(path, one)
            rows.append(
                {"way": name, "motion": one.motion, "noise": one.noise}
                | {"e2": shares.e2, "s4": shares.s4, "added_deg": shares.added_deg}
            )
    return {"rows": rows}


def smoothers_table(figures: Mapping[str, Any]) -> str:
    """Geometric means over cells with and without outliers, and all cells."""
    rows = figures["rows"]
    ways = list(dict.fromkeys(row["way"] for row in rows))
    lines = ["way                    e2     s4     e2 without outliers  with  worse than raw"]
    for way in ways:
        own = [row for row in rows if row["way"] == way]
        wild = [row["e2"] for row in own if row["noise"] in OUTLIERS]
        quiet = [row["e2"] for row in own if row["noise"] not in OUTLIERS]
        worse = sum(row["e2"] > 1.0 for row in own)
        both = [_mean([row[key] for row in own]) for key in ("e2", "s4")]
        lines.append(
            f"{way:22s} {both[0]:.3f}  {both[1]:.3f}  {_mean(quiet):.3f}"
            f"                {_mean(wild):.3f} {worse}"
        )
    for row in rows:
        lines.append(
            f"{row['way']:22s} {row['e2']:.3f}  {row['s4']:.3f}  {row['motion']}, {row['noise']}"
        )
    return "\n".join(lines)


def _mean(values: list[float]) -> float:
    return float(np.exp(np.mean(np.log(values)))) if values else float("nan")
