"""Least-squares fit of a cumulative B-spline's control motors to poses.

Minimised is the sum over the poses of squared rotation (rad) and displacement (m) left between
pose and spline, plus a very small multiple of the squared fourth differences of the screws from
control to control. That term decides what the poses leave open, such as the outermost controls.
Gauss-Newton with exact derivatives (Sommer et al., CVPR 2020, carried over to rigid motions),
damped after Levenberg and Marquardt where a step would raise the sum, as it may far from poses that
are plainly wrong; a segment touches six controls, so the normal equations are a band and the time
is linear in the poses.

Twists are (rotation, translation); a control moves by ``C exp(step)``, a pose by ``S exp(J step)``.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.versors.motor import Motor

_MAX_STEPS = 100
# Damping of steps that would raise the sum of squares, as a share of the diagonal.
_LEAST_DAMPING = 1e-3
_ROUNDING = 1e-12
# Beside plainly wrong poses steps may never end: then the sum is as small as it gets after so many
# in a row that change it by less than this share, or where none is left but with this damping.
_LEVEL_STEPS, _LEVEL = 4, 1e-9
_MOST_DAMPING = 1.0
# Largest step of any control that shapes a pose by a tenth or more, rad and m.
_CONVERGED = 1e-9
_SMOOTHNESS = 1e-6
_CHUNK = 512
# A control's say fades by 0.43, the pole of quintic splines, from knot to knot; where the roughness
# alone tells controls it does so over some knots. Of long splines so many controls are fitted at a
# time, and so many more to either side, past which nothing that float64 shows is left.
_KEPT, _OVERLAP = 1000, 100
_FOURTH_DIFFERENCE = (1.0, -4.0, 6.0, -4.0, 1.0)


def fit_controls(
    controls: Motor, segment: IntArray, weights: FloatArray, poses: Motor
) -> Motor | None:
    """Move control motors until the spline through them is closest to the poses.

    Args:
        controls: first guess, Motor ``(n,)``.
        segment: ``(N,)`` first of the six controls that shape each pose, not decreasing.
        weights: ``(5, N)`` cumulative basis at each pose.
        poses: Motor ``(N,)``.

    Returns:
        The fitted controls, or None where the steps do not settle.

    Raises:
        ModuleNotFoundError: scipy is missing.
    """
    strength = _SMOOTHNESS * len(segment) / (len(controls) - 5)
    made = np.array(controls.coefficients)
    for part, kept in _parts(len(controls)):
        rows = slice(*np.searchsorted(segment, [part.start, part.stop - 5]).tolist())
        fitted = _fitted(
            controls[part], segment[rows] - part.start, weights[:, rows], poses[rows], strength
        )
        if fitted is None:
            return None
        made[kept] = fitted.coefficients[kept.start - part.start : kept.stop - part.start]
    return Motor(made)


def _parts(count: int) -> Iterator[tuple[slice, slice]]:
    """Controls that are fitted together, and those of them that are kept, which join up."""
    edges = np.linspace(0, count, max(1, count // _KEPT) + 1).astype(np.int64).tolist()
    for first, last in pairwise(edges):
        yield slice(max(0, first - _OVERLAP), min(count, last + _OVERLAP)), slice(first, last)


def _fitted(
    controls: Motor, segment: IntArray, weights: FloatArray, poses: Motor, strength: float
) -> Motor | None:
    """`fit_controls` of one part, whose roughness counts by `strength`."""
    damping, equations = 0.0, _normal_equations(controls, segment, weights, poses, strength)
    level = 0
    for _ in range(_MAX_STEPS):
        step = _solve_band(equations, damping)
        moved = controls.retract(step)
        # The six weights of a pose sum to one, most of it on the middle two controls.
        if float(np.max(np.abs(step[2:-2]))) < _CONVERGED * (1.0 + damping):
            return moved
        reached = _normal_equations(moved, segment, weights, poses, strength)
        flat = abs(reached.cost - equations.cost) <= _LEVEL * equations.cost
        level = level + 1 if flat else 0
        if reached.cost <= equations.cost * (1.0 + _ROUNDING):
            controls, equations = moved, reached
            damping = damping / 8.0 if damping > _LEAST_DAMPING else 0.0
        else:
            damping = max(_LEAST_DAMPING, 4.0 * damping)
        if level == _LEVEL_STEPS or damping > _MOST_DAMPING:
            return controls
    return None


class _Chain(NamedTuple):
    """Control motors, screws between them, and how each screw changes with a control's step."""

    controls: Motor
    screws: FloatArray
    by_next: FloatArray
    by_last: FloatArray

    @classmethod
    def of(cls, controls: Motor) -> _Chain:
        screws = controls[:-1].local(controls[1:])
        by_next, by_last = Motor.right_jacobian_inverse(screws), Motor.left_jacobian_inverse(screws)
        return cls(controls, screws, by_next, -by_last)


