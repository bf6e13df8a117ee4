"""The batch rival: the same problem by gtsam's graph, beside filter and backward pass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.filter import FilterSettings, Fused, fuse
from motorcade.fusion.filter.settings import RestDetection
from motorcade.fusion.graph import fuse_by_graph
from motorcade.fusion.graph.inertial import InertialGraph, as_pose
from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.metrics import absolute_translation_m, rotation_rad
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.tracking.measurements import PoseMeasurements

Record = Callable[..., Any]


def by_graph(run: Any, **options: Any) -> Fused:
    return fuse_by_graph(run.measurements, run.imu, run.noise, run.imu_T_camera, **options)


def in_deviations(a: Fused, b: Fused) -> FloatArray:
    """How far apart two results are ``(N, 6)``, in deviations of the first."""
    apart = (a.trajectory.poses.inverse() @ b.trajectory.poses).as_twist()
    deviations: FloatArray = np.abs(apart) / np.sqrt(np.einsum("kii->ki", a.covariance))
    return deviations


def rms_errors(fused: Fused, truth: Trajectory) -> tuple[float, float]:
    """RMS of position (m) and rotation (deg)."""
    true = truth.at(fused.trajectory.time_ns)
    position = absolute_translation_m(fused.trajectory.poses, true)
    turn = np.rad2deg(rotation_rad(fused.trajectory.poses, true))
    return float(np.sqrt(np.mean(position**2))), float(np.sqrt(np.mean(turn**2)))


def with_wrong_poses(measurements: PoseMeasurements, wrong: FloatArray) -> PoseMeasurements:
    off = Motor.from_twist(np.where(wrong[:, None], [0.4, 0.0, 0.3, 0.0, 0.7, 0.0], 0.0))
    return PoseMeasurements(
        measurements.trajectory.transformed_by(right=off), measurements.covariance
    )


def test_the_batch_is_what_filter_and_backward_pass_come_to(record: Record, rng):
    """Two programs, one posterior: means a fraction of a deviation apart, deviations equal."""
    run = record(rng)
    by_filter, batch = run.fuse(), by_graph(run)
    assert np.max(in_deviations(by_filter, batch)) < 1.0
    ratio = np.sqrt(
        np.einsum("kii->ki", batch.state_covariance)
        / np.einsum("kii->ki", by_filter.state_covariance)
    )
    np.testing.assert_allclose(ratio, 1.0, atol=0.02)
    whitening = np.linalg.inv(np.linalg.cholesky(by_filter.state_covariance))
    both = whitening @ batch.state_covariance @ whitening.swapaxes(-1, -2)
    assert np.max(np.abs(both - np.eye(15))) < 0.1
    sigma = np.sqrt(np.einsum("kii->ki", by_filter.state_covariance))
    biases = np.concatenate(
        [
            batch.gyro_bias_rad_s - by_filter.gyro_bias_rad_s,
            batch.accel_bias_m_s2 - by_filter.accel_bias_m_s2,
        ],
        axis=-1,
    )
    assert np.max(np.abs(biases) / sigma[:, 9:]) < 1.0
    assert np.max(np.abs(batch.velocity_m_s - by_filter.velocity_m_s)) < np.max(sigma[:, 6:9])


def test_wrong_poses_leave_next_to_no_trace(record: Record, rng):
    run = record(rng, 5.0)
    wrong = np.arange(len(run.measurements)) % 10 == 7
    degraded = replace(run, measurements=with_wrong_poses(run.measurements, wrong))
    kept = run.measurements
    without = PoseMeasurements(kept.trajectory[~wrong], kept.covariance[~wrong])
    clean = by_graph(replace(run, measurements=without), stamps_ns=kept.trajectory.time_ns)
    found = by_graph(degraded)
    np.testing.assert_array_equal(found.accepted, ~wrong)
    assert np.max(in_deviations(clean, found)) < 0.3
    trusting = by_graph(degraded, settings=FilterSettings(gate=1.0))
    assert np.max(in_deviations(clean, trusting)) > 3.0


def test_darkness_is_bridged_as_the_filter_bridges_it(record: Record, rng):
    run = record(rng, 6.0)
    path = run.measurements.trajectory
    seen = (path.time_s < 3.0) | (path.time_s > 4.2)
    dark = replace(
        run, measurements=PoseMeasurements(path[seen], run.measurements.covariance[seen])
    )
    stamps = path.time_ns[~seen] + 1_234_567
    assert np.max(in_deviations(dark.fuse(stamps_ns=stamps), by_graph(dark, stamps_ns=stamps))) < 1


def test_it_returns_what_the_filter_returns(record: Record, rng):
    run = record(rng, 3.0)
    by_filter, batch = run.fuse(), by_graph(run)
    for name in Fused.__dataclass_fields__:
        own, other = getattr(batch, name), getattr(by_filter, name)
        own, other = (getattr(one, "coefficients", one) for one in (own, other))
        if name == "trajectory":
            np.testing.assert_array_equal(own.time_ns, other.time_ns)
            assert (own.parent, own.child) == (other.parent, other.child)
        elif name == "also":
            assert own == other == ()
        elif name not in ("health", "noise"):  # which the filter alone says
            assert own.shape == other.shape, name
    assert np.all(np.isnan(batch.nis))
    again = by_graph(run)
    np.testing.assert_array_equal(
        again.trajectory.motors.coefficients, batch.trajectory.motors.coefficients
    )


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"stamps_ns": np.array([1.0])}, "stamps_ns: expected rising"),
        ({"stamps_ns": np.array([5])}, "stamps_ns: expected some"),
        ({"settings": FilterSettings(rest=RestDetection())}, "settings"),
    ],
)
def test_bad_input_is_refused(record: Record, rng, options, says):
    with pytest.raises(ValueError, match=says):
        by_graph(record(rng, 1.0), **options)


def test_spans_that_do_not_overlap_are_refused(record: Record, rng):
    run = record(rng, 1.0)
    path = run.measurements.trajectory
    later = Trajectory(path.time_ns + 10**12, path.poses)
    with pytest.raises(ValueError, match="overlap"):
        by_graph(replace(run, measurements=PoseMeasurements(later, run.measurements.covariance)))


def test_on_a_real_flight_batch_and_filter_agree(data_dir: Path):
    """V1_02 with simulated poses, 2 % of them wrong, darkness of 2 s every 15 s."""
    imu = read_imu(data_dir / "imu" / "V102_imu.txt")
    truth = read_trajectory(data_dir / "imu" / "V1_02_medium.csv")
    rng = np.random.default_rng(4)
    given = simulate_camera_poses(truth, 20.0, 0.01, np.deg2rad(0.5), rng)
    given = with_wrong_poses(given, rng.random(len(given)) < 0.02)
    path, noise = given.trajectory, ADIS16448.scaled(8.0)
    seen = path.time_s % 15.0 < 13.0
    given = PoseMeasurements(path[seen], given.covariance[seen])
    extrinsics = Motor.identity()
    batch = fuse_by_graph(given, imu, noise, extrinsics, path.time_ns)
    by_filter = fuse(given, imu, noise, extrinsics, path.time_ns)
    assert np.max(in_deviations(by_filter, batch)) < 1.0
    error = absolute_translation_m(batch.trajectory.poses, truth.at(path.time_ns))
    assert np.sqrt(np.mean(error[seen] ** 2)) < 0.005
    assert np.max(error[~seen]) < 0.05


def test_gaps_that_leave_the_graph_singular_are_refused(tmp_path):
    from tests.end_to_end.gap_doors import FUNCTIONS
    from tests.end_to_end.gap_paths import Case, shapes

    case = Case.of(shapes(10**9)["a gap every 20 poses"], tmp_path / "case")
    with pytest.raises(ValueError, match="got a graph that is singular"):
        FUNCTIONS["fuse_by_graph"](case)


def test_forces_are_taken_in_the_axes_of_the_middle_of_a_step(handheld):
    """Gravity alone would otherwise err by half a step's rotation: 0.1 m/s² here."""
    import gtsam

    path = handheld.trajectory(100.0, 2.0, "imu")
    simulated = simulate_imu(path, 100.0, None, np.random.default_rng(0))
    stamps = simulated.path.time_ns[[20, 60]]
    motors = simulated.path.motors_at(stamps)
    seen = PoseMeasurements(Trajectory(stamps, motors), np.tile(1e-6 * np.eye(6), (2, 1, 1)))
    bias = np.array([0.3, -0.2, 0.4])
    imu = ImuStream(
        simulated.stream.time_ns,
        simulated.stream.angular_rate_rad_s + bias,
        simulated.stream.specific_force_m_s2,
    )
    graph = InertialGraph.of(seen, imu, ADIS16448, Motor.identity(), stamps, FilterSettings())
    known = gtsam.imuBias.ConstantBias(np.zeros(3), bias)
    start = gtsam.NavState(as_pose(motors[0]), simulated.velocity_m_s[20])
    there = graph.summed(1, known).predict(start, known)
    np.testing.assert_allclose(there.position(), motors[1].translation_m, atol=2e-4)
    np.testing.assert_allclose(there.velocity(), simulated.velocity_m_s[60], atol=5e-4)
