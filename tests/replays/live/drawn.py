"""A board as a camera sees it that is carried round it, drawn from exact poses."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from motorcade.fusion import ADIS16448, simulate_imu
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.live import LiveFrame
from motorcade.replays.live.inertial import ImuSample
from motorcade.tracking import Board, Camera, board_named

BOARD = board_named("checkerboard_7x6_30mm")
CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
STEP_NS = 33_000_000
_FINE = 3


def world_T_camera(index: int, seed: int) -> Motor:
    """Above the board, and round it."""
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3)
    tilt = 0.45 * np.sin(0.13 * index + phase[:2])
    look = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    swing = Rotor.from_rotation_vector([tilt[0], tilt[1], 0.3 * np.sin(0.07 * index + phase[2])])
    middle = BOARD.points_m.mean(axis=0)
    turn = swing @ look
    return Motor.from_rotor_translation(turn, middle - turn.apply([0.0, 0.0, 0.45]))


def image_of(pose: Motor, board: Board = BOARD, camera: Camera = CAMERA) -> np.ndarray:
    """The board on grey, with light noise that the pose fixes."""
    printed, origin = board_print(board)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    corners *= [printed.shape[1] - 1.0, printed.shape[0] - 1.0]
    points = (corners - origin) / _PER_M * [1.0, -1.0]
    seen = camera.project(pose.inverse().apply(np.pad(points, ((0, 0), (0, 1)))))
    fine = _FINE * seen + 0.5 * (_FINE - 1)
    warp = cv2.getPerspectiveTransform(corners.astype(np.float32), fine.astype(np.float32))
    size = (_FINE * camera.width, _FINE * camera.height)
    large = cv2.warpPerspective(printed, warp, size, flags=cv2.INTER_AREA, borderValue=128)
    image = cv2.resize(large, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    seed = int(1e6 * abs(float(pose.translation_m[0]))) % 2**32
    noise = np.random.default_rng(seed).normal(0.0, 1.0, image.shape)
    return np.clip(np.rint(0.7 * image + 40.0 + noise), 0, 255).astype(np.uint8)


_PER_M = 1500.0


def board_print(board: Board) -> tuple[np.ndarray, np.ndarray]:
    """A board as printed, and its origin's pixel."""
    printed, origin = board.draw(pixels_per_m=_PER_M)
    return printed, np.array(origin)


def frames(count: int, seed: int, board: Board = BOARD) -> Iterator[LiveFrame]:
    """Frames as they come, without waiting."""
    for index in range(count):
        yield LiveFrame(index * STEP_NS, image_of(world_T_camera(index, seed), board))


OFFSET_S = 0.021
IMU_T_CAMERA = Motor.from_rotor_translation(
    Rotor.from_rotation_vector([0.3, -1.2, 0.4]), [0.02, -0.03, 0.01]
)
LEVEL_T_BOARD = Motor.from_rotor_translation(
    Rotor.from_rotation_vector([0.4, -0.2, 0.1]), [0.0, 0.0, 1.0]
)


def readings(seconds: float, seed: int, rate_hz: float = 200.0) -> list[ImuSample]:
    """Of an IMU on the drawn camera, whose clock is ahead of the camera's."""
    stamps = round(1e9 / rate_hz) * np.arange(round(rate_hz * seconds))
    poses = Motor.stack([world_T_camera(ns / STEP_NS, seed) for ns in stamps.tolist()])
    path = Trajectory(stamps, LEVEL_T_BOARD @ poses @ IMU_T_CAMERA.inverse())
    imu = simulate_imu(path, rate_hz, ADIS16448, np.random.default_rng(seed)).stream
    rows = zip(imu.time_ns, imu.angular_rate_rad_s, imu.specific_force_m_s2, strict=True)
    late_ns = round(1e9 * OFFSET_S)
    return [ImuSample(int(ns) + late_ns, rate, force) for ns, rate, force in rows]
