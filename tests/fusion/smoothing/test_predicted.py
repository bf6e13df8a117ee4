"""Poses are left out only where the others predict them, and no path comes out worse."""

import numpy as np

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import smoothed_automatically
from motorcade.fusion.smoothing.batch.inliers import inlier_poses
from motorcade.fusion.smoothing.batch.noise import first_sizes
from motorcade.fusion.smoothing.batch.predicted import unresolved, with_unpredicted
from motorcade.fusion.smoothing.batch.start import PathStart
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

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
        found = with_unpredicted(path.time_s, path.motors, kept)
        assert np.array_equal(found, kept if told else np.ones_like(kept))


def test_poses_of_a_jerky_path_are_not_called_wrong(rng: np.random.Generator) -> None:
    level = np.repeat(0.03 * rng.standard_normal((20, 3)), 15, axis=0)
    path = shifted(Gaussian(1e-6, 1e-6).apply(jerky(rng)[:300], rng), level)
    sizes = first_sizes(path)
    assert np.mean(inlier_poses(path.time_s, path.motors, *sizes)) < 0.9
    assert np.mean(PathStart.of(path).weights) > 0.95


def test_a_path_far_off_good_poses_is_not_resolved(rng: np.random.Generator) -> None:
    true = MOTIONS["handheld"].sampled(30.0, 5.0)
    noisy, kept = Gaussian(0.005, 0.005).apply(true, rng), np.ones(len(true), dtype=np.bool_)
    assert unresolved(noisy, true, kept) == ""
    assert "farther off" in unresolved(noisy, shifted(true, np.array([0.2, 0.0, 0.0])), kept)
    kept[20:50] = False
    assert unresolved(noisy, true, kept) == "their motion is not resolved"


def test_corrections_of_stiff_splines_do_not_outgrow_each_other() -> None:
    rng = np.random.default_rng(2)
    true = MOTIONS["screw"].sampled(30.0, 20.0)
    noisy = Gaussian(1e-3, 1e-3).apply(true, rng)
    made = smoothed_automatically(noisy).trajectory
    off = (made.motors.translation_m - true.motors.translation_m) ** 2
    assert np.sqrt(np.mean(np.sum(off, axis=1))) < 4e-4  # of 1.8e-3
