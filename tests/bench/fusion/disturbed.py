"""What wrong starts, outliers, bursts of them and relocated maps leave in a smoothed flight.

`python -m tests.bench.fusion.disturbed --flights V1_03 --seeds 3 --graph`: camera poses of recorded
flights (20 Hz, 1 cm and 0.5° an axis, gaps of 2 s every 15 s), disturbed in one way a row, fused
with default settings, and errors at the stamps of all of them. "Known" is the same filter without
the wrong poses: what could be had. Constants of the filter were chosen on V1_02 and MH_05.
NEES/6 of the smoothed path, one where deviations are honest, stands beside gtsam's; `--only
undisturbed --seeds 10 --graph` is what may be had of ordinary poses.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter import Fused, fuse
from motorcade.fusion.graph import fuse_by_graph
from motorcade.fusion.metrics import absolute_translation_m, normalised_squared, rotation_rad
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.data import data_folder
from tests.bench.fusion.ground_truth import found_faults, set_right
from tests.bench.fusion.recorded import BLACKOUTS, FLIGHTS, NOISE, Flight, flight, measured
from tests.bench.timing import on_one_core

__all__ = ["DISTURBANCES", "bench_disturbed", "disturbed_figures", "disturbed_table"]

Disturbance = Callable[[Motor, FloatArray, np.random.Generator], tuple[Motor, NDArray[np.bool_]]]
"""Poses, their seconds and a generator in; poses and which of them are wrong out."""

_OFF_M, _OFF_RAD = 2.0, np.deg2rad(90.0)
_BURST_S = 1.0
_AFTER_S = 1.0  # live, a wrong start may cost the first second


def _undisturbed(
    poses: Motor, seconds: FloatArray, rng: np.random.Generator
) -> tuple[Motor, NDArray[np.bool_]]:
    return poses, np.zeros(len(seconds), dtype=np.bool_)


def _off(count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Shifts uniform in a cube, and turns by uniform angles about any axis."""
    axis = rng.standard_normal((count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    angle = rng.uniform(-_OFF_RAD, _OFF_RAD, (count, 1))
    return rng.uniform(-_OFF_M, _OFF_M, (count, 3)), angle * axis


def _moved(poses: Motor, shift_m: FloatArray, turn_rad: FloatArray) -> Motor:
    """Poses shifted in the world and turned in place."""
    right = Motor.from_twist(np.hstack([turn_rad, np.zeros_like(turn_rad)]))
    left = Motor.from_twist(np.hstack([np.zeros_like(shift_m), shift_m]))
    return left @ poses @ right


def _start(shift_m: float, turn_deg: float) -> Disturbance:
    def disturb(
        poses: Motor, seconds: FloatArray, rng: np.random.Generator
    ) -> tuple[Motor, NDArray[np.bool_]]:
        axes = rng.standard_normal((2, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        wrong = np.arange(len(seconds)) == 0
        shift, turn = shift_m * axes[0], np.deg2rad(turn_deg) * axes[1]
        return _moved(poses, wrong[:, None] * shift, wrong[:, None] * turn), wrong

    return disturb


def _outliers(share: float) -> Disturbance:
    def disturb(
        poses: Motor, seconds: FloatArray, rng: np.random.Generator
    ) -> tuple[Motor, NDArray[np.bool_]]:
        wrong = rng.random(len(seconds)) < share
        shift, turn = _off(len(seconds), rng)
        return _moved(poses, wrong[:, None] * shift, wrong[:, None] * turn), wrong

    return disturb


def _bursts(share: float, together: bool, burst_s: float = _BURST_S) -> Disturbance:
    """In bursts, each pose by itself or all of one by the same motion of the world."""

    def disturb(
        poses: Motor, seconds: FloatArray, rng: np.random.Generator
    ) -> tuple[Motor, NDArray[np.bool_]]:
        period = burst_s / share
        starts = np.arange(0.0, seconds[-1], period)
        starts = starts + rng.uniform(0.0, period - burst_s, len(starts))
        inside = (seconds[:, None] >= starts) & (seconds[:, None] < starts + burst_s)
        wrong = np.any(inside, axis=1)
        if not together:
            shift, turn = _off(len(seconds), rng)
            return _moved(poses, wrong[:, None] * shift, wrong[:, None] * turn), wrong
        shift, turn = _off(len(starts), rng)
        left = Motor.from_twist(inside @ np.hstack([turn, shift]))
        return left @ poses, wrong

    return disturb


DISTURBANCES: Mapping[str, Disturbance] = {
    "undisturbed": _undisturbed,
    **{
        f"start off by {shift_m:g} m, {turn_deg:g}°": _start(shift_m, turn_deg)
        for shift_m, turn_deg in (
            (0.2, 0), (0.5, 0), (1, 0), (3, 0), (10, 0), (0, 5), (0, 30), (0, 180), (0.2, 5),
            (1, 30), (10, 180),
        )
    },
    **{f"outliers {share:.0%}": _outliers(share) for share in (0.1, 0.3, 0.5)},
    **{f"bursts {share:.0%}": _bursts(share, False) for share in (0.1, 0.3, 0.5)},
    **{f"bursts {share:.0%}, moved as one": _bursts(share, True) for share in (0.1, 0.3)},
    "bursts of 3 s, 10%, moved as one": _bursts(0.1, True, 3.0),
}  # fmt: skip
"""By name, what is done to the poses."""


def bench_disturbed(
    flights: tuple[str, ...] = FLIGHTS,
    seeds: range = range(3),
    *,
    graph: bool = False,
    only: str = "",
    upright: bool = False,
) -> dict[str, Any]:
    """Every flight that is present, disturbed in every way whose name contains `only`."""
    rows, left_out = [], []
    for name in flights:
        one = flight(name, data_folder())
        if one is None:
            left_out.append(f"{name}: not below {data_folder()}; set MOTORCADE_DATA")
            continue
        if upright:
            one = set_right(one, found_faults(one))
        rows += [
            {"flight": name, "disturbed": how, **disturbed_figures(one, how, seeds, graph=graph)}
            for how in DISTURBANCES
            if only in how
        ]
    return {"rows": rows, "left_out": left_out}


def disturbed_figures(
    one: Flight, how: str, seeds: range, *, graph: bool = False
) -> dict[str, Any]:
    """Errors and times of all seeds: worst and root mean square, and the median of the times."""
    found: dict[str, list[float]] = {}
    for seed in seeds:
        for key, value in _seed(one, how, seed, graph).items():
            found.setdefault(key, []).append(value)
    joined: dict[str, Callable[[list[float]], Any]] = {
        "max": np.max,
        "share": np.mean,
        "nees": np.mean,
        "mean": np.mean,
        "seconds": np.median,
    }
    return {
        key: float(joined.get(key.rpartition("_")[2], _rms)(values))
        for key, values in found.items()
    }


def _seed(one: Flight, how: str, seed: int, graph: bool) -> dict[str, float]:
    clean = measured(one, seed, degraded=BLACKOUTS)
    path = clean.trajectory
    poses, wrong = DISTURBANCES[how](
        path.motors, path.time_s - path.time_s[0], np.random.default_rng([seed, 77])
    )
    given = PoseMeasurements(
        Trajectory(path.time_ns, poses, path.parent, path.child), clean.covariance
    )
    known = PoseMeasurements(path[~wrong], clean.covariance[~wrong])
    first = np.flatnonzero(~wrong)[0]
    by = partial(fuse, imu=one.imu, noise=NOISE, imu_T_camera=Motor.identity())
    made: dict[str, float] = {}
    for name, fused, measurements, stamps in (
        ("robust", by, given, path.time_ns),
        ("live", partial(by, smoothed=False), given, path.time_ns),
        ("known", by, known, path.time_ns[first:]),
        ("known_live", partial(by, smoothed=False), known, path.time_ns[first:]),
        ("graph", partial(fuse_by_graph, imu=one.imu, noise=NOISE, imu_T_camera=Motor.identity()),
         given, path.time_ns),
    ):  # fmt: skip
        if name == "graph" and not graph:
            continue
        began = perf_counter()
        result: Fused = fused(measurements, stamps_ns=stamps)
        made[f"{name}_seconds"] = perf_counter() - began
        error, turned = _errors(one, result)
        if name in ("robust", "graph"):
            made[f"{name}_mean"] = float(error.mean())
            made[f"{name}_nees"] = _nees(one, result)
        if name in ("live", "known_live"):
            settled = (result.trajectory.time_ns - path.time_ns[0]) * 1e-9 > _AFTER_S
            error, turned = error[settled], turned[settled]
        made[f"{name}_m"], made[f"{name}_m_max"] = _rms(error), float(error.max())
        made[f"{name}_deg_max"] = float(turned.max())
        if name == "robust":
            made["misjudged_share"] = float(np.mean(result.accepted == wrong))
    return made


def _errors(one: Flight, fused: Fused) -> tuple[FloatArray, FloatArray]:
    found, true = fused.trajectory.motors, one.truth.motors_at(fused.trajectory.time_ns)
    return absolute_translation_m(found, true), np.rad2deg(rotation_rad(found, true))


def _nees(one: Flight, fused: Fused) -> float:
    """Mean normalised square of the pose's error, a dimension."""
    off = fused.trajectory.motors.local(one.truth.motors_at(fused.trajectory.time_ns))
    return float(np.mean(normalised_squared(off, fused.covariance))) / 6.0


def _rms(values: FloatArray | list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def disturbed_table(found: Mapping[str, Any]) -> str:
    """A line a flight and disturbance; errors in mm, worst in parentheses."""
    lines = [
        f"{'position error, rms (max), mm':<38}{'smoothed':>18}{'known':>16}"
        f"{'live after 1 s':>20}{'/ known':>8}{'gtsam':>18}{'rotation':>10}{'misjudged':>11}"
        f"{'NEES/6':>8}{'gtsam':>7}{'mean / gtsam':>14}{'time':>9}{'/ known':>8}{'/ gtsam':>8}"
    ]
    for row in found["rows"]:
        both = {
            name: f"{1e3 * row[f'{name}_m']:.2f} ({1e3 * row[f'{name}_m_max']:.1f})"
            if f"{name}_m" in row
            else "-"
            for name in ("robust", "known", "live", "graph")
        }
        beside = row["robust_seconds"] / row.get("graph_seconds", np.nan)
        mean = row["robust_mean"] / row.get("graph_mean", np.nan)
        lines.append(
            f"{row['flight'] + ', ' + row['disturbed']:<38}{both['robust']:>18}{both['known']:>16}"
            f"{both['live']:>20}{row['live_m'] / row['known_live_m']:>8.2f}"
            f"{both['graph']:>18}{row['robust_deg_max']:>9.2f}°"
            f"{row['misjudged_share']:>11.2%}{row['robust_nees']:>8.2f}"
            f"{row.get('graph_nees', np.nan):>7.2f}{mean:>14.2f}"
            f"{1e3 * row['robust_seconds']:>6.0f} ms"
            f"{row['robust_seconds'] / row['known_seconds']:>8.2f}{beside:>8.2f}"
        )
    return "\n".join([*lines, *(f"left out: {reason}" for reason in found["left_out"])])


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.fusion.disturbed")
    parser.add_argument("--flights", default=",".join(FLIGHTS), help="by commas")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--graph", action="store_true", help="gtsam's batch beside it")
    parser.add_argument("--only", default="", help="disturbances whose name contains this")
    parser.add_argument("--upright", action="store_true", help="the ground truth set right before")
    given = parser.parse_args()
    with on_one_core():
        found = bench_disturbed(
            tuple(given.flights.split(",")),
            range(given.seeds),
            graph=given.graph,
            only=given.only,
            upright=given.upright,
        )
    print(disturbed_table(found))


if __name__ == "__main__":
    main()
