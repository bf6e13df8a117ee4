"""Cameras against OpenCV's own projections, finite differences and their own inverses."""

import cv2
import numpy as np
import pytest

from motorcade.tracking import Camera

RADTAN = (-0.2834, 0.0739, 1.9e-4, 1.8e-5, 0.021, 0.013, -0.04, 0.006)
EQUIDISTANT = (-0.0086, 0.0124, -0.0081, 0.0021)
CAMERAS = [
    Camera(752, 480, 458.7, 457.3, 367.2, 248.4),
    *(Camera(752, 480, 458.7, 457.3, 367.2, 248.4, "radtan", RADTAN[:n]) for n in (2, 4, 5, 8)),
    Camera(752, 480, 380.8, 380.3, 367.2, 248.4, "equidistant", EQUIDISTANT),
]


def name(camera: Camera) -> str:
    return f"{camera.model}{len(camera.distortion)}"


every_camera = pytest.mark.parametrize("camera", CAMERAS, ids=name)


def in_view(camera: Camera, shape: tuple[int, ...]) -> np.ndarray:
    """Points from 0.2 to 5 m away that the camera sees."""
    rng = np.random.default_rng(3)
    pixels = rng.uniform([0, 0], [camera.width - 1, camera.height - 1], (*shape, 2))
    return camera.unproject(pixels) * rng.uniform(0.2, 5.0, (*shape, 1))


def opencv_projection(camera: Camera, points: np.ndarray) -> np.ndarray:
    coefficients, still = np.array(camera.distortion), np.zeros(3)
    if camera.model == "equidistant":
        seen, _ = cv2.fisheye.projectPoints(
            points.reshape(-1, 1, 3), still, still, camera.matrix, coefficients
        )
    else:
        padded = np.zeros(max(4, len(coefficients)))
        padded[: len(coefficients)] = coefficients
        seen, _ = cv2.projectPoints(points.reshape(-1, 3), still, still, camera.matrix, padded)
    return seen.reshape(*points.shape[:-1], 2)


@every_camera
def test_projection_is_opencvs(camera: Camera) -> None:
    points = in_view(camera, (50, 4))
    np.testing.assert_allclose(camera.project(points), opencv_projection(camera, points), atol=1e-9)


@every_camera
def test_unprojection_undoes_projection_over_the_whole_image(camera: Camera) -> None:
    columns, rows = np.meshgrid(np.linspace(0, 751, 40), np.linspace(0, 479, 30))
    pixels = np.stack([columns, rows], axis=-1)
    rays = camera.unproject(pixels)
    assert np.all(rays[..., 2] == 1.0)
    np.testing.assert_allclose(opencv_projection(camera, rays), pixels, atol=1e-8)


@every_camera
def test_jacobian_is_the_slope_of_the_projection(camera: Camera) -> None:
    points = np.concatenate([in_view(camera, (20,)), [[0.0, 0.0, 0.7], [1e-9, 0.0, 1.0]]])
    pixels, jacobian = camera.project_jacobian(points)
    np.testing.assert_array_equal(pixels, camera.project(points))
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = 1e-6
        slope = (camera.project(points + step) - camera.project(points - step)) / 2e-6
        np.testing.assert_allclose(jacobian[..., axis], slope, rtol=1e-6, atol=2e-4)


@every_camera
def test_leading_dimensions_are_batch(camera: Camera) -> None:
    points = in_view(camera, (2, 3))
    np.testing.assert_array_equal(camera.project(points)[1, 2], camera.project(points[1, 2]))
    pixels = camera.project(points)
    np.testing.assert_allclose(camera.unproject(pixels)[1, 2], camera.unproject(pixels[1, 2]))
    assert camera.project(np.empty((0, 3))).shape == (0, 2)


@every_camera
def test_the_optical_axis_meets_the_principal_point(camera: Camera) -> None:
    np.testing.assert_allclose(camera.project([0.0, 0.0, 2.0]), [367.2, 248.4])


@pytest.mark.parametrize("camera", CAMERAS[:3], ids=name)
def test_points_behind_have_no_image(camera: Camera) -> None:
    assert np.isnan(camera.project([[0.1, 0.0, -1.0], [0.1, 0.0, 0.0]])).all()
    assert np.isnan(camera.project_jacobian([0.1, 0.0, -1.0])[1]).all()


