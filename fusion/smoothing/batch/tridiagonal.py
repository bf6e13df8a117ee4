"""Least squares on a chain: a white-noise-acceleration prior between neighbours, a pose at each.

The state of a pose is its small move and the change of its velocity, 2 d numbers; normal equations
couple neighbours only, so they are a band and are solved in time linear in the poses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motorcade.fusion.chains import banded
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga.arrays import FloatArray


class Between(NamedTuple):
    """Vectors ``(N, d)`` from bases to targets, derivatives ``(N, d, d)`` by small moves of each.

    The derivatives of plain components are ``(1, d, d)``, the same for all.
    """

    vector: FloatArray
    by_base: FloatArray
    by_target: FloatArray


def between(representation: Representation, base: FloatArray, target: FloatArray) -> Between:
    """Vectors from bases ``(N, D)`` to targets ``(N, D)``, with their derivatives."""
    vector = representation.local(target, base)
    return Between(vector, *representation.local_jacobians(vector))


def component_sizes(
    representation: Representation, count: int, rotation: float, translation: float, scale: float
) -> FloatArray:
    """Sizes ``(d,)`` of the components of a difference for sizes in rad, m and log scale.

    A small turn changes quaternion components by half of it, and so does a small shift the dual
    part of a dual quaternion near the origin (further off, components are larger than that).
    """
    (turning, shifting), (a_radian, a_metre) = representation.ends, representation.units
    sizes = np.full(count, scale)
    sizes[:turning], sizes[turning:shifting] = a_radian * rotation, a_metre * translation
    return sizes


class Equations(NamedTuple):
    """Blocks of the normal equations: diagonal ``(N, s, s)``, below it ``(N-1, s, s)``, right-hand
    side ``(N, s)``, with s = 2 d.
    """

    diagonal: FloatArray
    below: FloatArray
    right: FloatArray

    @classmethod
    def of(
        cls,
        interval_s: FloatArray,
        density: FloatArray,
        steps: Between,
        velocity: FloatArray,
        measured: Between,
        information: FloatArray,
    ) -> Equations:
        """Linearise at poses and velocities.

        Args:
            interval_s: ``(N-1,)``.
            density: ``(d,)`` of the white acceleration.
            steps: from each pose to the next.
            velocity: ``(N, d)``.
            measured: from measured poses to the estimated ones.
            information: ``(N, d)`` of each measured component, weights included.
        """
        count, d = velocity.shape
        a, b = steps.by_base, steps.by_target
        move, speed = slice(0, d), slice(d, 2 * d)
        diagonal, below = np.zeros((count, 2 * d, 2 * d)), np.zeros((count - 1, 2 * d, 2 * d))
        right = np.zeros((count, 2 * d))
        w11, w12, w22 = _weights(interval_s, density)
        first, second = prior_residuals(interval_s, steps, velocity)
        pull, push = w11 * first + w12 * second, w12 * first + w22 * second
        at, bt = np.swapaxes(a, 1, 2), np.swapaxes(b, 1, 2)
        every = np.arange(d)
        early, late = diagonal[:-1], diagonal[1:]
        early[:, move, move] += at @ (w11[:, :, None] * a)
        early[:, move, speed] += at * w12[:, None, :]
        early[:, speed, move] += w12[:, :, None] * a
        early[:, d + every, d + every] += w22
        late[:, move, move] += bt @ (w11[:, :, None] * b)
        late[:, move, speed] += bt * w12[:, None, :]
        late[:, speed, move] += w12[:, :, None] * b
        late[:, d + every, d + every] += w22
        below[:, move, move] = bt @ (w11[:, :, None] * a)
        below[:, move, speed] = bt * w12[:, None, :]
        below[:, speed, move] = w12[:, :, None] * a
        below[:, d + every, d + every] = 0.5 * w22
        right[:-1, move] -= _times(at, pull)
        right[:-1, speed] += interval_s[:, None] * pull + push
        right[1:, move] -= _times(bt, pull)
        right[1:, speed] -= push
        c = measured.by_target
        ct = np.swapaxes(c, 1, 2)
        diagonal[:, move, move] += ct @ (information[:, :, None] * c)
        right[:, move] -= _times(ct, information * measured.vector)
        return cls(diagonal, below, right)


def prior_residuals(
    interval_s: FloatArray, steps: Between, velocity: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What the steps and the changes of velocity ``(N-1, d)`` leave of constant velocity."""
    return steps.vector - interval_s[:, None] * velocity[:-1], np.diff(velocity, axis=0)


def prior_cost(
    interval_s: FloatArray, density: FloatArray, steps: Between, velocity: FloatArray
) -> float:
    """Squared residuals of the prior, in its own deviations."""
    w11, w12, w22 = _weights(interval_s, density)
    first, second = prior_residuals(interval_s, steps, velocity)
    return float(np.sum(w11 * first**2 + 2.0 * w12 * first * second + w22 * second**2))


def solved(equations: Equations, damping: float) -> FloatArray:
    """Steps ``(N, s)``, or ``(N, s, k)`` for k right-hand sides.

    `damping` adds that part of the diagonal to it (Marquardt).

    Raises:
        ModuleNotFoundError: scipy is missing.
    """
    try:
        from scipy.linalg import solveh_banded
    except ModuleNotFoundError as missing:
        raise ModuleNotFoundError(
            'robust_map needs scipy: pip install "motorcade[pipeline]" brings it', name="scipy"
        ) from missing
    count, size = equations.right.shape[:2]
    band = banded(equations.diagonal, equations.below)
    band[0] *= 1.0 + damping
    try:
        right = equations.right.reshape(count * size, *equations.right.shape[2:])
        made = solveh_banded(band, right, overwrite_ab=True, lower=True)
    except np.linalg.LinAlgError as lost:
        raise ValueError(
            "acceleration, noise: expected a motion model that rounding leaves solvable, got "
            "accelerations too small for the noise and the stamps"
        ) from lost
    return np.asarray(made, dtype=np.float64).reshape(equations.right.shape)


def _weights(
    interval_s: FloatArray, density: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Inverse of ``q² [[dt³/3, dt²/2], [dt²/2, dt]]``, each entry ``(N-1, d)``."""
    information = density**-2.0
    dt = interval_s[:, None]
    return 12.0 / dt**3 * information, -6.0 / dt**2 * information, 4.0 / dt * information


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    return np.asarray((matrices @ vectors[..., None])[..., 0], dtype=np.float64)
