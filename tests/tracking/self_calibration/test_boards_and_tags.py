"""A clip's camera from boards and tags: focal length, lens, shutter; refusals with reasons."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking import (
    Camera,
    Checkerboard,
    SelfCalibrationError,
    self_calibrate_board,
    self_calibrate_tags,
)
from motorcade.tracking.markers.families import marker_points_m
from tests.tracking.self_calibration.clips import board_views, hand, pixels, tag_frames

FRAMES = 90
STAMPS = np.arange(FRAMES) * 33_333_333
LENSES = {
    "main": Camera(1920, 1080, 1500.0, 1500.0, 968.0, 533.0, "radtan", (0.04, -0.06)),
    "tall": Camera(1080, 1920, 1620.0, 1620.0, 545.0, 950.0),
    "wide": Camera(1920, 1080, 860.0, 860.0, 955.0, 544.0, "equidistant", (0.03, -0.01, 0, 0)),
}
READOUTS = {"main": (0.0, 0.021), "tall": (-0.016, 0.0), "wide": (0.0, 0.0)}
BOARD = Checkerboard(9, 6, 1.0)
LOOSE = [(0.0, 0.0, 0.0, 0.3), (2.5, 0.4, 0.0, 1.2), (-1.8, 1.7, 0.3, -0.4), (0.6, -2.2, 0.8, 2.0)]


def centred(points: np.ndarray) -> np.ndarray:
    return points - points.mean(axis=0)


def tags() -> np.ndarray:
    """Corners of four tags that lie about, two of them raised and turned."""
    parts = []
    for x, y, z, turn in LOOSE:
        pose = Motor.from_rotor_translation(
            Rotor.from_rotation_vector([0.3 * z, 0.2 * z, turn]), [x, y, z]
        )
        parts.append(pose.apply(marker_points_m(1.0) - [0.5, -0.5, 0.0]))
    return np.concatenate(parts)


def check(found, camera: Camera, readout_s: tuple[float, float]) -> None:
    """Focal length and shutter, against the truth and against what is claimed."""
    error = abs(found.camera.fx / camera.fx - 1.0)
    assert error < 0.006
    assert error < 5.0 * found.sigma_focal + 0.0005
    grid = np.stack(np.meshgrid(np.linspace(0.3, 0.7, 5), np.linspace(0.3, 0.7, 5)), axis=-1)
    px = grid.reshape(-1, 2) * (camera.width, camera.height)
    # Lenses are told apart by the rays of the image's middle part, up to a turn of the camera.
    mine, true = found.camera.bearings(px), camera.bearings(px)
    left, _, right = np.linalg.svd(mine.T @ true)
    assert np.linalg.norm(mine @ left @ right - true, axis=-1).max() * camera.fx < 2.5
    assert found.readout is not None
    true_s = max(readout_s, key=abs)
    assert abs(found.readout_s - abs(true_s)) < 0.0015
    if true_s:
        assert found.readout.axis == ("down" if readout_s[1] else "left")


@pytest.mark.parametrize("lens", LENSES)
def test_a_board_of_any_size_gives_lens_and_shutter(lens: str) -> None:
    camera, rng = LENSES[lens], np.random.default_rng(3)
    path = hand(FRAMES, 18.0 * camera.fx / 1500.0, 0.5)
    points = centred(BOARD.points_m)
    px = pixels(camera, path, points, READOUTS[lens])
    found = self_calibrate_board(
        board_views(px, camera, BOARD.points_m, 0.15, rng), (camera.width, camera.height), STAMPS
    )
    assert found.basis == "board"
    check(found, camera, READOUTS[lens])


@pytest.mark.slow
@pytest.mark.parametrize("lens", LENSES)
def test_loose_tags_of_unknown_size_give_lens_and_shutter(lens: str) -> None:
    camera, rng = LENSES[lens], np.random.default_rng(4)
    path = hand(FRAMES, 8.0 * camera.fx / 1500.0, 0.45, phase=2.0)
    px = pixels(camera, path, tags(), READOUTS[lens])
    found = self_calibrate_tags(
        tag_frames(px, camera, 0.15, rng), (camera.width, camera.height), STAMPS
    )
    assert found.basis == "tags"
    check(found, camera, READOUTS[lens])


def test_a_board_at_one_angle_gives_what_it_tells() -> None:
    camera, rng = LENSES["main"], np.random.default_rng(5)
    t = np.arange(FRAMES) / 30.0
    turn = Rotor.from_rotation_vector([[np.pi - 0.5, 0.0, 0.0]] * FRAMES)
    place = np.stack([np.sin(t), np.cos(t), 16.0 + np.sin(2.0 * t)], axis=-1)
    path = Motor.from_rotor_translation(turn, place)
    px = pixels(camera, path, centred(BOARD.points_m), (0.0, 0.0))
    views = board_views(px, camera, BOARD.points_m, 0.15, rng)
    found = self_calibrate_board(views, (1920, 1080), STAMPS)
    assert abs(found.camera.fx / camera.fx - 1.0) < 2.0 * found.sigma_focal


@pytest.mark.parametrize("tilt_deg", [0.0, 5.0])
def test_a_board_head_on_gives_a_usual_camera_and_its_doubt(tilt_deg: float) -> None:
    points, rng = BOARD.points_m, np.random.default_rng(6)
    camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    aside = np.radians(tilt_deg) * np.linspace(-1.0, 1.0, 24)
    turn = Rotor.from_rotation_vector(np.stack([np.pi + aside, 0 * aside, 0 * aside], axis=-1))
    place = np.stack([np.full(24, -4.0), np.full(24, 2.5), 13.0 + 0.2 * np.arange(24)], axis=-1)
    px = pixels(camera, Motor.from_rotor_translation(turn, place), points, (0.0, 0.0))
    views = board_views(px, camera, points, 0.1, rng)
    found = self_calibrate_board(views, (640, 480), np.arange(24) * 33_333_333)
    assert 0.05 < found.sigma_focal < 0.5
    assert abs(found.camera.fx / camera.fx - 1.0) < 2.0 * found.sigma_focal
    assert found.breathing == 0.0
    said = next(one for one in found.doubts if "focal length is known to" in one)
    tilt = int(said.split("head on, to ")[1].split(" degrees")[0])
    assert abs(tilt - tilt_deg) <= 2.0


def test_a_lens_is_not_believed_beyond_where_it_was_seen() -> None:
    """A print that is bent, in the middle of the images: no lens that folds or swings there."""
    rng = np.random.default_rng(7)
    camera = Camera(960, 720, 740.0, 740.0, 479.5, 359.5)
    points = centred(BOARD.points_m)
    bent = points + 0.02 * (points[:, :1] ** 2 - 6.0) * [0.0, 0.0, 1.0]
    px = pixels(camera, hand(FRAMES, 22.0, 0.3), bent, (0.0, 0.0))
    assert np.abs(px - (479.5, 359.5)).max() < 300.0
    views = board_views(px, camera, BOARD.points_m, 0.15, rng)
    found = self_calibrate_board(views, (960, 720), STAMPS)
    assert not found.camera.folds()
    corner = np.array([[0.0, 0.0], [959.0, 719.0]])
    moved = np.linalg.norm(found.camera.undistort(corner) - corner, axis=-1)
    assert moved.max() < 0.1 * 600.0
    assert abs(found.camera.fx / camera.fx - 1.0) < 2.0 * found.sigma_focal


def test_too_few_frames_are_told() -> None:
    with pytest.raises(SelfCalibrationError, match="at least 5 frames that show a marker, got 0"):
        self_calibrate_tags([[], []], (640, 480), [0, 1])


def test_stamps_must_be_one_a_frame() -> None:
    with pytest.raises(ValueError, match="expected 2 stamps, one a view, got 1"):
        self_calibrate_board([None, None], (640, 480), [0])
