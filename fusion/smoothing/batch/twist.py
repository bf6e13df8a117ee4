"""Columns that move together: of one constant twist, or of rotations that turn fast.

However stiff the splines of its axes are, a body that turns takes the axes along, and errors with
them. But where nothing else moves the path is ``X exp(t ξ)``, whose twelve numbers least squares
tell from all poses (T. D. Barfoot, State Estimation for Robotics, 2nd ed., 2024, ch. 7); where it
goes anywhere and turns evenly, six do for its rotations. Where the rate changes as well, a Kalman
filter and smoother propagates errors of all three axes along the turn (`causal.kalman`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.fusion.smoothing.batch.columns import (
    COARSE,
    FINE,
    ColumnModel,
    ColumnPath,
    ColumnSegment,
    likelihoods,
    ratio_of,
)
from motorcade.fusion.smoothing.causal.kalman import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    smoothed_states,
)
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

_ROUNDS = 4
# Noise of an axis that is finer by more than this than the usual one hinders more than it tells.
FINEST = 0.1
# Noise of rotations in rad, or positions in m, that is none.
LEAST = 1e-9
# Orders of rotations that are smoothed together, the least weight that a pose has there, and noise
# that is enough for rounding.
_JOINT_ORDERS, _LIGHTEST, _NO_NOISE = (1, 2), 1e-12, 1e-6

# Shares of an error that may be left at the next pose, and how many such memories a path must span
# for errors to be told from motion.
_KEPT, _MEMORIES = (0.3, 0.5, 0.7, 0.8, 0.9), 32.0


def moved_together(
    representation: Representation,
    time_s: FloatArray,
    coordinates: FloatArray,
    path: FloatArray,
    weights: FloatArray,
    models: Sequence[ColumnModel],
) -> dict[int, ColumnPath]:
    """The columns whose models are stiff or joint, as splines have them, of values beyond a path's.

    Args:
        representation: motors where rotations and positions are stiff, else rotors or motors.
        time_s: ``(N,)`` increasing.
        coordinates: ``(N, D)`` of measured poses.
        path: ``(N, D)`` near them, to start from.
        weights: ``(N,)`` of these.
        models: of the columns.
    """
    stiff = [k for k, model in enumerate(models) if model.stiff]
    joint = models[0].joint
    if not stiff and not joint:
        return {}
    poses, near = (representation.poses(base).rigid for base in (coordinates, path))
    if joint:
        smoothed, spread = turned_together(time_s, poses, weights, models[0])
        beyond, off = (
            (base.rotor.inverse() @ other.rotor).as_rotation_vector()
            for base, other in ((near, smoothed), (smoothed, poses))
        )
        others = spread / np.maximum(1.0 - weights * spread, LEAST)
        left_out = off * (1.0 + weights * others)[:, None]
        return {k: ColumnPath(beyond[:, k], left_out[:, k], others, spread) for k in range(3)}
    if len(stiff) == 3:
        poses, near = (
            Motor.from_rotor_translation(base.rotor, np.zeros((len(base), 3)))
            for base in (poses, near)
        )
    parts = np.reshape([base.noise for base in models[: len(stiff)]], (-1, 3))
    usual = np.sqrt(np.mean(parts**2, axis=1, keepdims=True))
    noise = np.resize(np.maximum(parts, FINEST * usual) + LEAST, 6)
    fitted, off, spread = _fitted(time_s, poses, near, weights, noise)
    beyond = (near.inverse() @ fitted).as_twist()
    columns = {}
    for k in stiff:
        others = spread[:, k] / np.maximum(1.0 - weights * spread[:, k], LEAST)
        left_out = off[:, k] * (1.0 + weights * others)
        if models[k].memory_s > 0.0:
            beside, less = _beside(time_s, left_out, weights, models[k].memory_s)
            # Of an error whose variance is that of weight 1 divided by its own.
            left_out, others = left_out - beside, others - less / np.where(weights > 0, weights, 1)
        columns[k] = ColumnPath(beyond[:, k], left_out, others, spread[:, k])
    return columns


def _beside(
    time_s: FloatArray, off: FloatArray, weights: FloatArray, memory_s: float
) -> tuple[FloatArray, FloatArray]:
    """What errors ``(N,)`` that last tell of those between, and by what share of their variance.

    The nearest to either side tell it all (G. E. Uhlenbeck, L. S. Ornstein, 1930).
    """
    rows, kept = np.flatnonzero(weights), np.arange(len(off))
    before = np.searchsorted(rows, kept) - 1
    behind = np.searchsorted(rows, kept, "right")
    near = []
    for place, there in ((before, before >= 0), (behind, behind < len(rows))):
        row = rows[np.clip(place, 0, len(rows) - 1)]
        left = np.exp(-np.abs(time_s[row] - time_s) / memory_s)
        near.append((np.where(there, left, 0.0), off[row]))
    (first, past), (last, next_) = near
    both = 1.0 - (first * last) ** 2
    shared = (first * (1.0 - last**2) * past + last * (1.0 - first**2) * next_) / both
    return shared, 1.0 - (1.0 - first**2) * (1.0 - last**2) / both


def _fitted(
    time_s: FloatArray, poses: Motor, path: Motor, weights: FloatArray, noise: FloatArray
) -> tuple[Motor, FloatArray, FloatArray]:
    """The likeliest path, twists ``(N, 6)`` from it to poses, and its variance in their noise's."""
    middle = len(time_s) // 2
    passed_s = (time_s - time_s[middle])[:, None]
    steps = (path[:-1].inverse() @ path[1:]).as_twist() / np.diff(time_s)[:, None]
    pose, twist = path[middle], np.median(steps, axis=0)
    step, scales = np.zeros(12), np.sqrt(weights)[:, None] / noise
    for _ in range(_ROUNDS + 1):
        pose, twist = pose @ Motor.from_twist(step[:6]), twist + step[6:]
        moved = Motor.from_twist(twist * passed_s)
        off = ((pose @ moved).inverse() @ poses).as_twist()
        turned = passed_s[..., None] * Motor.right_jacobian(twist * passed_s)
        slopes = np.concatenate([moved.inverse().adjoint(), turned], axis=2)
        rows = (slopes * scales[..., None]).reshape(-1, 12)
        covariance = np.linalg.pinv(rows.T @ rows, hermitian=True)
        step = covariance @ (rows.T @ (off * scales).ravel())
    spread = np.einsum("nij,jk,nik->ni", slopes, covariance, slopes, optimize=True)
    return pose @ moved, off, spread / noise**2


