"""Images ready for tracking, corners spread over them, and corners tracked between them.

Images are undistorted once, so all pixels here belong to a pinhole camera. Corners are ORB's
(FAST, ranked by Harris) with their descriptors; between images `track_corners` finds them again.

Source: Rublee et al. 2011 (ORB).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import track_corners
from motorcade.tracking.native._flow import Pyramid

DepthImage = NDArray[np.float32]
Descriptors = NDArray[np.uint8]

_RESPONSE = attrgetter("response")
_FAST_THRESHOLD = 7
_CANDIDATES_A_CORNER = 6
_FINER = 4  # at most one corner in a cell of a grid so much finer than one a corner
_PER_CELL = 4
_DEPTH_STEP = 0.04  # share of the depth by which the neighbours of a usable depth may differ
_ROW_PX = 1.0
_LEAST_DISPARITY_PX = 1.0


@dataclass(frozen=True, eq=False)
class SlamImage:
    """One undistorted image.

    Args:
        time_ns: stamp.
        gray: ``(height, width)`` uint8.
        depth_m: ``(height, width)`` float32, NaN where unknown; None without depth.
        right: the rectified right image; None without one.
    """

    time_ns: int
    gray: GrayImage
    depth_m: DepthImage | None = None
    right: GrayImage | None = None

    @cached_property
    def pyramid(self) -> Pyramid:
        """The image as corners are tracked in it."""
        return Pyramid(self.gray)


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners ``(n, 2)`` pixels and their ORB descriptors ``(n, 32)``."""

    px: FloatArray
    descriptors: Descriptors

    def __len__(self) -> int:
        return len(self.px)


def grid_cells(px: FloatArray, shape: tuple[int, ...], count: int) -> IntArray:
    """Number of the square cell ``(n,)`` each pixel lies in, with about `count` cells in all."""
    side = np.sqrt(shape[0] * shape[1] / count)
    columns = int(np.ceil(shape[1] / side))
    cells = np.floor(px / side).astype(np.int64)
    numbers: IntArray = cells[:, 1] * columns + cells[:, 0]
    return numbers


def find_corners(gray: GrayImage, count: int, taken_px: FloatArray | None = None) -> Corners:
    """New corners, which together with `taken_px` make `count`, spread over the image.

    Fewer where the image has no texture; always in the same order.
    """
    taken = np.zeros((0, 2)) if taken_px is None else taken_px
    keypoints = _orb(count * _CANDIDATES_A_CORNER).detect(gray, None)
    nothing = Corners(np.zeros((0, 2)), np.zeros((0, 32), dtype=np.uint8))
    if not keypoints or len(taken) >= count:
        return nothing
    px = np.asarray(cv2.KeyPoint.convert(keypoints), dtype=np.float64)
    strength = np.fromiter(map(_RESPONSE, keypoints), np.float64, len(keypoints))
    order = np.lexsort((px[:, 0], px[:, 1], -strength))
    fine = grid_cells(px, gray.shape, _FINER * count)
    _, first = np.unique(fine[order], return_index=True)
    order = order[np.sort(first)]
    order = order[~np.isin(fine[order], grid_cells(taken, gray.shape, _FINER * count))]
    # The best of every coarse cell before the second best of any.
    coarse = grid_cells(np.concatenate([taken, px[order]]), gray.shape, count // _PER_CELL)
    turn = np.argsort(_rank_among_equals(coarse)[len(taken) :], kind="stable")
    chosen = order[turn][: count - len(taken)]
    if not len(chosen):
        return nothing
    kept, descriptors = _orb(count).compute(gray, [keypoints[index] for index in chosen])
    return Corners(np.asarray(cv2.KeyPoint.convert(kept), dtype=np.float64), descriptors)


def _rank_among_equals(values: IntArray) -> IntArray:
    """For each value how many equal ones stand before it."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    starts = np.searchsorted(ordered, ordered)
    rank = np.empty(len(values), dtype=np.int64)
    rank[order] = np.arange(len(values)) - starts
    return rank


def _orb(count: int) -> Any:
    return cv2.ORB.create(
        nfeatures=count,
        scaleFactor=1.4,
        nlevels=4,
        edgeThreshold=19,
        patchSize=31,
        fastThreshold=_FAST_THRESHOLD,
        scoreType=cv2.ORB_HARRIS_SCORE,
    )


def depth_at(depth_m: DepthImage, px: FloatArray) -> FloatArray:
    """Depths ``(n,)`` at pixels: the median of 3 by 3, NaN at gaps and at edges of surfaces."""
    height, width = depth_m.shape
    middle = np.rint(px).astype(np.int64)
    columns = np.clip(middle[:, 0, None, None] + np.arange(-1, 2), 0, width - 1)
    rows = np.clip(middle[:, 1, None, None] + np.arange(-1, 2)[:, None], 0, height - 1)
    around = depth_m[rows, columns].reshape(len(px), 9).astype(np.float64)
    around = np.where(np.isfinite(around) & (around > 0.0), around, np.nan)
    known = np.count_nonzero(np.isfinite(around), axis=1) >= 7
    depth = np.full(len(px), np.nan)
    if not known.any():
        return depth
    usable = around[known]
    median = np.nanmedian(usable, axis=1)
    spread = np.nanmax(usable, axis=1) - np.nanmin(usable, axis=1)
    depth[known] = np.where(spread <= _DEPTH_STEP * median, median, np.nan)
    return depth


def stereo_depth(
    left: GrayImage | Pyramid, right: GrayImage, px: FloatArray, disparity_px_m: float
) -> FloatArray:
    """Depths ``(n,)`` of pixels of a rectified pair; NaN where the right image shows no match.

    Args:
        left: the image that holds the pixels.
        right: the other one, its rows level with `left`.
        px: ``(n, 2)``.
        disparity_px_m: focal length (pixels) times baseline (metres).
    """
    there, tracked = track_corners(left, right, px, px)
    disparity = px[:, 0] - there[:, 0]
    level = np.abs(px[:, 1] - there[:, 1]) <= _ROW_PX
    usable = tracked & level & (disparity >= _LEAST_DISPARITY_PX)
    depth: FloatArray = np.where(usable, disparity_px_m / np.where(usable, disparity, 1.0), np.nan)
    return depth
