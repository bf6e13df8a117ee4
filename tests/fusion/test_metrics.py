"""Metrics keep their definitions: evo's errors, jitter against closed forms, lag to a fraction."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.fusion.metrics import (
    NotObservableError,
    accelerations,
    align,
    angular_rate_lag_s,
    associate,
    evaluate,
    jitter,
    jitter_above,
    position_lag_s,
    rotation_rad,
    tilt_rad,
)
from motorcade.fusion.metrics.poses.pose_error import Statistics
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.trajectories import read_trajectory

EVO_OPTIONS = {"none": [], "se3": ["-a"], "sim3": ["-as"]}
FREIBURG, DESK = "freiburg1_xyz-groundtruth.txt", "fr2_desk_groundtruth.txt"
REAL_ESTIMATES = "freiburg1_xyz-rgbdslam.txt", "freiburg1_xyz-ORB_kf_mono.txt", "fr2_desk_ORB.txt"


def evo(program, reference, estimate, home: Path, *options: str) -> dict[str, float]:
    """Statistics that evo's own program writes for two TUM files."""
    pytest.importorskip("evo")
    result = home / f"{program}{len(list(home.glob('*.zip')))}.zip"
    command = [Path(sys.executable).with_name(program), "tum", reference, estimate, *options]
    subprocess.run(
        [*map(str, command), "--save_results", str(result)],
        env={**os.environ, "HOME": str(home), "MPLBACKEND": "Agg"},
        check=True,
        capture_output=True,
    )
    with zipfile.ZipFile(result) as archive:
        return json.loads(archive.read("stats.json"))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("reference", "estimate", "how"),
    [
        (FREIBURG, "freiburg1_xyz-rgbdslam.txt", "se3"),
        (FREIBURG, "freiburg1_xyz-ORB_kf_mono.txt", "sim3"),
        (DESK, "fr2_desk_ORB.txt", "sim3"),
        (DESK, "fr2_desk_ORB_kf_mono.txt", "none"),
    ],
)
def test_every_error_equals_evos(data_dir, tmp_path, reference, estimate, how):
    files = [data_dir / "trajectories" / name for name in (reference, estimate)]
    ours = evaluate(read_trajectory(files[1]), read_trajectory(files[0]), how).as_dict()
    for program, relation, name, unit in [
        ("evo_ape", "trans_part", "ape", "m"),
        ("evo_ape", "angle_deg", "rotation", "deg"),
        ("evo_rpe", "trans_part", "rpe_trans", "m"),
        ("evo_rpe", "angle_deg", "rpe_rot", "deg"),
    ]:
        theirs = evo(program, *files, tmp_path, "-r", relation, *EVO_OPTIONS[how])
        for statistic in Statistics.names():
            assert ours[f"{name}_{statistic}_{unit}"] == pytest.approx(theirs[statistic], abs=1e-9)


def test_pairs_are_those_of_evo_also_on_ties_and_beyond_the_ends(rng):
    from evo.core.sync import matching_time_indices

    for long_step, short_step in [(10_000_000, 25_000_000), (5_000_000, 7_100_000)]:
        long = 1_311_868_163_869_700_000 + long_step * np.arange(400)
        short = 1_311_868_163_819_700_000 + short_step * np.arange(190)
        short = short + rng.integers(-3, 4, short.size) * 1_000_000
        trajectories = [Trajectory(t, Motor.identity(t.shape)) for t in (short, long)]
        seconds = [
            np.array([float(f"{t // 10**9}.{t % 10**9:09d}") for t in s]) for s in (short, long)
        ]
        theirs = matching_time_indices(*seconds, 0.004)
        pairs = associate(*trajectories, 0.004)
        assert pairs.estimate_index.tolist() == theirs[0]
        assert pairs.reference_index.tolist() == theirs[1]
        swapped = associate(*trajectories[::-1], 0.004)
        assert swapped.estimate_index.tolist() == theirs[1]
        assert swapped.reference_index.tolist() == theirs[0]