def turned_together(
    time_s: FloatArray, poses: Motor, weights: FloatArray, model: ColumnModel
) -> tuple[Motor, FloatArray]:
    """Poses ``(N,)`` with smoothed rotations, and their variance in that of a pose of weight 1."""
    noise = max(model.noise, _NO_NOISE)
    noise_rad = noise / np.sqrt(np.maximum(weights, _LIGHTEST))
    chosen = (
        ConstantVelocityFilter(
            angular_acceleration_rad_s2=model.ratio * noise,
            noise_rad=noise_rad,
            representation="rotor",
        )
        if model.order == 1
        else ConstantAccelerationFilter(
            angular_jerk_rad_s3=model.ratio * noise, noise_rad=noise_rad, representation="rotor"
        )
    )
    still = Motor.from_rotor_translation(poses.rotor, np.zeros((len(poses), 3)))
    states = smoothed_states(Trajectory(np.rint(1e9 * time_s).astype(np.int64), still), chosen)
    return states.trajectory.motors, (states.deviations[:, 0, 0] / noise) ** 2


def turning_model(
    time_s: FloatArray, poses: Motor, weights: FloatArray, noise: float
) -> ColumnModel:
    """What predicts each rotation best from all others, by generalised cross-validation."""
    interval_s, kept = float(np.median(np.diff(time_s))), weights > 0.0

    def scored(order: int, level: float) -> tuple[float, ColumnModel]:
        model = ColumnModel(order, ratio_of(level, order, interval_s), noise, joint=True)
        smoothed, spread = turned_together(time_s, poses, weights, model)
        off = (smoothed.rotor.inverse() @ poses.rotor).angle()[kept]
        shares = 1.0 - (weights * spread)[kept]
        return float(np.mean(weights[kept] * off**2) / np.mean(shares) ** 2), model

    tried = [scored(order, level) for order in _JOINT_ORDERS for level in COARSE]
    best = int(np.argmin([score for score, _ in tried]))
    order, level = _JOINT_ORDERS[best // len(COARSE)], COARSE[best % len(COARSE)]
    tried += [scored(order, level + step) for step in FINE]
    return min(tried, key=lambda trial: trial[0])[1]


def memories_beside(segment: ColumnSegment, columns: int) -> FloatArray | None:
    """For how many seconds errors ``(columns,)`` last of which poses beyond a path consist; else
    None, where the first of some columns hold motion too.

    That is where a spline of a velocity that white noise changes makes them likelier than errors
    alone do, white or lasting, by what G. Schwarz asks for of two numbers more: how large that is,
    and where it starts. What is much finer than errors about the other axes is none.
    """
    interval_s, rows = float(np.median(np.diff(segment.time_s))), np.count_nonzero(segment.weights)
    memories_s = [0.0] + [
        -interval_s / float(np.log(kept)) for kept in _KEPT if -np.log(kept) * rows >= _MEMORIES
    ]
    ratios = [ratio_of(level, 1, interval_s) for level in COARSE]
    likelihood = np.array(
        [[likelihoods([segment], 1, ratio, one) for ratio in ratios] for one in memories_s]
    )[..., :columns]
    gained = np.max(likelihood, axis=(0, 1)) - np.max(likelihood[:, 0], axis=0)
    parts = np.sqrt(np.mean(segment.values[:, :columns] ** 2, axis=0)).reshape(-1, 3)
    counts = parts > FINEST * np.sqrt(np.mean(parts**2, axis=1, keepdims=True))
    if np.any(gained[counts.ravel()] > np.log(rows)):
        return None
    still = np.sum(likelihood[:, 0].reshape(len(memories_s), -1, 3), axis=2)
    still[1:] -= np.log(rows)  # a memory is one number more, which must be worth it
    return np.repeat(np.array(memories_s)[np.argmax(still, axis=0)], 3)
