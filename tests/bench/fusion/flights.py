"""Accuracy on recorded flights over twenty seeds of noise: outside blackouts, and in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from motorcade.fusion.filter import Fused, fuse
from motorcade.fusion.graph import fuse_by_graph
from motorcade.fusion.metrics import absolute_translation_m, rotation_rad
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.data import data_folder
from tests.bench.fusion.recorded import (
    BLACKOUTS,
    NOISE,
    SETTINGS,
    Flight,
    flight,
    measured,
)

__all__ = ["bench_flights", "flight_figures", "flights_table"]

Fusing = Callable[[Flight, PoseMeasurements], tuple[Fused, Fused | None]]

SEEDS = 20
_DIVERGED_M, _DIVERGED_DEG = 0.5, 5.0
_SETTLED_S = 5.0


def bench_flights(seeds: int = SEEDS) -> dict[str, Any]:
    """Every flight that is present, by the filter and by gtsam's graph; figures are of all seeds.

    The graph has nodes at 20 Hz alone, where it is judged, and estimates no vertical.
    """
    rows, left_out = [], []
    for name in ("V1_02", "V1_01"):
        one = flight(name, data_folder())
        if one is None:
            left_out.append(f"{name}: not below {data_folder()}; set MOTORCADE_DATA")
            continue
        rows.append({"flight": name, "by": "filter", **flight_figures(one, range(seeds))})
        try:
            figures = flight_figures(one.thinned(20.0), range(seeds), _by_graph)
        except ModuleNotFoundError as fault:
            left_out.append(f"{name} by a graph: needs the Python package {fault.name}")
            continue
        rows.append({"flight": name, "by": "gtsam's graph", **figures})
    return {"rows": rows, "left_out": left_out}


def _by_filter(one: Flight, poses: PoseMeasurements) -> tuple[Fused, Fused | None]:
    smoothed, online = (
        fuse(
            poses,
            one.imu,
            NOISE,
            Motor.identity(),
            one.truth.time_ns,
            settings=SETTINGS,
            smoothed=ahead,
        )
        for ahead in (True, False)
    )
    return smoothed, online


def _by_graph(one: Flight, poses: PoseMeasurements) -> tuple[Fused, Fused | None]:
    return fuse_by_graph(poses, one.imu, NOISE, Motor.identity(), one.truth.time_ns), None


def flight_figures(one: Flight, seeds: range, fused: Fusing = _by_filter) -> dict[str, Any]:
    """Errors of a flight fused with the poses of every seed, at the ground truth's stamps.

    "Ends" are the last stamps of blackouts, "gaps" their worst ones. A window reaches from the
    start of one blackout to that of the next, the first from the first pose; it has diverged
    where any smoothed error exceeds 0.5 m or 5°.
    """
    each = [_seed(one, *fused(one, measured(one, seed))) for seed in seeds]
    joined = {key: np.concatenate([np.atleast_1d(row[key]) for row in each]) for key in each[0]}
    figures: dict[str, Any] = {
        "seeds": len(seeds),
        "outside_rmse_m": float(joined["outside_m"].max()),
        "outside_rmse_deg": float(joined["outside_deg"].max()),
        "outside_mean_rmse_m": float(joined["outside_m"].mean()),
        "outside_mean_rmse_deg": float(joined["outside_deg"].mean()),
        "gap_worst_median_m": float(np.median(joined["gaps_m"])),
        "gap_worst_p90_m": float(np.quantile(joined["gaps_m"], 0.9)),
        "gap_worst_max_m": float(joined["gaps_m"].max()),
        "gaps": int(joined["gaps_m"].size),
        "windows": int(joined["diverged"].size),
        "windows_diverged": int(np.count_nonzero(joined["diverged"])),
    }
    if "ends_m" in joined:
        figures["online_end_median_m"] = float(np.median(joined["ends_m"]))
        figures["online_end_max_m"] = float(joined["ends_m"].max())
        figures["nis_per_dimension"] = float(joined["nis"].mean()) / 6.0
    for key in ("gyro_bias_rad_s", "accel_bias_m_s2"):
        if key in joined:
            figures[f"{key}_worst"] = float(joined[key].max())
    return figures


def _seed(one: Flight, smoothed: Fused, online: Fused | None) -> dict[str, Any]:
    """Errors of one seed, those of the online path only where there is one."""
    seconds = (one.truth.time_ns - one.truth.time_ns[0]) * 1e-9
    dark = BLACKOUTS.dark(seconds, one.truth.duration_s)
    metres, degrees = _errors(one, smoothed)
    spans = BLACKOUTS.spans_s(one.truth.duration_s)
    inside = [dark & (seconds >= start - 0.1) & (seconds <= end) for start, end in spans]
    edges = np.searchsorted(seconds, [0.0, *spans[:, 0], np.inf])
    windows = [slice(a, b) for a, b in pairwise(edges)]
    lost = (metres > _DIVERGED_M) | (degrees > _DIVERGED_DEG)
    row: dict[str, Any] = {
        "outside_m": _rms(metres[~dark]),
        "outside_deg": _rms(degrees[~dark]),
        "gaps_m": np.array([metres[at].max() for at in inside]),
        "diverged": np.array([np.any(lost[at]) for at in windows]),
    }
    if online is not None:
        live, _ = _errors(one, online)
        row["ends_m"] = np.array([live[at][-1] for at in inside])
        row["nis"] = np.nanmean(online.nis[online.accepted])
    settled = seconds > _SETTLED_S
    for key in ("gyro_bias_rad_s", "accel_bias_m_s2"):
        true = getattr(one, key)
        if true is not None:
            row[key] = np.abs(getattr(smoothed, key) - true)[settled].max()
    return row


def _errors(one: Flight, fused: Fused) -> tuple[FloatArray, FloatArray]:
    found, true = fused.trajectory.motors, one.truth.motors
    return absolute_translation_m(found, true), np.rad2deg(rotation_rad(found, true))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def flights_table(found: Mapping[str, Any]) -> str:
    """A line a figure and flight."""
    lines = [
        "poses simulated from ground truth (20 Hz, 1 cm, 0.5°, 2 % outliers, blackouts of 2 s)",
        f"gyroscope {NOISE.gyro_density_rad_s_rthz:.3g} rad/s/√Hz, walk "
        f"{NOISE.gyro_walk_rad_s2_rthz:.3g}; accelerometer {NOISE.accel_density_m_s2_rthz:.3g} "
        f"m/s²/√Hz, walk {NOISE.accel_walk_m_s3_rthz:.3g}",
    ]
    for row in found["rows"]:
        lines += _lines(row)
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)


def _lines(row: Mapping[str, Any]) -> list[str]:
    name = f"{row['flight']}, {row['by']}, {row['seeds']} seeds: "
    lines = [
        f"{name + 'smoothed outside blackouts, worst seed (mean)':<82}"
        f"{1e3 * row['outside_rmse_m']:>8.2f} mm ({1e3 * row['outside_mean_rmse_m']:.2f})"
        f"{row['outside_rmse_deg']:>8.3f}° ({row['outside_mean_rmse_deg']:.3f})",
        f"{name + 'smoothed, worst in a blackout, median, 90 %, max':<82}"
        f"{1e2 * row['gap_worst_median_m']:>8.1f} cm{1e2 * row['gap_worst_p90_m']:>8.1f} cm"
        f"{1e2 * row['gap_worst_max_m']:>8.1f} cm",
        f"{name + 'windows diverged':<82}{row['windows_diverged']:>8} of {row['windows']}",
    ]
    if "online_end_median_m" in row:
        lines += [
            f"{name + 'online at the ends of blackouts, median, max':<82}"
            f"{1e2 * row['online_end_median_m']:>8.1f} cm{1e2 * row['online_end_max_m']:>8.1f} cm",
            f"{name + 'mean NIS a dimension':<82}{row['nis_per_dimension']:>8.2f}",
        ]
    if "gyro_bias_rad_s_worst" in row:
        lines.append(
            f"{name + 'biases, furthest from the recorded ones':<82}"
            f"{row['gyro_bias_rad_s_worst']:>8.5f} rad/s{row['accel_bias_m_s2_worst']:>8.3f} m/s²"
        )
    return lines
