"""A clip's camera from motion alone: it follows from points, and what cannot tell it is refused."""

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Camera, SelfCalibrationError, self_calibrate_motion
from motorcade.tracking.self_calibration.lens import KINDS
from motorcade.tracking.self_calibration.points import (
    PointObservations,
    PointState,
    fit_points,
    fit_with_shutter,
)
from tests.end_to_end.phones.sensor import PhoneCamera

RADIAL = KINDS[2]
SIZE = (960, 540)


def moving(count: int) -> Motor:
    t = np.linspace(0.0, 3.0, count)
    turn = Rotor.from_rotation_vector(
        np.stack([0.2 * np.sin(2.0 * t), 0.3 * np.cos(1.5 * t), 0.2 * np.sin(t)], axis=-1)
    )
    place = np.stack([0.8 * np.sin(1.3 * t), 0.4 * np.cos(t), 0.3 * np.sin(2.2 * t)], axis=-1)
    return Motor.from_rotor_translation(turn, place)


@pytest.mark.parametrize("wrong", [0.75, 1.3])
def test_a_focal_length_that_is_far_off_comes_back(wrong: float) -> None:
    """Poses and points start as a wrong lens would have them: depths stretched with its focus."""
    rng = np.random.default_rng(8)
    camera = Camera(*SIZE, 700.0, 700.0, 484.0, 266.0, "radtan", (0.06, -0.08))
    poses, points = moving(16), rng.uniform([-2.5, -1.6, 2.5], [2.5, 1.6, 6.0], (250, 3))
    px = camera.project(poses[:, None].inverse().apply(points), allow_nan=True)
    inside = np.all((px > 0.0) & (px < (SIZE[0] - 1, SIZE[1] - 1)), axis=-1)
    inside[:, np.count_nonzero(inside, axis=0) < 3] = False
    view, point = np.nonzero(inside)
    noisy = px[view, point] + 0.2 * rng.standard_normal((len(view), 2))
    wild = rng.choice(len(noisy), len(noisy) // 30, replace=False)
    noisy[wild] += rng.uniform(-60.0, 60.0, (len(wild), 2))
    known, which = np.unique(point, return_inverse=True)
    start = PointState(
        RADIAL,
        np.array([700.0 * wrong, 479.5, 269.5, 0.0, 0.0]),
        poses[0].inverse() @ poses,
        poses[0].inverse().apply(points[known]) * [1.0, 1.0, wrong],
    )
    found = fit_points(PointObservations(SIZE, view, which, noisy), start)
    sigma = np.sqrt(np.diag(found.covariance))
    error = found.state.numbers - [700.0, 484.0, 266.0, 0.06, -0.08]
    assert abs(error[0]) < 0.005 * 700.0
    assert np.all(np.abs(error) < 5.0 * sigma + [0.1, 0.1, 0.1, 1e-4, 1e-4])
    assert found.noise_px == pytest.approx(0.2, rel=0.2)


def turned_images(count: int) -> list[np.ndarray]:
    """What a camera sees of a far noisy wall while it only turns: exact homographies."""
    rng = np.random.default_rng(9)
    wall = cv2.GaussianBlur(rng.integers(0, 255, (1500, 2600)).astype(np.float32), (0, 0), 2.5)
    wall = cv2.normalize(wall, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    matrix = Camera(640, 480, 560.0, 560.0, 319.5, 239.5).matrix
    of_wall = np.array([[560.0, 0.0, 1300.0], [0.0, 560.0, 750.0], [0.0, 0.0, 1.0]])
    images = []
    for at in np.linspace(0.0, 2.0, count):
        turn = Rotor.from_rotation_vector(
            [0.2 * np.sin(2.0 * at), 0.35 * np.sin(1.5 * at), 0.1 * at]
        )
        warp = matrix @ turn.as_matrix().T @ np.linalg.inv(of_wall)
        images.append(cv2.warpPerspective(wall, warp, (640, 480)))
    return images


def test_a_camera_that_only_turns_is_refused_and_its_focal_length_told() -> None:
    images = turned_images(40)
    with pytest.raises(SelfCalibrationError, match="only turns") as refused:
        self_calibrate_motion(images, (640, 480), np.arange(40) * 33_333_333)
    told = float(str(refused.value).split("length of about ")[1].split()[0])
    assert told == pytest.approx(560.0, rel=0.1)


def test_images_of_another_size_are_refused() -> None:
    with pytest.raises(ValueError, match=r"images\[0\]: expected 64 x 48 pixels, got 48 x 64"):
        self_calibrate_motion([np.zeros((64, 48), np.uint8)], (64, 48), [0])


def test_a_camera_that_stands_still_is_refused() -> None:
    still = turned_images(1) * 12
    with pytest.raises(SelfCalibrationError, match="stands still"):
        self_calibrate_motion(still, (640, 480), np.arange(12) * 33_333_333)


@pytest.mark.parametrize(
    ("shutter_s", "axis"),
    [((-0.02, 0.0), "left"), ((0.0, 0.0), None)],
)
def test_points_tell_a_rolling_shutter_and_the_focal_length_in_spite_of_it(
    shutter_s: tuple[float, float], axis: str | None
) -> None:
    """Each line is projected at its own time; velocities are those of the path."""
    rng = np.random.default_rng(10)
    camera = Camera(*SIZE, 700.0, 700.0, 484.0, 266.0, "radtan", (0.06, -0.08))
    points, time_s = rng.uniform([-2.5, -1.6, 2.5], [2.5, 1.6, 6.0], (160, 3)), np.arange(16) / 5

    def path(at: np.ndarray) -> Motor:
        turn = np.stack([0.2 * np.sin(2.0 * at), 0.3 * np.cos(1.5 * at), 0.2 * np.sin(at)], -1)
        place = np.stack([0.8 * np.sin(1.3 * at), 0.4 * np.cos(at), 0.3 * np.sin(2.2 * at)], -1)
        return Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), place)

    phone = PhoneCamera(camera, shutter_s)
    px = np.array([phone.project(path, float(at), points) for at in time_s])
    inside = np.all((px > 0.0) & (px < (SIZE[0] - 1, SIZE[1] - 1)), axis=-1)
    inside[:, np.count_nonzero(inside, axis=0) < 3] = False
    view, point = np.nonzero(inside)
    noisy = px[view, point] + 0.2 * rng.standard_normal((len(view), 2))
    known, which = np.unique(point, return_inverse=True)
    poses = path(time_s)
    lens = np.array([690.0, 479.5, 269.5, 0.0, 0.0])
    start = PointState(
        RADIAL, lens, poses[0].inverse() @ poses, poses[0].inverse().apply(points[known])
    )
    velocity = path(time_s - 0.01).local(path(time_s + 0.01)) / 0.02
    seen = PointObservations(SIZE, view, which, noisy)
    _, found, readout = fit_with_shutter(seen, start, velocity)
    assert found.state.numbers[0] == pytest.approx(700.0, rel=0.01)
    assert found.noise_px == pytest.approx(0.2, rel=0.2)
    if axis is None:
        assert readout is None
        return
    assert readout is not None
    assert readout.axis == axis
    assert readout.seconds == pytest.approx(max(map(abs, shutter_s)), rel=0.1)
    assert fit_points(seen, start).noise_px > 1.15 * found.noise_px  # it does harm here


