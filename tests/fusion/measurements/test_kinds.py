"""Kinds of measurements: derivatives, refusals, and what filter and smoother make of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.filter import FilterSettings, PoseFilter, fuse
from motorcade.fusion.measurements import (
    Measurements,
    PositionMeasurements,
    RelativePoseMeasurements,
    jacobian_error,
)
from motorcade.fusion.measurements.interface import PredictedState, numerical_jacobian
from motorcade.fusion.measurements.positions import AltitudeMeasurements, VelocityMeasurements
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.measurements import PoseMeasurements
from tests.fusion.measurements.along import KINDS, Along, measured_along

Record = Callable[..., Any]


@dataclass(frozen=True, eq=False)
class Range(Measurements):
    """A kind of a user's own, without a derivative: how far a beacon is."""

    time_ns: IntArray
    covariance: FloatArray
    range_m: FloatArray
    beacon_m: FloatArray
    name = "range"

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        return np.array([self.range_m[row] - np.linalg.norm(state.position_m - self.beacon_m)])


def some(kind: str, rng: np.random.Generator) -> Measurements:
    """Three measurements of a kind, along a path that turns."""
    stamps = 50_000_000 * np.arange(4)
    path = Along(
        stamps, Motor.random(rng, (4,)), rng.standard_normal((4, 3)), rng.standard_normal((4, 3))
    )
    return measured_along(kind, path, rng)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_are_those_of_differences(kind, rng):
    given = some(kind, rng)
    assert jacobian_error(given, rng) < 1e-7


def test_a_wrong_derivative_shows(rng):
    class Wrong(PositionMeasurements):
        def jacobian(self, row: int, state: PredictedState) -> FloatArray:
            return -super().jacobian(row, state)

    given = Wrong(time_ns=np.array([0]), position_m=np.zeros((1, 3)), covariance=np.eye(3))
    assert jacobian_error(given, rng) > 0.1


