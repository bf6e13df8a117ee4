"""Paths through the textured room, in closed form: exact at any time.

Times are seconds, poses `world_T_camera` with OpenCV camera axes in the room's world (z up).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["Path", "handheld", "loop", "turning"]

Path = Callable[[ArrayLike], Motor]

LOOP_S = 12.0
"""Once around the block."""
_LOOP_X_M, _LOOP_Y_M, _EYES_M = 2.9, 2.0, 1.35
_STAND_M = np.array([-0.4, -2.0, _EYES_M])
_DOWN_RAD = np.deg2rad(8.0)


def loop(time_s: ArrayLike) -> Motor:
    """Around the block, looking ahead and a little outwards, back to the start every `LOOP_S`."""
    time = np.asarray(time_s, dtype=np.float64)
    angle = 2.0 * np.pi * time / LOOP_S
    centre = np.stack(
        [
            _LOOP_X_M * np.cos(angle),
            _LOOP_Y_M * np.sin(angle),
            _EYES_M + 0.04 * np.sin(5.0 * angle),
        ],
        axis=-1,
    )
    ahead = np.arctan2(_LOOP_Y_M * np.cos(angle), -_LOOP_X_M * np.sin(angle))
    return _looking(centre, ahead - 0.25, _DOWN_RAD + 0.05 * np.sin(3.0 * angle))


def handheld(time_s: ArrayLike) -> Motor:
    """A hand's sway and reach on the spot: up to 0.35 m and 15 degrees to each side."""
    time = np.asarray(time_s, dtype=np.float64)
    sway = np.stack(
        [
            0.35 * np.sin(1.3 * time),
            0.20 * np.sin(0.9 * time),
            0.15 * np.sin(1.9 * time),
        ],
        axis=-1,
    )
    yaw = 0.6 + 0.26 * np.sin(1.1 * time)
    down = _DOWN_RAD + 0.15 * np.sin(1.6 * time)
    return _looking(_STAND_M + sway, yaw, down)


def turning(time_s: ArrayLike) -> Motor:
    """On the spot, turning about the lens: 60 degrees to each side and 10 up and down."""
    time = np.asarray(time_s, dtype=np.float64)
    centre = np.broadcast_to(_STAND_M, (*time.shape, 3))
    yaw = np.deg2rad(60.0) * np.sin(0.8 * time)
    return _looking(centre, yaw, _DOWN_RAD + np.deg2rad(10.0) * np.sin(1.3 * time))


def _looking(centre_m: FloatArray, yaw_rad: FloatArray, down_rad: FloatArray) -> Motor:
    """Level cameras at centres ``(*, 3)`` that look at a yaw from +x towards +y, and down."""
    ahead = np.stack([np.cos(yaw_rad), np.sin(yaw_rad), np.zeros_like(yaw_rad)], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    forward = np.cos(down_rad)[..., None] * ahead - np.sin(down_rad)[..., None] * up
    right = np.cross(ahead, up)
    matrix = np.stack([right, np.cross(forward, right), forward], axis=-1)
    return Motor.from_rotor_translation(Rotor.from_matrix(matrix), centre_m)
