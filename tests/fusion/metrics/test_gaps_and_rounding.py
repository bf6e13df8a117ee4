"""Jitter where stamps are few, uneven or missing, and where numbers are no more than rounding."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from motorcade.fusion.metrics import (
    NotObservableError,
    energy_excess_above,
    evaluate,
    jitter,
    jitter_above,
    log_dimensionless_jerk,
)
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor, Trajectory

MS = 1_000_000


def along(stamps_ms, way_m) -> Trajectory:
    """Shift by these metres along z, and turn by as many radians about x."""
    stamps = np.round(np.asarray(stamps_ms) * MS).astype(np.int64)
    way = np.asarray(way_m)[:, None]
    return Trajectory(
        stamps,
        Motor.from_rotor_translation(
            Rotor.from_rotation_vector(way * [1.0, 0.0, 0.0]), way * [0.0, 0.0, 1.0]
        ),
    )


def still(stamps_ms) -> Trajectory:
    return along(stamps_ms, np.zeros(len(stamps_ms)))


def spiked(stamps_ms, row: int, size: float = 1e-3) -> Trajectory:
    """At rest but for one pose."""
    return along(stamps_ms, size * (np.arange(len(stamps_ms)) == row))


def test_one_pose_off_jitters_as_its_second_differences():
    """1 mm at 100 Hz: 10, -20, 10 m/s² in three of eight."""
    found = jitter(spiked(np.arange(10) * 10, 5), still(np.arange(0, 200, 10)))
    expected = np.sqrt((10.0**2 + 20.0**2 + 10.0**2) / 8)
    assert found.linear_m_s2 == pytest.approx(expected, rel=1e-9)
    assert found.angular_rad_s2 == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("gap_ms", "told"), [(30, True), (31, False)])
def test_differences_across_more_than_three_intervals_do_not_count(gap_ms, told):
    """The shift after the gap is seen across it only."""
    stamps = np.concatenate([np.arange(6) * 10, 50 + gap_ms + np.arange(6) * 10])
    shifted = along(stamps, 1e-3 * (np.arange(12) >= 6))
    found = jitter(shifted, still(np.arange(0, 400, 10)))
    assert (found.linear_m_s2 > 1e-3) is told
    assert (found.angular_rad_s2 > 1e-3) is told


@pytest.mark.parametrize(("row", "told"), [(4, False), (5, True), (14, True), (15, False)])
def test_only_triples_within_the_truth_count(row, told):
    """Poses at 0 to 190 ms, a ground truth from 50 to 140."""
    found = jitter(spiked(np.arange(20) * 10, row), still(np.arange(50, 141, 10)))
    assert (found.linear_m_s2 > 1.0) is told


def test_three_stamps_are_enough_for_jitter_and_two_are_not():
    truth = still(np.arange(0, 200, 10))
    found = jitter(spiked([50, 60, 70], 1), truth)
    assert found.linear_m_s2 == pytest.approx(20.0)
    for few in ([50, 60], [50, 60, 250], [50, 60, 250, 260]):
        with pytest.raises(NotObservableError, match="three consecutive stamps of the estimate"):
            jitter(still(few), truth)


def test_three_poses_between_gaps_count():
    stamps = np.concatenate([np.arange(0, 200, 10), [300, 310, 320, 430]])
    assert jitter(spiked(stamps, 21), still(np.arange(0, 500, 10))).linear_m_s2 > 1.0


def test_a_gap_in_the_truth_is_left_out_by_itself():
    """What jitters within the gap is not judged; what jitters beside it is."""
    truth = still([*range(0, 100, 10), *range(200, 300, 10)])
    stamps = np.arange(0, 300, 10)
    assert jitter(spiked(stamps, 14), truth).linear_m_s2 == 0.0
    assert jitter(spiked(stamps, 5), truth).linear_m_s2 > 0.0
    assert jitter(spiked(stamps, 25), truth).linear_m_s2 > 0.0


def sine(count: int, rate_hz: float, frequency_hz: float, size: float = 1e-3) -> Trajectory:
    seconds = np.arange(count) / rate_hz
    return along(1e3 * seconds, size * np.sin(2.0 * np.pi * frequency_hz * seconds))


def test_jitter_above_is_the_root_of_scipys_band_power():
    path = sine(256, 100.0, 12.0)
    acceleration = np.diff(path.motors.translation_m[:, 2], 2) * 1e4
    level = signal.detrend(acceleration)
    frequency, density = signal.periodogram(level, 100.0, "hann", detrend=False)
    for above_hz in (5.0, 12.1, 15.9, 30.0):
        expected = np.sqrt(np.sum(density[frequency >= above_hz]) * frequency[1])
        found = jitter_above(path, above_hz)
        assert found.linear_m_s2 == pytest.approx(expected, rel=1e-6)
        assert found.angular_rad_s2 == pytest.approx(expected, rel=1e-6)


def test_sixteen_poses_without_a_gap_are_a_spectrum_and_fewer_are_none():
    assert jitter_above(sine(16, 100.0, 30.0), 10.0).linear_m_s2 > 1.0
    with pytest.raises(NotObservableError, match="a segment of 16 poses without a gap, got none"):
        jitter_above(sine(15, 100.0, 30.0), 10.0)
    # one interval and a half is no gap, more is one
    for gap_ms, told in ((15, True), (15.1, False)):
        stamps = np.concatenate([np.arange(8) * 10, 70 + gap_ms + np.arange(8) * 10])
        if told:
            assert jitter_above(still(stamps), 10.0).linear_m_s2 == 0.0
        else:
            with pytest.raises(NotObservableError, match="16 poses without a gap"):
                jitter_above(still(stamps), 10.0)


def test_longer_segments_weigh_more_and_short_ones_do_not_count():
    """A quiet segment of 300 poses and a jittering one of 100, beside 15 that jitter wildly."""
    rate_hz, frequency_hz, size = 100.0, 25.0, 1e-3
    counts, sizes = (300, 100, 15), (0.0, size, 100.0 * size)
    index = np.concatenate(
        [start + np.arange(n) for start, n in zip((0, 400, 600), counts, strict=True)]
    )
    amplitude = np.repeat(sizes, counts)
    seconds = index / rate_hz
    path = along(1e3 * seconds, amplitude * np.sin(2.0 * np.pi * frequency_hz * seconds))
    seen = size * (2.0 * np.sin(np.pi * frequency_hz / rate_hz) * rate_hz) ** 2 / np.sqrt(2.0)
    # Differences at both ends are lost, and a segment has one time step less than it has stamps.
    share = 98 / (98 + 298)
    found = jitter_above(path, 10.0)
    assert found.linear_m_s2 == pytest.approx(seen * np.sqrt(share), rel=0.02)


def test_frequencies_lie_between_zero_and_half_the_rate():
    path = sine(64, 100.0, 30.0)
    assert jitter_above(path, 49.9).linear_m_s2 >= 0.0
    for bad in (0.0, -1.0, 50.0, np.nan):
        with pytest.raises(ValueError, match=r"below half the rate \(50.000 Hz\), got"):
            jitter_above(path, bad)
    with pytest.raises(ValueError, match=r"below half the rate \(0.000 Hz\), got 1"):
        jitter_above(path[:1], 1.0)


def test_energy_needs_a_segment_within_the_truth():
    truth = still(np.arange(0, 1000, 10))
    for stamps, message in [
        ([990, 1000, 1010], "expected 2 or more stamps within the ground truth, got 1"),
        ([980, 990, 1000], "a segment of 16 poses without a gap, got none"),
        ([2000, 2010], "expected 2 or more stamps within the ground truth, got 0"),
    ]:
        with pytest.raises(NotObservableError, match=message):
            energy_excess_above(still(stamps), truth, 10.0)


def test_energy_is_compared_over_the_common_stamps_alone():
    """The estimate jitters outside the ground truth; within, both stand still."""
    stamps = np.arange(0, 1000, 10)
    wild = along(stamps, 1e-3 * ((-1.0) ** np.arange(100)) * (stamps < 300))
    truth = still(np.arange(400, 1000, 10))
    assert energy_excess_above(wild, truth, 10.0).linear_m2_s4 == 0.0
    jittering = along(stamps, 1e-3 * np.sin(2.0 * np.pi * 20.0 * stamps * 1e-3))
    later = jitter_above(jittering[stamps >= 400], 10.0)
    found = energy_excess_above(jittering, truth, 10.0)
    assert found.linear_m2_s4 == pytest.approx(later.linear_m_s2**2, rel=1e-9)
    assert found.angular_rad2_s4 == pytest.approx(later.angular_rad_s2**2, rel=1e-9)


def test_the_cut_off_is_lowered_for_slow_estimates_only():
    truth = MOTIONS["handheld"].sampled(40.0, 5.0)
    assert evaluate(truth, truth).energy_above_hz == 5.0
    assert evaluate(truth[::4], truth).energy_above_hz == pytest.approx(2.5)
    assert evaluate(truth[:1], truth).energy_above_hz == 5.0
    assert evaluate(truth[:400:40][:2], truth).energy_above_hz == pytest.approx(0.25)
    assert evaluate(truth, truth, energy_above_hz=0.5).energy_above_hz == 0.5
    for bad in (0.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="energy_above_hz: expected a number above 0"):
            evaluate(truth, truth, energy_above_hz=bad)


def test_five_poses_have_a_jerk():
    """Speeds 0, 1, 0, 0 m/s over seconds: a = 1, -1, 0; a' = -2, 1 over the two inner steps."""
    five = along(1e3 * np.arange(5), [0.0, 0.0, 1.0, 1.0, 1.0])
    found = log_dimensionless_jerk(five)
    # T⁴ over the squared peak times the mean of the squares; T = 4 s.
    expected = -np.log(4.0**4 / 1.0**2 * (4.0 + 1.0) / 2.0)
    assert found.linear == pytest.approx(expected, rel=1e-9)
    assert found.angular == pytest.approx(expected, rel=1e-9)


