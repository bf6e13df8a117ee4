"""Rotation, velocity and position as one group element, SE₂(3), and its exponential.

An element acts as `(R, v, p)`; its tangent is `(φ, ν, ρ)`, rad, m/s, m, in the world's axes, and a
left factor `Exp(ξ)` moves an estimate by an error that does not depend on where the estimate is
(A. Barrau and S. Bonnabel, The invariant extended Kalman filter as a stable observer, IEEE TAC
62(4), 2017). Plain arrays without a batch: these run once a filter step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import FloatArray

__all__ = ["ExtendedPose", "rotation_exp", "skew"]

_SMALL = 1e-4


@dataclass(frozen=True, eq=False)
class ExtendedPose:
    """Rotation matrix `R` (3, 3), velocity `v` (3,) in m/s and position `p` (3,) in m."""

    R: FloatArray
    v: FloatArray
    p: FloatArray

    def moved(self, xi: FloatArray) -> ExtendedPose:
        """`Exp(ξ)` times this element, ξ (9,) as (φ, ν, ρ)."""
        turn, spread = _exp_and_jacobian(xi[:3])
        return ExtendedPose(
            turn @ self.R,
            turn @ self.v + spread @ xi[3:6],
            turn @ self.p + spread @ xi[6:9],
        )

    def error_from(self, other: ExtendedPose) -> FloatArray:
        """ξ (9,) with `Exp(ξ) other = self`; the rotation between them is below π."""
        turn = self.R @ other.R.T
        phi = _rotation_log(turn)
        _, spread = _exp_and_jacobian(phi)
        offsets = np.stack([self.v - turn @ other.v, self.p - turn @ other.p], axis=1)
        return np.concatenate([phi, np.linalg.solve(spread, offsets).T.ravel()])


def skew(vectors: FloatArray) -> FloatArray:
    """Matrices (*, 3, 3) of the cross product with vectors (*, 3)."""
    matrices = np.zeros((*vectors.shape, 3))
    matrices[..., 2, 1], matrices[..., 1, 2] = vectors[..., 0], -vectors[..., 0]
    matrices[..., 0, 2], matrices[..., 2, 0] = vectors[..., 1], -vectors[..., 1]
    matrices[..., 1, 0], matrices[..., 0, 1] = vectors[..., 2], -vectors[..., 2]
    return matrices


def rotation_exp(vectors_rad: FloatArray) -> FloatArray:
    """Rotation matrices (*, 3, 3) of rotation vectors (*, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(vectors_rad, axis=-1)[..., None, None]
    cross = skew(vectors_rad)
    small = angle < _SMALL
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 1.0 - angle**2 / 6, np.sin(safe) / safe)
    second = np.where(small, 0.5 - angle**2 / 24, (1.0 - np.cos(safe)) / safe**2)
    matrices: FloatArray = np.eye(3) + first * cross + second * (cross @ cross)
    return matrices


def _exp_and_jacobian(phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation matrix of φ and the left Jacobian of SO(3) at φ."""
    angle = float(np.sqrt(phi @ phi))
    cross = skew(phi)
    square = cross @ cross
    if angle < _SMALL:
        a, b, c = 1.0 - angle**2 / 6, 0.5 - angle**2 / 24, 1 / 6 - angle**2 / 120
    else:
        a = np.sin(angle) / angle
        b = (1.0 - np.cos(angle)) / angle**2
        c = (1.0 - a) / angle**2
    identity = np.eye(3)
    return identity + a * cross + b * square, identity + b * cross + c * square


def _rotation_log(rotation: FloatArray) -> FloatArray:
    """Rotation vector (3,) of a matrix whose angle is below π."""
    half_sine = 0.5 * np.array([
        rotation[2, 1] - rotation[1, 2],
        rotation[0, 2] - rotation[2, 0],
        rotation[1, 0] - rotation[0, 1],
    ])  # fmt: skip
    sine = float(np.sqrt(half_sine @ half_sine))
    angle = float(np.arctan2(sine, 0.5 * (np.trace(rotation) - 1.0)))
    vector: FloatArray = half_sine * (angle / sine if sine > 1e-12 else 1.0)
    return vector
