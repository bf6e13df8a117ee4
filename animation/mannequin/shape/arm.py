"""The mannequin's left arm and hand in blocks, laid along the spread arm of the rest pose.

In the frame of the arm x points ahead, y to its outer side (the back of the hand) and the third
axis down the arm.
"""

from __future__ import annotations

import numpy as np

from motorcade.animation.mannequin.proportions import (
    ARM_SPREAD_RAD,
    FINGERS,
    FOREARM_M,
    THUMB_M,
    THUMB_ROOT_M,
    THUMB_SPREAD_RAD,
    UPPER_ARM_M,
)
from motorcade.animation.mannequin.shape.fields import BodyBlock, block
from motorcade.ga.arrays import FloatArray

__all__ = ["SHOULDER_M", "arm", "arm_axes"]

SHOULDER_M = np.array([-0.012, 0.177, 1.423])
ELBOW, WRIST = UPPER_ARM_M, UPPER_ARM_M + FOREARM_M

# finger: half-widths at its root, its joints, and near its tip
FINGER_HALF_M: dict[str, tuple[float, float, float]] = {
    "index": (0.0096, 0.0088, 0.0076),
    "middle": (0.0098, 0.0090, 0.0078),
    "ring": (0.0094, 0.0086, 0.0074),
    "little": (0.0084, 0.0076, 0.0066),
}


def arm_axes() -> FloatArray:
    """(3, 3) rows: ahead, outer side, down the arm."""
    cos, sin = np.cos(ARM_SPREAD_RAD), np.sin(ARM_SPREAD_RAD)
    return np.array([[1.0, 0.0, 0.0], [0.0, cos, sin], [0.0, sin, -cos]])


def arm() -> list[BodyBlock]:
    """Shoulder to fingertips."""
    return [*_upper_arm(), *_forearm(), *_palm(), *_fingers(), *_thumb()]


def _part(rows: list[tuple[float, ...]], caps_m: tuple[float, float], blend_m: float) -> BodyBlock:
    """A block along the arm, stations measured from the shoulder."""
    return block(SHOULDER_M, arm_axes(), rows, caps_m, blend_m)


def _muscle(
    along: float, ahead: float, out: float, half: tuple[float, float, float], blend_m: float
) -> BodyBlock:
    """An ellipsoid with half-axes (ahead, aside, along)."""
    return _part([(along, half[0], half[1], ahead, out)], (half[2], half[2]), blend_m)


def _upper_arm() -> list[BodyBlock]:
    bone = _part(
        [
            (-0.010, 0.042, 0.037, 0.000, -0.004),
            (0.060, 0.048, 0.044, 0.000, 0.000),
            (0.130, 0.044, 0.040, 0.001, 0.000),
            (0.200, 0.040, 0.036, 0.000, 0.000),
            (0.255, 0.036, 0.035, -0.001, 0.000),
            (ELBOW, 0.036, 0.036, -0.003, 0.000),
        ],
        (0.03, 0.02),
        0.035,
    )
    return [
        bone,
        _muscle(0.034, -0.002, 0.004, (0.051, 0.041, 0.070), 0.030),  # shoulder cap
        _muscle(0.160, 0.022, -0.004, (0.026, 0.028, 0.072), 0.025),  # biceps
        _muscle(0.135, -0.024, 0.002, (0.024, 0.030, 0.080), 0.025),  # triceps
        _muscle(ELBOW + 0.002, -0.028, 0.002, (0.014, 0.018, 0.020), 0.018),  # point of the elbow
    ]


def _forearm() -> list[BodyBlock]:
    bone = _part(
        [
            (ELBOW - 0.005, 0.035, 0.035, -0.002, 0.000),
            (ELBOW + 0.045, 0.040, 0.037, 0.002, 0.000),
            (ELBOW + 0.090, 0.038, 0.034, 0.003, 0.000),
            (ELBOW + 0.160, 0.031, 0.026, 0.002, 0.000),
            (ELBOW + 0.215, 0.0265, 0.0205, 0.000, 0.000),
            (WRIST + 0.004, 0.0265, 0.0190, 0.000, 0.000),
        ],
        (0.02, 0.015),
        0.020,
    )
    return [bone, _muscle(ELBOW + 0.060, 0.018, 0.010, (0.026, 0.026, 0.065), 0.022)]


def _palm() -> list[BodyBlock]:
    palm = _part(
        [
            (WRIST - 0.004, 0.0260, 0.0175, 0.000, 0.000),
            (WRIST + 0.025, 0.0330, 0.0165, 0.001, 0.000),
            (WRIST + 0.060, 0.0415, 0.0145, 0.0005, 0.000),
            (WRIST + 0.084, 0.0410, 0.0125, 0.0000, 0.000),
        ],
        (0.015, 0.010),
        0.014,
    )
    return [
        palm,
        _muscle(WRIST + 0.042, 0.024, -0.008, (0.020, 0.015, 0.034), 0.014),  # ball of the thumb
        _muscle(WRIST + 0.048, -0.024, -0.006, (0.014, 0.013, 0.034), 0.014),  # outer edge
    ]


def _fingers() -> list[BodyBlock]:
    fingers = []
    for name, (ahead, down, bones, fan) in FINGERS.items():
        root = SHOULDER_M + arm_axes().T @ np.array([ahead, 0.0, WRIST + down])
        fingers.append(_digit(root, fan, bones, FINGER_HALF_M[name], start=-0.012))
    return fingers


def _thumb() -> list[BodyBlock]:
    ahead, down = THUMB_ROOT_M
    root = SHOULDER_M + arm_axes().T @ np.array([ahead, -0.004, WRIST + down])
    return [_digit(root, THUMB_SPREAD_RAD, THUMB_M, (0.0135, 0.0108, 0.0088), start=0.006)]


def _digit(
    root_m: FloatArray,
    fan_rad: float,
    bones_m: tuple[float, float, float],
    half_m: tuple[float, float, float],
    start: float,
) -> BodyBlock:
    """A finger from its root joint; its knuckles are a little wider than its bones."""
    axes = arm_axes()
    along = np.sin(fan_rad) * axes[0] + np.cos(fan_rad) * axes[2]
    turned = np.stack([np.cos(fan_rad) * axes[0] - np.sin(fan_rad) * axes[2], axes[1], along])
    first, second, third = bones_m
    root, middle, tip = half_m
    rows = [
        (start, root, root),
        (0.5 * first, 0.96 * middle, 0.98 * middle),
        (first, 1.02 * middle, 1.02 * middle),
        (first + 0.5 * second, 0.97 * middle, 0.96 * middle),
        (first + second, tip * 1.06, tip * 1.04),
        (first + second + 0.55 * third, tip, 0.94 * tip),
    ]
    return block(root_m, turned, rows, (0.008, 0.45 * third), 0.0045)
