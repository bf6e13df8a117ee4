"""What `auto` finds out about a path, what it picks, and that it does no harm."""

import numpy as np
import pytest

from motorcade.fusion.metrics import jitter
from motorcade.fusion.motions import MOTIONS, handheld
from motorcade.fusion.motions.degradations import Gaussian, Outliers, PlanarFlips, StampJitter
from motorcade.fusion.smoothing import REPRESENTATIONS, choose, smooth, smoothed_automatically
from motorcade.fusion.smoothing.results import changes
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

RIGID = [name for name in MOTIONS if name != "zoom"]


def errors(found: Trajectory, truth: Trajectory) -> FloatArray:
    between = found.poses.inverse() @ truth.poses
    shift = np.linalg.norm(found.poses.translation_m - truth.poses.translation_m, axis=1)
    turn = np.linalg.norm(between.rotor.as_rotation_vector(), axis=1)
    return np.sqrt(np.mean(np.stack([shift, turn]) ** 2, axis=1))


@pytest.mark.parametrize("name", RIGID)
def test_a_path_without_noise_is_left_as_it_is(name: str) -> None:
    truth = MOTIONS[name].sampled(30.0, 8.0)
    assert choose(truth).outliers == 0.0
    assert np.all(errors(smooth(truth), truth) < 1e-4)


@pytest.mark.parametrize("name", RIGID)
def test_noise_is_told_and_taken_away_without_lag(name: str, rng: np.random.Generator) -> None:
    truth = MOTIONS[name].sampled(30.0, 15.0)
    noisy = Gaussian(0.005, np.deg2rad(0.5)).apply(truth, rng)
    picked = choose(noisy)
    assert picked.outliers < 0.01
    assert picked.noise_m == pytest.approx(0.005, rel=0.25)
    assert picked.noise_rad == pytest.approx(np.deg2rad(0.5), rel=0.25)
    found = picked.smooth(noisy)
    assert np.all(errors(found, truth) < 0.7 * errors(noisy, truth))
    before, after = jitter(noisy, truth), jitter(found, truth)
    # A body that spins fast sees its own straight way as a fast circle, which looks like noise.
    assert after.linear_m_s2 < (0.25 if name == "fast_spin" else 0.1) * before.linear_m_s2
    assert after.angular_rad_s2 < 0.1 * before.angular_rad_s2


@pytest.mark.parametrize(("sigma_m", "sigma_rad"), [(1e-4, 1e-3), (0.02, 0.003), (0.001, 0.05)])
def test_noise_of_any_size_is_told(
    sigma_m: float, sigma_rad: float, rng: np.random.Generator
) -> None:
    truth = MOTIONS["antipodal_crossing"].sampled(60.0, 10.0)
    trembling = StampJitter(0.002).apply(truth, rng)
    stamps = trembling.time_ns
    inside = (stamps >= truth.time_ns[0]) & (stamps <= truth.time_ns[-1])
    noisy = Gaussian(sigma_m, sigma_rad).apply(truth.resampled(stamps[inside]), rng)
    found = choose(noisy)
    assert found.noise_m == pytest.approx(sigma_m, rel=0.25)
    assert found.noise_rad == pytest.approx(sigma_rad, rel=0.25)
    assert found.outliers < 0.01


@pytest.mark.parametrize("name", ["tumble", "walk_and_look", "screw"])
def test_wrong_poses_call_for_the_robust_estimate(name: str, rng: np.random.Generator) -> None:
    truth = MOTIONS[name].sampled(30.0, 10.0)
    noisy = Gaussian(0.005, np.deg2rad(0.5)).apply(truth, rng)
    degraded = PlanarFlips(0.02).apply(Outliers(0.05, 0.3, 0.5).apply(noisy, rng), rng)
    picked = choose(degraded)
    assert 0.03 < picked.outliers < 0.15
    assert "outliers" in str(picked)
    found = picked.smooth(degraded)
    right = np.linalg.norm((noisy.poses.inverse() @ degraded.poses).as_twist(), axis=1) < 1e-9
    assert np.all(errors(found[right], truth[right]) < 0.7 * errors(noisy, truth))
    assert np.all(errors(found, truth) < 0.2 * errors(degraded, truth))


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_every_representation_is_given_parameters(
    representation: str, rng: np.random.Generator
) -> None:
    truth = MOTIONS["stop_and_go"].sampled(30.0, 8.0)
    noisy = Gaussian(0.005, np.deg2rad(0.5)).apply(truth, rng)
    better = errors(smooth(noisy, "auto", representation), truth) < errors(noisy, truth)
    assert better[0]
    assert better[1] or representation == "euler", "only angles that leap lose"


