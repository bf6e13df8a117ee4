"""The filter as a stream: any order of arrival, every kind of measurement, refusals, rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from motorcade.fusion.filter import FilterSettings, PoseFilter, fuse
from motorcade.fusion.filter.extended_pose import corrected, extended_pose
from motorcade.fusion.filter.settings import RestDetection
from motorcade.fusion.imu import ADIS16448, ImuStream
from motorcade.fusion.measurements import PositionMeasurements
from motorcade.fusion.measurements.positions import VelocityMeasurements
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.measurements import PoseMeasurements

CAMERA = Camera(752, 480, 460.0, 457.0, 367.0, 248.0, "radtan", (-0.28, 0.07, 2e-4, 2e-5))
GRAVITY = np.array([0.0, 0.0, 9.81])


def fed(run, arrivals, **options) -> PoseFilter:
    """A filter fed with a recording: `arrivals` are (time of arrival, index of measurement)."""
    stream = PoseFilter(run.noise, run.imu_T_camera, **options)
    path, waiting = run.measurements.trajectory, sorted(arrivals)
    for time_ns, rate, force in zip(
        run.imu.time_ns.tolist(),
        run.imu.angular_rate_rad_s,
        run.imu.specific_force_m_s2,
        strict=True,
    ):
        stream.imu(time_ns, rate, force)
        while waiting and waiting[0][0] <= time_ns:
            k = waiting.pop(0)[1]
            stream.camera_pose(int(path.time_ns[k]), path.motors[k], run.measurements.covariance[k])
    return stream


def on_time(run) -> list[tuple[int, int]]:
    return [(int(t), k) for k, t in enumerate(run.measurements.trajectory.time_ns)]


def check_same(one: PoseFilter, other: PoseFilter) -> None:
    for name in ("velocity_m_s", "gyro_bias_rad_s", "accel_bias_m_s2", "covariance"):
        a, b = (getattr(stream.state, name) for stream in (one, other))
        assert a.tobytes() == b.tobytes(), name
    a, b = (stream.state.world_T_imu.coefficients for stream in (one, other))
    assert a.tobytes() == b.tobytes()


# Order of arrival -------------------------------------------------------------------------------


def test_a_stream_ends_where_the_recording_does(record, rng):
    run = record(rng, 3.0)
    stream = fed(run, on_time(run))
    batch = fuse(
        run.measurements, run.imu, run.noise, run.imu_T_camera, run.imu.time_ns[-1:], smoothed=False
    )
    assert stream.state.time_ns == run.imu.time_ns[-1]
    apart = (stream.state.world_T_camera.inverse() @ batch.trajectory.poses[0]).as_twist()
    np.testing.assert_allclose(apart, 0.0, atol=1e-14)
    np.testing.assert_array_equal(stream.state.covariance, batch.state_covariance[0])
    np.testing.assert_array_equal(stream.state.velocity_m_s, batch.velocity_m_s[0])


def test_the_order_of_arrival_changes_nothing(record, rng):
    """Delays of up to half a second, so that measurements overtake each other."""
    run = record(rng, 4.0)
    delays = rng.integers(0, 500_000_000, len(run.measurements))
    delays[0] = delays[-10:] = 0  # it starts with the first, and the last must arrive at all
    late = [(t + int(delay), k) for (t, k), delay in zip(on_time(run), delays, strict=True)]
    assert [k for _, k in sorted(late)] != list(range(len(late)))
    check_same(fed(run, late), fed(run, on_time(run)))


def test_measurements_ahead_of_the_inertial_data_wait(record, rng):
    run = record(rng, 2.0)
    early = [(max(t - 60_000_000, int(run.imu.time_ns[0])), k) for t, k in on_time(run)]
    check_same(fed(run, early), fed(run, on_time(run)))


def test_what_comes_too_late_or_from_before_the_start_is_refused(record, rng):
    run = record(rng, 4.0)
    pose, covariance = run.measurements.trajectory.motors[0], run.measurements.covariance[0]
    fresh = PoseFilter(run.noise, run.imu_T_camera)
    with pytest.raises(ValueError, match="expected inertial data before measurements"):
        fresh.camera_pose(int(run.imu.time_ns[0]), pose, covariance)
    fresh.imu(1000, np.zeros(3), GRAVITY)
    with pytest.raises(ValueError, match="expected a stamp from 1000 on, where inertial data"):
        fresh.camera_pose(999, pose, covariance)
    with pytest.raises(ValueError, match="expected a measured pose to start from"):
        fresh.measure(VelocityMeasurements.zero(np.array([1000]), 1.0))
    assert fresh.state is None
    assert fresh.innovations == ()
    fresh.imu(3000, np.zeros(3), GRAVITY)
    fresh.camera_pose(2000, pose, covariance)
    with pytest.raises(ValueError, match="expected a stamp from the start at 2000 on, got 1500"):
        fresh.camera_pose(1500, pose, covariance)
    stream = fed(run, on_time(run), history_s=0.5)
    before = stream.state.covariance
    with pytest.raises(ValueError, match="which the history holds"):
        stream.camera_pose(int(run.imu.time_ns[-1]) - 10**9, pose, covariance)
    assert stream.state.covariance.tobytes() == before.tobytes()
    for count in stream._engine.held()[:2]:
        assert count < 100  # of 400 samples, half a second and what lies between kept states


def test_without_its_extrinsics_nothing_of_a_camera_is_taken():
    """It is never taken for the identity: a pose of the IMU itself is another measurement."""
    stream = PoseFilter(ADIS16448)
    stream.imu(0, np.zeros(3), GRAVITY)
    stream.pose(0, Motor.identity(), np.eye(6))
    one, seen = Motor.identity(), np.eye(6)
    for call in (
        lambda: stream.camera_pose(0, one, seen),
        lambda: stream.tag_pose(0, one, seen, one),
        lambda: stream.tag(0, [[367.0, 248.0]], [[0.0, 0.0, 1.0]], CAMERA),
    ):
        with pytest.raises(ValueError, match="imu_T_camera: expected the camera's pose on the IMU"):
            call()
    assert [found.kind for found in stream.innovations] == ["imu_pose"]


def test_bad_samples_are_refused_and_leave_the_filter_as_it_was(record, rng):
    run = record(rng, 1.0)
    stream = fed(run, on_time(run))
    before, last = stream.state, int(run.imu.time_ns[-1])
    for arguments, message in (
        ((last, np.zeros(3), GRAVITY), "imu: expected a stamp after"),
        ((last + 1, np.array([0.0, np.nan, 0.0]), GRAVITY), "imu: expected finite numbers"),
        ((last + 1, np.zeros(3), np.array([np.inf, 0.0, 0.0])), "imu: expected finite numbers"),
        ((last + 1, np.zeros(4), GRAVITY), "gyro: expected three numbers of float64"),
        ((last + 1, np.zeros(3), GRAVITY.astype(np.float32)), "accel: expected three numbers"),
    ):
        with pytest.raises(ValueError, match=message):
            stream.imu(*arguments)
    pose, covariance = Motor.identity(), np.eye(6)
    for call, message in (
        (lambda: stream.pose(last, pose, -covariance), "covariance: expected a symmetric positive"),
        (lambda: stream.pose(last, pose, np.eye(3)), "covariance: expected"),
        (lambda: stream.pose(last, pose, np.ones((2, 6, 6))), r"covariance: .* got \(2, 6, 6\)"),
        (lambda: stream.pose(last, Motor.identity((2,)), covariance), r"pose: .* got \(2,\)"),
        (lambda: stream.tag(last, np.zeros((5, 2)), np.zeros((5, 3)), CAMERA), "n from 1 to 4"),
        (lambda: stream.tag(last, [[0.0, 0.0]], [[0.0, 0.0, 1.0]], CAMERA, 0.0), "sigma_px"),
        (lambda: PoseFilter(run.noise, history_s=0.0), "history_s: expected"),
        (lambda: PoseFilter(run.noise, time_offset_s=np.nan), "time_offset_s: expected"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
    assert stream.state.time_ns == before.time_ns
    assert stream.state.covariance.tobytes() == before.covariance.tobytes()


# Kinds of measurements --------------------------------------------------------------------------

ARM = np.array([0.3, -0.2, 0.5])
TAG = np.array([[-0.3, 0.3, 0.0], [0.3, 0.3, 0.0], [0.3, -0.3, 0.0], [-0.3, -0.3, 0.0]])


def corners_of(world_T_camera: Motor) -> FloatArray:
    """A tag's corners in the world, two metres in front of a camera."""
    return world_T_camera.apply(TAG + np.array([0.1, -0.2, 2.0]))


