"""Consistency: filters pass, Euler angles fail at gimbal lock, and runs are the same anywhere."""

from __future__ import annotations

import json

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.replays.cli import main
from motorcade.replays.comparison.consistency import (
    FILTERS,
    ConsistencyPlan,
    Experiment,
    as_json,
    judge,
    run_plan,
    simulate,
)

PARTS = ("nees_pose", "nees_velocity", "nees_biases", "nis")


def test_a_seed_gives_the_same_run_whatever_the_others_are():
    experiment = Experiment("tumble", 1.0)
    alone, among = (simulate(experiment, seeds) for seeds in (range(5, 6), range(3, 7)))
    (poses, imu), (same_poses, same_imu) = alone.recorded[0], among.recorded[2]
    np.testing.assert_array_equal(imu.angular_rate_rad_s, same_imu.angular_rate_rad_s)
    np.testing.assert_array_equal(
        poses.trajectory.motors.coefficients, same_poses.trajectory.motors.coefficients
    )
    other = simulate(Experiment("handheld", 1.0), range(5, 6)).recorded[0][1]
    assert not np.allclose(imu.angular_rate_rad_s[0], other.angular_rate_rad_s[0])


def test_simulated_truths_are_the_motions_and_biases_the_priors():
    simulated = simulate(Experiment("gimbal_crossing", 0.5), range(100))
    motion = MOTIONS["gimbal_crossing"].at(np.arange(11) * 0.05)
    apart = motion.pose.rotor.inverse() @ simulated.truth.rotor[7]
    assert np.max(np.abs(apart.as_rotation_vector())) < 1e-9
    bias = simulated.truth.bias[:, 0]
    sigma = np.repeat([0.1, 0.5], 3)
    np.testing.assert_allclose(np.std(bias, axis=0), sigma, rtol=0.36)
    measured = simulated.recorded[7][0].trajectory.motors
    np.testing.assert_allclose(measured.translation_m, simulated.truth.position_m[7], atol=0.06)


def test_cameras_that_look_ahead_carry_a_level_imu():
    """Its z axis is up: an accelerometer that moves slowly reads g there, far from gimbal lock."""
    for name in ("handheld", "walk_and_look"):
        _, imu = simulate(Experiment(name, 2.0), range(1)).recorded[0]
        assert imu.specific_force_m_s2[:, 2].mean() > 8.0


def test_motors_and_quaternions_are_consistent_where_euler_angles_are_not(tmp_path):
    """Over 30 short runs through gimbal lock: on the average, to five standard errors of it."""
    plan = ConsistencyPlan(
        ("gimbal_crossing",), ("motor", "quaternion", "euler"), runs=30, duration_s=10.0
    )
    rows = {row["filter"]: row for row in as_json(plan, run_plan(plan, tmp_path))["rows"]}
    for name in ("motor", "quaternion"):
        for part in PARTS:
            assert rows[name][f"{part}_over_expected"] == pytest.approx(1.0, abs=0.15)
            assert rows[name][f"{part}_share_within"] > 0.75
        assert rows[name]["rotation_worst_deg"] < 1.0
    assert rows["euler"]["nees_pose_over_expected"] > 10.0
    assert rows["euler"]["nees_pose_share_within"] < 0.3
    assert rows["euler"]["rotation_worst_deg"] > 3.0


@pytest.mark.slow
def test_the_filter_keeps_its_bounds_on_three_motions(tmp_path):
    """100 runs of 120 s each: within the 95 % bounds at 90 to 99 % of the steps, part by part."""
    plan = ConsistencyPlan(filters=("motor",))
    for row in as_json(plan, run_plan(plan, tmp_path, "processes:2"))["rows"]:
        for part in PARTS:
            assert 0.90 <= row[f"{part}_share_within"] <= 0.99, (row["motion"], part)
        assert row["left_out"] == 0


def test_a_filter_that_believes_itself_too_much_is_found_out():
    """Told of an IMU three times as good as it is, the biases' squares leave their bounds."""
    experiment = Experiment("tumble", 10.0)
    simulated = simulate(experiment, range(10))
    flattered = Experiment("tumble", 10.0, noise=experiment.noise.scaled(1.0 / 3.0))
    honest, wrong = (
        judge(simulated, one, "quaternion").nees["biases"].mean() for one in (experiment, flattered)
    )
    assert honest == pytest.approx(6.0, rel=0.3)
    assert wrong > 2.0 * honest


def test_the_spread_of_errors_is_that_of_the_runs(tmp_path):
    """Of five runs the median is the third; the 10th and 90th percentile lie 0.4 of a step in."""
    plan = ConsistencyPlan(("tumble",), ("motor",), runs=5, seed=3, duration_s=10.0)
    verdict = run_plan(plan, tmp_path)["tumble"]["motor"]
    simulated = simulate(Experiment("tumble", 10.0), range(3, 8))
    judged = judge(simulated, Experiment("tumble", 10.0), "motor")
    runs = np.sort(np.rad2deg(judged.rotation_rad), axis=0)
    low, middle, high = verdict.rotation_spread_deg
    np.testing.assert_allclose(middle, runs[2], rtol=1e-12)
    np.testing.assert_allclose(low, 0.6 * runs[0] + 0.4 * runs[1], rtol=1e-9)
    np.testing.assert_allclose(high, 0.4 * runs[3] + 0.6 * runs[4], rtol=1e-9)


def test_the_command_writes_its_page_and_figures(tmp_path, capsys):
    status = main(
        [
            "consistency",
            "--motions",
            "gimbal_crossing",
            "--filters",
            "quaternion,euler",
            "--runs",
            "1",
            "--duration-s",
            "10",
            "--executor",
            "local",
            "--out",
            str(tmp_path / "out"),
            "--json",
            str(tmp_path / "figures.json"),
        ]
    )
    assert status == 0
    assert "steps within the 95 % bounds of 1 runs" in capsys.readouterr().out
    figures = json.loads((tmp_path / "figures.json").read_text())
    assert [row["filter"] for row in figures["rows"]] == ["quaternion", "euler"]
    assert {row["motion"] for row in figures["rows"]} == {"gimbal_crossing"}
    page = (tmp_path / "out" / "consistency.html").read_text()
    assert page.count("<svg") == 5
    assert "http" not in page.replace("http://www.w3.org", "")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--motions", "zoom"], "motion: expected one of gimbal_crossing"),
        (
            ["--filters", "motor,kalman"],
            "plan.filters: expected some of motor, quaternion",
        ),
        (["--runs", "0"], "expected runs >= 1"),
        (["--duration-s", "1"], "plan.duration_s: expected 10 or more"),
        (["--executor", "processes:0"], "--executor: expected local, processes"),
    ],
)
def test_bad_input_is_refused_in_one_line(options, message, tmp_path, capsys):
    assert main(["consistency", *options, "--out", str(tmp_path)]) == 1
    assert message in capsys.readouterr().err


def test_every_filter_can_judge_its_own_errors():
    simulated = simulate(Experiment("tumble", 1.0), range(2))
    for _, coordinates in FILTERS.values():
        assert np.max(np.abs(coordinates.local(simulated.truth, simulated.truth))) < 1e-12
    assert simulated.truth.rotor.shape == (2, 21)
