"""Points of the map matched to corners of an image: near where they should be, and alike.

Likeness is the number of bits in which ORB's descriptors differ (Hamming distance).

In a known map the camera is found in two steps. The keyframes that show the same words are looked
up (`vocabulary`); the best few are then matched one by one and verified by geometry, which alone
decides.

Sources: ORB: Rublee et al. 2011; ratio of distances: Lowe 2004.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera, to_frame
from motorcade.tracking.slam.features import Corners, Descriptors
from motorcade.tracking.slam.geometry import BoolArray, FittedPose, pose_by_sampling, reach
from motorcade.tracking.slam.mapping.map import Keyframe, SlamMap

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
    in_camera = to_frame(world_T_camera, points)
    expected, far = camera.project(in_camera, allow_nan=True), reach(camera, in_camera)
    then = reach(camera, to_frame(seen_by.world_T_camera, points))
    limit = (camera.width - 1 - _BORDER_PX, camera.height - 1 - _BORDER_PX)
    with np.errstate(invalid="ignore", divide="ignore"):
        near = np.abs(np.log(far / then)) < np.log(_SCALE_CHANGE)
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
        corners: those of the image.
        radius_px: how far off a corner may be.
    """
    apart = np.abs(expected_px[:, None] - corners.px[None])
    points, rows = np.nonzero(np.all(apart <= radius_px, axis=-1))
    own, other = (
        np.ascontiguousarray(d).view(np.uint64) for d in (descriptors, corners.descriptors)
    )
    bits = np.bitwise_count(own[points] ^ other[rows]).sum(axis=1)
    alike = bits <= _MOST_BITS
    points, rows, bits = points[alike], rows[alike], bits[alike]
    order = np.lexsort((rows, points, bits))
    points, rows = points[order], rows[order]
    best = np.zeros(len(points), dtype=np.int64)
    for owner in (points, rows):
        best[np.unique(owner, return_index=True)[1]] += 1
    chosen = best == 2
    return points[chosen], rows[chosen]


_FARTHEST = 64  # bits that may differ between two views of a corner
_RATIO = 0.85
_FEWEST_MATCHES = 15
_FEWEST_INLIERS = 15


@dataclass(frozen=True, eq=False)
class RecognisedKeyframe:
    """A keyframe that was recognised, the pose from it, and the matches that are inliers.

    Args:
        keyframe: its row; fit: the pose; ids, px: ``(n,)`` and ``(n, 2)`` points and pixels.
    """

    keyframe: int
    fit: FittedPose
    ids: IntArray
    px: FloatArray


def candidates(
    slam_map: SlamMap, corners: Corners, count: int, allowed: IntArray | None = None
) -> IntArray:
    """Rows of up to `count` keyframes (of `allowed`, if given) that look most like the corners."""
    rows = slam_map.keyframe_rows if allowed is None else allowed
    return slam_map.alike(corners.descriptors, rows, count)


def matched(slam_map: SlamMap, corners: Corners, keyframe: int) -> tuple[IntArray, IntArray]:
    """Rows of corners, and numbers of the points of one keyframe that they match."""
    ids = slam_map.keyframes[keyframe].ids
    ids = ids[slam_map.located[ids]]
    if len(ids) < 2 or not len(corners):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    best: dict[int, tuple[int, int]] = {}
    for row, point, distance in _nearest(corners.descriptors, slam_map.descriptors[ids], 2):
        clear = distance[0] <= _FARTHEST and distance[0] < _RATIO * distance[1]
        if clear and distance[0] < best.get(point[0], (_FARTHEST + 1, 0))[0]:
            best[point[0]] = (distance[0], row)
    points = np.array(sorted(best), dtype=np.int64)
    return np.array([best[point][1] for point in points], dtype=np.int64), ids[points]


def verified(
    slam_map: SlamMap, corners: Corners, rows: IntArray, camera: Camera
) -> RecognisedKeyframe | None:
    """The keyframe of `rows` with most matches that one pose explains, or None."""
    best: RecognisedKeyframe | None = None
    for keyframe in rows:
        corner, ids = matched(slam_map, corners, int(keyframe))
        if len(ids) < _FEWEST_MATCHES:
            continue
        px = corners.px[corner]
        fit = pose_by_sampling(slam_map.points[ids], px, camera)
        if fit is None or np.count_nonzero(fit.inliers) < _FEWEST_INLIERS:
            continue
        inliers = fit.inliers
        if best is None or np.count_nonzero(inliers) > len(best.ids):
            best = RecognisedKeyframe(int(keyframe), fit, ids[inliers], px[inliers])
    return best


def _nearest(
    query: Descriptors, known: Descriptors, count: int
) -> list[tuple[int, list[int], list[int]]]:
    """For each query its nearest known descriptors: row, their rows, their distances in bits."""
    pairs = cv2.BFMatcher(cv2.NORM_HAMMING).knnMatch(query, known, k=count)
    return [
        (pair[0].queryIdx, [m.trainIdx for m in pair], [int(m.distance) for m in pair])
        for pair in pairs
        if len(pair) == count
    ]
