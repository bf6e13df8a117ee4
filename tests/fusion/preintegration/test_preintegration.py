"""Preintegration against gtsam, exact motions, numerical derivatives and random trials."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import gtsam
import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.preintegration import Preintegrated, preintegrate
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.motion import SplineSample, sampled_motion

GYRO_BIAS = np.array([-0.002, 0.021, 0.076])
ACCEL_BIAS = np.array([-0.013, 0.103, 0.093])
GRAVITY = np.array([0.0, 0.0, -9.81])
NAMES = ["handheld", "gimbal_crossing", "walk_and_look"]


def stamps(rate_hz: float, duration_s: float = 1.0) -> IntArray:
    return np.round(np.arange(round(duration_s * rate_hz) + 1) * 1e9 / rate_hz).astype(np.int64)


def truth(name: str, time_ns: IntArray) -> SplineSample:
    return sampled_motion(MOTIONS[name].at(0.3 + time_ns * 1e-9))


def perfect(name: str, time_ns: IntArray) -> ImuStream:
    """What a perfect sensor with constant biases reads."""
    exact = truth(name, time_ns)
    force = exact.pose.rotor.inverse().apply(exact.world_acceleration_m_s2 - GRAVITY)
    return ImuStream(time_ns, exact.body_angular_rate_rad_s + GYRO_BIAS, force + ACCEL_BIAS)


def by_gtsam(imu: ImuStream, noise: ImuNoise, form: str = "Manifold") -> Any:
    """The whole stream preintegrated by gtsam, each sample held until the next."""
    params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.81)
    params.setGyroscopeCovariance(noise.gyro_density_rad_s_rthz**2 * np.eye(3))
    params.setAccelerometerCovariance(noise.accel_density_m_s2_rthz**2 * np.eye(3))
    params.setBiasOmegaCovariance(noise.gyro_walk_rad_s2_rthz**2 * np.eye(3))
    params.setBiasAccCovariance(noise.accel_walk_m_s3_rthz**2 * np.eye(3))
    params.setIntegrationCovariance(np.zeros((3, 3)))
    kind = getattr(gtsam, f"PreintegratedCombinedMeasurements{form}")
    summed = kind(params, gtsam.imuBias.ConstantBias(ACCEL_BIAS, GYRO_BIAS))
    for k, dt_s in enumerate(np.diff(imu.time_ns) * 1e-9):
        summed.integrateMeasurement(
            imu.specific_force_m_s2[k], imu.angular_rate_rad_s[k], float(dt_s)
        )
    return summed


def difference(own: Preintegrated, other: Any) -> float:
    turn = own.motion[0, 0].rotor.as_matrix() - other.deltaRij().matrix()
    moved, gained = own.motion.translation_m[0]
    parts = (turn, moved - other.deltaPij(), gained - other.deltaVij())
    return max(float(np.max(np.abs(part))) for part in parts)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("form", "within"), [("Manifold", 1e-12), ("LieGroup", 1e-12), ("", 1e-4)])
def test_half_a_second_by_gtsams_rule_agrees_with_gtsam(name, form, within):
    """To rounding on manifold and group; its default, in tangent space, is itself of first order
    in its rotation.
    """
    imu = perfect(name, stamps(200.0, 0.5))
    own = preintegrate(imu, imu.time_ns[[0, -1]], ADIS16448, GYRO_BIAS, ACCEL_BIAS, rule="held")
    assert difference(own, by_gtsam(imu, ADIS16448, form)) < within


@pytest.mark.parametrize("name", NAMES)
def test_the_covariance_by_gtsams_rule_is_gtsams(name):
    imu = perfect(name, stamps(200.0, 0.5))
    noise = ADIS16448.scaled(3.0)
    keys = imu.time_ns[[0, -1]]
    own = preintegrate(imu, keys, noise, GYRO_BIAS, ACCEL_BIAS, rule="held").covariance[0]
    sigma = np.sqrt(np.diag(own))
    theirs = by_gtsam(imu, noise).preintMeasCov()
    # gtsam puts the accelerometer first and counts biases as taken off.
    order, sign = np.r_[:9, 12:15, 9:12], np.repeat([1.0, -1.0], [9, 6])
    theirs = sign[:, None] * theirs[np.ix_(order, order)] * sign
    np.testing.assert_allclose(
        own / np.outer(sigma, sigma), theirs / np.outer(sigma, sigma), atol=1e-9
    )


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("rule", "falls"), [("mean", 3.5), ("held", 1.8)])
def test_halved_steps_shrink_the_error_by_the_rules_order(name, rule, falls):
    """Against the motion's closed form: from the true start to the true end."""
    errors = []
    for rate_hz in (100.0, 200.0, 400.0):
        time_ns = stamps(rate_hz)
        exact = truth(name, time_ns)
        own = preintegrate(
            perfect(name, time_ns), time_ns[[0, -1]], ADIS16448, GYRO_BIAS, ACCEL_BIAS, rule=rule
        )
        pose, velocity = own.propagate(exact.pose[:1], exact.world_velocity_m_s[:1], GRAVITY)
        apart = (pose.inverse() @ exact.pose[-1:]).as_twist()
        errors.append(
            [
                np.linalg.norm(apart[0, :3]),
                np.linalg.norm(apart[0, 3:]),
                np.linalg.norm(velocity[0] - exact.world_velocity_m_s[-1]),
            ]
        )
    for coarse, fine in pairwise(np.array(errors)):
        assert np.all(coarse / fine > falls)


