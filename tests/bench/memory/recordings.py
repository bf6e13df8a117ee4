"""Long recordings that are quick to make: a hundred thousand small frames, hours of an IMU."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from motorcade.fusion.imu import ADIS16448, ContinuousPath, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.motions import gimbal_crossing
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render.video import write_video
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.trajectories import write_trajectory
from motorcade.tracking import Camera, Checkerboard
from tests.bench.memory.fused import write_measured

__all__ = ["write_footage", "write_long_stream"]

RATE_HZ, IMU_HZ, TRUTH_HZ = 30.0, 200.0, 20.0
TURN_FRAMES = 300
"""The camera goes round so often; its images are drawn once and repeated."""
CAMERA = Camera(160, 120, 150.0, 150.0, 79.5, 59.5)
BOARD = Checkerboard(columns=7, rows=5, square_m=0.03)
_CAMERA_TOML = """
[camera]
model = "pinhole"
width = 160
height = 120
fx = 150.0
fy = 150.0
cx = 79.5
cy = 59.5
[truth]
file = "truth.tum"
format = "tum"
convention = "world_T_camera"
"""
_BOARD_TOML = """
[frames]
video = "frames.mp4"
[board]
type = "checkerboard"
columns = 7
rows = 5
square_m = 0.03
"""
_IMU_TOML = """
[frames]
images = "*.png"
rate_hz = 1.0
[imu]
file = "imu.csv"
imu_T_camera = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0]]
"""


def write_footage(folder: Path, frames: int) -> None:
    """Write a video of a checkerboard that a camera circles over, swaying, and the true path."""
    folder.mkdir(parents=True)
    stamps = np.rint(np.arange(frames) * (1e9 / RATE_HZ)).astype(np.int64)
    turn = _round_the_board(TURN_FRAMES)
    drawn = [_photograph(turn[k]) for k in range(TURN_FRAMES)]

    def repeated() -> Iterator[np.ndarray]:
        while True:
            yield from drawn

    write_video(folder / "frames.mp4", islice(repeated(), frames), stamps)
    path = Trajectory(stamps, turn[np.arange(frames) % TURN_FRAMES])
    write_trajectory(path, folder / "truth.tum")
    (folder / "motorcade.toml").write_text('name = "long footage"\n' + _BOARD_TOML + _CAMERA_TOML)


def write_long_stream(folder: Path, duration_s: float) -> None:
    """Write an IMU's stream on a turning path, the true path, a single image, measured poses."""
    folder.mkdir(parents=True)
    made = simulate_imu(
        ContinuousPath.along(gimbal_crossing(), duration_s),
        IMU_HZ,
        ADIS16448,
        np.random.default_rng(0),
    )
    write_imu(made.stream, folder / "imu.csv")
    write_trajectory(made.path[:: round(IMU_HZ / TRUTH_HZ)], folder / "truth.tum")
    poses = simulate_camera_poses(made.path, TRUTH_HZ, 0.01, 0.01, np.random.default_rng(1))
    write_measured(folder, made.stream, poses)
    cv2.imwrite(str(folder / "0.png"), np.zeros((CAMERA.height, CAMERA.width), np.uint8))
    (folder / "motorcade.toml").write_text('name = "long stream"\n' + _IMU_TOML + _CAMERA_TOML)


def _round_the_board(count: int) -> Motor:
    phase = np.arange(count) * (2.0 * np.pi / count)
    middle = BOARD.points_m.mean(axis=0)
    looking_down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    sway = np.stack([0.3 * np.sin(phase), 0.25 * np.cos(2.0 * phase), 0.4 * np.sin(phase)], axis=-1)
    rotor = looking_down @ Rotor.from_rotation_vector(sway)
    behind = -0.35 * rotor.apply(np.array([0.0, 0.0, 1.0]))
    return Motor.from_rotor_translation(rotor, middle + behind)


def _photograph(world_T_camera: Motor) -> np.ndarray:
    """What the camera sees, RGB: the drawing through its homography, four times as fine, shrunk."""
    scale, fine = 2000.0, 4
    drawing, origin = BOARD.draw(scale)
    to_board = np.array([[1, 0, -origin[0]], [0, -1, origin[1]], [0, 0, scale]]) / scale
    view = world_T_camera.inverse().as_matrix()[:3][:, [0, 1, 3]]
    finer = np.diag([fine, fine, 1.0]) + np.array([[0, 0, 1.5], [0, 0, 1.5], [0, 0, 0]])
    homography = finer @ CAMERA.matrix @ view @ to_board
    size = (CAMERA.width * fine, CAMERA.height * fine)
    large = cv2.warpPerspective(drawing, homography, size, flags=cv2.INTER_AREA, borderValue=150)
    gray = cv2.resize(large, (CAMERA.width, CAMERA.height), interpolation=cv2.INTER_AREA)
    return np.repeat(gray[..., None], 3, axis=2)
