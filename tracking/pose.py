"""Pose of a camera from the corners of a flat board: both planar solutions, and the refined one.

Frames: the board frame is called ``world`` (see `boards.corners`), so poses are
``world_T_camera``. A covariance belongs to the right perturbation
``world_T_camera @ Motor.from_twist(delta)``, ``delta`` = rotation (rad), then translation (m), both
in the camera frame. Errors in pixels are root mean squares of the distance of a corner from its
reprojection through the full lens model.

Sources: IPPE, Collins & Bartoli 2014 (through OpenCV); Levenberg 1944, Marquardt 1963.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import cv2
import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera, reproject
from motorcade.tracking.optimise import NormalEquations, Stop, minimise

if TYPE_CHECKING:
    from motorcade.tracking.boards.corners import BoardCorners  # whose package imports this module

# No corner finder is better than this on real images, however small the residuals are.
SIGMA_FLOOR_PX = 0.1
_STOP = Stop(steps=50, gain=1e-12, damping=1e-6, most_damping=1e6)
# Beyond this reprojection error IPPE is asked again, with rays moved by so much of themselves.
_DOUBTFUL_PX = 1.0
# Of a fisheye's corners farther than 80 degrees off the axis, where a plane across it stretches
# pixels more than thirtyfold, the pose is looked for in a view that is turned towards them.
ASIDE_COSINE = np.cos(np.deg2rad(80.0))
_NUDGES = (1e-9, 1e-8, 1e-7)


class TrackingError(ValueError):
    """Corners from which no pose follows, or a recording in which the board is never seen.

    >>> from motorcade.tracking import Camera, Checkerboard, TrackingError, track_board
    >>> try:
    ...     track_board([], Camera(64, 48, 50.0, 50.0, 32.0, 24.0), Checkerboard(3, 3, 0.05))
    ... except TrackingError as error:
    ...     print(error)
    frames: expected some that show checkerboard_3x3_50mm, got it in none of 0
    """


@dataclass(frozen=True, eq=False)
class PlanarCandidates:
    """The two poses that explain a flat board's image locally best, the better one first.

    A flat board seen from afar or nearly head on looks almost the same tilted either way; the
    pixels then cannot tell, and the second pose may be the true one.

    Args:
        world_T_camera: Motor ``(2,)``.
        error_px: ``(2,)`` root mean square reprojection error, rising.
    """

    world_T_camera: Motor
    error_px: FloatArray


@dataclass(frozen=True, eq=False)
class RefinedPose:
    """A pose that is least squares on all corners.

    Args:
        world_T_camera: one Motor.
        covariance: ``(6, 6)`` of the right perturbation, rotation (rad) then translation (m).
        error_px: root mean square reprojection error.
        residuals_px: ``(n, 2)`` reprojection minus corner.
        sigma_px: noise a coordinate that the covariance stands on: estimated from the residuals,
            at least `SIGMA_FLOOR_PX`.
    """

    world_T_camera: Motor
    covariance: FloatArray
    error_px: float
    residuals_px: FloatArray
    sigma_px: float


def planar_candidates(corners: BoardCorners, camera: Camera) -> PlanarCandidates:
    """Both local solutions of the pose of a flat board, by IPPE on undistorted rays.

    Head on and for exact corners the two coincide.

    Raises:
        TrackingError: fewer than four corners, corners on one line, or corners through which the
            lens model has no ray.
    """
    _check_spread(corners)
    bearings = camera.bearings(corners.corners_px)
    if not np.isfinite(bearings).all():
        raise TrackingError("corners: expected pixels that the lens model covers, got some outside")
    camera_T_view = Motor.identity()
    rays = camera.unproject(corners.corners_px)
    if bearings[:, 2].min() < ASIDE_COSINE:
        camera_T_view = _looking_along(bearings.mean(axis=0))
        seen = camera_T_view.inverse().apply(bearings)
        if seen[:, 2].min() < ASIDE_COSINE:
            raise TrackingError("corners: expected them within one view, got them all around")
        rays = seen / seen[:, 2:]
    candidates = _ippe(corners, camera, rays[:, :2], camera_T_view)
    for nudge in _NUDGES:
        if candidates.error_px[0] <= _DOUBTFUL_PX:
            break
        # Exactly head on, rounding alone decides whether OpenCV's IPPE finds the rotation; corners
        # moved by far less than any noise lead it past that point.
        nudged = rays[:, :2] * (1.0 + nudge * np.linspace(-1.0, 1.0, len(rays))[:, None])
        again = _ippe(corners, camera, nudged, camera_T_view)
        candidates = min(candidates, again, key=lambda pair: float(pair.error_px[0]))
    seen = np.isfinite(candidates.error_px)
    if not seen[0]:
        raise TrackingError("corners: expected a pose with every corner before the camera")
    if not seen[1]:  # no image at all from there: it explains nothing
        return PlanarCandidates(candidates.world_T_camera[[0, 0]], candidates.error_px[[0, 0]])
    return candidates


def _looking_along(ray: FloatArray) -> Motor:
    """camera_T_view of a view turned so that its axis is the ray."""
    across = np.array([-ray[1], ray[0], 0.0])
    sine = float(np.linalg.norm(across))
    axis = across / sine if sine > 0.0 else np.array([1.0, 0.0, 0.0])
    turn = Rotor.from_rotation_vector(np.arctan2(sine, ray[2]) * axis)
    return Motor.from_rotor_translation(turn, np.zeros(3))


def _ippe(
    corners: BoardCorners, camera: Camera, rays: FloatArray, camera_T_view: Motor
) -> PlanarCandidates:
    """IPPE's two poses, the one that reprojects better first, from rays in a turned view."""
    count, rotations, translations, _ = cv2.solvePnPGeneric(
        corners.points_m,
        np.ascontiguousarray(rays),
        np.eye(3),
        None,
        flags=cv2.SOLVEPNP_IPPE,
    )
    if count == 0:
        raise TrackingError("corners: expected a planar pose, got none that lies before the camera")
    camera_T_world = np.tile(np.eye(4), (2, 1, 1))
    for which in range(2):
        used = min(which, count - 1)
        camera_T_world[which, :3, :3] = cv2.Rodrigues(rotations[used])[0]
        camera_T_world[which, :3, 3] = np.ravel(translations[used])
    unknown = ~np.isfinite(camera_T_world).all(axis=(1, 2))  # square on along one axis, exactly
    camera_T_world[unknown] = np.eye(4)
    poses = (camera_T_view @ Motor.from_matrix(camera_T_world)).inverse()
    errors = np.array([reprojection_px(corners, camera, pose) for pose in poses])
    errors[unknown] = np.inf
    order = np.argsort(errors, kind="stable")
    return PlanarCandidates(poses[order], errors[order])


