"""Where markers of a map reproject in the cameras of a rig, and how that changes with the poses.

Poses are perturbed on the right, ``pose @ Motor.from_twist(delta)``: rotation (rad), then
translation (m).
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import FloatArray, Motor
from motorcade.tracking.markers.mapping.rig import RigSightings

__all__ = ["linearised", "residuals_px"]


def residuals_px(seen: RigSightings, world_T_rig: Motor, world_T_marker: Motor) -> FloatArray:
    """Reprojection minus corner ``(N, 4, 2)``; NaN where a corner has no image.

    Args:
        seen: N sightings.
        world_T_rig: Motor ``(N,)``, of each sighting's frame.
        world_T_marker: Motor ``(N,)``, of each sighting's marker.
    """
    camera_T_world = (world_T_rig @ seen.rig_T_camera[seen.camera]).inverse()
    points = (camera_T_world @ world_T_marker)[:, None].apply(seen.points_m)
    found = np.full((len(seen), 4, 2), np.nan)
    for which, camera in enumerate(seen.cameras):
        own = seen.camera == which
        found[own] = camera.project(points[own]) - seen.corners_px[own]
    return found


def linearised(
    seen: RigSightings, world_T_rig: Motor, world_T_marker: Motor
) -> tuple[FloatArray, FloatArray]:
    """Residuals ``(N, 8)`` and their derivatives ``(N, 3, 8, 6)`` by rig, marker and camera pose.

    Zero, with zero derivatives, for sightings with a corner that has no image.
    """
    rig_T_camera = seen.rig_T_camera[seen.camera]
    points = seen.points_m
    rig_T_marker = world_T_rig.inverse() @ world_T_marker
    on_rig = rig_T_marker[:, None].apply(points)
    before = rig_T_camera.inverse()[:, None].apply(on_rig)
    residuals, by_point = np.full((len(seen), 4, 2), np.nan), np.zeros((len(seen), 4, 2, 3))
    for which, camera in enumerate(seen.cameras):
        own = seen.camera == which
        pixels, by_point[own] = camera.project_jacobian(before[own])
        residuals[own] = pixels - seen.corners_px[own]
    axes = rig_T_camera.rotor.as_matrix()[:, None]
    by_rig_point = by_point @ axes.swapaxes(-1, -2)
    by_marker_point = by_rig_point @ rig_T_marker.rotor.as_matrix()[:, None]
    jacobians = np.stack(
        [
            -_by_twist(by_rig_point, on_rig),
            _by_twist(by_marker_point, points),
            -_by_twist(by_point, before),
        ],
        axis=1,
    ).reshape(len(seen), 3, 8, 6)
    hidden = ~np.isfinite(residuals).all(axis=(-1, -2)) | ~np.isfinite(jacobians).all((-1, -2, -3))
    residuals[hidden], jacobians[hidden] = 0.0, 0.0
    return residuals.reshape(-1, 8), jacobians


def _by_twist(by_point: FloatArray, points: FloatArray) -> FloatArray:
    """Derivative ``(N, 4, 2, 6)`` by a twist that moves the points: ``dX = w x X + v``."""
    by_turn = np.cross(points[..., None, :], by_point)
    return np.concatenate([by_turn, by_point], axis=-1)
