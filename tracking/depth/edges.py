"""Whether depth lies on colour's pixels: where a surface ends, its image changes.

Needs no poses and no features: the last pixels of nearer surfaces are laid over the image's
gradient, shifted this way and that, larger and smaller. They fit best where depth and colour agree.
A rotation of the depth camera shows as a shift, a wrong ratio of focal lengths as a zoom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.audit import DEPTH_ON_COLOUR_PX
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.depth.cameras import DepthImage

_REACH = 0.05
"""Shifts up to so much of the image's width are tried (32 of 640 pixels)."""
_ZOOMS = np.linspace(0.86, 1.14, 15)
_JUMP = 1.12
"""A surface ends where what lies beside it is farther by an eighth: no slope looks like that."""
_BESIDE_PX = 6
"""Gaps beside an edge, which the depth camera's shadow leaves, are bridged up to here."""
_BLUR_PX = 1.5
_BRIGHTEST = 0.95
_FEWEST = 4000
_STANDS_OUT = 5.0
"""Times the scatter of shifts far from it by which the best one must lead their mean."""
_AHEAD = 1.0
"""Times that scatter by which another place must lead the stated one: less is what coincidence
gives one shift in three, and nothing separates the two."""
_USUAL_WIDTH = 320
"""Wider images are made smaller: what is looked for is pixels, not their fractions."""


@dataclass(frozen=True)
class EdgeOffset:
    """How far depth lies off colour; NaN where the images do not tell.

    Fields:
        right_px, down_px: by which depth has to be moved to lie on colour.
        zoom: by which it has to be made larger, about the image's middle.
        px: what both move a pixel by, root mean square over the image.
        contrast: how far the best fit stands out, in standard deviations of others.
        pixels: at edges of depth that were compared.
    """

    right_px: float
    down_px: float
    zoom: float
    px: float
    contrast: float
    pixels: int


