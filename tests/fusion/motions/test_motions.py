"""Motions have the derivatives they claim, and are as hard as their names say."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS, Factor, Motion, gimbal_crossing, handheld
from motorcade.fusion.motions.motion import Polynomial, Sines, Stops
from motorcade.ga import Motor, Similarity
from motorcade.ga.motion import sampled_motion

STEP = mpmath.mpf(10) ** -9


def exactly(signal, t):
    """The signal by mpmath, from its definition."""
    if isinstance(signal, Polynomial):
        return mpmath.polyval([mpmath.mpf(c) for c in reversed(signal.coefficients)], t)
    if isinstance(signal, Sines):
        parts = zip(signal.amplitudes, signal.frequencies_hz, signal.phases_rad, strict=True)
        return mpmath.fsum(a * mpmath.sin(2 * mpmath.pi * f * t + p) for a, f, p in parts)
    stage = mpmath.mpf(signal.move_s) + mpmath.mpf(signal.rest_s)
    index = int(mpmath.floor(t / stage))
    u = min((t - index * stage) / signal.move_s, mpmath.mpf(1))
    start, end = (signal.levels[(index + k) % len(signal.levels)] for k in (0, 1))
    # Integral of 140 u³ (1 - u)³, whose roots make velocity, acceleration and jerk vanish.
    return start + (mpmath.mpf(end) - start) * mpmath.betainc(4, 4, 0, u, regularized=True)


def exponential(twist, size):
    """``exp`` of a 4x4 matrix of sim(3) at 40 digits."""
    x, y, z, a, b, c, growth = [mpmath.mpf(v) for v in np.append(twist, 0.0)[:7]]
    generator = mpmath.matrix([[growth, -z, y, a], [z, growth, -x, b], [-y, x, growth, c], [0] * 4])
    return mpmath.expm(size * generator)


def matrix(motion, t):
    product = mpmath.eye(4)
    for factor in motion.factors:
        product = product * exponential(factor.twist, exactly(factor.signal, t))
    return product


def vee(x):
    growth = (x[0, 0] + x[1, 1] + x[2, 2]) / 3
    return [x[2, 1], x[0, 2], x[1, 0], x[0, 3], x[1, 3], x[2, 3], growth]


def derived(motion, t):
    """Pose matrix, twist and its two derivatives by differences of matrices at 40 digits."""
    with mpmath.workdps(40):
        m = {k: matrix(motion, mpmath.mpf(t) + k * STEP) for k in (-2, -1, 0, 1, 2)}
        back = m[0] ** -1
        first = back * (m[1] - m[-1]) / (2 * STEP)
        second = back * (m[1] - 2 * m[0] + m[-1]) / STEP**2
        third = back * (m[2] - 2 * m[1] + 2 * m[-1] - m[-2]) / (2 * STEP**3)
        rate = second - first**2
        jerk = third - first**3 - 2 * first * rate - rate * first
        pose = np.array(m[0].tolist(), dtype=float)
        return pose, *(np.array(vee(x), dtype=float) for x in (first, rate, jerk))


@pytest.mark.parametrize("name", MOTIONS)
def test_twist_acceleration_and_jerk_are_mpmaths(name):
    motion = MOTIONS[name]
    times = np.array([-1.3456, 0.7123, 11.9871])
    sample, jerk = motion.at(times), motion.twist_jerk(times)
    size = 7 if name == "zoom" else 6
    for i, t in enumerate(times):
        pose, *expected = derived(motion, t)
        np.testing.assert_allclose(sample.pose.as_matrix()[i], pose, rtol=0, atol=1e-12)
        found = sample.body_twist[i], sample.body_twist_rate[i], jerk[i]
        for ours, theirs in zip(found, expected, strict=True):
            scale = max(1.0, np.abs(theirs).max())
            np.testing.assert_allclose(ours, theirs[:size], rtol=0, atol=1e-9 * scale)


@pytest.mark.parametrize("name", MOTIONS)
def test_samples_are_the_motion_at_even_stamps(name):
    motion = MOTIONS[name]
    trajectory = motion.sampled(30.0, 10.0, start_ns=10**18, start_s=2.5, child="imu")
    assert len(trajectory) == 301
    assert (trajectory.parent, trajectory.child) == ("world", "imu")
    np.testing.assert_array_equal(np.diff(trajectory.time_ns) // 1000, 33333)
    expected = motion.at(2.5 + trajectory.time_s).pose.coefficients
    np.testing.assert_allclose(trajectory.poses.coefficients, expected, rtol=0, atol=1e-13)


def test_batches_of_times_keep_their_shape():
    times = np.linspace(-3.0, 3.0, 12)
    flat, shaped = (MOTIONS["handheld"].at(t) for t in (times, times.reshape(3, 4)))
    assert shaped.pose.shape == (3, 4)
    assert shaped.body_twist.shape == (3, 4, 6)
    reshaped, single = shaped.body_twist.reshape(12, 6), MOTIONS["handheld"].at(times[5])
    np.testing.assert_allclose(reshaped, flat.body_twist, rtol=0, atol=1e-14)
    np.testing.assert_allclose(single.body_twist, flat.body_twist[5], rtol=0, atol=1e-14)


@pytest.mark.parametrize("rate_rad_s", [0.5, 2.0, 4.0])
def test_gimbal_crossings_pass_the_pole_at_their_rate(rate_rad_s):
    miss = np.deg2rad(1.0)
    motion = gimbal_crossing(rate_rad_s, miss)
    times = np.linspace(0.0, 18.0, 36_001)
    sample = motion.at(times)
    ahead = sample.pose.rotor.apply([0.0, 0.0, 1.0])
    from_pole = np.arctan2(np.linalg.norm(ahead[:, 1:], axis=1), np.abs(ahead[:, 0]))
    assert from_pole.min() == pytest.approx(miss, rel=1e-3)
    swing = np.abs(sample.body_twist[:, :2])
    assert np.hypot(*swing.T).max() == pytest.approx(rate_rad_s, rel=1e-6)
    roll = np.unwrap(sample.pose.as_euler_translation()[0][:, 0])
    assert np.abs(np.gradient(roll, times)).max() == pytest.approx(rate_rad_s / miss, rel=0.01)


def test_hover_stays_near_the_pole_and_never_still():
    poses = MOTIONS["gimbal_hover"].at(np.linspace(0.0, 60.0, 6001)).pose
    pitch = poses.as_euler_translation()[0][:, 1]
    assert np.rad2deg(pitch).min() > 82.0
    assert np.ptp(pitch) > np.deg2rad(3.0)


def test_fast_spin_turns_the_wrong_way_for_a_slow_stream():
    motion = MOTIONS["fast_spin"]
    rate = np.linalg.norm(motion.at(np.linspace(0, 60, 6001)).body_twist[:, :3], axis=1)
    assert rate.min() / 5.0 > np.pi
    assert rate.max() / 30.0 < 0.75
    slow = motion.sampled(5.0, 10.0)
    steps = (slow.poses[:-1].inverse() @ slow.poses[1:]).rotor.angle()
    assert np.all(steps < rate.min() / 5.0)


def test_antipodal_crossing_passes_half_a_turn_both_ways():
    poses = MOTIONS["antipodal_crossing"].at(np.linspace(0.0, 8.0, 8001)).pose
    angle = (poses[0].inverse() @ poses).rotor.angle()
    assert angle.max() > np.pi - 1e-3
    quaternions = poses.rotor.as_quaternion()
    positive = quaternions * np.sign(quaternions[:, :1])
    leaps = np.sum(positive[1:] * positive[:-1], axis=1) < 0
    assert np.count_nonzero(leaps) == 2


def test_screw_and_circle_keep_their_radius_and_twist():
    times = np.linspace(0.0, 30.0, 300)
    turned = MOTIONS["screw"].at(times)
    assert np.abs(turned.body_twist - turned.body_twist[0]).max() < 1e-12
    assert np.abs(turned.body_twist_rate).max() < 1e-12
    for name, radius in (("screw", 0.7), ("distant_circle", 10.0)):
        across = MOTIONS[name].at(times).pose.translation_m[:, :2]
        np.testing.assert_allclose(np.hypot(*across.T), radius, rtol=1e-12)


def test_tumble_keeps_its_nutation_and_its_rate():
    sample = MOTIONS["tumble"].at(np.linspace(0.0, 30.0, 300))
    own = sample.pose.rotor.apply([1.0, 0.0, 0.0])
    np.testing.assert_allclose(own[:, 0], np.cos(1.1), atol=1e-12)
    rate = np.linalg.norm(sample.body_twist[:, :3], axis=1)
    np.testing.assert_allclose(rate, np.sqrt(1.3**2 + 2.1**2 + 2 * 1.3 * 2.1 * np.cos(1.1)))


def test_stops_stand_still_and_the_camera_looks_level():
    times = np.arange(1.2, 20.0, 2.0)[:, None] + np.linspace(0.0, 0.8, 9)
    sample = MOTIONS["stop_and_go"].at(times)
    assert np.abs(sample.body_twist).max() < 1e-12
    assert np.abs(np.ptp(sample.pose.translation_m, axis=1)).max() < 1e-14
    start = MOTIONS["stop_and_go"].at(0.0).pose.rotor
    np.testing.assert_allclose(start.apply([0.0, 0.0, 1.0]), [1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(start.apply([0.0, 1.0, 0.0]), [0.0, 0.0, -1.0], atol=1e-12)


def test_stops_have_continuous_jerk():
    stops = Stops((0.0, 1.0, -0.5), 0.7, 0.4)
    knots = np.array([0.7, 1.1, 1.8, 2.2, 2.9, 3.3])
    before, after = (stops.derivatives(knots + d) for d in (-1e-9, 1e-9))
    np.testing.assert_allclose(before, after, atol=1e-5)
    np.testing.assert_allclose(before[1:], 0.0, atol=1e-5)


def test_random_sines_have_their_size_and_band(rng):
    signal = Sines.random(rng, 0.3, (0.2, 2.5))
    assert 0.2 <= min(signal.frequencies_hz) < max(signal.frequencies_hz) <= 2.5
    values = signal.derivatives(np.linspace(0.0, 4000.0, 400_001))[0]
    assert np.sqrt(np.mean(values**2)) == pytest.approx(0.3, rel=0.02)


def test_handheld_is_the_seeds_alone():
    one, same, other = (
        handheld(np.random.default_rng(seed)).sampled(30.0, 2.0).poses.coefficients
        for seed in (5, 5, 6)
    )
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.01


def test_zoom_grows_by_its_factor():
    scale = MOTIONS["zoom"].at(np.linspace(0.0, 5.0, 5001)).pose.scale
    assert scale.max() == pytest.approx(np.exp(0.7), rel=1e-6)
    assert scale.min() == pytest.approx(np.exp(-0.7), rel=1e-6)


def test_accelerations_are_those_an_inertial_sensor_feels():
    sample = sampled_motion(MOTIONS["screw"].at(np.linspace(0.0, 3.0, 7)))
    inward = -0.7 * np.ones(7)
    centre = sample.pose.translation_m * [1.0, 1.0, 0.0]
    found = np.sum(sample.world_acceleration_m_s2 * centre, axis=1) / 0.7
    np.testing.assert_allclose(found, inward, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Motion((), Motor), "one or more"),
        (lambda: Motion((Factor(np.zeros(6), Polynomial((1.0,))),), Similarity), "7 numbers"),
        (lambda: Factor(np.zeros(5), Polynomial((1.0,))), "Factor.twist"),
        (lambda: Factor(np.zeros((2, 7)), Polynomial((1.0,))), r"Factor.twist: .* got \(2, 7\)"),
        (lambda: Factor([0, 0, 0, 0, 0, np.nan], Polynomial((1.0,))), "finite"),
        (lambda: Polynomial(()), "Polynomial.coefficients"),
        (lambda: Sines((1.0,), (1.0, 2.0), (0.0,)), "one frequency"),
        (lambda: Sines.single(1.0, 0.0), "above 0"),
        (lambda: Sines.random(np.random.default_rng(0), 1.0, (2.0, 1.0)), "low < high"),
        (lambda: Stops((1.0,), 1.0, 1.0), "2 or more"),
        (lambda: Stops((1.0, 2.0), 0.0, 1.0), "move_s"),
        (lambda: MOTIONS["screw"].sampled(0.0, 1.0), "rate_hz"),
        (lambda: MOTIONS["screw"].sampled(30.0, np.inf), "duration_s"),
        (lambda: MOTIONS["screw"].at([0.0, np.nan]), "finite"),
    ],
)
def test_bad_input_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
