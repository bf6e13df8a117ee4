"""Whether two pictures show the same scene, however the camera, light or exposure changed between.

Corners of one are looked for in the other, from the shift that correlation of the whole pictures
suggests, and count where a homography or the neighbourhood agrees; or the pictures, laid on each
other by that shift, correlate by themselves (blur of a fast pan leaves no corners). Grey levels are
made comparable first: a flash or a fade changes level and contrast, not structure.

Sources: Lucas & Kanade 1981; Kuglin & Hines 1975 (phase correlation).
"""

from __future__ import annotations

from itertools import product

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.pictures import track_corners
from motorcade.tracking.shots.camera_motion import REST_PX, Rest

MOST_CORNERS = 160
FEWEST_CORNERS = 12
_FOUND_SHARE, _AGREED_SHARE = 0.3, 0.6
_AGREES_PX = 3.0
_LEAST_OVERLAP, _LEAST_CORRELATION = 0.3, 0.55
_BLUR_PX, _DETAIL_PX = 1.5, 10.0
_LEAST_CONTRAST = 1.0
_CELLS, _HALF_PX, _REACH_PX = 14, 7, 9
_SURE, _UNLIKE, _FAINT, _BORDER = 0.8, 0.5, 2.5, 0.2
_BLOCKS, _FEWEST_BLOCKS, _TEXTURE = (16, 12), 20, 3.0
_BLOCK_ALIKE, _ALIKE_SHARE = 0.7, 0.3
"""Of blocks of two scenes one in twenty is alike by chance."""


def corners_in(preview: GrayImage) -> FloatArray:
    """Corners ``(n, 2)`` of a small picture, spread over it; fewer where it is plain."""
    corners = cv2.goodFeaturesToTrack(preview, MOST_CORNERS, 0.01, 7.0, blockSize=5)
    return np.zeros((0, 2)) if corners is None else corners.reshape(-1, 2).astype(np.float64)


def levelled(preview: GrayImage) -> GrayImage:
    """The picture with its levels stretched to a common mean and contrast."""
    mean, deviation = cv2.meanStdDev(preview)
    gain = 48.0 / max(float(deviation[0, 0]), _LEAST_CONTRAST)
    levels = gain * (np.arange(256) - float(mean[0, 0])) + 128.0
    return np.asarray(cv2.LUT(preview, np.clip(levels, 0, 255).astype(np.uint8)), np.uint8)


def shows_same_scene(before: GrayImage, after: GrayImage) -> bool:
    """Whether two small pictures ``(h, w)`` of a clip show the same scene."""
    before, after = levelled(before), levelled(after)
    details = [_details(preview) for preview in (before, after)]
    shift, correlation = _shift(*details)
    if correlation >= _LEAST_CORRELATION:
        return True
    px = corners_in(before)
    if len(px) < FEWEST_CORNERS:
        return False
    for start in (np.zeros(2), shift):
        there, tracked = track_corners(before, after, px, px + start, border_px=4.0)
        if np.count_nonzero(tracked) < max(FEWEST_CORNERS, _FOUND_SHARE * len(px)):
            continue
        _, agreed = cv2.findHomography(px[tracked], there[tracked], cv2.RANSAC, _AGREES_PX)
        if agreed is not None and np.count_nonzero(agreed) >= max(
            FEWEST_CORNERS, _AGREED_SHARE * np.count_nonzero(tracked)
        ):
            return True
    return False


def _details(preview: GrayImage) -> FloatArray:
    """Structure of middle size: what neither noise nor blur nor light changes much."""
    fine = cv2.GaussianBlur(preview.astype(np.float32), (0, 0), _BLUR_PX)
    return np.asarray(fine - cv2.GaussianBlur(fine, (0, 0), _DETAIL_PX), np.float32)


