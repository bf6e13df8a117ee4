"""Extended poses: position and velocity under one rotation, as a pair of motors.

The group SE₂(3) of (R, p, v) is a Motor of shape ``(*, 2)``: the pose, and the same rotor with the
velocity in place of the translation. Composition, exponential and logarithm are then those of
motors, member by member. An error ξ of 15 numbers is

    rotation φ (rad), position ρ (m), velocity ν (m/s), gyroscope bias, accelerometer bias,

its first nine in the moving frame: ``true = estimate @ Exp(φ, ρ, ν)``; a true bias is the estimate
plus its error.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["ERROR_SIZE", "corrected", "extended_pose"]

ERROR_SIZE = 15


def extended_pose(rotor: Rotor, position_m: FloatArray, velocity_m_s: FloatArray) -> Motor:
    """Motor ``(*, 2)`` of a rotor ``(*)``, position and velocity ``(*, 3)``."""
    both = np.stack([position_m, velocity_m_s], axis=-2)
    return Motor.from_rotor_translation(rotor.reshape(*rotor.shape, 1), both)


def corrected(pose: Motor, error: FloatArray) -> Motor:
    """Extended poses ``(*, 2)`` retracted by the first nine numbers of errors ``(*, 15)``."""
    return pose.retract(_pairs(error))


def _pairs(error: FloatArray) -> FloatArray:
    """Twists ``(*, 2, 6)``: rotation with position, rotation with velocity."""
    return np.stack([error[..., :6], error[..., [0, 1, 2, 6, 7, 8]]], axis=-2)
