"""Straight segments in pictures, as rays in the world: what upright edges and vanishing points
are found by.

Source of the detector: LSD, Grompone von Gioi et al. 2010.
"""

from __future__ import annotations

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage

# Pictures are searched at this width; segments below a share of it have no sure direction.
_WIDTH_PX, _LONG, _MOST = 640, 0.06, 120


def segment_rays(picture: GrayImage, camera: Camera, world_T_camera: Motor) -> FloatArray:
    """The longest straight segments of a picture.

    Args:
        picture: ``(height, width)`` uint8, of the camera's size.
        camera: which took it, distortion and all.
        world_T_camera: its pose.

    Returns:
        ``(s, 2, 3)`` unit rays to the ends of at most 120 segments, in the world's axes; those
        that the lens has no ray for are left out. Curves and textures give segments as well.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.planes import segment_rays
    >>> picture = np.zeros((480, 640), np.uint8)
    >>> picture[:, 320:] = 200  # an edge from top to bottom
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> rays = segment_rays(picture, camera, Motor.identity())
    >>> rays.shape, bool(np.abs(rays[..., 0]).max() < 0.01)
    ((1, 2, 3), True)
    """
    shrink = min(1.0, _WIDTH_PX / max(picture.shape))
    small = cv2.resize(picture, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    segments = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(small)[0]
    if segments is None:
        return np.zeros((0, 2, 3))
    ends = (segments.reshape(-1, 2, 2).astype(np.float64) + 0.5) / shrink - 0.5
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=-1)
    order = np.argsort(-length, kind="stable")[:_MOST]
    ends = ends[order[length[order] >= _LONG * max(picture.shape)]]
    rays = camera.bearings(ends.reshape(-1, 2)).reshape(-1, 2, 3)
    rays = rays[np.isfinite(rays).all(axis=(1, 2))]
    return np.asarray(world_T_camera.rotor.apply(rays))