def measured(kind: str, pose: Motor, velocity: FloatArray, extrinsics: Motor, points: FloatArray):
    """What is measured of each kind, as numbers whose differences are residuals."""
    if kind == "position":
        return pose.apply(ARM)
    if kind == "velocity":
        return velocity
    return CAMERA.project((pose @ extrinsics).inverse().apply(points)).ravel()


def offer(stream: PoseFilter, kind: str, time_ns: int, value: FloatArray, points: FloatArray):
    """Give a filter a measurement; its covariance."""
    size = value.size
    root = 0.01 * (np.eye(size) + 0.2 * np.ones((size, size)))
    if kind == "position":
        stream.measure(
            PositionMeasurements(
                time_ns=np.array([time_ns]),
                position_m=value[None],
                covariance=root @ root.T,
                arm_m=ARM,
            )
        )
    elif kind == "velocity":
        stream.measure(
            VelocityMeasurements(
                time_ns=np.array([time_ns]), velocity_m_s=value[None], covariance=root @ root.T
            )
        )
    else:
        stream.tag(time_ns, value.reshape(-1, 2), points, CAMERA, 0.7)
        return 0.49 * np.eye(size)
    return root @ root.T


@pytest.mark.parametrize("kind", ["position", "velocity", "corners"])
def test_an_update_is_bayes_rule_with_derivatives_by_differences(record, rng, kind):
    run = record(rng, 2.0)
    stream = fed(run, on_time(run), settings=FilterSettings(gate=1.0))
    before, time_ns = stream.state, int(run.imu.time_ns[-1])
    points = corners_of(before.world_T_camera)
    state = extended_pose(
        before.world_T_imu.rotor, before.world_T_imu.translation_m, before.velocity_m_s
    )

    def seen(error: FloatArray) -> FloatArray:
        moved = corrected(state, error)
        return measured(kind, moved[0], moved[1].translation_m, run.imu_T_camera, points)

    effect = np.stack([(seen(1e-5 * e) - seen(-1e-5 * e)) / 2e-5 for e in np.eye(15)], axis=-1)
    residual = 1e-4 * rng.standard_normal(len(effect))
    spread = offer(stream, kind, time_ns, seen(np.zeros(15)) + residual, points)
    weight = np.linalg.inv(spread)
    posterior = np.linalg.inv(np.linalg.inv(before.covariance) + effect.T @ weight @ effect)
    sigma = np.sqrt(np.diag(before.covariance))
    apart = (stream.state.covariance - posterior) / np.outer(sigma, sigma)
    np.testing.assert_allclose(apart, 0.0, atol=1e-5)
    change = posterior @ effect.T @ weight @ residual
    found = (before.world_T_imu.inverse() @ stream.state.world_T_imu).as_twist()
    np.testing.assert_allclose(found / sigma[:6], change[:6] / sigma[:6], atol=1e-5)
    total = effect @ before.covariance @ effect.T + spread
    assert stream.innovations[-1].nis == pytest.approx(
        residual @ np.linalg.solve(total, residual), rel=1e-3
    )
    assert stream.innovations[-1].freedom == len(residual)


