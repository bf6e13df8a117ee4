"""What answering later gains on recorded flights: errors over the lag, and what that costs.

`python -m tests.bench.fusion.lag --flights V1_03 --disturbed "bursts 10%, moved as one"`: camera
poses of flights (20 Hz, 1 cm and 0.5° an axis, gaps of 2 s every 15 s), disturbed or not, fused
with one lag after another; errors at the stamps of the ground truth, gaps included, or at those of
the poses. Nothing in the filter was chosen for a lag.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from motorcade.fusion.filter import Fused, fuse
from motorcade.fusion.filter.fused import LAGS_S
from motorcade.fusion.metrics import absolute_translation_m, rotation_rad
from motorcade.ga import Motor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.data import data_folder
from tests.bench.fusion.disturbed import DISTURBANCES
from tests.bench.fusion.recorded import BLACKOUTS, FLIGHTS, NOISE, Flight, flight, measured
from tests.bench.timing import on_one_core

__all__ = ["bench_lag", "lag_table"]


def bench_lag(
    flights: tuple[str, ...] = FLIGHTS,
    seeds: range = range(3),
    disturbed: str = "undisturbed",
    *,
    between: bool = False,
) -> dict[str, Any]:
    """Every flight that is present with every lag; figures are of all seeds."""
    rows, left_out = [], []
    for name in flights:
        one = flight(name, data_folder())
        if one is None:
            left_out.append(f"{name}: not below {data_folder()}; set MOTORCADE_DATA")
            continue
        given = [_given(one, seed, disturbed) for seed in seeds]
        rows += [
            {"flight": name, **_figures(one, given, lag, between)} for lag in (*LAGS_S, np.inf)
        ]
    return {"disturbed": disturbed, "seeds": len(seeds), "rows": rows, "left_out": left_out}


def _given(one: Flight, seed: int, disturbed: str) -> PoseMeasurements:
    clean = measured(one, seed, degraded=BLACKOUTS)
    path = clean.trajectory
    rng = np.random.default_rng([seed, 77])
    poses, _ = DISTURBANCES[disturbed](path.motors, path.time_s - path.time_s[0], rng)
    return PoseMeasurements(
        Trajectory(path.time_ns, poses, path.parent, path.child), clean.covariance
    )


def _figures(
    one: Flight, given: list[PoseMeasurements], lag_s: float, between: bool
) -> dict[str, float]:
    metres, degrees, seconds, length_s = [], [], 0.0, 0.0
    by = partial(fuse, imu=one.imu, noise=NOISE, imu_T_camera=Motor.identity(), lag_s=lag_s)
    for poses in given:
        stamps = one.truth.time_ns if between else poses.trajectory.time_ns
        began = perf_counter()
        found: Fused = by(poses, stamps_ns=stamps)
        seconds += perf_counter() - began
        path, true = found.trajectory, one.truth.motors_at(found.trajectory.time_ns)
        metres.append(absolute_translation_m(path.motors, true))
        degrees.append(np.rad2deg(rotation_rad(path.motors, true)))
        length_s += path.duration_s
    every, turned = np.concatenate(metres), np.concatenate(degrees)
    return {
        "lag_s": lag_s,
        "rmse_m": float(np.sqrt(np.mean(every**2))),
        "median_m": float(np.median(every)),
        "max_m": float(every.max()),
        "rmse_deg": float(np.sqrt(np.mean(turned**2))),
        "seconds_a_second": seconds / length_s,
    }


def lag_table(found: Mapping[str, Any]) -> str:
    """A line a flight and lag."""
    lines = [
        f"{found['disturbed']}, {found['seeds']} seeds",
        f"{'flight, lag':<20}{'rms':>10}{'median':>10}{'max':>11}{'rotation':>10}"
        f"{'of real time':>14}",
    ]
    for row in found["rows"]:
        name = "all" if np.isinf(row["lag_s"]) else f"{row['lag_s']:g} s"
        lines.append(
            f"{row['flight'] + ', ' + name:<20}{1e3 * row['rmse_m']:>7.2f} mm"
            f"{1e3 * row['median_m']:>7.2f} mm{1e3 * row['max_m']:>8.1f} mm"
            f"{row['rmse_deg']:>9.3f}°{row['seconds_a_second']:>14.2%}"
        )
    return "\n".join([*lines, *(f"left out: {reason}" for reason in found["left_out"])])


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.fusion.lag")
    parser.add_argument("--flights", default=",".join(FLIGHTS), help="by commas")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--disturbed", default="undisturbed", choices=list(DISTURBANCES))
    parser.add_argument("--between", action="store_true", help="at the ground truth's stamps")
    given = parser.parse_args()
    with on_one_core():
        found = bench_lag(
            tuple(given.flights.split(",")), range(given.seeds), given.disturbed,
            between=given.between,
        )  # fmt: skip
    print(lag_table(found))


if __name__ == "__main__":
    main()
