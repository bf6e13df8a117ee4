"""How far lag is sought, from how much motion, and how sure a peak must be."""

from __future__ import annotations

import re

import numpy as np
import pytest

from motorcade.fusion.metrics import NotObservableError, angular_rate_lag_s, position_lag_s
from motorcade.ga import Motor, Rotor, Trajectory

LAGS = pytest.mark.parametrize("lag_s", [position_lag_s, angular_rate_lag_s])


def late_by(handheld, lag_ms: float, rate_hz: float = 50.0, first_s: float = 2.0, count: int = 800):
    stamps = handheld.time_ns(rate_hz, (count - 1) / rate_hz) + round(first_s * 1e9)
    return Trajectory(stamps, handheld.poses(stamps - round(lag_ms * 1e6)))


@LAGS
@pytest.mark.parametrize(("lag_ms", "found"), [(480, True), (-480, True), (520, False)])
def test_half_a_second_is_sought_unless_said_otherwise(handheld, lag_s, lag_ms, found):
    truth = handheld.trajectory(100.0, 24.0)
    late = late_by(handheld, lag_ms)
    if found:
        assert 1e3 * lag_s(late, truth) == pytest.approx(lag_ms, abs=0.05)
        with pytest.raises(NotObservableError, match=r"within ±0.300 s, got one at the edge"):
            lag_s(late, truth, 0.3)
        return
    with pytest.raises(NotObservableError, match=r"within ±0.500 s, got one at the edge"):
        lag_s(late, truth)
    assert 1e3 * lag_s(late, truth, 0.6) == pytest.approx(lag_ms, abs=0.05)


@LAGS
@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, 1e9])
def test_a_limit_is_above_zero(handheld, lag_s, bad):
    truth = handheld.trajectory(100.0, 4.0)
    with pytest.raises(ValueError, match="max_lag_s: expected above 0 and up to 60, got"):
        lag_s(truth, truth, bad)


@LAGS
def test_a_quarter_of_the_overlap_is_sought_at_most(handheld, lag_s):
    """Of one second and a fifth, 0.3 s; a peak beyond is at the edge."""
    truth = handheld.trajectory(100.0, 24.0)
    short = late_by(handheld, 330.0, 50.0, 5.0, 61)
    with pytest.raises(NotObservableError, match=r"within ±0.300 s, got one at the edge"):
        lag_s(short, truth)


@LAGS
def test_of_trajectories_that_hardly_overlap_the_overlap_is_told(handheld, lag_s):
    truth = handheld.trajectory(100.0, 4.0)
    for first_s, said in ((3.97, "0.030 s"), (9.0, "0.000 s")):
        late = late_by(handheld, 0.0, 100.0, first_s, 50)
        with pytest.raises(NotObservableError, match=rf"overlap by 0.04 s with 4 stamps.*{said}"):
            lag_s(late, truth)
    before = Trajectory(truth.time_ns - 3_980_000_000, truth.motors)
    with pytest.raises(NotObservableError, match=r"overlap by 0.04 s with 4 stamps.*0.020 s"):
        lag_s(before, truth)


def test_four_stamps_tell_a_lag_and_three_do_not(handheld):
    truth = handheld.trajectory(100.0, 24.0)
    whole = late_by(handheld, 20.0, 2.0, 2.0, 40)
    four, three = whole[[0, 10, 20, 30]], whole[[0, 10, 20]]
    assert 1e3 * position_lag_s(four, truth) == pytest.approx(20.0, abs=0.5)
    with pytest.raises(NotObservableError, match=r"with 4 stamps or more, got 10.000 s with 3"):
        position_lag_s(three, truth)


@pytest.mark.parametrize(("step_ms", "told"), [(250, True), (251, False)])
def test_rates_over_more_than_a_quarter_of_a_second_do_not_count(handheld, step_ms, told):
    truth = handheld.trajectory(100.0, 24.0)
    slow = late_by(handheld, 12.0, 1e3 / step_ms, 2.0, 70)
    if told:
        assert 1e3 * angular_rate_lag_s(slow, truth) == pytest.approx(12.0, abs=0.05)
        return
    with pytest.raises(NotObservableError, match=r"4 steps of at most 0.25 s between poses, got 0"):
        angular_rate_lag_s(slow, truth)


def test_four_rates_tell_a_lag_and_three_do_not(handheld):
    """Steps of 20 ms here and there: rates are of steps, and these are few."""
    truth = handheld.trajectory(100.0, 24.0)
    whole = late_by(handheld, 12.0)
    rows = np.array([[k, k + 1] for k in (0, 180, 360, 540, 720)]).ravel()
    four = np.append(rows[:8], 700)
    assert 1e3 * angular_rate_lag_s(whole[four], truth) == pytest.approx(12.0, abs=0.5)
    with pytest.raises(NotObservableError, match=r"4 steps of at most 0.25 s.*, got 3"):
        angular_rate_lag_s(whole[np.append(rows[:6], [540, 700])], truth)


@pytest.mark.parametrize(("gap_ms", "counts"), [(59, True), (61, False)])
def test_rates_over_more_than_three_intervals_do_not_count(handheld, gap_ms, counts):
    """After a gap the estimate is turned aside; across the gap alone this looks like a rate."""
    truth = handheld.trajectory(100.0, 24.0)
    aside = np.arange(800) >= 400
    stamps = late_by(handheld, 0.0).time_ns + aside * (gap_ms - 20) * 1_000_000
    turned = Rotor.from_rotation_vector(aside[:, None] * [0.0, 0.0, 0.2])
    rotors = turned @ handheld.poses(stamps - 30_000_000).rotor
    path = Trajectory(stamps, Motor.from_rotor_translation(rotors, np.zeros((800, 3))))
    found = 1e3 * angular_rate_lag_s(path, truth)
    assert (abs(found - 30.0) > 0.01) is counts


