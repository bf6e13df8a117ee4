"""Grey levels of a picture between its pixels."""

from __future__ import annotations

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.checks import GrayImage

__all__ = ["grey_levels"]


def grey_levels(image: GrayImage, px: FloatArray) -> FloatArray:
    """Bilinear grey levels ``(*, n)`` at pixels ``(*, n, 2)``; beyond the edge those of the edge.

    >>> import numpy as np
    >>> from motorcade.tracking.grey_levels import grey_levels
    >>> grey_levels(np.array([[0, 100], [0, 100]], np.uint8), np.array([[0.5, 0.0], [9.0, 1.0]]))
    array([ 50., 100.])
    """
    grid = px.astype(np.float32).reshape(-1, px.shape[-2], 2)
    levels = cv2.remap(image, grid, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(levels, np.float64).reshape(px.shape[:-1])
