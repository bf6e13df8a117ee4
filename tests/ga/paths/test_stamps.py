"""Stamps: how far from zero they may lie, where gaps split a path, how many an even rate makes."""

import numpy as np
import pytest

from motorcade.ga import CumulativeBSpline, Motor, Trajectory
from motorcade.ga.stamps import STAMP_LIMIT_NS, segments, stamps_at_rate

SECOND = 10**9
DAY = 86_400 * SECOND
YEARS = 30 * 365 * DAY


def walk(time_ns: np.ndarray) -> Trajectory:
    """A metre from each pose to the next."""
    places = np.arange(len(time_ns))[:, None] * [1.0, 0.0, 0.0]
    return Trajectory(time_ns, Motor.from_translation(places))


def with_gap(gap_ns: int, start_ns: int = 0) -> np.ndarray:
    """Ten stamps a second apart, a gap, ten more."""
    steps = np.full(19, SECOND)
    steps[9] = gap_ns
    return start_ns + np.concatenate([[0], np.cumsum(steps)])


@pytest.mark.parametrize("far", [-(2**63), -STAMP_LIMIT_NS, STAMP_LIMIT_NS, 2**63 - 1])
def test_stamps_too_far_from_zero_to_be_subtracted_are_refused(far):
    stamps = np.sort(np.array([0, far]))
    with pytest.raises(ValueError, match=rf"expected stamps within 146 years .*, got {far} ns"):
        walk(stamps)
    with pytest.raises(ValueError, match=rf"Trajectory\.at\(time_ns\): .* got {far} ns"):
        walk(np.array([0, 1])).at(np.array([far]))


def test_the_farthest_stamps_have_a_difference():
    whole = walk(np.array([1 - STAMP_LIMIT_NS, STAMP_LIMIT_NS - 1]))
    assert whole.duration_s == pytest.approx(2**63 * 1e-9)
    assert np.allclose(whole.at(np.array([0])).translation_m, [[0.5, 0.0, 0.0]])


@pytest.mark.parametrize(
    ("gap_ns", "parts"),
    [(2 * SECOND, 1), (10 * SECOND, 1), (10 * SECOND + 1, 2), (DAY, 2), (YEARS, 2)],
)
def test_gaps_of_more_than_ten_seconds_split(gap_ns, parts):
    assert len(segments(with_gap(gap_ns))) == parts


def test_poses_that_are_evenly_far_apart_are_one_segment():
    assert segments(np.arange(50) * DAY) == [slice(0, 50)]
    assert segments(np.array([5])) == [slice(0, 1)]


@pytest.mark.parametrize("gap_ns", [11 * SECOND, DAY, YEARS])
def test_each_segment_is_resampled_for_itself(gap_ns):
    path = walk(with_gap(gap_ns))
    made = path.at_rate(4.0)
    alone = [path[:10].at_rate(4.0), path[10:].at_rate(4.0)]
    assert len(made) == 2 * 37
    assert np.array_equal(made.time_ns, np.concatenate([one.time_ns for one in alone]))
    coefficients = np.concatenate([one.poses.coefficients for one in alone])
    assert np.array_equal(made.poses.coefficients, coefficients)


def test_a_gap_of_ten_seconds_is_bridged():
    made = walk(with_gap(10 * SECOND)).at_rate(1.0)
    assert len(made) == 29
    assert np.allclose(made.poses.translation_m[14, 0], 9.5)


@pytest.mark.parametrize("rate_hz", [1e9, 1e300, np.nan, 0.0, -1.0])
def test_rates_are_refused_before_anything_is_made(rate_hz):
    with pytest.raises(ValueError, match="rate_hz"):
        walk(np.arange(20) * SECOND).at_rate(rate_hz)


def test_a_refused_rate_says_how_many_there_may_be():
    with pytest.raises(
        ValueError, match=r"expected at most 60000 samples from 20 poses .* got 1\.9e\+06; choose"
    ):
        stamps_at_rate(np.arange(20) * SECOND, 1e5, "rate_hz")


@pytest.mark.parametrize(("step_ns", "spacing_s"), [(DAY, 0.1), (SECOND, 1e-6), (SECOND, 1e-300)])
def test_more_knots_than_poses_can_tell_are_refused(step_ns, spacing_s):
    with pytest.raises(ValueError, match=r"knot_spacing_s: expected at most 2400 knots for 20 pos"):
        CumulativeBSpline.fit(walk(np.arange(20) * step_ns), spacing_s)