@LAGS
def test_a_truth_with_a_gap_tells_by_its_rest(handheld, lag_s):
    truth = handheld.trajectory(100.0, 24.0)
    seconds = truth.time_s
    gapped = truth[(seconds < 9.0) | (seconds > 10.0)]
    assert 1e3 * lag_s(late_by(handheld, 7.0), gapped) == pytest.approx(7.0, abs=0.5)


def test_what_stands_still_or_turns_evenly_has_no_lag(handheld):
    truth = handheld.trajectory(100.0, 8.0)
    still = Trajectory(truth.time_ns, Motor.identity((len(truth),)))
    for pair in ((still, truth), (truth, still)):
        for lag_s in (position_lag_s, angular_rate_lag_s):
            with pytest.raises(NotObservableError, match="one that stands still or turns evenly"):
                lag_s(*pair)


def opposite(trajectory: Trajectory) -> Trajectory:
    return Trajectory(
        trajectory.time_ns,
        Motor.from_rotor_translation(trajectory.motors.rotor, -trajectory.motors.translation_m),
    )


@pytest.mark.parametrize(
    ("tremor", "said"), [(0.0, "got one at the edge"), (0.05, "got a standard error of inf ms")]
)
def test_motion_the_other_way_fits_at_no_lag(handheld, tremor, said):
    """Straight on at one speed: where a tremor makes a peak, the correlation is negative."""
    stamps = handheld.time_ns(100.0, 8.0)
    seconds = (stamps - stamps[0]) * 1e-9
    along = seconds + 0.01 * seconds**2 + tremor * np.sin(2.0 * np.pi * seconds / 0.4)
    motors = Motor.from_translation(along[:, None] * [1.0, 0.0, 0.0])
    path = Trajectory(stamps, motors)
    with pytest.raises(NotObservableError, match=f"lag: expected a peak of the .*, {said}"):
        position_lag_s(opposite(path), path)


@pytest.mark.parametrize(("size", "away"), [(0.2, 1.0), (1.0, 1e5), (30.0, 1.0)])
def test_lag_does_not_depend_on_the_units_nor_on_where_the_origin_is(handheld, size, away):
    truth, late = handheld.trajectory(100.0, 24.0), late_by(handheld, 8.0)
    scaled = Trajectory(
        late.time_ns,
        Motor.from_rotor_translation(
            late.motors.rotor,
            size * late.motors.translation_m + away * np.array([100.0, -50.0, 3.0]),
        ),
    )
    assert 1e3 * position_lag_s(scaled, truth) == pytest.approx(8.0, abs=0.01)


def stated_ms(clean: Trajectory, noise_m: np.ndarray, truth: Trajectory) -> float:
    """The standard error that a refusal states, at stamps 5 ms apart."""
    moved = Motor.from_rotor_translation(clean.motors.rotor, clean.motors.translation_m + noise_m)
    with pytest.raises(NotObservableError) as refused:
        position_lag_s(Trajectory(clean.time_ns, moved), truth, 0.05)
    said = re.search(r"known to 2.5 ms, got a standard error of ([0-9.]+) ms", str(refused.value))
    assert said is not None, refused.value
    return float(said[1])


def test_the_standard_error_is_what_white_noise_leaves(handheld, rng):
    """σ over the root of the summed squares of the velocity, less what a scale could explain."""
    truth = handheld.trajectory(100.0, 12.0)
    clean = late_by(handheld, 0.0, 200.0, 1.0, 2001)
    inner = clean.time_ns
    velocity = handheld.velocities(inner)
    velocity -= velocity.mean(axis=0)
    position = clean.motors.translation_m - clean.motors.translation_m.mean(axis=0)
    velocity -= position * (np.sum(position * velocity) / np.sum(position**2))
    sigma_m = 6e-3 * np.sqrt(np.sum(velocity**2))
    stated = [
        stated_ms(clean, sigma_m * rng.standard_normal((len(clean), 3)), truth) for _ in range(8)
    ]
    # 20 batch means know a deviation to 16 %, eight runs of them to 6 %.
    assert np.sqrt(np.mean(np.square(stated))) == pytest.approx(6.0, rel=0.18)


def test_slow_errors_make_a_peak_less_sure_than_as_many_white_ones(handheld, rng):
    truth = handheld.trajectory(100.0, 12.0)
    clean = late_by(handheld, 0.0, 200.0, 1.0, 2001)
    knots = 0.3 * rng.standard_normal((101, 3))
    slow = np.stack([np.interp(np.arange(2001) / 20, np.arange(101), one) for one in knots.T], -1)
    quick = np.std(slow) * rng.standard_normal(slow.shape)
    assert stated_ms(clean, slow, truth) > 2.5 * stated_ms(clean, quick, truth)


def test_a_peak_known_to_half_an_interval_is_taken(handheld, jittered, rng):
    """The same errors, seldom: intervals of 100 ms allow 50 ms."""
    truth = handheld.trajectory(100.0, 24.0)
    seldom = jittered(late_by(handheld, 0.0, 10.0, 2.0, 200), 0.1, 1e-6, rng)
    often = jittered(late_by(handheld, 0.0, 100.0, 2.0, 2000), 1.0, 1e-6, rng)
    assert abs(position_lag_s(seldom, truth)) < 0.05
    with pytest.raises(NotObservableError, match="known to 5 ms, got a standard error of"):
        position_lag_s(often, truth)
