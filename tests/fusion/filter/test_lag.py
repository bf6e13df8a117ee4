"""Fixed lag: between the live filter and the smoother, exact, and robust as far as it can see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.fusion.filter import FilterSettings, PoseFilter, fuse
from motorcade.fusion.measurements.positions import VelocityMeasurements
from motorcade.fusion.metrics import absolute_translation_m
from motorcade.ga import Motor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements

LAG_S = 0.5
MORE = {"gravity_sigma_rad": 0.02, "extrinsics_sigma_rad": 0.02, "time_offset_sigma_s": 0.002}
SAME = ("velocity_m_s", "gyro_bias_rad_s", "accel_bias_m_s2", "covariance", "accepted", "nis")


def disturbed(run, rows, shift_m):
    """The run with some poses somewhere else."""
    path = run.measurements.trajectory
    shift = np.where(np.isin(np.arange(len(path)), rows)[:, None], shift_m, 0.0)
    moved = Motor.from_twist(np.hstack([np.zeros_like(shift), shift])) @ path.motors
    poses = Trajectory(path.time_ns, moved, path.parent, path.child)
    return replace(run, measurements=PoseMeasurements(poses, run.measurements.covariance))


def check_identical(one, other):
    assert one.trajectory.motors.coefficients.tobytes() == (
        other.trajectory.motors.coefficients.tobytes()
    )
    for name in SAME:
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), name


def until(run, time_ns):
    """What was measured up to a moment."""
    path = run.measurements.trajectory
    known = path.time_ns <= time_ns
    return PoseMeasurements(path[known], run.measurements.covariance[known])


def errors_m(fused, run):
    at = run.camera.at(fused.trajectory.time_ns)
    return absolute_translation_m(fused.trajectory.motors, at)


@pytest.mark.parametrize("settings", [{}, MORE])
@pytest.mark.parametrize("rows", [[], [0, 20, 21, 40]])
def test_no_lag_is_the_live_filter_and_a_long_one_the_smoother(record, rng, settings, rows):
    run = disturbed(record(rng, 3.0), rows, [0.3, -0.2, 0.5])
    options = {"settings": FilterSettings(**settings), "stamps_ns": run.imu.time_ns[10::7]}
    check_identical(run.fuse(**options, lag_s=0.0), run.fuse(**options, smoothed=False))
    check_identical(run.fuse(**options, lag_s=3.0), run.fuse(**options))
    check_identical(run.fuse(**options, lag_s=1e12), run.fuse(**options))


@pytest.mark.parametrize("settings", [{}, MORE])
def test_a_moment_is_what_the_smoother_makes_of_all_up_to_its_lag(record, rng, settings):
    run = record(rng, 3.0)
    options = {"settings": FilterSettings(gate=1.0, **settings)}
    lagged = run.fuse(**options, stamps_ns=run.imu.time_ns[::13], lag_s=LAG_S)
    for row in range(3, len(lagged.trajectory), 5):
        moment = lagged.trajectory.time_ns[row]
        known = replace(run, measurements=until(run, moment + round(LAG_S * 1e9)))
        whole = known.fuse(**options, stamps_ns=np.array([moment]))
        apart = lagged.trajectory.motors[row : row + 1].inverse() @ whole.trajectory.motors
        assert np.max(np.abs(apart.as_twist())) < 1e-9
        sigma = np.sqrt(np.diag(whole.covariance[0]))
        difference = lagged.covariance[row] - whole.covariance[0]
        assert np.max(np.abs(difference) / np.outer(sigma, sigma)) < 1e-9
        assert np.max(np.abs(lagged.gyro_bias_rad_s[row] - whole.gyro_bias_rad_s[0])) < 1e-9


@pytest.mark.parametrize("late_s", [0.0, 0.12])
def test_a_filter_that_runs_live_answers_late_what_the_recording_holds(record, rng, late_s):
    run = record(rng, 3.0)
    live = PoseFilter(run.noise, run.imu_T_camera, lag_s=LAG_S, settings=FilterSettings(gate=1.0))
    path, lag_ns, late_ns = run.measurements.trajectory, round(LAG_S * 1e9), round(late_s * 1e9)
    found, waiting = [], 0
    for time_ns, rate, force in zip(
        run.imu.time_ns.tolist(),
        run.imu.angular_rate_rad_s,
        run.imu.specific_force_m_s2,
        strict=True,
    ):
        live.imu(time_ns, rate, force)
        while waiting < len(path) and path.time_ns[waiting] + late_ns <= time_ns:
            spread = run.measurements.covariance[waiting]
            live.camera_pose(int(path.time_ns[waiting]), path.motors[waiting], spread)
            waiting += 1
        if late_s == 0.0 and time_ns - lag_ns > path.time_ns[0]:
            found.append(live.state_at(time_ns - lag_ns))
    if late_s > 0.0:
        moments = path.time_ns[(path.time_ns >= time_ns - lag_ns)]
        found = [live.state_at(int(moment)) for moment in moments]
    stamps = np.array([one.time_ns for one in found])
    settings = FilterSettings(gate=1.0)
    lag_s = LAG_S if late_s == 0.0 else np.inf
    arrived = replace(run, measurements=until(run, path.time_ns[waiting - 1]))
    expected = arrived.fuse(
        stamps_ns=stamps,
        lag_s=lag_s,
        settings=settings,
    )
    poses = Motor.concatenate([one.world_T_camera.reshape(1) for one in found])
    apart = (poses.inverse() @ expected.trajectory.motors).as_twist()
    assert np.max(np.abs(apart)) < 1e-9
    for one, covariance in zip(found, expected.state_covariance, strict=True):
        sigma = np.sqrt(np.diag(covariance))
        assert (
            np.max(np.abs(one.covariance - covariance) / np.outer(sigma, sigma)) < 1e-6
        )  # of a start that knows no speed little is left


def test_the_state_of_now_is_that_of_the_filter(record, rng):
    run = record(rng, 1.0)
    live = PoseFilter(run.noise, run.imu_T_camera, lag_s=LAG_S)
    with pytest.raises(ValueError, match="a filter that started"):
        live.state_at(0)
    for k in range(100):
        live.imu(int(run.imu.time_ns[k]), run.imu.angular_rate_rad_s[k],
                 run.imu.specific_force_m_s2[k])  # fmt: skip
        if k == 60:
            live.camera_pose(int(run.imu.time_ns[k]), Motor.identity(), 1e-4 * np.eye(6))
    now = live.state
    assert live.state_at(now.time_ns).covariance.tobytes() == now.covariance.tobytes()
    with pytest.raises(ValueError, match="after the start"):
        live.state_at(int(run.imu.time_ns[55]))
    for moment in (now.time_ns + 1, now.time_ns - round(LAG_S * 1e9) - 1):
        with pytest.raises(ValueError, match="one within"):
            live.state_at(moment)


def test_a_burst_that_moves_as_one_is_seen_through_where_it_ends_within_the_lag(record, rng):
    """It lasts longer than live waits for its end."""
    run = disturbed(record(rng, 8.0), range(60, 105), [0.8, -0.5, 0.3])
    whole = np.max(errors_m(run.fuse(), run))
    live, short, long = (np.max(errors_m(run.fuse(lag_s=lag_s), run)) for lag_s in (0.0, 0.2, 4.0))
    assert long < 1.2 * whole < 0.05 < short <= live


def test_scattered_outliers_are_left_out_by_what_comes_soon_after(record, rng):
    rows = np.flatnonzero(rng.random(121) < 0.3)
    run = disturbed(record(rng, 6.0), rows, 2.0 * rng.uniform(-1.0, 1.0, (121, 3)))
    whole, lagged = run.fuse(), run.fuse(lag_s=1.0)
    assert np.max(errors_m(lagged, run)) < 1.3 * np.max(errors_m(whole, run))
    assert np.mean(lagged.accepted == whole.accepted) > 0.98


def test_other_measurements_are_settled_too(record, rng):
    run = record(rng, 3.0)
    stamps = run.imu.time_ns[10:-10:10]
    speed = run.fuse(stamps_ns=stamps).velocity_m_s
    spread = np.tile(1e-4 * np.eye(3), (len(stamps), 1, 1))
    also = [VelocityMeasurements(time_ns=stamps, velocity_m_s=speed, covariance=spread)]
    check_identical(run.fuse(also=also, lag_s=3.0), run.fuse(also=also))
    lagged = run.fuse(also=also, lag_s=LAG_S).also[0]
    assert np.all(lagged.accepted)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"lag_s": -1.0}, "lag_s: expected seconds from 0 on, got -1.0"),
        ({"lag_s": np.nan}, "lag_s: expected seconds from 0 on, got nan"),
        (
            {"lag_s": 1.0, "smoothed": False},
            "lag_s: expected none where nothing looks ahead, got 1.0",
        ),
    ],
)
def test_lags_that_mean_nothing_are_refused(record, rng, options, message):
    run = record(rng, 1.0)
    with pytest.raises(ValueError, match=message):
        fuse(run.measurements, run.imu, run.noise, run.imu_T_camera, **options)


def test_a_live_filter_refuses_to_look_ahead_for_ever(record, rng):
    with pytest.raises(ValueError, match="lag_s: expected finite seconds"):
        PoseFilter(record(rng, 1.0).noise, lag_s=np.inf)
