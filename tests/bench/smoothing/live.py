"""`make bench SUITE=live`: smoothing with nothing to tune, beside filters tuned on ground truth.

Three flights of EuRoC under sixteen kinds of noise, none of which a constant of `LiveSmoother` was
chosen on. Each peer is tuned anew on the ground truth of every cell, and the best of all peers is
what counts. Then poses foretold 50 ms ahead beside the last measured one held, on the standard
motions; and the time of one update, arrays in and arrays out.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import LiveSmoother, smooth
from motorcade.ga import Motor
from tests.bench.data import data_folder
from tests.bench.smoothing.cells import JUDGED, cells, left

__all__ = ["bench_live", "live_table"]

PEERS = ("exponential", "double_exponential", "one_euro", "constant_velocity")
WITHIN = 1.05
AHEAD_S, RATE_HZ, SECONDS = 0.05, 60.0, 20.0
NOISES = ((0.001, 0.1), (0.005, 0.5))
UPDATES = 5000


@dataclass(frozen=True)
class LiveRow:
    """What is left of a cell's error (e2) and of error and jitter (s4), and the best peer's e2."""

    motion: str
    noise: str
    e2: float
    s4: float
    best_e2: float
    best: str


def bench_live(folder: Path | None = None) -> dict[str, Any]:
    """Figures of all three questions."""
    found = data_folder() if folder is None else folder
    rows = [] if found is None else [asdict(row) for row in _rows(found)]
    return {"cells": rows, "ahead": _ahead(), "update_us": _update_us()}


def _rows(folder: Path) -> Iterator[LiveRow]:
    for one in cells(tuple(JUDGED), folder):
        ours, best, name = left(LiveSmoother().smooth(one.raw), one), np.inf, "none"
        for peer, settings in _settings():
            share = left(smooth(one.raw, peer, "rotor", **settings), one).e2
            if share < best:
                best, name = share, peer
        yield LiveRow(one.motion, one.noise, ours.e2, ours.s4, best, name)


def _settings() -> Iterator[tuple[str, dict[str, Any]]]:
    """What peers are tuned over: below half the rate of 20 Hz."""
    for cutoff_hz in np.geomspace(0.3, 9.0, 10):
        yield "exponential", {"cutoff_hz": cutoff_hz}
    for cutoff_hz in np.geomspace(1.0, 9.0, 6):
        for share in (0.2, 0.5, 1.0):
            yield (
                "double_exponential",
                {"cutoff_hz": cutoff_hz, "trend_cutoff_hz": share * cutoff_hz},
            )
    for cutoff_hz in (0.2, 0.5, 1.0, 2.0, 4.0):
        for beta in (0.5, 2.0, 5.0, 10.0, 30.0):
            yield (
                "one_euro",
                {"min_cutoff_hz": cutoff_hz, "beta_per_rad": beta, "beta_per_m": beta},
            )
    for noise_m in np.geomspace(1e-3, 3e-2, 4):
        for noise_rad in np.deg2rad(np.geomspace(0.1, 3.0, 4)):
            for density in (0.5, 2.0, 8.0):
                yield (
                    "constant_velocity",
                    {
                        "noise_m": noise_m,
                        "noise_rad": noise_rad,
                        "acceleration_m_s2": density,
                        "angular_acceleration_rad_s2": density,
                    },
                )


def _ahead() -> list[dict[str, Any]]:
    """Errors of prediction as shares of those of the last measured pose held."""
    rows, steps = [], round(AHEAD_S * RATE_HZ)
    for sigma_m, sigma_deg in NOISES:
        for name, motion in MOTIONS.items():
            true = motion.sampled(RATE_HZ, SECONDS).rigid
            rng = np.random.default_rng(1)
            raw = Gaussian(sigma_m, float(np.deg2rad(sigma_deg))).apply(true, rng).motors
            wxyz, position_m = raw.as_quaternion_translation()
            live, made = LiveSmoother(), []
            for k in range(len(raw) - steps):
                live.update(k / RATE_HZ, position_m[k], wxyz[k])
                _, position, turned = live.predict((k + steps) / RATE_HZ)
                made.append(Motor.from_quaternion_translation(turned, position).coefficients)
            ours, held = (
                np.sqrt(
                    np.mean(true.motors[steps:].local(path).reshape(-1, 2, 3) ** 2, axis=(0, 2))
                )
                for path in (Motor(np.array(made)), raw[:-steps])
            )
            rotation, position_share = (ours / held).tolist()
            rows.append(
                {
                    "motion": name,
                    "sigma_m": sigma_m,
                    "position": position_share,
                    "rotation": rotation,
                }
            )
    return rows


def _update_us() -> float:
    """Processor time of an update, the best of five runs."""
    rng = np.random.default_rng(0)
    position_m = np.cumsum(1e-3 * rng.standard_normal((UPDATES, 3)), axis=0)
    wxyz = np.array([1.0, 0.0, 0.0, 0.0]) + 0.01 * rng.standard_normal((UPDATES, 4))
    best = np.inf
    for _ in range(5):
        live, start = LiveSmoother(), time.process_time()
        for k in range(UPDATES):
            live.update(k / RATE_HZ, position_m[k], wxyz[k])
        best = min(best, (time.process_time() - start) / UPDATES)
    return 1e6 * best


def live_table(figures: Mapping[str, Any]) -> str:
    """As aligned text."""
    lines = [f"{'motion':8s}{'noise':26s}{'e2':>7s}{'s4':>7s}   best tuned peer"]
    for row in figures["cells"]:
        lines.append(
            f"{row['motion']:8s}{row['noise']:26s}{row['e2']:7.3f}{row['s4']:7.3f}"
            f"{row['best_e2']:8.3f} {row['best']}"
        )
    if figures["cells"]:
        e2, s4, best = (
            np.array([row[key] for row in figures["cells"]]) for key in ("e2", "s4", "best_e2")
        )
        means = [float(np.exp(np.mean(np.log(one)))) for one in (e2, s4, best)]
        lines.append(
            f"geometric means {means[0]:.3f}, {means[1]:.3f}, best tuned {means[2]:.3f}; within "
            f"5 % of the best tuned peer in {int(np.sum(e2 <= WITHIN * best))} of {len(e2)}; worse "
            f"than raw in {int(np.sum(e2 > 1.0))}"
        )
    shares = np.array([[row["position"], row["rotation"]] for row in figures["ahead"]])
    lines.append(
        f"50 ms ahead: {np.exp(np.mean(np.log(shares))):.3f} of the error of holding the last "
        f"pose, {shares.max():.2f} at worst of {len(shares)} motions"
    )
    lines.append(f"one update, arrays in and out: {figures['update_us']:.1f} µs")
    return "\n".join(lines)
