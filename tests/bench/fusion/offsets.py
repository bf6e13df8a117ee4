"""A time offset put between the camera and the IMU of recorded flights, and found again.

`python -m tests.bench.fusion.offsets [--seeds N] [--flights NAME ...]`: 5 flights, 8 seeds.

The ground truth's clock is not the IMU's to a fraction of a millisecond, so what is found is held
against the offset between the gyroscope and the ground truth's own orientations, taken from these
alone, without noise. It depends on how long a turn is looked at: within 50 ms the ground truth is
the gyroscope, from which it was made; what it was corrected by has clocks of its own.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation, Slerp

from motorcade.fusion.imu import ADIS16448
from motorcade.fusion.motions.degradations import Degradation
from motorcade.fusion.sync import synchronise
from tests.bench.data import data_folder
from tests.bench.fusion.recorded import BLACKOUTS, DEGRADED, FLIGHTS, Flight, flight, measured

__all__ = [
    "bench_offsets",
    "found_offset",
    "offsets_table",
    "own_offset",
    "spread",
    "summed_turns",
]

_DELAYS_S = (0.005, 0.02, 0.05, -0.01)
_SEEDS = range(2)
_ALL_SEEDS = 8
_SPANS_S = (0.05, 0.15, 0.3, 1.0)
_SPAN_S = 0.15
_POSES: Mapping[str, Degradation] = {"blackouts": BLACKOUTS, "blackouts, outliers": DEGRADED}


def bench_offsets() -> dict[str, Any]:
    """Poses of V1_02 stamped late; a row a kind of poses, delay and seed."""
    one = flight("V1_02", data_folder())
    if one is None:
        return {"rows": [], "left_out": [f"V1_02: not below {data_folder()}; set MOTORCADE_DATA"]}
    rows = [
        {"poses": kind, "seed": seed, **found_offset(one, seed, delay_s, degraded)}
        for kind, degraded in _POSES.items()
        for delay_s in _DELAYS_S[:3]
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


def own_offset(one: Flight, span_s: float = _SPAN_S) -> float:
    """The gyroscope's clock minus that of the ground truth's orientations, seconds.

    That at which turns of both over spans are most alike, the rotation between them
    and the gyroscope's bias free; by SciPy's rotations, none of the product's.
    """
    zero = one.imu.time_ns[0]
    time_s = (one.imu.time_ns - zero) * 1e-9
    at_s = (one.truth.time_ns - zero) * 1e-9
    inside = (at_s > 0.1) & (at_s < time_s[-1] - 0.1)
    at_s, held = at_s[inside], Rotation.from_matrix(one.truth.motors.rotor.as_matrix()[inside])
    steps = max(1, round(span_s / float(np.median(np.diff(at_s)))))
    stride = max(1, steps // 4)
    first, last = np.arange(0, len(at_s) - steps, stride), np.arange(steps, len(at_s), stride)
    turned = held[first].inv() * held[last]
    span = (at_s[last] - at_s[first])[:, None]
    bias = np.zeros(3)
    for _ in range(3):  # what is left of the bias is small enough for turns to add up
        summed = summed_turns(time_s, one.imu.angular_rate_rad_s - bias)

        def left(x: np.ndarray, summed: Slerp = summed) -> np.ndarray:
            turn, now = Rotation.from_rotvec(x[1:4]), summed(at_s + 1e-3 * x[0])
            read = turn * now[first].inv() * now[last] * turn.inv()
            error: np.ndarray = (turned.inv() * read).as_rotvec() - x[4:] * span
            return error.ravel()

        scale = float(np.median(np.abs(left(np.zeros(7)))))
        found = least_squares(left, np.zeros(7), loss="cauchy", f_scale=3.0 * scale)
        bias = bias + found.x[4:]
    return 1e-3 * float(found.x[0])


def summed_turns(time_s: np.ndarray, rate: np.ndarray) -> Slerp:
    """Orientations that a gyroscope's rates add up to."""
    steps = Rotation.from_rotvec(0.5 * (rate[1:] + rate[:-1]) * np.diff(time_s)[:, None])
    turns = [Rotation.identity()]
    for step in steps:
        turns.append(turns[-1] * step)
    return Slerp(time_s, Rotation.concatenate(turns))


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


def spread(one: Flight, seeds: int) -> Iterator[tuple[float, float]]:
    """Errors and stated deviations (s) against the ground truth's own offset, a pair a seed."""
    own_s = own_offset(one)
    for seed in range(seeds):
        row = found_offset(one, seed, _DELAYS_S[seed % len(_DELAYS_S)], DEGRADED)
        if row["found_s"] is None:
            yield np.nan, np.nan
        else:
            yield row["delay_s"] - row["found_s"] - own_s, row["sigma_s"]


def main() -> int:
    """Print errors flight by flight; 1 where fewer than 95 % lie within two stated deviations."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=_ALL_SEEDS)
    parser.add_argument("--flights", nargs="+", choices=FLIGHTS, default=list(FLIGHTS))
    options = parser.parse_args()
    within = runs = 0
    for name in options.flights:
        one = flight(name, data_folder())
        if one is None:
            print(f"{name}: not below {data_folder()}; set MOTORCADE_DATA")
            continue
        own = ", ".join(f"{1e3 * own_offset(one, span):.2f} ({span:g} s)" for span in _SPANS_S)
        print(f"{name}: ground truth's own offset by turns over spans, ms: {own}")
        pairs = 1e3 * np.array(list(spread(one, options.seeds)))
        error, sigma = pairs.T
        inside = int(np.count_nonzero(np.abs(error) <= 2.0 * sigma))
        within, runs = within + inside, runs + len(error)
        print(
            f"{name}: error {np.mean(error):+.2f} ± {np.std(error) / np.sqrt(len(error)):.2f} ms "
            f"in the mean, RMS {np.sqrt(np.mean(error**2)):.2f}, stated σ {np.mean(sigma):.2f}, "
            f"{inside} of {len(error)} within 2 σ: "
            + " ".join(f"{a:+.2f}±{b:.2f}" for a, b in pairs),
            flush=True,
        )
    print(f"{within} of {runs} within two stated deviations")
    return int(within < 0.95 * runs)


if __name__ == "__main__":
    sys.exit(main())
