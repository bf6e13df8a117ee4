"""Least squares of a plane to points: orthogonal regression, weighted, with its covariance.

The covariance takes the points' noise as independent and of the relative sizes given; its scale
comes from the residuals. Depth images have noise that neighbours share, so there it is too small.

Sources: Pearson 1901; its covariance: Kanatani 1996, ch. 10.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.tracking.planes.plane import Plane

# Points that spread less than this many times their noise across a line fix no plane.
LEAST_SPREAD = 3.0
_CELLS = 40


def fit_plane(
    points_m: ArrayLike,
    sigma_m: ArrayLike | None = None,
    *,
    towards_m: ArrayLike = (0.0, 0.0, 0.0),
) -> Plane:
    """Fit a plane to points that all belong to it.

    Args:
        points_m: ``(n, 3)``.
        sigma_m: noise of the points, one number or ``(n,)``; None weighs all alike.
        towards_m: a point on the side that the normal points to.

    Raises:
        ValueError: fewer than three points, NaN, noise that is not above zero, points on one line
            (exactly, or within their noise).
    """
    points = checked_points(points_m, "fit_plane(points_m)", 3)
    eye = checked_floats(towards_m, "fit_plane(towards_m)", (3,))
    weight = np.ones(len(points))
    if sigma_m is not None:
        weight = checked_sigma(sigma_m, len(points), "fit_plane(sigma_m)") ** -2.0
    centre, spread, axes = spread_axes(points, weight)
    noise = 0.0 if sigma_m is None else LEAST_SPREAD**2 * len(points)
    if spread[1] <= max(1e-12 * spread[2], noise):
        raise ValueError("fit_plane(points_m): expected points that do not lie on one line")
    normal, along = axes[:, 0], axes[:, 2]
    if normal @ (eye - centre) < 0.0:
        normal = -normal
    along = along * np.sign(along[np.argmax(np.abs(along))])
    turn = np.stack([along, np.cross(normal, along), normal], axis=-1)
    distances = (points - centre) @ normal
    variance = float(weight @ distances**2) / max(len(points) - 3, 1)
    # Tilt about x moves points by their y, tilt about y by their x.
    known = np.array([spread[1], spread[2], weight.sum()])
    return Plane(
        Motor.from_rotor_translation(Rotor.from_matrix(turn), centre),
        _outline((points - centre) @ turn[:, :2]),
        len(points),
        float(np.sqrt(np.mean(distances**2))),
        np.diag(variance / known),
    )


def spread_axes(
    points: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weighted mean ``(3,)``, sums of squares along the principal axes ``(3,)`` rising, the axes.

    The axes ``(3, 3)`` are the columns.
    """
    centre = weight @ points / weight.sum()
    offset = points - centre
    spread, axes = np.linalg.eigh((offset.T * weight) @ offset)
    return np.asarray(centre), np.maximum(spread, 0.0), axes


def checked_points(value: ArrayLike, name: str, fewest: int) -> FloatArray:
    """Refuse anything but `fewest` or more finite points ``(n, 3)``.

    Raises:
        ValueError: naming the argument.
    """
    points = checked_floats(value, name, (3,))
    if points.ndim != 2 or len(points) < fewest:
        raise ValueError(
            f"{name}: expected {fewest} or more points (n, 3), got shape {points.shape}"
        )
    return points


def checked_sigma(value: ArrayLike, count: int, name: str) -> FloatArray:
    """Noise a point ``(count,)``, from one number or as many.

    Raises:
        ValueError: another count, or noise that is not above zero.
    """
    sigma = checked_floats(value, name, ())
    if sigma.shape not in ((), (count,)) or np.any(sigma <= 0.0):
        raise ValueError(
            f"{name}: expected metres above 0, one or {count}, got shape {sigma.shape} "
            f"from {float(np.min(sigma, initial=np.inf))} on"
        )
    return np.broadcast_to(sigma, (count,))


def _outline(local: FloatArray) -> FloatArray:
    """Convex outline ``(k, 2)``, anticlockwise, of the largest patch that hangs together.

    Points far from the patch would otherwise stretch the outline over what is not there.
    """
    low, extent = local.min(axis=0), np.ptp(local, axis=0)
    cell = np.minimum((local - low) / extent * _CELLS, _CELLS - 1).astype(int)
    taken = np.zeros((_CELLS, _CELLS), dtype=np.uint8)
    taken[cell[:, 0], cell[:, 1]] = 1
    # One empty cell between points is no gap.
    _, patches = cv2.connectedComponents(cv2.dilate(taken, np.ones((3, 3), np.uint8)))
    patch = patches[cell[:, 0], cell[:, 1]]
    kept = local[patch == np.argmax(np.bincount(patch))]
    if len(kept) < 3 or np.linalg.matrix_rank(kept - kept.mean(axis=0), tol=1e-9) < 2:
        kept = local  # so sparse that no patch spans an area
    from scipy.spatial import ConvexHull

    return np.asarray(kept[ConvexHull(kept).vertices])  # anticlockwise, as Qhull has them in 2D
