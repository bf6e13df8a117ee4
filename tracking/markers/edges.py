"""Corners of square markers as the intersections of their four sides.

The corner of a marker is rounded by blur, which draws any corner finder inward; its sides are
straight. So points are searched across each side, a line is fitted to each, and neighbours are
crossed. Against exact renderings this is several times nearer than ``cornerSubPix``. Where a
camera is given, the points are undistorted by its lens model before the lines are fitted.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import grey_levels

_ALONG = np.linspace(0.12, 0.88, 20)
_ACROSS = np.linspace(-1.0, 1.0, 15)
_REACH_PX = (1.0, 3.5)
_CLEAR, _OPEN = 0.6, 0.25
"""Share of what is clear beside a side that is searched at most; and of the steepest step, from
which on one at the end of the search is blur that reaches farther: more is searched then."""
_MIDDLES = 0.5 * (_ACROSS[1:] + _ACROSS[:-1])
_NEXT, _BEFORE = [1, 2, 3, 0], [3, 0, 1, 2]
_ROUNDS, _SETTLED_PX = 12, 0.02
"""Blur wider than what is searched across a side leaves each round a share of the way to go."""
_FITS = 3
_LEAST_STEP = 8.0  # grey levels across a side
_OUTLIER_PX = 0.3
_WORST_SPREAD_PX = 0.6
_ALIKE, _OPENLY, _ROUNDING_PX, _TORN = 2.5, 17, 0.03, 600.0
"""Sides of one print scatter alike: 2.5 times as far as another side is once in ten thousand (F of
18 and 18). Of their twenty points three may lie anywhere, which the fit makes up for; what rounding
leaves, and how finely printers draw a side, tells nothing."""


def refine_quads(
    image: GrayImage,
    quads: FloatArray,
    clear_share: float,
    camera: Camera | None = None,
    white_inside: bool = False,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Refine the corners of markers to sub-pixel accuracy.

    Args:
        image: grey image.
        quads: ``(m, 4, 2)`` corners in pixels, clockwise as seen, right to a pixel or two.
        clear_share: the part of a marker's side up to which, inward and outward of it, nothing
            else is printed: the width of the black border or of the white gap.
        camera: whose lens distorts the sides; without one they are taken as straight.
        white_inside: whether the markers are white squares on black.

    Returns:
        the corners ``(m, 4, 2)``, and a mask ``(m,)`` of markers all of whose sides were found:
        of the right colours, straight to 0.6 px and, where the lens is known, as straight as the
        others, which one that is half covered is not.
    """
    places = quads.copy()
    sides = quads[:, _NEXT] - quads
    side_px = np.sqrt((sides * sides).sum(axis=-1))
    most = _CLEAR * clear_share * side_px.min(axis=1)
    least_px = np.maximum(_ROUNDING_PX, side_px.max(axis=1) / _TORN)
    reach = np.clip(most, *_REACH_PX)
    good, alike = _inside(image, quads, reach), np.ones(len(quads), bool)
    rows, sign = np.arange(len(quads)), -1.0 if white_inside else 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(_ROUNDS):
            points, weights, seen, blurred = _side_points(image, places[rows], reach[rows], sign)
            lines, spread, scatter = _fit_lines(_undistorted(points, camera), weights)
            crossed = _distorted(_crossings(lines), camera)
            shift_px = _farthest(crossed, quads[rows])
            good[rows] &= (seen & (spread < _WORST_SPREAD_PX)).all(axis=1)
            _, second, _, most_px = np.sort(scatter, axis=1).T
            alike[rows] = most_px <= _ALIKE * np.maximum(second, least_px[rows])
            good[rows] &= shift_px < np.maximum(3.0, 2.0 * reach[rows])
            blurred &= reach[rows] < most[rows]
            reach[rows] = np.where(blurred, np.minimum(2.0 * reach[rows], most[rows]), reach[rows])
            moving = good[rows] & (blurred | (_farthest(crossed, places[rows]) > _SETTLED_PX))
            places[rows] = np.where(good[rows, None, None], crossed, quads[rows])
            rows = rows[moving]
            if not len(rows):
                break
    return places, good if camera is None else good & alike


def _farthest(quads: FloatArray, others: FloatArray) -> FloatArray:
    """How far ``(m,)`` the corner of a quad lies from another's that lies farthest."""
    change = quads - others
    return cast("FloatArray", np.sqrt((change * change).sum(axis=-1).max(axis=1)))


