"""Gaps split what is simulated along a path: work grows with its poses, not with the time."""

import numpy as np
import pytest

from motorcade.fusion import ADIS16448, ContinuousPath, simulate_camera_poses, simulate_imu
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Blackouts
from motorcade.fusion.smoothing import smooth
from motorcade.ga import Trajectory

DAY_S, YEARS_S = 86_400.0, 30 * 365 * 86_400.0
STEP_NS = 50_000_000


def split(gap_s: float) -> Trajectory:
    """Three seconds of a motion, a gap of the clock, three more."""
    path = MOTIONS["handheld"].sampled(20.0, 6.0)
    later = (np.arange(len(path)) > 60) * round(gap_s * 1e9)
    return Trajectory(path.time_ns + later, path.poses)


@pytest.mark.parametrize("gap_s", [20.0, DAY_S, YEARS_S])
def test_an_imu_is_read_in_each_segment_as_if_it_were_alone(gap_s, rng):
    path = split(gap_s)
    whole = simulate_imu(path, 200.0, None, rng)
    alone = [simulate_imu(part, 200.0, None, rng) for part in (path[:61], path[61:])]
    assert len(whole.stream) == sum(len(one.stream) for one in alone)
    for name in ("angular_rate_rad_s", "specific_force_m_s2"):
        expected = np.concatenate([getattr(one.stream, name) for one in alone])
        # thirty years in seconds are known to a tenth of a microsecond
        assert np.allclose(getattr(whole.stream, name), expected, atol=1e-4)
    stamps = np.concatenate([one.stream.time_ns for one in alone])
    assert np.abs(whole.stream.time_ns - stamps).max() <= 256


def test_between_segments_a_path_follows_the_screw(rng):
    path = split(DAY_S)
    continuous = ContinuousPath.through(path)
    ends = [3.0, DAY_S + 3.05]
    joined = continuous.twists(np.array([ends[0], sum(ends) / 2, ends[1]])).pose
    halfway = joined[0].interpolate(joined[2], 0.5)
    assert np.allclose(joined[1].coefficients, halfway.coefficients, atol=1e-6)
    assert continuous.twists(np.full((2, 3), 1.0)).body_twist.shape == (2, 3, 6)


def test_biases_walk_on_through_a_gap(rng):
    """By the square root of the time that it lasts."""
    paths = [
        simulate_imu(split(DAY_S), 20.0, ADIS16448, np.random.default_rng(seed))
        for seed in range(100)
    ]
    leaps = np.array([one.gyro_bias_rad_s[61] - one.gyro_bias_rad_s[60] for one in paths])
    expected = ADIS16448.gyro_walk_rad_s2_rthz * np.sqrt(DAY_S)
    assert np.std(leaps) == pytest.approx(expected, rel=0.2)


def test_more_samples_than_there_may_be_are_refused(rng):
    with pytest.raises(ValueError, match="expected at most 10000000 samples, got"):
        simulate_imu(split(0.0), 1e9, None, rng)
    with pytest.raises(ValueError, match=r"rate_hz of .* over 10 s: expected at most 10000000"):
        MOTIONS["handheld"].sampled(1e9, 10.0)
    with pytest.raises(ValueError, match="rate_hz"):
        simulate_camera_poses(split(0.0), 1e9, 0.01, 0.01, rng)


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, 1e10, 1e300, np.inf, np.nan])
def test_rates_that_no_sensor_has_are_refused(rate_hz, rng):
    with pytest.raises(ValueError, match="rate_hz"):
        simulate_imu(split(0.0), rate_hz, None, rng)
    with pytest.raises(ValueError, match="rate_hz"):
        simulate_camera_poses(split(0.0), rate_hz, 0.01, 0.01, rng)
    with pytest.raises(ValueError, match="rate_hz"):
        MOTIONS["handheld"].sampled(rate_hz, 10.0)


def test_an_offset_of_ages_is_refused(rng):
    with pytest.raises(ValueError, match=r"time_offset_s: expected seconds up to .* got 1e"):
        simulate_imu(split(0.0), 20.0, None, rng, time_offset_s=1e300)


@pytest.mark.parametrize("gap_s", [20.0, YEARS_S])
def test_cameras_see_nothing_in_a_gap(gap_s, rng):
    assert len(simulate_camera_poses(split(gap_s), 40.0, 0.01, 0.01, rng)) == 121 + 119


@pytest.mark.parametrize("representation", ["motor", "rotor", "euler", "similarity"])
def test_each_segment_has_a_spline_of_its_own(representation):
    path = split(DAY_S)
    made = smooth(path, "spline", representation, knot_spacing_s=0.2)
    alone = [smooth(part, "spline", representation) for part in (path[:61], path[61:])]
    expected = np.concatenate([one.poses.coefficients for one in alone])
    assert np.allclose(made.poses.coefficients, expected, atol=1e-12)


def test_a_pose_alone_between_gaps_stays():
    path = split(DAY_S)
    stamps = np.append(path.time_ns, path.time_ns[-1] + round(DAY_S * 1e9))
    lonely = Trajectory(stamps, path.poses[np.append(np.arange(len(path)), 5)])
    made = smooth(lonely, "spline")
    assert np.array_equal(made.poses[-1].coefficients, lonely.poses[-1].coefficients)


def test_blackouts_of_years_are_those_that_are_listed():
    dark = Blackouts(1.0, 4.0)
    seconds = np.sort(np.random.default_rng(0).uniform(0.0, 40.0, 500))
    listed = [np.any([a <= s < b for a, b in dark.spans_s(38.0)]) for s in np.round(seconds, 6)]
    assert np.array_equal(dark.dark(seconds, 38.0), listed)
    assert np.array_equal(
        dark.dark(np.array([0.5, YEARS_S, YEARS_S + 1.5]), 2 * YEARS_S), [False, True, False]
    )
