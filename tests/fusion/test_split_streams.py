"""Gaps split streams for whoever fuses or correlates them; what is too long is refused."""

import numpy as np
import pytest

from motorcade.fusion import (
    ADIS16448,
    ContinuousPath,
    ImuStream,
    fuse,
    fuse_by_graph,
    preintegrate,
    simulate_camera_poses,
    simulate_imu,
    smooth,
    synchronise,
)
from motorcade.fusion.filter import FilterSettings
from motorcade.fusion.filter.fitting import fit_noise
from motorcade.fusion.metrics import angular_rate_lag_s, evaluate
from motorcade.fusion.metrics.lag import _even_rates
from motorcade.fusion.metrics.smooth_path import SmoothPath
from motorcade.fusion.motions import MOTIONS, handheld
from motorcade.fusion.visual_inertial import start_inertial
from motorcade.ga import Motor, Trajectory
from motorcade.replays.comparison.evaluator import RecordedTruth
from motorcade.tracking import PoseMeasurements

DAY_S, YEARS_S = 86_400.0, 30 * 365 * 86_400.0


def drawn(duration_s=6.0):
    rng = np.random.default_rng(0)
    sensor = simulate_imu(ContinuousPath.along(handheld(rng), duration_s), 200.0, ADIS16448, rng)
    return simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng), sensor.stream


def split(measured, imu, gap_s, at_s=2.5):
    """The same with a leap of the clock."""
    at_ns = round(at_s * 1e9)

    def later(stamps):
        return stamps + np.where(stamps > at_ns, round(gap_s * 1e9), 0)

    path = measured.trajectory
    moved = Trajectory(later(path.time_ns), path.poses)
    stream = ImuStream(later(imu.time_ns), imu.angular_rate_rad_s, imu.specific_force_m_s2)
    return PoseMeasurements(moved, measured.covariance), stream


def part(measured, imu, rows, samples):
    return (
        PoseMeasurements(measured.trajectory[rows], measured.covariance[rows]),
        ImuStream(
            imu.time_ns[samples], imu.angular_rate_rad_s[samples], imu.specific_force_m_s2[samples]
        ),
    )


@pytest.mark.parametrize("fused_by", [fuse, fuse_by_graph])
@pytest.mark.parametrize("gap_s", [20.0, YEARS_S])
def test_each_segment_is_fused_for_itself(fused_by, gap_s):
    measured, imu = split(*drawn(), gap_s)
    whole = fused_by(measured, imu, ADIS16448, Motor.identity())
    rows, samples = measured.trajectory.time_ns > gap_s * 1e9, imu.time_ns > gap_s * 1e9
    alone = [
        fused_by(*part(measured, imu, chosen, sampled), ADIS16448, Motor.identity())
        for chosen, sampled in ((~rows, ~samples), (rows, samples))
    ]
    for name in ("velocity_m_s", "covariance", "nis", "accepted", "gyro_bias_rad_s"):
        expected = np.concatenate([getattr(one, name) for one in alone])
        assert np.array_equal(getattr(whole, name), expected, equal_nan=name == "nis")
    stamps = np.concatenate([one.trajectory.time_ns for one in alone])
    assert np.array_equal(whole.trajectory.time_ns, stamps)


def test_stamps_between_segments_are_left_out():
    measured, imu = split(*drawn(), DAY_S)
    wanted = np.array([1_000_000_000, 3_000_000_000, round(DAY_S * 1e9) + 5_000_000_000])
    found = fuse(measured, imu, ADIS16448, Motor.identity(), wanted)
    assert np.array_equal(found.trajectory.time_ns, wanted[[0, 2]])


