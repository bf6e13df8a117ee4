"""What the inertial stages do with worlds that lean, with clocks, and with odometry."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.filter.learning import LearntNoise
from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.metrics import absolute_translation_m, evaluate
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.recording import Odometry, Recording
from motorcade.replays.stages.camera import slam_poses
from motorcade.replays.stages.camera.slam_poses import NoMetres, in_metres
from motorcade.replays.stages.inertial.convergence import convergence
from motorcade.replays.stages.inertial.fused import fused
from motorcade.replays.stages.inertial.imu import imu
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.inertial import UsedImu
from motorcade.replays.stages.values.paths import FusedPath
from motorcade.tracking import Camera, PoseMeasurements
from motorcade.tracking.frame_history import SlamHistory
from motorcade.tracking.slam import MapSnapshot
from motorcade.tracking.slam.results import SlamResult
from tests.replays.stages.stamps import Stamps

IMU_T_CAMERA = Motor.from_euler_translation(
    np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07])
)
CAMERA = Camera(640, 480, 300.0, 300.0, 319.5, 239.5)
OFFSET_S = 0.025


def path(rate_hz: float = 20.0, child: str = "camera") -> Trajectory:
    """Where the camera really was for ten seconds; z is up."""
    sampled = MOTIONS["handheld"].sampled(rate_hz, 10.0, child="imu")
    return sampled.transformed_by(right=IMU_T_CAMERA, child=child)


@pytest.fixture(scope="module")
def stream() -> ImuStream:
    truth = MOTIONS["handheld"].sampled(200.0, 10.0, child="imu")
    return simulate_imu(truth, 200.0, ADIS16448, np.random.default_rng(1)).stream


def measured(left: Motor | None = None, gap_s: tuple[float, float] = (0.0, 0.0)) -> CameraPoses:
    """The path as a board in a world of its own would give it, with nothing in the gap."""
    rng = np.random.default_rng(2)
    found = simulate_camera_poses(path(), 20.0, 0.002, 0.002, rng)
    seconds = (found.trajectory.time_ns - found.trajectory.time_ns[0]) * 1e-9
    seen = (seconds < gap_s[0]) | (seconds >= gap_s[1])
    trajectory = found.trajectory if left is None else found.trajectory.transformed_by(left=left)
    kept = PoseMeasurements(trajectory[seen], found.covariance[seen])
    nothing = np.full(len(kept), np.nan)
    return CameraPoses(kept, found.trajectory.time_ns, nothing, "board", "as given")


def recording(**more: Any) -> Recording:
    return Recording("made up", Path(), "images", Stamps(path().time_ns), **more)  # type: ignore[arg-type]


def with_imu(stream: ImuStream) -> Recording:
    return recording(imu=stream, imu_T_camera=IMU_T_CAMERA)


def both(one: Recording, poses: CameraPoses, **knobs: Any) -> tuple[UsedImu, FusedPath]:
    made = imu(one, poses)
    return made, fused(one, poses, made, **knobs)


@pytest.mark.parametrize("lean_deg", [0.0, 40.0, 90.0, 180.0])
def test_a_world_that_leans_is_fused_as_well_as_an_upright_one(
    lean_deg: float, stream: ImuStream
) -> None:
    """A board on a wall: what bridges two seconds must know where down is."""
    angles = np.deg2rad([lean_deg, 0.0, 30.0])
    turn = Motor.from_euler_translation(angles, np.array([1.0, 2.0, 3.0]))
    one, poses = with_imu(stream), measured(turn, gap_s=(4.0, 6.0))
    made, found = both(one, poses)
    judged = evaluate(found.trajectory, path().transformed_by(left=turn), align="none")
    assert judged.ape_m.max < 0.06
    assert judged.rotation_deg.max < 0.5
    assert ("leans" in found.summary) == (lean_deg > 3.0)
    again = convergence(one, poses, made, found, duration_s=8.0)
    assert again.settled_s is not None
    assert again.settled_s < 3.0


def test_the_clock_of_a_recorded_imu_is_set_where_that_is_asked_for(stream: ImuStream) -> None:
    late = ImuStream(
        stream.time_ns + round(OFFSET_S * 1e9),
        stream.angular_rate_rad_s,
        stream.specific_force_m_s2,
    )
    one, poses = with_imu(late), measured()
    believed, found = imu(one, poses), imu(one, poses, sync="estimate")
    assert (believed.clock_offset_s, believed.clock_offset_sigma_s) == (0.0, None)
    assert found.clock_offset_s == pytest.approx(OFFSET_S, abs=1e-3)
    assert found.clock_offset_sigma_s is not None
    assert 0.0 < found.clock_offset_sigma_s < 1e-3
    apart = np.abs(found.stream(one).time_ns - stream.time_ns)
    assert apart.max() < 1e6
    errors = [
        evaluate(fused(one, poses, made).trajectory, path(), align="none").rotation_deg.rmse
        for made in (believed, found)
    ]
    assert errors[1] < 0.7 * errors[0]


def test_an_imu_of_unknown_extrinsics_is_never_taken_to_sit_in_the_camera(
    stream: ImuStream, caplog: pytest.LogCaptureFixture
) -> None:
    one, poses = recording(imu=stream), measured()
    with pytest.raises(ValueError, match=r"made up: imu.source=recorded, but .* put imu_T_camera"):
        imu(one, poses, source="recorded")
    assert not caplog.records
    made, found = both(one, poses)
    assert made.origin == "none"
    assert found.by == "nothing"
    assert "nothing tells how the camera sits on the recorded IMU" in found.summary
    (warned,) = caplog.messages
    assert warned.startswith("made up: its IMU is left aside: the camera's pose on the IMU is not")
    assert "into [imu] of a manifest" in warned
    with pytest.raises(ValueError, match=r"imu.sync=estimate needs a recorded IMU"):
        imu(one, poses, sync="estimate")


def test_a_clock_cannot_be_set_by_metres_that_came_from_it(stream: ImuStream) -> None:
    inertial = replace(measured(), metres_a_unit=2.0)
    with pytest.raises(ValueError, match="clock_offset_s"):
        imu(with_imu(stream), inertial, sync="estimate")
    with pytest.raises(ValueError, match=r"sync=estimate needs a recorded IMU"):
        imu(recording(), measured(), sync="estimate")


def test_a_path_without_a_unit_is_left_as_it_was_tracked(stream: ImuStream) -> None:
    one, poses = with_imu(stream), replace(measured(gap_s=(4.0, 6.0)), metric=False)
    made, found = both(one, poses)
    assert found.by == "nothing"
    np.testing.assert_array_equal(
        found.trajectory.poses.coefficients, poses.measurements.trajectory.poses.coefficients
    )
    assert "lengths have no unit" in found.summary
    assert convergence(one, poses, made, found).time_s.size == 0
    for by in ("imu", "odometry"):
        with pytest.raises(ValueError, match="have no unit"):
            fused(one, poses, made, by=by)


def test_nothing_is_fused_where_nothing_was_measured() -> None:
    """The tracked path, all of it and as it was, whatever gaps it has."""
    poses = measured(gap_s=(4.0, 6.0))
    made, found = both(recording(), poses)
    assert made.origin == "none"
    assert found.by == "nothing"
    assert "no IMU was recorded" in found.summary
    kept, tracked = found.trajectory, poses.measurements
    np.testing.assert_array_equal(kept.time_ns, tracked.trajectory.time_ns)
    np.testing.assert_array_equal(kept.motors.coefficients, tracked.trajectory.motors.coefficients)
    np.testing.assert_array_equal(found.covariance, tracked.covariance)
    assert convergence(recording(), poses, made, found).time_s.size == 0
    with pytest.raises(ValueError, match="expected an IMU, but no IMU was recorded"):
        made.stream(recording())


def test_an_imu_is_simulated_from_ground_truth_alone_and_only_where_that_is_asked_for() -> None:
    one, poses = recording(truth=path(100.0)), measured(gap_s=(4.0, 4.5))
    assert imu(one, poses).origin == "none"
    made = imu(one, poses, source="reference")
    assert made.origin == "reference"
    found = fused(one, poses, made)
    assert "simulated IMU" in found.summary
    assert evaluate(found.trajectory, path(), align="none").ape_m.max < 0.05
    with pytest.raises(ValueError, match=r"imu\.source=reference, but it has no ground truth"):
        imu(recording(), poses, source="reference")


@pytest.mark.parametrize("kept_s", [(2.0, 8.0), (0.0, 6.0), (7.0, 20.0)])
def test_measured_poses_outside_what_is_fused_stay_as_they_were_tracked(
    kept_s: tuple[float, float], stream: ImuStream
) -> None:
    seconds = (stream.time_ns - stream.time_ns[0]) * 1e-9
    inside = (seconds >= kept_s[0]) & (seconds <= kept_s[1])
    short = ImuStream(
        stream.time_ns[inside],
        stream.angular_rate_rad_s[inside],
        stream.specific_force_m_s2[inside],
    )
    whole = drifting().trajectory
    own_s = (whole.time_ns - whole.time_ns[0]) * 1e-9
    odometry = Odometry(
        whole[(own_s >= kept_s[0]) & (own_s <= kept_s[1])], drifting().odometry_T_camera
    )
    poses = measured()
    tracked = poses.measurements.trajectory
    for one, by in ((with_imu(short), "imu"), (recording(odometry=odometry), "odometry")):
        made, found = both(one, poses)
        assert found.by == by
        np.testing.assert_array_equal(found.trajectory.time_ns, tracked.time_ns)
        begin, end = (short if by == "imu" else odometry.trajectory).time_ns[[0, -1]]
        outside = (tracked.time_ns < begin) | (tracked.time_ns > end)
        assert np.any(outside)
        np.testing.assert_array_equal(
            found.trajectory.motors.coefficients[outside], tracked.motors.coefficients[outside]
        )
        assert f"{np.count_nonzero(outside)} poses outside its span" in found.summary
        assert len(found.nis) == len(found.accepted) == len(found.covariance) == len(tracked)
        again = convergence(one, poses, made, found, duration_s=2.0)
        assert (len(again.time_s) > 0) == (by == "imu")


def drifting() -> Odometry:
    """A path in its own world that goes astray by a few centimetres, smooth from step to step."""
    body_T_odometry = Motor.from_euler_translation(
        np.array([0.3, 0.2, -0.1]), np.array([0.1, 0.0, 0.2])
    )
    truth = path(30.0).transformed_by(right=body_T_odometry.inverse(), child="body")
    astray = np.cumsum(
        np.random.default_rng(5).standard_normal((len(truth), 6)) * np.repeat([2e-4, 5e-4], 3),
        axis=0,
    )
    own = Motor.from_euler_translation(np.array([0.0, 0.0, 2.0]), np.array([5.0, 0.0, 0.0]))
    drifted = truth.transformed_by(left=own, right=Motor.from_twist(astray))
    return Odometry(drifted, body_T_odometry)


def test_a_recorded_odometry_bridges_what_the_camera_did_not_see(stream: ImuStream) -> None:
    poses = measured(gap_s=(4.0, 6.0))
    made, found = both(recording(odometry=drifting()), poses)
    assert found.by == "odometry"
    assert "recorded odometry" in found.summary
    times_ns = poses.frame_times_ns
    inside = times_ns[times_ns <= drifting().trajectory.time_ns[-1]]
    np.testing.assert_array_equal(found.trajectory.time_ns, inside)
    assert evaluate(found.trajectory, path(), align="none").ape_m.max < 0.015
    with pytest.raises(ValueError, match=r"fused\.by=imu, but no IMU was recorded"):
        fused(recording(odometry=drifting()), poses, made, by="imu")
    # What was measured by an IMU goes through the filter.
    one = recording(odometry=drifting(), imu=stream, imu_T_camera=IMU_T_CAMERA)
    assert both(one, poses)[1].by == "imu"
    live = fused(recording(odometry=drifting()), poses, made, look_ahead=False)
    assert (live.by, len(live.trajectory)) == ("nothing", len(poses.measurements))
    assert "only where fused.look_ahead" in live.summary
    with pytest.raises(ValueError, match="looks ahead always"):
        fused(recording(odometry=drifting()), poses, made, by="odometry", look_ahead=False)
    with pytest.raises(ValueError, match="holds none"):
        fused(recording(), poses, made, by="odometry")


def test_an_odometry_that_makes_the_path_worse_is_left_aside() -> None:
    """Its extrinsics turned: poses that were held out say so, with a ground truth or without."""
    turned = Motor.from_euler_translation(np.array([0.0, 0.0, np.pi / 2]), np.zeros(3))
    wrong = replace(drifting(), odometry_T_camera=turned @ drifting().odometry_T_camera)
    poses = measured()
    for truth in (None, path(100.0)):
        one = recording(odometry=wrong, truth=truth)
        made, found = both(one, poses)
        assert found.by == "nothing"
        np.testing.assert_array_equal(
            found.trajectory.motors.coefficients, poses.measurements.trajectory.motors.coefficients
        )
        assert "with the recorded odometry fused is farther from the held-out" in found.summary
        assert (found.held_out is None) == (truth is not None)
    assert fused(one, poses, made, by="odometry").by == "odometry"


def mapped(truth: Trajectory) -> SlamResult:
    """What SLAM by one camera makes of a path, in units of half a metre: a wall of points."""
    rng = np.random.default_rng(6)
    half = Motor.from_rotor_translation(truth.motors.rotor, 2.0 * truth.motors.translation_m)
    noise = Motor.from_twist(rng.standard_normal((len(truth), 6)) * np.repeat([1e-3, 4e-3], 3))
    frames = Trajectory(truth.time_ns, half @ noise)
    keyframes = frames[::10]
    places = keyframes.motors.translation_m.mean(axis=0)
    points = places + keyframes.motors[0].rotor.apply(
        rng.uniform([-6.0, -6.0, 8.0], [6.0, 6.0, 14.0], (60, 3))
    )
    rows, names = np.divmod(np.arange(len(keyframes) * 60), 60)
    own = keyframes.motors[rows].inverse().apply(points[names])
    ahead = own[:, 2] > 1.0
    snapshot = MapSnapshot(
        keyframes.time_ns,
        keyframes.motors,
        points,
        np.zeros((60, 32), np.uint8),
        rows[ahead],
        names[ahead],
        CAMERA.project(own[ahead]),
        np.full(np.count_nonzero(ahead), np.nan),
        False,
    )
    spread = np.tile(np.diag(np.repeat([1e-3, 4e-3], 3) ** 2), (len(frames), 1, 1))
    states = ("tracking",) * len(frames)
    none = np.zeros(len(frames), np.int64)
    history = SlamHistory(frames.time_ns, states, none, none, none, ())
    return SlamResult(frames, spread, history, None, snapshot, (), False, (), {})


def test_an_imu_tells_metres_where_it_was_carried_and_says_why_not(stream: ImuStream) -> None:
    one = replace(with_imu(stream), camera=CAMERA)
    found = in_metres(one, mapped(path()))
    assert found.scaled_map.metres_a_unit == pytest.approx(0.5, rel=3 * found.scale_sigma)
    assert found.scale_sigma < 0.05
    judged = evaluate(found.scaled_map.measurements.trajectory, path(), align="se3")
    assert judged.ape_m.rmse < 0.03
    with pytest.raises(NoMetres, match="no IMU whose extrinsics are known"):
        in_metres(replace(one, imu=None), mapped(path()))
    with pytest.raises(NoMetres, match="where the camera sits"):
        in_metres(replace(one, imu_T_camera=None), mapped(path()))
    still = Trajectory(path().time_ns, Motor.stack([path().motors[0]] * len(path())))
    at_rest = simulate_imu(
        still.transformed_by(right=IMU_T_CAMERA.inverse(), child="imu"),
        200.0,
        ADIS16448,
        np.random.default_rng(1),
    ).stream
    with pytest.raises(NoMetres, match="tell"):
        in_metres(replace(one, imu=at_rest), mapped(still))


def test_metres_that_the_imu_contradicts_are_none(
    stream: ImuStream, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A map that drifts may give a scale that is far off, and called sure."""
    one = replace(with_imu(stream), camera=CAMERA)
    found = in_metres(one, mapped(path()))
    told = found.scaled_map.measurements
    places = 30.0 * told.trajectory.motors.translation_m
    grown = Motor.from_rotor_translation(told.trajectory.motors.rotor, places)
    wrong = PoseMeasurements(Trajectory(told.trajectory.time_ns, grown), told.covariance)
    made = replace(found.scaled_map, measurements=wrong)
    monkeypatch.setattr(slam_poses, "metric_map", lambda *given: made)
    with pytest.raises(NoMetres, match=r"poses of the path .* contradict it"):
        in_metres(one, mapped(path()))


