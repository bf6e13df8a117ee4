"""Wrong starts, outliers, bursts and relocated maps: the path they leave is that without them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from motorcade.fusion.filter import Fused, PoseFilter, fuse
from motorcade.fusion.metrics import absolute_translation_m
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.data import data_folder
from tests.bench.fusion.disturbed import DISTURBANCES, disturbed_figures
from tests.bench.fusion.recorded import SETTINGS, flight
from tests.bench.fusion.wrong_spans import MOST_RATIO, Drawn, WrongSpan, drawn, span_errors
from tests.fusion.conftest import Run


def shifted(run: Run, poses: Motor) -> Run:
    path = run.measurements.trajectory
    moved = Trajectory(path.time_ns, poses, path.parent, path.child)
    return replace(run, measurements=PoseMeasurements(moved, run.measurements.covariance))


def disturbed(run: Run, how: str, seed: int) -> tuple[Run, np.ndarray]:
    path = run.measurements.trajectory
    seconds = path.time_s - path.time_s[0]
    poses, wrong = DISTURBANCES[how](path.motors, seconds, np.random.default_rng(seed))
    return shifted(run, poses), wrong


def without(run: Run, wrong: np.ndarray, *, smoothed: bool = True) -> Fused:
    """The path by the right poses alone, at the stamps of all from the first right one on."""
    given, first = run.measurements, np.flatnonzero(~wrong)[0]
    right = PoseMeasurements(given.trajectory[~wrong], given.covariance[~wrong])
    stamps = given.trajectory.time_ns[first:]
    return fuse(right, run.imu, run.noise, run.imu_T_camera, stamps, smoothed=smoothed)


def apart_m(one: Fused, other: Fused) -> FloatArray:
    """Distances where both paths are."""
    shared = np.isin(one.trajectory.time_ns, other.trajectory.time_ns)
    return absolute_translation_m(one.trajectory.motors[shared], other.trajectory.motors)


@pytest.mark.parametrize("how", [name for name in DISTURBANCES if name != "undisturbed"])
def test_what_is_wrong_leaves_no_trace(record: Callable[..., Run], rng, how: str):
    """The smoothed path is that of the right poses, and the wrong ones are known as such."""
    run, wrong = disturbed(record(rng, 8.0), how, 5)
    found = run.fuse()
    assert np.mean(found.accepted == wrong) <= 0.01
    assert np.max(apart_m(found, without(run, wrong))) < 0.02
    error = absolute_translation_m(found.trajectory.motors, run.camera.at(found.trajectory.time_ns))
    assert np.max(error) < 0.1


@pytest.mark.parametrize(
    ("first", "count", "shift_m", "turn_deg"),
    [
        (0, 9, 1.0, 0.0),
        (0, 16, 2.0, 6.0),
        (0, 25, 6.5, 40.0),
        (0, 45, 0.3, 30.0),
        (70, 30, 2.0, 60.0),
        (0, 25, 0.13, 4.6),
        (4, 32, 7.8, 3.2),
        (82, 30, 0.13, 4.3),
        (130, 50, 0.13, 1.1),
        (51, 51, 0.32, 1.2),
        (58, 52, 0.27, 2.5),
        (64, 49, 0.24, 1.7),
        (123, 10, 0.11, 1.8),
        (65, 10, 0.12, 2.6),
        (3, 57, 0.49, 1.7),
        (100, 50, 0.1, 0.1),
        (21, 40, 0.11, 1.1),
    ],
)
def test_a_span_wrong_together_leaves_no_trace_outside_it(
    record: Callable[..., Run], rng, first: int, count: int, shift_m: float, turn_deg: float
):
    """Smoothed, the error outside is that of the right poses alone, wherever the span stands."""
    run = record(rng, 10.0)
    axes = rng.standard_normal((2, 3)) / np.sqrt(3.0)
    turn = tuple((np.deg2rad(turn_deg) * axes[1]).tolist())
    span = WrongSpan(first, count, tuple((shift_m * axes[0]).tolist()), turn)
    wrong = span.among(len(run.measurements))
    found = replace(run, measurements=span.moved(run.measurements)).fuse()
    right = without(run, wrong)
    errors = []
    for fused in (found, right):
        stamps = run.measurements.trajectory.time_ns[~wrong]
        kept = fused.trajectory[np.isin(fused.trajectory.time_ns, stamps)]
        error_m = absolute_translation_m(kept.motors, run.camera.at(kept.time_ns))
        errors.append(np.sqrt(np.mean(np.square(error_m))))
    assert errors[0] <= MOST_RATIO * errors[1]


@pytest.mark.parametrize("how", [name for name in DISTURBANCES if name.startswith("start")])
def test_live_a_wrong_start_is_found_within_a_second(record: Callable[..., Run], rng, how: str):
    clean = record(rng, 4.0)
    run, _ = disturbed(clean, how, 5)
    found = run.fuse(smoothed=False)
    error, undisturbed = (
        absolute_translation_m(one.trajectory.motors, run.camera.at(one.trajectory.time_ns))
        for one in (found, clean.fuse(smoothed=False))
    )
    later = found.trajectory.time_s - found.trajectory.time_s[0] > 1.0
    assert np.max(error[later]) < 3.0 * np.max(undisturbed[later])


def test_live_a_burst_that_moves_as_one_is_not_followed(record: Callable[..., Run], rng):
    """Second 4 to 5 lies elsewhere: the IMU carries the path, and all is well when that ends."""
    run = record(rng, 8.0)
    path = run.measurements.trajectory
    seconds = path.time_s - path.time_s[0]
    wrong = (seconds >= 4.0) & (seconds < 5.0)
    shift = wrong[:, None] * np.array([0.0, 0.0, 0.4, 1.0, -2.0, 0.5])
    found = shifted(run, Motor.from_twist(shift) @ path.motors).fuse(smoothed=False)
    error = absolute_translation_m(found.trajectory.motors, run.camera.at(path.time_ns))
    assert np.max(error[seconds > 1.0]) < 0.1
    np.testing.assert_array_equal(found.accepted[wrong], False)
    assert found.accepted[seconds > 5.2].all()
    assert not len(found.given_up_ns)


def test_live_a_burst_of_three_seconds_costs_what_a_gap_does(record: Callable[..., Run], rng):
    """It lies metres off: the IMU tells the old map from that for longer than poses are missed."""
    run = record(rng, 14.0)
    path = run.measurements.trajectory
    seconds = path.time_s - path.time_s[0]
    wrong = (seconds >= 8.0) & (seconds < 11.0)
    shift = wrong[:, None] * np.array([0.2, 0.0, 0.9, 3.0, -4.0, 2.0])
    found = shifted(run, Motor.from_twist(shift) @ path.motors).fuse(smoothed=False)
    known = without(run, wrong, smoothed=False)
    errors = [
        absolute_translation_m(one.trajectory.motors, run.camera.at(one.trajectory.time_ns))
        for one in (found, known)
    ]
    right = np.isin(path.time_ns, known.trajectory.time_ns)
    assert np.sqrt(np.mean(errors[0][right] ** 2)) < 1.5 * np.sqrt(np.mean(errors[1] ** 2))
    np.testing.assert_array_equal(found.accepted[wrong], False)
    assert found.accepted[seconds > 11.2].all()


def test_it_tells_for_which_spans_it_did_not_know(record: Callable[..., Run], rng):
    run, _ = disturbed(record(rng, 3.0), "start off by 1 m, 30°", 5)
    path, covariance = run.measurements.trajectory, run.measurements.covariance
    stream = PoseFilter(run.noise, run.imu_T_camera, history_s=10.0)
    since = []
    for k, time_ns in enumerate(run.imu.time_ns.tolist()):
        stream.imu(time_ns, run.imu.angular_rate_rad_s[k], run.imu.specific_force_m_s2[k])
        for row in np.flatnonzero(path.time_ns == time_ns):
            stream.camera_pose(time_ns, path.motors[row], covariance[row])
            since.append(stream.state.contradicted_since_ns)
    first, second, *_ = path.time_ns.tolist()
    assert since[0] is None
    assert since[1] == since[4] == second
    assert since[-1] is None
    ((begin, end),) = stream.given_up
    assert begin == first
    assert second < end < first + 1_000_000_000
    np.testing.assert_array_equal(run.fuse().given_up_ns, [[begin, end]])


def test_where_nothing_is_wrong_nothing_is_given_up(record: Callable[..., Run], rng):
    found = record(rng, 4.0).fuse()
    assert found.given_up_ns.shape == (0, 2)
    assert np.all(found.accepted)


def test_noise_stated_too_small_makes_no_outliers(record: Callable[..., Run], rng):
    """Poses four times as noisy as they say are all believed, as those that say so are."""
    run = record(rng, 8.0)
    given = run.measurements
    modest = replace(run, measurements=PoseMeasurements(given.trajectory, given.covariance / 16.0))
    found = modest.fuse()
    assert np.mean(found.accepted) > 0.98
    error = absolute_translation_m(found.trajectory.motors, run.camera.at(found.trajectory.time_ns))
    assert np.max(error) < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("how", [name for name in DISTURBANCES if "moved" not in name])
@pytest.mark.parametrize("name", ["V1_03", "V2_02", "V1_01"])
def test_recorded_flights_are_smoothed_as_without_what_is_wrong(name: str, how: str):
    """On flights on which no constant was chosen: the error is that of the right poses alone."""
    one = flight(name, data_folder())
    if one is None:
        pytest.skip(f"{name}: not below {data_folder()}; set MOTORCADE_DATA")
    found = disturbed_figures(one, how, range(3))
    assert found["robust_m"] < 1.05 * found["known_m"]
    assert found["robust_m_max"] < 1.05 * found["known_m_max"] + 1e-3
    assert found["misjudged_share"] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed", "of", "count"),
    [
        ("V2_02", 12, Drawn(), 36),
        ("V1_03", 21, Drawn((30, 60), (0.03, 0.5), (0.1, 5.0)), 48),
        ("V1_03", 41, Drawn((30, 60), (0.03, 0.5), (0.1, 5.0)), 48),
        ("V1_03", 2311, Drawn(), 50),
        ("V1_02", 30000, Drawn(), 47),
        ("V1_01", 40001, Drawn(), 42),
    ],
)
def test_most_poses_of_a_flight_are_not_denied_for_a_wrong_span(
    name: str, seed: int, of: Drawn, count: int
):
    """Few poses in a row are wrong together; the IMU once led 300 m away from all others."""
    spans = [one for one in drawn((name,), 30, seed, 30.0, of) if one[1].count == count]
    if not spans:
        pytest.skip(f"{name}: not below {data_folder()}; set MOTORCADE_DATA")
    for _, span, recorded, poses in spans:
        assert span_errors(recorded, poses, span, SETTINGS).worst_m < 0.1
