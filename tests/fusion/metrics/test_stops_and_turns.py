"""What counts as a stop, as a turn of the way and as a whole turn: just below, just above."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.metrics import (
    NotObservableError,
    gimbal_index,
    position_overshoot_m,
    seconds_per_pose,
)
from motorcade.fusion.metrics.artifacts import (
    path_over_geodesic,
    rotation_path_rad,
    stops,
    winding_count,
)
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor, Trajectory


def about(angles_rad, axis=(0.36, 0.48, 0.8)) -> Rotor:
    return Rotor.from_rotation_vector(np.asarray(angles_rad)[:, None] * np.asarray(axis))


def walking(speeds_m_s, step_s=0.1) -> Trajectory:
    """Along x at these speeds from stamp to stamp."""
    way = np.concatenate([[0.0], np.cumsum(np.asarray(speeds_m_s) * step_s)])
    stamps = np.round(1e9 * step_s * np.arange(len(way))).astype(np.int64)
    positions = way[:, None] * [1.0, 0.0, 0.0]
    return Trajectory(stamps, Motor.from_rotor_translation(Rotor.identity(way.shape), positions))


@pytest.mark.parametrize(
    ("speed", "expected"),
    [
        ([1.0, 0.19, 1.0], [(0, 1, 2)]),
        ([1.0, 0.2, 1.0], []),  # no stop: no less than a fifth of the peak before
        ([1.0, 0.1, 0.5], [(0, 1, 3)]),  # no peak after it: no more than five times as fast
        ([1.0, 0.1, 0.49, 0.1, 1.0], [(0, 1, 4)]),  # no peak between: less than five times
        ([1.0, 0.1, 0.51, 0.05, 1.0], [(0, 1, 2), (2, 3, 4)]),
        ([1.0, 0.1, 0.05, 0.02], [(0, 2 + 1, 4)]),  # the end stands for the second peak
        ([0.5, 1.0, 0.9, 0.0], [(1, 3, 4)]),  # the highest before, the lowest after
        ([1.0, 0.1, 0.1, 0.05, 2.0, 3.0, 0.3], [(0, 3, 5), (5, 6, 7)]),
        ([0.2, 1.0, 1.0], []),
        ([0.0, 1.0, 0.0, 2.0], [(1, 2, 3)]),  # it starts from rest: that is no stop
    ],
)
def test_stops_lie_between_peaks_five_times_as_fast(speed, expected):
    assert stops(np.array(speed)) == expected


def test_of_equal_speeds_the_first_counts_and_rounding_chooses_none():
    assert stops(np.array([1.0, 1.0, 0.1, 0.1, 1.0, 1.0])) == [(0, 2, 4)]
    wobble = np.array([1.0, 1.0 + 1e-10, 0.1, 0.1 - 1e-11, 1.0, 1.0 + 1e-10])
    assert stops(wobble) == [(0, 2, 4)]
    told = np.array([1.0, 1.0 + 1e-8, 0.1, 0.1 - 1e-8, 1.0, 1.0 + 1e-8])
    assert stops(told) == [(1, 3, 5)]


def test_a_millionth_of_the_fastest_speed_is_standing_still():
    still = np.array([1.0, 9e-7, 4e-7, 1.0])
    assert stops(still) == [(0, 1, 3)]  # both are zero, and the first of them counts
    assert stops(np.array([1.0, 4e-6, 2e-6, 1.0])) == [(0, 2, 3)]


def test_overshoot_takes_the_way_from_peak_to_peak_and_no_more():
    """Off the way only after the next peak, it has overshot nothing."""
    truth = walking([1.0] * 5 + [0.0] * 5 + [1.0] * 5)
    positions = truth.motors.translation_m.copy()
    for row, expected in ((8, 0.07), (9, 0.07)):
        moved = positions.copy()
        moved[row, 0] += 0.07
        estimate = Trajectory(
            truth.time_ns, Motor.from_rotor_translation(truth.motors.rotor, moved)
        )
        assert position_overshoot_m(estimate, truth) == pytest.approx(expected, abs=1e-9)
    ahead = positions.copy()
    ahead[12:, 0] += 0.5
    later = Trajectory(truth.time_ns, Motor.from_rotor_translation(truth.motors.rotor, ahead))
    assert position_overshoot_m(later, truth) == 0.0
    short = positions.copy()
    short[5:, 0] -= 0.1
    before = Trajectory(truth.time_ns, Motor.from_rotor_translation(truth.motors.rotor, short))
    assert position_overshoot_m(before, truth) == 0.0


def test_a_stop_back_at_the_start_tells_no_direction():
    there_and_back = walking([1.0, -1.0, 0.0, 0.0])
    with pytest.raises(NotObservableError, match="that stops or turns back on its way"):
        position_overshoot_m(there_and_back, there_and_back)


def test_overshoot_reads_speeds_at_the_stamps_as_they_are():
    """Even motion at uneven stamps neither stops nor turns; long steps are no fast ones."""
    seconds = np.array([0.0, 0.1, 0.2, 0.21, 0.22, 0.32, 0.42])
    stamps = np.round(1e9 * seconds).astype(np.int64)
    even = Trajectory(stamps, Motor.from_twist(seconds[:, None] * np.eye(6)[3]))
    with pytest.raises(NotObservableError, match="that stops or turns back on its way"):
        position_overshoot_m(even, even)


def test_five_stamps_within_the_truth_are_enough_for_overshoot():
    truth = walking([1.0, 1.0, 0.0, 0.0])
    assert position_overshoot_m(truth, truth) == 0.0
    with pytest.raises(NotObservableError, match="5 or more stamps within the ground truth, got 4"):
        position_overshoot_m(truth[:4], truth)


@pytest.mark.parametrize(
    ("end_deg", "turns"), [(100, 0), (260, 0), (272, 1), (360, 1), (628, 1), (640, 2), (-280, 1)]
)
def test_a_whole_turn_ends_within_a_quarter_of_the_truth(end_deg, turns):
    error = about(np.deg2rad(np.linspace(0.0, end_deg, 200)))
    assert winding_count(error) == turns
    assert winding_count(error[::-1]) == turns


def test_errors_that_leave_a_quarter_and_come_back_the_other_way_are_counted_once():
    """From 80° (at home) all the way round to 275°, which is 85° short of the ground truth."""
    assert winding_count(about(np.deg2rad(np.linspace(80.0, 275.0, 100)))) == 1
    assert winding_count(about(np.deg2rad(np.linspace(95.0, 275.0, 100)))) == 0  # never at home


def test_the_sign_of_a_rotor_says_nothing(rng):
    for end_deg in (100.0, 200.0, 260.0, 350.0, 500.0, 1000.0):
        error = about(np.deg2rad(np.linspace(0.0, end_deg, 300)))
        signs = rng.choice([-1.0, 1.0], (300, 1))
        assert winding_count(Rotor(signs * error.coefficients)) == winding_count(error)


def test_two_stamps_within_the_truth_are_enough_for_turning():
    truth = MOTIONS["handheld"].sampled(30.0, 1.0)
    found = gimbal_index(truth[10:12], truth)
    assert found.path_ratio == pytest.approx(1.0, abs=1e-9)
    assert found.peak_rate_ratio == pytest.approx(1.0, abs=1e-9)
    with pytest.raises(NotObservableError, match="2 or more stamps within the ground truth, got 1"):
        gimbal_index(truth[10:11], truth)


def test_rates_are_over_the_steps_as_they_are():
    """The same turns in steps of a half and of a twentieth of a second: ten times the rate."""
    stamps = np.array([0, 500, 1000, 1050, 1500, 2000]) * 1_000_000
    true, ours = 0.1 * stamps * 1e-9, np.array([0.0, 0.05, 0.10, 0.15, 0.16, 0.21])
    truth, estimate = (
        Trajectory(stamps, Motor.from_rotor_translation(about(angles), np.zeros((6, 3))))
        for angles in (true, ours)
    )
    found = gimbal_index(estimate, truth)
    assert found.peak_rate_ratio == pytest.approx((0.05 / 0.05) / 0.1, rel=1e-6)
    assert found.path_ratio == pytest.approx(0.21 / 0.2, rel=1e-6)


@pytest.mark.parametrize(("turn_rad", "still"), [(1e-10, True), (1e-7, False)])
def test_a_nanoradian_is_no_turn(turn_rad, still):
    rotors = about(turn_rad * np.linspace(0.0, 1.0, 5))
    stamps = np.arange(5) * 100_000_000
    path = Trajectory(stamps, Motor.from_rotor_translation(rotors, np.zeros((5, 3))))
    if still:
        with pytest.raises(NotObservableError, match="that turns, got one that does not"):
            gimbal_index(path, path)
        with pytest.raises(NotObservableError, match="ends that differ, got equal ones"):
            path_over_geodesic(rotors)
        return
    assert gimbal_index(path, path).path_ratio == pytest.approx(1.0, rel=1e-3)
    assert path_over_geodesic(rotors) == pytest.approx(1.0, rel=1e-3)


def test_a_path_there_and_back_is_as_long_as_both_ways():
    there = np.deg2rad(np.linspace(0.0, 50.0, 11))
    both = about(np.concatenate([there, there[::-1]]))
    assert rotation_path_rad(both) == pytest.approx(np.deg2rad(100.0), rel=1e-12)
    most = about(np.deg2rad([0.0, 40.0, -10.0]))
    assert path_over_geodesic(most) == pytest.approx(90.0 / 10.0, rel=1e-9)


def test_a_pose_costs_its_share_of_the_fastest_run(monkeypatch):
    """Three runs by a clock of ours: 5, 2 and 3 s over 31 poses."""
    ticks = iter([0.0, 5.0, 10.0, 12.0, 20.0, 23.0])
    monkeypatch.setattr("motorcade.fusion.metrics.evaluation.perf_counter", lambda: next(ticks))
    trajectory = MOTIONS["handheld"].sampled(30.0, 1.0)
    assert seconds_per_pose(lambda path: path, trajectory) == pytest.approx(2.0 / len(trajectory))
    with pytest.raises(StopIteration):  # three runs, and no more
        next(ticks)
    once = iter([1.0, 5.0])
    monkeypatch.setattr("motorcade.fusion.metrics.evaluation.perf_counter", lambda: next(once))
    found = seconds_per_pose(lambda path: path, trajectory, repeats=1)
    assert found == pytest.approx(4.0 / len(trajectory))
