"""Orientation by inertial readings on trials of BROAD and flights of EuRoC, beside VQF's package.

python -m tests.bench.fusion.orientation
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from time import process_time
from typing import Any

import numpy as np

from motorcade.ga import Rotor
from tests.bench.data import data_folder
from tests.bench.fusion.broad import (
    BroadTrial,
    broad_errors,
    by_vqf,
    estimated,
    read_trial,
    trial_paths,
)
from tests.bench.fusion.recorded import FLIGHTS, flight
from tests.bench.timing import on_one_core

__all__ = ["bench_orientation", "orientation_table"]

_SETS = ("BROAD, 6 axes", "BROAD, 9 axes", "EuRoC, 6 axes")
_Method = Callable[[BroadTrial, bool, bool], Rotor]
_KINDS = ("inclination_deg", "heading_deg", "total_deg")


def bench_orientation() -> dict[str, Any]:
    """Every trial at hand, with and without magnetometer, online and offline; samples a second."""
    if not trial_paths():
        return {"rows": [], "left_out": ["BROAD: no trials; set MOTORCADE_DATA"]}
    try:
        trials = {"BROAD": [read_trial(path) for path in trial_paths()], "EuRoC": _flights()}
    except ModuleNotFoundError as fault:
        return {"rows": [], "left_out": [f"BROAD: needs the Python package {fault.name}"]}
    rows, left_out = [], []
    with on_one_core():
        for axes, smooth in product(_SETS, (False, True)):
            row: dict[str, Any] = {"axes": axes, "way": "offline" if smooth else "online"}
            chosen = trials[axes.partition(",")[0]]
            if not chosen:
                continue
            for name, method in (("ours", estimated), ("vqf", by_vqf)):
                try:
                    row[name] = _measured(chosen, method, smooth, "9 axes" in axes)
                except ModuleNotFoundError as fault:
                    left_out = [f"VQF: needs the Python package {fault.name}"]
            rows.append(row)
    return {"rows": rows, "left_out": left_out}


def _flights() -> list[BroadTrial]:
    """Flights as trials: samples count that have a ground truth."""
    made = []
    for name in FLIGHTS:
        one = flight(name, data_folder())
        if one is None or name == "V1_01":  # of whose ground truth there are few stamps
            continue
        stamps, first = one.imu.time_ns, one.truth.time_ns[0]
        inside = (stamps >= first) & (stamps <= one.truth.time_ns[-1])
        truth = one.truth.motors_at(np.clip(stamps, first, one.truth.time_ns[-1])).rotor
        none = np.full((len(one.imu), 3), np.nan)
        made.append(BroadTrial(name, one.imu, none, truth, inside))
    return made


def _measured(
    trials: list[BroadTrial], method: _Method, smooth: bool, magnetometer: bool
) -> dict[str, Any]:
    """Errors by trial, and samples a second of the processor."""
    found, seconds = {}, 0.0
    for trial in trials:
        start = process_time()
        estimate = method(trial, smooth, magnetometer)
        seconds += process_time() - start
        found[trial.name] = broad_errors(trial, estimate)
    samples = sum(len(trial.imu) for trial in trials)
    return {"errors": found, "samples_per_s": samples / seconds}


def orientation_table(found: Mapping[str, Any]) -> str:
    """Trials in columns; means and speed at the end of each line."""
    lines = []
    for row in found["rows"]:
        kinds = _KINDS if "9 axes" in row["axes"] else _KINDS[:1]
        names = list(row["ours"]["errors"])
        lines.append(f"{row['axes']}, {row['way']:<10}" + "".join(f"{n:>6}" for n in names))
        lines[-1] += f"{'mean':>8}{'worst ratio':>13}{'M/s':>6}"
        for kind in kinds:
            for name in ("ours", "vqf"):
                if name not in row:
                    continue
                errors = [trial[kind] for trial in row[name]["errors"].values()]
                line = f"  {kind.removesuffix('_deg'):<12} {name:<10}"
                line += "".join(f"{error:>6.2f}" for error in errors) + f"{np.mean(errors):>8.3f}"
                if name == "ours" and "vqf" in row:
                    rivals = [trial[kind] for trial in row["vqf"]["errors"].values()]
                    line += f"{max(np.divide(errors, rivals)):>13.2f}"
                else:
                    line += " " * 13
                lines.append(line + f"{1e-6 * row[name]['samples_per_s']:>6.1f}")
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)


if __name__ == "__main__":
    print(orientation_table(bench_orientation()))
