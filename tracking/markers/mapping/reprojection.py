"""Where markers of a map reproject in the cameras of a rig, and how that changes with the poses.

Poses are perturbed by ``pose.retract(twist)``: rotation (rad), then translation (m).
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.reprojection import reproject
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
    camera_T_rig = seen.rig_T_camera[seen.camera].inverse()
    camera_T_marker = camera_T_rig @ world_T_rig.inverse() @ world_T_marker
    in_camera = camera_T_marker[:, None].apply(seen.points_m)
    residuals, by_camera = np.full((len(seen), 4, 2), np.nan), np.zeros((len(seen), 4, 2, 6))
    for which, camera in enumerate(seen.cameras):
        mine = seen.camera == which
        pixels, by_camera[mine], _ = reproject(camera, in_camera[mine])
        residuals[mine] = pixels - seen.corners_px[mine]
    own = by_camera.reshape(-1, 8, 6)
    by_rig, by_marker = own @ camera_T_rig.adjoint(), -own @ camera_T_marker.adjoint()
    jacobians = np.stack([by_rig, by_marker, own], axis=1)
    hidden = ~np.isfinite(residuals).all(axis=(-1, -2)) | ~np.isfinite(jacobians).all((-1, -2, -3))
    residuals[hidden], jacobians[hidden] = 0.0, 0.0
    return residuals.reshape(-1, 8), jacobians
