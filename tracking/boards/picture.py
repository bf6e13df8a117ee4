"""Flat patterns of black and white cells, and pictures of them drawn by exact area coverage.

A pattern lives in printed coordinates: metres, x right and y down from the board's origin (so
printed y is minus the board frame's y). Pictures follow the house: pixel (0, 0) is the centre of
the top-left pixel, 0 is black.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray

__all__ = ["Pattern", "draw"]


@dataclass(frozen=True)
class Pattern:
    """Cells between rising edges.

    Fields:
        white: ``(rows, columns)`` bool, True where the paper stays white.
        x_edges_m, y_edges_m: ``(columns + 1,)`` and ``(rows + 1,)`` edges, metres from the origin.
        quiet_m: width of the white zone that the pattern needs around it, metres.

    >>> from motorcade.tracking import SingleMarker
    >>> pattern = SingleMarker("aruco_4x4_50", 0, side_m=0.06).pattern
    >>> pattern.white.shape, pattern.x_edges_m[-1].item()  # 4 x 4 bits in a black border
    ((6, 6), 0.06)
    """

    white: NDArray[np.bool_]
    x_edges_m: FloatArray
    y_edges_m: FloatArray
    quiet_m: float


def draw(pattern: Pattern, pixels_per_m: float) -> tuple[NDArray[np.uint8], tuple[float, float]]:
    """Draw a pattern at any scale; every pixel is the mean of the paper that it covers.

    Returns:
        the uint8 picture, and the pixel ``(column, row)`` of the origin in it: the printed point
        ``(x, y)`` lies at ``origin + pixels_per_m * (x, y)``.

    Raises:
        ValueError: a scale that is not above zero, or too small to give the pattern any pixel.
    """
    if not np.isfinite(pixels_per_m) or pixels_per_m <= 0.0:
        raise ValueError(f"pixels_per_m: expected a number above 0, got {pixels_per_m}")
    weights, origin = [], []
    for edges in (pattern.x_edges_m, pattern.y_edges_m):
        start = int(np.floor((edges[0] - pattern.quiet_m) * pixels_per_m))
        stop = int(np.ceil((edges[-1] + pattern.quiet_m) * pixels_per_m))
        weights.append(_coverage(edges * pixels_per_m - start, stop - start))
        origin.append(-start - 0.5)
    across, down = weights
    black = down @ (~pattern.white).astype(np.float64) @ across.T
    picture = np.rint(255.0 * (1.0 - black)).astype(np.uint8)
    return picture, (origin[0], origin[1])


def _coverage(edges_px: FloatArray, pixels: int) -> FloatArray:
    """Share ``(pixels, cells)`` of each pixel's length that each cell covers."""
    left = np.arange(pixels)[:, None]
    overlap = np.minimum(left + 1, edges_px[1:]) - np.maximum(left, edges_px[:-1])
    share: FloatArray = np.clip(overlap, 0.0, 1.0)
    return share
