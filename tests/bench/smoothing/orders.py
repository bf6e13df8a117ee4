"""`make bench SUITE=orders`: which order of Euler angles loses on which motions, and why.

Motions at 30 Hz under white noise of 10 mm and 1° are smoothed as quaternions, as rotors, and as
Euler angles in every order, each triple the nearest to the one before; as unwrapped and as plain
x-y′-z″ besides. Parameters are the same for all, and so is the noise. Figures are what an order
leaves of rotation error and of angular jitter beside quaternions: geometric means over the seeds of
the root mean squares' ratios. Orders around one axis (xyx and xzx) differ by constants, and one
stands for both. Flights of EuRoC are judged besides, at 20 Hz, where recordings are at hand.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from motorcade.fusion.metrics.jitter import accelerations
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import smooth
from motorcade.fusion.smoothing.representations import EULER_ORDERS, best_euler_order
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.versors.euler_angles import lock_levers
from tests.bench.data import data_folder
from tests.bench.smoothing.cells import JUDGED, motion

__all__ = ["ORDERS", "bench_orders", "losing", "order_row", "orders_table"]

RATE_HZ, DURATION_S, SEEDS = 30.0, 20.0, (1, 2, 3, 4, 5)
SIGMA_M, SIGMA_RAD = 0.01, float(np.deg2rad(1.0))
METHODS: Mapping[str, Mapping[str, Any]] = {
    "gaussian": {"sigma_s": 0.1},
    "rts_constant_acceleration": {"noise_m": SIGMA_M, "noise_rad": SIGMA_RAD},
}
ORDERS = tuple(name for name in EULER_ORDERS if name not in ("euler_xzx", "euler_yzy", "euler_zyz"))
NAMES = ("rotor", *ORDERS, "euler_best", "euler_unwrapped", "euler")
# More than seeds and rounding make: an order that leaves so much more than quaternions suffers.
_MORE = 1.05


def bench_orders() -> list[dict[str, Any]]:
    """A row a motion and method."""
    synthetic = [name for name, one in MOTIONS.items() if one.versor is Motor]
    paths = {name: MOTIONS[name].sampled(RATE_HZ, DURATION_S) for name in synthetic}
    flown = {name: motion(name, data_folder()) for name in JUDGED}
    paths |= {name: path for name, path in flown.items() if path is not None}
    return [order_row(name, path, method) for method in METHODS for name, path in paths.items()]


def order_row(
    name: str, true: Trajectory, method: str, seeds: Iterable[int] = SEEDS
) -> dict[str, Any]:
    """What every order leaves on a motion beside quaternions."""
    ratios: dict[str, list[FloatArray]] = {one: [] for one in NAMES}
    for seed in seeds:
        noisy = Gaussian(SIGMA_M, SIGMA_RAD).apply(true, np.random.default_rng(seed))
        beside = _left(smooth(noisy, method, "quaternion", **METHODS[method]), true)
        for one in NAMES:
            left = _left(smooth(noisy, method, one, **METHODS[method]), true)
            ratios[one].append(np.log(left / beside))
    rotations = true.motors.rotor.as_matrix()
    best = best_euler_order(true.poses)
    return {
        "motion": name,
        "method": method,
        "best": best.name,
        "nearest_lock_deg": {
            one: float(np.rad2deg(np.arcsin(np.min(lock_levers(rotations, one[-3:])))))
            for one in ORDERS
        },
        "rotation": {one: float(np.exp(np.mean(ratios[one], axis=0)[0])) for one in NAMES},
        "jitter": {one: float(np.exp(np.mean(ratios[one], axis=0)[1])) for one in NAMES},
    }


def _left(smoothed: Trajectory, true: Trajectory) -> FloatArray:
    """Root mean squares of the rotation error and of the angular jitter."""
    turns = (true.motors.rotor.inverse() @ smoothed.motors.rotor).as_rotation_vector()
    theirs, ours = (accelerations(path.time_s, path.motors)[1] for path in (true, smoothed))
    return np.array([np.sqrt(np.mean(np.sum(one**2, axis=1))) for one in (turns, ours - theirs)])


def losing(row: Mapping[str, Any]) -> list[str]:
    """Orders that leave 5 % more rotation error or angular jitter than quaternions."""
    return [one for one in ORDERS if max(row["rotation"][one], row["jitter"][one]) > _MORE]


def _named(row: Mapping[str, Any]) -> str:
    ways = ((one, row["nearest_lock_deg"][one]) for one in losing(row))
    return ", ".join(f"{one[-3:]} ({way:.0f}°)" for one, way in ways) or "none loses"


def orders_table(rows: Iterable[Mapping[str, Any]]) -> str:
    """Two tables a method, of rotation error and of angular jitter, and who suffers where."""
    rows, lines = list(rows), list[str]()
    headings = "".join(f"{name.removeprefix('euler_')[:9]:>10}" for name in NAMES)
    for method in dict.fromkeys(row["method"] for row in rows):
        mine = [row for row in rows if row["method"] == method]
        for figure, what in (("rotation", "rotation error"), ("jitter", "angular jitter")):
            lines += [f"{method}: {what} beside quaternions", f"{'':22}{headings}"]
            for row in mine:
                cells = "".join(f"{row[figure][name]:10.3g}" for name in NAMES)
                lines.append(f"{row['motion']:22}{cells}")
            lines.append("")
        lines.append(f"{method}: orders that leave 5 % more of either, with the way to their lock")
        lines += [f"{row['motion']:22}best is {row['best']}; {_named(row)}" for row in mine]
        lines.append("")
    return "\n".join(lines)
