"""A second thread maps while the first one tracks: no frame waits for it, unless it must."""

from collections.abc import Callable
from threading import Event, Timer

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.tracking import Camera
from motorcade.tracking.slam import SlamSettings, VisualSlam
from motorcade.tracking.slam.mapping.mapper import Mapper

View = Callable[[Motor], tuple[np.ndarray, np.ndarray]]
Poses = Callable[..., list[Motor]]

CAMERA = Camera(400, 300, 320.0, 320.0, 199.5, 149.5)  # as the room is rendered
STEP_NS = 33_333_333
COUNT = 40


def test_every_frame_is_tracked_as_well_as_by_one_thread(view: View, swaying: Poses) -> None:
    poses = swaying(COUNT)
    slam = VisualSlam(CAMERA, SlamSettings(threads=True))
    states = [slam.track(i * STEP_NS, *view(pose)).state for i, pose in enumerate(poses)]
    result = slam.finish()
    assert states == ["tracking"] * COUNT
    assert result.trajectory is not None
    assert len(result.trajectory) == COUNT
    expected = poses[0].inverse() @ Motor.stack(poses)
    apart = expected.inverse() @ result.trajectory.motors
    assert np.linalg.norm(apart.translation_m, axis=1).max() < 0.02
    assert result.seconds["mapping"] > 0.0


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> Event:
    """Mapping beyond the first keyframe waits for this."""
    gate = Event()
    insert_keyframe = Mapper.insert_keyframe

    def patient(self: Mapper, *work: object) -> object:
        if self.map.keyframes:
            assert gate.wait(60.0)
        return insert_keyframe(self, *work)  # type: ignore[arg-type]

    monkeypatch.setattr(Mapper, "insert_keyframe", patient)
    return gate


def test_tracking_goes_on_while_a_keyframe_is_worked_in(
    view: View, swaying: Poses, held: Event
) -> None:
    slam = VisualSlam(CAMERA, SlamSettings(threads=True))
    frames = [slam.track(i * STEP_NS, *view(pose)) for i, pose in enumerate(swaying(14))]
    wanted = [index for index, frame in enumerate(frames) if frame.keyframe]
    # The mapper has been standing still since the second keyframe was asked for.
    assert len(wanted) == 2
    assert wanted[1] < 10
    assert [frame.state for frame in frames] == ["tracking"] * 14
    held.set()
    assert len(slam.snapshot().time_ns) == 2
    result = slam.finish()
    assert result.trajectory is not None
    assert len(result.trajectory) == 14


def test_the_camera_is_not_lost_for_points_that_are_still_being_made(
    view: View, turning: Poses, held: Event
) -> None:
    slam = VisualSlam(CAMERA, SlamSettings(threads=True))
    views = [view(pose) for pose in turning(30, 2.0)]  # nothing of the first is in the last
    release = Timer(4.0, held.set)
    release.start()
    states = [slam.track(i * STEP_NS, *seen).state for i, seen in enumerate(views)]
    assert held.is_set(), "it waited"
    slam.finish()
    assert len(states) == len(views)
    assert set(states) <= {"tracking", "weak"}


def test_a_fault_of_the_mapper_reaches_the_caller(
    view: View, swaying: Poses, monkeypatch: pytest.MonkeyPatch
) -> None:
    slam = VisualSlam(CAMERA, SlamSettings(threads=True))
    poses = swaying(30)
    slam.track(0, *view(poses[0]))

    def broken(*_: object) -> None:
        raise ZeroDivisionError("mapper")

    monkeypatch.setattr(Mapper, "insert_keyframe", broken)

    def go_on() -> None:
        for index, pose in enumerate(poses[1:], start=1):
            slam.track(index * STEP_NS, *view(pose))
        slam.finish()

    with pytest.raises(ZeroDivisionError, match="mapper"):
        go_on()