@pytest.mark.parametrize("scale", [1.0, 0.4])
def test_alignment_undoes_any_similarity(handheld, rng, scale):
    truth = handheld.trajectory()
    turn, shift = Rotor.random(rng), rng.standard_normal(3)
    moved = Motor.from_rotor_translation(
        turn @ truth.poses.rotor, turn.apply(truth.poses.translation_m) * scale + shift
    )
    found = align(associate(Trajectory(truth.time_ns, moved), truth), with_scale=scale != 1.0)
    assert found.scale == pytest.approx(1.0 / scale, abs=1e-12)
    back = found.apply(moved)
    np.testing.assert_allclose(back.translation_m, truth.poses.translation_m, atol=1e-12)
    assert np.max(rotation_rad(back, truth.poses)) < 1e-12


def test_rotation_error_is_scipys_angle(rng):
    ours, true = Motor.random(rng, (50,)), Motor.random(rng, (50,))
    quaternions = [m.rotor.as_quaternion() for m in (ours, true)]
    a, b = (Rotation.from_quat(q, scalar_first=True) for q in quaternions)
    np.testing.assert_allclose(rotation_rad(ours, true), (b.inv() * a).magnitude(), atol=1e-12)


def test_tilt_is_blind_to_heading(rng):
    true = Motor.random(rng, (20,))
    heading = Rotor.from_rotation_vector(np.array([0.0, 0.0, 0.8]))
    roll = Rotor.from_rotation_vector(np.array([0.0, 0.3, 0.0]))
    turned = Motor.from_rotor_translation(heading, np.zeros(3)) @ true
    leaning = Motor.from_rotor_translation(roll, np.zeros(3)) @ true
    np.testing.assert_allclose(tilt_rad(turned, true), 0.0, atol=1e-12)
    np.testing.assert_allclose(tilt_rad(leaning, true), 0.3, atol=1e-12)


def test_accelerations_match_closed_forms_at_uneven_stamps(handheld, rng):
    steps = rng.integers(1_000_000, 4_000_000, 4000)
    stamps = handheld.time_ns(100.0, 0.0)[0] + np.cumsum(steps)
    linear, _ = accelerations((stamps - stamps[0]) * 1e-9, handheld.poses(stamps))
    true = handheld.accelerations(stamps)[1:-1]
    assert np.max(np.abs(linear - true)) < 2e-3


def test_angular_acceleration_is_exact_for_a_constant_one():
    time_s = np.sort(np.concatenate([np.linspace(0, 2, 31), np.linspace(0.01, 1.9, 23)]))
    angle = 0.7 * time_s**2 / 2
    poses = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(angle[:, None] * np.array([0.0, 0.6, 0.8])),
        np.zeros((time_s.size, 3)),
    )
    _, angular = accelerations(time_s, poses)
    np.testing.assert_allclose(angular, np.tile([0.0, 0.42, 0.56], (time_s.size - 2, 1)), atol=1e-9)


def test_jitter_of_white_noise_has_its_closed_form(handheld, jittered, rng):
    """A second difference of white noise σ at step h has deviation σ √6 / h² an axis."""
    truth = handheld.trajectory(100.0, 40.0)
    found = jitter(jittered(truth, 1e-3, 2e-3, rng), truth)
    assert found.linear_m_s2 == pytest.approx(1e-3 * np.sqrt(18) * 1e4, rel=0.03)
    assert found.angular_rad_s2 == pytest.approx(2e-3 * np.sqrt(18) * 1e4, rel=0.03)


@pytest.mark.parametrize("truth_hz", [20.0, 100.0, 173.0])
def test_a_perfect_estimate_has_no_jitter_whatever_the_rates(handheld, truth_hz):
    truth = handheld.trajectory(truth_hz, 12.0)
    estimate = handheld.trajectory(200.0, 8.0)[250:]
    found = jitter(estimate, truth)
    assert found.linear_m_s2 < 0.01
    assert found.angular_rad_s2 < 0.02


def test_a_gap_in_the_truth_adds_no_jitter(handheld):
    truth = handheld.trajectory(100.0, 10.0)
    stamps = truth.time_s
    gapped = truth[(stamps < 4.0) | (stamps > 6.0)]
    assert jitter(handheld.trajectory(50.0, 10.0), gapped).linear_m_s2 < 1e-3


