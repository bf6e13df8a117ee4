"""An automatic window takes away noise and never motion."""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.fusion.smoothing import automatic_window_s, smooth
from motorcade.fusion.smoothing.window import white_noise_removed
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

Jittering = Callable[[Trajectory, float, float, np.random.Generator], Trajectory]
SIGMA_M, SIGMA_RAD = 0.01, 0.008


def covariances(count: int, factor: float = 1.0) -> FloatArray:
    sigma = factor * np.repeat([SIGMA_RAD, SIGMA_M], 3)
    return np.tile(np.diag(sigma**2), (count, 1, 1))


def waving(hertz: float, count: int = 300) -> Trajectory:
    time_ns = np.arange(count, dtype=np.int64) * 33_333_333
    twist = np.zeros((count, 6))
    twist[:, 1] = 0.3 * np.sin(2 * np.pi * hertz * time_ns * 1e-9)
    twist[:, 4] = 0.2 * np.cos(2 * np.pi * hertz * time_ns * 1e-9)
    return Trajectory(time_ns, Motor.from_twist(twist))


@pytest.mark.parametrize(("neighbours", "order"), [(2, 2), (3, 2), (5, 3), (10, 4)])
def test_the_share_of_white_noise_removed_is_what_a_simulation_loses(
    neighbours: int, order: int, rng: np.random.Generator
) -> None:
    count = 20_000
    moves = np.zeros((count, 6))
    moves[:, 3:] = rng.standard_normal((count, 3))
    path = Trajectory(np.arange(count) * 1_000_000, Motor.from_twist(moves))
    window_s = (2 * neighbours + 1) * 1e-3
    found = smooth(path, "local_polynomial", window_s=window_s, order=order)
    lost = np.mean((path.poses.translation_m - found.poses.translation_m) ** 2)
    assert lost == pytest.approx(white_noise_removed(neighbours, order), rel=0.05)


def test_noise_on_slow_motion_is_given_a_wide_window_that_helps(
    jittered: Jittering, rng: np.random.Generator
) -> None:
    truth = waving(0.2)
    noisy = jittered(truth, SIGMA_M, SIGMA_RAD, rng)
    window_s = automatic_window_s(noisy, covariances(300))
    assert window_s is not None
    assert window_s > 0.4
    found = smooth(noisy, "local_polynomial", window_s=window_s)
    before = np.linalg.norm((truth.poses.inverse() @ noisy.poses).as_twist(), axis=-1)
    after = np.linalg.norm((truth.poses.inverse() @ found.poses).as_twist(), axis=-1)
    assert after.mean() < 0.5 * before.mean()


def test_faster_motion_is_given_a_narrower_window(
    jittered: Jittering, rng: np.random.Generator
) -> None:
    windows = [
        automatic_window_s(jittered(waving(hertz), SIGMA_M, SIGMA_RAD, rng), covariances(300))
        or 0.0
        for hertz in (0.2, 2.0, 6.0)
    ]
    assert windows[0] > windows[1] > windows[2]


def test_motion_is_never_taken_for_noise_that_the_path_does_not_claim() -> None:
    fast, sure = waving(6.0), covariances(300, 0.01)
    assert automatic_window_s(fast, sure) is None


def test_a_short_path_is_left_alone() -> None:
    assert automatic_window_s(waving(0.2, count=12), covariances(12)) is None


def test_covariances_must_fit_the_path() -> None:
    with pytest.raises(ValueError, match=r"covariance: expected \(300, 6, 6\), got \(299, 6, 6\)"):
        automatic_window_s(waving(0.2), covariances(299))


@pytest.mark.parametrize("hertz", [2.0, 4.0, 7.0])
def test_motion_below_the_claimed_noise_is_not_smoothed_away(hertz: float) -> None:
    """What smoothing takes away grows with the window: it is no noise, whatever is claimed."""
    moving = waving(hertz)
    assert automatic_window_s(moving, covariances(300, 100.0)) is None
