"""Which corners one pose explains (inliers), and which of the two planar poses is the true one.

Frames and errors as in `pose`. The choice between candidates is a shortest path (Viterbi 1967) kept
up online: each candidate costs what its pixels say against it, and each step what the camera would
have had to turn. So clear pictures speak for the unclear ones after them.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.pose import PlanarCandidates, RefinedPose, TrackingError, refine

__all__ = ["PoseChoice", "choose_pose", "inliers"]

# Corner noise a coordinate, and how fast a camera in the hand turns; both decide only between
# candidates that the pixels hardly tell apart.
_SIGMA_PX = 0.2
_TURN_RAD_S = np.radians(150.0)
_WORST_STEP = 20.0
_CLEAR = 200.0


@dataclass(frozen=True, eq=False)
class PoseChoice:
    """The chosen pose, and what the next picture needs to know of both.

    Args:
        pose: the chosen candidate, refined on all corners.
        candidates: Motor ``(2,)``, both ``world_T_camera``, the better reprojection first.
        costs: ``(2,)`` of the cheapest paths that end in them (negative log likelihoods).
    """

    pose: RefinedPose
    candidates: Motor
    costs: FloatArray


def choose_pose(
    candidates: PlanarCandidates,
    corners: BoardCorners,
    camera: Camera,
    before: PoseChoice | None = None,
    elapsed_s: float = 0.0,
) -> PoseChoice:
    """Choose between the two planar poses and refine the chosen one.

    Args:
        candidates: both planar poses of these corners.
        corners: what was seen.
        camera: what it was seen with.
        before: the choice in an earlier picture of the same board; without one the smaller
            reprojection error decides, and for small or distant boards it may be wrong.
        elapsed_s: seconds since then, above zero where `before` is given.

    Raises:
        ValueError: an elapsed time that is not above zero.
        TrackingError: a candidate that cannot be refined.
    """
    if before is not None and not elapsed_s > 0.0:
        raise ValueError(f"elapsed_s: expected seconds above 0, got {elapsed_s}")
    poses = [refine(corners, camera, candidates.world_T_camera[0])]
    second, error_px = candidates.world_T_camera[1], float(candidates.error_px[1])
    if _evidence(poses[0].error_px, error_px, len(corners)) < _CLEAR:
        poses.append(refine(corners, camera, second))
        poses.sort(key=lambda pose: pose.error_px)
        second, error_px = poses[1].world_T_camera, poses[1].error_px
    both = Motor.stack([poses[0].world_T_camera, second])
    costs = np.array([0.0, min(_evidence(poses[0].error_px, error_px, len(corners)), _CLEAR)])
    if before is not None:
        turns = (before.candidates[:, None].inverse() @ both[None, :]).rotor.angle()
        steps = np.minimum(0.5 * (turns / (_TURN_RAD_S * elapsed_s)) ** 2, _WORST_STEP)
        costs = costs + (before.costs[:, None] + steps).min(axis=0)
        costs = costs - costs.min()
    chosen = int(np.argmin(costs))
    pose = poses[chosen] if chosen < len(poses) else refine(corners, camera, second)
    return PoseChoice(pose, both, costs)


def inliers(corners: BoardCorners, camera: Camera, limit_px: float) -> BoardCorners:
    """The largest set of corners that one homography explains to `limit_px`, found by RANSAC.

    OpenCV seeds its search with a constant, so the answer is always the same.

    Raises:
        TrackingError: no homography at all.
    """
    straight = camera.undistort(corners.corners_px)
    homography, mask = cv2.findHomography(
        corners.points_m[:, :2], straight, cv2.RANSAC, limit_px, maxIters=500, confidence=0.999
    )
    if homography is None:
        raise TrackingError("corners: expected four that one pose explains, got none")
    return corners.keep(mask.ravel() == 1)


def _evidence(better_px: float, worse_px: float, count: int) -> float:
    """Log likelihood ratio of two poses for root mean square errors over `count` corners."""
    return float(count * (worse_px**2 - better_px**2) / (2.0 * _SIGMA_PX**2))
