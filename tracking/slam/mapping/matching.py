"""Points of the map matched to corners of a picture: near where they should be, and alike.

Likeness is the number of bits in which ORB's descriptors differ (Rublee et al. 2011).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.cameras.reprojection import project, to_frame
from motorcade.tracking.slam.features import Corners, Descriptors
from motorcade.tracking.slam.geometry import BoolArray
from motorcade.tracking.slam.mapping.map import Keyframe, SlamMap

__all__ = ["alike_where_expected", "any_in_view", "in_view"]

_MOST_BITS = 64
_SCALE_CHANGE = 1.5
_BORDER_PX = 12.0


def in_view(
    slam_map: SlamMap, seen_by: Keyframe, ids: IntArray, world_T_camera: Motor, camera: Camera
) -> tuple[BoolArray, FloatArray]:
    """Which points ``(n,)`` a pose should see about as large as a keyframe did, and where.

    Args:
        slam_map: the map.
        seen_by: the keyframe.
        ids: ``(n,)`` points it saw.
        world_T_camera: the pose.
        camera: the pinhole.
    """
    points = slam_map.points[ids]
    expected, depth = project(camera, world_T_camera, points)
    then = to_frame(seen_by.world_T_camera, points)[:, 2]
    limit = (camera.width - 1 - _BORDER_PX, camera.height - 1 - _BORDER_PX)
    with np.errstate(invalid="ignore", divide="ignore"):
        near = np.abs(np.log(depth / then)) < np.log(_SCALE_CHANGE)
        inside = np.all((expected >= _BORDER_PX) & (expected <= limit), axis=1)
    usable: BoolArray = slam_map.located[ids] & near & inside
    return usable, expected


def any_in_view(
    slam_map: SlamMap, rows: Iterable[int], taken: IntArray, world_T_camera: Motor, camera: Camera
) -> tuple[IntArray, FloatArray]:
    """Points ``(n,)`` of some keyframes, but for those `taken`, that a pose sees; and where."""
    free = np.ones(len(slam_map.alive), dtype=np.bool_)
    free[taken] = False
    ids, px = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 2))]
    for row in rows:
        keyframe = slam_map.keyframes[row]
        usable, expected = in_view(slam_map, keyframe, keyframe.ids, world_T_camera, camera)
        usable &= free[keyframe.ids]
        ids.append(keyframe.ids[usable])
        px.append(expected[usable])
        free[ids[-1]] = False
    return np.concatenate(ids), np.concatenate(px)


def alike_where_expected(
    expected_px: FloatArray, descriptors: Descriptors, corners: Corners, radius_px: float
) -> tuple[IntArray, IntArray]:
    """Rows of points and of corners that are each other's best match.

    Args:
        expected_px: ``(n, 2)`` where the points should be.
        descriptors: ``(n, 32)`` theirs.
        corners: those of the picture.
        radius_px: how far off a corner may be.
    """
    apart = np.abs(expected_px[:, None] - corners.px[None])
    points, rows = np.nonzero(np.all(apart <= radius_px, axis=-1))
    one, other = (
        np.ascontiguousarray(d).view(np.uint64) for d in (descriptors, corners.descriptors)
    )
    bits = np.bitwise_count(one[points] ^ other[rows]).sum(axis=1)
    alike = bits <= _MOST_BITS
    points, rows, bits = points[alike], rows[alike], bits[alike]
    order = np.lexsort((rows, points, bits))
    points, rows = points[order], rows[order]
    best = np.zeros(len(points), dtype=np.int64)
    for owner in (points, rows):
        best[np.unique(owner, return_index=True)[1]] += 1
    chosen = best == 2
    return points[chosen], rows[chosen]