def test_a_tags_pose_is_that_of_the_camera(record, rng):
    run = record(rng, 1.0)
    one, other = (fed(run, on_time(run)) for _ in range(2))
    time_ns, tag = int(run.imu.time_ns[-1]), Motor.from_twist(rng.standard_normal(6))
    camera = one.state.world_T_camera @ Motor.from_twist(0.01 * rng.standard_normal(6))
    root = 0.01 * rng.standard_normal((6, 6))
    one.tag_pose(time_ns, camera.inverse() @ tag, root @ root.T, tag)
    # By sampling small errors on the right of the tag's pose.
    errors = 1e-3 * rng.standard_normal((4000, 6)) @ root.T
    moved = tag @ (camera.inverse() @ tag @ Motor.from_twist(errors)).inverse()
    twists = 1e3 * (camera.inverse() @ moved).as_twist()
    other.camera_pose(time_ns, camera, twists.T @ twists / len(twists))
    np.testing.assert_allclose(
        np.sqrt(np.diag(one.state.covariance)), np.sqrt(np.diag(other.state.covariance)), rtol=0.05
    )


@pytest.mark.parametrize("kind", ["position", "velocity", "corners"])
def test_innovations_of_every_kind_are_honest(record, rng, kind):
    """One pose to start from, then only measurements of one kind: their mean NIS is their size."""
    nis: list[float] = []
    size = 0
    for seed in range(3):
        run = record(np.random.default_rng(seed), 6.0)
        stream = PoseFilter(run.noise, run.imu_T_camera, settings=FilterSettings(gate=1.0))
        camera, points = run.camera, corners_of(run.camera.poses[0])
        for k, time_ns in enumerate(run.imu.time_ns.tolist()):
            stream.imu(time_ns, run.imu.angular_rate_rad_s[k], run.imu.specific_force_m_s2[k])
            if k == 0:
                stream.camera_pose(
                    time_ns, run.measurements.trajectory.motors[0], run.measurements.covariance[0]
                )
            elif k % 10 == 0:
                if kind == "corners":
                    points = corners_of(camera.poses[k])
                true = measured(
                    kind, run.truth.motors[k], run.velocity_m_s[k], run.imu_T_camera, points
                )
                size = true.size
                root = 0.01 * (np.eye(size) + 0.2 * np.ones((size, size)))
                scale = 0.7 * np.eye(size) if kind == "corners" else root
                offer(stream, kind, time_ns, true + scale @ rng.standard_normal(size), points)
        known = [one.nis for one in stream.innovations if one.kind == kind]
        nis += known[5:]  # linearised far off at first
    low, high = chi2.ppf([0.0005, 0.9995], size * len(nis)) / len(nis)
    assert low < np.mean(nis) < high


