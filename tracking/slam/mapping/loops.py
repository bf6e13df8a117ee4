"""Loops: the camera is back where it was, and the map is made to agree with that.

A keyframe that looks like one far back along the map is matched to it; if one pose explains the
matches, the drift between the two passes is spread over all keyframes by a pose graph (gtsam), and
points move with the keyframe that first saw them. Lengths must be metres: with one camera alone
the unit drifts too, and rigid poses cannot take that out.

Source: pose graph over keyframes that share points, Mur-Artal & Tardos 2017.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera, to_frame
from motorcade.tracking.slam.features import Corners, find_corners
from motorcade.tracking.slam.geometry import BoolArray, refine_pose
from motorcade.tracking.slam.mapping.map import SlamMap
from motorcade.tracking.slam.mapping.matching import (
    RecognisedKeyframe,
    alike_where_expected,
    any_in_view,
    candidates,
    verified,
)
from motorcade.tracking.slam.tracker import is_reliable

_APART = 10  # keyframes between the two passes, at least
_CANDIDATES = 3
_FEWEST_INLIERS = 40
_SHARED = 15
_ALIKE_PX = 6.0
_SAME_PX = 4.0
_AROUND = 5  # keyframes to each side of the old one that count as the same location
_SIGMA_RAD, _SIGMA_SHARE = 0.01, 0.01  # of an edge that one point holds
_FIXED = 1e6  # points that would hold a keyframe as if nailed down
_EDGE_SHARED = 30


@dataclass(frozen=True, eq=False)
class LoopClosure:
    """The newest keyframe recognised an old one.

    Args:
        old, new: rows of the keyframes.
        world_T_new: the newest keyframe's pose as the old part of the map has it.
        ids, px: ``(n,)``, ``(n, 2)`` old points that the newest keyframe sees, and where.
    """

    old: int
    new: int
    world_T_new: Motor
    ids: IntArray
    px: FloatArray


def find_loop(slam_map: SlamMap, features: int, camera: Camera) -> LoopClosure | None:
    """Look for an old keyframe that the newest one sees again but the map does not tie it to."""
    new = len(slam_map.keyframes) - 1
    newest = slam_map.keyframes[new]
    if newest.gray is None:
        return None
    untied = np.flatnonzero(~_tied(slam_map, newest.ids))
    untied = untied[untied <= new - _APART]
    if not len(untied):
        return None
    corners = find_corners(newest.gray, features)
    rows = candidates(slam_map, corners, _CANDIDATES, untied)
    found = verified(slam_map, corners, rows, camera)
    if found is None:
        return None
    ids, px = _more_matches(slam_map, corners, found, camera)
    if len(ids) < _FEWEST_INLIERS:
        return None
    fit = refine_pose(found.fit.world_T_camera, slam_map.points[ids], px, camera)
    inliers = fit.inliers
    reliable = is_reliable(fit, px, newest.gray.shape)
    if np.count_nonzero(inliers) < _FEWEST_INLIERS or not reliable:
        return None
    return LoopClosure(found.keyframe, new, fit.world_T_camera, ids[inliers], px[inliers])


def _tied(slam_map: SlamMap, ids: IntArray) -> BoolArray:
    """Keyframes ``(k,)`` that share points with these, or with keyframes that do."""
    near = np.flatnonzero(slam_map.shared(ids) >= _SHARED)
    if not len(near):
        return np.zeros(len(slam_map.keyframes), dtype=np.bool_)
    tied: BoolArray = slam_map.shared(slam_map.observations(near)[1]) >= _SHARED
    return tied


def _more_matches(
    slam_map: SlamMap, corners: Corners, found: RecognisedKeyframe, camera: Camera
) -> tuple[IntArray, FloatArray]:
    """Points of a keyframe and its neighbours, with the corners alike that lie near enough."""
    ids, expected = _around(slam_map, found.keyframe, found.fit.world_T_camera, camera)
    points, rows = alike_where_expected(expected, slam_map.descriptors[ids], corners, _ALIKE_PX)
    return ids[points], corners.px[rows]


def _around(
    slam_map: SlamMap, row: int, world_T_camera: Motor, camera: Camera
) -> tuple[IntArray, FloatArray]:
    """Points seen by a keyframe or its neighbours that a pose has in view, and where."""
    rows = range(max(row - _AROUND, 0), min(row + _AROUND + 1, len(slam_map.keyframes)))
    return any_in_view(slam_map, rows, np.zeros(0, np.int64), world_T_camera, camera)


def close_loop(slam_map: SlamMap, loop: LoopClosure, camera: Camera) -> None:
    """Spread the drift over the keyframes, move the points along, and join the two passes."""
    before = Motor.stack([one.world_T_camera for one in slam_map.keyframes])
    after = _optimised(slam_map, before, loop)
    owner = np.full(len(slam_map.alive), -1)
    for row in reversed(range(len(before))):
        owner[slam_map.keyframes[row].ids] = row
    for row, keyframe in enumerate(slam_map.keyframes):
        mine = np.flatnonzero((owner == row) & slam_map.located)
        correction = after[row] @ before[row].inverse()
        slam_map.points[mine] = correction.apply(slam_map.points[mine])
        keyframe.world_T_camera = after[row]
    _fuse(slam_map, loop, camera)
    _join(slam_map, loop)


def _join(slam_map: SlamMap, loop: LoopClosure) -> None:
    """Let the newest keyframe see the old points that were not fused with its own."""
    newest = slam_map.keyframes[loop.new]
    _, first = np.unique(loop.ids, return_index=True)
    ids, px = loop.ids[first], loop.px[first]
    fresh = ~np.isin(ids, newest.ids)
    newest.ids = np.concatenate([newest.ids, ids[fresh]])
    newest.px = np.concatenate([newest.px, px[fresh]])
    newest.depth = np.concatenate([newest.depth, np.full(np.count_nonzero(fresh), np.nan)])
    newest.keep(np.argsort(newest.ids))


def _fuse(slam_map: SlamMap, loop: LoopClosure, camera: Camera) -> None:
    """Make one of points that both passes mapped, so that the map holds together there."""
    for row in range(max(loop.new - _AROUND, 0), loop.new + 1):
        keyframe = slam_map.keyframes[row]
        ids, expected = _around(slam_map, loop.old, keyframe.world_T_camera, camera)
        unseen = ~np.isin(ids, keyframe.ids)
        ids, expected = ids[unseen], expected[unseen]
        own = keyframe.ids[slam_map.located[keyframe.ids]]
        own = own[~np.isin(own, slam_map.observations(np.arange(loop.old + _AROUND + 1))[1])]
        px = keyframe.px[np.isin(keyframe.ids, own)]
        corners = Corners(px, slam_map.descriptors[own])
        points, rows = alike_where_expected(expected, slam_map.descriptors[ids], corners, _SAME_PX)
        slam_map.merge(own[rows], ids[points])


def _optimised(slam_map: SlamMap, before: Motor, loop: LoopClosure) -> Motor:
    """Poses Motor ``(k,)`` of the keyframes after the loop."""
    import gtsam

    world_T = [gtsam.Pose3(pose) for pose in before.as_matrix()]
    depth = _typical_depth(slam_map)
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for row, node in enumerate(world_T):
        values.insert(row, node)
    graph.add(gtsam.PriorFactorPose3(0, world_T[0], _noise(_FIXED, depth)))
    for a, b, count in _edges(slam_map):
        relative = world_T[a].inverse() * world_T[b]
        graph.add(gtsam.BetweenFactorPose3(a, b, relative, _noise(count, depth)))
    seen = world_T[loop.old].inverse() * gtsam.Pose3(loop.world_T_new.as_matrix())
    noise = _noise(len(loop.ids), depth)
    graph.add(gtsam.BetweenFactorPose3(loop.old, loop.new, seen, noise))
    result = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    return Motor.from_matrix([result.atPose3(row).matrix() for row in range(len(before))])


def _noise(count: float, depth: float) -> Any:
    """Of an edge that `count` points hold, in a map whose points lie `depth` away."""
    import gtsam

    sigmas = np.array([_SIGMA_RAD] * 3 + [_SIGMA_SHARE * depth] * 3)
    return gtsam.noiseModel.Diagonal.Sigmas(sigmas / np.sqrt(count))


def _typical_depth(slam_map: SlamMap) -> float:
    newest = slam_map.keyframes[-1]
    ids = newest.ids[slam_map.located[newest.ids]]
    return float(np.median(to_frame(newest.world_T_camera, slam_map.points[ids])[:, 2]))


def _edges(slam_map: SlamMap) -> Iterator[tuple[int, int, int]]:
    """Neighbours in time, and keyframes that share many points: rows, and how many they share."""
    for row, keyframe in enumerate(slam_map.keyframes[:-1]):
        shared = slam_map.shared(keyframe.ids)
        for other in range(row + 1, len(slam_map.keyframes)):
            if other == row + 1 or shared[other] >= _EDGE_SHARED:
                yield row, other, max(int(shared[other]), 1)
