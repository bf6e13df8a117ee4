"""Each kind against gtsam's own factor for it: residuals, derivatives, posteriors."""

from __future__ import annotations

from typing import Any

import gtsam
import numpy as np
import pytest

from motorcade.fusion.filter import FilterSettings, PoseFilter
from motorcade.fusion.graph.kinds import KindFactor
from motorcade.fusion.graph.shared import SharedUnknowns, keys
from motorcade.fusion.imu import ADIS16448
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from tests.fusion.measurements.along import (
    ARM,
    FIELD,
    IMU_R_BODY,
    IMU_T_BODY,
    KINDS,
    Along,
    measured_along,
)

AXIS = np.array([0.8, 0.6, 0.0])


def as_pose(motor: Motor) -> gtsam.Pose3:
    return gtsam.Pose3(motor.as_matrix())


def axes_of(kind: str) -> FloatArray:
    """Turns our residual to gtsam's axes, which for a magnetometer are the body's."""
    size = {"altitude": 1, "heading": 1, "pose": 6, "relative_pose": 6}.get(kind, 3)
    return IMU_R_BODY.as_matrix() if kind == "magnetic_field" else np.eye(size)


def by_gtsam(kind: str, given: Any, reading: FloatArray) -> gtsam.NoiseModelFactor:
    """What gtsam says of the first measurement: its own factor, or one of its own operations.

    Its residuals are predicted less measured, in `axes_of` the kind.
    """
    axes = axes_of(kind)
    node = keys(0)
    model = gtsam.noiseModel.Gaussian.Covariance(axes @ given.covariance[0] @ axes.T)
    body = as_pose(IMU_T_BODY)
    if kind == "position":
        return gtsam.GPSFactorArm(node.pose, given.position_m[0], ARM, model)
    if kind == "magnetic_field":
        size = float(np.linalg.norm(FIELD))
        return gtsam.MagPoseFactorPose3(
            node.pose, given.measured_field[0], size, FIELD / size, np.zeros(3), model, body
        )

    def error(_: Any, values: gtsam.Values, jacobians: Any) -> FloatArray:
        pose, speed = values.atPose3(node.pose), values.atVector(node.velocity)
        rate = reading - values.atConstantBias(node.bias).gyroscope()
        turn = np.zeros((3, 6), order="F")
        by_pose, by_speed, by_bias, by_earlier = (
            np.zeros((given.covariance.shape[-1], size)) for size in (6, 3, 6, 6)
        )
        across = np.stack([np.cross(ARM, axis) for axis in np.eye(3)], axis=-1)  # [arm]×
        if kind == "altitude":
            place = pose.transformFrom(ARM, turn, np.zeros((3, 3), order="F"))
            value, by_pose = place[2:] - given.altitude_m[0], turn[2:]
        elif kind == "heading":
            way = np.zeros((3, 3), order="F")
            x, y, _ = pose.rotation().rotate(AXIS, way, np.zeros((3, 3), order="F"))
            value = np.array([np.angle(np.exp(1j * (np.arctan2(y, x) - given.heading_rad[0])))])
            by_pose[0, :3] = (x * way[1] - y * way[0]) / (x * x + y * y)
        elif kind == "velocity":
            way, own = np.zeros((3, 3), order="F"), np.zeros((3, 3), order="F")
            about = pose.rotation().rotate(np.cross(rate, ARM), way, own)
            value = speed + about - given.velocity_m_s[0]
            by_pose[:, :3], by_speed, by_bias[:, 3:] = way, np.eye(3), own @ across
        elif kind == "body_velocity":
            way, own = np.zeros((3, 3), order="F"), np.zeros((3, 3), order="F")
            seen = pose.rotation().unrotate(speed, way, own) + np.cross(rate, ARM)
            back = body.rotation().matrix().T
            value = back @ seen - given.velocity_m_s[0]
            by_pose[:, :3], by_speed, by_bias[:, 3:] = back @ way, back @ own, back @ across
        else:
            one, two = np.zeros((6, 6), order="F"), np.zeros((6, 6), order="F")
            if kind == "pose":
                seen, measured = pose.compose(body, one, two), given.world_T_body[0]
            else:
                before = values.atPose3(keys(1).pose)
                start = before.compose(body, one, two)
                first = one.copy()
                end = pose.compose(body, one, two)
                own = one.copy()
                seen, measured = start.between(end, one, two), given.earlier_T_body[0]
                by_earlier, one = one @ first, two @ own
            by_here = np.zeros((6, 6), order="F")
            apart = as_pose(measured).between(seen, np.zeros((6, 6), order="F"), by_here)
            by_log = np.zeros((6, 6), order="F")
            value = gtsam.Pose3.Logmap(apart, by_log)
            by_pose, by_earlier = by_log @ by_here @ one, by_log @ by_here @ by_earlier
        if jacobians is not None:
            blocks = [by_pose, by_speed, by_bias, by_earlier]
            for k in range(len(jacobians)):
                jacobians[k] = np.asfortranarray(blocks[k])
        return value

    names = [node.pose, node.velocity, node.bias]
    if given.since_ns is not None:
        names.append(keys(1).pose)
    return gtsam.CustomFactor(model, names, error)