# In need ----------------------------------------------------------------------------------------


def test_a_wrong_start_is_given_up(record, rng):
    """The first pose is an outlier: live five more are left out, looking back only the first."""
    run = record(rng, 4.0)
    poses = run.measurements.trajectory.poses.coefficients.copy()
    poses[0] = (
        run.measurements.trajectory.motors[0] @ Motor.from_twist([0.5, 0.0, 0.3, 1.0, 0.0, -0.8])
    ).coefficients
    path = replace(run.measurements.trajectory, poses=Motor(poses))
    fused = fuse(
        PoseMeasurements(path, run.measurements.covariance), run.imu, run.noise, run.imu_T_camera
    )
    np.testing.assert_array_equal(np.flatnonzero(~fused.accepted), [0])
    apart = (fused.trajectory.poses.inverse() @ run.camera.at(path.time_ns)).as_twist()
    sigma = np.sqrt(np.diagonal(fused.covariance, axis1=1, axis2=2))
    assert np.max(np.abs(apart) / sigma) < 5.0
    assert np.max(np.abs(apart[0, 3:])) < 0.04


def test_outliers_that_contradict_each_other_never_win(record, rng):
    """Thirty wrong poses in a row, each elsewhere: the prediction is kept through all of them."""
    run = record(rng, 8.0)
    coefficients = run.measurements.trajectory.poses.coefficients.copy()
    bad = slice(80, 110)
    errors = rng.standard_normal((30, 6)) * np.repeat([0.5, 1.0], 3)
    coefficients[bad] = (
        run.measurements.trajectory.motors[bad] @ Motor.from_twist(errors)
    ).coefficients
    path = replace(run.measurements.trajectory, poses=Motor(coefficients))
    wrong = PoseMeasurements(path, run.measurements.covariance)
    for smoothed in (False, True):
        fused = fuse(wrong, run.imu, run.noise, run.imu_T_camera, smoothed=smoothed)
        left_out = np.flatnonzero(~fused.accepted)
        np.testing.assert_array_equal(left_out, np.arange(80, 110))


def test_a_fifth_of_outliers_and_a_wrong_start_are_left_behind(record):
    """No seed runs away, however the outliers fall; a wrong start may cost the first second."""
    for seed in range(8):
        rng = np.random.default_rng(seed)
        run = record(rng, 10.0)
        path = run.measurements.trajectory
        bad = rng.random(len(path)) < 0.2
        bad[0] = seed % 2 == 0
        errors = rng.standard_normal((len(path), 6)) * np.repeat([0.5, 1.0], 3)
        off = Motor.from_twist(np.where(bad[:, None], errors, 0.0))
        wrong = PoseMeasurements(path.transformed_by(right=off), run.measurements.covariance)
        fused = fuse(wrong, run.imu, run.noise, run.imu_T_camera)
        apart = (fused.trajectory.poses.inverse() @ run.camera.at(path.time_ns)).as_twist()
        assert np.max(np.abs(apart[20:, :3])) < np.deg2rad(2.0)
        assert np.max(np.abs(apart[20:, 3:])) < 0.05
        assert np.mean(fused.accepted == ~bad) > 0.95


