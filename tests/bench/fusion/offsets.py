"""A time offset put between the camera and the IMU of a recorded flight, and found again."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter
from typing import Any

from motorcade.fusion.imu import ADIS16448
from motorcade.fusion.motions.degradations import Degradation
from motorcade.fusion.sync import synchronise
from tests.bench.data import data_folder
from tests.bench.fusion.recorded import BLACKOUTS, DEGRADED, Flight, flight, measured

__all__ = ["bench_offsets", "found_offset", "offsets_table"]

_DELAYS_S = (0.005, 0.02, 0.05)
_SEEDS = range(2)
_POSES: Mapping[str, Degradation] = {"blackouts": BLACKOUTS, "blackouts, outliers": DEGRADED}


def bench_offsets() -> dict[str, Any]:
    """Poses of V1_02 stamped late; a row a kind of poses, delay and seed."""
    one = flight("V1_02", data_folder())
    if one is None:
        return {"rows": [], "left_out": [f"V1_02: not below {data_folder()}; set MOTORCADE_DATA"]}
    rows = [
        {"poses": kind, "seed": seed, **found_offset(one, seed, delay_s, degraded)}
        for kind, degraded in _POSES.items()
        for delay_s in _DELAYS_S
        for seed in _SEEDS
    ]
    return {"rows": rows, "left_out": []}


def found_offset(one: Flight, seed: int, delay_s: float, degraded: Degradation) -> dict[str, Any]:
    """What is found where the camera's stamps are late by a delay; `refused` says why nothing."""
    start = perf_counter()
    path = measured(one, seed, delay_s, degraded).trajectory
    try:
        found = synchronise(path, one.imu, ADIS16448)
    except ValueError as refusal:
        return {"delay_s": delay_s, "found_s": None, "sigma_s": None, "refused": str(refusal)}
    return {
        "delay_s": delay_s,
        "found_s": -found.offset_s,
        "sigma_s": found.offset_sigma_s,
        "seconds": perf_counter() - start,
    }


def offsets_table(found: Mapping[str, Any]) -> str:
    """A line a kind of poses and delay: what each seed found."""
    lines = [
        f"{'V1_02: camera stamped late, poses with':<34}{'by (ms)':>10}   found (ms), stated σ"
    ]
    for kind, delay_s in dict.fromkeys((row["poses"], row["delay_s"]) for row in found["rows"]):
        of = [row for row in found["rows"] if (row["poses"], row["delay_s"]) == (kind, delay_s)]
        each = "".join(
            f"{'refused':>10}        "
            if row["found_s"] is None
            else f"{1e3 * row['found_s']:>10.2f} ± {1e3 * row['sigma_s']:<5.2f}"
            for row in of
        )
        lines.append(f"{kind:<38}{1e3 * delay_s:>6g}{each}")
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)