def _pose_jacobians(
    chain: _Chain, segment: IntArray, weights: FloatArray
) -> tuple[Motor, FloatArray]:
    """Poses ``(N,)`` and their derivatives ``(N, 6, 36)`` by the steps of six controls each."""
    jacobian = np.zeros((len(segment), 6, 6, 6))
    pose = Motor.identity((len(segment),))
    chained = np.broadcast_to(np.eye(6), (len(segment), 6, 6))
    parts = weights[..., None] * chain.screws[segment + np.arange(5)[:, None]]
    weighed = weights[..., None, None] * Motor.right_jacobian(parts)
    factors = Motor.from_twist(parts)
    back = factors.inverse().adjoint()
    for j in range(4, -1, -1):
        effect = chained @ weighed[j]
        jacobian[:, :, j + 1] += effect @ chain.by_next[segment + j]
        jacobian[:, :, j] += effect @ chain.by_last[segment + j]
        pose = factors[j] @ pose
        chained = chained @ back[j]
    jacobian[:, :, 0] += chained
    return chain.controls[segment] @ pose, jacobian.reshape(-1, 6, 36)


def _roughness(chain: _Chain, first: int, last: int) -> tuple[FloatArray, FloatArray]:
    """Fourth differences of the screws ``(K, 6)`` and their derivatives ``(K, 6, 36)`` of some
    segments.
    """
    rough = np.zeros((last - first, 6))
    jacobian = np.zeros((last - first, 6, 6, 6))
    for j, factor in enumerate(_FOURTH_DIFFERENCE):
        own = slice(first + j, last + j)
        rough += factor * chain.screws[own]
        jacobian[:, :, j + 1] += factor * chain.by_next[own]
        jacobian[:, :, j] += factor * chain.by_last[own]
    return rough, jacobian.reshape(-1, 6, 36)


def _residuals(pose: Motor, target: Motor) -> FloatArray:
    """Rotation vector and displacement ``(N, 6)`` from pose to target, in the pose's own frame."""
    turn = (pose.rotor.inverse() @ target.rotor).as_rotation_vector()
    shift = pose.rotor.inverse().apply(target.translation_m - pose.translation_m)
    return np.concatenate([turn, shift], axis=-1)


class _Equations(NamedTuple):
    """Lower band ``(6 n, 36)``, a row a column; right-hand side ``(6 n,)``; sum of squares."""

    band: FloatArray
    right: FloatArray
    cost: float

    def add(self, first: int, blocks: FloatArray, gradient: FloatArray) -> None:
        """Add the blocks ``(K, 36, 36)`` and gradients ``(K, 36)`` of segments from `first` on."""
        for column in range(36):
            own = slice(6 * first + column, 6 * (first + len(blocks)) + column, 6)
            self.right[own] += gradient[:, column]
            self.band[own, : 36 - column] += blocks[:, column, column:]


def _normal_equations(
    controls: Motor, segment: IntArray, weights: FloatArray, poses: Motor, strength: float
) -> _Equations:
    chain, segments = _Chain.of(controls), len(controls) - 5
    made = _Equations(np.zeros((6 * len(controls), 36)), np.zeros(6 * len(controls)), 0.0)
    cost = 0.0
    for start in range(0, len(segment), _CHUNK):
        part = slice(start, start + _CHUNK)
        pose, jacobian = _pose_jacobians(chain, segment[part], weights[:, part])
        residual = _residuals(pose, poses[part])
        cost += float(np.sum(residual**2))
        made.add(int(segment[start]), *_summed(jacobian, residual, segment[part] - segment[start]))
    for start in range(0, segments, _CHUNK):
        rough, jacobian = _roughness(chain, start, min(segments, start + _CHUNK))
        turned = strength * np.swapaxes(jacobian, -1, -2)
        made.add(start, turned @ jacobian, -(turned @ rough[..., None])[..., 0])
        cost += strength * float(np.sum(rough**2))
    return made._replace(cost=cost)


def _summed(
    jacobian: FloatArray, residual: FloatArray, segment: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Blocks ``(K, 36, 36)`` and gradients ``(K, 36)`` of segments 0 to K - 1.

    The rows of a segment's poses are one tall matrix; segments with equally many are done at once.
    """
    blocks, gradient = np.zeros((segment[-1] + 1, 36, 36)), np.zeros((segment[-1] + 1, 36))
    firsts = np.flatnonzero(np.diff(segment, prepend=-1))
    counts = np.diff(firsts, append=len(segment))
    for count in np.unique(counts).tolist():
        alike = firsts[counts == count]
        rows = (alike[:, None] + np.arange(count)).ravel()
        tall = jacobian[rows].reshape(-1, 6 * count, 36)
        turned = np.swapaxes(tall, -1, -2)
        blocks[segment[alike]] = turned @ tall
        gradient[segment[alike]] = (turned @ residual[rows].reshape(-1, 6 * count, 1))[..., 0]
    return blocks, gradient


def _solve_band(equations: _Equations, damping: float) -> FloatArray:
    """Steps ``(n, 6)`` of all controls."""
    try:
        from scipy.linalg import solveh_banded
    except ModuleNotFoundError as missing:
        raise ModuleNotFoundError(
            'fitting a spline needs scipy: pip install "motorcade[pipeline]"'
        ) from missing
    band = equations.band.copy()
    # The smoothness term leaves out steps that are polynomials over the whole spline.
    diagonal = band[:, 0]
    diagonal += 1e-14 * np.max(diagonal) + damping * diagonal
    made = solveh_banded(band.T, equations.right, overwrite_ab=True, lower=True)
    return np.asarray(made).reshape(-1, 6)