def test_a_gap_in_the_samples_is_owned_up_to(record, rng):
    """Half a second without inertial data: uncertain by what the settings say, and honest."""
    run = record(rng, 6.0)
    stamps = run.imu.time_ns
    seconds = (stamps - stamps[0]) * 1e-9
    kept = (seconds < 3.0) | (seconds > 3.5)
    with_gap = ImuStream(
        stamps[kept], run.imu.angular_rate_rad_s[kept], run.imu.specific_force_m_s2[kept]
    )
    seen = (run.measurements.trajectory.time_s < 3.0) | (run.measurements.trajectory.time_s > 3.5)
    rest = PoseMeasurements(run.measurements.trajectory[seen], run.measurements.covariance[seen])
    at = stamps[[299, 345]]
    fused = fuse(rest, with_gap, run.noise, run.imu_T_camera, at, smoothed=False)
    whole = fuse(rest, run.imu, run.noise, run.imu_T_camera, at, smoothed=False)
    sigma, known = (
        np.sqrt(np.diagonal(one.state_covariance, axis1=1, axis2=2)) for one in (fused, whole)
    )
    np.testing.assert_allclose(sigma[0], known[0])
    assert np.all(sigma[1, :3] > 0.3)
    assert np.all(sigma[1, :3] > 5.0 * known[1, :3])
    apart = (fused.trajectory.poses.inverse() @ run.camera.at(at)).as_twist()[1]
    assert np.all(np.abs(apart) < 4.0 * np.sqrt(np.diag(fused.covariance[1])))
    after = fuse(rest, with_gap, run.noise, run.imu_T_camera)
    assert np.all(after.accepted)


def still(seconds: float, rng: np.random.Generator, rate_hz: float = 200.0) -> ImuStream:
    """A sensor at rest, tilted, with biases and noise."""
    count = round(seconds * rate_hz)
    stamps = np.round(np.arange(count) * 1e9 / rate_hz).astype(np.int64)
    white = rng.standard_normal((2, count, 3)) * np.sqrt(rate_hz)
    up = Motor.from_twist([0.3, -0.2, 0.0, 0.0, 0.0, 0.0]).rotor.inverse().apply(GRAVITY)
    return ImuStream(stamps, 2e-4 * white[0] + 0.01, up + 2e-3 * white[1] + 0.02)


@pytest.mark.parametrize("rest", [None, RestDetection()])
def test_a_sensor_at_rest_stays_there_where_rest_is_told(rng, rest):
    """After one second of poses only inertial data: without zero velocities it drifts off."""
    imu = still(20.0, rng)
    pose = Motor.from_twist([0.3, -0.2, 0.0, 0.0, 0.0, 0.0])
    stream = PoseFilter(ADIS16448, settings=FilterSettings(rest=rest))
    for k, time_ns in enumerate(imu.time_ns.tolist()):
        stream.imu(time_ns, imu.angular_rate_rad_s[k], imu.specific_force_m_s2[k])
        if time_ns <= 10**9 and k % 10 == 0:
            stream.pose(time_ns, pose, 1e-6 * np.eye(6))
    speed, place = np.linalg.norm(stream.state.velocity_m_s), stream.state.world_T_imu
    off = np.linalg.norm(place.translation_m)
    if rest is None:
        assert off > 0.1
    else:
        assert speed < 0.01
        assert off < 0.05
        told = [one for one in stream.innovations if one.kind == "velocity"]
        assert len(told) > 10
        assert np.mean([one.nis for one in told]) < 3.0


def test_motion_is_not_taken_for_rest(record, rng):
    run = record(rng, 5.0)
    stream = fed(run, on_time(run), settings=FilterSettings(rest=RestDetection()), history_s=10.0)
    assert {one.kind for one in stream.innovations} == {"camera_pose"}
