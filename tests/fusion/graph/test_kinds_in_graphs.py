"""Other kinds of measurements in the graph, and what it estimates besides the motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.filter import FilterSettings, Fused
from motorcade.fusion.graph import fuse_by_graph
from motorcade.fusion.imu import ImuStream
from motorcade.fusion.measurements import Measurements, RelativePoseMeasurements
from motorcade.ga import Motor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements
from tests.fusion.measurements.along import KINDS, Along, measured_along

Record = Callable[..., Any]
OPEN = FilterSettings(gate=1.0)  # nothing weighed down


def by_graph(run: Any, **options: Any) -> Fused:
    return fuse_by_graph(run.measurements, run.imu, run.noise, run.imu_T_camera, **options)


def sparse(run: Any) -> Any:
    """A recording with the camera poses of its first half second, and few later ones."""
    given = run.measurements
    kept = np.arange(len(given))
    kept = kept[(kept < 10) | (kept % 40 == 0)]
    return replace(
        run, measurements=PoseMeasurements(given.trajectory[kept], given.covariance[kept])
    )


def measured(kind: str, run: Any, rng: np.random.Generator, every: int) -> Measurements:
    rate = run.imu.angular_rate_rad_s - run.gyro_bias
    path = Along(run.truth.time_ns, run.truth.motors, run.velocity_m_s, rate)
    # Not at the first pose, which tells no speed: there the filter weighs down what that bends.
    return measured_along(kind, path[every::every], rng)


def check_same(by_filter: Fused, batch: Fused, share: float) -> None:
    """Poses less than one deviation apart, deviations equal but for a share."""
    apart = (by_filter.trajectory.poses.inverse() @ batch.trajectory.poses).as_twist()
    sigma = np.sqrt(np.einsum("kii->ki", by_filter.covariance))
    assert np.max(np.abs(apart) / sigma) < 1.0
    assert np.sqrt(np.mean((apart / sigma) ** 2)) < 0.3
    ratio = np.einsum("kii->ki", batch.covariance) / np.einsum("kii->ki", by_filter.covariance)
    np.testing.assert_allclose(np.sqrt(ratio), 1.0, atol=share)


@pytest.mark.parametrize("kind", KINDS)
def test_the_graph_is_what_filter_and_backward_pass_come_to(record: Record, rng, kind):
    run = sparse(record(rng, 3.0))
    given = measured(kind, run, rng, 20)
    options = {"also": [given], "stamps_ns": run.imu.time_ns[::20]}
    by_filter, batch = run.fuse(**options, settings=OPEN), by_graph(run, **options, settings=OPEN)
    check_same(by_filter, batch, 0.05)
    (found,) = batch.also
    assert found.name == given.name
    assert np.all(found.accepted)


def test_outliers_of_a_kind_lose_their_weight(record: Record, rng):
    run = record(rng, 3.0)
    given = measured("position", run, rng, 20)
    wrong = np.arange(len(given)) % 5 == 3
    off = replace(given, position_m=given.position_m + np.where(wrong[:, None], 3.0, 0.0))
    found = by_graph(run, also=[off])
    np.testing.assert_array_equal(found.also[0].accepted, ~wrong)
    check_same(by_graph(run), found, 0.2)


def test_steps_may_overlap(record: Record, rng):
    """Keyframes' steps of half a second, a new one every tenth of a second."""
    run = sparse(record(rng, 3.0))
    path = run.truth
    rows = np.arange(0, len(path) - 50, 10)
    noise = Motor.from_twist(0.002 * rng.standard_normal((len(rows), 6)))
    steps = RelativePoseMeasurements(
        earlier_ns=path.time_ns[rows],
        time_ns=path.time_ns[rows + 50],
        earlier_T_body=path.motors[rows].inverse() @ path.motors[rows + 50] @ noise,
        covariance=0.002**2 * np.eye(6),
    )
    with pytest.raises(ValueError, match="fuse_by_graph takes such"):
        run.fuse(also=[steps])
    stamps = path.time_ns[::10]
    plain, found = by_graph(run, stamps_ns=stamps), by_graph(run, stamps_ns=stamps, also=[steps])
    errors = [
        np.linalg.norm((one.trajectory.poses.inverse() @ run.camera.at(stamps)).as_twist()[:, 3:])
        for one in (plain, found)
    ]
    assert errors[1] < 0.6 * errors[0]


