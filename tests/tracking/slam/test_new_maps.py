"""Where the camera stays lost a new map begins, unless that is not wanted."""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity
from motorcade.tracking import Camera
from motorcade.tracking.slam import SlamSettings, VisualSlam

View = Callable[[Motor], tuple[np.ndarray, np.ndarray]]

CAMERA = Camera(400, 300, 320.0, 320.0, 199.5, 149.5)  # as the room is rendered
STEP_NS = 33_333_333
MAPPED, ELSEWHERE = 4, 6


def _poses() -> list[Motor]:
    """Some steps along one wall, and then along the one behind."""
    steps = Motor.from_twist(np.linspace(0.0, 0.1, MAPPED)[:, None] * np.eye(6)[3])
    behind = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([0.0, np.pi, 0.0]), np.zeros(3)
    )
    more = Motor.from_twist(np.linspace(0.0, 0.1, ELSEWHERE)[:, None] * np.eye(6)[3])
    return [*steps, *(behind @ more)]


@pytest.mark.parametrize("new_maps", [True, False])
def test_a_camera_put_elsewhere_begins_a_new_map_at_its_third_frame(
    view: View, new_maps: bool
) -> None:
    slam, frames = VisualSlam(CAMERA, SlamSettings(new_maps=new_maps)), []
    poses = _poses()
    for index, pose in enumerate(poses):
        frames.append(slam.track(index * STEP_NS, *view(pose)))
    result = slam.finish()
    states = [frame.state for frame in frames[MAPPED:]]
    if not new_maps:
        assert states == ["lost"] * ELSEWHERE
        assert not result.separate
        return
    assert states == ["lost"] * 2 + ["tracking"] * (ELSEWHERE - 2)
    assert [frame.map_number for frame in frames[MAPPED + 2 :]] == [1] * (ELSEWHERE - 2)
    # The tie between equally many frames goes to the first.
    assert result.trajectory is not None
    assert len(result.trajectory) == MAPPED
    (apart,) = result.separate
    assert apart.trajectory is not None
    first = poses[MAPPED + 2]
    for stamp, pose in zip(apart.trajectory.time_ns, apart.trajectory.motors, strict=True):
        expected = first.inverse() @ poses[round(stamp / STEP_NS)]
        assert np.abs(pose.local(expected)).max() < 0.01
    told = [one.kind for one in result.history.events]
    assert told == ["map begun", "lost", "map begun"]


def test_a_map_taken_to_another_world_leaves_the_others_where_they_are(view: View) -> None:
    slam = VisualSlam(CAMERA)
    for index, pose in enumerate(_poses()):
        frame = slam.track(index * STEP_NS, *view(pose))
    assert frame.map_number == 1
    away = Motor.from_translation([1.0, 2.0, 3.0])
    slam.rescale(Similarity.from_motor_scale(away))
    result = slam.finish(adjust=False)
    (apart,) = result.separate
    for map_and_path, first in ((result, Motor.identity()), (apart, away)):
        assert map_and_path.trajectory is not None
        for poses in (map_and_path.map.world_T_camera, map_and_path.trajectory.motors):
            assert np.abs(poses[0].local(first)).max() < 1e-9
    assert result.online is not None
    assert np.abs(result.online.motors[0].translation_m).max() < 1e-9


def test_a_map_that_is_recognised_in_vain_does_not_become_the_one_that_is_tracked_in(
    view: View, monkeypatch: pytest.MonkeyPatch
) -> None:
    slam, poses = VisualSlam(CAMERA), _poses()
    for index, pose in enumerate(poses):
        slam.track(index * STEP_NS, *view(pose))
    stamps = slam.snapshot().time_ns
    assert stamps[0] > 0
    monkeypatch.setattr("motorcade.tracking.slam.slam.is_reliable", lambda *_: False)
    assert slam.track(len(poses) * STEP_NS, *view(poses[0])).state == "lost"
    np.testing.assert_array_equal(slam.snapshot().time_ns, stamps)
