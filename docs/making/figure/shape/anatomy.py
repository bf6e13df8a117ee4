"""The explorer's body in blocks: trunk, head with cap, leg with boot, arm with glove.

All lengths are metres of a figure 1.75 m tall in its rest pose; blocks are those of the left half.
Rows of a block read (station, half-width ahead, half-width aside, shift ahead, shift aside).
"""

from __future__ import annotations

import numpy as np

from docs.making.figure.proportions import (
    ANKLE_HEIGHT_M,
    ARM_SPREAD_RAD,
    FINGERS,
    FOREARM_M,
    HIP_HALF_WIDTH_M,
    SHIN_M,
    THIGH_M,
    THUMB_M,
    THUMB_ROOT_M,
    THUMB_SPREAD_RAD,
    UPPER_ARM_M,
    figure_skeleton,
)
from docs.making.figure.shape.fields import BodyBlock, BodyField, block
from motorcade.ga.arrays import FloatArray

UP = np.eye(3)
DOWN = np.diag([1.0, 1.0, -1.0])
# a foot lies along x: its first cross axis is z
AHEAD = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
SOLE_ROUNDING_M = 0.008

SKULL_M, SKULL_HALF_M = np.array([0.0, 0.0, 1.502]), (0.224, 0.240, 0.248)
RIM = (1.462, 0.60)
"""Height of the cap's rim over the ears, and how it rises ahead."""
COLLAR_Z, HEM_Z, BOOT_Z, SOLE_Z = 1.222, 0.668, 0.205, 0.030
"""Heights of the scarf, the jacket's hem, the boots' upper edge and that of their soles."""


def body_field() -> BodyField:
    """The whole body, arms spread, soles at z = 0."""
    return BodyField((*_trunk(), *_leg(), *_head(), *arm()), SOLE_ROUNDING_M)


def over_rim(points: FloatArray) -> FloatArray:
    """How far points (N, 3) lie above the plane of the cap's rim, metres."""
    height, slope = RIM
    away = points[:, 2] - height - slope * points[:, 0]
    return np.asarray(away / np.hypot(1.0, slope))


def _ball(
    centre: tuple[float, float, float], half: tuple[float, float, float], blend_m: float
) -> BodyBlock:
    """An ellipsoid with half-axes along the world's."""
    return block(centre, UP, [(0.0, half[0], half[1])], (half[2], half[2]), blend_m)


def _trunk() -> list[BodyBlock]:
    core = block(
        (0.0, 0.0, 0.0),
        UP,
        [
            (0.590, 0.088, 0.120, -0.004),
            (0.640, 0.124, 0.172, -0.004),
            (0.700, 0.138, 0.192, -0.002),
            (0.780, 0.138, 0.190, 0.002),
            (0.880, 0.131, 0.175, 0.002),
            (0.980, 0.121, 0.158, -0.002),
            (1.070, 0.108, 0.144, -0.006),
            (1.135, 0.088, 0.122, -0.008),
            (1.185, 0.064, 0.080, -0.008),
        ],
        (0.030, 0.020),
        0.02,
    )
    yoke = block(
        (-0.006, 0.030, 1.148),
        _frame((-0.004, 0.128, -0.012)),
        [(0.0, 0.070, 0.052), (0.07, 0.066, 0.052), (0.130, 0.062, 0.054)],
        (0.03, 0.03),
        0.080,
    )
    return [core, yoke, _ball((0.036, 0.0, 0.800), (0.116, 0.150, 0.130), 0.06)]


def _frame(along: tuple[float, float, float]) -> FloatArray:
    """Axes (3, 3) of which the third lies along a direction and the first points about ahead."""
    axis = np.array(along) / np.linalg.norm(along)
    ahead = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
    ahead /= np.linalg.norm(ahead)
    return np.stack([ahead, np.cross(axis, ahead), axis])


def _head() -> list[BodyBlock]:
    neck = block(
        (0.0, 0.0, 0.0),
        UP,
        [(1.150, 0.072, 0.080, -0.010), (1.240, 0.066, 0.072, -0.006), (1.330, 0.066, 0.072, 0.0)],
        (0.02, 0.02),
        0.020,
    )
    skull = (float(SKULL_M[0]), float(SKULL_M[1]), float(SKULL_M[2]))
    return [
        neck,
        _ball(skull, SKULL_HALF_M, 0.020),
        _ball((0.050, 0.060, 1.398), (0.138, 0.142, 0.110), 0.110),  # cheeks
        _ball((0.130, 0.0, 1.350), (0.064, 0.084, 0.058), 0.060),  # chin
        _ball((0.222, 0.0, 1.436), (0.024, 0.029, 0.023), 0.024),  # nose
    ]


def _leg() -> list[BodyBlock]:
    hip_z = ANKLE_HEIGHT_M + SHIN_M + THIGH_M
    aside = HIP_HALF_WIDTH_M
    trousers = block(
        (0.0, aside, hip_z),
        DOWN,
        [
            (-0.020, 0.104, 0.090, -0.002, 0.000),
            (0.060, 0.100, 0.091, 0.000, 0.000),
            (0.140, 0.092, 0.088, 0.002, 0.000),
            (0.230, 0.085, 0.083, 0.004, 0.000),
            (0.290, 0.083, 0.081, 0.003, 0.000),
            (0.360, 0.083, 0.081, 0.000, 0.000),
            (0.420, 0.082, 0.080, -0.002, 0.000),
            (0.480, 0.074, 0.070, -0.002, 0.000),
        ],
        (0.03, 0.02),
        0.022,
    )
    shaft = block(
        (0.0, aside, 0.0),
        UP,
        [
            (0.060, 0.072, 0.068, -0.006),
            (0.120, 0.070, 0.067, -0.005),
            (0.170, 0.075, 0.072, -0.003),
            (BOOT_Z - 0.010, 0.083, 0.080, -0.002),
        ],
        (0.02, 0.02),
        0.030,
    )
    return [trousers, shaft, *_shoe(aside)]


