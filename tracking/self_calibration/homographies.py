"""A first focal length from pictures of planes: what each homography says of it alone.

Source: Zhang 2000, section 3.1, with the centre in the middle and square pixels: the images of two
perpendicular directions of equal length give two equations, linear in 1/f².
"""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.self_calibration.result import SelfCalibrationError

LEAST_FOCAL, MOST_FOCAL = 0.2, 5.0
"""In long sides of the picture; a lens of 120 degrees across has 0.29, one of 12 degrees 4.8."""


def focal_from_planes(
    planes: Iterable[tuple[FloatArray, FloatArray]], size: tuple[int, int]
) -> float:
    """Focal length in pixels that pictures of planes agree on.

    Each plane's two equations are weighed by how much they say; the weighted median over all planes
    is not moved by wrong ones. Right to some per cent where planes are seen at a slant.

    Args:
        planes: points ``(n, 2 or 3)`` of a plane and their pixels ``(n, 2)``; n at least 4.
        size: width and height of the pictures.

    Raises:
        SelfCalibrationError: planes that are all seen head on.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.self_calibration.homographies import focal_from_planes
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    >>> slanted = Motor.from_euler_translation([2.5, 0.3, 0.0], [0.0, 0.0, 4.0]).apply(square)
    >>> round(focal_from_planes([(square, camera.project(slanted))], (640, 480)), 3)
    500.0
    """
    long = float(max(size))
    middle = 0.5 * (np.array(size) - 1.0)
    found, weights = [], []
    for points, px in planes:
        flat = np.ascontiguousarray(points[:, :2] - points[:, :2].mean(axis=0))
        homography, _ = cv2.findHomography(flat, np.ascontiguousarray((px - middle) / long))
        if homography is None:
            continue
        one, other = homography[:, 0], homography[:, 1]
        left = np.array([one[:2] @ other[:2], one[:2] @ one[:2] - other[:2] @ other[:2]])
        right = -np.array([one[2] * other[2], one[2] ** 2 - other[2] ** 2])
        scale = float(one[:2] @ one[:2] + other[:2] @ other[:2])
        left, right = left / scale, right / scale
        # With u = (f / long)^2: left = right * u, least squares; weighed by what it says of u.
        weight = float(right @ right)
        if weight > 0.0:
            found.append(float(left @ right) / weight)
            weights.append(weight)
    squared = _weighted_median(np.array(found), np.sqrt(weights)) if found else 0.0
    if not squared > 0.0:
        raise SelfCalibrationError(
            "expected a board or tag seen at a slant in some frames, got it head on in all; the "
            "focal length does not follow: film it from several sides"
        )
    return float(np.clip(np.sqrt(squared), LEAST_FOCAL, MOST_FOCAL)) * long


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])