def images_of_walls(centre_px: tuple[float, float], count: int) -> list[np.ndarray]:
    """Four textured walls one before the other, passed by a camera whose lens has this centre."""
    rng = np.random.default_rng(12)
    matrix = Camera(640, 480, 560.0, 560.0, *centre_px).matrix
    walls = []
    for depth_m, left_m in ((6.0, -9.0), (4.0, 0.6), (3.0, -2.6), (2.0, 0.9)):
        wall = cv2.GaussianBlur(rng.integers(0, 255, (900, 1800)).astype(np.float32), (0, 0), 2.0)
        wall = cv2.normalize(wall, None, 1, 255, cv2.NORM_MINMAX).astype(np.uint8)
        width = 1800 if depth_m == 6.0 else 200
        walls.append((wall[:, :width], depth_m, left_m))
    images = []
    for at in np.linspace(0.0, 2.5, count):
        turn = Rotor.from_rotation_vector([0.1 * np.sin(at), 0.15 * np.cos(at), 0.05 * at])
        pose = Motor.from_rotor_translation(turn, [0.7 * at - 0.8, 0.3 * np.sin(at), 0.3 * at])
        camera_T_world = pose.inverse().as_matrix()
        image = np.zeros((480, 640), np.uint8)
        for wall, depth_m, left_m in walls:
            # Wall pixels (u, v, 1) are points (left + u / 100, v / 100 - 4.5, depth).
            points = np.array([[0.01, 0.0, left_m], [0.0, 0.01, -4.5], [0.0, 0.0, depth_m]])
            moved = camera_T_world[:3, :3] @ points
            moved[:, 2] += camera_T_world[:3, 3]
            drawn = cv2.warpPerspective(wall, matrix @ moved, (640, 480))
            image = np.where(drawn > 0, drawn, image)
        images.append(image)
    return images


@pytest.mark.slow
@pytest.mark.parametrize("aside_px", [0.0, 190.0])
def test_a_centre_where_no_lens_has_it_is_not_believed(aside_px: float) -> None:
    """Whether motion misled it or the clip was cut from the side of another cannot be told."""
    images = images_of_walls((319.5 + aside_px, 239.5), 30)
    calibration = self_calibrate_motion(images, (640, 480), np.arange(30) * 33_333_333)
    assert any("beside the middle" in doubt for doubt in calibration.doubts) == (aside_px > 0.0)
    if aside_px == 0.0:
        assert calibration.camera.fx == pytest.approx(560.0, rel=0.03)
    else:
        assert calibration.camera.cx == 319.5


@pytest.mark.slow
def test_the_camera_has_the_size_of_the_images_where_it_is_no_multiple_of_the_tracked_one() -> None:
    """Images of 1281 x 961 are tracked at half; a camera of 1280 x 960 fits none of them."""
    doubled = [cv2.resize(each, (1280, 960)) for each in images_of_walls((319.5, 239.5), 30)]
    images = [cv2.copyMakeBorder(each, 0, 1, 0, 1, cv2.BORDER_REPLICATE) for each in doubled]
    calibration = self_calibrate_motion(images, (1281, 961), np.arange(30) * 33_333_333)
    assert (calibration.camera.width, calibration.camera.height) == (1281, 961)
    assert calibration.camera.fx == pytest.approx(1120.0, rel=0.03)
    assert calibration.camera.cx == pytest.approx(639.5, abs=15.0)