def test_the_errors_of_a_state_are_those_of_the_filter(rng):
    """`PredictedState.retract` is the extended pose's own, to first order."""
    from motorcade.fusion.filter.extended_pose import corrected, extended_pose

    state = PredictedState.random(rng)
    error = np.zeros(30)
    error[:15] = 1e-5 * rng.standard_normal(15)
    pose = state.world_T_imu
    both = corrected(extended_pose(pose.rotor, pose.translation_m, state.velocity_m_s), error[:15])
    found = state.retract(error)
    np.testing.assert_allclose(found.world_R_imu, both[0].rotor.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(found.position_m, both[0].translation_m, atol=1e-9)
    np.testing.assert_allclose(found.velocity_m_s, both[1].translation_m, atol=1e-9)


# In the filter ----------------------------------------------------------------------------------


def sparse(run: Any) -> Any:
    """A recording with the camera poses of its first half second, and few later ones."""
    given = run.measurements
    kept = np.arange(len(given))
    kept = kept[(kept < 10) | (kept % 40 == 0)]
    return replace(
        run, measurements=PoseMeasurements(given.trajectory[kept], given.covariance[kept])
    )


def measured(kind: str, run: Any, rng: np.random.Generator, every: int = 10) -> Measurements:
    rate = run.imu.angular_rate_rad_s - run.gyro_bias
    path = Along(run.truth.time_ns, run.truth.motors, run.velocity_m_s, rate)
    return measured_along(kind, path[::every], rng)


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_makes_a_path_surer_and_its_innovations_are_honest(record: Record, rng, kind):
    run = sparse(record(rng, 6.0))
    given = measured(kind, run, rng)
    stamps = run.imu.time_ns[::10]
    plain = run.fuse(stamps_ns=stamps)
    fused = run.fuse(stamps_ns=stamps, also=[given], settings=FilterSettings(gate=1.0))
    size = given.covariance.shape[-1]
    assert np.trace(fused.covariance.sum(axis=0)) < 0.999 * np.trace(plain.covariance.sum(axis=0))
    (found,) = fused.also
    assert found.name == given.name
    assert np.all(found.accepted)
    nis = found.nis[len(found.nis) // 5 :]
    spread = size * np.sqrt(2.0 / size / len(nis))
    assert abs(np.mean(nis) - size) < 5.0 * spread


@pytest.mark.parametrize("kind", KINDS)
def test_a_stream_ends_where_the_recording_does(record: Record, rng, kind):
    """The same kinds live: in any order, to the last bit."""
    run = sparse(record(rng, 3.0))
    given = measured(kind, run, rng, 30)
    relative = given.since_ns is not None
    batch = run.fuse(also=[given], stamps_ns=run.imu.time_ns[-1:], smoothed=False)
    live = PoseFilter(run.noise, run.imu_T_camera, history_s=10.0, relative=relative)
    poses = run.measurements
    for k, time_ns in enumerate(run.imu.time_ns.tolist()):
        live.imu(time_ns, run.imu.angular_rate_rad_s[k], run.imu.specific_force_m_s2[k])
        if k == 0:
            live.camera_pose(time_ns, poses.trajectory.motors[0], poses.covariance[0])
    live.measure(given)
    for k in range(1, len(poses)):
        live.camera_pose(
            int(poses.trajectory.time_ns[k]), poses.trajectory.motors[k], poses.covariance[k]
        )
    assert live.state.covariance.tobytes() == batch.state_covariance[0].tobytes()
    assert {one.kind for one in live.innovations} == {"camera_pose", given.name}


def test_looking_back_makes_nothing_less_sure(record: Record, rng):
    run = record(rng, 1.0)
    given = measured("relative_pose", run, rng, 20)
    smoothed = run.fuse(also=[given])
    live = run.fuse(also=[given], smoothed=False)
    np.testing.assert_allclose(smoothed.covariance[-1], live.covariance[-1], rtol=1e-9, atol=1e-15)
    for name in ("covariance", "state_covariance"):
        known, before = getattr(smoothed, name), getattr(live, name)
        ratio = np.linalg.eigvals(np.linalg.solve(before, known)).real
        assert np.all((ratio > 0.0) & (ratio < 1.0 + 1e-6))
    assert smoothed.state_covariance.shape[1:] == (15, 15)


def test_a_kind_of_ones_own_goes_wherever_the_others_go(record: Record, rng):
    run = sparse(record(rng, 4.0))
    beacons = np.array([[5.0, 0.0, 0.0], [0.0, 5.0, 1.0], [-4.0, -4.0, 2.0], [0.0, 0.0, 6.0]])
    places, stamps = run.truth.motors.translation_m[::10], run.truth.time_ns[::10]
    ranges = []
    for beacon in beacons:
        true = np.linalg.norm(places - beacon, axis=-1)
        noisy = true + 0.01 * rng.standard_normal(len(true))
        ranges.append(Range(stamps, np.full((len(true), 1, 1), 1e-4), noisy, beacon))
    plain, fused = run.fuse(stamps_ns=stamps), run.fuse(stamps_ns=stamps, also=ranges)
    errors = [
        np.linalg.norm((one.trajectory.motors @ run.imu_T_camera.inverse()).translation_m - places,
                       axis=-1)
        for one in (plain, fused)
    ]  # fmt: skip
    assert np.mean(errors[1]) < 0.5 * np.mean(errors[0])
    state = PredictedState.random(rng)
    own = numerical_jacobian(ranges[0], 0, state)
    np.testing.assert_array_equal(ranges[0].jacobian(0, state), own)


def test_outliers_of_a_kind_are_left_out(record: Record, rng):
    run = record(rng, 4.0)
    given = measured("position", run, rng)
    wrong = np.arange(len(given)) % 7 == 3
    off = replace(given, position_m=given.position_m + np.where(wrong[:, None], 3.0, 0.0))
    (found,) = run.fuse(also=[off]).also
    np.testing.assert_array_equal(found.accepted, ~wrong)


def test_gaps_split_the_kinds_too(record: Record, rng):
    run = record(rng, 4.0)
    given = measured("velocity", run, rng)
    late = 30 * 10**9
    split = run.imu.time_ns > run.imu.time_ns[200]
    stream = replace(run.imu, time_ns=run.imu.time_ns + late * split)
    poses = run.measurements.trajectory
    moved = replace(poses, time_ns=poses.time_ns + late * (poses.time_ns > run.imu.time_ns[200]))
    shifted = replace(given, time_ns=given.time_ns + late * (given.time_ns > run.imu.time_ns[200]))
    fused = fuse(
        PoseMeasurements(moved, run.measurements.covariance),
        stream,
        run.noise,
        run.imu_T_camera,
        also=[shifted],
    )
    (found,) = fused.also
    assert len(found.nis) == len(given)
    assert np.sum(np.isnan(found.nis)) <= 1  # between the last pose's segment and the next
    assert np.mean(found.accepted) > 0.9


# Refusals ---------------------------------------------------------------------------------------


class Broken(AltitudeMeasurements):
    """A kind whose author forgot a dimension."""

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        return np.zeros(2)


class Lost(AltitudeMeasurements):
    """A kind that raises."""

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        raise KeyError("no such map")


def test_faults_of_a_kind_come_out_by_name(record: Record, rng):
    run = record(rng, 1.0)
    stamps = run.imu.time_ns[10:20]
    for wrong, error, says in (
        (Broken, ValueError, r"altitude measurements: expected a residual \(1,\)"),
        (Lost, KeyError, "no such map"),
    ):
        given = wrong(time_ns=stamps, altitude_m=np.zeros(10), covariance=1.0)
        with pytest.raises(error, match=says):
            run.fuse(also=[given])
    nowhere = AltitudeMeasurements(time_ns=stamps, altitude_m=np.full(10, 1e300), covariance=1.0)
    fused = run.fuse(also=[nowhere])
    assert not np.any(fused.also[0].accepted)


def test_bad_kinds_are_refused(record: Record, rng):
    run = record(rng, 1.0)
    stamps, zeros = run.imu.time_ns[:3], np.zeros((3, 3))
    good = VelocityMeasurements(time_ns=stamps, velocity_m_s=zeros, covariance=np.eye(3))
    step = Motor.identity((2,))
    overlapping = RelativePoseMeasurements(
        earlier_ns=stamps[0] + np.array([0, 100]), time_ns=stamps[0] + np.array([200, 300]),
        earlier_T_body=step, covariance=np.eye(6),
    )  # fmt: skip
    backwards = replace(overlapping, earlier_ns=overlapping.time_ns + 1)
    for given, error, says in (
        (3.0, TypeError, "also: expected kinds of measurements, got float"),
        (replace(good, time_ns=stamps[::-1]), ValueError, "velocity measurements: time_ns"),
        (replace(good, covariance=-np.eye(3)), ValueError, "positive definite"),
        (overlapping, ValueError, "steps that do not overlap"),
        (backwards, ValueError, "before time_ns"),
    ):
        with pytest.raises(error, match=says):
            run.fuse(also=[given])
    for make, says in (
        (lambda: replace(good, velocity_m_s=np.zeros((2, 3))), "velocity_m_s: expected shape"),
        (lambda: replace(good, covariance=np.eye(2)), "covariance: expected"),
        (lambda: replace(good, time_ns=stamps * 1e-9), "time_ns: expected integer"),
        (lambda: replace(good, arm_m=np.array([np.nan, 0.0, 0.0])), "arm_m"),
        (lambda: VelocityMeasurements.zero(stamps, 0.0), "sigma_m_s"),
    ):
        with pytest.raises(ValueError, match=says):
            make()


def test_a_live_filter_says_what_it_cannot_relate():
    live = PoseFilter(run_noise())
    step = RelativePoseMeasurements(
        earlier_ns=np.array([0]), time_ns=np.array([10]), earlier_T_body=Motor.identity((1,)),
        covariance=np.eye(6),
    )  # fmt: skip
    with pytest.raises(ValueError, match="relative=True"):
        live.measure(step)
    live = PoseFilter(run_noise(), relative=True)
    live.imu(0, np.zeros(3), np.array([0.0, 0.0, 9.81]))
    live.pose(0, Motor.identity(), np.eye(6))
    live.imu(100, np.zeros(3), np.array([0.0, 0.0, 9.81]))
    live.measure(step)
    with pytest.raises(ValueError, match="do not overlap"):
        live.measure(replace(step, earlier_ns=np.array([5]), time_ns=np.array([20])))


def run_noise() -> Any:
    from motorcade.fusion.imu import ADIS16448

    return ADIS16448
