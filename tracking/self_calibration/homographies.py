"""A first focal length from images of planes: the one whose poses show the corners best.

Each plane's homography says how it lies for any focal length that is tried; a wrong one leaves
directions that are not perpendicular or not of one length (Zhang 2000, section 3.1), so corners are
reprojected elsewhere. Planes seen head on say nothing: there usual cameras decide.
"""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.self_calibration.lens import FOCAL_SPREAD, USUAL_FOCAL
from motorcade.tracking.self_calibration.result import SelfCalibrationError

LEAST_FOCAL, MOST_FOCAL = 0.2, 5.0
"""In long sides of the image; a lens of 120 degrees across has 0.29, one of 12 degrees 4.8."""
_TRIED = 41
_INDEPENDENT = 8.0  # planes; their neighbours err alike
_FAR = 5.0  # times the noise of planes: beyond it an error is as bad as any


def focal_from_planes(
    planes: Iterable[tuple[FloatArray, FloatArray]], size: tuple[int, int]
) -> float:
    """Focal length in pixels that images of planes agree on, the centre being in the middle.

    Right to some per cent where planes are seen at a slant; a camera's usual one where none is.

    Args:
        planes: points ``(n, 2 or 3)`` of a plane and their pixels ``(n, 2)``; n at least 4.
        size: width and height of the images.

    Raises:
        SelfCalibrationError: pixels that are no image of a plane.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.self_calibration.homographies import focal_from_planes
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    >>> slanted = Motor.from_euler_translation([2.5, 0.3, 0.0], [0.0, 0.0, 4.0]).apply(square)
    >>> 490.0 < focal_from_planes([(square, camera.project(slanted))], (640, 480)) < 510.0
    True
    """
    long = float(max(size))
    middle = 0.5 * (np.array(size) - 1.0)
    focal = np.geomspace(LEAST_FOCAL, MOST_FOCAL, _TRIED)
    errors = []
    for points, px in planes:
        flat = np.ascontiguousarray(points[:, :2] - points[:, :2].mean(axis=0))
        seen = np.ascontiguousarray((px - middle) / long)
        homography, _ = cv2.findHomography(flat, seen)
        if homography is not None:
            errors.append(_reprojected(flat, seen, homography, focal))
    if not errors:
        raise SelfCalibrationError("expected a board or tag, got corners that no flat one shows")
    noise = max(float(np.median(np.min(errors, axis=1))), 0.05 / long)
    each = np.minimum(np.array(errors) / noise, _FAR) ** 2
    usual = (np.log(focal / USUAL_FOCAL) / FOCAL_SPREAD) ** 2
    cost = _INDEPENDENT * each.mean(axis=0) + usual
    best = int(np.clip(np.argmin(cost), 1, _TRIED - 2))
    before, at, after = cost[best - 1 : best + 2]
    aside = 0.5 * (before - after) / max(before - 2.0 * at + after, 1e-12)
    step = np.log(focal[1] / focal[0])
    return float(long * focal[best] * np.exp(step * np.clip(aside, -1.0, 1.0)))


def _reprojected(
    flat: FloatArray, seen: FloatArray, homography: FloatArray, focal: FloatArray
) -> FloatArray:
    """Root mean square error ``(F,)`` of a plane's corners, long sides, for each focal length."""
    columns = homography[None] / np.stack([focal, focal, np.ones_like(focal)], axis=-1)[..., None]
    columns = columns * np.sign(homography[2, 2])
    left, scale, right = np.linalg.svd(columns[..., :2], full_matrices=False)
    place = columns[..., 2] / scale.mean(axis=-1)[:, None]
    points = np.einsum("nk,fjk->fnj", flat, left @ right) + place[:, None]
    px = focal[:, None, None] * points[..., :2] / np.maximum(points[..., 2:], 1e-9)
    return np.asarray(np.sqrt(((px - seen) ** 2).sum(axis=-1).mean(axis=-1)), np.float64)
