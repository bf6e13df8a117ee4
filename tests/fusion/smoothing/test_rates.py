"""What is smoothed is told by the signal, not by how many seconds lie between stamps."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import choose, smooth, smoothed_automatically
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from tests.bench.smoothing.cells import NOISES, SLOW, cell, left, motion
from tests.bench.smoothing.estimates import MOST_MOVED, moved_in_scatters


def restamped(path: Trajectory, factor: float) -> Trajectory:
    passed_ns = np.round(factor * (path.time_ns - path.time_ns[0])).astype(np.int64)
    return Trajectory(passed_ns, path.poses, path.parent, path.child)


def driven(rate_hz: float, rng: np.random.Generator) -> Trajectory:
    """A robot at walking pace, its heading swaying within half a minute to a minute; 400 poses."""
    fine_s = np.arange(0.0, 400.0 / rate_hz, 0.02)
    periods_s, phases = rng.uniform(25.0, 80.0, 3), rng.uniform(0.0, 6.0, 3)
    heading = np.sum(np.sin(2.0 * np.pi * fine_s[:, None] / periods_s + phases), axis=1)
    along = np.stack([np.cos(heading), np.sin(heading), np.zeros_like(heading)], axis=1)
    rows = np.round(np.arange(400) / rate_hz / 0.02).astype(np.int64)
    turn = heading[rows, None] * [0.0, 0.0, 1.0]
    position_m = np.cumsum(0.5 * 0.02 * along, axis=0)[rows]
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), position_m)
    return Trajectory(np.round(1e9 * np.arange(400) / rate_hz).astype(np.int64), poses)


def off(path: Trajectory, true: Trajectory) -> FloatArray:
    twist = (true.motors.inverse() @ path.motors).as_twist().reshape(-1, 2, 3)
    return np.asarray(np.sqrt(np.mean(np.sum(twist**2, axis=2), axis=0)), dtype=np.float64)


@pytest.mark.parametrize("name", ["handheld", "walk_and_look"])
@pytest.mark.parametrize("factor", [0.1, 2.0, 7.3, 30.0])
def test_a_path_restamped_is_smoothed_alike(
    name: str, factor: float, rng: np.random.Generator
) -> None:
    true = MOTIONS[name].sampled(20.0, 15.0)
    noisy = Gaussian(0.005, np.deg2rad(0.5)).apply(true, rng)
    plain, other = smooth(noisy), smooth(restamped(noisy, factor))
    moved = off(plain, noisy)
    assert np.all(off(other, plain) < 0.01 * moved)
    assert np.all(off(plain, true) < 0.7 * off(noisy, true))


@pytest.mark.parametrize("noise", NOISES)
def test_any_path_under_any_noise_is_smoothed_alike_at_any_stamps(
    noise: str, tmp_path: Path
) -> None:
    """Stamps 0.01 to 1000 times as far apart; motions, paths and factors are drawn.

    And no pose is moved by more than five times what the path's own steps scatter, but for such as
    are called wrong.
    """
    rng = np.random.default_rng([*map(ord, noise)])
    name = str(rng.choice(["gimbal_hover", "screw", "distant_circle", "fast_spin", *SLOW]))
    true = motion(name, tmp_path, 10.0)
    assert true is not None
    raw = cell(name, noise, true, int(rng.integers(1 << 31))).raw
    found = smoothed_automatically(raw)
    plain, other = found.trajectory, smooth(restamped(raw, float(10.0 ** rng.uniform(-2.0, 3.0))))
    assert np.all(off(other, plain) < 0.01 * off(plain, raw) + 1e-6)
    assert np.all(moved_in_scatters(raw, plain)[found.weights > 0.0] < MOST_MOVED)


@pytest.mark.parametrize("rate_hz", [1.0, 2.0, 5.0, 8.0])
def test_a_slow_robot_is_smoothed_at_any_rate(rate_hz: float, rng: np.random.Generator) -> None:
    true = driven(rate_hz, rng)
    noisy = Gaussian(0.05, np.deg2rad(1.0)).apply(true, rng)
    assert np.all(off(smooth(noisy), true) < 0.4 * off(noisy, true))


@pytest.mark.parametrize("rate_hz", [10.0, 20.0, 30.0])
def test_a_body_that_shakes_as_fast_as_stamps_resolve_stays(
    rate_hz: float, rng: np.random.Generator
) -> None:
    """Noise is a tenth of what the body turns to and fro beyond half of the band."""
    time_s = np.arange(600) / rate_hz
    rates_hz = rate_hz * np.arange(0.005, 0.5, 0.0013)
    sizes = np.minimum(1.0, 0.02 * rate_hz / rates_hz) ** 1.5
    size = sizes[:, None] * rng.standard_normal((len(rates_hz), 3)) * np.deg2rad(0.2)
    phases = rng.uniform(0.0, 2.0 * np.pi, len(rates_hz))
    turn = np.sin(2.0 * np.pi * time_s[:, None] * rates_hz + phases) @ size
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), np.zeros((600, 3)))
    true = Trajectory(np.round(1e9 * time_s).astype(np.int64), poses)
    noisy = Gaussian(0.005, np.deg2rad(0.002)).apply(true, rng)
    found = smoothed_automatically(noisy)

    def steps(path: Trajectory) -> FloatArray:
        return np.diff(
            (true.motors.rotor.inverse() @ path.motors.rotor).as_rotation_vector(), axis=0
        )

    assert np.sum(steps(found.trajectory) ** 2) < 1.05**2 * np.sum(steps(noisy) ** 2)
    assert "its motion takes up the band" in str(found.choice)
    assert choose(noisy).noise_m == pytest.approx(0.005, rel=0.2)


@pytest.mark.parametrize(("noise", "seed"), [("white 5 mm, 0.5°", 777), ("Student's t", 9001)])
def test_errors_of_a_slow_robot_last_no_longer_than_its_path_tells(noise: str, seed: int) -> None:
    """Of 240 s twelve times 19.5 s were a memory: 0.90 and 0.97 of the error was left."""
    true = motion("robot at 1 Hz", Path())
    assert true is not None
    one = cell("robot at 1 Hz", noise, true, seed)
    assert left(smoothed_automatically(one.raw).trajectory, one).e2 < 0.86