@pytest.mark.parametrize("kind", KINDS)
def test_residual_and_derivatives_are_gtsams(kind, rng):
    """At twenty states each, some deviations from what is measured."""
    shared = SharedUnknowns(Motor.identity(), 0.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(20):
        poses, stamps = Motor.random(rng, (2,)), np.array([0, 50_000_000])
        path = Along(stamps, poses, rng.standard_normal((2, 3)), rng.standard_normal((2, 3)))
        given = measured_along(kind, path, rng)
        relative = given.since_ns is not None
        where = 1 if relative else 0
        bias, reading = 0.1 * rng.standard_normal(6), path.rate_rad_s[where]
        values = gtsam.Values()
        near = poses @ Motor.from_twist(0.01 * rng.standard_normal((2, 6)))
        values.insert(keys(0).pose, as_pose(near[where]))
        values.insert(keys(1).pose, as_pose(near[0]))
        values.insert(keys(0).velocity, path.velocity_m_s[where] + 0.1)
        values.insert(keys(0).bias, gtsam.imuBias.ConstantBias(bias[3:], bias[:3]))
        ours = KindFactor(given, 0, 0, 0, 1 if relative else None, reading, shared)
        theirs = by_gtsam(kind, given, reading)
        own = ours.measurements.residual(0, ours.state(values))
        axes = axes_of(kind)
        np.testing.assert_allclose(axes @ own, -theirs.unwhitenedError(values), atol=1e-9)
        blocks = dict(zip(ours.factor(np.inf).keys(), ours.blocks(values, ours.state(values)),
                          strict=True))  # fmt: skip
        spread = axes @ given.covariance[0] @ axes.T
        whitening = gtsam.noiseModel.Gaussian.Covariance(spread).R() @ axes
        found = theirs.linearize(values)
        width, first = {"x": 6, "v": 3, "b": 6}, 0
        for key in list(found.keys()):
            size = width[chr(gtsam.Symbol(key).chr())]
            expected = found.getA()[:, first : first + size]
            scale = np.abs(expected).max() + np.abs(whitening).max()
            np.testing.assert_allclose(
                whitening @ blocks[key] / scale, -expected / scale, atol=1e-6
            )
            first += size


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "relative_pose"])
def test_a_measurement_moves_the_filter_as_it_moves_gtsam(kind, rng):
    """One measurement at the start: posterior and correction of one step of Gauss and Newton.

    Speed is hardly known there: a turn that is not known well either would bend what speed makes.
    """
    covariance = 1e-4 * np.diag([1.0, 2.0, 1.5, 3.0, 1.0, 2.0])
    if kind.endswith("velocity"):
        covariance[:3] *= 1e-6
    start = Motor.random(rng)
    path = Along(
        np.array([0]), start.reshape(1) @ Motor.from_twist(0.01 * rng.standard_normal((1, 6))),
        np.zeros((1, 3)), 0.3 * np.ones((1, 3)),
    )  # fmt: skip
    given = measured_along(kind, path, rng)
    live = PoseFilter(ADIS16448, settings=FilterSettings(gate=1.0))
    live.imu(0, path.rate_rad_s[0], np.array([0.0, 0.0, 9.81]))
    live.pose(0, start, covariance)
    before = live.state
    live.measure(given)

    node, factors, values = keys(0), gtsam.GaussianFactorGraph(), gtsam.Values()
    values.insert(node.pose, as_pose(before.world_T_imu))
    values.insert(node.velocity, before.velocity_m_s)
    values.insert(node.bias, gtsam.imuBias.ConstantBias())
    # The filter's error in gtsam's: velocity in the world, the accelerometer's bias first.
    change = np.zeros((15, 15))
    change[:6, :6] = np.eye(6)
    change[6:9, 6:9] = before.world_T_imu.rotor.as_matrix()
    change[range(9, 15), [12, 13, 14, 9, 10, 11]] = 1.0
    information = np.linalg.inv(change @ before.covariance @ change.T)
    root, zero = np.linalg.cholesky(information).T, np.zeros(15)
    unit = gtsam.noiseModel.Unit.Create(15)
    factors.push_back(
        gtsam.JacobianFactor(
            node.pose, root[:, :6], node.velocity, root[:, 6:9], node.bias, root[:, 9:], zero, unit
        )
    )
    factors.push_back(by_gtsam(kind, given, path.rate_rad_s[0]).linearize(values))
    ordering = gtsam.Ordering()
    for key in (node.pose, node.velocity, node.bias):
        ordering.push_back(key)
    hessian, gradient = factors.hessian(ordering)
    posterior = np.linalg.inv(hessian)
    moved = np.linalg.solve(change, posterior @ gradient)
    sigma = np.sqrt(np.diag(before.covariance))
    apart = np.linalg.solve(change, np.linalg.solve(change, posterior).T) - live.state.covariance
    np.testing.assert_allclose(apart / np.outer(sigma, sigma), 0.0, atol=1e-6)
    found = (before.world_T_imu.inverse() @ live.state.world_T_imu).as_twist()
    np.testing.assert_allclose(found / sigma[:6], moved[:6] / sigma[:6], atol=1e-6)
    bias = np.concatenate([live.state.gyro_bias_rad_s, live.state.accel_bias_m_s2])
    np.testing.assert_allclose(bias / sigma[9:], moved[9:] / sigma[9:], atol=1e-6)
