"""The mannequin's body in blocks: trunk, head, leg, arm and hand.

All lengths are metres of a figure 1.75 m tall in its rest pose; blocks are those of the left half.
Rows of a block read (station, half-width ahead, half-width aside, shift ahead, shift aside).
"""

from __future__ import annotations

import numpy as np

from motorcade.animation.mannequin.proportions import (
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
)
from motorcade.animation.mannequin.shape.fields import BodyBlock, BodyField, block
from motorcade.ga.arrays import FloatArray

UP = np.eye(3)
DOWN = np.diag([1.0, 1.0, -1.0])
# a foot lies along x: its first cross axis is z
AHEAD = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
SOLE_ROUNDING_M = 0.006


def body_field() -> BodyField:
    """The whole body, arms spread, soles at z = 0."""
    return BodyField((*_trunk(), *_leg(), *_head(), *arm()), SOLE_ROUNDING_M)


def _ball(
    centre: tuple[float, float, float],
    half: tuple[float, float, float],
    blend_m: float,
    carve: bool = False,
    axes: FloatArray = UP,
) -> BodyBlock:
    """An ellipsoid with half-axes along `axes`."""
    rows = [(0.0, half[0], half[1])]
    return block(centre, axes, rows, (half[2], half[2]), blend_m, carve=carve)


def _trunk() -> list[BodyBlock]:
    core = block(
        (0.0, 0.0, 0.0),
        UP,
        [
            (0.880, 0.078, 0.095, -0.010),
            (0.905, 0.096, 0.138, -0.013),
            (0.950, 0.103, 0.160, -0.012),
            (1.000, 0.097, 0.157, -0.006),
            (1.055, 0.088, 0.139, 0.002),
            (1.105, 0.084, 0.129, 0.005),
            (1.160, 0.089, 0.134, 0.005),
            (1.230, 0.101, 0.147, 0.002),
            (1.310, 0.108, 0.158, -0.003),
            (1.375, 0.099, 0.156, -0.011),
            (1.425, 0.078, 0.130, -0.018),
            (1.460, 0.056, 0.080, -0.020),
        ],
        (0.034, 0.020),
        0.02,
    )
    yoke = block(
        (-0.020, 0.030, 1.462),
        _frame((-0.004, 0.143, -0.045)),
        [(0.0, 0.054, 0.042), (0.07, 0.048, 0.036), (0.145, 0.044, 0.036)],
        (0.03, 0.03),
        0.045,
    )
    return [
        core,
        yoke,
        _ball((0.060, 0.072, 1.325), (0.042, 0.076, 0.056), 0.035),  # chest muscle
        _ball((-0.036, 0.106, 1.285), (0.058, 0.048, 0.105), 0.045),  # broad back muscle
        _ball((-0.078, 0.075, 1.345), (0.030, 0.060, 0.075), 0.040),  # shoulder blade
        _ball((-0.068, 0.030, 1.080), (0.026, 0.034, 0.120), 0.040),  # along the spine
        _ball((-0.075, 0.073, 0.915), (0.062, 0.074, 0.075), 0.030),  # seat
        _ball((0.066, 0.028, 1.120), (0.024, 0.036, 0.095), 0.030),  # belly
    ]


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
        [
            (1.440, 0.062, 0.070, -0.024),
            (1.480, 0.055, 0.058, -0.016),
            (1.530, 0.052, 0.054, -0.006),
            (1.590, 0.053, 0.055, 0.002),
        ],
        (0.02, 0.02),
        0.030,
    )
    face = block(
        (0.0, 0.0, 0.0),
        UP,
        [
            (1.532, 0.022, 0.024, 0.060),
            (1.552, 0.046, 0.047, 0.038),
            (1.580, 0.062, 0.0595, 0.024),
            (1.615, 0.074, 0.064, 0.016),
            (1.655, 0.079, 0.069, 0.010),
            (1.700, 0.074, 0.066, 0.006),
        ],
        (0.013, 0.03),
        0.018,
    )
    nose = block(
        (0.0845, 0.0, 1.650),
        _frame((0.014, 0.0, -0.044)),
        [(0.0, 0.007, 0.008), (0.025, 0.010, 0.010), (0.043, 0.013, 0.014)],
        (0.008, 0.008),
        0.012,
    )
    brow = block(
        (0.080, 0.0, 1.661),
        _frame((-0.010, 0.045, -0.002)),
        [(0.0, 0.010, 0.010), (0.045, 0.009, 0.008)],
        (0.01, 0.01),
        0.016,
    )
    return [
        neck,
        _ball((-0.012, 0.0, 1.657), (0.099, 0.0775, 0.093), 0.025),  # skull
        face,
        _ball((0.050, 0.047, 1.610), (0.024, 0.018, 0.020), 0.030),  # cheek bone
        _ball((0.094, 0.033, 1.641), (0.017, 0.021, 0.013), 0.014, carve=True),  # eye socket
        brow,
        _ball((0.070, 0.031, 1.641), (0.0135, 0.0155, 0.0125), 0.004),  # eye
        nose,
        _ball((0.0775, 0.0, 1.581), (0.011, 0.022, 0.006), 0.008),  # upper lip
        _ball((0.0755, 0.0, 1.571), (0.011, 0.019, 0.006), 0.008),  # lower lip
        _ball((0.070, 0.0, 1.538), (0.018, 0.022, 0.015), 0.016),  # chin
        _ball((-0.008, 0.0765, 1.632), (0.017, 0.008, 0.031), 0.008, axes=_EAR),
        _ball((-0.002, 0.0860, 1.636), (0.008, 0.006, 0.016), 0.006, carve=True, axes=_EAR),
    ]


