"""What every metric owes: nothing for a perfect estimate, the same figure in every frame."""

from __future__ import annotations

import json

import numpy as np
import pytest

from motorcade.fusion.metrics import (
    Delta,
    absolute_translation_m,
    angular_rate_lag_s,
    drift_by_length,
    energy_excess_above,
    evaluate,
    gimbal_index,
    jitter,
    log_dimensionless_jerk,
    log_scales,
    position_lag_s,
    position_overshoot_m,
    relative_errors,
    rotation_overshoot_rad,
    rotation_rad,
    tilt_rad,
)
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.ga import Motor, Rotor, Similarity, Trajectory

ZERO = {
    "ape": lambda e, t: absolute_translation_m(e.motors, t.motors).max(),
    "rotation": lambda e, t: rotation_rad(e.motors, t.motors).max(),
    "rpe_by_length": lambda e, t: np.max(relative_errors(e.motors, t.motors, Delta(0.5, "m"))),
    "drift": lambda e, t: drift_by_length(e.motors, t.motors, (0.5,))[0].translation,
    "linear_jitter": lambda e, t: jitter(e, t).linear_m_s2,
    "angular_jitter": lambda e, t: jitter(e, t).angular_rad_s2,
    "linear_energy": lambda e, t: energy_excess_above(e, t, 3.0).linear_m2_s4,
    "angular_energy": lambda e, t: energy_excess_above(e, t, 3.0).angular_rad2_s4,
    "turns": lambda e, t: gimbal_index(e, t).spurious_turns,
}
ONE = {
    "path_ratio": lambda e, t: gimbal_index(e, t).path_ratio,
    "peak_rate_ratio": lambda e, t: gimbal_index(e, t).peak_rate_ratio,
}
AT_STOPS = {"overshoot": position_overshoot_m, "rotation_overshoot": rotation_overshoot_rad}
ALONE = {
    "linear_log_jerk": lambda e, t: log_dimensionless_jerk(e).linear,
    "angular_log_jerk": lambda e, t: log_dimensionless_jerk(e).angular,
}
# Of the origin of the moving frame, so another origin gives another figure.
OF_THE_ORIGIN = {
    "ape",
    "rpe_by_length",
    "drift",
    "linear_jitter",
    "linear_energy",
    "overshoot",
    "linear_log_jerk",
}
RIGID = [name for name in MOTIONS if name != "zoom"]


@pytest.fixture(params=RIGID)
def truth(request) -> Trajectory:
    return MOTIONS[request.param].sampled(30.0, 10.0, start_ns=10**18)


def test_a_perfect_estimate_has_no_error(truth):
    for name, metric in ZERO.items():
        assert abs(metric(truth, truth)) < 1e-9, name
    for name, metric in ONE.items():
        assert metric(truth, truth) == pytest.approx(1.0, abs=1e-9), name


@pytest.mark.parametrize("name", ["stop_and_go", "handheld", "gimbal_crossing"])
def test_a_perfect_estimate_does_not_overshoot(name):
    truth = MOTIONS[name].sampled(30.0, 20.0)
    for metric in AT_STOPS.values():
        assert metric(truth, truth) < 1e-12


@pytest.mark.parametrize("metric", [*ZERO, *ONE, *AT_STOPS, *ALONE])
def test_the_world_of_both_does_not_matter(metric, rng):
    truth = MOTIONS["stop_and_go"].sampled(30.0, 10.0)
    estimate = Gaussian(0.005, 0.01).apply(truth, rng)
    figure = (ZERO | ONE | AT_STOPS | ALONE)[metric]
    before = figure(estimate, truth)
    if metric not in ("turns",):
        assert abs(before) > 1e-6
    for left in Motor.random(rng, (3,)):
        after = figure(estimate.transformed_by(left), truth.transformed_by(left))
        assert after == pytest.approx(before, rel=1e-6)


