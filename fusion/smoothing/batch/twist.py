"""Paths of one constant twist, as of a screw, a spin or a body at rest.

However stiff the splines of its axes are, a body that turns takes the axes along, and errors with
them. But where nothing else moves the path is ``X exp(t ξ)``, whose twelve numbers least squares
tell from all poses (T. D. Barfoot, State Estimation for Robotics, 2nd ed., 2024, ch. 7); where it
goes anywhere and turns evenly, six do for its rotations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.fusion.smoothing.batch.columns import (
    COARSE,
    ColumnModel,
    ColumnPath,
    ColumnStretch,
    likelihoods,
    ratio_of,
)
from motorcade.fusion.smoothing.representation import Representation
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

_ROUNDS = 4
# Noise of an axis that is finer by more than this than the usual one hinders more than it tells.
_FINEST = 0.1
# Noise of rotations in rad, or positions in m, that is none.
_LEAST = 1e-9


def twisted(
    representation: Representation,
    time_s: FloatArray,
    coordinates: FloatArray,
    path: FloatArray,
    weights: FloatArray,
    models: Sequence[ColumnModel],
) -> dict[int, ColumnPath]:
    """The columns whose models are stiff, as splines have them, of values beyond a path's.

    Args:
        representation: motors where rotations and positions are stiff, else rotors.
        time_s: ``(N,)`` increasing.
        coordinates: ``(N, D)`` of measured poses.
        path: ``(N, D)`` near them, to start from.
        weights: ``(N,)`` of these.
        models: of the columns.
    """
    stiff = [k for k, model in enumerate(models) if model.stiff]
    if not stiff:
        return {}
    poses, near = (representation.poses(one).rigid for one in (coordinates, path))
    if len(stiff) == 3:
        poses, near = (
            Motor.from_rotor_translation(one.rotor, np.zeros((len(one), 3)))
            for one in (poses, near)
        )
    parts = np.reshape([one.noise for one in models[: len(stiff)]], (-1, 3))
    usual = np.sqrt(np.mean(parts**2, axis=1, keepdims=True))
    noise = np.resize(np.maximum(parts, _FINEST * usual) + _LEAST, 6)
    found, off, spread = _fitted(time_s, poses, near, weights, noise)
    beyond = (near.inverse() @ found).as_twist()
    others = spread / np.maximum(1.0 - weights[:, None] * spread, _LEAST)
    left_out = off * (1.0 + weights[:, None] * others)
    return {k: ColumnPath(beyond[:, k], left_out[:, k], others[:, k], spread[:, k]) for k in stiff}


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


def moves_beside(stretch: ColumnStretch, columns: int) -> bool:
    """Whether the first of some columns, of poses beyond a path, hold motion.

    That is where a spline of a velocity that white noise changes makes them likelier than noise
    does by what G. Schwarz asks for of two numbers more: how large that is, and where it starts.
    """
    interval_s = float(np.median(np.diff(stretch.time_s)))
    found = [likelihoods([stretch], 1, ratio_of(one, 1, interval_s), 0.0) for one in COARSE]
    gained = np.max(found, axis=0) - found[0]
    return bool(np.any(gained[:columns] > np.log(np.count_nonzero(stretch.weights))))
