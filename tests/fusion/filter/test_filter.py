"""The filter: exact increments, right Jacobians, honest covariances, and what it does in need."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from motorcade.fusion.filter import FilterSettings, Fused
from motorcade.fusion.filter.extended_pose import (
    corrected,
    extended_pose,
    increments,
    process_noise,
)
from motorcade.fusion.imu import ADIS16448
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from tests.fusion.filter.by_hand import GRAVITY, Intervals


def state_errors(run, fused: Fused) -> FloatArray:
    """True minus estimated state ``(N, 15)`` in the filter's own coordinates."""
    k = np.searchsorted(run.truth.time_ns, fused.trajectory.time_ns)
    true, found = run.truth.poses[k], fused.trajectory.poses @ run.imu_T_camera.inverse()
    ours = extended_pose(found.rotor, found.translation_m, fused.velocity_m_s)
    theirs = extended_pose(true.rotor, true.translation_m, run.velocity_m_s[k])
    twists = (ours.inverse() @ theirs).as_twist()
    return np.hstack(
        [
            twists[:, 0],
            twists[:, 1, 3:],
            run.gyro_bias[k] - fused.gyro_bias_rad_s,
            run.accel_bias[k] - fused.accel_bias_m_s2,
        ]
    )


def some_intervals(rng, count=40, dt_s=0.005) -> Intervals:
    rate = rng.normal(0.5, 1.0, (count, 3))
    force = rng.normal([0.0, 0.0, 9.81], 3.0, (count, 3))
    return Intervals(np.full(count, dt_s), rate, force)


def each(data: Intervals, bias: FloatArray) -> tuple[Motor, FloatArray]:
    """What every interval adds: extended poses ``(K, 2)`` and transitions ``(K, 15, 15)``."""
    first = np.arange(len(data.dt_s))
    motion, transition, _ = increments(
        first, data.dt_s, data.rate_rad_s, data.force_m_s2, bias, ADIS16448
    )
    return motion, transition


def pushed(start: Motor, bias: FloatArray, data: Intervals) -> Motor:
    """Extended pose after all intervals."""
    rotor, (position, velocity) = start[0].rotor, start.translation_m
    motion, _ = each(data, bias)
    for step, gained, dt in zip(motion, motion.translation_m, data.dt_s, strict=True):
        position = position + velocity * dt + 0.5 * GRAVITY * dt**2 + rotor.apply(gained[0])
        velocity = velocity + GRAVITY * dt + rotor.apply(gained[1])
        rotor = rotor @ step[0].rotor
    return extended_pose(rotor, position, velocity)


# Propagation ------------------------------------------------------------------------------------


def test_one_interval_is_exact_for_constant_rate_and_force(rng):
    """A thousand tiny intervals with the same readings lead where one long one does."""
    for size in (1e-9, 1e-3, 0.02, 0.5, 3.0):
        rate, force = size * rng.standard_normal(3), rng.normal(0.0, 5.0, 3)
        start = extended_pose(Rotor.random(rng), rng.standard_normal(3), rng.standard_normal(3))
        long = pushed(start, np.zeros(6), Intervals(np.array([0.8]), rate[None], force[None]))
        tiny = Intervals(np.full(1000, 8e-4), np.tile(rate, (1000, 1)), np.tile(force, (1000, 1)))
        short = pushed(start, np.zeros(6), tiny)
        np.testing.assert_allclose((long.inverse() @ short).as_twist(), 0.0, atol=1e-11)


def test_propagation_is_what_gtsams_preintegration_tends_to(rng):
    """There the force is held through a step as at its start: an error that falls with the step."""
    gtsam = pytest.importorskip("gtsam")
    data, bias = some_intervals(rng), rng.normal(0.0, 0.1, 6)
    start = extended_pose(Rotor.random(rng), rng.standard_normal(3), rng.standard_normal(3))
    ours = pushed(start, bias, data)
    params = gtsam.PreintegrationParams.MakeSharedU(9.81)
    pose = gtsam.NavState(gtsam.Pose3(start[0].as_matrix()), start[1].translation_m)
    constant = gtsam.imuBias.ConstantBias(bias[3:], bias[:3])
    differences = []
    for parts in (4, 40):
        total = gtsam.PreintegratedImuMeasurements(params, constant)
        for rate, force in zip(data.rate_rad_s, data.force_m_s2, strict=True):
            for _ in range(parts):
                total.integrateMeasurement(force, rate, 0.005 / parts)
        end = total.predict(pose, constant)
        theirs = Motor.from_matrix(end.pose().matrix())
        offset = np.abs((ours[0].inverse() @ theirs).as_twist())
        speed = np.abs(ours[1].translation_m - end.velocity())
        differences.append(max(offset.max(), speed.max()))
    assert differences[1] < 2e-4
    assert differences[1] < 0.15 * differences[0]