def test_a_path_answered_later_is_nearer_to_that_of_the_whole(stream: ImuStream) -> None:
    one, poses = with_imu(stream), measured()
    _, whole = both(one, poses, lag_curve=True)
    _, lagged = both(one, poses, lag_s=0.2)
    assert whole.latency is not None
    assert lagged.latency is None
    curve = dict(zip(whole.latency.lag_s.tolist(), whole.latency.position_m, strict=True))
    apart = absolute_translation_m(lagged.trajectory.motors, whole.trajectory.motors)
    assert np.sqrt(np.mean(apart**2)) == pytest.approx(curve[0.2], rel=1e-6)
    assert curve[0.0] > curve[0.2] > curve[2.0] >= curve[np.inf] == 0.0
    assert "up to 0.2 s after it" in lagged.summary


@pytest.mark.parametrize(
    ("knobs", "message"),
    [
        ({"lag_s": 0.0}, "fused.lag_s: expected"),
        ({"lag_s": 1.0, "look_ahead": False}, "fused.lag_s: expected none without"),
    ],
)
def test_a_lag_that_means_nothing_is_refused(
    stream: ImuStream, knobs: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        both(with_imu(stream), measured(), **knobs)


def test_what_was_learnt_of_the_noise_is_told(stream: ImuStream) -> None:
    one, poses = with_imu(stream), measured()
    _, found = both(one, poses, learn_noise=True)
    assert found.noise is not None
    assert "24 s of poses are needed to learn it, and there are 10" in found.noise.summary
    assert both(one, poses)[1].noise is None


def test_what_was_told_and_learnt_of_a_path_serves_the_one_it_is_judged_by(
    stream: ImuStream, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Noise is learnt once and a fault told once, though a second path is made of fewer poses."""
    learnt: list[int] = []

    def learn(measurements: PoseMeasurements, *_: Any, **__: Any) -> LearntNoise:
        learnt.append(len(measurements))
        return LearntNoise(ADIS16448.scaled(20.0), True, "learnt")

    monkeypatch.setattr("motorcade.replays.stages.inertial.fused.noise_of", learn)
    negated = ImuStream(stream.time_ns, -stream.angular_rate_rad_s, stream.specific_force_m_s2)
    poses = measured()
    _, found = both(with_imu(negated), poses, learn_noise=True)
    assert found.held_out is not None
    assert learnt == [len(poses.measurements)]
    told = [one.getMessage() for one in caplog.records if one.name == "motorcade.fuse"]
    assert told
    assert len(told) == len(set(told))
