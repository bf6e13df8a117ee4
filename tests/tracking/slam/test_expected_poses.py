"""What others tell SLAM: where the camera should be, and how long a unit of its map is."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity
from motorcade.tracking.slam import VisualSlam
from tests.tracking.slam.conftest import CAMERA, Poses, View

STEP_NS = 33_000_000


def test_a_jump_is_tracked_where_it_is_expected(view: View, swaying: Poses):
    poses = swaying(6)
    jump = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([0.05, 0.25, 0.1]), [0.05, 0.0, 0.1]
    )
    poses.append(poses[-1] @ jump)
    states = []
    for expected in (None, poses[0].inverse() @ poses[-1]):
        slam = VisualSlam(CAMERA)
        for step, pose in enumerate(poses):
            last = step == len(poses) - 1
            gray, depth = view(pose)
            frame = slam.track(step * STEP_NS, gray, depth, predicted=expected if last else None)
        states.append(frame.state)
    assert states == ["relocalised", "tracking"]
    assert frame.world_T_camera is not None
    off = frame.world_T_camera.local(poses[0].inverse() @ poses[-1])
    assert np.abs(off).max() < 5e-3


def test_a_lost_camera_is_found_where_it_is_expected(view: View, swaying: Poses):
    poses = swaying(8)
    slam = VisualSlam(CAMERA)
    for step, pose in enumerate(poses[:6]):
        slam.track(step * STEP_NS, *view(pose))
    black = np.zeros((CAMERA.height, CAMERA.width), np.uint8)
    expected = poses[0].inverse() @ poses[7]
    assert slam.track(6 * STEP_NS, black, predicted=expected).state == "lost"
    frame = slam.track(7 * STEP_NS, *view(poses[7]), predicted=expected)
    assert frame.state == "relocalised"
    assert np.abs(frame.world_T_camera.local(expected)).max() < 5e-3


def test_all_that_was_said_goes_along_to_another_unit(view: View, swaying: Poses):
    turned = Motor.from_rotor_translation(Rotor.from_rotation_vector([0.2, 0.1, 0.3]), [1, 2, 3])
    similarity = Similarity.from_motor_scale(turned, 2.0)
    poses = swaying(40)
    results = []
    for rescaled in (False, True):
        slam = VisualSlam(CAMERA)
        for step, pose in enumerate(poses):
            frame = slam.track(step * STEP_NS, view(pose)[0])
            if rescaled and step == 30:
                assert not slam.metric
                slam.rescale(similarity)
                assert slam.metric
        results.append(slam.finish(adjust=False))
        assert frame.state == "tracking"
    plain, moved = (result.trajectory.motors for result in results)
    assert len(plain.coefficients) > 30
    places = similarity.apply(plain.translation_m)
    np.testing.assert_allclose(moved.translation_m, places, atol=0.02)
    apart = (turned.rotor @ plain.rotor).inverse() @ moved.rotor
    assert np.abs(apart.as_rotation_vector()).max() < 0.01
    online = [result.online.motors.translation_m[:10] for result in results]
    np.testing.assert_allclose(online[1], similarity.apply(online[0]), atol=1e-9)
    spread, before = results[1].covariance[5], results[0].covariance[5]
    np.testing.assert_allclose(spread[3:, 3:], 4.0 * before[3:, 3:])
    np.testing.assert_allclose(spread[:3, 3:], 2.0 * before[:3, 3:])
    assert results[1].metric
    assert not results[0].metric


def test_a_map_in_metres_is_not_given_another_unit(view: View, swaying: Poses):
    slam = VisualSlam(CAMERA)
    slam.track(0, *view(swaying(1)[0]))
    slam.rescale(Similarity.from_motor_scale(Motor.identity(), 1.0))
    with pytest.raises(ValueError, match="world_T_map: expected scale 1 for a map in metres"):
        slam.rescale(Similarity.from_motor_scale(Motor.identity(), 2.0))