def test_scales_are_smoothed_too(rng: np.random.Generator) -> None:
    truth = MOTIONS["zoom"].sampled(30.0, 10.0)
    noisy = Gaussian(0.005, 0.01, 0.01).apply(truth, rng)
    picked = choose(noisy, "similarity")
    assert picked.noise_scale == pytest.approx(0.01, rel=0.3)
    found = picked.smooth(noisy)
    assert isinstance(found.poses, Similarity)
    assert isinstance(truth.poses, Similarity)
    error = np.log(found.poses.scale / truth.poses.scale)
    assert np.sqrt(np.mean(error**2)) < 0.006


def test_few_poses_tell_nothing(rng: np.random.Generator) -> None:
    path = Trajectory(np.arange(15) * 33_000_000, Motor.random(rng, (15,)))
    with pytest.raises(ValueError, match="at least 16 poses to tell noise from motion, got 15"):
        smooth(path)


def test_changes_say_how_far_poses_moved(rng: np.random.Generator) -> None:
    truth = MOTIONS["screw"].sampled(30.0, 5.0)
    noisy = Gaussian(0.01, 0.02).apply(truth, rng)
    found = changes(noisy, truth)
    assert found["shift_rms_m"] == pytest.approx(0.01 * np.sqrt(3), rel=0.15)
    assert found["turned_rms_deg"] == pytest.approx(np.rad2deg(0.02 * np.sqrt(3)), rel=0.15)
    assert found["raw_linear_jitter_m_s2"] > 10 * found["smoothed_linear_jitter_m_s2"]
    with pytest.raises(ValueError, match="expected the stamps of the raw trajectory"):
        changes(noisy, truth[1:])
    assert changes(noisy[:2], truth[:2])["raw_linear_jitter_m_s2"] is None
    assert changes(noisy[:9], truth[:9])["smoothed_angular_jitter_rad_s2"] is None  # no spectrum


def test_axes_are_those_of_the_body_where_noise_is(rng: np.random.Generator) -> None:
    truth = MOTIONS["handheld"].sampled(30.0, 15.0)
    deep = rng.standard_normal((len(truth), 3)) * [0.001, 0.001, 0.02]
    shifted = truth.motors @ Motor.from_translation(deep)
    noisy = Trajectory(truth.time_ns, shifted, truth.parent, truth.child)
    picked = choose(noisy)
    assert picked.representation == "motor"
    noise = [one.noise for one in picked.models[3:]]
    np.testing.assert_allclose(noise, [0.001, 0.001, 0.02], rtol=0.3)
    assert choose(Gaussian(0.005, 0.01).apply(truth, rng)).representation == "rotor"


def test_stamps_that_tremble_are_taken_for_even(rng: np.random.Generator) -> None:
    truth = MOTIONS["handheld"].sampled(30.0, 15.0)
    noisy = Gaussian(0.002, np.deg2rad(0.2)).apply(truth, rng)
    off = (1e9 / 30.0 * rng.uniform(-0.35, 0.35, len(truth))).astype(np.int64)
    trembling = Trajectory(truth.time_ns + off, noisy.poses, truth.parent, truth.child)
    picked = choose(trembling)
    assert picked.even_stamps
    assert "stamps taken for even" in str(picked)
    found = picked.smooth(trembling)
    assert np.array_equal(found.time_ns, trembling.time_ns)
    assert np.all(errors(found, truth) < 0.7 * errors(noisy, truth))
    # Poses that were taken at such stamps are left at them.
    inside = trembling.time_ns.clip(*truth.time_ns[[0, -1]])
    inside = inside[np.concatenate([[True], np.diff(inside) > 0])]
    honest = Gaussian(0.002, np.deg2rad(0.2)).apply(truth.resampled(inside), rng)
    assert not choose(honest).even_stamps


def test_what_is_known_comes_with_the_path(rng: np.random.Generator) -> None:
    truth = MOTIONS["handheld"].sampled(30.0, 15.0)
    noisy = Gaussian(0.005, np.deg2rad(0.5)).apply(truth, rng)
    wrong = Outliers(0.05, 0.3, 0.5).apply(noisy, rng)
    struck = np.linalg.norm((noisy.poses.inverse() @ wrong.poses).as_twist(), axis=1) > 0.1
    found = smoothed_automatically(wrong)
    assert np.all(found.weights[struck] == 0.0)
    assert np.mean(found.weights[~struck] > 0.3) > 0.98
    off = found.trajectory.motors.translation_m - truth.motors.translation_m
    normalised = off[~struck] / found.deviations[~struck, 3:]
    assert 0.7 < np.sqrt(np.mean(normalised**2)) < 1.4


