"""Pixels away from the corners say how far what is drawn lies off; noise of corners is pooled."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.tracking import BoardTrack, Camera, Checkerboard, MarkerGrid, PoseMeasurements
from motorcade.tracking.audit import scatter_px
from motorcade.tracking.board_tracking.tracker import with_pooled_noise
from motorcade.tracking.board_tracking.witness import pixel_offsets
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.images import corner_noise_px
from motorcade.tracking.measurements import MarkerObservation
from motorcade.tracking.pose import refine

BOARDS = [Checkerboard(7, 4, 0.03), MarkerGrid("tag36h11", 3, 2, 0.05, 0.015)]


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.name)
def test_a_pose_that_is_off_is_told_by_pixels(board, straight_camera, render, look_at) -> None:
    pose = look_at(board, 0.5, 20.0, 40.0, 10.0)
    image = render(board, straight_camera, pose, blur_px=1.0, noise=2.0)
    assert np.abs(pixel_offsets(image, board, straight_camera, pose)).max() < 0.2
    beside = pose @ Motor.from_translation([2.0 * 0.5 / straight_camera.fx, 0.0, 0.0])  # 2 px
    right = pixel_offsets(image, board, straight_camera, beside)[:, 0]
    assert np.median(right) > 0.9


def test_a_hidden_board_says_nothing(straight_camera, render, look_at) -> None:
    board = BOARDS[1]
    pose = look_at(board, 0.5, 20.0, 40.0, 10.0)
    image = render(board, straight_camera, pose)
    noise = np.random.default_rng(3).integers(0, 255, image.shape).astype(np.uint8)
    assert len(pixel_offsets(noise, board, straight_camera, pose)) == 0


def test_dark_and_noisy_images_let_corners_scatter_more(render, look_at) -> None:
    board, camera = BOARDS[0], Camera(240, 180, 210.0, 210.0, 119.5, 89.5)
    pose = look_at(board, 0.5)
    px = camera.project(pose.inverse().apply(board.points_m))
    image = render(board, camera, pose, noise=2.0)
    noisy = render(board, camera, pose, noise=25.0)
    dim = cv2.convertScaleAbs(render(board, camera, pose), alpha=0.03)
    clear, coarse, dark = (corner_noise_px([one], [px]) for one in (image, noisy, dim))
    assert clear < 0.05
    assert coarse > 5.0 * clear
    assert dark > 2.0 * clear
    assert scatter_px(camera) < 0.5 < scatter_px(replace(camera, width=640, height=480))
    assert scatter_px(camera, coarse) > scatter_px(camera, clear)


def test_a_frame_that_fits_by_chance_is_not_surer_than_its_neighbours() -> None:
    """Four corners leave two residuals: alone they claim a tenth of the noise at times."""
    rng, count, sigma_px = np.random.default_rng(11), 40, 0.8
    camera = Camera(640, 480, 500.0, 500.0, 320.0, 240.0)
    points = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, -0.1, 0.0], [0.0, -0.1, 0.0]])
    turn = Rotor.from_rotation_vector([np.pi - 0.5, 0.3, 0.0])
    true = Motor.from_rotor_translation(turn, [0.05, 0.2, 0.5])
    exact = camera.project(true.inverse().apply(points))
    poses, seen = [], []
    for row in range(count):
        px = exact + sigma_px * rng.standard_normal((4, 2))
        poses.append(refine(BoardCorners(np.arange(4), px, points), camera, true))
        both = Motor.stack([true, true])
        seen.append(MarkerObservation(row, np.arange(4), px, both, np.zeros(2)))
    path = Trajectory(np.arange(count), Motor.stack([pose.world_T_camera for pose in poses]))
    alone = PoseMeasurements(path, np.stack([pose.covariance for pose in poses]))
    errors = np.array([pose.error_px for pose in poses])
    states = np.full(count, "detected")
    track = BoardTrack(np.arange(count), states, tuple(seen), alone, errors)
    off = Motor.stack([true] * count).local(path.motors)

    def farthest(measured: PoseMeasurements) -> float:
        return float(np.einsum("ni,nij,nj->n", off, np.linalg.inv(measured.covariance), off).max())

    assert farthest(alone) > 100.0
    assert farthest(with_pooled_noise(track).measurements) < 26.0  # once in 5,000, of six numbers
