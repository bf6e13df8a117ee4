"""A room whose walls are painted with noise, rendered by casting a ray through every pixel."""

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Camera

CAMERA = Camera(400, 300, 320.0, 320.0, 199.5, 149.5)
HALF_M = np.array([1.1, 0.8, 2.4])
TEXEL_M = 0.01

View = Callable[[Motor], tuple[np.ndarray, np.ndarray]]
Poses = Callable[..., list[Motor]]


@lru_cache(maxsize=1)
def _walls() -> list[np.ndarray]:
    """Six images of noise in several sizes, smooth over a few texels."""
    rng = np.random.default_rng(7)
    walls = []
    for _ in range(6):
        size = 512
        wall = np.zeros((size, size), dtype=np.float32)
        for cells, weight in ((16, 1.0), (48, 1.0), (128, 1.2)):
            coarse = rng.standard_normal((cells, cells)).astype(np.float32)
            wall += weight * cv2.resize(coarse, (size, size), interpolation=cv2.INTER_CUBIC)
        walls.append(np.clip(128.0 + 40.0 * wall, 5.0, 250.0))
    return walls


def rendered(world_T_camera: Motor, camera: Camera = CAMERA) -> tuple[np.ndarray, np.ndarray]:
    """Grey image uint8 of the inside of a box, and metres along each ray (depth of a pinhole)."""
    columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    px = np.stack([columns, rows], axis=-1)
    fisheye = camera.model == "equidistant"
    rays = (camera.bearings(px) if fisheye else camera.unproject(px)).reshape(-1, 3)
    unseen = ~np.isfinite(rays[:, 0])
    rays[unseen] = [0.01, 0.02, 1.0]
    matrix = world_T_camera.as_matrix()
    direction, origin = rays @ matrix[:3, :3].T, matrix[:3, 3]
    with np.errstate(divide="ignore"):
        distance = (np.sign(direction) * HALF_M - origin) / direction
    axis = np.argmin(distance, axis=1)
    depth = distance[np.arange(len(rays)), axis]
    hit = origin + depth[:, None] * direction
    side = 2 * axis + (np.take_along_axis(direction, axis[:, None], 1)[:, 0] > 0.0)
    shape = (camera.height, camera.width)
    texel = (hit / TEXEL_M + 256.0).astype(np.float32).reshape(*shape, 3)
    side = side.reshape(shape)
    gray = np.zeros(shape, dtype=np.float32)
    for number, wall in enumerate(_walls()):
        if np.any(side == number):
            u, v = (texel[..., other] for other in range(3) if other != number // 2)
            gray = np.where(side == number, cv2.remap(wall, u, v, cv2.INTER_LINEAR), gray)
    gray[unseen.reshape(shape)] = 0.0
    return np.rint(gray).astype(np.uint8), depth.astype(np.float32).reshape(shape)


@pytest.fixture(scope="session")
def view() -> View:
    """Image and depth of the room from a pose; each pose is rendered once."""
    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def seen(world_T_camera: Motor) -> tuple[np.ndarray, np.ndarray]:
        key = world_T_camera.coefficients.tobytes()
        if key not in known:
            known[key] = rendered(world_T_camera)
        return known[key]

    return seen


@pytest.fixture(scope="session")
def half_m() -> np.ndarray:
    """Half the size of the room, whose middle is the world's origin."""
    return HALF_M


@pytest.fixture(scope="session")
def swaying() -> Poses:
    """See `_swaying`."""
    return _swaying


@pytest.fixture(scope="session")
def turning() -> Poses:
    """See `_turning`."""
    return _turning


def _swaying(count: int) -> list[Motor]:
    """A hand that sways through the room and turns a little: poses of frames at 30 Hz."""
    t = np.arange(count) / 30.0
    place = np.stack([0.4 * np.sin(1.1 * t), 0.2 * np.sin(1.7 * t), 0.3 * np.sin(0.8 * t)], axis=1)
    turn = np.stack([0.1 * np.sin(t), 0.15 * np.sin(0.9 * t), 0.05 * np.sin(1.3 * t)], axis=1)
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), place)
    return list(poses)


def _turning(count: int, radians: float) -> list[Motor]:
    """A camera that turns on the spot."""
    angle = np.linspace(0.0, radians, count)
    turn = np.stack([0.1 * np.sin(angle), angle, 0.0 * angle], axis=1)
    return list(
        Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), np.zeros((count, 3)))
    )
