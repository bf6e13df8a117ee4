"""Planar poses: exact truth, OpenCV's and SciPy's answers, and the noise they claim."""

import cv2
import numpy as np
import pytest
from scipy.optimize import least_squares

from motorcade.ga import Motor
from motorcade.tracking import Camera, Checkerboard, SingleMarker, TrackingError
from motorcade.tracking.board_tracking.tracker import choose_pose
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.pose import SIGMA_FLOOR_PX, planar_candidates, refine, reprojection_px

CHECKERS = Checkerboard(9, 6, 0.03)
TAG = SingleMarker("tag36h11", 5, 0.05)
CAMERAS = [
    Camera(752, 480, 458.7, 457.3, 367.2, 248.4, "radtan", (-0.28, 0.07, 2e-4, 2e-5)),
    Camera(752, 480, 380.8, 380.3, 367.2, 248.4, "equidistant", (-0.01, 0.01, -0.01, 0.002)),
]
every_camera = pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.model)


def seen(board, camera: Camera, pose: Motor, noise_px: float = 0.0, seed: int = 0) -> BoardCorners:
    """Corners as the camera sees them from the pose, with noise a coordinate."""
    pixels = camera.project(pose.inverse().apply(board.points_m))
    noise = noise_px * np.random.default_rng(seed).standard_normal(pixels.shape)
    return BoardCorners(np.arange(len(pixels)), pixels + noise, board.points_m)


def angle_deg(a: Motor, b: Motor) -> float:
    return float(np.degrees((a.inverse() @ b).rotor.angle()))


@every_camera
def test_exact_corners_give_the_exact_pose_among_two(camera: Camera, look_at) -> None:
    for tilt_deg, roll_deg in ((0.0, 0.0), (10.0, 200.0), (50.0, -60.0)):
        pose = look_at(CHECKERS, 0.4, tilt_deg, 70.0, roll_deg)
        corners = seen(CHECKERS, camera, pose)
        found = planar_candidates(corners, camera)
        assert found.world_T_camera.shape == (2,)
        assert found.error_px[0] < 1e-5
        np.testing.assert_allclose(found.world_T_camera[0].as_matrix(), pose.as_matrix(), atol=1e-6)
        exact = refine(corners, camera, found.world_T_camera[0])
        np.testing.assert_allclose(exact.world_T_camera.as_matrix(), pose.as_matrix(), atol=1e-9)


@every_camera
def test_the_camera_stands_before_the_printed_face(camera: Camera, look_at) -> None:
    corners = seen(CHECKERS, camera, look_at(CHECKERS, 0.4, 35.0, 20.0))
    assert np.all(planar_candidates(corners, camera).world_T_camera.translation_m[:, 2] > 0.0)


def test_the_second_pose_is_the_first_mirrored_in_the_line_of_sight(look_at) -> None:
    camera = CAMERAS[0].undistorted()
    pose = look_at(TAG, 1.5, 30.0, 40.0)
    found = planar_candidates(seen(TAG, camera, pose), camera)
    views = found.world_T_camera.inverse()
    normals = views.rotor.apply(np.array([0.0, 0.0, 1.0]))
    sight = views.apply(np.array([0.025, -0.025, 0.0]))
    sight /= np.linalg.norm(sight, axis=-1, keepdims=True)
    tilts = np.degrees(np.arccos(-np.sum(normals * sight, axis=-1)))
    np.testing.assert_allclose(tilts, 30.0, atol=1.0)
    mirrored = 2.0 * (normals[0] @ sight[0]) * sight[0] - normals[0]
    assert np.degrees(np.arccos(min(normals[1] @ mirrored, 1.0))) < 2.0
    assert found.error_px[0] < 1e-5 < found.error_px[1] < 0.5


@every_camera
def test_refinement_finds_scipys_minimum(camera: Camera, look_at) -> None:
    pose = look_at(CHECKERS, 0.45, 30.0, 110.0, 15.0)
    corners = seen(CHECKERS, camera, pose, 0.5, seed=4)

    def residuals(twist: np.ndarray) -> np.ndarray:
        moved = pose @ Motor.from_twist(twist)
        return (
            camera.project(moved.inverse().apply(corners.points_m)) - corners.corners_px
        ).ravel()

    theirs = least_squares(residuals, np.zeros(6), method="lm", xtol=1e-15, ftol=1e-15)
    start = pose @ Motor.from_twist([0.05, -0.04, 0.03, 0.01, 0.02, -0.03])
    ours = refine(corners, camera, start)
    expected = pose @ Motor.from_twist(theirs.x)
    np.testing.assert_allclose(ours.world_T_camera.as_matrix(), expected.as_matrix(), atol=1e-7)
    np.testing.assert_allclose(ours.residuals_px.ravel(), theirs.fun, atol=1e-4)
    np.testing.assert_allclose(ours.error_px, np.sqrt(2.0 * np.mean(theirs.fun**2)), rtol=1e-6)
    freedom = 2 * len(corners) - 6
    sigma = np.sqrt(theirs.fun @ theirs.fun / freedom)
    np.testing.assert_allclose(ours.sigma_px, sigma, rtol=1e-6)


