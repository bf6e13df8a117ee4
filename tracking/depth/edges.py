"""Whether depth lies on colour's pixels: where a surface ends, its picture changes.

Needs no poses and no features: the pixels of nearer surfaces at jumps of depth are laid over the
picture's gradient, shifted this way and that. They fit best where depth and colour agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.slam.features import DepthImage
from motorcade.tracking.slam.geometry import BoolArray

_REACH_PX = 24
_JUMP = 1.12
"""A surface ends where what lies beside it is farther by an eighth: no slope looks like that."""
_BESIDE_PX = 6
"""Gaps beside an edge, which the depth camera's shadow leaves, are bridged up to here."""
_BLUR_PX = 1.5
_BRIGHTEST = 0.95
_FEWEST = 4000
_STANDS_OUT = 5.0
"""Times the scatter of far shifts by which the best one must lead their mean."""


@dataclass(frozen=True)
class EdgeOffset:
    """How far depth lies off colour.

    Fields:
        right_px, down_px: by which depth has to be moved to lie on colour; NaN where the pictures
            do not tell.
        contrast: how far the best shift stands out among all, in standard deviations of theirs.
        pixels: at edges of depth that were compared.
    """

    right_px: float
    down_px: float
    contrast: float
    pixels: int

    @property
    def px(self) -> float:
        """Length of the offset; NaN where it is unknown."""
        return float(np.hypot(self.right_px, self.down_px))


def edge_offset(grays: Sequence[GrayImage], depths_m: Sequence[DepthImage]) -> EdgeOffset:
    """Find the shift of depth, up to 24 pixels, that puts its edges on those of the pictures.

    Args:
        grays: pictures ``(height, width)`` uint8.
        depths_m: their depth, registered, of the same size.

    Boxes before a wall, whose depth is 6 pixels too far to the left:

    >>> import numpy as np
    >>> from motorcade.tracking.depth import edge_offset
    >>> gray, depth = np.full((240, 320), 90, np.uint8), np.full((240, 320), 3.0, np.float32)
    >>> for y, x in np.mgrid[30:200:40, 40:280:60].reshape(2, -1).T:
    ...     gray[y : y + 20, x : x + 30] = 160
    ...     depth[y : y + 20, x - 6 : x + 24] = 2.0
    >>> found = edge_offset([gray] * 10, [depth] * 10)
    >>> round(found.right_px), round(found.down_px)
    (6, 0)
    """
    reach = _REACH_PX
    score, count = np.zeros((2 * reach + 1, 2 * reach + 1)), 0
    for gray, depth_m in zip(grays, depths_m, strict=True):
        slope = _slope(gray)
        edges = _edges(depth_m).astype(np.float64)
        inner = edges[reach:-reach, reach:-reach]
        found = int(inner.sum())
        if not found:
            continue
        # Correlation: score[a, b] sums the slope at every edge pixel moved by (a, b) - reach.
        score += cv2.filter2D(slope, cv2.CV_64F, inner, borderType=cv2.BORDER_CONSTANT)[
            _around(slope.shape[0], inner.shape[0], reach),
            _around(slope.shape[1], inner.shape[1], reach),
        ]
        count += found
    if count < _FEWEST:
        return EdgeOffset(np.nan, np.nan, 0.0, count)
    best = np.unravel_index(int(np.argmax(score)), score.shape)
    down, right = int(best[0]), int(best[1])
    rows, columns = np.indices(score.shape)
    far = np.hypot(rows - down, columns - right) > reach / 2
    contrast = float((score[down, right] - score[far].mean()) / max(score[far].std(), 1e-12))
    at_rim = not (0 < down < 2 * reach and 0 < right < 2 * reach)
    if at_rim or contrast < _STANDS_OUT:
        return EdgeOffset(np.nan, np.nan, contrast, count)
    right_px = right - reach + _vertex(score[down, right - 1 : right + 2])
    down_px = down - reach + _vertex(score[down - 1 : down + 2, right])
    return EdgeOffset(float(right_px), float(down_px), contrast, count)


def _around(size: int, kernel: int, reach: int) -> slice:
    """The places of a correlation at which the kernel is at most `reach` from the middle."""
    middle = reach + kernel // 2
    return slice(max(middle - reach, 0), min(middle + reach + 1, size))


def _vertex(values: FloatArray) -> float:
    """Where the parabola through three values has its peak, from the middle one."""
    bend = values[0] - 2.0 * values[1] + values[2]
    return float(0.5 * (values[0] - values[2]) / bend) if bend < 0.0 else 0.0


def _slope(gray: GrayImage) -> FloatArray:
    """Length of the picture's gradient; the steepest twentieth counts alike."""
    smooth = cv2.GaussianBlur(gray.astype(np.float64), (0, 0), _BLUR_PX)
    slope = np.hypot(cv2.Sobel(smooth, cv2.CV_64F, 1, 0), cv2.Sobel(smooth, cv2.CV_64F, 0, 1))
    top = max(float(np.quantile(slope, _BRIGHTEST)), 1e-9)
    found: FloatArray = np.minimum(slope / top, 1.0)
    return found


def _edges(depth_m: DepthImage) -> BoolArray:
    """The last pixels of a nearer surface, where a farther one follows, at once or after a gap."""
    known = np.where(np.isfinite(depth_m) & (depth_m > 0.0), depth_m, np.nan)
    edges = np.zeros(known.shape, dtype=np.bool_)
    for axis in (0, 1):
        for sign in (-1, 1):
            ends = ~(np.roll(known, sign, axis) < _JUMP * known)
            for far in range(1, _BESIDE_PX + 1):
                edges |= ends & (np.roll(known, sign * far, axis) > _JUMP * known)
    return edges