@pytest.mark.parametrize("rule", ["mean", "held"])
def test_the_bias_jacobian_is_the_derivative(rule):
    imu = perfect("handheld", stamps(200.0, 0.5))
    keys = imu.time_ns[[0, 40, 100]]

    def motion(biases: FloatArray) -> Motor:
        return preintegrate(imu, keys, ADIS16448, biases[:3], biases[3:], rule=rule).motion

    start = np.concatenate([GYRO_BIAS, ACCEL_BIAS])
    middle = preintegrate(imu, keys, ADIS16448, GYRO_BIAS, ACCEL_BIAS, rule=rule)
    for column, step in enumerate(np.eye(6) * 1e-5):
        ends = (middle.motion.inverse() @ motion(start + sign * step) for sign in (1, -1))
        up, down = (end.as_twist() for end in ends)
        slope = (up - down) / 2e-5
        expected = np.concatenate([slope[:, 0], slope[:, 1, 3:]], axis=-1)
        np.testing.assert_allclose(middle.bias_jacobian[..., column], expected, atol=3e-5)


def test_correcting_for_biases_is_off_only_by_the_square_of_the_change():
    imu = perfect("handheld", stamps(200.0, 0.5))
    keys = imu.time_ns[[0, -1]]
    first = preintegrate(imu, keys, ADIS16448, GYRO_BIAS, ACCEL_BIAS)
    errors = []
    for size in (1.0, 0.5):
        biases = GYRO_BIAS + 0.01 * size, ACCEL_BIAS - 0.1 * size
        again = preintegrate(imu, keys, ADIS16448, *biases).motion
        apart = (first.with_biases(*biases).inverse() @ again).as_twist()
        errors.append(float(np.max(np.abs(apart))))
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] > 3.5


def test_the_covariance_is_that_of_many_noisy_runs(rng):
    """Errors of noisy streams with walking biases, in deviations, have covariance one."""
    noise = ImuNoise(2e-3, 3e-3, 2e-2, 3e-2)
    time_ns = stamps(100.0, 0.5)
    clean = perfect("handheld", time_ns)
    keys = time_ns[[0, -1]]
    expected = preintegrate(clean, keys, noise, GYRO_BIAS, ACCEL_BIAS, rule="held")
    runs, dt_s, errors = 800, 0.01, []
    for _ in range(runs):
        white = rng.standard_normal((2, len(time_ns), 3)) / np.sqrt(dt_s)
        walk = np.cumsum(rng.standard_normal((2, len(time_ns), 3)) * np.sqrt(dt_s), axis=1)
        walk -= walk[:, :1]  # biases are known at the start
        walk *= np.array([noise.gyro_walk_rad_s2_rthz, noise.accel_walk_m_s3_rthz])[:, None, None]
        imu = ImuStream(
            time_ns,
            clean.angular_rate_rad_s + noise.gyro_density_rad_s_rthz * white[0] + walk[0],
            clean.specific_force_m_s2 + noise.accel_density_m_s2_rthz * white[1] + walk[1],
        )
        run = preintegrate(imu, keys, noise, GYRO_BIAS, ACCEL_BIAS, rule="held")
        apart = (run.motion.inverse() @ expected.motion).as_twist()[0]
        errors.append(np.concatenate([apart[0], apart[1, 3:], walk[0, -1], walk[1, -1]]))
    spread = np.array(errors)
    whitened = np.linalg.solve(np.linalg.cholesky(expected.covariance[0]), spread.T)
    found = whitened @ whitened.T / runs
    assert np.max(np.abs(found - np.eye(15))) < 5.0 * np.sqrt(2.0 / runs)


