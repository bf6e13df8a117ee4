"""What the stage `slam_poses` hands on and keeps, whatever SLAM itself does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.replays.readers.frames.files import PictureFrames
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera import depth, slam_poses
from motorcade.tracking import Camera, MapSnapshot
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.slam import SlamHistory, SlamResult

PINHOLE = Camera(640, 480, 300.0, 300.0, 319.5, 239.5)
BENT = Camera(640, 480, 300.0, 300.0, 319.5, 239.5, "radtan", (-0.2, 0.05))
FISHEYE = Camera(640, 480, 300.0, 300.0, 319.5, 239.5, "equidistant", (0.01, 0.0, 0.0, 0.0))
STAMPS = np.array([0, 100_000_000])
FOUND_OUT = AuditFinding("depth_on_colour", "unknown", None, "px", "edges do not tell")


def recording(camera: Camera) -> Recording:
    frames = PictureFrames((Path("0.png"), Path("1.png")), STAMPS)
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
    """A fisheye's map holds its own pixels, any other lens's those of the undistorted picture."""
    through = []

    def refined(_map: object, _path: object, colour: Camera, *_: object) -> None:
        through.append(colour)

    monkeypatch.setattr(depth, "refine_by_depth", refined)
    assert depth.refined_by_depth(recording(camera), mapped(metric=True)) is None
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
    monkeypatch.setattr(slam_poses, "audited_depth", lambda _: (None, (FOUND_OUT,)))
    monkeypatch.setattr(slam_poses, "track", lambda *_: ())  # no picture is read
    found = slam_poses.slam_poses(given, adjust=False)
    assert found.metric == metric
    assert found.audit == (FOUND_OUT,)