def _shift(before: FloatArray, after: FloatArray) -> tuple[FloatArray, float]:
    """By how much ``(2,)`` one picture lies beside the other, and how alike they are then."""
    height, width = before.shape
    window = cv2.createHanningWindow((width, height), cv2.CV_32F)
    (dx, dy), _ = cv2.phaseCorrelate(before, after, window)
    best = np.zeros(2), -1.0
    for x, y in ((0, 0), (round(dx), round(dy))):
        if (width - abs(x)) * (height - abs(y)) < _LEAST_OVERLAP * width * height:
            continue
        own = before[max(0, -y) : height - max(0, y), max(0, -x) : width - max(0, x)]
        other = after[max(0, y) : height + min(0, y), max(0, x) : width + min(0, x)]
        alike = _likeness(own, other)
        if alike > best[1]:
            best = np.array([x, y], np.float64), alike
    return best


def _likeness(own: FloatArray, other: FloatArray) -> float:
    """Share of the textured blocks that are alike in both, or the whole's correlation if more."""
    products = [
        cv2.resize(product, _BLOCKS, interpolation=cv2.INTER_AREA)
        for product in (own * other, own**2, other**2)
    ]
    whole = float(products[0].mean() / np.sqrt(products[1].mean() * products[2].mean() + 1e-6))
    textured = (products[1] > _TEXTURE**2) & (products[2] > _TEXTURE**2)
    if np.count_nonzero(textured) < _FEWEST_BLOCKS:
        return whole
    blocks = products[0][textured] / np.sqrt(products[1][textured] * products[2][textured])
    return max(whole, float(np.mean(blocks > _BLOCK_ALIKE)) / _ALIKE_SHARE * _LEAST_CORRELATION)


def corners_all_over(gray: GrayImage, cells: int = 16, border_px: int = _HALF_PX) -> FloatArray:
    """The most corner-like place ``(n, 2)`` in each cell of a grid that is not quite plain."""
    details = _details(gray)
    cornered = cv2.cornerMinEigenVal(details, 7)
    grid = (np.array_split(np.arange(border_px, n - border_px), cells) for n in gray.shape)
    corners = []
    for rows, columns in product(*grid):
        if not len(rows) or not len(columns):
            continue
        cell = cornered[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        _, _, _, (x, y) = cv2.minMaxLoc(cell)
        x, y = x + int(columns[0]), y + int(rows[0])
        patch = details[y - _HALF_PX : y + _HALF_PX + 1, x - _HALF_PX : x + _HALF_PX + 1]
        if patch.std() >= _FAINT:
            corners.append((x, y))
    return np.array(corners, np.float64).reshape(-1, 2)


def rest_of(before: GrayImage, after: GrayImage) -> Rest:
    """How much of a scene lies still between two pictures, faint structure included.

    The most corner-like place in each cell of a grid is looked for where it was, and around.
    """
    height, width = before.shape
    details, later = _details(before), _details(after)
    reach = _HALF_PX + _REACH_PX
    near, same = (slice(_REACH_PX - px, _REACH_PX + px + 1) for px in (int(REST_PX), 1))
    still, elsewhere, places = 0, 0, set()
    corners = corners_all_over(before, _CELLS, reach).astype(int)
    for x, y in corners.tolist():
        patch = details[y - _HALF_PX : y + _HALF_PX + 1, x - _HALF_PX : x + _HALF_PX + 1]
        around = later[y - reach : y + reach + 1, x - reach : x + reach + 1]
        alike = cv2.matchTemplate(around, patch, cv2.TM_CCOEFF_NORMED)
        best, here = float(alike.max()), float(alike[near, near].max())
        if here > _SURE and here >= best - 0.05:
            still += float(alike[same, same].max()) >= best - 0.02
            places.add((x, y))
        elif best > _SURE and here < _UNLIKE:
            elsewhere += 1
    quarters = {(2 * x > width, 2 * y > height) for x, y in places}
    beside = np.minimum(corners, [width - 1, height - 1] - corners) < _BORDER * np.array(
        [width, height]
    )
    at_border = {(x, y) for x, y in corners[beside.any(axis=-1)].tolist()}
    border = len(at_border & places) / max(len(at_border), 1)
    return Rest(still, len(places), elsewhere, len(quarters), border)