def test_noise_of_rotation_alone_leaves_positions(rng: np.random.Generator) -> None:
    """Where an axis has no noise, motion that its spline misses makes no pose an outlier."""
    truth = MOTIONS["handheld"].sampled(20.0, 20.0)
    found = smoothed_automatically(Gaussian(0.01, 0.0).apply(truth, rng))
    assert np.all(found.weights > 0.0)
    assert errors(found.trajectory, truth)[1] < 1e-4


@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_similarities_are_smoothed_in_every_representation(
    name: str, rng: np.random.Generator
) -> None:
    truth = MOTIONS["zoom"].sampled(30.0, 2.0)
    noisy = Gaussian(0.005, 0.01, 0.005).apply(truth, rng)
    made = smooth(noisy, "auto", name)
    away = made.poses.translation_m - truth.poses.translation_m
    raw = noisy.poses.translation_m - truth.poses.translation_m
    assert np.sqrt(np.mean(away**2)) < 0.8 * np.sqrt(np.mean(raw**2))


def test_errors_that_last_are_told_and_taken_away(rng: np.random.Generator) -> None:
    """Of the body's own wandering at 20 Hz: each keeps 0.8 of the error before."""
    truth = MOTIONS["tumble"].sampled(20.0, 30.0)
    error = rng.standard_normal((len(truth), 3))
    for k in range(1, len(truth)):
        error[k] = 0.8 * error[k - 1] + 0.6 * error[k]
    shifted = Motor.from_translation(0.005 * error) @ truth.motors
    noisy = Trajectory(truth.time_ns, shifted, truth.parent, truth.child)
    found = smoothed_automatically(noisy)
    assert 0.1 < found.choice.memory_s < 0.6
    assert "errors last for" in str(found.choice)
    assert errors(found.trajectory, truth)[0] < 0.9 * errors(noisy, truth)[0]  # white: 0.93
    white = Gaussian(0.005, 0.005).apply(truth, rng)
    assert choose(white).memory_s == 0.0


def test_noise_that_a_path_does_not_tell_is_not_named(rng: np.random.Generator) -> None:
    coarse = Gaussian(0.002, 0.005).apply(MOTIONS["handheld"].sampled(5.0, 20.0), rng)
    found = smoothed_automatically(coarse)
    assert (found.choice.noise_m, found.choice.noise_rad) == (None, None)
    assert "its motion takes up the band" in str(found.choice)
    assert np.all(np.isnan(found.deviations))
    known = smoothed_automatically(coarse, noise_m=0.005)
    assert known.choice.noise_m == pytest.approx(0.005)
    assert np.all(np.isfinite(known.deviations[:, 3:]))
    turning = Gaussian(0.005, 0.0).apply(MOTIONS["handheld"].sampled(30.0, 10.0), rng)
    assert choose(turning).noise_rad is None
    assert "its motion takes up the band" in str(choose(turning))


@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_noise_is_that_of_poses_whatever_they_are_written_as(
    name: str, rng: np.random.Generator
) -> None:
    true = MOTIONS["antipodal_crossing"].sampled(30.0, 5.0)
    found = choose(Gaussian(0.005, np.deg2rad(0.5)).apply(true, rng), name)
    if name != "euler":  # whose leaps are no noise
        assert found.noise_rad == pytest.approx(np.deg2rad(0.5), rel=0.25)
    if name != "dual_quaternion":
        assert found.noise_m == pytest.approx(0.005, rel=0.25)
    else:
        assert found.noise_m is None
        assert "dual parts mix" in found.unobservable


@pytest.mark.parametrize("gap_s", [60.0, 3600.0, 3e7])
@pytest.mark.parametrize("row", [1, 2, 100, 198])
def test_poses_behind_a_long_gap_stay_by_those_that_were_measured(gap_s: float, row: int) -> None:
    """Two recordings in one file, or a tracker that slept: neither side says where the other is."""
    rng = np.random.default_rng(3)
    whole = Gaussian(0.005, 0.005).apply(handheld(rng).sampled(30.0, 6.6), rng)
    time_ns = whole.time_ns + np.where(np.arange(len(whole)) < row, 0, int(1e9 * gap_s))
    smoothed = smooth(Trajectory(time_ns, whole.motors))
    moved = smoothed.motors.translation_m - whole.motors.translation_m
    assert np.max(np.linalg.norm(moved, axis=1)) < 6.0 * 0.005
    beside = [smooth(part) for part in (whole[:row], whole[row:]) if len(part) > 50]
    if len(beside) == 2:
        apart = np.concatenate([one.motors.translation_m for one in beside])
        assert np.max(np.linalg.norm(smoothed.motors.translation_m - apart, axis=1)) < 0.005