def test_jerk_at_uneven_stamps_is_weighed_by_their_steps():
    """Cubic motion of constant jerk j: -ln(T⁴ j² / v²) whatever the stamps."""
    seconds = np.array([0.0, 0.1, 0.4, 0.5, 1.1, 1.2, 2.0])
    found = log_dimensionless_jerk(along(1e3 * seconds, 0.02 * seconds**3))
    speed = np.max(np.diff(0.02 * seconds**3) / np.diff(seconds))
    assert found.linear == pytest.approx(-np.log(2.0**4 * 0.12**2 / speed**2), rel=1e-9)
    # Jerk in one inner step alone counts by that step's share of them all.
    kinked = np.where(seconds < 0.45, 0.0, seconds - 0.45)
    linear = np.diff(kinked) / np.diff(seconds)
    middle = 0.5 * (seconds[2:] - seconds[:-2])
    acceleration = np.diff(linear) / middle
    jerk = np.diff(acceleration) / ((seconds[3:] - seconds[:-3]) / 3.0)
    inner = np.diff(seconds)[1:-1]
    mean = np.sum(jerk**2 * inner) / np.sum(inner)
    expected = -np.log(2.0**4 * mean / np.max(linear) ** 2)
    assert log_dimensionless_jerk(along(1e3 * seconds, kinked)).linear == pytest.approx(expected)


@pytest.mark.parametrize(("size", "told"), [(1e-17, False), (2e-13, True), (1e-9, True)])
def test_no_score_is_made_of_rounding(size, told):
    """A tremor of so many metres on a path a metre from the origin."""
    stamps = np.arange(50) * 10
    tremor = size * np.sin(np.arange(50.0))
    moved = Trajectory(
        stamps * MS,
        Motor.from_rotor_translation(
            Rotor.identity((50,)), np.ones(50)[:, None] + tremor[:, None] * [1.0, 0.0, 0.0]
        ),
    )
    assert (log_dimensionless_jerk(moved).linear is not None) is told
    turned = Trajectory(
        stamps * MS,
        Motor.from_rotor_translation(
            Rotor.from_rotation_vector(tremor[:, None] * [1.0, 0.0, 0.0]), np.zeros((50, 3))
        ),
    )
    assert (log_dimensionless_jerk(turned).angular is not None) is told


def test_even_motion_has_no_jerk_but_rounding_and_so_no_score():
    seconds = np.arange(0.0, 3.0, 0.01)
    assert log_dimensionless_jerk(along(1e3 * seconds, 5.0 + 0.7 * seconds)).linear is None
