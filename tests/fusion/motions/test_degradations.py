"""Degradations do what they say: sizes and shares within confidence bounds, geometry as OpenCV's.

Bounds are five standard errors wide, at a fixed seed.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from motorcade.fusion.metrics import log_scales, position_lag_s
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import (
    Blackouts,
    DroppedFrames,
    Gaussian,
    InTurn,
    Latency,
    Outliers,
    PlanarFlips,
    Quantised,
    StampJitter,
    wrong_planar_pose,
)
from motorcade.ga import Motor, Trajectory

DEGREE = np.deg2rad(1.0)
ALL = (
    Gaussian(0.005, 0.5 * DEGREE),
    Outliers(0.05, 0.1, 0.2),
    PlanarFlips(0.02),
    Quantised(1e-3, 1e-3),
    StampJitter(2e-3),
    DroppedFrames(0.1),
    DroppedFrames(0.1, 8.0),
    Blackouts(2.0, 15.0),
    Latency(0.05),
    Latency(0.05, 0.01, known=True),
)


@pytest.fixture(scope="module")
def truth() -> Trajectory:
    return MOTIONS["handheld"].sampled(30.0, 1000.0)


def difference(degraded: Trajectory, truth: Trajectory):
    """Position error (N, 3) in the world and rotation vector (N, 3) in the moving frame."""
    shift = degraded.poses.translation_m - truth.poses.translation_m
    return shift, (truth.poses.rotor.inverse() @ degraded.poses.rotor).as_rotation_vector()


def run_lengths(struck):
    edges = np.diff(np.concatenate([[0], struck.astype(int), [0]]))
    return np.flatnonzero(edges < 0) - np.flatnonzero(edges > 0)


@pytest.mark.parametrize("degradation", ALL, ids=repr)
def test_the_seed_decides_and_the_input_stays(degradation, truth):
    short = truth[:500]
    before = short.poses.coefficients.copy(), short.time_ns.copy()
    one, same = (degradation.apply(short, np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(one.time_ns, same.time_ns)
    np.testing.assert_array_equal(one.poses.coefficients, same.poses.coefficients)
    np.testing.assert_array_equal(short.poses.coefficients, before[0])
    np.testing.assert_array_equal(short.time_ns, before[1])


def test_gaussian_noise_has_its_deviation_and_is_normal(truth, rng):
    shift, turn = difference(Gaussian(0.005, 0.5 * DEGREE).apply(truth, rng), truth)
    for errors, sigma in ((shift, 0.005), (turn, 0.5 * DEGREE)):
        bound = 5.0 / np.sqrt(2.0 * errors.size)
        assert np.std(errors) == pytest.approx(sigma, rel=bound)
        assert stats.kstest(errors.ravel() / sigma, "norm").pvalue > 1e-4
        neighbours = np.corrcoef(errors[1:].ravel(), errors[:-1].ravel())[0, 1]
        assert abs(neighbours) < 5.0 / np.sqrt(errors.size)


@pytest.mark.parametrize("freedom", [1.0, 3.0, np.inf])
def test_outliers_have_their_share_and_tails(truth, rng, freedom):
    shift, turn = difference(Outliers(0.05, 0.1, 0.02, freedom).apply(truth, rng), truth)
    struck = np.linalg.norm(shift, axis=1) > 1e-12
    np.testing.assert_array_equal(struck, np.linalg.norm(turn, axis=1) > 1e-12)
    expected = stats.binom(len(truth), 0.05)
    assert abs(np.count_nonzero(struck) - expected.mean()) < 5.0 * expected.std()
    law = stats.norm if np.isinf(freedom) else stats.t(freedom)
    assert stats.kstest(shift[struck].ravel() / 0.1, law.cdf).pvalue > 1e-4
    if freedom > 1.0:  # Cauchy's turns come round
        assert stats.kstest(turn[struck][:, 0] / 0.02, law.cdf).pvalue > 1e-4


def test_a_share_of_one_strikes_all(truth, rng):
    shift, _ = difference(Outliers(1.0, 0.1, 0.02).apply(truth, rng), truth)
    assert np.linalg.norm(shift, axis=1).min() > 0.0


@pytest.mark.parametrize(("share", "mean_run"), [(0.02, 10.0), (0.3, 4.0), (0.5, 2.0)])
def test_flips_have_their_share_runs_and_size(truth, rng, share, mean_run):
    tilt, distance = 25 * DEGREE, 1.5
    degraded = PlanarFlips(share, mean_run, distance, tilt).apply(truth, rng)
    shift, turn = difference(degraded, truth)
    struck = np.linalg.norm(turn, axis=1) > 1e-9
    lengths = run_lengths(struck)
    assert lengths.mean() == pytest.approx(mean_run, abs=5.0 * lengths.std() / lengths.size**0.5)
    # Variance of the share of a Markov chain of two states.
    memory = 1.0 - 1.0 / mean_run - share / ((1.0 - share) * mean_run)
    variance = share * (1.0 - share) * (1.0 + memory) / (1.0 - memory) / len(truth)
    assert struck.mean() == pytest.approx(share, abs=5.0 * np.sqrt(variance))
    starts = np.flatnonzero(np.diff(struck.astype(int)) > 0) + 1
    np.testing.assert_allclose(np.linalg.norm(turn[starts], axis=1), 2 * tilt, rtol=1e-9)
    size = np.linalg.norm(shift[starts], axis=1)
    np.testing.assert_allclose(size, 2 * distance * np.sin(tilt), rtol=1e-9)


def test_no_share_leaves_everything(truth, rng):
    for none in (PlanarFlips(0.0), Outliers(0.0, 1.0, 1.0), DroppedFrames(0.0), Quantised(0, 0)):
        degraded = none.apply(truth, rng)
        np.testing.assert_array_equal(degraded.time_ns, truth.time_ns)
        shift, turn = difference(degraded, truth)
        assert max(np.abs(shift).max(), np.abs(turn).max()) < 1e-12


def looking_at(marker_m, eye_m):
    ahead = (marker_m - eye_m) / np.linalg.norm(marker_m - eye_m)
    right = np.cross(ahead, [0.1, 0.2, 0.97])
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([right, np.cross(ahead, right), ahead])
    matrix[:3, 3] = eye_m
    return Motor.from_matrix(matrix)


def test_the_wrong_planar_pose_is_opencvs_second_candidate(rng):
    cv2 = pytest.importorskip("cv2")
    half = 0.01  # so small a marker that the image is affine to 1e-5
    corners = half * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], dtype=float)
    for _ in range(10):
        eye = 2.0 * np.array([*rng.uniform(-0.6, 0.6, 2), 1.0])
        camera = looking_at(0.2 * rng.standard_normal(3) * [1, 1, 0], eye)
        seen = camera.inverse().apply(corners)
        rays = np.ascontiguousarray(seen[:, :2] / seen[:, 2:])
        count, turns, shifts, _ = cv2.solvePnPGeneric(
            corners, rays, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
        )
        assert count == 2
        found = []
        for turn, shift in zip(turns, shifts, strict=True):
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = cv2.Rodrigues(turn)[0], np.ravel(shift)
            found.append(Motor.from_matrix(matrix).inverse())
        wrong = wrong_planar_pose(camera, np.zeros(3), [0.0, 0.0, 1.0])
        other = max(found, key=lambda pose: float((camera.inverse() @ pose).rotor.angle()))
        assert (camera.inverse() @ other).rotor.angle() > 5 * DEGREE
        assert (wrong.inverse() @ other).rotor.angle() < 0.02
        assert np.linalg.norm(wrong.translation_m - other.translation_m) < 0.03


def test_the_wrong_planar_pose_mirrors_the_normal_about_the_line_of_sight(rng):
    poses, marker = Motor.random(rng, (20,)), rng.standard_normal((20, 3))
    normal = rng.standard_normal((20, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    wrong = wrong_planar_pose(poses, marker, normal)
    before, after = (p.inverse().apply(marker) for p in (poses, wrong))
    np.testing.assert_allclose(before, after, atol=1e-12)
    sight = before / np.linalg.norm(before, axis=1, keepdims=True)
    old, new = (p.rotor.inverse().apply(normal) for p in (poses, wrong))
    mirrored = 2 * np.sum(sight * old, axis=1, keepdims=True) * sight - old
    np.testing.assert_allclose(new, mirrored, atol=1e-12)
    back = wrong_planar_pose(wrong, marker, normal)
    np.testing.assert_allclose(back.as_matrix(), poses.as_matrix(), atol=1e-12)


def test_quantised_poses_lie_on_their_grid(truth, rng):
    degraded = Quantised(2e-3, 1e-2).apply(truth, rng)
    steps = degraded.poses.translation_m / 2e-3
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    shift, turn = difference(degraded, truth)
    assert np.abs(shift).max() <= 1e-3 * (1 + 1e-9)
    assert stats.kstest(shift.ravel() / 2e-3 + 0.5, "uniform").statistic < 0.02
    assert np.linalg.norm(turn, axis=1).max() < 1e-2
    # Three of the four components' errors turn, each uniform: variance 4 · (step/2)² / 12 an axis.
    assert np.sqrt(np.mean(turn**2)) == pytest.approx(1e-2 / np.sqrt(12.0), rel=0.03)


def test_stamps_tremble_by_their_deviation_in_order(truth, rng):
    degraded = StampJitter(2e-3).apply(truth, rng)
    offsets = (degraded.time_ns - truth.time_ns) * 1e-9
    assert np.std(offsets) == pytest.approx(2e-3, rel=5.0 / np.sqrt(2.0 * len(truth)))
    assert stats.kstest(offsets / 2e-3, "norm").pvalue > 1e-4
    np.testing.assert_array_equal(degraded.poses.coefficients, truth.poses.coefficients)
    wild = StampJitter(1.0).apply(truth, rng)
    assert np.diff(wild.time_ns).min() > 0


@pytest.mark.parametrize(("share", "mean_run"), [(0.2, None), (0.1, 8.0)])
def test_dropped_frames_have_their_share_and_bursts(truth, rng, share, mean_run):
    degraded = DroppedFrames(share, mean_run).apply(truth, rng)
    lost = ~np.isin(truth.time_ns, degraded.time_ns)
    lengths = run_lengths(lost)
    expected = 1.0 / (1.0 - share) if mean_run is None else mean_run
    assert lengths.mean() == pytest.approx(expected, abs=5.0 * lengths.std() / lengths.size**0.5)
    memory = 1.0 - 1.0 / expected - share / ((1.0 - share) * expected)
    variance = share * (1.0 - share) * (1.0 + memory) / (1.0 - memory) / len(truth)
    assert lost.mean() == pytest.approx(share, abs=5.0 * np.sqrt(variance))
    if mean_run is None:  # independent: what follows a lost frame is as often lost as any
        assert lost[1:][lost[:-1]].mean() == pytest.approx(share, abs=0.03)
    assert len(DroppedFrames(0.99).apply(truth[:2], rng)) >= 1


def test_blackouts_take_every_pose_of_their_spans_and_no_other(truth, rng):
    blackouts, short = Blackouts(2.0, 15.0), truth[: 30 * 47]
    degraded = blackouts.apply(short, rng)
    offset_s = (degraded.time_ns - short.time_ns[0]) * 1e-9
    gaps = np.flatnonzero(np.diff(offset_s) > 0.1)
    # The third would end at 47 s, after the last pose at 46.97 s.
    np.testing.assert_allclose(offset_s[gaps], [15.0 - 1 / 30, 30.0 - 1 / 30], atol=1e-8)
    np.testing.assert_allclose(offset_s[gaps + 1], [17.0, 32.0], atol=1e-8)
    assert len(short) - len(degraded) == 2 * 60
    np.testing.assert_array_equal(blackouts.spans_s(47.0)[-1], [45.0, 47.0])
    assert len(blackouts.apply(truth[:100], rng)) == 100


def test_latency_shifts_what_is_not_known_of_it(truth, rng):
    short = truth[:600]
    late = Latency(0.05).apply(short, rng)
    assert position_lag_s(late, short) == pytest.approx(0.05, abs=1e-6)
    known = Latency(0.05, known=True).apply(short, rng)
    np.testing.assert_array_equal(known.time_ns, short.time_ns)
    varying = Latency(0.05, 0.004).apply(truth, rng)
    delays = (varying.time_ns - truth.time_ns) * 1e-9
    assert delays.min() > 0.0
    assert delays.mean() == pytest.approx(0.05, abs=5 * 0.004 / np.sqrt(len(truth)))
    assert np.std(delays) == pytest.approx(0.004, rel=0.05)
    queued = Latency(0.2, 0.2).apply(truth, rng)
    assert np.diff(queued.time_ns).min() >= 1
    thought = Latency(0.05, 0.004, known=True).apply(truth, rng)
    assert abs(np.mean(thought.time_ns - truth.time_ns)) < 5e9 * 0.004 / np.sqrt(len(truth))


def test_several_apply_in_turn(truth):
    steps = PlanarFlips(0.1), Gaussian(0.01, DEGREE), DroppedFrames(0.2)
    rng = np.random.default_rng(8)
    expected = truth[:300]
    for step in steps:
        expected = step.apply(expected, rng)
    found = InTurn(steps).apply(truth[:300], np.random.default_rng(8))
    np.testing.assert_array_equal(found.time_ns, expected.time_ns)
    np.testing.assert_array_equal(found.poses.coefficients, expected.poses.coefficients)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Gaussian(-1.0, 0.0), "Gaussian.sigma_m"),
        (lambda: Gaussian(0.0, np.nan), "Gaussian.sigma_rad"),
        (lambda: Outliers(1.1, 1.0, 1.0), "Outliers.share"),
        (lambda: Outliers(0.1, 1.0, 1.0, 0.0), "degrees_of_freedom"),
        (lambda: PlanarFlips(1.0), "PlanarFlips.share"),
        (lambda: PlanarFlips(0.1, 0.5), "PlanarFlips.mean_run"),
        (lambda: PlanarFlips(0.9, 2.0), "PlanarFlips.mean_run"),
        (lambda: PlanarFlips(0.1, 2.0, 0.0), "distance_m"),
        (lambda: PlanarFlips(0.1, 2.0, 1.0, 2.0), "tilt_rad"),
        (lambda: Quantised(-1.0, 0.0), "step_m"),
        (lambda: Quantised(0.0, 1.0), "step_rad"),
        (lambda: StampJitter(-1e-3), "sigma_s"),
        (lambda: DroppedFrames(1.0), "DroppedFrames.share"),
        (lambda: DroppedFrames(-0.1), "DroppedFrames.share"),
        (lambda: DroppedFrames(0.1, 0.0), "DroppedFrames.mean_run"),
        (lambda: Blackouts(0.0, 1.0), "Blackouts.length_s"),
        (lambda: Blackouts(2.0, 1.0), "Blackouts.length_s"),
        (lambda: Blackouts(1.0, np.inf), "Blackouts.every_s"),
        (lambda: Latency(0.0), "delay_s"),
        (lambda: Latency(0.1, -1.0), "spread_s"),
        (lambda: wrong_planar_pose(Motor.identity(), [0, 0, 1], [0, 0, 2]), "length 1"),
        (lambda: wrong_planar_pose(Motor.identity(), [0, 0, 0], [0, 0, 1]), "centre"),
    ],
)
def test_bad_input_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("degradation", ALL, ids=repr)
def test_similarities_keep_their_scale_and_take_the_same_errors(degradation):
    zooming = MOTIONS["zoom"].sampled(30.0, 20.0)
    degraded = degradation.apply(zooming, np.random.default_rng(4))
    rigid = degradation.apply(zooming.rigid, np.random.default_rng(4))
    np.testing.assert_array_equal(degraded.time_ns, rigid.time_ns)
    found = degraded.rigid.motors.as_matrix()
    np.testing.assert_allclose(found, rigid.motors.as_matrix(), rtol=0, atol=1e-12)
    if len(degraded) == len(zooming):
        scales = log_scales(degraded.poses), log_scales(zooming.poses)
        np.testing.assert_allclose(*scales, rtol=0, atol=1e-12)


def test_noise_of_the_scale_has_its_deviation(rng):
    zooming = MOTIONS["zoom"].sampled(30.0, 500.0)
    degraded = Gaussian(0.0, 0.0, 0.02).apply(zooming, rng)
    errors = log_scales(degraded.poses) - log_scales(zooming.poses)
    assert np.std(errors) == pytest.approx(0.02, rel=5.0 / np.sqrt(2.0 * errors.size))


def test_noise_of_the_scale_is_refused_for_rigid_poses(truth, rng):
    with pytest.raises(ValueError, match="sigma_log_scale"):
        Gaussian(0.0, 0.0, 0.1).apply(truth[:10], rng)