def test_the_transition_is_the_derivative_of_propagation(rng):
    data = Intervals(np.array([0.01]), rng.normal(0.0, 1.0, (1, 3)), rng.normal(0.0, 6.0, (1, 3)))
    start = extended_pose(Rotor.random(rng), rng.standard_normal(3), rng.standard_normal(3))
    bias = rng.normal(0.0, 0.1, 6)
    matrix = each(data, bias)[1][0]
    end, numeric, step = pushed(start, bias, data), np.zeros((15, 15)), 1e-5
    numeric[9:, 9:] = np.eye(6)
    for i in range(15):
        both = []
        for sign in (1.0, -1.0):
            error = sign * step * np.eye(15)[i]
            moved = pushed(corrected(start, error), bias + error[9:], data)
            twists = (end.inverse() @ moved).as_twist()
            both.append(np.concatenate([twists[0], twists[1, 3:]]))
        numeric[:9, i] = (both[0] - both[1]) / (2 * step)
    np.testing.assert_allclose(matrix, numeric, atol=1e-8)


def test_the_error_moves_the_same_wherever_the_estimate_is(rng):
    """Large errors too: the law of invariant filtering (with the biases known)."""
    data = some_intervals(rng)
    _, steps = each(data, np.zeros(6))
    error = np.concatenate([[0.6, -0.5, 0.4, 1.0, -2.0, 0.5, 3.0, 1.0, -2.0], np.zeros(6)])
    carried = error
    for matrix in steps:
        carried = matrix @ carried
    for _ in range(3):
        where = rng.normal(0.0, 10.0, (2, 3))
        start = extended_pose(Rotor.random(rng), where[0], where[1])
        moved = pushed(corrected(start, error), np.zeros(6), data)
        predicted = corrected(pushed(start, np.zeros(6), data), carried)
        np.testing.assert_allclose((moved.inverse() @ predicted).as_twist(), 0.0, atol=1e-9)


def test_process_noise_is_the_integral_of_white_noise():
    """One long step adds what five hundred short ones do, one carried into the next."""
    whole = process_noise(np.array([0.5]), ADIS16448)[0]
    small = process_noise(np.full(500, 1e-3), ADIS16448)
    move = np.eye(15)
    move[3:6, 6:9] = 1e-3 * np.eye(3)
    total = np.zeros((15, 15))
    for added in small:
        total = move @ total @ move.T + added
    np.testing.assert_allclose(total, whole, rtol=1e-9, atol=1e-18)


# The filter as a whole --------------------------------------------------------------------------


@pytest.mark.parametrize("smoothed", [False, True])
def test_covariances_are_honest(record, smoothed):
    """Mean NEES of a small Monte Carlo lies within the χ² bounds (99.8 %), each part apart."""
    runs, parts = 24, {"pose": slice(0, 6), "velocity": slice(6, 9), "biases": slice(9, 15)}
    nees = {name: [] for name in [*parts, "all"]}
    for seed in range(runs):
        run = record(np.random.default_rng(seed), 5.0)
        fused = run.fuse(smoothed=smoothed)
        at = [30, 60, 95]
        errors, covariances = state_errors(run, fused)[at], fused.state_covariance[at]
        for name, part in [*parts.items(), ("all", slice(0, 15))]:
            e, p = errors[:, part, None], covariances[:, part, part]
            nees[name].append(np.mean(e.swapaxes(-1, -2) @ np.linalg.solve(p, e)))
    for name, values in nees.items():
        freedom = 15 if name == "all" else parts[name].stop - parts[name].start
        low, high = chi2.ppf([0.001, 0.999], runs * freedom) / runs
        assert low < np.mean(values) < high, (name, np.mean(values), freedom)


@pytest.mark.parametrize("more", [{}, {"gravity_sigma_rad": 0.02, "extrinsics_sigma_rad": 0.02}])
def test_smoothed_covariances_are_symmetric_positive_and_smaller(record, rng, more):
    """At every sample, from a start that hardly knows its velocity; scaled by their deviations."""
    run = record(rng, 4.0)
    online, smoothed = (
        run.fuse(stamps_ns=run.imu.time_ns, smoothed=ahead, settings=FilterSettings(**more))
        for ahead in (False, True)
    )
    sigma = np.sqrt(np.diagonal(smoothed.state_covariance, axis1=1, axis2=2))
    before = np.sqrt(np.diagonal(online.state_covariance, axis1=1, axis2=2))
    known = sigma[0] > 0.0  # what is not estimated has none
    assert np.count_nonzero(known) == 15 + 5 * bool(more)
    assert np.all(sigma <= before * (1.0 + 1e-9))
    covariance = smoothed.state_covariance
    np.testing.assert_array_equal(covariance, covariance.swapaxes(-1, -2))
    part = covariance[:, known][:, :, known] / (sigma[:, known, None] * sigma[:, None, known])
    assert np.min(np.linalg.eigvalsh(part)) > 1e-6


