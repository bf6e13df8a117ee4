"""The README's call, `fuse(poses, imu, ADIS16448, imu_T_camera)`, beside gtsam on recorded flights.

`python -m tests.bench.fusion.default_call --seeds 3`: camera poses of flights (20 Hz, 1 cm and 0.5°
an axis, gaps of 2 s every 15 s), the data sheet's noise and no setting. gtsam's batch gets the same
poses with each of three noises: the data sheet's, the one that was tuned on two of the flights, and
the one that the call found for itself; the best of them by ground truth stands beside it. Errors
are at the stamps of the poses, times those of one core, with all that the call does.
"""

from __future__ import annotations

from time import process_time
from typing import Any

import numpy as np

from motorcade.fusion.filter import Fused, fuse
from motorcade.fusion.graph import fuse_by_graph
from motorcade.fusion.imu import ADIS16448
from motorcade.fusion.metrics import absolute_translation_m
from motorcade.ga import Motor
from tests.bench.fusion.recorded import BLACKOUTS, NOISE, Flight, flights_asked_for, measured, nees
from tests.bench.timing import on_one_core

__all__ = ["default_figures"]

MOST_RATIO, CONSISTENT = 1.1, (0.6, 1.6)
"""What the mean error may be times gtsam's, and NEES/6."""


def default_figures(one: Flight, seed: int) -> dict[str, Any]:
    """Of one draw: mean errors in m of the call and of gtsam's best, NEES/6, and times."""
    poses = measured(one, seed, degraded=BLACKOUTS)
    stamps = poses.trajectory.time_ns
    began = process_time()
    ours = fuse(poses, one.imu, ADIS16448, Motor.identity(), stamps)
    seconds = process_time() - began
    noises = {"sheet": ADIS16448, "tuned": NOISE, "found": ours.noise}
    graphs = dict[str, tuple[float, float]]()
    for name, noise in noises.items():
        assert noise is not None
        began = process_time()
        graph = fuse_by_graph(poses, one.imu, noise, Motor.identity(), stamps)
        graphs[name] = _mean_m(one, graph), process_time() - began
    best = min(graphs, key=lambda name: graphs[name][0])
    return {
        "ours_m": _mean_m(one, ours),
        "nees": nees(one, ours),
        "gtsam_m": graphs[best][0],
        "best": best,
        "ratio": _mean_m(one, ours) / graphs[best][0],
        "time": seconds / float(np.median([spent for _, spent in graphs.values()])),
    }


def _mean_m(one: Flight, fused: Fused) -> float:
    true = one.truth.motors_at(fused.trajectory.time_ns)
    return float(np.mean(absolute_translation_m(fused.trajectory.motors, true)))


def main() -> None:
    """Measure what is asked for, a line a flight."""
    print(
        f"{'mean error, mm':<10}{'ours':>8}{'gtsam':>8}{'ratio':>8}{'NEES/6':>8}{'time':>8}  noise"
    )
    with on_one_core():
        for one, seeds in flights_asked_for("tests.bench.fusion.default_call", 3):
            rows = [default_figures(one, seed) for seed in seeds]
            ours, graph, ratio, spread, time = (
                float(np.mean([row[key] for row in rows]))
                for key in ("ours_m", "gtsam_m", "ratio", "nees", "time")
            )
            holds = ratio <= MOST_RATIO and CONSISTENT[0] <= spread <= CONSISTENT[1]
            print(
                f"{one.name:<10}{1e3 * ours:>12.2f}{1e3 * graph:>8.2f}{ratio:>8.2f}{spread:>8.2f}"
                f"{'1/' + format(1.0 / time, '.1f'):>8}  {'/'.join(row['best'] for row in rows)}"
                + ("" if holds else "  beyond its bounds"),
                flush=True,
            )


if __name__ == "__main__":
    main()
