"""Poses are left out only where the others predict them, and no path comes out worse."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.metrics.jitter import accelerations
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import smoothed_automatically
from motorcade.fusion.smoothing.batch.inliers import first_sizes, inlier_poses
from motorcade.fusion.smoothing.batch.predicted import judged_runs
from motorcade.fusion.smoothing.batch.start import PathStart
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.trajectories import read_trajectory
from tests.bench.smoothing.cells import cell, left, motion

RUN = slice(400, 430)


def shifted(path: Trajectory, shift_m: FloatArray) -> Trajectory:
    made = Motor.from_translation(shift_m) @ path.motors
    return Trajectory(path.time_ns, made, path.parent, path.child)


def jerky(rng: np.random.Generator) -> Trajectory:
    """Two metres to and fro, with another speed every third of a second."""
    speed = np.repeat(rng.standard_normal((60, 3)), 10, axis=0)
    return Trajectory(
        np.arange(600) * 33_000_000, Motor.from_translation(np.cumsum(0.033 * speed, axis=0))
    )


def test_a_run_is_left_out_where_the_others_predict_it(rng: np.random.Generator) -> None:
    kept = np.ones(600, dtype=np.bool_)
    kept[RUN] = False
    off = np.where(kept, 0.0, 0.1)[:, None] * [1.0, 0.0, 0.0]
    for calm, told in ((MOTIONS["screw"].sampled(30.0, 599 / 30.0), True), (jerky(rng), False)):
        path = shifted(Gaussian(0.001, 0.001).apply(calm, rng), off)
        found = judged_runs(path.time_s, path.motors, kept).motion
        assert np.array_equal(found, kept if told else np.ones_like(kept))


def test_a_run_that_the_path_does_not_return_from_is_a_level(rng: np.random.Generator) -> None:
    kept = np.ones(600, dtype=np.bool_)
    kept[RUN] = False
    level = np.select([np.arange(600) < 400, kept], [0.0, -0.4], 0.5)[:, None] * [1.0, 0.0, 0.0]
    path = shifted(
        Gaussian(0.001, 0.001).apply(MOTIONS["screw"].sampled(30.0, 599 / 30.0), rng), level
    )
    found = judged_runs(path.time_s, path.motors, kept)
    assert np.all(found.motion)
    assert found.jumps.tolist() == [400, 430]


def test_poses_of_a_jerky_path_are_not_called_wrong(rng: np.random.Generator) -> None:
    level = np.repeat(0.03 * rng.standard_normal((20, 3)), 15, axis=0)
    path = shifted(Gaussian(1e-6, 1e-6).apply(jerky(rng)[:300], rng), level)
    sizes = first_sizes(path)
    assert np.mean(inlier_poses(path.time_s, path.motors, *sizes)) < 0.9
    assert np.mean(PathStart.of(path)[0].weights) > 0.95


def test_corrections_of_stiff_splines_do_not_outgrow_each_other() -> None:
    rng = np.random.default_rng(2)
    true = MOTIONS["screw"].sampled(30.0, 20.0)
    noisy = Gaussian(1e-3, 1e-3).apply(true, rng)
    made = smoothed_automatically(noisy).trajectory
    off = (made.motors.translation_m - true.motors.translation_m) ** 2
    assert np.sqrt(np.mean(np.sum(off, axis=1))) < 4e-4  # of 1.8e-3


def wrong_together(seed: int) -> tuple[Trajectory, Trajectory, FloatArray]:
    """A measured path, the true one in its levels, and which poses are wrong (1).

    Runs of wrong poses, jumps of level beside them or anywhere, and gaps, all in one.
    """
    rng = np.random.default_rng([35, seed])
    name = str(rng.choice(["handheld", "walk_and_look", "tumble"]))
    true, count = MOTIONS[name].sampled(20.0, 299 / 20.0), 300
    noisy = Gaussian(0.002, np.deg2rad(0.1)).apply(true, rng)
    wrong, twist, ends = np.zeros(count), np.zeros((count, 6)), [int(rng.integers(30, 270))]
    for _ in range(2):
        length = int(rng.integers(1, 13))
        first = int(rng.integers(20, count - length - 20))
        rows = 1 if rng.random() < 0.5 else length
        twist[first : first + length] = rng.standard_normal((rows, 6)) * [0.5] * 6
        wrong[first : first + length] = 1.0
        ends.append(first + length)
    level = (np.arange(count) >= rng.choice(ends))[:, None] * 0.3 * rng.standard_normal(6)
    levels = Motor.from_twist(level)
    measured = levels @ noisy.motors @ Motor.from_twist(twist)
    kept = np.ones(count, dtype=np.bool_)
    gap = int(rng.integers(20, 270))
    kept[gap : gap + int(rng.integers(1, 10))] = False
    return (
        Trajectory(true.time_ns, measured)[kept],
        Trajectory(true.time_ns, levels @ true.motors)[kept],
        wrong[kept],
    )


def sizes_off(path: Trajectory, true: Trajectory) -> FloatArray:
    """By how much each pose is off ``(N, 2)``, in rad and m."""
    off = (true.motors.inverse() @ path.motors).as_twist().reshape(-1, 2, 3)
    return np.asarray(np.linalg.norm(off, axis=2), dtype=np.float64)


@pytest.mark.slow
def test_runs_jumps_and_gaps_together_spoil_no_good_pose() -> None:
    spoiled = 0
    for seed in range(40):
        measured, true, wrong = wrong_together(seed)
        found = smoothed_automatically(measured).trajectory
        before, after = (sizes_off(one, true)[wrong == 0.0] for one in (measured, found))
        spoiled += bool(np.any(np.mean(after**2, axis=0) > 1.1 * np.mean(before**2, axis=0)))
    assert spoiled <= 2


def test_a_path_that_a_spline_cannot_follow_stays_in_its_rotations(
    rng: np.random.Generator,
) -> None:
    """Euler angles that wrap were smoothed across their wraps, by 39°; positions are smoothed."""
    true = MOTIONS["gimbal_crossing_slow"].sampled(30.0, 10.0)
    noisy = Gaussian(0.005, np.deg2rad(0.5)).apply(true, rng)
    found = smoothed_automatically(noisy, "euler")
    before, after = (
        np.mean(sizes_off(one, true) ** 2, axis=0) for one in (noisy, found.trajectory)
    )
    assert np.all(after < [1.01 * before[0], 0.25 * before[1]])
    assert "what lies next to a pose predicts it better" in str(found.choice)


def test_poses_that_a_representation_distorts_are_no_rougher_than_others() -> None:
    """Left out beside the gimbal lock, positions stayed as measured though the path knew them."""
    true = MOTIONS["gimbal_crossing_slow"].sampled(30.0, 10.0)
    expected, _ = accelerations(true.time_s, true.motors)
    for seed in range(3):
        noisy = Gaussian(0.005, np.deg2rad(0.5)).apply(true, np.random.default_rng(seed))
        found = smoothed_automatically(noisy, "euler_unwrapped").trajectory
        linear, _ = accelerations(true.time_s, found.motors)
        assert np.sqrt(np.mean(np.sum((linear - expected) ** 2, axis=1))) < 0.5


@pytest.mark.parametrize(
    ("name", "noise", "seed"),
    [
        ("gimbal_hover", "flips", 1),  # six at the end, taken for another level
        ("handheld", "flips", 0),  # two, whose steps are like a turn's
        ("fast_spin", "flips", 4),  # bridged over so long that anything was near
        ("walk_and_look", "bursts of outliers", 4),  # in part mirrored, as a marker's are
        ("stop_and_go", "bursts of outliers", 2),  # the path leaps back by what it leapt off
    ],
)
def test_runs_that_the_path_leaps_to_and_back_are_wrong(
    name: str, noise: str, seed: int, data_dir: Path
) -> None:
    true = motion(name, data_dir, 10.0)
    assert true is not None
    drawn = cell(name, noise, true, seed)
    assert left(smoothed_automatically(drawn.raw).trajectory, drawn).e2 < 0.15


def test_right_poses_between_wrong_ones_beside_a_jump_are_kept() -> None:
    for seed in (0, 13, 27, 32):
        measured, true, wrong = wrong_together(seed)
        found = smoothed_automatically(measured).trajectory
        before, after = (sizes_off(one, true)[wrong == 0.0] for one in (measured, found))
        assert np.all(np.mean(after**2, axis=0) < 1.1 * np.mean(before**2, axis=0))


def test_corrections_that_outgrow_each_other_lead_nowhere() -> None:
    """Nine times as far off as measured before, by corrections that each outgrew the last."""
    true = MOTIONS["fast_spin"].sampled(20.0, 599 / 60.0)
    raw = cell("fast_spin", "white 1 mm, 0.1°", true, 1)
    assert left(smoothed_automatically(raw.raw).trajectory, raw).e2 < 1.0


def test_good_poses_of_a_flight_stay_where_nothing_bridges_them(data_dir: Path) -> None:
    """A fast turn of good poses was left out, and a jump found behind it."""
    raw = read_trajectory(data_dir / "cases" / "smooth_v102_first_400.tum")
    true = read_trajectory(data_dir / "imu" / "V1_02_medium.csv").resampled(raw.time_ns)
    found = smoothed_automatically(raw).trajectory

    def figures(path: Trajectory) -> FloatArray:
        steps = [one.motors[:-1].inverse() @ one.motors[1:] for one in (path, true)]
        wrong = (steps[1].inverse() @ steps[0]).as_twist().reshape(-1, 2, 3)
        jerks = zip(*(accelerations(raw.time_s, one.motors) for one in (path, true)), strict=True)
        jitter = [np.sqrt(np.mean(np.sum((own - real) ** 2, axis=1))) for own, real in jerks]
        return np.array([*np.sqrt(np.mean(np.sum(wrong**2, axis=2), axis=0)), *jitter])

    assert np.all(figures(found) <= 1.0001 * figures(raw))
    assert np.all(np.max(sizes_off(found, raw), axis=0) < [np.deg2rad(5.0), 0.2])


def test_a_run_is_wrong_that_the_path_returns_from_for_two_poses() -> None:
    """Of these twelve five were kept, with a jump before them."""
    true, kept = motion("robot at 8 Hz", Path()), 0
    assert true is not None
    for seed in range(12):
        rng, off = np.random.default_rng([99, seed, 2]), np.zeros((2, len(true), 3))
        noisy = Gaussian(0.005, np.deg2rad(0.5)).apply(true, rng)
        off[0, -10:-2], off[1, -10:-2] = 0.2 * rng.standard_normal(3), 0.3 * rng.standard_normal(3)
        turned = Motor.from_twist(np.concatenate([off[1], 0.0 * off[0]], axis=1))
        wrong = Motor.from_translation(off[0]) @ noisy.motors @ turned
        found = smoothed_automatically(Trajectory(noisy.time_ns, wrong))
        kept += np.flatnonzero(found.weights == 0.0).tolist() != [*range(230, 238)]
    assert kept <= 2


@pytest.mark.parametrize(
    ("noise", "seed"),
    [("bursts of outliers", 672860), ("bursts of outliers", 9001), ("outliers 5 %", 977578)],
)
def test_what_is_left_out_stays_where_a_path_is_no_surer(noise: str, seed: int) -> None:
    """A run's rotations are wrong, but positions were led farther off than they were measured."""
    true = motion("robot at 1 Hz", Path())
    assert true is not None
    one = cell("robot at 1 Hz", noise, true, seed)
    found = left(smoothed_automatically(one.raw).trajectory, one)
    assert found.shares[0] < 1.01  # 1.76, 1.86 and 0.59 of the raw path's
    assert found.e2 < 0.6 if noise == "bursts of outliers" else found.e2 < 0.2