def test_an_equidistant_lens_sees_beyond_ninety_degrees() -> None:
    camera = Camera(640, 640, 100.0, 100.0, 320.0, 320.0, "equidistant", (0.0,) * 4)
    np.testing.assert_allclose(camera.project([1.0, 0.0, 0.0]), [320 + 100 * np.pi / 2, 320])
    np.testing.assert_allclose(camera.project([1.0, 0.0, -1.0]), [320 + 75 * np.pi, 320])
    assert np.isnan(camera.unproject([320.0 + 100.0 * np.pi / 2, 320.0])[:2]).all()


def test_pixels_beyond_the_fold_have_no_ray() -> None:
    # x (1 - 0.4 x^2) reaches its largest value, 0.6086, at x = 0.9129
    camera = Camera(200, 100, 100.0, 100.0, 100.0, 50.0, "radtan", (-0.4, 0.0))
    assert np.isnan(camera.unproject([100.0 + 61.0, 50.0])[:2]).all()
    near = camera.unproject([100.0 + 60.8, 50.0])
    assert 0.88 < near[0] < 0.9129


def test_undistorted_images_are_opencvs() -> None:
    camera = CAMERAS[2]
    image = np.random.default_rng(0).integers(0, 256, (480, 752, 3), dtype=np.uint8)
    image = cv2.GaussianBlur(image, (0, 0), 3.0)
    expected = cv2.undistort(image, camera.matrix, np.array(camera.distortion))
    difference = np.abs(camera.undistort_image(image).astype(int) - expected)
    assert difference.max() <= 2
    grey = camera.undistort_image(np.ascontiguousarray(image[..., 0]))
    assert np.abs(grey.astype(int) - expected[..., 0]).max() <= 2


@every_camera
def test_undistorted_images_show_what_the_straight_camera_projects(camera: Camera) -> None:
    spot = np.array([0.21, -0.13, 1.0])
    columns, rows = np.meshgrid(np.arange(752), np.arange(480))
    u, v = camera.project(spot)
    blob = 255 * np.exp(-0.5 * ((columns - u) ** 2 + (rows - v) ** 2) / 4.0**2)
    straight = camera.undistort_image(np.rint(blob).astype(np.uint8)).astype(float)
    centre = [(straight * columns).sum() / straight.sum(), (straight * rows).sum() / straight.sum()]
    # the lens stretches the blob a little more on one side
    np.testing.assert_allclose(centre, camera.undistorted().project(spot), atol=0.2)


@every_camera
def test_straightening_and_bending_undo_each_other(camera: Camera) -> None:
    pixels = np.random.default_rng(5).uniform([0, 0], [751, 479], (100, 2))
    np.testing.assert_allclose(camera.distort(camera.undistort(pixels)), pixels, atol=1e-8)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"fx": 0.0}, r"Camera\.fx: expected pixels above 0, got 0"),
        ({"fy": -400.0}, r"Camera\.fy"),
        ({"cx": float("nan")}, r"Camera\.cx: expected a finite number, got nan"),
        ({"fx": "458"}, r"Camera\.fx: expected a number, got '458'"),
        ({"width": 0}, r"Camera\.width"),
        ({"height": 480.5}, r"Camera\.height"),
        ({"model": "fov"}, r"Camera\.model: expected pinhole or radtan or equidistant, got 'fov'"),
        (
            {"distortion": (0.1, 0.2, 0.3)},
            r"Camera\.distortion: radtan expects 2 or 4 or 5 or 8 coefficients, got 3",
        ),
        ({"model": "pinhole", "distortion": (0.1,)}, r"pinhole expects 0 coefficients, got 1"),
        ({"model": "equidistant", "distortion": (0.1,)}, r"equidistant expects 4 .* got 1"),
        ({"distortion": (0.1, float("inf"))}, r"Camera\.distortion: expected a finite number"),
    ],
)
def test_bad_intrinsics_are_refused(change: dict[str, object], told: str) -> None:
    good = {"width": 752, "height": 480, "fx": 458.0, "fy": 457.0, "cx": 367.0, "cy": 248.0}
    with pytest.raises(ValueError, match=told):
        Camera(**{**good, "model": "radtan", "distortion": (0.1, 0.2), **change})


def test_bad_points_and_images_are_refused() -> None:
    camera = CAMERAS[1]
    with pytest.raises(ValueError, match=r"points_camera: expected shape \(\*, 3\)"):
        camera.project([1.0, 2.0])
    with pytest.raises(ValueError, match="pixels: expected finite"):
        camera.unproject([1.0, np.nan])
    with pytest.raises(ValueError, match="expected 752 x 480 pixels, got 480 x 752"):
        camera.undistort_image(np.zeros((752, 480), np.uint8))
    with pytest.raises(ValueError, match="expected a uint8 image"):
        camera.undistort_image(np.zeros((480, 752)))
