"""From one stamp to the next on inertial data alone: mean, transition matrix, added covariance.

The state is (R, v, p) and the biases of gyroscope and accelerometer; its error (φ, ν, ρ, δb_g,
δb_a) stands on the left of the estimate, in the world's axes, so that only biases couple it to
the estimate. Between samples rate and force are taken at their means (trapezoid).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.filter.extended_pose import ExtendedPose, rotation_exp, skew
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.ga import FloatArray

__all__ = ["ERROR_SIZE", "Samples", "Step", "propagate"]

ERROR_SIZE = 15
"""φ, ν, ρ, δb_g, δb_a: three numbers each."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Inertial data of one step: intervals (K,) s, mean rate and force (K, 3) in each."""

    interval_s: FloatArray
    rate_rad_s: FloatArray
    force_m_s2: FloatArray


@dataclass(frozen=True, eq=False)
class Step:
    """Where a step leads: the predicted element, its transition (15, 15), its noise (15, 15)."""

    predicted: ExtendedPose
    transition: FloatArray
    noise: FloatArray


def propagate(
    start: ExtendedPose,
    gyro_bias: FloatArray,
    accel_bias: FloatArray,
    samples: Samples,
    noise: ImuNoise,
    gravity: FloatArray,
) -> Step:
    """Carry an estimate over all samples of a step; `gravity` (3,) is the world's, m/s²."""
    dt = samples.interval_s[:, None]
    turns = rotation_exp((samples.rate_rad_s - gyro_bias) * dt)
    halves = rotation_exp(0.5 * (samples.rate_rad_s - gyro_bias) * dt)
    count = len(samples.interval_s)
    rotations = np.empty((count + 1, 3, 3))
    rotations[0] = start.R
    for k in range(count):
        rotations[k + 1] = rotations[k] @ turns[k]
    force = (samples.force_m_s2 - accel_bias)[..., None]
    acceleration = (rotations[:-1] @ halves @ force)[..., 0] + gravity
    velocity = start.v + np.concatenate([np.zeros((1, 3)), np.cumsum(acceleration * dt, axis=0)])
    moves = velocity[:-1] * dt + 0.5 * acceleration * dt**2
    position = start.p + np.concatenate([np.zeros((1, 3)), np.cumsum(moves, axis=0)])
    transition, added = np.eye(ERROR_SIZE), np.zeros((ERROR_SIZE, ERROR_SIZE))
    steps = _transitions(rotations[:-1], velocity[:-1], position[:-1], samples.interval_s, gravity)
    noises = _noises(rotations[:-1], velocity[:-1], position[:-1], samples.interval_s, noise)
    for k in range(count):
        transition = steps[k] @ transition
        added = steps[k] @ added @ steps[k].T + noises[k]
    end = ExtendedPose(rotations[-1], velocity[-1], position[-1])
    return Step(end, transition, added)


def _transitions(
    R: FloatArray, v: FloatArray, p: FloatArray, interval_s: FloatArray, gravity: FloatArray
) -> FloatArray:
    """`I + A dt + A² dt² / 2` (K, 15, 15) of the error's linear dynamics."""
    dynamics = np.zeros((len(interval_s), ERROR_SIZE, ERROR_SIZE))
    dynamics[:, 0:3, 9:12] = -R
    dynamics[:, 3:6, 0:3] = skew(gravity)
    dynamics[:, 3:6, 9:12] = -skew(v) @ R
    dynamics[:, 3:6, 12:15] = -R
    dynamics[:, 6:9, 3:6] = np.eye(3)
    dynamics[:, 6:9, 9:12] = -skew(p) @ R
    step = dynamics * interval_s[:, None, None]
    transitions: FloatArray = np.eye(ERROR_SIZE) + step + 0.5 * (step @ step)
    return transitions


def _noises(
    R: FloatArray, v: FloatArray, p: FloatArray, interval_s: FloatArray, noise: ImuNoise
) -> FloatArray:
    """Covariance (K, 15, 15) that white noise and bias walks add in each interval."""
    entry = np.zeros((len(interval_s), ERROR_SIZE, 12))
    entry[:, 0:3, 0:3] = R
    entry[:, 3:6, 0:3] = skew(v) @ R
    entry[:, 6:9, 0:3] = skew(p) @ R
    entry[:, 3:6, 3:6] = R
    entry[:, 9:12, 6:9] = entry[:, 12:15, 9:12] = np.eye(3)
    density = np.repeat(
        [
            noise.gyro_density_rad_s_rthz,
            noise.accel_density_m_s2_rthz,
            noise.gyro_walk_rad_s2_rthz,
            noise.accel_walk_m_s3_rthz,
        ],
        3,
    )
    scaled = entry * density
    added: FloatArray = scaled @ scaled.swapaxes(-1, -2) * interval_s[:, None, None]
    return added
