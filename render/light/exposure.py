"""How the exposure of footage changes, told by ground that several of its pictures show."""

from __future__ import annotations

import numpy as np

from motorcade.animation.srgb import to_linear
from motorcade.ga import Motor
from motorcade.render.light.ground import BRIGHTEST, GroundMap
from motorcade.render.scene import ImageArray
from motorcade.tracking.cameras.camera import Camera

POINTS, FEWEST = 400, 40
LEAST_LIGHT = 0.03
MOST = 4.0
"""A camera's exposure changes by no more than this in footage that shows the same ground."""


class ExposureMeter:
    """Exposure of one picture after another, 1 for the usual one of a ground's pictures.

    Where a picture shows too little of the ground that is flat and not overexposed, the exposure is
    held to be that of the picture before.

    Args:
        ground: whose light is compared with.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.render.light import ExposureMeter, GroundMap
    >>> none, light = np.zeros((8, 8), bool), np.full((8, 8), 0.5)
    >>> lawn = GroundMap(Motor.identity(), 0.1, light, 0 * light, none, none, 0.1, np.zeros(2))
    >>> len(ExposureMeter(lawn).points_m)
    64
    """

    def __init__(self, ground: GroundMap) -> None:
        rows, columns = np.nonzero(ground.flat & ~ground.full & (ground.light > LEAST_LIGHT))
        some = np.unique(np.linspace(0, max(len(rows) - 1, 0), POINTS).astype(int))
        some = some[: len(rows)]
        self.points_m = ground.points_m()[rows[some], columns[some]]
        self._light = ground.light[rows[some], columns[some]]
        self._last = 1.0

    def gain(self, picture: ImageArray, camera: Camera, world_T_camera: Motor) -> float:
        """Light of a picture (h, w) or (h, w, 3) over what it usually is, vignetting aside."""
        if not len(self.points_m):
            return self._last
        own = world_T_camera.inverse().apply(self.points_m)
        ahead = own[:, 2] > 1e-3
        if not ahead.any():
            return self._last
        x, y = np.rint(camera.project(own[ahead])).astype(np.int64).T
        inside = (x >= 0) & (y >= 0) & (x < camera.width) & (y < camera.height)
        shown = picture[y[inside], x[inside]]
        grey = shown.mean(axis=1) if shown.ndim == 2 else shown
        fit = grey < BRIGHTEST
        if np.count_nonzero(fit) >= FEWEST:
            ratio = to_linear(grey[fit] / 255.0) / self._light[ahead][inside][fit]
            self._last = float(np.clip(np.median(ratio), 1.0 / MOST, MOST))
        return self._last