def test_any_keyframes_at_once_are_each_on_their_own_and_follow_each_other():
    imu = perfect("handheld", stamps(200.0))
    keys = np.array([0, 3_000_000, 250_000_000, 261_234_567, 700_000_000, 1_000_000_000])
    together = preintegrate(imu, keys, ADIS16448, GYRO_BIAS, ACCEL_BIAS)
    exact = truth("handheld", keys)
    pose, velocity = exact.pose[:1], exact.world_velocity_m_s[:1]
    transition, covariance = np.eye(15), np.zeros((15, 15))
    for k, (start, end) in enumerate(pairwise(keys)):
        alone = preintegrate(imu, np.array([start, end]), ADIS16448, GYRO_BIAS, ACCEL_BIAS)
        for name in ("duration_s", "transition", "covariance"):
            np.testing.assert_allclose(
                getattr(together, name)[k], getattr(alone, name)[0], rtol=1e-9, atol=1e-15
            )
        pose, velocity = alone.propagate(pose, velocity, GRAVITY)
        matrix = alone.transition[0]
        transition = matrix @ transition
        covariance = matrix @ covariance @ matrix.T + alone.covariance[0]
    own = preintegrate(imu, keys[[0, -1]], ADIS16448, GYRO_BIAS, ACCEL_BIAS)
    sigma = np.sqrt(np.diag(own.covariance[0]))
    np.testing.assert_allclose(own.transition[0], transition, atol=3e-5)
    scale = np.outer(sigma, sigma)
    np.testing.assert_allclose(own.covariance[0] / scale, covariance / scale, atol=0.02)
    assert np.max(np.abs((pose.inverse() @ exact.pose[-1:]).as_twist())) < 1e-4
    assert np.max(np.abs(velocity[0] - exact.world_velocity_m_s[-1])) < 1e-3


def test_biases_may_differ_by_interval():
    imu = perfect("handheld", stamps(200.0))
    keys = imu.time_ns[[0, 100, 200]]
    biases = np.stack([GYRO_BIAS, np.zeros(3)]), np.stack([ACCEL_BIAS, np.ones(3)])
    both = preintegrate(imu, keys, ADIS16448, *biases)
    second = preintegrate(imu, keys[1:], ADIS16448, np.zeros(3), np.ones(3))
    np.testing.assert_allclose(both.motion[1].coefficients, second.motion[0].coefficients)
    np.testing.assert_array_equal(both.gyro_bias_rad_s, biases[0])


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"keyframes_ns": np.array([0])}, "keyframes_ns"),
        ({"keyframes_ns": np.array([0, 0])}, "rising"),
        ({"keyframes_ns": np.array([0.0, 1.0])}, "integer"),
        ({"keyframes_ns": np.array([-5, 1_000])}, "where there are samples"),
        ({"gyro_bias_rad_s": np.zeros((2, 3))}, "gyro_bias_rad_s"),
        ({"accel_bias_m_s2": [0.0, np.nan, 0.0]}, "accel_bias_m_s2"),
        ({"rule": "euler"}, "euler"),
    ],
)
def test_bad_input_is_refused(options, says):
    imu = perfect("handheld", stamps(200.0))
    keys = options.pop("keyframes_ns", imu.time_ns[[0, 100]])
    with pytest.raises(ValueError, match=says):
        preintegrate(imu, keys, ADIS16448, **options)