def reprojection_px(corners: BoardCorners, camera: Camera, world_T_camera: Motor) -> float:
    """Root mean square distance of the corners from the reprojection of their points.

    Infinite where a point has no image from that pose.
    """
    projected = camera.project(world_T_camera.inverse().apply(corners.points_m))
    squared = np.sum((projected - corners.corners_px) ** 2, axis=-1)
    error = float(np.sqrt(squared.mean()))
    return error if np.isfinite(error) else float("inf")


def refine(corners: BoardCorners, camera: Camera, world_T_camera: Motor) -> RefinedPose:
    """Minimise the reprojection error of all corners, from a pose that is near.

    Levenberg-Marquardt on the right perturbation with exact derivatives of the full lens model.
    The covariance is ``sigma^2 (J^T J)^-1``; it takes the corners' noise as independent and equal,
    and says nothing about the other planar solution.

    Raises:
        TrackingError: fewer than four corners, corners on one line, or a start from which some
            corner has no image.
    """
    _check_spread(corners)
    evaluate = partial(_Reprojection, corners, camera)
    if not np.isfinite(evaluate(world_T_camera).cost):
        raise TrackingError("world_T_camera: expected a pose with every corner before the camera")
    minimum = minimise(world_T_camera, evaluate, Motor.retract, _STOP)
    residuals = minimum.evaluation.residuals_px
    freedom = max(residuals.size - 6, 1)
    sigma = max(float(np.sqrt(np.sum(residuals**2) / freedom)), SIGMA_FLOOR_PX)
    return RefinedPose(
        world_T_camera=minimum.state,
        covariance=minimum.evaluation.equations.covariance(sigma),
        error_px=float(np.sqrt(2.0 * np.mean(residuals**2))),
        residuals_px=residuals,
        sigma_px=sigma,
    )


class _Reprojection:
    """Corners of a board against their reprojection from one pose."""

    def __init__(self, corners: BoardCorners, camera: Camera, world_T_camera: Motor) -> None:
        in_camera = world_T_camera.inverse().apply(corners.points_m)
        pixels, self._by_twist, _ = reproject(camera, in_camera)
        self.residuals_px: FloatArray = pixels - corners.corners_px
        self.cost = 0.5 * float(np.sum(self.residuals_px**2))

    @cached_property
    def equations(self) -> NormalEquations:
        return NormalEquations.of(self._by_twist.reshape(-1, 6), self.residuals_px.ravel())


def _check_spread(corners: BoardCorners) -> None:
    if not corners.spanning:
        raise TrackingError(
            f"corners: expected at least four that do not lie on one line, got {len(corners)}"
        )