def test_noise_is_fitted_where_most_poses_are():
    rng = np.random.default_rng(4)
    path = ContinuousPath.along(handheld(rng), 50.0)
    sensor = simulate_imu(path, 100.0, ADIS16448.scaled(10.0), rng)
    measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)
    stamps = measured.trajectory.time_ns
    seen, imu = part(measured, sensor.stream, (stamps < 5e9) | (stamps > 30e9), slice(None))
    alone = part(seen, imu, seen.trajectory.time_ns > 30e9, imu.time_ns > 30e9)
    expected = fit_noise(*alone, ADIS16448, Motor.identity())
    assert expected.accel_density_m_s2_rthz > 4.0 * ADIS16448.accel_density_m_s2_rthz
    for streams in (split(seen, imu, DAY_S, 20.0), (seen, imu)):
        fitted = fit_noise(*streams, ADIS16448, Motor.identity())
        assert fitted.accel_density_m_s2_rthz > 4.0 * ADIS16448.accel_density_m_s2_rthz
    ends = part(seen, imu, (seen.trajectory.time_ns < 5e9) | (seen.trajectory.time_ns > 45e9),
                slice(None))  # fmt: skip
    assert fit_noise(*ends, ADIS16448, Motor.identity()) == ADIS16448  # too few to tell


def test_measurements_in_gaps_alone_are_refused():
    measured, imu = split(*drawn(), DAY_S)
    at = Trajectory(np.array([10**12, 10**12 + 10**9]), Motor.identity((2,)))
    lost = PoseMeasurements(at, measured.covariance[:2])
    with pytest.raises(ValueError, match="in one of the 2 segments between gaps of the imu, got"):
        fuse(lost, imu, ADIS16448, Motor.identity())


def test_a_stream_of_a_sample_a_minute_is_none():
    measured, imu = drawn()
    slow = ImuStream(imu.time_ns * 12_000, imu.angular_rate_rad_s, imu.specific_force_m_s2)
    path = measured.trajectory
    at = PoseMeasurements(Trajectory(path.time_ns * 12_000, path.poses), measured.covariance)
    for estimate in (fuse, fuse_by_graph, start_inertial):
        with pytest.raises(ValueError, match="samples at most 10 s apart, got 60 s"):
            estimate(at, slow, ADIS16448, Motor.identity())
    with pytest.raises(ValueError, match="samples at most 10 s apart, got 60 s"):
        synchronise(at.trajectory, slow, ADIS16448)


def test_gaps_are_not_integrated():
    _, imu = split(*drawn(), DAY_S)
    with pytest.raises(ValueError, match="imu: expected samples at most 10 s apart between keyf"):
        preintegrate(imu, imu.time_ns[[0, -1]], ADIS16448)
    fast = ImuStream(imu.time_ns[:3], np.full((3, 3), 1e8), np.zeros((3, 3)))
    with pytest.raises(ValueError, match="turns up to 1000 rad between samples, got"):
        preintegrate(fast, fast.time_ns, ADIS16448)


def test_the_longest_segment_tells_the_offset(caplog):
    measured, imu = split(*drawn(12.0), DAY_S, at_s=4.0)
    found = synchronise(measured.trajectory, imu, ADIS16448, search_s=0.1)
    assert found.time_ns[0] > DAY_S * 1e9
    assert abs(found.offset_s) < 0.01
    assert "gaps split the imu into 2 segments: the longest is used, 15" in caplog.text


@pytest.mark.parametrize("search_s", [1e9, 60.1, np.inf, np.nan])
def test_searches_of_ages_are_refused(search_s):
    measured, imu = drawn(3.0)
    with pytest.raises(ValueError, match="search_s: expected seconds above 0 and up to 60, got"):
        synchronise(measured.trajectory, imu, ADIS16448, search_s=search_s)