def test_jitter_without_truth_counts_only_what_is_faster(handheld):
    """A 1 mm sine at 12 Hz jitters by A ω² / √2; the slow motion under it is not counted."""
    truth = handheld.trajectory(200.0, 20.0)
    tremor = np.zeros((len(truth), 3))
    tremor[:, 1] = 1e-3 * np.sin(2 * np.pi * 12.0 * truth.time_s)
    poses = Motor.from_translation(tremor) @ truth.poses
    jittering = Trajectory(truth.time_ns, poses)
    expected = 1e-3 * (2 * np.pi * 12.0) ** 2 / np.sqrt(2)
    assert jitter_above(jittering, 6.0).linear_m_s2 == pytest.approx(expected, rel=0.03)
    assert jitter_above(truth, 6.0).linear_m_s2 < 0.02
    gapped = jittering[(truth.time_s < 8.0) | (truth.time_s > 8.5)]
    assert jitter_above(gapped, 6.0).linear_m_s2 == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("lag_ms", [-37.3, 0.0, 3.7, 61.25])
def test_lag_is_found_to_a_tenth_of_a_millisecond(handheld, lag_ms):
    """An estimate that shows at t where the ground truth was at t - lag is late by lag."""
    truth = handheld.trajectory(100.0, 20.0)
    stamps = handheld.time_ns(30.0, 18.0) + 1_000_000_000
    late = Trajectory(stamps, handheld.poses(stamps - round(lag_ms * 1e6)))
    assert 1e3 * position_lag_s(late, truth) == pytest.approx(lag_ms, abs=0.1)
    assert 1e3 * angular_rate_lag_s(late, truth) == pytest.approx(lag_ms, abs=0.1)


@pytest.mark.parametrize("file", [FREIBURG, *REAL_ESTIMATES])
def test_a_real_trajectory_has_no_lag_behind_itself(data_dir, file):
    path = read_trajectory(data_dir / "trajectories" / file)
    assert abs(position_lag_s(path, path)) < 1e-9
    assert abs(angular_rate_lag_s(path, path)) < 1e-9


@pytest.mark.parametrize("longest_step_ms", [12, 60, 240])
def test_uneven_stamps_alone_make_no_lag(handheld, jittered, rng, longest_step_ms):
    steps = rng.integers(2_000_000, longest_step_ms * 1_000_000, 600)
    stamps = handheld.time_ns(100.0, 0.0)[0] + np.cumsum(steps)
    path = jittered(Trajectory(stamps, handheld.poses(stamps)), 0.01, 0.02, rng)
    found = evaluate(path, path)
    assert abs(found.lag_ms) < 1e-6
    assert abs(found.angular_rate_lag_ms) < 1e-6


def test_a_known_shift_is_found_on_real_motion(data_dir):
    """Read between the ground truth's stamps on screws, so not by the interpolant of the metric."""
    truth = read_trajectory(data_dir / "trajectories" / FREIBURG)
    stamps = read_trajectory(data_dir / "trajectories" / REAL_ESTIMATES[0]).time_ns[5:-5]
    late = Trajectory(stamps, truth.at(stamps - 3_700_000))
    assert 1e3 * position_lag_s(late, truth) == pytest.approx(3.7, abs=0.2)
    assert 1e3 * angular_rate_lag_s(late, truth) == pytest.approx(3.7, abs=0.2)


def test_a_known_shift_is_found_under_noise(handheld, jittered, rng):
    truth = handheld.trajectory(100.0, 40.0)
    stamps = handheld.time_ns(30.0, 38.0) + 1_000_000_000
    stamps = stamps + rng.integers(-8_000_000, 8_000_000, stamps.size)
    late = Trajectory(stamps, handheld.poses(stamps - 3_700_000))
    found = jittered(late, 5e-4, 2e-5, rng)
    assert 1e3 * position_lag_s(found, truth) == pytest.approx(3.7, abs=0.2)
    assert 1e3 * angular_rate_lag_s(found, truth) == pytest.approx(3.7, abs=0.2)


