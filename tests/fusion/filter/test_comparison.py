"""The filter in other coordinates: in those of motors it is `fuse`, the others are right too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.fusion.filter import FilterSettings, Fused, fuse
from motorcade.fusion.filter.comparison import (
    EulerErrors,
    ExactEulerErrors,
    ExtendedPoseErrors,
    QuaternionTranslationErrors,
    Runs,
    RunStates,
    filter_runs,
)
from motorcade.fusion.imu import ImuNoise, ImuStream
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements

ALL = (QuaternionTranslationErrors(), EulerErrors(), ExactEulerErrors())
# Of the recordings that the fixture `record` simulates.
NOISE = ImuNoise(2e-3, 2e-4, 2e-2, 3e-3)
Recorded = list[tuple[PoseMeasurements, ImuStream]]
TILT_RAD = np.deg2rad(5.0)


@pytest.fixture
def recorded(record):
    """Three runs of a recording, some of their poses off, a little or far."""

    def make(duration_s: float = 4.0, degraded: bool = True) -> Recorded:
        made, rng = [], np.random.default_rng(11)
        for i in range(3):
            one = record(np.random.default_rng(i), duration_s)
            off = np.zeros((len(one.measurements), 6))
            if degraded:
                off[10::9] = 0.05 * rng.standard_normal(off[10::9].shape)
                off[14::13] = rng.standard_normal(off[14::13].shape)
            turned = one.imu_T_camera.inverse() @ Motor.from_twist(off)
            path = one.measurements.trajectory.transformed_by(right=turned, child="imu")
            made.append((PoseMeasurements(path, one.measurements.covariance), one.imu))
        return made

    return make


def test_in_the_coordinates_of_motors_it_is_fuse(recorded):
    """Outliers, weighed down and left out, and a wrong start included: to 1e-4 of a deviation."""
    runs = recorded()
    settings = FilterSettings(initial_tilt_error_rad=TILT_RAD)
    found = filter_runs(Runs.of(runs), NOISE, ExtendedPoseErrors(), settings)
    assert np.count_nonzero(~found.accepted) > 10
    for i, (measured, imu) in enumerate(runs):
        one = fuse(measured, imu, NOISE, Motor.identity(), settings=settings, smoothed=False)
        np.testing.assert_array_equal(one.accepted, found.accepted[i])
        np.testing.assert_allclose(found.nis[i], one.nis, rtol=1e-3)
        sigma = np.sqrt(np.diagonal(one.state_covariance, axis1=1, axis2=2))
        scale = sigma[:, :, None] * sigma[:, None]
        np.testing.assert_allclose(
            found.covariance[i] / scale, one.state_covariance / scale, atol=1e-4
        )
        apart = ExtendedPoseErrors().local(one_state(one), at(found.state, i))
        np.testing.assert_allclose(apart / sigma, 0.0, atol=1e-3)


def test_after_many_left_out_the_next_is_believed(recorded):
    """A tracker that restarts elsewhere is followed, its first poses left out."""
    runs = recorded(degraded=False)
    jump = Motor.from_twist(np.array([0.0, 0.0, 0.9, 2.0, -1.0, 0.5]))
    moved = []
    for measured, imu in runs:
        path, later = measured.trajectory, np.arange(len(measured)) >= 40
        poses = Motor.concatenate([path.motors[~later], jump @ path.motors[later]])
        path = Trajectory(path.time_ns, poses, path.parent, path.child)
        moved.append((PoseMeasurements(path, measured.covariance), imu))
    found = filter_runs(Runs.of(moved), NOISE, QuaternionTranslationErrors(), FilterSettings())
    left_out = np.flatnonzero(~found.accepted[0])
    np.testing.assert_array_equal(left_out, 40 + np.arange(5))
    shift = found.state.position_m - Runs.of(moved).world_T_imu.translation_m
    assert np.max(np.abs(shift[:, 60:])) < 0.06


def test_runs_are_of_one_experiment(recorded):
    runs = recorded()
    later = Trajectory(
        runs[0][0].trajectory.time_ns + 1, runs[0][0].trajectory.motors, "world", "imu"
    )
    with pytest.raises(ValueError, match="expected the same stamps and covariances in all runs"):
        Runs.of([runs[0], (PoseMeasurements(later, runs[0][0].covariance), runs[1][1])])
    with pytest.raises(ValueError, match="expected poses at stamps of inertial samples"):
        Runs.of([(PoseMeasurements(later, runs[0][0].covariance), runs[0][1])])


def one_state(one: Fused) -> RunStates:
    poses = one.trajectory.motors
    bias = np.concatenate([one.gyro_bias_rad_s, one.accel_bias_m_s2], axis=-1)
    return RunStates(poses.rotor, poses.translation_m, one.velocity_m_s, bias)


def at(state: RunStates, i: int) -> RunStates:
    return RunStates(state.rotor[i], state.position_m[i], state.velocity_m_s[i], state.bias[i])


@pytest.mark.parametrize("coordinates", ALL, ids=lambda one: type(one).__name__)
def test_they_agree_with_fuse_where_errors_are_small(recorded, coordinates):
    """Far from gimbal lock, once settled: to a small part of the deviation."""
    runs = recorded(6.0, degraded=False)
    found = filter_runs(Runs.of(runs), NOISE, coordinates, FilterSettings())
    for i, (measured, imu) in enumerate(runs):
        one = fuse(measured, imu, NOISE, Motor.identity(), smoothed=False)
        sigma_m = np.sqrt(np.diagonal(one.covariance, axis1=1, axis2=2)[:, 3:])
        apart_m = one.trajectory.motors.translation_m - found.state.position_m[i]
        assert np.max(np.abs(apart_m / sigma_m)[20:]) < 0.3
        apart = one.trajectory.motors.rotor.inverse() @ found.state.rotor[i]
        assert np.max(np.abs(apart.as_rotation_vector()[20:])) < np.deg2rad(0.15)


def some_states(rng, count=50) -> RunStates:
    rotor = Rotor.from_euler(rng.uniform([-3, -1.4, -3], [3, 1.4, 3], (count, 3)))
    return RunStates(rotor, *rng.standard_normal((2, count, 3)), rng.standard_normal((count, 6)))


@pytest.mark.parametrize(
    "coordinates", [*ALL, ExtendedPoseErrors()], ids=lambda one: type(one).__name__
)
def test_differences_undo_moves(coordinates, rng):
    state, error = some_states(rng), 0.1 * rng.standard_normal((50, 15))
    moved = coordinates.retract(state, error)
    np.testing.assert_allclose(coordinates.local(state, moved), error, atol=1e-12)


@pytest.mark.parametrize("coordinates", ALL, ids=lambda one: type(one).__name__)
def test_small_errors_of_motors_are_carried_into_the_coordinates(coordinates, rng):
    state, error = some_states(rng), 1e-6 * rng.standard_normal((50, 15))
    found = coordinates.local(state, ExtendedPoseErrors().retract(state, error))
    carried = (coordinates.from_body(state) @ error[..., None])[..., 0]
    np.testing.assert_allclose(found, carried, atol=3e-10)


def test_euler_angles_and_their_rates_are_scipys(rng):
    state = some_states(rng)
    body = Rotation.from_quat(state.rotor.as_quaternion(), scalar_first=True)
    turn = 1e-6 * rng.standard_normal((50, 3))
    before, after = (one.as_euler("XYZ") for one in (body, body * Rotation.from_rotvec(turn)))
    rates = (EulerErrors().rotation_from_body(state.rotor) @ turn[..., None])[..., 0]
    np.testing.assert_allclose(np.mod(after - before + 1, 2 * np.pi) - 1, rates, atol=1e-9)
    turned = EulerErrors().turned(state.rotor, turn).as_quaternion()
    again = Rotation.from_quat(turned, scalar_first=True)
    apart = (again.inv() * body * Rotation.from_rotvec(turn)).magnitude()
    assert np.max(apart) < 1e-9