def test_refinement_is_as_good_as_opencvs(look_at) -> None:
    camera = CAMERAS[0]
    corners = seen(CHECKERS, camera, look_at(CHECKERS, 0.45, 30.0), 0.4, seed=2)
    ours = refine(corners, camera, planar_candidates(corners, camera).world_T_camera[0])
    view = ours.world_T_camera.inverse().as_matrix()
    rotation, _ = cv2.Rodrigues(view[:3, :3])
    theirs = cv2.solvePnPRefineLM(
        corners.points_m,
        corners.corners_px,
        camera.matrix,
        np.array(camera.distortion),
        rotation,
        view[:3, 3:],
    )
    projected, _ = cv2.projectPoints(
        corners.points_m, *theirs, camera.matrix, np.array(camera.distortion)
    )
    error = np.sqrt(np.mean(np.sum((projected[:, 0] - corners.corners_px) ** 2, axis=1)))
    np.testing.assert_allclose(ours.error_px, error, rtol=1e-6)
    np.testing.assert_allclose(
        reprojection_px(corners, camera, ours.world_T_camera), error, rtol=1e-6
    )


@every_camera
def test_covariance_is_that_of_the_error_in_the_camera_frame(camera: Camera, look_at) -> None:
    """Over many draws the mean normalised squared error is 6, direction by direction 1."""
    pose = look_at(CHECKERS, 0.45, 25.0, 60.0, 30.0)
    whitened = []
    for seed in range(250):
        corners = seen(CHECKERS, camera, pose, 0.4, seed)
        found = refine(corners, camera, pose)
        delta = (found.world_T_camera.inverse() @ pose).as_twist()
        whitened.append(np.linalg.solve(np.linalg.cholesky(found.covariance), delta))
    squares = np.square(whitened)
    # 5 standard deviations of the mean of 250 chi-square draws
    assert abs(squares.sum(axis=1).mean() - 6.0) < 5.0 * np.sqrt(12.0 / 250)
    assert np.abs(squares.mean(axis=0) - 1.0).max() < 5.0 * np.sqrt(2.0 / 250)
    np.testing.assert_array_equal(found.covariance, found.covariance.T)


def test_claimed_noise_has_a_floor(look_at) -> None:
    pose = look_at(CHECKERS, 0.45, 25.0)
    found = refine(seen(CHECKERS, CAMERAS[0], pose), CAMERAS[0], pose)
    assert found.sigma_px == SIGMA_FLOOR_PX


def test_leading_choice_is_the_smaller_error_and_history_corrects_it(look_at) -> None:
    """A small tag far away flips by itself; the camera's steady motion says which pose is true."""
    camera = CAMERAS[0].undistorted()
    alone = steady = flips = 0
    before = None
    frames = 120
    last_alone = None
    for frame in range(frames):
        phase = frame / 30.0
        pose = look_at(TAG, 0.9, 20.0 + 12.0 * np.sin(3.0 * phase), 60.0 * phase)
        corners = seen(TAG, camera, pose, 0.12, seed=frame)
        candidates = planar_candidates(corners, camera)
        best = min(angle_deg(pose, one) for one in candidates.world_T_camera)
        single = choose_pose(candidates, corners, camera)
        before = choose_pose(candidates, corners, camera, before, 1 / 30)
        wrong = angle_deg(pose, single.pose.world_T_camera) > best + 5.0
        alone += wrong
        steady += angle_deg(pose, before.pose.world_T_camera) > best + 5.0
        flips += last_alone is not None and wrong != last_alone
        last_alone = wrong
    assert flips > 5
    assert steady < 0.5 * alone
    assert before.candidates.shape == before.costs.shape == (2,)


def test_choice_needs_time_to_pass(look_at) -> None:
    corners = seen(TAG, CAMERAS[0], look_at(TAG, 0.5, 20.0))
    candidates = planar_candidates(corners, CAMERAS[0])
    first = choose_pose(candidates, corners, CAMERAS[0])
    with pytest.raises(ValueError, match="elapsed_s: expected seconds above 0, got 0"):
        choose_pose(candidates, corners, CAMERAS[0], first, 0.0)


def test_corners_that_carry_no_pose_are_refused(look_at) -> None:
    camera, pose = CAMERAS[0], look_at(CHECKERS, 0.45, 25.0)
    corners = seen(CHECKERS, camera, pose)
    three = corners.keep(np.isin(corners.ids, [0, 8, 45]))
    line = corners.keep(corners.ids < 9)
    for few in (three, line):
        with pytest.raises(TrackingError, match="at least four that do not lie on one line"):
            planar_candidates(few, camera)
        with pytest.raises(TrackingError, match="at least four that do not lie on one line"):
            refine(few, camera, pose)
    with pytest.raises(TrackingError, match="every corner before the camera"):
        refine(corners, camera, pose @ Motor.from_twist([np.pi, 0, 0, 0, 0, 0]))
    folding = Camera(752, 480, 100.0, 100.0, 376.0, 240.0, "radtan", (-0.4, 0.0))
    with pytest.raises(TrackingError, match="that the lens model covers"):
        planar_candidates(corners.at(corners.corners_px + 300.0), folding)


def test_head_on_views_are_found_whatever_the_last_bits_are(look_at) -> None:
    for distance_m in np.linspace(0.3, 0.6, 40):
        pose = look_at(CHECKERS, distance_m, 0.0, 70.0, 0.0)
        found = planar_candidates(seen(CHECKERS, CAMERAS[0], pose), CAMERAS[0])
        assert found.error_px[0] < 1e-2
