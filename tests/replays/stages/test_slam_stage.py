"""What the stage `slam_poses` hands on and keeps, whatever SLAM itself does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.imu import ImuStream
from motorcade.fusion.visual_inertial import InertialSlamResult
from motorcade.fusion.visual_inertial.start import InertialStart
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera import sensor_audit, slam_poses
from motorcade.replays.stages.camera.slam_poses import FoundCameras
from motorcade.replays.stages.inertial.imu import imu
from motorcade.tracking import Camera, MapSnapshot, PoseMeasurements
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.depth import DepthCamera
from motorcade.tracking.slam import SlamHistory, SlamResult

PINHOLE = Camera(640, 480, 300.0, 300.0, 319.5, 239.5)
BENT = Camera(640, 480, 300.0, 300.0, 319.5, 239.5, "radtan", (-0.2, 0.05))
FISHEYE = Camera(640, 480, 300.0, 300.0, 319.5, 239.5, "equidistant", (0.01, 0.0, 0.0, 0.0))
STAMPS = np.array([0, 100_000_000])
FOUND_OUT = AuditFinding("depth_on_colour", "unknown", None, "px", "edges do not tell")


def recording(camera: Camera) -> Recording:
    frames = ImageFrames((Path("0.png"), Path("1.png")), STAMPS)
    return Recording("made up", Path(), "images", frames, camera)


def mapped(*, metric: bool) -> SlamResult:
    """Two keyframes, a point in front of both."""
    poses = Motor.from_translation([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    path, none = Trajectory(STAMPS, poses), np.zeros(2, np.int64)
    known = MapSnapshot(
        time_ns=STAMPS,
        world_T_camera=poses,
        points=[[0.0, 0.0, 2.0]],
        descriptors=np.zeros((1, 32), np.uint8),
        keyframe_of=[0, 1],
        point_of=[0, 0],
        px=[[319.5, 239.5], [304.5, 239.5]],
        depth=[2.0, 2.0],
        metric=metric,
    )
    history = SlamHistory(STAMPS, ("tracking", "tracking"), none, none, none, ())
    covariance = np.tile(1e-6 * np.eye(6), (2, 1, 1))
    return SlamResult(path, covariance, history, path, known, (), metric, (), {})


@pytest.mark.parametrize("camera", [PINHOLE, BENT, FISHEYE])
def test_depth_refines_a_map_through_the_camera_of_its_pixels(
    camera: Camera, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fisheye's map holds its own pixels, any other lens's those of the undistorted image."""
    through = []

    def refined(_map: object, _path: object, colour: Camera, *_: object) -> None:
        through.append(colour)

    monkeypatch.setattr(sensor_audit, "refine_by_depth", refined)
    assert sensor_audit.refined_by_depth(recording(camera), mapped(metric=True)) is None
    assert through == [camera if camera is FISHEYE else PINHOLE]


