"""Triangulation and the pose of one image: what every part of SLAM shares.

Poses are ``world_T_camera``, the camera is an undistorted pinhole or a fisheye as it is, points are
metres (or the free unit of a monocular map). A covariance belongs to the perturbation
``world_T_camera.retract(step)``, rotation (rad), then translation.

Sources: Hartley & Zisserman 2003, ch. 12; Barath et al. 2020 (MAGSAC++, in OpenCV).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.native._least_squares import Lens, View
from motorcade.tracking.optimise import NormalEquations, Stop

BoolArray = NDArray[np.bool_]

OUTLIER_PX = 3.0
_HUBER_PX = 1.5
_SIGMA_FLOOR_PX = 0.3
_STOP = Stop(steps=10, gain=1e-7, damping=1e-9)
_SAMPLES = 300
_FEWEST = 6
# A pinhole stretches a fisheye's pixels fivefold along the radius where rays stand 65 degrees off
# the axis; corners beyond are left to those who know the lens.
_FLAT_COSINE = np.cos(np.deg2rad(65.0))


@dataclass(frozen=True, eq=False)
class FittedPose:
    """A pose fitted to points and their pixels.

    Args:
        world_T_camera: the pose.
        covariance: ``(6, 6)``, rotation (rad) then translation, of the right perturbation.
        inliers: ``(n,)`` which points the pose explains within `OUTLIER_PX`.
        error_px: root mean square reprojection error of the inliers.
    """

    world_T_camera: Motor
    covariance: FloatArray
    inliers: BoolArray
    error_px: float


def is_native(camera: Camera) -> bool:
    """Whether SLAM works in the images as the lens made them.

    So it does for a fisheye: a pinhole's image ends where the rays do long before 90 degrees. Of
    other lenses the images are undistorted once, which is faster.
    """
    return camera.model == "equidistant"


def seen_through(camera: Camera) -> Camera:
    """The camera whose images SLAM works in, and whose pixels its map holds."""
    return camera if is_native(camera) else camera.undistorted()


def flattened(camera: Camera, px: FloatArray) -> FloatArray:
    """Pixels ``(n, 2)`` of a pinhole with the camera's matrix; NaN far from the axis of a fisheye.

    For estimators that know nothing but pinholes, and may leave corners out.
    """
    if not is_native(camera):
        return px
    bearings = camera.bearings(px)
    near = bearings[:, 2] > _FLAT_COSINE
    flat = np.full(px.shape, np.nan)
    flat[near] = camera.undistorted().project(bearings[near])
    return flat


def reach(camera: Camera, in_camera: FloatArray) -> FloatArray:
    """How far ``(n,)`` points are, as the size of what is seen of them goes by it.

    That is the depth along the axis of a pinhole, and the distance from a fisheye.
    """
    return np.linalg.norm(in_camera, axis=-1) if is_native(camera) else in_camera[:, 2]


def triangulate(
    first: Motor, second: Motor, px: FloatArray, other_px: FloatArray, camera: Camera
) -> FloatArray:
    """Points ``(n, 3)`` seen at pixels ``(n, 2)`` from two poses; linear, all at once."""
    rows = []
    for world_T_camera, pixels in ((first, px), (second, other_px)):
        pose = world_T_camera.inverse().as_matrix()
        normals = _across(camera, pixels)
        rows += [
            normals[:, k, :1] * pose[0] + normals[:, k, 1:2] * pose[1] + normals[:, k, 2:] * pose[2]
            for k in (0, 1)
        ]
    system = np.stack(rows, axis=1)
    system = system / np.linalg.norm(system, axis=-1, keepdims=True)
    known = np.isfinite(system).all(axis=(-1, -2))
    system[~known] = 0.0
    # The smallest eigenvector of A^T A: four by four, and far faster than a batch of SVDs.
    _, vectors = np.linalg.eigh(np.swapaxes(system, -1, -2) @ system)
    homogeneous = vectors[..., 0]
    scale = np.where(np.abs(homogeneous[:, 3:]) > 1e-12, homogeneous[:, 3:], np.nan)
    points: FloatArray = homogeneous[:, :3] / np.where(known[:, None], scale, np.nan)
    return points


def _across(camera: Camera, px: FloatArray) -> FloatArray:
    """Two vectors ``(n, 2, 3)`` across the ray of each pixel: normals of planes that hold it."""
    normals = np.zeros((len(px), 2, 3))
    if not is_native(camera):
        normals[:, [0, 1], [0, 1]] = -1.0
        normals[:, :, 2] = camera.unproject(px)[:, :2]
        return normals
    bearings = camera.bearings(px)
    least = np.zeros_like(bearings)
    axis = np.argmin(np.abs(np.nan_to_num(bearings)), axis=-1)
    np.put_along_axis(least, axis[:, None], 1.0, axis=-1)
    normals[:, 0] = np.cross(bearings, least)
    normals[:, 1] = np.cross(bearings, normals[:, 0])
    return normals


def parallax_rad(first: Motor, second: Motor, points: FloatArray) -> FloatArray:
    """Angles ``(n,)`` between the rays from two cameras to the points."""
    a, b = (points - pose.translation_m for pose in (first, second))
    cosine = np.sum(a * b, axis=-1) / (np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1))
    angle: FloatArray = np.arccos(np.clip(cosine, -1.0, 1.0))
    return angle


def in_world(world_T_map: Similarity, map_T_camera: Motor) -> Motor:
    """Rigid poses ``(*)`` of a map's cameras in a world of another unit."""
    place = world_T_map.apply(map_T_camera.translation_m)
    return Motor.from_rotor_translation(world_T_map.rotor @ map_T_camera.rotor, place)


