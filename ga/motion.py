"""Poses with their derivatives, and what twists do: the common language of all paths.

A twist is the velocity of a body in its own frame, ``pose' = pose · twist``: angular rate (rad/s),
velocity of its origin (m/s), and for similarities the rate of the logarithm of the scale (1/s)
after them; ``(*, 6)`` for motors, ``(*, 7)`` for similarities. Batch in front.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.similarity import Similarity

__all__ = ["SplineSample", "TwistSample", "sampled_motion", "twist_bracket"]

V = TypeVar("V", Motor, Similarity)


@dataclass(frozen=True, eq=False)
class TwistSample(Generic[V]):
    """Pose, first and second derivative at the evaluated times, batch ``(*)`` in front.

    ``pose`` is ``parent_T_child``; ``body_twist`` and its derivative ``body_twist_rate`` are
    ``(*, 6)``, or ``(*, 7)`` for similarities, in the child's frame.
    """

    pose: V
    body_twist: FloatArray
    body_twist_rate: FloatArray


@dataclass(frozen=True, eq=False)
class SplineSample:
    """Pose and exact derivatives at the evaluated times, batch ``(*)`` in front.

    ``pose`` is ``parent_T_child``. Rates are in the child's (body) frame, velocity and
    acceleration are of the child's origin in the parent's (world) frame, without gravity.
    """

    pose: Motor
    body_angular_rate_rad_s: FloatArray
    body_angular_acceleration_rad_s2: FloatArray
    world_velocity_m_s: FloatArray
    world_acceleration_m_s2: FloatArray


def sampled_motion(sample: TwistSample[Motor]) -> SplineSample:
    """The same derivatives as an inertial sensor or a plot wants them."""
    rotation, twist, rate = sample.pose.rotor, sample.body_twist, sample.body_twist_rate
    body_acceleration = rate[..., 3:] + np.cross(twist[..., :3], twist[..., 3:])
    return SplineSample(
        sample.pose, twist[..., :3], rate[..., :3],
        rotation.apply(twist[..., 3:]), rotation.apply(body_acceleration),
    )  # fmt: skip


def twist_bracket(a: FloatArray, b: FloatArray) -> FloatArray:
    """Commutator of twists, ``(*, 6)`` or ``(*, 7)``."""
    turn = np.cross(a[..., :3], b[..., :3])
    shift = np.cross(a[..., :3], b[..., 3:6]) + np.cross(a[..., 3:6], b[..., :3])
    if a.shape[-1] == 6:
        return np.concatenate([turn, shift], axis=-1)
    shift = shift + a[..., 6:] * b[..., 3:6] - b[..., 6:] * a[..., 3:6]
    return np.concatenate([turn, shift, np.zeros_like(turn[..., :1])], axis=-1)
