"""Poses of single markers: both candidates, the true one among them, and how ambiguous they are."""

import cv2
import numpy as np
import pytest

from motorcade.tracking import Camera, Detection, SingleMarker, TrackingError, pose_marker
from motorcade.tracking.markers.planar import planar_poses

SIDE_M = 0.1
CAMERA = Camera(480, 360, 420.0, 418.0, 242.3, 176.8)
BOARD = SingleMarker("tag36h11", 5, SIDE_M)


def seen_from(pose, camera: Camera = CAMERA) -> Detection:
    corners = camera.project(pose.inverse().apply(BOARD.points_m))
    return Detection("tag36h11", 5, corners, 0, 1.0, True)


@pytest.mark.parametrize("tilt_deg", [5.0, 30.0, 60.0])
def test_the_true_pose_comes_first_and_both_reproject(tilt_deg: float, look_at) -> None:
    pose = look_at(BOARD, 0.5, tilt_deg, 70.0, 25.0)
    posed = pose_marker(seen_from(pose), CAMERA, SIDE_M)
    away = posed.candidates.world_T_camera[0].inverse() @ pose
    assert np.abs(away.log()).max() < 1e-5
    assert posed.candidates.error_px[0] < 1e-4 < posed.candidates.error_px[1]
    assert 0.0 <= posed.ambiguity < 0.01


def test_as_opencv_sees_it(look_at) -> None:
    """OpenCV's own single-marker convention has its origin in the middle, with the same axes."""
    pose = look_at(BOARD, 0.5, 35.0, 70.0, 25.0)
    found = seen_from(pose)
    half = 0.5 * SIDE_M
    square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    _, turn, move = cv2.solvePnP(
        square, found.corners_px, CAMERA.matrix, None, flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    camera_T_marker = pose_marker(found, CAMERA, SIDE_M).camera_T_marker[0]
    np.testing.assert_allclose(camera_T_marker.rotor.as_matrix(), cv2.Rodrigues(turn)[0], atol=1e-5)
    np.testing.assert_allclose(camera_T_marker.apply([half, -half, 0.0]), move.ravel(), atol=1e-5)


def test_far_away_the_two_cannot_be_told_apart(look_at, rng: np.random.Generator) -> None:
    near, far = (
        [
            pose_marker(
                Detection(
                    "tag36h11",
                    5,
                    seen_from(pose).corners_px + 0.1 * rng.standard_normal((4, 2)),
                    0,
                    1.0,
                    True,
                ),
                CAMERA,
                SIDE_M,
            ).ambiguity
            for _ in range(40)
        ]
        for pose in (look_at(BOARD, 0.3, 50.0, 70.0), look_at(BOARD, 3.0, 20.0, 70.0))
    )
    assert np.median(near) < 0.1
    assert np.median(far) > 0.4
    assert max(near + far) <= 1.0


def test_what_gives_no_pose_is_refused(look_at) -> None:
    found = seen_from(look_at(BOARD, 0.5, 20.0))
    with pytest.raises(ValueError, match="side_m: expected metres above 0, got -1"):
        pose_marker(found, CAMERA, -1)
    folding = Camera(480, 360, 420.0, 418.0, 242.3, 176.8, "radtan", (-40.0, 0.0))
    with pytest.raises(TrackingError, match="pixels that the lens model covers"):
        pose_marker(found, folding, SIDE_M)
    with pytest.raises(ValueError, match=r"Detection\.corners_px: expected \(4, 2\)"):
        Detection("tag36h11", 5, np.zeros((3, 2)), 0, 1.0, True)


def test_a_marker_shrunk_to_a_point_has_no_pose_and_harms_no_other(look_at) -> None:
    whole = seen_from(look_at(BOARD, 0.5, 30.0, 70.0, 25.0)).corners_px
    around = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    tiny = [(100.0, 50.0) + 10.0**power * around for power in range(-14, -5)]
    rows, poses, errors = planar_poses(CAMERA, np.stack([*tiny, whole]), np.full(10, 0.1))
    assert rows[-1] == 9
    alone = planar_poses(CAMERA, whole[None], np.array([0.1]))
    assert poses[-1:].isclose(alone[1]).all()
    assert errors[-1:] == pytest.approx(alone[2])
