"""Exact images of boards: every pixel is the mean of many rays traced onto the printed cells."""

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Board, Camera

PAPER, INK, TABLE = np.float32(215), np.float32(35), np.float32(120)
SAMPLES = 4

Render = Callable[..., np.ndarray]
LookAt = Callable[..., Motor]


@lru_cache(maxsize=4)
def _rays(camera: Camera) -> np.ndarray:
    """Rays of unit depth through SAMPLES x SAMPLES places of every pixel.

    The places are drawn at random, one in each sub-square: a regular grid would put every edge
    that runs along the rows off by up to 1 / (2 SAMPLES).
    """
    rng = np.random.default_rng(20)
    shape = (camera.height * SAMPLES, camera.width * SAMPLES)
    columns = (np.arange(shape[1]) + rng.random(shape)) / SAMPLES - 0.5
    rows = (np.arange(shape[0])[:, None] + rng.random(shape)) / SAMPLES - 0.5
    return camera.unproject(np.stack([columns, rows], axis=-1)).astype(np.float32)


def _brightness(board: Board, x: np.ndarray, y_down: np.ndarray) -> np.ndarray:
    pattern = board.pattern
    column = np.searchsorted(pattern.x_edges_m.astype(np.float32), x, side="right") - 1
    row = np.searchsorted(pattern.y_edges_m.astype(np.float32), y_down, side="right") - 1
    rows, columns = pattern.white.shape
    printed = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    white = pattern.white[np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)]
    quiet = pattern.quiet_m
    on_paper = (x > pattern.x_edges_m[0] - quiet) & (x < pattern.x_edges_m[-1] + quiet)
    on_paper &= (y_down > pattern.y_edges_m[0] - quiet) & (y_down < pattern.y_edges_m[-1] + quiet)
    levels = np.where(on_paper, PAPER, TABLE)
    levels[printed] = np.where(white, PAPER, INK)[printed]
    return levels


@pytest.fixture(scope="session")
def render() -> Render:
    """``render(board, camera, world_T_camera, blur_px=0.7, noise=0.0, seed=0)`` -> grey image."""

    def make(
        board: Board,
        camera: Camera,
        world_T_camera: Motor,
        blur_px: float = 0.7,
        noise: float = 0.0,
        seed: int = 0,
    ) -> np.ndarray:
        rotation = world_T_camera.rotor.as_matrix().astype(np.float32)
        origin = world_T_camera.translation_m.astype(np.float32)
        across, up, depth = np.moveaxis(_rays(camera) @ rotation.T, -1, 0)
        distance = -origin[2] / depth
        x, y = origin[0] + distance * across, origin[1] + distance * up
        levels = np.where(distance > 0.0, _brightness(board, x, -y), TABLE)
        shape = (camera.height, SAMPLES, camera.width, SAMPLES)
        image = levels.reshape(shape).mean(axis=(1, 3))
        if blur_px > 0.0:
            image = cv2.GaussianBlur(image, (0, 0), blur_px)
        image = image + noise * np.random.default_rng(seed).standard_normal(image.shape)
        return np.clip(np.rint(image), 0, 255).astype(np.uint8)

    return make


@pytest.fixture(scope="session")
def look_at() -> LookAt:
    """``look_at(board, distance_m, tilt_deg, azimuth_deg, roll_deg)`` -> world_T_camera.

    The camera looks at the board's middle from `distance_m`, `tilt_deg` off its normal in the
    direction `azimuth_deg` (0 = from the printed right), rolled about its own axis. Without roll
    the board stands upright in the image when seen head on.
    """

    def make(
        board: Board,
        distance_m: float,
        tilt_deg: float = 0.0,
        azimuth_deg: float = 0.0,
        roll_deg: float = 0.0,
    ) -> Motor:
        middle = 0.5 * (board.points_m.min(axis=0) + board.points_m.max(axis=0))
        tilt, azimuth, roll = np.radians([tilt_deg, azimuth_deg, roll_deg])
        axis = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        tilted = Rotor.from_rotation_vector(tilt * axis)
        head_on = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
        rolled = Rotor.from_rotation_vector([0.0, 0.0, roll])
        rotor = tilted @ head_on @ rolled
        centre = middle + tilted.apply(np.array([0.0, 0.0, distance_m]))
        return Motor.from_rotor_translation(rotor, centre)

    return make


@pytest.fixture(scope="session")
def straight_camera() -> Camera:
    return Camera(480, 360, 420.0, 418.0, 242.3, 176.8)


@pytest.fixture(scope="session")
def wide_camera() -> Camera:
    """A lens that bends as much as the one of the checkerboard recording."""
    return Camera(480, 360, 300.0, 301.0, 238.0, 183.0, "radtan", (-0.28, 0.07, 2e-4, -3e-4))