# What else it estimates -------------------------------------------------------------------------


def turned(run: Any, turn: Motor) -> Any:
    """The recording in a world that is turned: its z no longer points up."""
    given = run.measurements
    poses = replace(given.trajectory, poses=turn @ given.trajectory.motors)
    return replace(run, measurements=PoseMeasurements(poses, given.covariance))


def test_it_finds_gravity_extrinsics_and_offset(record: Record, rng):
    """Poses are the filter's; what is shared it knows better than the filter, which linearises
    once and takes itself for surer than it is.
    """
    run = record(rng, 5.0)
    tilt = Motor.from_twist([0.03, -0.02, 0.0, 0.0, 0.0, 0.0])
    off = Motor.from_twist([0.01, -0.02, 0.015, 0.01, 0.02, -0.01])
    late_ns = 4_000_000
    moved = turned(replace(run, imu_T_camera=run.imu_T_camera @ off), tilt)
    path = moved.measurements.trajectory
    poses = PoseMeasurements(
        Trajectory(path.time_ns - late_ns, path.motors)[1:], moved.measurements.covariance[1:]
    )
    moved = replace(moved, measurements=poses)
    settings = FilterSettings(
        gate=1.0,
        gravity_sigma_rad=0.05,
        extrinsics_sigma_rad=0.03,
        extrinsics_sigma_m=0.03,
        time_offset_sigma_s=0.01,
    )
    by_filter, batch = moved.fuse(settings=settings), by_graph(moved, settings=settings)
    check_same(by_filter, batch, 0.15)
    last = batch.state_covariance[-1]
    sigma = np.sqrt(np.diag(last)[15:24])
    true = tilt.rotor.apply(np.array([0.0, 0.0, -9.81]))
    lean = np.cross(batch.gravity_m_s2[-1], true) / 9.81**2
    assert np.all(np.abs(lean[:2]) < 4.0 * sigma[:2])
    extrinsics = batch.imu_T_camera[-1].local(run.imu_T_camera)
    assert np.all(np.abs(extrinsics) < 4.0 * sigma[2:8])
    assert abs(batch.time_offset_s[-1] - 1e-9 * late_ns) < 4.0 * sigma[8]
    assert sigma[8] < 2e-3  # of 10 ms
    for name in ("gravity_m_s2", "time_offset_s"):
        assert np.ptp(getattr(batch, name), axis=0).max() == 0.0


def test_kinds_and_gravity_go_together(record: Record, rng):
    run = record(rng, 3.0)
    stream = ImuStream(run.imu.time_ns, run.imu.angular_rate_rad_s, run.imu.specific_force_m_s2)
    tilt = Motor.from_twist([0.03, -0.02, 0.0, 0.0, 0.0, 0.0])
    path = Along(
        run.truth.time_ns,
        tilt @ run.truth.motors,
        tilt.rotor.apply(run.velocity_m_s),
        run.imu.angular_rate_rad_s - run.gyro_bias,
    )[::20]
    given = [measured_along(kind, path, rng) for kind in ("velocity", "relative_pose", "heading")]
    moved = replace(turned(sparse(run), tilt), imu=stream)
    settings = FilterSettings(gate=1.0, gravity_sigma_rad=0.05)
    options = {"also": given, "stamps_ns": path.time_ns, "settings": settings}
    check_same(moved.fuse(**options), by_graph(moved, **options), 0.1)
