"""`python -m tests.bench.smoothing.flips [--seeds FROM TO] [--rate HZ]`: what flips cost when slow.

A slow robot's path with runs of a flat marker's other candidate is smoothed by `auto`, and the same
path without them. A row a rate: how many drawn paths have such runs, and the error beside that of
the path without them, rotation or position, whichever is worse: mean, median and worst.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from motorcade.fusion import smooth
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from tests.bench.smoothing.cells import NOISES, SLOW, errors, motion

WHITE, FLIPS = "white 5 mm, 0.5°", "flips"
FLIPPED_RAD = 0.1
"""A rotation that noise alone does not make."""


def ratios(name: str, true: Trajectory, seeds: range) -> FloatArray:
    """Errors with flips over those without ``(n,)``, of the seeds that draw some."""
    found = []
    for seed in seeds:
        clean, flipped = (
            NOISES[noise](true, np.random.default_rng([seed, *map(ord, name)]))[0]
            for noise in (WHITE, FLIPS)
        )
        if np.any(np.linalg.norm(errors(flipped, clean)[0], axis=1) > FLIPPED_RAD):
            without, left = (_sizes(smooth(path), true) for path in (clean, flipped))
            found.append(np.max(left / without))
    return np.array(found)


def _sizes(path: Trajectory, true: Trajectory) -> FloatArray:
    return np.array([np.sqrt(np.mean(np.sum(off**2, axis=1))) for off in errors(path, true)])


def main() -> None:
    parser = argparse.ArgumentParser(description="what flips cost at low rates")
    parser.add_argument("--seeds", nargs=2, type=int, default=(0, 40), metavar=("FROM", "TO"))
    parser.add_argument("--rate", action="append", type=float, help="Hz; all of them by default")
    asked = parser.parse_args()
    for name, rate_hz in SLOW.items():
        true = motion(name, Path())
        if true is None or (asked.rate and rate_hz not in asked.rate):
            continue
        cost = ratios(name, true, range(*asked.seeds))
        figures = f"mean {cost.mean():.2f}, median {np.median(cost):.2f}, worst {cost.max():.1f}"
        print(f"{name}: {len(cost)} paths with flips; times the error without: {figures}")


if __name__ == "__main__":
    main()
