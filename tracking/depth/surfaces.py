"""Local planes of depth pictures, in the pixels' own coordinates.

The inverse depth of a plane is linear in the pixel, whatever the focal length: where
``1/z = w + wu (u - u0) + wv (v - v0)``, the plane is ``n . X = 1`` with
``n = (fx wu, fy wv, w + wu (cx - u0) + wv (cy - v0))``. So planes that were fitted once serve all
focal lengths that are tried.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.depth.cameras import DepthImage
from motorcade.tracking.planes.finding import depth_sigma_m

_HALF = 3
"""Windows of 7 by 7 pixels: the noise of a plane's depth is a seventh of a pixel's, and a surface
of 2 cm at 2 m still fills one."""
_EVERY = 4
_SIGMAS = 3.0
"""A window that scatters by more than so many times the sensor's noise holds an edge."""


@dataclass(frozen=True, eq=False)
class DepthSurfaces:
    """The local planes of several depth pictures of one size, at every fourth pixel.

    Fields:
        planes: ``(k, rows, columns, 3)`` float32: inverse depth in 1/m, and its slopes along u and
            v; NaN at gaps, edges and where the surface is no plane.
    """

    planes: NDArray[np.float32]

    @classmethod
    def of(cls, pictures: list[DepthImage]) -> DepthSurfaces:
        """Fit them all."""
        return cls(np.stack([_fitted(picture) for picture in pictures]))

    def at(self, picture: IntArray, px: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The planes ``(n, 3)`` nearest to pixels ``(n, 2)``, NaN for none, and their pixels."""
        cell = np.rint(np.nan_to_num(px, nan=-1e6) / _EVERY).astype(np.int64)
        rows, columns = self.planes.shape[1:3]
        inside = np.all((cell >= 0) & (cell < (columns, rows)), axis=-1)
        cell = np.where(inside[:, None], cell, 0)
        planes = self.planes[picture, cell[:, 1], cell[:, 0]].astype(np.float64)
        planes[~inside] = np.nan
        return planes, (cell * _EVERY).astype(np.float64)

    def grid(self, picture: int, every_px: int) -> tuple[FloatArray, FloatArray]:
        """Pixels ``(n, 2)`` of a grid that have a plane, and their inverse depths ``(n,)``."""
        step = max(every_px // _EVERY, 1)
        inverse = self.planes[picture, step // 2 :: step, step // 2 :: step, 0]
        rows, columns = np.nonzero(np.isfinite(inverse))
        px = _EVERY * (np.stack([columns, rows], axis=-1) * step + step // 2)
        return px.astype(np.float64), inverse[rows, columns].astype(np.float64)


def _fitted(depth_m: DepthImage) -> NDArray[np.float32]:
    known = np.isfinite(depth_m) & (depth_m > 0.0)
    inverse = np.zeros(depth_m.shape)
    inverse[known] = 1.0 / depth_m[known].astype(np.float64)
    side = 2 * _HALF + 1
    ones, ramp = np.ones(side), np.arange(-_HALF, _HALF + 1.0)
    spread = float(np.sum(ramp**2)) * side

    def summed(picture: FloatArray, along: FloatArray, down: FloatArray) -> FloatArray:
        sums = cv2.sepFilter2D(picture, cv2.CV_64F, along, down, borderType=cv2.BORDER_CONSTANT)
        return np.asarray(sums, np.float64)

    full = summed(known.astype(np.float64), ones, ones) > side * side - 0.5
    mean = summed(inverse, ones, ones) / side**2
    slope_u, slope_v = summed(inverse, ramp, ones) / spread, summed(inverse, ones, ramp) / spread
    scatter = summed(inverse**2, ones, ones) / side**2 - mean**2
    scatter -= (slope_u**2 + slope_v**2) * spread / side**2
    ahead = 1.0 / np.where(full, mean, 1.0)
    full &= scatter <= (_SIGMAS * depth_sigma_m(ahead) / ahead**2) ** 2
    planes = np.stack([mean, slope_u, slope_v], axis=-1)
    planes[~full] = np.nan
    return planes[::_EVERY, ::_EVERY].astype(np.float32)


def normals(
    planes: FloatArray, px: FloatArray, focal: FloatArray, centre: FloatArray
) -> FloatArray:
    """The planes ``n . X = 1`` as ``(n, 3)``, of planes at pixels; lengths ``(2,)`` in pixels."""
    slopes = planes[:, 1:]
    offset = planes[:, 0] + np.sum(slopes * (centre - px), axis=-1)
    return np.concatenate([slopes * focal, offset[:, None]], axis=-1)