def test_innovations_are_white_with_six_degrees_of_freedom(record):
    nis = np.concatenate(
        [record(np.random.default_rng(seed), 5.0).fuse(smoothed=False).nis[5:] for seed in range(6)]
    )
    low, high = chi2.ppf([0.001, 0.999], 6 * nis.size) / nis.size
    assert low < np.mean(nis) < high


def test_the_backward_pass_is_gtsams_batch_optimum(record, rng):
    """Same data, same model: poses, velocities and biases of a least-squares problem over all."""
    gtsam = pytest.importorskip("gtsam")
    run = record(rng, 2.0)
    fused = run.fuse(settings=FilterSettings(gate=1.0))
    batch = gtsam_batch(gtsam, run)
    ours = fused.trajectory.poses @ run.imu_T_camera.inverse()
    apart = (ours.inverse() @ Motor.stack([Motor.from_matrix(m) for m, _, _ in batch])).as_twist()
    sigma = np.sqrt(np.diagonal(fused.state_covariance, axis1=-2, axis2=-1))
    assert np.max(np.abs(apart) / sigma[:, :6]) < 0.1
    faster = np.linalg.norm(fused.velocity_m_s - [v for _, v, _ in batch], axis=-1)
    assert np.max(faster / np.linalg.norm(sigma[:, 6:9], axis=-1)) < 0.1
    bias = np.hstack([fused.accel_bias_m_s2, fused.gyro_bias_rad_s]) - [b for _, _, b in batch]
    assert np.max(np.abs(bias) / sigma[:, [12, 13, 14, 9, 10, 11]]) < 0.1


def gtsam_batch(gtsam, run) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Poses (4, 4), velocities and biases (accelerometer first) at the measured stamps."""
    noise, graph, values = run.noise, gtsam.NonlinearFactorGraph(), gtsam.Values()
    sigmas, x, v, b = (
        gtsam.noiseModel.Diagonal.Sigmas,
        *(lambda i, letter=letter: gtsam.symbol(letter, i) for letter in "xvb"),
    )
    stamps, poses = run.measurements.trajectory.time_ns, run.measurements.trajectory.poses
    bodies = poses @ run.imu_T_camera.inverse()
    adjoint = gtsam.Pose3(run.imu_T_camera.as_matrix()).AdjointMap()
    guess = np.gradient(bodies.translation_m, stamps * 1e-9, axis=0)
    zero, at_rest = gtsam.imuBias.ConstantBias(), np.zeros(3)
    walks = np.repeat([noise.accel_walk_m_s3_rthz, noise.gyro_walk_rad_s2_rthz], 3)
    for i, covariance in enumerate(adjoint @ run.measurements.covariance @ adjoint.T):
        body = gtsam.Pose3(bodies[i].as_matrix())
        spread = gtsam.noiseModel.Gaussian.Covariance(covariance)
        graph.add(gtsam.PriorFactorPose3(x(i), body, spread))
        values.insert(x(i), body)
        values.insert(v(i), guess[i])
        values.insert(b(i), zero)
    graph.add(gtsam.PriorFactorConstantBias(b(0), zero, sigmas(np.repeat([0.5, 0.1], 3))))
    graph.add(gtsam.PriorFactorVector(v(0), at_rest, sigmas(np.full(3, 20.0))))
    for i, step_ns in enumerate(np.diff(stamps)):
        total = preintegrated(gtsam, run, stamps[i], stamps[i + 1])
        graph.add(gtsam.ImuFactor(x(i), v(i), x(i + 1), v(i + 1), b(i), total))
        step = sigmas(walks * np.sqrt(step_ns * 1e-9))
        graph.add(gtsam.BetweenFactorConstantBias(b(i), b(i + 1), zero, step))
    found = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    return [
        (found.atPose3(x(i)).matrix(), found.atVector(v(i)), found.atConstantBias(b(i)).vector())
        for i in range(len(stamps))
    ]


def preintegrated(gtsam, run, start_ns: int, end_ns: int):
    """Readings between two stamps; gtsam holds the force at the start of a step: small steps."""
    params = gtsam.PreintegrationParams.MakeSharedU(9.81)
    params.setGyroscopeCovariance(run.noise.gyro_density_rad_s_rthz**2 * np.eye(3))
    params.setAccelerometerCovariance(run.noise.accel_density_m_s2_rthz**2 * np.eye(3))
    params.setIntegrationCovariance(1e-12 * np.eye(3))
    total = gtsam.PreintegratedImuMeasurements(params, gtsam.imuBias.ConstantBias())
    parts = 20 * (np.searchsorted(run.imu.time_ns, [start_ns, end_ns]) @ [-1, 1])
    middles = start_ns + (end_ns - start_ns) * (2 * np.arange(parts) + 1) // (2 * parts)
    readings = run.imu.at(middles)
    for rate, force in zip(readings.angular_rate_rad_s, readings.specific_force_m_s2, strict=True):
        total.integrateMeasurement(force, rate, (end_ns - start_ns) * 1e-9 / parts)
    return total
