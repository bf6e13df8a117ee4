"""Calibration: known cameras come back, as OpenCV finds them; bad views go; doubt is refused."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.tracking import (
    CalibrationError,
    Camera,
    CharucoBoard,
    Checkerboard,
    MarkerGrid,
    calibrate,
)
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.calibrate import spread_views

BOARD = Checkerboard(9, 6, 0.03)
CAMERAS = [
    Camera(640, 480, 520.0, 515.0, 330.0, 231.0),
    Camera(752, 480, 420.0, 421.0, 355.0, 250.0, "radtan", (-0.29, 0.08, 1e-3, -8e-4)),
    Camera(640, 512, 190.0, 190.5, 318.0, 260.0, "equidistant", (0.02, -0.01, 0.004, -0.001)),
]
every_camera = pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.model)


def truth_of(camera: Camera) -> np.ndarray:
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])


def seen_by(camera: Camera, poses: list[Motor], noise_px: float, rng) -> list[BoardCorners]:
    """Corners with noise, of poses from which the whole board is in the image."""
    views = []
    for pose in poses:
        pixels = camera.project(pose.inverse().apply(BOARD.points_m))
        inside = np.isfinite(pixels).all() and np.all(pixels > 5.0)
        if inside and np.all(pixels < (camera.width - 6.0, camera.height - 6.0)):
            noisy = pixels + noise_px * rng.standard_normal(pixels.shape)
            views.append(BoardCorners(np.arange(len(pixels)), noisy, BOARD.points_m))
    return views


def around(look_at, camera: Camera, rng, count: int, tilt_deg: float = 45.0) -> list[Motor]:
    """Poses on all sides of the board, moved so that it fills different parts of the image."""
    poses = []
    for _ in range(count):
        distance = 0.0006 * camera.fx * rng.uniform(0.8, 1.6)
        tilt, azimuth, roll = rng.uniform((0, 0, 0), (tilt_deg, 360, 360))
        pose = look_at(BOARD, distance, tilt, azimuth, roll)
        aside = Motor.from_twist([*rng.uniform(-0.35, 0.35, 2), 0.0, 0.0, 0.0, 0.0])
        poses.append(pose @ aside)
    return poses


@pytest.mark.quick_every(2)
@every_camera
def test_known_cameras_come_back_within_what_is_claimed(camera: Camera, look_at, rng) -> None:
    """Six calibrations: errors over their claimed deviations are standard normal."""
    scores = []
    for _ in range(6):
        views = seen_by(camera, around(look_at, camera, rng, 40), 0.2, rng)[:14]
        found = calibrate(views, (camera.width, camera.height), camera.model)
        assert found.used.all()
        assert found.rmse_px == pytest.approx(0.2 * np.sqrt(2.0), rel=0.1)
        scores.append((truth_of(found.camera) - truth_of(camera)) / found.deviation)
    assert np.abs(np.mean(scores, axis=0)).max() < 1.5
    assert 0.7 < np.sqrt(np.mean(np.square(scores))) < 1.3


@every_camera
def test_exact_corners_give_the_exact_camera(camera: Camera, look_at, rng) -> None:
    views = seen_by(camera, around(look_at, camera, rng, 40), 0.0, rng)[:10]
    found = calibrate(views, (camera.width, camera.height), camera.model)
    np.testing.assert_allclose(truth_of(found.camera), truth_of(camera), rtol=1e-5, atol=1e-6)
    assert found.rmse_px < 1e-5


def test_as_opencv_calibrates(look_at, rng) -> None:
    camera = CAMERAS[1]
    views = seen_by(camera, around(look_at, camera, rng, 40), 0.2, rng)[:14]
    ours = calibrate(views, (752, 480), "radtan")
    points = [view.points_m.astype(np.float32) for view in views]
    pixels = [view.corners_px.astype(np.float32)[:, None] for view in views]
    rmse, matrix, lens, *_ = cv2.calibrateCamera(
        points, pixels, (752, 480), None, None, flags=cv2.CALIB_FIX_K3
    )
    assert ours.rmse_px == pytest.approx(rmse, rel=1e-5)
    np.testing.assert_allclose(ours.camera.matrix, matrix, atol=0.01)
    np.testing.assert_allclose(ours.camera.distortion, lens.ravel()[:4], atol=1e-4)


@pytest.mark.quick_every(3)
@pytest.mark.parametrize(
    "board",
    [
        BOARD,
        CharucoBoard("aruco_5x5_100", 7, 5, 0.04, 0.03),
        MarkerGrid("tag36h11", 4, 3, 0.05, 0.015),
    ],
    ids=["checkerboard", "charuco", "marker_grid"],
)
def test_images_of_every_kind_of_board(board, render, look_at, rng) -> None:
    camera = Camera(480, 360, 300.0, 301.0, 238.0, 183.0, "radtan", (-0.28, 0.07, 2e-4, -3e-4))
    views = []
    for index in range(8):
        tilt, azimuth = 20.0 + 25.0 * (index % 2), 45.0 * index
        aside = Motor.from_twist([*rng.uniform(-0.12, 0.12, 2), 0.0, 0.0, 0.0, 0.0])
        pose = look_at(board, 0.36, tilt, azimuth, 77.0 * index) @ aside
        found = board.detect(render(board, camera, pose, blur_px=0.8, noise=2.0, seed=index))
        if found is not None:
            views.append(found)
    assert len(views) >= 6
    found = calibrate(views, (480, 360), "radtan")
    away = np.abs(truth_of(found.camera) - truth_of(camera))
    assert found.rmse_px < 0.25
    assert away[:2].max() < 0.004 * 300.0
    assert away[2:4].max() < 1.5


def test_views_that_do_not_fit_are_left_out(look_at, rng) -> None:
    camera = CAMERAS[1]
    views = seen_by(camera, around(look_at, camera, rng, 60), 0.1, rng)[:16]
    bad = [3, 11]
    views[3] = views[3].at(np.roll(views[3].corners_px, 9, axis=0))  # numbered a row too far
    views[11] = views[11].at(views[11].corners_px + 4.0 * rng.standard_normal((54, 2)))
    found = calibrate(views, (752, 480), "radtan")
    np.testing.assert_array_equal(np.flatnonzero(~found.used), bad)
    assert np.abs(truth_of(found.camera) - truth_of(camera))[:4].max() < 3.0
    assert found.view_error_px[bad].min() > 1.0
    assert found.view_error_px[found.used].max() < 0.3
    assert len(found.camera_T_board) == 14


def test_what_the_views_do_not_tell_is_refused(look_at, rng) -> None:
    camera = CAMERAS[0]
    size = (640, 480)
    good = seen_by(camera, around(look_at, camera, rng, 20), 0.1, rng)[:6]
    with pytest.raises(CalibrationError, match="at least 3 that show the board, got 2"):
        calibrate(good[:2], size)
    flat = [
        look_at(BOARD, distance) @ Motor.from_twist([0, 0, 0, x, y, 0])
        for distance in (0.35, 0.45, 0.6)
        for x in (-0.03, 0.0, 0.03)
        for y in (-0.02, 0.02)
    ]
    for noise_px in (0.0, 0.1):
        views = seen_by(camera, flat, noise_px, rng)
        assert len(views) >= 10
        with pytest.raises(CalibrationError, match="tilt"):
            calibrate(views, size, "pinhole")
    with pytest.raises(CalibrationError, match="fix focal length and centre to 5 %"):
        calibrate(seen_by(camera, around(look_at, camera, rng, 40, 6.0), 2.0, rng)[:3], size)
    noise = [view.at(rng.uniform(0, 480, (54, 2))) for view in good]
    with pytest.raises(CalibrationError):
        calibrate(noise, size)
    with pytest.raises(ValueError, match="model: expected pinhole, radtan, equidistant, got 'fov'"):
        calibrate(good, size, "fov")
    with pytest.raises(ValueError, match=r"views\[1\]: expected four corners that span"):
        calibrate([good[0], good[1].keep(np.arange(54) < 9), good[2]], size)


def test_spread_views_are_the_different_ones(look_at, rng) -> None:
    camera = CAMERAS[0]
    apart = seen_by(camera, around(look_at, camera, rng, 40), 0.0, rng)[:5]
    assert len(apart) == 5
    video = [view for view in apart for _ in range(10)]
    chosen = spread_views(video, 5)
    np.testing.assert_array_equal(chosen // 10, np.arange(5))
    np.testing.assert_array_equal(spread_views(apart, 9), np.arange(5))


def test_coverage_is_the_share_of_cells_with_corners(look_at, rng) -> None:
    camera = CAMERAS[0]
    views = seen_by(camera, around(look_at, camera, rng, 40), 0.1, rng)[:12]
    found = calibrate(views, (640, 480), "pinhole")
    cells = {(int((x + 0.5) // 80), int((y + 0.5) // 80)) for v in views for x, y in v.corners_px}
    assert found.coverage(views) == pytest.approx(len(cells) / 48)
    assert found.turn_deg > 30.0


def test_the_checkerboard_recordings_own_camera(data_dir: Path) -> None:
    folder = data_dir / "replays" / "vamr_board"
    board = Checkerboard(9, 6, 0.04)
    files = sorted((folder / "images").iterdir())[::10]
    views = [board.detect(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)) for path in files]
    found = calibrate([view for view in views if view is not None], (752, 480), "radtan")
    given = np.loadtxt(folder / "K.txt")
    assert found.rmse_px < 0.1
    assert abs(found.camera.fx / given[0, 0] - 1.0) < 0.012
    assert abs(found.camera.cx - given[0, 2]) < 4.0
    assert abs(found.camera.cy - given[1, 2]) < 6.0
