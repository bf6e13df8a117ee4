"""Corners carried from one picture to the next by pyramidal Lucas-Kanade flow.

A corner counts as followed when the flow back from its new place returns to the old one
(forward-backward check, Kalal et al. 2010). Places are right to some tenths of a pixel; a board's
`sharpen` then puts them onto the print, so nothing drifts.
"""

from __future__ import annotations

from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.tracking.boards import BoardCorners, GrayImage

__all__ = ["follow"]

_WINDOW_PX = (17, 17)
_LEVELS = 3
_STOP = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 20, 0.03)
_RETURN_PX = 1.0


def follow(before: GrayImage, after: GrayImage, corners: BoardCorners) -> BoardCorners:
    """Find where corners of one picture lie in the next; those that are lost are left out.

    Moves of up to about 60 px are found; faster ones need a new detection.
    """
    start = corners.corners_px.astype(np.float32).reshape(-1, 1, 2)
    there, found = _flow(before, after, start)
    back, returned = _flow(after, before, there)
    gap = np.linalg.norm((back - start).reshape(-1, 2), axis=-1)
    height, width = after.shape
    places = there.reshape(-1, 2)
    inside = ((places >= 0.0) & (places <= (width - 1, height - 1))).all(axis=-1)
    kept = found & returned & inside & (gap <= _RETURN_PX)
    places = np.where(kept[:, None], places, corners.corners_px)
    return corners.moved(places.astype(np.float64)).keep(kept)


def _flow(
    before: GrayImage, after: GrayImage, start: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    there, found, _ = cv2.calcOpticalFlowPyrLK(
        before, after, start, None, winSize=_WINDOW_PX, maxLevel=_LEVELS, criteria=_STOP
    )
    return there, cast("NDArray[np.bool_]", found.ravel() == 1)