def test_a_peak_that_noise_could_have_made_is_no_lag(handheld, jittered, rng):
    truth = handheld.trajectory(100.0, 20.0)
    drowned = jittered(handheld.trajectory(50.0, 20.0), 10.0, 1.0, rng)
    for lag_s in (position_lag_s, angular_rate_lag_s):
        with pytest.raises(NotObservableError, match="known to 10 ms, got a standard error of"):
            lag_s(drowned, truth)
    found = evaluate(drowned, truth)
    assert found.lag_ms is None
    assert found.angular_rate_lag_ms is None


def test_motion_straight_ahead_and_even_turns_have_no_lag_to_tell(handheld, rng):
    stamps = handheld.time_ns(100.0, 0.0)[0] + np.cumsum(rng.integers(10**7, 10**8, 300))
    seconds = (stamps - stamps[0])[:, None] * 1e-9
    poses = Motor.from_euler_translation(
        seconds * np.array([0.0, 0.0, 0.3]), seconds * np.array([8.0, 1.0, 0.0])
    )
    found = evaluate(Trajectory(stamps, poses), Trajectory(stamps, poses))
    assert found.lag_ms is None
    assert found.angular_rate_lag_ms is None


def test_metrics_do_not_depend_on_the_world_of_both(handheld, jittered, rng):
    truth = handheld.trajectory(50.0)
    estimate = jittered(truth, 0.01, 0.01, rng)
    elsewhere = Motor.random(rng)
    before = evaluate(estimate, truth, "se3").as_dict()
    after = evaluate(estimate.transformed_by(elsewhere), truth, "se3").as_dict()
    assert after.pop("align") == before.pop("align")
    for name, value in before.items():
        if value is None:  # the ground truth neither stops nor turns back
            assert after[name] is None, name
        else:
            assert after[name] == pytest.approx(value, rel=1e-6, abs=1e-9), name


def test_what_cannot_be_told_is_none_and_json_takes_the_rest(handheld):
    truth = handheld.trajectory(50.0)
    found = evaluate(truth[100:102], truth).as_dict()
    assert found["linear_jitter_m_s2"] is None
    assert found["lag_ms"] is None
    assert json.loads(json.dumps(found))["pairs"] == 2
    still = Trajectory(truth.time_ns, Motor.identity((len(truth),)))
    assert evaluate(still, still).lag_ms is None


def test_metrics_leave_their_input_alone(handheld):
    truth = handheld.trajectory(50.0)
    before = truth.poses.coefficients.copy()
    evaluate(truth, truth, "sim3")
    np.testing.assert_array_equal(truth.poses.coefficients, before)


def test_refusals_say_what_was_expected(handheld):
    truth = handheld.trajectory(50.0)
    later = Trajectory(truth.time_ns + 60_000_000_000, truth.poses)
    with pytest.raises(ValueError, match="of each other, got none"):
        evaluate(truth, later)
    with pytest.raises(ValueError, match="max_difference_s: expected 0 or more, got -1"):
        evaluate(truth, truth, max_difference_s=-1.0)
    with pytest.raises(ValueError, match=r"align: expected one of none, se3, .*, got 'pitch'"):
        evaluate(truth, truth, "pitch")
    with pytest.raises(ValueError, match="expected 3 or more pairs, got 2"):
        evaluate(truth[:2], truth[:2], "se3")
    line = Motor.from_rotor_translation(Rotor.identity((9,)), np.arange(27.0).reshape(9, 3))
    straight = Trajectory(truth.time_ns[:9], line)
    with pytest.raises(ValueError, match="do not lie on one line"):
        evaluate(straight, straight, "se3")
    with pytest.raises(ValueError, match="frequency_hz: expected above 0 and below half the rate"):
        jitter_above(truth, 25.5)
    with pytest.raises(NotObservableError, match="peak of the correlation"):
        position_lag_s(Trajectory(later.time_ns - 57_000_000_000, truth.poses), truth)