def edge_offset(grays: Sequence[GrayImage], depths_m: Sequence[DepthImage]) -> EdgeOffset:
    """Find shift and zoom of depth that put its edges on those of the images.

    Args:
        grays: images ``(height, width)`` uint8.
        depths_m: their depth, registered, of the same size.

    Raises:
        ValueError: no images, or not as many of the one as of the other.

    Boxes before a wall, whose depth is 6 pixels too far to the left:

    >>> import numpy as np
    >>> from motorcade.tracking.depth import edge_offset
    >>> gray, depth = np.full((240, 320), 90, np.uint8), np.full((240, 320), 3.0, np.float32)
    >>> for y, x in np.mgrid[30:200:40, 40:280:60].reshape(2, -1).T:
    ...     gray[y : y + 20, x : x + 30] = 160
    ...     depth[y : y + 20, x - 6 : x + 24] = 2.0
    >>> found = edge_offset([gray] * 10, [depth] * 10)
    >>> round(found.right_px), round(found.down_px), round(found.zoom, 2)
    (6, 0, 1.0)
    """
    if not len(grays) or len(grays) != len(depths_m):
        raise ValueError(f"depths_m: expected as many as images, got {len(depths_m)}")
    height, width = grays[0].shape
    shrunk = max(width // _USUAL_WIDTH, 1)
    reach = round(_REACH * width / shrunk)
    score, counts = np.zeros((len(_ZOOMS), 2 * reach + 1, 2 * reach + 1)), np.zeros(len(_ZOOMS))
    pixels = 0
    for gray, depth_m in zip(grays, depths_m, strict=True):
        slope = np.fft.rfft2(_slope(gray, shrunk))
        rows, columns = np.nonzero(_edges(depth_m))
        pixels += len(rows)
        for index, zoom in enumerate(_ZOOMS):
            edges = _raster(columns, rows, zoom, (height, width), shrunk, reach)
            counts[index] += edges.sum()
            score[index] += _correlated(slope, edges, reach)
    if pixels < _FEWEST or not np.all(counts > 0.0):
        return EdgeOffset(np.nan, np.nan, np.nan, np.nan, 0.0, pixels)
    return _best(score / counts[:, None, None], reach, shrunk, (height, width), pixels)


def _best(
    score: FloatArray, reach: int, shrunk: int, shape: tuple[int, int], pixels: int
) -> EdgeOffset:
    rows, columns = np.indices(score.shape[1:])
    about_stated = np.zeros(score.shape, bool)
    middle = len(_ZOOMS) // 2
    about_stated[middle - 1 : middle + 2] = (
        shrunk * np.hypot(rows - reach, columns - reach) <= DEPTH_ON_COLOUR_PX
    )
    best, mode = (
        np.unravel_index(int(np.argmax(scores)), score.shape)
        for scores in (score, np.where(about_stated, score, -np.inf))
    )
    far = score[:, np.hypot(rows - best[1], columns - best[2]) > reach / 2]
    if score[best] - score[mode] < _AHEAD * far.std():
        best = mode
    z, down, right = (int(index) for index in best)
    contrast = float((score[z, down, right] - far.mean()) / max(far.std(), 1e-12))
    inside = all(0 < index < size - 1 for index, size in zip(best, score.shape, strict=True))
    if not inside or contrast < _STANDS_OUT:
        return EdgeOffset(np.nan, np.nan, np.nan, np.nan, contrast, pixels)
    right_px = shrunk * (right - reach + _vertex(score[z, down, right - 1 : right + 2]))
    down_px = shrunk * (down - reach + _vertex(score[z, down - 1 : down + 2, right]))
    step = float(_ZOOMS[1] - _ZOOMS[0])
    zoom = float(_ZOOMS[z]) + step * _vertex(score[z - 1 : z + 2, down, right])
    spread = (zoom - 1.0) ** 2 * (shape[0] ** 2 + shape[1] ** 2) / 12.0
    px = float(np.sqrt(right_px**2 + down_px**2 + spread))
    return EdgeOffset(float(right_px), float(down_px), zoom, px, contrast, pixels)


def _vertex(values: FloatArray) -> float:
    """Where the parabola through three values has its peak, from the middle one."""
    bend = values[0] - 2.0 * values[1] + values[2]
    return float(0.5 * (values[0] - values[2]) / bend) if bend < 0.0 else 0.0


def _slope(gray: GrayImage, shrunk: int) -> FloatArray:
    """Length of the image's gradient; the steepest twentieth counts alike."""
    smooth = cv2.GaussianBlur(gray.astype(np.float64), (0, 0), _BLUR_PX)
    slope = np.hypot(cv2.Sobel(smooth, cv2.CV_64F, 1, 0), cv2.Sobel(smooth, cv2.CV_64F, 0, 1))
    top = max(float(np.quantile(slope, _BRIGHTEST)), 1e-9)
    height, width = slope.shape[0] // shrunk, slope.shape[1] // shrunk
    cut = np.minimum(slope / top, 1.0)[: height * shrunk, : width * shrunk]
    slopes: FloatArray = cut.reshape(height, shrunk, width, shrunk).mean(axis=(1, 3))
    return slopes


def _edges(depth_m: DepthImage) -> NDArray[np.bool_]:
    """The last pixels of a nearer surface, where a farther one follows, at once or after a gap."""
    known = np.where(np.isfinite(depth_m) & (depth_m > 0.0), depth_m, np.nan)
    # A rim of unknown depth, so that nothing is compared with the opposite side of the image.
    known = np.pad(known, _BESIDE_PX, constant_values=np.nan)
    edges = np.zeros(known.shape, dtype=np.bool_)
    for axis in (0, 1):
        for sign in (-1, 1):
            ends = ~(np.roll(known, sign, axis) < _JUMP * known)
            for far in range(1, _BESIDE_PX + 1):
                edges |= ends & (np.roll(known, sign * far, axis) > _JUMP * known)
    return edges[_BESIDE_PX:-_BESIDE_PX, _BESIDE_PX:-_BESIDE_PX]


def _raster(
    columns: IntArray,
    rows: IntArray,
    zoom: float,
    shape: tuple[int, int],
    shrunk: int,
    reach: int,
) -> FloatArray:
    """How many edge pixels fall on each pixel of the smaller image; none near its rim."""
    height, width = shape[0] // shrunk, shape[1] // shrunk
    middle = 0.5 * (np.array(shape) - 1.0)
    y = np.rint((middle[0] + zoom * (rows - middle[0]) + 0.5) / shrunk - 0.5).astype(np.int64)
    x = np.rint((middle[1] + zoom * (columns - middle[1]) + 0.5) / shrunk - 0.5).astype(np.int64)
    inside = (y >= reach) & (y < height - reach) & (x >= reach) & (x < width - reach)
    counted = np.bincount(y[inside] * width + x[inside], minlength=height * width)
    return counted.reshape(height, width).astype(np.float64)


def _correlated(slope: np.ndarray, edges: FloatArray, reach: int) -> FloatArray:
    """Sums of the slope at the edges, moved by ``(a, b) - reach``."""
    whole = np.fft.irfft2(slope * np.conj(np.fft.rfft2(edges)), s=edges.shape)
    around = np.arange(-reach, reach + 1)
    sums: FloatArray = whole[around[:, None], around]
    return sums