def _tilted(about_y_rad: float, about_z_rad: float) -> FloatArray:
    """Axes (3, 3) leant back about y, then opened about z."""
    c, s = np.cos(about_y_rad), np.sin(about_y_rad)
    lean = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    c, s = np.cos(about_z_rad), np.sin(about_z_rad)
    return np.asarray(lean @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))


_EAR = _tilted(0.25, 0.28)


def _leg() -> list[BodyBlock]:
    hip_z = ANKLE_HEIGHT_M + SHIN_M + THIGH_M
    knee_z, aside = ANKLE_HEIGHT_M + SHIN_M, HIP_HALF_WIDTH_M
    thigh = block(
        (0.0, aside, hip_z),
        DOWN,
        [
            (-0.015, 0.080, 0.074, -0.006, 0.010),
            (0.050, 0.088, 0.080, -0.004, 0.008),
            (0.120, 0.084, 0.076, 0.000, 0.004),
            (0.220, 0.074, 0.067, 0.004, 0.001),
            (0.320, 0.062, 0.057, 0.004, -0.001),
            (0.400, 0.053, 0.051, 0.002),
            (0.440, 0.051, 0.050, 0.000),
        ],
        (0.03, 0.03),
        0.025,
    )
    calf = block(
        (0.0, aside, knee_z),
        DOWN,
        [
            (-0.010, 0.050, 0.049, 0.001),
            (0.050, 0.049, 0.047, -0.004),
            (0.110, 0.055, 0.052, -0.014, 0.001),
            (0.170, 0.051, 0.047, -0.015, 0.001),
            (0.260, 0.038, 0.037, -0.010),
            (0.340, 0.030, 0.0295, -0.006),
            (0.395, 0.030, 0.0285, -0.006),
            (0.425, 0.032, 0.029, -0.006),
        ],
        (0.02, 0.02),
        0.020,
    )
    return [
        thigh,
        calf,
        _ball((0.046, aside - 0.020, knee_z + 0.085), (0.022, 0.026, 0.055), 0.03),  # above knee
        _ball((0.034, aside, knee_z - 0.004), (0.026, 0.032, 0.036), 0.020),  # kneecap
        _ball((-0.052, aside - 0.022, knee_z - 0.120), (0.026, 0.026, 0.075), 0.025),  # calf, inner
        _ball((-0.048, aside + 0.024, knee_z - 0.105), (0.024, 0.024, 0.065), 0.025),  # calf, outer
        _ball((-0.004, aside + 0.028, 0.072), (0.013, 0.009, 0.014), 0.014),  # ankle, outer
        _ball((0.000, aside - 0.029, 0.078), (0.014, 0.009, 0.015), 0.014),  # ankle, inner
        *_foot(aside),
    ]


def _foot(aside: float) -> list[BodyBlock]:
    """Heel, arch, ball and toe box; rows read (ahead, half height, half width, up, aside)."""
    sole = block(
        (0.0, aside, 0.0),
        AHEAD,
        [
            (-0.034, 0.034, 0.029, 0.026, 0.000),
            (0.000, 0.036, 0.033, 0.030, 0.000),
            (0.040, 0.034, 0.034, 0.026, 0.002),
            (0.085, 0.026, 0.040, 0.018, 0.004),
            (0.125, 0.021, 0.045, 0.013, 0.004),
            (0.155, 0.017, 0.043, 0.010, 0.001),
            (0.178, 0.0165, 0.036, 0.009, -0.004),
        ],
        (0.022, 0.026),
        0.022,
    )
    instep = block(
        (0.004, aside, 0.070),
        _frame((0.105, 0.006, -0.047)),
        [(0.0, 0.036, 0.029), (0.050, 0.026, 0.032), (0.115, 0.015, 0.035)],
        (0.02, 0.02),
        0.025,
    )
    return [sole, instep]


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
