"""Runs whose stages contradict each other or the images are called doubtful, others are not."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.demo.furniture import BOARD, world_T_board
from motorcade.replays.demo.recording import CAMERA, IMU_T_CAMERA, HandheldPath
from motorcade.replays.engine.stage import Chosen
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.camera_poses import camera_poses
from motorcade.replays.stages.inertial.filter_input import other_rate
from motorcade.replays.stages.inertial.fused import fused
from motorcade.replays.stages.inertial.imu import imu
from motorcade.replays.stages.integrity import integrity
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.stages.values.camera_poses import BoardPoses, CameraPoses
from motorcade.replays.stages.values.errors import Integrity
from motorcade.tracking import BoardTrack, Camera, PoseMeasurements, registration_px
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.measurements import MarkerObservation
from tests.replays.stages.stamps import Stamps

FRAMES, RATE_HZ = 120, 30.0
SIGMA_M, SIGMA_RAD, CORNER_PX = 0.0005, 0.0005, 0.1
SEEDS = range(3)


@dataclass(frozen=True)
class Given:
    """A recording with an IMU, and what was measured by a board in it."""

    recording: Recording
    poses: BoardPoses


@functools.cache
def given(seed: int) -> Given:
    """The demo's camera, its board's corners and its IMU, without any image."""
    rng = np.random.default_rng(seed)
    path = HandheldPath.of(rng)
    stamps = np.rint(np.arange(FRAMES) / RATE_HZ * 1e9).astype(np.int64)
    fine = np.arange(0, stamps[-1] + 50_000_000, 2_500_000)
    world_T_imu = path.trajectory(fine).transformed_by(right=IMU_T_CAMERA.inverse(), child="imu")
    stream = simulate_imu(world_T_imu, 200.0, ADIS16448, rng, knot_spacing_s=0.03).stream
    truth = path.trajectory(stamps)
    found = simulate_camera_poses(truth, RATE_HZ, SIGMA_M, SIGMA_RAD, rng)
    at = truth.motors_at(found.trajectory.time_ns)
    recording = Recording(
        "made up",
        Path(),
        "images",
        Stamps(found.trajectory.time_ns),  # type: ignore[arg-type]
        CAMERA,
        imu=stream,
        imu_noise=ADIS16448,
        imu_T_camera=IMU_T_CAMERA,
        board=BOARD,
        world_T_board=world_T_board(),
    )
    return Given(recording, by_board(found, at, rng))


def by_board(found: PoseMeasurements, truth: Motor, rng: np.random.Generator) -> BoardPoses:
    """The poses, with corners as the camera saw them from where it really was."""
    time_ns, ids = found.trajectory.time_ns, np.arange(len(BOARD.points_m))
    observations = []
    for k, stamp in enumerate(time_ns.tolist()):
        seen = CAMERA.project((truth[k].inverse() @ world_T_board()).apply(BOARD.points_m))
        corners = seen + CORNER_PX * rng.standard_normal(seen.shape)
        both = Motor.stack([found.trajectory.motors[k]] * 2)
        observations.append(MarkerObservation(stamp, ids, corners, both, np.full(2, CORNER_PX)))
    errors = np.full(len(found), CORNER_PX)
    states = np.full(len(found), "tracked")
    track = BoardTrack(time_ns, states, tuple(observations), found, errors)
    corners_m = BOARD.points_m
    return BoardPoses(found, time_ns, errors, "board", "as given", track=track, corners_m=corners_m)


def judged(one: Given, **knobs: Any) -> tuple[Integrity, Integrity]:
    """What the stages make of it, as judged by the images and without them."""
    poses = camera_poses(Chosen(one.poses, skipped=one.poses.skipped), **knobs)
    sensor = imu(one.recording, poses)
    joined = fused(one.recording, poses, sensor, noise_factor=1.0)
    paths = smoothed(joined, representations=("motor",))
    by_images, blind = (
        integrity(one.recording, poses, sensor, joined, paths, board) for board in (one.poses, None)
    )
    return by_images, blind


def with_imu(one: Given, stream: ImuStream | None, imu_T_camera: Motor = IMU_T_CAMERA) -> Given:
    return replace(one, recording=replace(one.recording, imu=stream, imu_T_camera=imu_T_camera))


def wrong(one: Given, fault: str) -> Given:
    """The same with one thing about its IMU as users get it wrong."""
    stream = one.recording.imu
    assert stream is not None
    time_ns, rate, force = (
        stream.time_ns,
        stream.angular_rate_rad_s,
        stream.specific_force_m_s2,
    )
    swapped = [1, 0, 2]
    turned = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([0.0, 0.0, 0.5 * np.pi]), np.zeros(3)
    )
    return {
        "degrees": lambda: with_imu(one, ImuStream(time_ns, np.rad2deg(rate), force)),
        "units of g": lambda: with_imu(one, ImuStream(time_ns, rate, force / 9.81)),
        "axes": lambda: with_imu(one, ImuStream(time_ns, rate[:, swapped], force[:, swapped])),
        "clock": lambda: with_imu(one, ImuStream(time_ns + 10**9, rate, force)),
        "extrinsics": lambda: with_imu(one, stream, IMU_T_CAMERA @ turned),
    }[fault]()


def failed(found: Integrity) -> set[str]:
    return {check.name for check in found.checks if not check.passed}


@pytest.mark.parametrize("seed", SEEDS)
def test_a_healthy_run_is_not_doubted(seed: int) -> None:
    for found, last in zip(judged(given(seed)), ("registration", "agreement"), strict=True):
        assert found.doubts == ()
        assert found.drawn_is == "smoothed"
        assert [check.name for check in found.checks] == [
            "coverage",
            "inertial",
            "innovations",
            last,
        ]


@pytest.mark.quick_every(4)
@pytest.mark.parametrize("fault", ["degrees", "units of g", "axes", "clock", "extrinsics"])
@pytest.mark.parametrize("seed", SEEDS)
def test_an_imu_that_contradicts_the_camera_is_never_silent(seed: int, fault: str) -> None:
    one = wrong(given(seed), fault)
    by_images, blind = judged(one)
    if fault == "extrinsics" and "registration" not in failed(by_images):
        # The filter, which may turn them, found the true ones: the path is right, the fault told.
        assert failed(by_images) == failed(blind) == {"inertial"}
        return
    if fault == "extrinsics":  # what the IMU denies is refused, and it is told how it is turned
        for found in (by_images, blind):
            assert "inertial" in failed(found)
            assert any("put the readings as (x, -z, y)" in doubt for doubt in found.doubts)
    for found in (by_images, blind) if fault != "extrinsics" else ():
        assert "innovations" in failed(found)
        assert any("measured poses contradict the IMU" in doubt for doubt in found.doubts)
    if fault == "units of g":  # the bias takes up what it can: the path is bad, not absurd
        return
    # What is drawn holds to the board, whatever the filter made of its IMU.
    assert "registration" in failed(by_images)
    assert by_images.drawn_is == "measured"
    seen = registration_px(
        by_images.drawn, one.poses.track, BOARD, CAMERA, one.recording.world_T_board
    )
    assert np.max(seen) < 3.0


def test_degrees_a_second_are_told_with_numbers() -> None:
    found, blind = judged(wrong(given(0), "degrees"))
    assert failed(blind) == {"inertial", "innovations", "agreement"}
    assert blind.drawn_is == "measured"
    assert failed(found) == {"inertial", "innovations", "registration"}
    inertial, innovations, registration = found.doubts
    assert "degrees a second" in inertial
    assert " refused" in innovations
    assert "mean NIS is" in innovations
    assert "px along the measured poses" in registration
    told = found.as_dict()
    assert told["doubts"] == list(found.doubts)
    assert told["drawn"] == "measured"
    verdicts = ["consistent", "contradicted", "doubtful", "doubtful"]
    assert [check["verdict"] for check in told["checks"]] == verdicts
    assert told["verdict"] == "contradicted"


def test_what_measuring_the_poses_found_is_judged_with_the_rest() -> None:
    told = AuditFinding("tag_sizes", "contradicted", 0.5, "share", "tag 3 is smaller", "say 0.1 m")
    one = given(0)
    found, _ = judged(replace(one, poses=replace(one.poses, audit=(told,))))
    assert found.verdict == "contradicted"
    assert found.doubts == ("tag 3 is smaller; say 0.1 m",)


@pytest.mark.parametrize(
    ("skipped", "named"),
    [
        ("board: frames: expected some that show it, got none; say columns = 4", "stated_board"),
        ("markers: expected some that show a marker, got none", None),
        ("slam: visual SLAM found no pose; swap the left and right images", "stated_slam"),
    ],
)
def test_what_was_stated_and_is_not_seen_is_no_consistent_run(
    skipped: str, named: str | None
) -> None:
    one = given(0)
    recording = replace(one.recording, board=BOARD, baseline_m=0.1)
    found, _ = judged(
        replace(one, recording=recording, poses=replace(one.poses, skipped=(skipped,)))
    )
    assert (named is None) == (found.verdict == "consistent")
    if named is not None:
        assert failed(found) == {named}
        assert skipped.partition(": ")[2] in found.doubts[0]


def outliers(one: Given, share: float) -> Given:
    """A share of the measured poses is off by centimetres and degrees."""
    rng = np.random.default_rng(7)
    found = one.poses.measurements
    path = found.trajectory
    bad = rng.permutation(len(path)) < share * len(path)
    twist = rng.standard_normal((len(path), 6)) * 0.1 * bad[:, None]
    off = Trajectory(path.time_ns, path.motors @ Motor.from_twist(twist), path.parent, path.child)
    return replace(
        one, poses=replace(one.poses, measurements=PoseMeasurements(off, found.covariance))
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_a_tracked_path_with_many_outliers_is_doubted_and_one_with_few_is_not(seed: int) -> None:
    for found in judged(outliers(given(seed), 0.1)):
        assert found.doubts == ()
    by_images, blind = judged(outliers(given(seed), 0.3))
    assert failed(by_images) == {"innovations"}
    assert failed(blind) == {"innovations", "agreement"}
    # The filter left them out: its path is the better one.
    assert by_images.drawn_is == blind.drawn_is == "smoothed"


@pytest.mark.parametrize("seed", SEEDS)
def test_images_deny_outliers_where_no_imu_does(seed: int) -> None:
    found, _ = judged(outliers(with_imu(given(seed), None), 0.3))
    assert failed(found) == {"registration"}


@pytest.mark.parametrize("seed", SEEDS)
def test_no_limit_grows_with_what_it_judges(seed: int) -> None:
    """Corners that the poses miss by pixels in all frames alike: the board is another one."""
    one = with_imu(given(seed), None)
    rng = np.random.default_rng(seed)
    off = 3.0 * rng.standard_normal((len(BOARD.points_m), 2))
    track = one.poses.track
    missed = tuple(replace(seen, corners_px=seen.corners_px + off) for seen in track.observations)
    wrong_board = replace(one.poses, track=replace(track, observations=missed))
    found, _ = judged(replace(one, poses=wrong_board))
    assert failed(found) == {"registration"}
    assert "the measured poses do not explain the images" in found.doubts[0]


def test_intrinsics_of_images_twice_as_large_are_doubted() -> None:
    one = with_imu(given(0), None)
    found, _ = judged(replace(one, recording=replace(one.recording, camera=doubled(CAMERA))))
    assert "camera_centre" in failed(found)
    assert any("divide fx, fy, cx and cy by 2" in doubt for doubt in found.doubts)


def doubled(camera: Camera) -> Camera:
    fx, fy, cx, cy = (2.0 * one for one in (camera.fx, camera.fy, camera.cx, camera.cy))
    return replace(camera, fx=fx, fy=fy, cx=cx, cy=cy)


def scaled(one: Given, factor: float) -> Given:
    """The same with squares taken to be `factor` times as large as they are."""
    found, path = one.poses.measurements, one.poses.measurements.trajectory
    origin = one.recording.world_T_board
    on_board = path.transformed_by(left=origin.inverse()).motors
    motors = origin @ Motor.from_rotor_translation(on_board.rotor, factor * on_board.translation_m)
    spread = np.diag(np.repeat([1.0, factor], 3))
    measurements = PoseMeasurements(
        Trajectory(path.time_ns, motors, path.parent, path.child),
        spread @ found.covariance @ spread,
    )
    board = replace(BOARD, marker_m=factor * BOARD.marker_m, gap_m=factor * BOARD.gap_m)
    poses = replace(one.poses, measurements=measurements, corners_m=board.points_m)
    return Given(replace(one.recording, board=board), poses)


def test_a_wrong_size_of_the_board_is_not_seen_but_by_an_imu() -> None:
    """Board, poses and images scale together: no image tells metres, an accelerometer does."""
    one = scaled(given(0), 2.0)
    for found in judged(with_imu(one, None)):
        assert found.doubts == ()
    for found in judged(one):
        assert "innovations" in failed(found)


def test_a_path_that_is_mostly_bridged_is_doubted() -> None:
    one = given(1)
    assert judged(one, blackouts_s=(1.0, 1.5))[0].doubts == ()
    found, _ = judged(one, blackouts_s=(0.5, 3.5))
    assert "coverage" in failed(found)
    assert found.doubts[0].startswith("90 of 120 frames have no pose (up to 60 may); ")


@pytest.mark.parametrize(("stated_hz", "named"), [(30.0, 0.0), (20.0, 30.0), (60.0, 30.0)])
def test_a_rate_of_frames_that_the_gyroscope_denies_is_named(
    stated_hz: float, named: float
) -> None:
    recorded = given(1)
    stream, poses = recorded.recording.imu, recorded.poses
    assert stream is not None
    frame = np.rint(1e-9 * RATE_HZ * poses.frame_times_ns)
    stamps = np.rint(1e9 * frame / stated_hz).astype(np.int64)
    measured = poses.measurements
    path = Trajectory(stamps, measured.trajectory.motors)
    restamped = PoseMeasurements(path, measured.covariance)
    errors = np.full(len(path), CORNER_PX)
    findings = other_rate(CameraPoses(restamped, stamps, errors, "board", "restamped"), stream)
    assert [finding.advice for finding in findings] == [f"say rate_hz = {named:g}"] * bool(named)
