"""What to believe: which corners agree with one pose, and which of the two planar poses is true.

Frames and errors as in `pose`.
"""

from __future__ import annotations

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.camera import Camera
from motorcade.tracking.pose import PlanarCandidates, RefinedPose, TrackingError, refine

__all__ = ["choose", "consistent"]

# Corner noise a coordinate that decides between candidates: more than the residuals of a good
# picture show, because blur and a wrong lens model move all corners of a marker together.
_DECISION_SIGMA_PX = 0.3
_CLEAR_BEFORE = 100.0
_CLEAR_AFTER = 9.0


def choose(
    candidates: PlanarCandidates, corners: BoardCorners, camera: Camera, expected: Motor | None
) -> RefinedPose:
    """Refine the better candidate; where the pixels hardly tell the two apart, refine both.

    If the refined errors still differ by less than three standard deviations of the noise, the
    pose that turns less from `expected` (the camera a moment before) is taken; without one, the
    smaller error decides, and may be wrong.

    Raises:
        TrackingError: a candidate that cannot be refined.
    """
    if _excess(candidates.error_px[0], candidates.error_px[1], len(corners)) > _CLEAR_BEFORE:
        return refine(corners, camera, candidates.world_T_camera[0])
    both = [refine(corners, camera, candidate) for candidate in candidates.world_T_camera]
    both.sort(key=lambda pose: pose.error_px)
    if _excess(both[0].error_px, both[1].error_px, len(corners)) > _CLEAR_AFTER:
        return both[0]
    if expected is None:
        return both[0]
    turns = [float((expected.inverse() @ pose.world_T_camera).rotor.angle()) for pose in both]
    return both[int(np.argmin(turns))]


def consistent(corners: BoardCorners, camera: Camera, limit_px: float) -> BoardCorners:
    """The largest set of corners that one homography explains to `limit_px`, found by RANSAC.

    OpenCV seeds its search with a constant, so the answer is always the same.

    Raises:
        TrackingError: no homography at all.
    """
    straight = camera.straighten(corners.corners_px)
    homography, mask = cv2.findHomography(
        corners.points_m[:, :2], straight, cv2.RANSAC, limit_px, maxIters=500, confidence=0.999
    )
    if homography is None:
        raise TrackingError("corners: expected four that agree with one pose, got none")
    return corners.keep(mask.ravel() == 1)


def _excess(better_px: float, worse_px: float, count: int) -> float:
    """By how many noise variances the worse pose's sum of squares exceeds the better one's."""
    return float(count * (worse_px**2 - better_px**2) / _DECISION_SIGMA_PX**2)