@pytest.mark.parametrize("metric", [True, False])
def test_what_was_found_of_the_sensors_stays_with_the_poses(
    metric: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Tracked:
        def __init__(self, *_: object, **__: object) -> None: ...

        def finish(self) -> SlamResult:
            return mapped(metric=metric)

    given = recording(PINHOLE)
    monkeypatch.setattr("motorcade.tracking.slam.VisualSlam", Tracked)
    cameras = FoundCameras(None, None, (FOUND_OUT,))
    monkeypatch.setattr(slam_poses, "found_cameras", lambda _: cameras)
    monkeypatch.setattr(slam_poses, "track", lambda *_: ())  # no image is read
    found = slam_poses.slam_poses(given, adjust=False)
    assert found.metric == metric
    assert found.audit == (FOUND_OUT,)


def carried(
    first_ns: int = -10_000_000, last_ns: int = 130_000_000, step_ns: int = 5_000_000
) -> Recording:
    """Two images by a rolling shutter, and an IMU at rest."""
    stamps = np.arange(first_ns, last_ns, step_ns)
    still = np.zeros((len(stamps), 3))
    imu = ImuStream(stamps, still, still + np.array([0.0, 0.0, 9.81]))
    return replace(recording(PINHOLE), imu=imu, imu_T_camera=Motor.identity(), readout_s=0.01)


class FedInertialSlam:
    """Takes what it is given, and says that the IMU told metres with the second image."""

    told = True

    def __init__(self, *_: object, readout_s: float) -> None:
        assert readout_s == 0.01
        self.samples_ns: list[int] = []

    def imu(self, samples: ImuStream) -> None:
        assert not self.samples_ns or samples.time_ns[0] > self.samples_ns[-1]
        self.samples_ns += samples.time_ns.tolist()

    def track(self, time_ns: int, _gray: object, _right: object) -> None:
        assert self.samples_ns[-1] >= time_ns

    def finish(self) -> InertialSlamResult:
        if not self.told:
            none = (None,) * 4
            return InertialSlamResult(mapped(metric=False), *none, ("visual",) * 2)
        lean = Motor.from_rotor_translation(Rotor.from_rotation_vector([-np.pi / 2, 0, 0]), [0] * 3)
        start = InertialStart(
            Similarity.from_motor_scale(lean, 2.5),
            0.02,
            0.003,
            STAMPS,
            Motor.identity((2,)),
            *(np.zeros((2, 3)) for _ in range(3)),
        )
        states = "visual", "tracking"
        found = mapped(metric=True)
        poses = PoseMeasurements(Trajectory(STAMPS, found.map.world_T_camera), found.covariance)
        return InertialSlamResult(found, start, int(STAMPS[1]), poses, None, states)


@pytest.fixture
def fed(monkeypatch: pytest.MonkeyPatch) -> type[FedInertialSlam]:
    class Fed(FedInertialSlam): ...

    monkeypatch.setattr(slam_poses, "InertialSlam", Fed)
    monkeypatch.setattr("motorcade.replays.io.recording.Frame.gray", lambda _: None)
    return Fed


@pytest.mark.parametrize("step_ns", [5_000_000, 60_000_000])  # 200 Hz; fewer than two an image
def test_an_imu_goes_into_slam_and_what_it_told_stays_with_the_poses(
    step_ns: int, fed: type[FedInertialSlam]
) -> None:
    found = slam_poses.slam_poses(carried(-60_000_000, 250_000_000, step_ns))
    assert found.metric
    assert "with the IMU inside, metres and up 0.1 s after the first frame" in found.summary
    assert (found.metres_a_unit, found.scale_sigma) == (pytest.approx(2.5), 0.02)
    told = found.inertial
    assert told is not None
    assert told.frames_in_state == {"visual": 1, "tracking": 1}
    # The world stands upright by a quarter turn about x: gravity is along the camera's y.
    np.testing.assert_allclose(told.gravity_direction, [0.0, 1.0, 0.0], atol=1e-12)
    figures = told.as_dict()
    assert figures["states"] == [
        {"start_s": 0.0, "state": "visual"},
        {"start_s": 0.1, "state": "tracking"},
    ]
    assert (figures["metric_from_s"], figures["readout_s"]) == (0.1, 0.01)
    # The poses stay in the upright world, and so do the points.
    np.testing.assert_array_equal(found.points, mapped(metric=True).map.points)


def test_cameras_that_were_found_stay_with_poses_by_an_imu(
    fed: type[FedInertialSlam], monkeypatch: pytest.MonkeyPatch
) -> None:
    cameras = FoundCameras(BENT, DepthCamera(PINHOLE, Motor.identity()), (FOUND_OUT,))
    monkeypatch.setattr(slam_poses, "found_cameras", lambda _: cameras)
    found = slam_poses.slam_poses(carried())
    assert found.inertial is not None
    assert (found.camera, found.depth_camera) == (cameras.camera, cameras.depth_camera)
    assert found.audit == (FOUND_OUT,)


def test_an_imu_that_tells_no_metres_leaves_images_alone(
    fed: type[FedInertialSlam], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Tracked:
        def __init__(self, *_: object, **__: object) -> None: ...

        def track(self, *_: object) -> None: ...

        def finish(self) -> SlamResult:
            return mapped(metric=False)

    monkeypatch.setattr("motorcade.tracking.slam.VisualSlam", Tracked)
    for one in (carried(), carried(last_ns=-1)):
        fed.told = False
        found = slam_poses.slam_poses(one)
        assert not found.metric
        assert found.inertial is None
        assert "the readout time of 10 ms left aside without an IMU" in found.summary


@pytest.mark.parametrize(
    ("first_ns", "last_ns", "carries"),
    [
        (-10_000_000, 130_000_000, True),
        (50_000_000, 130_000_000, True),  # one frame is given up for the IMU
        (-900_000_000, -600_000_000, False),
        (700_000_000, 900_000_000, False),
    ],
)
def test_an_imu_goes_in_where_it_covers_the_images(
    first_ns: int, last_ns: int, carries: bool
) -> None:
    one = carried(first_ns, last_ns)
    assert slam_poses.carries_imu(one) == carries
    for lacking in ({"imu": None}, {"imu_T_camera": None}):
        assert not slam_poses.carries_imu(replace(one, **lacking))


def test_a_pair_with_an_imu_has_metres_of_its_own(
    fed: type[FedInertialSlam], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("motorcade.replays.io.recording.Frame.right", lambda _: None)
    monkeypatch.setattr(slam_poses, "audited_pair", lambda _: (FOUND_OUT,))
    found = slam_poses.slam_poses(replace(carried(), baseline_m=0.1))
    assert "by a stereo pair with the IMU inside, upright 0.1 s after" in found.summary
    assert (found.metres_a_unit, found.scale_sigma) == (None, None)
    assert found.inertial is not None
    assert found.audit == (FOUND_OUT,)
    with pytest.raises(ValueError, match="imu_inside=false"):
        imu(carried(), found, sync="estimate")
