"""Lens distortion on the image plane: from points to distorted coordinates and back.

Everything here is in the units of the plane at z = 1 (pixels come in `camera`), batch in the
leading dimensions. Radtan coefficients are k1 k2 p1 p2 k3 k4 k5 k6, padded with zeros (Brown 1966,
OpenCV's rational form); equidistant ones k1 k2 k3 k4 (Kannala & Brandt 2006).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import Polynomial

from motorcade.ga.arrays import FloatArray

_ITERATIONS = 30
_CONVERGED = 1e-12
_REAL = 1e-9  # the imaginary part of a root that is real, by rounding


def distort(model: str, coefficients: FloatArray, points: FloatArray) -> FloatArray:
    """Project points ``(*, 3)`` of the camera frame to the distorted plane ``(*, 2)``."""
    if model == "equidistant":
        return _equidistant(coefficients, points)
    ideal = _perspective(points)
    return ideal if model == "pinhole" else _radtan(coefficients, ideal)


def by_coefficients(model: str, points: FloatArray, which: Sequence[int]) -> FloatArray:
    """Derivative ``(n, 2, c)`` of `distort` by coefficients of these numbers.

    Models are linear in k1 k2 p1 p2 k3 of radtan and in all of equidistant: differences are exact.
    """
    length = 8 if model == "radtan" else 4
    plain = distort(model, np.zeros(length), points)
    columns = [distort(model, unit, points) - plain for unit in np.eye(length)[list(which)]]
    return np.moveaxis(np.array(columns).reshape(-1, *plain.shape), 0, -1)


def distort_jacobian(
    model: str, coefficients: FloatArray, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """As `distort`, with the derivative ``(*, 2, 3)`` by the points."""
    if model == "equidistant":
        return _equidistant_jacobian(coefficients, points)
    ideal = _perspective(points)
    by_point = np.empty((*ideal.shape, 3))
    inverse_depth = 1.0 / np.where(points[..., 2] > 0.0, points[..., 2], np.nan)
    by_point[..., 0, 0] = by_point[..., 1, 1] = inverse_depth
    by_point[..., 0, 1] = by_point[..., 1, 0] = 0.0 * inverse_depth
    by_point[..., :, 2] = -ideal * inverse_depth[..., None]
    if model == "pinhole":
        return ideal, by_point
    return _radtan(coefficients, ideal), _radtan_jacobian(coefficients, ideal) @ by_point


def undistort(model: str, coefficients: FloatArray, plane: FloatArray) -> FloatArray:
    """Find the ideal coordinates ``(*, 2)`` of distorted ones; NaN where there are none."""
    if model == "pinhole":
        return plane
    if model == "equidistant":
        return _undistort_equidistant(coefficients, plane)
    return _undistort_radtan(coefficients, plane)


def bearings(model: str, coefficients: FloatArray, plane: FloatArray) -> FloatArray:
    """Unit vectors ``(*, 3)`` along the rays of distorted coordinates; NaN where there are none."""
    if model == "equidistant":
        angle, radius = _equidistant_angle(coefficients, plane, _fold_rad(coefficients))
        share = np.where(radius > 0.0, np.sin(angle) / np.where(radius > 0.0, radius, 1.0), 1.0)
        return np.concatenate([plane * share[..., None], np.cos(angle)[..., None]], axis=-1)
    ideal = undistort(model, coefficients, plane)
    rays = np.concatenate([ideal, np.ones_like(ideal[..., :1])], axis=-1)
    unit: FloatArray = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    return unit


def reach(model: str, coefficients: FloatArray) -> float:
    """Distorted radius up to which radii grow with the angle from the axis, by the radial terms.

    Beyond it the model folds back, so pixels there have no ray; infinite where it never does.
    """
    if model == "pinhole":
        return np.inf
    if model == "equidistant":
        return float(_distorted_angle(coefficients, np.array(_fold_rad(coefficients))))
    k1, k2, _, _, *rest = coefficients
    over, under = Polynomial([1.0, k1, k2, rest[0]]), Polynomial([1.0, *rest[1:]])
    twice = Polynomial([0.0, 2.0])  # by the squared radius, in which both are polynomials
    slope = over * under + twice * (over.deriv() * under - over * under.deriv())
    square = min(_first_root(slope), _first_root(under))
    if not np.isfinite(square):
        return np.inf
    return float(np.sqrt(square) * over(square) / max(under(square), _REAL))


def _first_root(polynomial: Polynomial) -> float:
    """The smallest root above zero; infinite without one."""
    roots = polynomial.trim().roots()
    real = roots.real[(np.abs(roots.imag) < _REAL) & (roots.real > 0.0)]
    return float(real.min(initial=np.inf))


def _perspective(points: FloatArray) -> FloatArray:
    depth = np.where(points[..., 2:] > 0.0, points[..., 2:], np.nan)
    ideal: FloatArray = points[..., :2] / depth
    return ideal


def _radtan(coefficients: FloatArray, ideal: FloatArray) -> FloatArray:
    k1, k2, p1, p2, k3, k4, k5, k6 = coefficients
    x, y = ideal[..., 0], ideal[..., 1]
    r2 = x * x + y * y
    radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    return np.stack(
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ],
        axis=-1,
    )


def _radtan_jacobian(coefficients: FloatArray, ideal: FloatArray) -> FloatArray:
    """Derivative ``(*, 2, 2)`` of `_radtan`, symmetric."""
    k1, k2, p1, p2, k3, k4, k5, k6 = coefficients
    x, y = ideal[..., 0], ideal[..., 1]
    r2 = x * x + y * y
    numerator = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    denominator = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))
    radial = numerator / denominator
    slope = (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3)) - radial * (k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6))
    slope = 2.0 * slope / denominator
    jacobian = np.empty((*ideal.shape, 2))
    jacobian[..., 0, 0] = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x
    jacobian[..., 1, 1] = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x
    mixed = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y
    jacobian[..., 0, 1] = jacobian[..., 1, 0] = mixed
    return jacobian


def _undistort_radtan(coefficients: FloatArray, plane: FloatArray) -> FloatArray:
    """Newton from the distorted point.

    Along a barrel's (concave) or a cushion's (convex) radius the steps approach from one side, so
    they stay on the branch that holds the axis; a root beyond a fold has a Jacobian that is not
    positive definite and is thrown out.
    """
    ideal = plane.copy()
    with np.errstate(all="ignore"):
        for _ in range(_ITERATIONS):
            jacobian = _radtan_jacobian(coefficients, ideal)
            step = _solve_2x2(jacobian, _radtan(coefficients, ideal) - plane)
            ideal = ideal - step
            if not np.any(np.abs(step) > _CONVERGED):
                break
        error = np.abs(_radtan(coefficients, ideal) - plane).max(axis=-1)
        jacobian = _radtan_jacobian(coefficients, ideal)
        upright = (jacobian[..., 0, 0] > 0.0) & (_determinant(jacobian) > 0.0)
        valid = upright & (error < 1e-9 * (1.0 + np.abs(plane).max(axis=-1)))
    ideal[~valid] = np.nan
    return ideal


def _determinant(matrix: FloatArray) -> FloatArray:
    a, b, c, d = (matrix[..., i, j] for i in (0, 1) for j in (0, 1))
    determinant: FloatArray = a * d - b * c
    return determinant


def _solve_2x2(matrix: FloatArray, right: FloatArray) -> FloatArray:
    a, b, c, d = (matrix[..., i, j] for i in (0, 1) for j in (0, 1))
    u, v = right[..., 0], right[..., 1]
    return np.stack([d * u - b * v, a * v - c * u], axis=-1) / _determinant(matrix)[..., None]


def _equidistant(coefficients: FloatArray, points: FloatArray) -> FloatArray:
    radius = np.hypot(points[..., 0], points[..., 1])
    angle = np.arctan2(radius, points[..., 2])
    off_axis = radius > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        on_axis = np.where(points[..., 2] > 0.0, 1.0 / points[..., 2], np.nan)
        scale = np.where(off_axis, _distorted_angle(coefficients, angle) / radius, on_axis)
    plane: FloatArray = points[..., :2] * scale[..., None]
    return plane


def _equidistant_jacobian(
    coefficients: FloatArray, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    xy, depth = points[..., :2], points[..., 2]
    radius = np.hypot(points[..., 0], points[..., 1])
    angle = np.arctan2(radius, depth)
    distance2 = radius * radius + depth * depth
    safe = np.where(radius > 0.0, radius, 1.0)
    off_axis = radius > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        on_axis = np.where(depth > 0.0, 1.0 / depth, np.nan)
        scale = np.where(off_axis, _distorted_angle(coefficients, angle) / safe, on_axis)
        slope = _angle_slope(coefficients, angle)
        # d(plane) = scale d(xy) + xy d(scale); the angle turns by (z dr - r dz) / (r2 + z2)
        by_radius = np.where(off_axis, (slope * depth / distance2 - scale) / (safe * safe), 0.0)
        by_depth = np.where(off_axis, -slope / distance2, -scale / depth)
    jacobian = np.empty((*xy.shape, 3))
    jacobian[..., :, :2] = by_radius[..., None, None] * xy[..., :, None] * xy[..., None, :]
    jacobian[..., 0, 0] += scale
    jacobian[..., 1, 1] += scale
    jacobian[..., :, 2] = xy * by_depth[..., None]
    return xy * scale[..., None], jacobian


def _distorted_angle(coefficients: FloatArray, angle: FloatArray) -> FloatArray:
    k1, k2, k3, k4 = coefficients
    a2 = angle * angle
    distorted: FloatArray = angle * (1.0 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))))
    return distorted


def _angle_slope(coefficients: FloatArray, angle: FloatArray) -> FloatArray:
    k1, k2, k3, k4 = coefficients
    a2 = angle * angle
    slope: FloatArray = 1.0 + a2 * (3.0 * k1 + a2 * (5.0 * k2 + a2 * (7.0 * k3 + a2 * 9.0 * k4)))
    return slope


def _undistort_equidistant(coefficients: FloatArray, plane: FloatArray) -> FloatArray:
    angle, radius = _equidistant_angle(coefficients, plane, 0.5 * np.pi)
    with np.errstate(all="ignore"):
        scale = np.where(radius > 0.0, np.tan(angle) / np.where(radius > 0.0, radius, 1.0), 1.0)
    return plane * scale[..., None]


def _fold_rad(coefficients: FloatArray) -> float:
    """Angle from the axis beyond which the image would fold back, half a turn at most."""
    k1, k2, k3, k4 = coefficients
    square = _first_root(Polynomial([1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3, 9.0 * k4]))
    return float(np.sqrt(min(square, np.pi**2)))


def _equidistant_angle(
    coefficients: FloatArray, plane: FloatArray, most_rad: float
) -> tuple[FloatArray, FloatArray]:
    """Angles ``(*,)`` from the axis, NaN where none below `most_rad` is found, and the radii."""
    radius = np.hypot(plane[..., 0], plane[..., 1])
    angle = np.minimum(radius, most_rad)
    with np.errstate(all="ignore"):
        for _ in range(_ITERATIONS):
            excess = _distorted_angle(coefficients, angle) - radius
            step = excess / _angle_slope(coefficients, angle)
            angle = np.clip(angle - step, 0.0, most_rad)
            if not np.any(np.abs(step) > _CONVERGED):
                break
        error = np.abs(_distorted_angle(coefficients, angle) - radius)
        valid = (error < 1e-9) & (angle < most_rad) & (_angle_slope(coefficients, angle) > 0.0)
    return np.where(valid, angle, np.nan), radius