@pytest.mark.parametrize("gap_s", [20.0, DAY_S, YEARS_S])
def test_errors_beside_a_gap_are_those_without_it(gap_s):
    """The clock of both leaps in the middle: what is judged on either side does not change."""
    path = MOTIONS["handheld"].sampled(30.0, 6.0)
    noisy = simulate_camera_poses(path, 30.0, 0.01, 0.01, np.random.default_rng(0)).trajectory
    leap = (np.arange(len(path)) > 90) * round(gap_s * 1e9)
    with_gap = [Trajectory(one.time_ns + leap, one.poses) for one in (noisy, path)]
    plain, found = (evaluate(*both).as_dict() for both in ((noisy, path), with_gap))
    for name in ("ape_rmse_m", "rotation_rmse_deg", "pairs", "spurious_turns"):
        assert found[name] == plain[name]
    for name in ("linear_jitter_m_s2", "angular_jitter_rad_s2", "rotation_path_ratio"):
        assert found[name] == pytest.approx(plain[name], rel=0.05)


@pytest.mark.parametrize("gap_s", [DAY_S, YEARS_S])
def test_lag_is_sought_where_there_are_poses(gap_s, monkeypatch):
    path = MOTIONS["handheld"].sampled(30.0, 6.0)
    leap = (np.arange(len(path)) > 90) * round(gap_s * 1e9)
    truth = Trajectory(path.time_ns + leap, path.poses)
    late = Trajectory(truth.time_ns + 20_000_000, truth.poses)
    sizes = []
    rotors = SmoothPath.rotors

    def counted(self, time_s):
        sizes.append(time_s.size)
        return rotors(self, time_s)

    monkeypatch.setattr(SmoothPath, "rotors", counted)
    assert 1e3 * angular_rate_lag_s(late, truth) == pytest.approx(20.0, abs=1.0)
    assert 0 < max(sizes) < 2000


def test_without_gaps_the_grid_of_rates_is_the_whole_one():
    path = SmoothPath.through(MOTIONS["handheld"].sampled(30.0, 6.0))
    time_s = np.arange(1.0, 5.0, 1 / 30)
    near = _even_rates(path, 0.033, time_s, 0.5)
    everywhere = _even_rates(path, 0.033, np.arange(0.0, 6.0, 0.1), 1.0)
    for lag_s in (-0.5, 0.0, 0.123, 0.5):
        assert np.array_equal(near(time_s - lag_s), everywhere(time_s - lag_s))


@pytest.mark.parametrize("gap_s", [0.0, DAY_S, YEARS_S])
def test_a_recorded_truth_has_rows_where_it_has_poses(gap_s):
    path = MOTIONS["handheld"].sampled(30.0, 6.0)
    leap = (np.arange(len(path)) > 90) * round(gap_s * 1e9)
    truth = RecordedTruth(Trajectory(path.time_ns + leap, path.poses))
    time_s = truth.seconds(path.time_ns + leap)
    places, rotors = truth.between_rows(time_s)
    # the last row of a table is less than a millisecond from the one before it
    assert np.abs(places - path.poses.translation_m)[:-1].max() < 1e-5
    assert (rotors.inverse() @ path.motors.rotor).angle()[:-1].max() < 1e-5
    assert len(truth._table[2]) < 12_000


@pytest.mark.parametrize(
    ("method", "parameters"),
    [
        ("gaussian", {"sigma_s": 1e300}),
        ("gaussian", {"sigma_s": 1e9}),
        ("local_polynomial", {"window_s": 1e300}),
        ("savitzky_golay", {"window_s": 1e10}),
    ],
)
def test_windows_of_ages_are_refused(method, parameters):
    path = MOTIONS["handheld"].sampled(30.0, 1.0)
    with pytest.raises(ValueError, match=r"_s.*: expected seconds up to 1e\+09 \(thirty years\)"):
        smooth(path, method, **parameters)


def test_settings_of_ages_are_refused():
    with pytest.raises(ValueError, match="gap_s: expected seconds up to"):
        FilterSettings(gap_s=1e300)
    measured, imu = drawn(3.0)
    with pytest.raises(ValueError, match="time_offset_s: expected seconds up to"):
        fuse(measured, imu, ADIS16448, Motor.identity(), time_offset_s=1e300)
