"""Figures for the tests of inverse kinematics, and their limits measured by SciPy alone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from motorcade.animation import Skeleton
from motorcade.animation.ik import Ball, Hinge
from motorcade.animation.ik.chain import JointKind
from motorcade.ga import Motor, Rotor


def chain(rng: np.random.Generator, count: int, *, bone_m: float = 0.3) -> Skeleton:
    """A chain of joints that stand in any way in each other at rest."""
    rotor = Rotor.from_rotation_vector(0.8 * rng.standard_normal((count, 3)))
    shift = rng.standard_normal((count, 3))
    shift *= bone_m / np.linalg.norm(shift, axis=1, keepdims=True)
    names = tuple(f"j{k}" for k in range(count))
    return Skeleton(names, np.arange(count) - 1, Motor.from_rotor_translation(rotor, shift))


def mixed_joints(rng: np.random.Generator, skeleton: Skeleton) -> dict[str, JointKind]:
    """Hinges, cones, ellipses, twists, joints without limits and such of no width."""
    made: dict[str, JointKind] = {}
    for k, name in enumerate(skeleton.names[:-1]):
        low, high = np.sort(rng.uniform(-1.2, 1.2, 2))
        axis, across = rng.standard_normal((2, 3))
        wide = rng.uniform(0.1, 1.4, 2)
        made[name] = (
            Hinge(axis, low, high),
            Ball(float(wide[0]), (low, high)),
            Ball((wide[0], wide[1]), (-0.3, 0.4), axis=axis, across=across),
            Ball(),
            Ball((0.0, wide[1]), (0.0, 0.0), axis=axis, across=across),
            Hinge(axis, 0.2, 0.2),
            Ball(np.pi, (low, high)),
        )[(k + int(rng.integers(7))) % 7]
    return made


def turns(skeleton: Skeleton, pose: Motor, joint: str) -> Rotation:
    """How a joint is turned from its rest pose, in its own frame."""
    k = skeleton.index(joint)
    rest, now = (
        Rotation.from_quat(one[..., k].rotor.as_quaternion(), scalar_first=True)
        for one in (skeleton.rest, pose)
    )
    return rest.inv() * now


def excess(skeleton: Skeleton, pose: Motor, joints: Mapping[str, JointKind]) -> float:
    """By how much the worst joint of one pose is beyond its limits, in radians."""
    worst = 0.0
    for name, kind in joints.items():
        turn = turns(skeleton, pose, name)
        if isinstance(kind, Hinge):
            axis = np.asarray(kind.axis) / np.linalg.norm(kind.axis)
            vector = turn.as_rotvec()
            angle = vector @ axis
            worst = max(worst, float(np.linalg.norm(vector - angle * axis)))
            worst = max(worst, kind.low_rad - angle, angle - kind.high_rad)
        elif isinstance(kind, Ball) and kind.limited:
            worst = max(worst, _excess_of_ball(skeleton, turn, name, kind))
    return worst


def swing_and_twist(turn: Rotation, axis: np.ndarray) -> tuple[np.ndarray, float]:
    """The rotation vector of the swing that comes after the twist about an axis."""
    w, *v = turn.as_quat(scalar_first=True)
    twist = 2.0 * np.arctan2(np.dot(v, axis), w)
    twist -= 2.0 * np.pi * np.round(twist / (2.0 * np.pi))
    return (turn * Rotation.from_rotvec(-twist * axis)).as_rotvec(), float(twist)


def axes_of(skeleton: Skeleton, name: str, kind: Ball) -> tuple[np.ndarray, np.ndarray]:
    """Axis and what the first swing turns about, of length 1."""
    child = np.flatnonzero(skeleton.parents == skeleton.index(name))
    axis = skeleton.rest[int(child[0])].translation_m if kind.axis is None else kind.axis
    axis = np.asarray(axis) / np.linalg.norm(axis)
    across = np.cross(axis, [0.3, 0.5, 0.8]) if kind.across is None else np.asarray(kind.across)
    across = across - (across @ axis) * axis
    return axis, across / np.linalg.norm(across)


def _excess_of_ball(skeleton: Skeleton, turn: Rotation, name: str, kind: Ball) -> float:
    axis, across = axes_of(skeleton, name, kind)
    swing, twist = swing_and_twist(turn, axis)
    half = np.broadcast_to(kind.swing_rad, (2,))
    at = np.array([swing @ across, swing @ np.cross(axis, across)])
    over = float(max(0.0, kind.twist_rad[0] - twist, twist - kind.twist_rad[1]))
    if np.all(half >= np.pi):
        return over
    flat = half == 0.0
    over = max(over, float(np.abs(at[flat]).max(initial=0.0)))
    share = np.linalg.norm(at[~flat] / half[~flat]) if np.any(~flat) else 0.0
    return max(over, float((share - 1.0) * np.max(half)))
