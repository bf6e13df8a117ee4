"""`make bench SUITE=fusion`: bounds that its figures must keep, and that it sees them broken."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuStream, simulate_imu
from motorcade.fusion.motions import MOTIONS
from tests.bench.fusion.flights import flight_figures, flights_table
from tests.bench.fusion.offsets import found_offset, offsets_table, spread
from tests.bench.fusion.orientation import orientation_table
from tests.bench.fusion.recorded import BLACKOUTS, Flight, flight, measured
from tests.bench.fusion.simulator import (
    against_differences,
    against_gtsam,
    halved_steps,
)
from tests.bench.fusion.speed import (
    recorded_hour,
    speed_table,
    symmetry_and_least_eigenvalue,
)


def present(name: str, data_dir) -> Flight:
    found = flight(name, data_dir)
    if found is None:
        pytest.skip(f"{name} is not among the recordings")
    return found


def check_bounds(figures: dict[str, Any]) -> None:
    """What must hold over every seed together."""
    assert figures["outside_rmse_m"] <= 5e-3
    assert figures["outside_rmse_deg"] <= 0.17
    assert figures["online_end_median_m"] <= 0.15
    assert figures["online_end_max_m"] <= 0.30
    assert figures["gap_worst_p90_m"] <= 0.05
    assert figures["windows_diverged"] == 0
    assert figures["nis_per_dimension"] == pytest.approx(1.0, abs=0.1)


def test_a_flight_keeps_its_bounds(data_dir):
    """Three seeds of V1_02; all twenty below."""
    figures = flight_figures(present("V1_02", data_dir), range(3))
    check_bounds(figures)
    assert (figures["gaps"], figures["windows"]) == (15, 18)
    assert figures["gyro_bias_rad_s_worst"] <= 0.002
    assert figures["accel_bias_m_s2_worst"] <= 0.05


@pytest.mark.slow
@pytest.mark.parametrize("name", ["V1_02", "V1_01"])
def test_flights_keep_their_bounds_over_twenty_seeds(name, data_dir):
    figures = flight_figures(present(name, data_dir), range(20))
    check_bounds(figures)
    if name == "V1_02":
        assert figures["gyro_bias_rad_s_worst"] <= 0.002
        assert figures["accel_bias_m_s2_worst"] <= 0.05
    rows = {"rows": [{"flight": name, "by": "filter", **figures}], "left_out": []}
    assert "0 of" in flights_table(rows)


def synthetic(duration_s: float = 40.0) -> Flight:
    path = ContinuousPath.along(MOTIONS["gimbal_crossing"], duration_s)
    made = simulate_imu(path, 100.0, ADIS16448.scaled(10.0), np.random.default_rng(1))
    return Flight("simulated", made.stream, made.path)


def test_a_sensor_that_lies_is_seen_as_divergence():
    """A gyroscope that reads a fifth too much: in the dark the path leaves the ground truth."""
    one = synthetic()
    honest = flight_figures(one, range(1))
    assert (honest["gaps"], honest["windows"], honest["windows_diverged"]) == (2, 3, 0)
    rates = 1.2 * one.imu.angular_rate_rad_s
    lying = replace(one, imu=ImuStream(one.imu.time_ns, rates, one.imu.specific_force_m_s2))
    wrong = flight_figures(lying, range(1))
    assert wrong["windows_diverged"] > 0
    assert wrong["online_end_max_m"] > 5.0 * honest["online_end_max_m"]


def test_poses_are_missing_in_blackouts_and_late_where_asked():
    one = synthetic()
    path, late = (measured(one, 3, delay).trajectory for delay in (0.0, 0.02))
    np.testing.assert_array_equal(late.time_ns - path.time_ns, 20_000_000)
    assert not np.any(BLACKOUTS.dark(path.time_s - path.time_s[0], one.truth.duration_s))
    assert np.max(np.diff(path.time_s)) == pytest.approx(2.05)


@pytest.mark.slow
@pytest.mark.parametrize("delay_s", [0.005, 0.02, 0.05])
def test_offsets_are_found_to_a_millisecond(delay_s, data_dir):
    one = present("V1_02", data_dir)
    row = found_offset(one, 0, delay_s, BLACKOUTS)
    assert row["sigma_s"] < 1e-3
    assert row["found_s"] == pytest.approx(delay_s, abs=3.0 * row["sigma_s"])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["V1_02", "V2_02", "MH_05"])
def test_offsets_agree_with_what_ground_truth_and_gyroscope_have(name, data_dir):
    """Ground truth's positions are late by milliseconds on MH_05: they must have no say."""
    error, sigma = np.array(list(spread(present(name, data_dir), 3))).T
    assert np.all(np.abs(error) < 3.0 * sigma)
    assert abs(np.mean(error)) < 3.0 * np.mean(sigma) / np.sqrt(len(error))


def test_offsets_that_are_refused_are_told():
    rows = [
        {"poses": "blackouts", "delay_s": 0.005, "found_s": 0.0051, "sigma_s": 4e-4},
        {"poses": "blackouts", "delay_s": 0.005, "found_s": None, "sigma_s": None},
    ]
    text = offsets_table({"rows": rows, "left_out": []})
    assert "5.10 ± 0.40" in text
    assert "refused" in text


def test_the_table_of_orientation_shows_every_trial():
    errors = {"inclination_deg": 0.5, "heading_deg": 1.25, "total_deg": 1.5}
    ours = {"errors": {"02": errors, "07": errors}, "samples_per_s": 2.5e6}
    rows = [{"axes": "9 axes", "way": "online", "ours": ours, "vqf": ours}]
    text = orientation_table({"rows": rows, "left_out": ["a trial: no"]})
    assert text.count("1.25") == 6  # two trials and the mean, ours and VQF's
    assert "left out: a trial: no" in text


def test_the_simulator_and_preintegration_keep_their_bounds():
    pytest.importorskip("gtsam")
    path = ContinuousPath.through(MOTIONS["handheld"].sampled(50.0, 4.0), 0.1)
    assert max(against_differences(path)) < 1e-6
    assert min(halved_steps(path)) >= 3.5
    assert against_gtsam(path) < 1e-6


def test_asymmetry_and_indefiniteness_show():
    good = np.array([[4.0, 1.0], [1.0, 9.0]])
    skewed = np.array([[4.0, 1.0], [1.6, 9.0]])
    indefinite = np.array([[4.0, 7.0], [7.0, 9.0]])
    assert symmetry_and_least_eigenvalue(good[None]) == (0.0, pytest.approx(5.0 / 6.0))
    assert symmetry_and_least_eigenvalue(np.stack([good, skewed]))[0] == pytest.approx(0.1)
    assert symmetry_and_least_eigenvalue(np.stack([good, indefinite]))[1] < 0.0


@pytest.mark.slow
def test_covariances_stay_sound_over_an_hour():
    skew, least = symmetry_and_least_eigenvalue(recorded_hour())
    assert skew < 1e-12
    assert least > 1e-6


def test_the_table_of_speeds_names_its_rivals():
    text = speed_table(
        {
            "samples": 1000,
            "batch_samples_per_s": {"1 Hz": 1.5e6},
            "streaming_us": 1.25,
            "streaming_with_poses_us": 3.5,
            "gtsam_preintegration_us": None,
            "covariance_asymmetry": 0.0,
            "covariance_least_eigenvalue": 7e-3,
        }
    )
    assert "1,500,000 samples/s" in text
    assert "1.25 µs" in text
    assert "gtsam" not in text