def _side_points(
    image: GrayImage, quads: FloatArray, reach: FloatArray, outward_sign: float
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_], NDArray[np.bool_]]:
    """Where each side's brightness steps from black to white, outward (sign 1) or inward (-1).

    Returns:
        points ``(m, 4, k, 2)``, weights ``(m, 4, k)``, whether a side ``(m, 4)`` is there, and
        whether steps ``(m,)`` go on beyond what is searched.
    """
    sides = quads[:, _NEXT] - quads
    outward = np.stack([sides[..., 1], -sides[..., 0]], axis=-1)
    outward /= np.sqrt((sides * sides).sum(axis=-1, keepdims=True))
    base = quads[:, :, None] + sides[:, :, None] * _ALONG[:, None]
    offsets = reach[:, None, None, None] * _ACROSS
    places = base[..., None, :] + outward[:, :, None, None] * offsets[..., None]
    levels = grey_levels(image, places.reshape(*places.shape[:2], -1, 2)).reshape(places.shape[:-1])
    steps = np.maximum(outward_sign * (levels[..., 1:] - levels[..., :-1]), 0.0)
    sharpness = steps * steps
    total = sharpness.sum(axis=-1)
    middle = reach[:, None, None] * ((sharpness @ _MIDDLES) / np.maximum(total, 1e-9))
    points = base + outward[:, :, None] * middle[..., None]
    seen = (steps.sum(axis=-1) >= _LEAST_STEP).mean(axis=-1) >= 0.6
    profile = steps.mean(axis=(1, 2))
    blurred = profile[:, [0, -1]].max(axis=-1) > _OPEN * profile.max(axis=-1)
    return points, np.sqrt(total), seen, blurred


def _fit_lines(
    points: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weighted total least squares, three times, outliers played down after each.

    Returns:
        homogeneous unit lines ``(m, 4, 3)``, and RMS distances ``(m, 4)`` from them: weighted, and
        of the points that lie nearest.
    """
    x, y = points[..., 0], points[..., 1]
    known = np.isfinite(x + y)
    if not known.all():
        weights, x, y = (np.where(known, one, 0.0) for one in (weights, x, y))
    for _ in range(_FITS):
        share = weights / np.maximum(weights.sum(axis=-1, keepdims=True), 1e-12)
        centre_x = (share * x).sum(axis=-1, keepdims=True)
        centre_y = (share * y).sum(axis=-1, keepdims=True)
        from_x, from_y = x - centre_x, y - centre_y
        weighted_x = share * from_x
        spread_xx, spread_xy = (weighted_x * from_x).sum(-1), (weighted_x * from_y).sum(-1)
        spread_yy = (share * from_y * from_y).sum(-1)
        angle = 0.5 * np.arctan2(2.0 * spread_xy, spread_xx - spread_yy)[..., None]
        normal_x, normal_y = -np.sin(angle), np.cos(angle)
        distance = from_x * normal_x + from_y * normal_y
        squared = distance * distance
        rms = np.sqrt((share * squared).sum(axis=-1))
        weights = weights / (1.0 + squared / _OUTLIER_PX**2)
    constant = -(normal_x * centre_x + normal_y * centre_y)
    lines = np.concatenate([normal_x, normal_y, constant], axis=-1)
    nearest = np.partition(squared, _OPENLY - 1, axis=-1)[..., :_OPENLY]
    return lines, rms, np.sqrt(nearest.mean(axis=-1))


def _crossings(lines: FloatArray) -> FloatArray:
    """Corner k ``(m, 4, 2)`` is where the side that ends in it crosses the one that starts."""
    a, b, c = np.moveaxis(lines, -1, 0)
    a_, b_, c_ = np.moveaxis(lines[:, _BEFORE], -1, 0)
    depth = a_ * b - b_ * a
    corners: FloatArray = np.stack([(b_ * c - c_ * b) / depth, (c_ * a - a_ * c) / depth], axis=-1)
    return corners


def _undistorted(points: FloatArray, camera: Camera | None) -> FloatArray:
    if camera is None or camera.model == "pinhole":
        return points
    return camera.undistort(points)


def _distorted(points: FloatArray, camera: Camera | None) -> FloatArray:
    if camera is None or camera.model == "pinhole":
        return points
    known = np.isfinite(points).all(axis=-1, keepdims=True)
    return np.where(known, camera.distort(np.where(known, points, 0.0)), np.nan)


def _inside(image: GrayImage, quads: FloatArray, reach: FloatArray) -> NDArray[np.bool_]:
    height, width = image.shape
    low = quads.min(axis=(1, 2)) - reach
    high = quads.max(axis=1) + reach[:, None]
    inside = (low >= 0.0) & (high <= (width - 1.0, height - 1.0)).all(axis=1)
    return cast("NDArray[np.bool_]", inside)
