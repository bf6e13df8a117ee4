"""A lens that zooms: by how much its focal length is longer than a camera's, moment by moment.

A zoom about the lens's centre scales its image about there, distortion and all. So an image that
was taken zoomed shows, scaled back, what the camera's own focal length would have shown of it, and
all that asks a recording for one camera stays as it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera

Pixels = TypeVar("Pixels", NDArray[np.uint8], NDArray[np.float32])
_ALIASED = 0.5
MOST_KNOTS = 500
"""A curve is written with no more times than this."""


@dataclass(frozen=True, eq=False)
class Zoom:
    """Focal lengths over time, in those of a camera.

    Distortion is held to be the same in every focal length, which lenses keep roughly; a rolling
    shutter's rows keep their times only near a ratio of 1.

    Args:
        time_s: ``(K,)`` rising, on the clock of the frames' stamps.
        ratio: ``(K,)`` focal length over the camera's, above 0; geometric between, constant beyond.

    Raises:
        ValueError: another number of ratios than of times, times that do not rise, or ratios that
            are not above 0.

    >>> from motorcade.tracking.cameras.zoom import Zoom
    >>> Zoom([0.0, 2.0], [1.0, 4.0]).at([-1_000_000_000, 1_000_000_000])
    array([1., 2.])
    """

    time_s: FloatArray
    ratio: FloatArray

    def __post_init__(self) -> None:
        for name in ("time_s", "ratio"):
            values = np.array(getattr(self, name), np.float64)
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.time_s.ndim != 1 or not len(self.time_s) or np.any(np.diff(self.time_s) <= 0.0):
            raise ValueError("Zoom.time_s: expected rising seconds, got some that do not rise")
        if self.ratio.shape != self.time_s.shape or not np.all(self.ratio > 0.0):
            expected = f"expected {len(self.time_s)} numbers above 0, one a time"
            raise ValueError(f"Zoom.ratio: {expected}, got {self.ratio.tolist()[:4]}")

    def at(self, time_ns: IntArray | int) -> FloatArray:
        """Focal length over the camera's ``(*,)`` at stamps ``(*,)``."""
        time_s = 1e-9 * np.asarray(time_ns, np.float64)
        return np.asarray(np.exp(np.interp(time_s, self.time_s, np.log(self.ratio))))

    def unzoomed(self, image: Pixels, camera: Camera, time_ns: int) -> Pixels:
        """An image ``(h, w)`` or ``(h, w, 3)`` as the camera's own focal length shows it.

        What it does not show is black, or NaN of an image of numbers.
        """
        ratio = float(self.at(time_ns))
        depth = image.dtype != np.uint8
        if ratio > 1.0 and not depth:
            image = np.asarray(cv2.GaussianBlur(image, (0, 0), _ALIASED * (ratio**2 - 1) ** 0.5))
        scale, centre = 1.0 / ratio, np.array([camera.cx, camera.cy])
        shown = np.column_stack([scale * np.eye(2), (1.0 - scale) * centre])
        size, how = (camera.width, camera.height), cv2.INTER_NEAREST if depth else cv2.INTER_CUBIC
        outside = np.nan if depth else 0.0
        moved = cv2.warpAffine(image, shown, size, flags=how, borderValue=(outside,) * 4)
        return np.asarray(moved, image.dtype)
