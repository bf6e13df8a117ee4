"""Observations whose candidates were refined on the image, for whatever takes those of corners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate.observations import (
    MarkerObservations,
    rotation_covariance,
)
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.photometric.refine import refine_photometric
from motorcade.tracking.markers.planar import planar_poses
from motorcade.tracking.pose import SIGMA_FLOOR_PX

# Neighbouring pixels err together: so many of them tell as much as one.
_ALIKE = 4.0


@dataclass(frozen=True, eq=False)
class RefinedFrame:
    """Markers of one image after refinement.

    Args:
        marker_ids: ``(m,)`` of those that have a pose.
        side_m: ``(m,)``.
        corners_px: ``(m, 4, 2)`` where the better candidate puts the corners.
        camera_T_marker: Motor ``(m, 2)``, the candidate that fits the image better first.
        error_px: ``(m, 2)`` 0, and the reprojection error that would speak as clearly against the
            other candidate if corners with `SIGMA_FLOOR_PX` of noise had it.

    Where refinement failed (see `refine_photometric`) all of these are what the corners say.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.markers.photometric import RefinedFrame
    >>> corners_px = np.array([[[10.0, 10.0], [60.0, 10.0], [60.0, 60.0], [10.0, 60.0]]])
    >>> frame = RefinedFrame(np.array([7]), np.array([0.1]), corners_px,
    ...     Motor.identity((1, 2)), error_px=np.array([[0.0, 3.2]]))
    >>> frame.marker_ids, float(frame.error_px[0, 1])  # the other candidate is clearly worse
    (array([7]), 3.2)
    """

    marker_ids: IntArray
    side_m: FloatArray
    corners_px: FloatArray
    camera_T_marker: Motor
    error_px: FloatArray


def refine_frame(
    image: GrayImage,
    camera: Camera,
    family: str,
    marker_ids: IntArray,
    corners_px: FloatArray,
    side_m: FloatArray,
    device: str | None = None,
) -> RefinedFrame:
    """Refine what was detected in one image; markers without a planar pose are left out.

    Args:
        image: see `refine_photometric`.
        camera: likewise.
        family: likewise.
        marker_ids: ``(n,)``.
        corners_px: ``(n, 4, 2)`` clockwise from the printed top-left corner.
        side_m: ``(n,)``.
        device: see `refine_photometric`.

    Raises:
        ValueError, PhotometricUnavailable: as `refine_photometric`.
    """
    rows, start, errors = planar_poses(camera, corners_px, side_m)
    ids, sides = marker_ids[rows], side_m[rows]
    refined = refine_photometric(image, camera, family, ids, sides, start, device)
    every, better = np.arange(len(ids))[:, None], np.argmin(refined.mismatch, axis=-1)
    sure = refined.refined[every[:, 0], better]
    order = np.argsort(np.where(sure[:, None], refined.mismatch, [0.0, 1.0]), axis=-1)
    poses = refined.camera_T_marker[every, order]
    less, more = np.maximum(np.sort(refined.mismatch, axis=-1), 1e-9).T
    nats = 0.5 * refined.pixels / _ALIKE * np.log(more / less)
    against = SIGMA_FLOOR_PX * np.sqrt(0.5 * nats)
    by_print = np.stack([np.zeros(len(ids)), against], axis=-1)
    return RefinedFrame(
        ids,
        sides,
        np.where(
            sure[:, None, None],
            camera.project(poses[:, 0][:, None].apply(marker_points_m(sides))),
            corners_px[rows],
        ),
        poses,
        np.where(sure[:, None], by_print, errors),
    )


def joined_frames(
    camera: Camera, time_ns: IntArray, frames: Sequence[RefinedFrame]
) -> tuple[CornerStream, MarkerObservations]:
    """All frames of a recording as corners, and as observations with both candidates.

    Args:
        camera: who saw them.
        time_ns: ``(F,)``.
        frames: F of them.
    """
    frame = np.repeat(np.arange(len(frames)), [len(one.marker_ids) for one in frames])
    ids = np.concatenate([one.marker_ids for one in frames])
    corners = np.concatenate([one.corners_px for one in frames])
    poses = Motor.concatenate([one.camera_T_marker for one in frames])
    points = marker_points_m(np.concatenate([one.side_m for one in frames]))
    errors = np.concatenate([one.error_px for one in frames])
    covariance = rotation_covariance(camera, poses, points[:, None])
    observations = MarkerObservations(time_ns, frame, ids, poses, errors, covariance)
    return CornerStream(camera, time_ns, frame, ids, corners), observations