@pytest.mark.parametrize("metric", [*ZERO, *ONE, *AT_STOPS, *ALONE])
def test_the_mount_of_both_does_not_matter(metric, rng):
    truth = MOTIONS["stop_and_go"].sampled(30.0, 10.0)
    estimate = Gaussian(0.005, 0.01).apply(truth, rng)
    figure = (ZERO | ONE | AT_STOPS | ALONE)[metric]
    before = figure(estimate, truth)
    for right in Motor.random(rng, (3,)):
        if metric in OF_THE_ORIGIN:
            right = Motor.from_rotor_translation(right.rotor, np.zeros(3))
        after = figure(estimate.transformed_by(right=right), truth.transformed_by(right=right))
        assert after == pytest.approx(before, rel=1e-6)


def test_evaluate_puts_them_together(rng):
    truth = MOTIONS["stop_and_go"].sampled(30.0, 20.0)
    estimate = Gaussian(0.005, 0.01).apply(truth, rng)
    flat = evaluate(estimate, truth, energy_above_hz=3.0).as_dict()
    assert json.loads(json.dumps(flat)) == flat
    found = gimbal_index(estimate, truth)
    energy, score = energy_excess_above(estimate, truth, 3.0), log_dimensionless_jerk(estimate)
    expected = {
        "energy_above_hz": 3.0,
        "linear_energy_excess_m2_s4": energy.linear_m2_s4,
        "angular_energy_excess_rad2_s4": energy.angular_rad2_s4,
        "linear_log_jerk": score.linear,
        "angular_log_jerk": score.angular,
        "overshoot_m": position_overshoot_m(estimate, truth),
        "rotation_overshoot_deg": np.rad2deg(rotation_overshoot_rad(estimate, truth)),
        "rotation_path_ratio": found.path_ratio,
        "peak_rate_ratio": found.peak_rate_ratio,
        "spurious_turns": 0,
        "lag_ms": 1e3 * position_lag_s(estimate, truth),
        "angular_rate_lag_ms": 1e3 * angular_rate_lag_s(estimate, truth),
        "tilt_mean_deg": np.rad2deg(tilt_rad(estimate.motors, truth.motors).mean()),
        "log_scale_rmse": None,
    }
    # A lag is where a correlation peaks, which rounding moves by more than itself.
    for key, value in expected.items():
        assert flat[key] == (None if value is None else pytest.approx(value, rel=1e-9)), key


def test_a_slow_estimate_lowers_the_cut_off():
    truth = MOTIONS["handheld"].sampled(4.0, 20.0)
    assert evaluate(truth, truth).energy_above_hz == pytest.approx(1.0)
    with pytest.raises(ValueError, match="energy_above_hz: expected a number above 0, got -1"):
        evaluate(truth, truth, energy_above_hz=-1.0)


def test_similarities_are_judged_by_their_rigid_part_and_their_scale(rng):
    truth = MOTIONS["zoom"].sampled(30.0, 10.0)
    noise = Gaussian(0.005, 0.01, 0.02)
    estimate = noise.apply(truth, rng)
    found = evaluate(estimate, truth)
    assert found.log_scale is not None
    ratios = np.log(estimate.poses.scale / truth.poses.scale)
    assert found.log_scale.rmse == pytest.approx(np.sqrt(np.mean(ratios**2)), rel=1e-12)
    assert found.log_scale.rmse == pytest.approx(0.02, rel=0.15)
    rigid = evaluate(estimate.rigid, truth.rigid)
    assert rigid.log_scale is None
    assert found.ape_m == rigid.ape_m
    assert found.rotation_deg == rigid.rotation_deg
    assert evaluate(truth, truth).log_scale.max < 1e-12
    np.testing.assert_array_equal(log_scales(Motor.identity((3,))), np.zeros(3))


def test_alignment_takes_the_scale_of_the_world_off_the_similarities(rng):
    truth = MOTIONS["zoom"].sampled(30.0, 10.0)
    world = Similarity.from_rotor_translation_scale(Rotor.random(rng), [1.0, 2.0, 3.0], 2.5)
    found = evaluate(truth.transformed_by(world), truth, "sim3")
    assert found.scale == pytest.approx(0.4, rel=1e-9)
    assert found.ape_m.max < 1e-9
    assert found.log_scale.max < 1e-9
