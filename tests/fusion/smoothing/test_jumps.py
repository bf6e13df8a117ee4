"""Jumps of level are kept as jumps, and what only moves fast is none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian, Outliers
from motorcade.fusion.smoothing import REPRESENTATIONS, smoothed_automatically
from motorcade.fusion.smoothing.auto import AutomaticPath
from motorcade.fusion.smoothing.batch.per_axis import chosen_models
from motorcade.fusion.smoothing.batch.start import PathStart, first_path
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from tests.bench.smoothing.cells import cell, left, motion

SLOW = pytest.mark.slow
NOISE = Gaussian(0.005, np.deg2rad(0.5))


def relocated(path: Trajectory, rows: slice, world_T_old: Motor) -> Trajectory:
    """The path with some of its poses told in another map."""
    coefficients = np.array(path.motors.coefficients)
    coefficients[rows] = (world_T_old @ path.motors[rows]).coefficients
    return Trajectory(path.time_ns, Motor(coefficients), path.parent, path.child)


def moved_at(path: Trajectory, row: int, duration_s: float, twist: FloatArray) -> Trajectory:
    """The path with a smooth move more, as fast as asked."""
    passed = np.clip((path.time_s - path.time_s[row]) / duration_s, 0.0, 1.0)
    share = passed**3 * (10.0 - 15.0 * passed + 6.0 * passed**2)
    moved = path.motors @ Motor.from_twist(share[:, None] * twist)
    return Trajectory(path.time_ns, moved, path.parent, path.child)


def off_m(found: AutomaticPath, true: Trajectory) -> FloatArray:
    between = found.trajectory.motors.translation_m - true.motors.translation_m
    return np.asarray(np.linalg.norm(between, axis=1), dtype=np.float64)


@pytest.mark.parametrize("size", [0.3, 1.0, 30.0])
@pytest.mark.parametrize("name", ["handheld", "walk_and_look"])
def test_a_corrected_map_is_a_jump(name: str, size: float, rng: np.random.Generator) -> None:
    path = MOTIONS[name].sampled(20.0, 20.0)
    twist = size * np.array([0.05, -0.1, 0.05, 0.1, 0.2, -0.1])
    true = relocated(path, slice(0, 240), Motor.from_twist(twist))
    found = smoothed_automatically(NOISE.apply(true, rng))
    assert found.jumps.tolist() == [240]
    assert found.choice.jumps == 1
    assert "1 jump of level kept" in str(found.choice)
    assert np.all(found.weights > 0.0)
    off = off_m(found, true)
    assert np.sqrt(np.mean(off**2)) < 0.55 * NOISE.sigma_m * np.sqrt(3.0)
    # The poses beside the jump are as good as those at an end.
    assert np.all(off[235:245] < 3.0 * NOISE.sigma_m * np.sqrt(3.0))


@pytest.mark.parametrize("duration_s", [0.15, 0.3, 1.0])
@pytest.mark.parametrize("twist", [[0.0, 0.0, 0.0, 0.2, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
def test_a_fast_move_is_no_jump(
    duration_s: float, twist: list[float], rng: np.random.Generator
) -> None:
    path = MOTIONS["handheld"].sampled(30.0, 15.0)
    true = moved_at(path, 200, duration_s, np.array(twist))
    noisy = NOISE.apply(true, rng)
    found = smoothed_automatically(noisy)
    assert found.jumps.size == 0
    raw = np.linalg.norm(noisy.motors.translation_m - true.motors.translation_m, axis=1)
    assert np.mean(off_m(found, true) ** 2) < 0.5 * np.mean(raw**2)


@pytest.mark.parametrize(
    "name",
    ["fast_spin", *(pytest.param(one, marks=SLOW) for one in ("handheld", "stop_and_go", "screw"))],
)
def test_wrong_poses_are_no_jumps(name: str, rng: np.random.Generator) -> None:
    noisy = NOISE.apply(MOTIONS[name].sampled(30.0, 15.0), rng)
    assert smoothed_automatically(noisy).jumps.size == 0
    assert smoothed_automatically(Outliers(0.05, 0.3, 0.5).apply(noisy, rng)).jumps.size == 0


def test_jumps_are_looked_for_in_each_path(rng: np.random.Generator) -> None:
    path = NOISE.apply(MOTIONS["handheld"].sampled(20.0, 20.0), rng)
    shifted = relocated(path, slice(100, None), Motor.from_translation([0.3, 0.0, 0.0]))
    choice = smoothed_automatically(path).choice
    assert smoothed_automatically(shifted, choice=choice).jumps.tolist() == [100]


@pytest.mark.parametrize(
    ("count", "run"),
    [(120, 20), pytest.param(550, 100, marks=SLOW), pytest.param(2000, 350, marks=SLOW)],
)
@pytest.mark.parametrize("place", ["start", "middle", "end"])
@pytest.mark.parametrize("size_m", [1.0, 8.0])
def test_runs_of_wrong_poses_spoil_none_of_the_others(
    count: int, run: int, place: str, size_m: float, rng: np.random.Generator
) -> None:
    true = MOTIONS["handheld"].sampled(30.0, (count - 1) / 30.0)
    first = {"start": 0, "middle": (count - run) // 2, "end": count - run}[place]
    wrong = np.zeros(count, dtype=np.bool_)
    wrong[first : first + run] = True
    noisy = NOISE.apply(true, rng)
    shift = wrong[:, None] * size_m * rng.standard_normal((count, 3))
    degraded = Trajectory(
        true.time_ns,
        Motor.from_rotor_translation(noisy.motors.rotor, noisy.motors.translation_m + shift),
        true.parent,
        true.child,
    )
    found = smoothed_automatically(degraded)
    assert np.all(found.weights[~wrong] > 0.0)
    assert np.mean(found.weights[wrong] > 0.0) < 0.1
    off = off_m(found, true)
    assert np.sqrt(np.mean(off[~wrong] ** 2)) < 0.6 * NOISE.sigma_m * np.sqrt(3.0)
    assert np.sqrt(np.mean(off[wrong] ** 2)) < size_m * np.sqrt(3.0)


@pytest.mark.slow
def test_turns_without_noise_that_the_chain_leaves_out_come_back(data_dir: Path) -> None:
    """They tell nothing of each other over a run, but the positions there do."""
    true = motion("V2_02", data_dir)
    assert true is not None
    one = cell("V2_02", "position alone 10 mm", true)
    found = smoothed_automatically(one.raw)
    assert np.all(found.weights > 0.0)
    assert left(found.trajectory, one).e2 < 0.5


@pytest.mark.parametrize("name", ["handheld", "screw", "fast_spin"])
@pytest.mark.parametrize(
    "rows", [slice(100, 108), slice(60, 160), slice(387, 398), slice(390, 398), slice(3, 11)]
)
def test_a_level_that_returns_is_a_run_of_wrong_poses(name: str, rows: slice) -> None:
    """It was kept as two jumps, with all of its error."""
    rng = np.random.default_rng([35, rows.start, *map(ord, name)])
    true = MOTIONS[name].sampled(20.0, 19.95)
    noisy = NOISE.apply(true, rng)
    poses = noisy.motors.coefficients.copy()
    turn, shift = rng.normal(0.0, 0.1, 3), rng.normal(0.0, 0.1, 3)
    body = Motor.from_twist(np.concatenate([turn, np.zeros(3)]))
    poses[rows] = (Motor.from_translation(shift) @ noisy.motors[rows] @ body).coefficients
    found = smoothed_automatically(Trajectory(true.time_ns, Motor(poses), true.parent, true.child))
    assert found.jumps.size == 0
    off = off_m(found, true)
    assert np.sqrt(np.mean(off**2)) < 1.1 * NOISE.sigma_m * np.sqrt(3.0)


def test_a_level_that_does_not_return_is_corrected_for_good(rng: np.random.Generator) -> None:
    true = MOTIONS["handheld"].sampled(20.0, 19.95)
    for rows, shift_m in ((slice(100, None), 0.2), (slice(160, None), -0.1)):
        true = relocated(true, rows, Motor.from_translation([shift_m, 0.1, 0.0]))
    assert smoothed_automatically(NOISE.apply(true, rng)).jumps.tolist() == [100, 160]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_angles_that_leap_at_their_gimbal_and_back_are_no_returned_level(seed: int) -> None:
    """Forty good poses were moved by one vector of angles: 12 to 59° were left of 0.9°."""
    true = MOTIONS["gimbal_crossing_slow"].sampled(30.0, 12.0).rigid
    noisy = NOISE.apply(true, np.random.default_rng(seed))
    paths = smoothed_automatically(noisy, "euler").trajectory, noisy
    off, raw = (np.mean((true.motors.inverse() @ one.motors).rotor.angle() ** 2) for one in paths)
    assert off < 1.05 * raw


def test_a_run_that_was_moved_back_once_keeps_its_jumps(rng: np.random.Generator) -> None:
    true = MOTIONS["handheld"].sampled(20.0, 19.95)
    run = slice(100, 130)
    wrong = relocated(NOISE.apply(true, rng), run, Motor.from_translation([0.2, 0.1, 0.0]))
    whole = np.ones(len(wrong))
    start = PathStart(wrong, whole, whole == 0.0, wrong, np.array([run.start, run.stop]))
    measured, path = start.written(REPRESENTATIONS["rotor"])
    models = chosen_models(measured, path, whole, (2,))
    moved = start._with_levels_returned(measured, path, models)
    assert np.flatnonzero(moved.mirrored).tolist() == list(range(run.start, run.stop))
    assert moved.jumps.size == 0
    # Had it not helped, the same jumps would be found again.
    again = replace(start, mirrored=moved.mirrored)
    assert again._with_levels_returned(measured, path, models) is again


def test_a_first_path_ends_though_every_start_calls_for_another(
    monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator
) -> None:
    tried = list[PathStart]()

    def another(start: PathStart, *_: object) -> PathStart:
        tried.append(replace(start))
        return tried[-1]

    monkeypatch.setattr(PathStart, "corrected", another)
    start = PathStart.of(NOISE.apply(MOTIONS["handheld"].sampled(20.0, 5.0), rng))[0]
    assert first_path([start], REPRESENTATIONS["euler"])[0] is tried[-1]
    assert len(tried) < 10
