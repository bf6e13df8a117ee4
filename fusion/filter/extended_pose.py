"""Extended poses: position and velocity under one rotation, as a pair of motors.

The group SE₂(3) of (R, p, v) is a Motor of shape ``(*, 2)``: the pose, and the same rotor with the
velocity in place of the translation. Composition, exponential and logarithm are then those of
motors, member by member. An error ξ of 15 numbers is

    rotation φ (rad), position ρ (m), velocity ν (m/s), gyroscope bias, accelerometer bias,

its first nine in the moving frame: ``true = estimate @ Exp(φ, ρ, ν)``; a true bias is the estimate
plus its error.

What inertial samples add to an extended pose: motion, transition of its error, covariance.

Over a step Δt the moving frame's rate and force are taken as constant, and

    R' = R ΔR,   v' = v + g Δt + R Δv,   p' = p + v Δt + ½ g Δt² + R Δp

holds exactly. ΔR, Δv, Δp and their derivatives are written once, in
`motorcade.fusion.filter.model.definitions`; this calls the C that is generated from them.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.filter.native import _filter
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray

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


def increments(
    first: IntArray,
    dt_s: FloatArray,
    rate_rad_s: FloatArray,
    force_m_s2: FloatArray,
    bias: FloatArray,
    noise: ImuNoise,
    *,
    held: bool = False,
) -> tuple[Motor, FloatArray, FloatArray]:
    """What M steps add up to over K intervals.

    Args:
        first: ``(K,)`` rising; the first step of each interval, which ends where the next begins.
        dt_s: ``(M,)`` lengths; steps that turn by 3 rad or more are taken in equal parts.
        rate_rad_s: ``(M, 3)``, constant over each step.
        force_m_s2: likewise.
        bias: ``(6,)`` or ``(M, 6)`` of gyroscope and accelerometer, taken off the readings.
        noise: densities and walks; white noise acts as a bias of each step alone.
        held: the force acts in the axes at the start of a step for the whole of it, as in gtsam's
            preintegration on a manifold.

    Returns:
        Extended poses ``(K, 2)``: ΔR with Δp, ΔR with Δv; the matrices ``(K, 15, 15)`` that an
        error at the start is multiplied with, and the covariances ``(K, 15, 15)`` that come to it.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.extended_pose import increments
        >>> from motorcade.fusion.imu import ADIS16448
        >>> rate, force = np.array([[0.0, 0.0, 1.0]]), np.array([[2.0, 0.0, 0.0]])
        >>> motion, transition, covariance = increments(
        ...     np.array([0]), np.array([0.01]), rate, force, np.zeros(6), ADIS16448
        ... )
        >>> motion[0, 1].translation_m[:2].round(6)  # velocity gained, in the axes at the start
        array([0.02  , 0.0001])
    """
    count, steps = len(first), len(dt_s)
    pose, velocity = np.empty((count, 8)), np.empty((count, 3))
    transition, covariance = np.empty((2, count, ERROR_SIZE, ERROR_SIZE))
    integrate = _filter.held_increments if held else _filter.increments
    integrate(
        np.ascontiguousarray(first, dtype=np.int64),
        np.ascontiguousarray(dt_s),
        np.ascontiguousarray(rate_rad_s),
        np.ascontiguousarray(force_m_s2),
        np.ascontiguousarray(np.broadcast_to(bias, (steps, 6))),
        _squares(noise),
        pose,
        velocity,
        transition,
        covariance,
    )
    unit = Motor.normalize(pose)
    return extended_pose(unit.rotor, unit.translation_m, velocity), transition, covariance


def process_noise(dt_s: FloatArray, noise: ImuNoise) -> FloatArray:
    """Covariances ``(K, 15, 15)`` that noise and bias walks, acting all the time, add to steps."""
    added = np.empty((len(dt_s), ERROR_SIZE, ERROR_SIZE))
    _filter.process_noise(np.ascontiguousarray(dt_s), _squares(noise), added)
    return added


def _squares(noise: ImuNoise) -> tuple[float, float, float, float]:
    return (
        noise.gyro_density_rad_s_rthz**2,
        noise.accel_density_m_s2_rthz**2,
        noise.gyro_walk_rad_s2_rthz**2,
        noise.accel_walk_m_s3_rthz**2,
    )