def _shoe(aside: float) -> list[BodyBlock]:
    """Heel to toe box, and the sole; rows read (ahead, half height, half width, up, aside)."""
    upper = block(
        (0.0, aside, 0.0),
        AHEAD,
        [
            (-0.040, 0.066, 0.062, 0.046, 0.000),
            (0.000, 0.072, 0.067, 0.048, 0.000),
            (0.050, 0.068, 0.073, 0.042, 0.002),
            (0.095, 0.063, 0.078, 0.037, 0.004),
            (0.128, 0.061, 0.077, 0.035, 0.002),
        ],
        (0.042, 0.060),
        0.034,
    )
    return [upper]


def _shoulder() -> FloatArray:
    skeleton = figure_skeleton()
    return skeleton.rest_world.translation_m[skeleton.index("left_upper_arm")]


SHOULDER_M = _shoulder()
ELBOW, WRIST = UPPER_ARM_M, UPPER_ARM_M + FOREARM_M
CUFF = WRIST - 0.034
"""Where a glove begins, from the shoulder."""

# finger: half-widths at its root, its joints, and near its tip
FINGER_HALF_M: dict[str, tuple[float, float, float]] = {
    "index": (0.0195, 0.0190, 0.0175),
    "middle": (0.0200, 0.0194, 0.0178),
    "little": (0.0190, 0.0182, 0.0168),
}


def arm_axes() -> FloatArray:
    """(3, 3) rows: ahead, outer side, down the arm."""
    cos, sin = np.cos(ARM_SPREAD_RAD), np.sin(ARM_SPREAD_RAD)
    return np.array([[1.0, 0.0, 0.0], [0.0, cos, sin], [0.0, sin, -cos]])


def arm() -> list[BodyBlock]:
    """Shoulder to fingertips."""
    return [*_sleeve(), *_glove(), *_fingers(), *_thumb()]


def _part(rows: list[tuple[float, ...]], caps_m: tuple[float, float], blend_m: float) -> BodyBlock:
    """A block along the arm, stations measured from the shoulder."""
    return block(SHOULDER_M, arm_axes(), rows, caps_m, blend_m)


def _sleeve() -> list[BodyBlock]:
    sleeve = _part(
        [
            (-0.010, 0.060, 0.055, 0.000, -0.006),
            (0.050, 0.063, 0.059, 0.000, 0.000),
            (0.120, 0.061, 0.057, 0.000, 0.000),
            (ELBOW, 0.058, 0.055, 0.000, 0.000),
            (ELBOW + 0.070, 0.057, 0.054, 0.000, 0.000),
            (ELBOW + 0.130, 0.055, 0.051, 0.000, 0.000),
            (CUFF, 0.050, 0.046, 0.000, 0.000),
        ],
        (0.03, 0.015),
        0.040,
    )
    return [sleeve]


def _glove() -> list[BodyBlock]:
    palm = _part(
        [
            (WRIST - 0.010, 0.044, 0.035, 0.000, 0.000),
            (WRIST + 0.025, 0.053, 0.037, 0.000, 0.000),
            (WRIST + 0.060, 0.057, 0.035, 0.000, 0.000),
            (WRIST + 0.080, 0.056, 0.030, 0.000, 0.000),
        ],
        (0.015, 0.014),
        0.014,
    )
    return [palm]


def _fingers() -> list[BodyBlock]:
    fingers = []
    for name, (ahead, down, bones, fan) in FINGERS.items():
        root = SHOULDER_M + arm_axes().T @ np.array([ahead, 0.0, WRIST + down])
        fingers.append(_digit(root, fan, bones, FINGER_HALF_M[name], start=-0.014))
    return fingers


def _thumb() -> list[BodyBlock]:
    ahead, down = THUMB_ROOT_M
    root = SHOULDER_M + arm_axes().T @ np.array([ahead, -0.006, WRIST + down])
    return [_digit(root, THUMB_SPREAD_RAD, THUMB_M, (0.0220, 0.0208, 0.0188), start=0.004)]


def _digit(
    root_m: FloatArray,
    fan_rad: float,
    bones_m: tuple[float, float, float],
    half_m: tuple[float, float, float],
    start: float,
) -> BodyBlock:
    """A finger from its root joint."""
    axes = arm_axes()
    along = np.sin(fan_rad) * axes[0] + np.cos(fan_rad) * axes[2]
    turned = np.stack([np.cos(fan_rad) * axes[0] - np.sin(fan_rad) * axes[2], axes[1], along])
    first, second, third = bones_m
    root, middle, tip = half_m
    rows = [
        (start, root, root),
        (first, middle, middle),
        (first + second, tip * 1.04, tip * 1.04),
        (first + second + 0.40 * third, tip, tip),
    ]
    return block(root_m, turned, rows, (0.008, 0.75 * tip), 0.006)