def points_in_world(world_T_map: Similarity, points: FloatArray) -> FloatArray:
    """A map's points ``(n, 3)`` likewise, NaN passed on."""
    moved = np.full(points.shape, np.nan)
    known = np.isfinite(points[:, 0])
    moved[known] = world_T_map.apply(points[known])
    return moved


@lru_cache(maxsize=8)
def lens_of(camera: Camera) -> Lens:
    """The camera as compiled equations take it."""
    return Lens(camera.model, camera.fx, camera.fy, camera.cx, camera.cy, camera.distortion)


def _covariance(view: View, pose: Motor, inliers: BoolArray, sigma: float) -> FloatArray:
    """Of the pose by the inliers alone; infinite where they do not fix it."""
    camera_T_world = pose.inverse().as_matrix()
    equations = NormalEquations(*view.linearise(camera_T_world, OUTLIER_PX))
    if np.count_nonzero(inliers) < _FEWEST or np.linalg.cond(equations.information) >= 1e14:
        return np.full((6, 6), np.inf)
    return equations.covariance(sigma)


def refine_pose(
    world_T_camera: Motor, points: FloatArray, px: FloatArray, camera: Camera
) -> FittedPose:
    """Robust least squares of the reprojection error, from a pose that is near.

    Args:
        world_T_camera: the start.
        points: ``(n, 3)``.
        px: ``(n, 2)`` where they were seen.
        camera: the pinhole that saw them.

    The pose found is a unit motor however far rounding has taken the start from one: poses that
    are moved along with a keyframe, which was made of such a pose, double their defect every time.

    Points behind the camera count as outliers. With fewer than six inliers, or points that do not
    fix the pose, the covariance is infinite.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.slam.geometry import refine_pose
    >>> camera, rng = Camera(640, 480, 500.0, 500.0, 319.5, 239.5), np.random.default_rng(0)
    >>> points = rng.uniform([-1.0, -1.0, 2.0], [1.0, 1.0, 4.0], (50, 3))
    >>> world_T_camera = Motor.from_twist([0.02, -0.01, 0.0, 0.1, 0.0, 0.05])
    >>> px = camera.project(world_T_camera.inverse().apply(points))
    >>> fit = refine_pose(Motor.identity(), points, px, camera)
    >>> bool(np.abs(fit.world_T_camera.local(world_T_camera)).max() < 1e-6)
    True
    """
    start = Motor.normalize(world_T_camera.coefficients)
    view = View(lens_of(camera), points, px, _HUBER_PX, OUTLIER_PX)
    stop = (_STOP.steps, _STOP.gain, _STOP.damping, _STOP.most_damping)
    coefficients, error = view.refine(start.coefficients, *stop)
    pose = Motor.normalize(coefficients)
    inliers = error <= OUTLIER_PX
    rms = float(np.sqrt(np.mean(error[inliers] ** 2))) if inliers.any() else float("inf")
    sigma = max(rms / np.sqrt(2.0), _SIGMA_FLOOR_PX)
    return FittedPose(pose, _covariance(view, pose, inliers, sigma), inliers, rms)


def pose_by_sampling(points: FloatArray, px: FloatArray, camera: Camera) -> FittedPose | None:
    """Pose from scratch: MAGSAC over minimal samples, then `refine_pose`; None where none is found.

    OpenCV seeds its samples alike at every call, so the same points give the same pose.
    """
    flat = flattened(camera, px)
    near = np.isfinite(flat[:, 0])
    if np.count_nonzero(near) < _FEWEST:
        return None
    try:
        solved, turn, shift, _ = cv2.solvePnPRansac(
            np.ascontiguousarray(points[near]),
            np.ascontiguousarray(flat[near]),
            np.array(camera.matrix),
            None,
            iterationsCount=_SAMPLES,
            reprojectionError=OUTLIER_PX,
            confidence=0.999,
            flags=cv2.USAC_MAGSAC,
        )
    except cv2.error:
        return None  # samples that allow no pose at all: OpenCV 5 throws where it finds no model
    if not solved or not np.isfinite(turn).all() or not np.isfinite(shift).all():
        return None
    return refine_pose(pose_from_opencv(turn, shift).inverse(), points, px, camera)


def pose_from_opencv(turn: FloatArray, shift: FloatArray) -> Motor:
    """A motor from OpenCV's rotation vector ``(3,)`` or matrix ``(3, 3)``, and its translation."""
    vector = cv2.Rodrigues(turn)[0] if np.size(turn) == 9 else turn
    return Motor.from_rotor_translation(
        Rotor.from_rotation_vector(np.ravel(vector)), np.ravel(shift)
    )
