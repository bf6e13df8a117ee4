"""Laws of every method: still paths stay, causal ones do not look ahead, no world is preferred."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import METHODS, smooth
from motorcade.ga import Motor, Trajectory
from motorcade.replays.comparison.report.matrix import CAUSAL

NOISE_RAD, NOISE_M = 0.004, 0.01


def noisy(rng: np.random.Generator) -> Trajectory:
    return Gaussian(NOISE_RAD, NOISE_M).apply(MOTIONS["handheld"].sampled(30.0, 4.0), rng)


def smoothed(path: Trajectory, method: str) -> Trajectory:
    return smooth(path, method, None if method == "auto" else "motor")


def apart(first: Motor, second: Motor) -> float:
    return float(np.abs(first.local(second)).max())


@pytest.mark.parametrize("method", METHODS)
def test_a_still_path_stays(method: str, rng: np.random.Generator) -> None:
    path = noisy(rng)
    still = path.motors[np.zeros(len(path), int)]
    assert apart(still, smoothed(Trajectory(path.time_ns, still), method).motors) < 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_what_is_still_to_come_counts_for_those_alone_that_are_not_causal(
    method: str, rng: np.random.Generator
) -> None:
    path = noisy(rng)
    until = 80
    later = path.motors[until:] @ Motor.from_twist([0.02, 0.01, 0.0, 0.05, 0.0, 0.03])
    coefficients = np.concatenate([path.motors[:until].coefficients, later.coefficients])
    other = Trajectory(path.time_ns, Motor(coefficients))
    change = apart(smoothed(path, method).motors[:until], smoothed(other, method).motors[:until])
    assert (change < 1e-12) == (method in CAUSAL)


@pytest.mark.parametrize("method", METHODS)
def test_the_frame_of_the_world_changes_nothing_on_motors(
    method: str, rng: np.random.Generator
) -> None:
    path, moved = noisy(rng), Motor.from_twist([0.9, -0.5, 1.3, 2.0, -3.0, 1.0])
    other = Trajectory(path.time_ns, moved @ path.motors)
    change = apart(moved @ smoothed(path, method).motors, smoothed(other, method).motors)
    # `auto` smooths axes apart, where they predict better those of the world: a part of the noise.
    assert change < (0.3 * NOISE_M if method == "auto" else 1e-6)
