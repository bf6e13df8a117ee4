"""Sightings as gtsam's factors, of a fisheye too, which no pinhole holds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.graph.inertial import as_pose, as_poses
from motorcade.fusion.graph.shared import keys
from motorcade.fusion.visual_inertial.observations import LandmarkObservations
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.slam.geometry import is_native

if TYPE_CHECKING:
    import gtsam

_HUBER = 1.5


def add_sightings(
    factors: gtsam.NonlinearFactorGraph,
    observations: LandmarkObservations,
    rows: IntArray,
    camera: Camera,
    imu_T_camera: Motor,
    sigma_px: float,
) -> None:
    """Add factors between poses and landmarks, with Huber's loss.

    Args:
        factors: the graph.
        observations: what was seen.
        rows: ``(m,)`` which of them.
        camera: with its distortion.
        imu_T_camera: pose of the camera on the IMU.
        sigma_px: noise of a pixel coordinate.
    """
    import gtsam

    loss = gtsam.noiseModel.mEstimator.Huber.Create(_HUBER)
    pinholes = _pinholes(camera, observations.px[rows], imu_T_camera, sigma_px)
    for row, (seen, noise, lens, extrinsics) in zip(rows.tolist(), pinholes, strict=True):
        pose = keys(int(observations.keyframe[row])).pose
        point = gtsam.symbol("l", int(observations.landmark[row]))
        model = gtsam.noiseModel.Robust.Create(loss, noise)
        factors.push_back(
            gtsam.GenericProjectionFactorCal3_S2(
                seen, model, pose, point, lens, False, False, extrinsics
            )
        )


def _pinholes(
    camera: Camera, px: FloatArray, imu_T_camera: Motor, sigma_px: float
) -> Iterator[tuple[FloatArray, gtsam.noiseModel.Base, gtsam.Cal3_S2, gtsam.Pose3]]:
    """Pixel, its noise, lens and pose on the IMU of a pinhole that saw each pixel ``(m, 2)``.

    That of a fisheye looks along the pixel's ray, with a focal length of 1: there its picture and
    the fisheye's differ by a linear map, and the noise goes through that.
    """
    import gtsam

    if not is_native(camera):
        matrix = camera.matrix
        lens = gtsam.Cal3_S2(matrix[0, 0], matrix[1, 1], 0.0, matrix[0, 2], matrix[1, 2])
        same = gtsam.noiseModel.Isotropic.Sigma(2, sigma_px), lens, as_pose(imu_T_camera)
        yield from ((seen, *same) for seen in camera.undistort(px))
        return
    rays = camera.bearings(px)
    camera_T_pinhole = _towards(rays)
    by_plane = camera.project_jacobian(rays)[1] @ camera_T_pinhole[:, :, :2]
    spread = sigma_px**2 * np.linalg.inv(by_plane.swapaxes(-1, -2) @ by_plane)
    turned = Motor.from_rotor_translation(Rotor.from_matrix(camera_T_pinhole), np.zeros(3))
    middle, lens = np.zeros(2), gtsam.Cal3_S2(1.0, 1.0, 0.0, 0.0, 0.0)
    for covariance, extrinsics in zip(spread, as_poses(imu_T_camera @ turned), strict=True):
        yield middle, gtsam.noiseModel.Gaussian.Covariance(covariance), lens, extrinsics


def _towards(rays: FloatArray) -> FloatArray:
    """Rotations ``(m, 3, 3)`` that take z to unit vectors ``(m, 3)``."""
    steep = np.abs(rays[:, 2:]) > np.sqrt(0.5)
    aside = np.cross(np.where(steep, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]), rays)
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    return np.stack([aside, np.cross(rays, aside), rays], axis=-1)
