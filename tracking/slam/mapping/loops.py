"""Loops: the camera is back where it was, and the map is made to agree with that.

A keyframe that looks like one far back along the map is matched to it. If one pose explains the
matches, the drift between the two passes is spread over all keyframes by a pose graph, and points
move with the keyframe that first saw them. With one camera the unit drifts too: how much longer it
has become is told by the depths of points that both passes mapped, and the graph spreads that as
well. Where the old keyframe belongs to another map, this makes one map of the two.

Sources: pose graph over keyframes that share points, Mur-Artal & Tardos 2017; of similarities,
Strasdat et al. 2010; maps that meet, Campos et al. 2021 (ORB-SLAM3).

In the pose graph of one camera the unit drifts along with the pose, so nodes are similarities: 7
numbers each. Where lengths are metres the scale stays and 6 remain.

Source: Strasdat, Montiel & Davison 2010 (scale drift-aware loop closing).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera, to_frame
from motorcade.tracking.optimise import PairIndex, SparseEquations, Stop, minimise, sum_by
from motorcade.tracking.slam.features import Corners, find_corners
from motorcade.tracking.slam.geometry import BoolArray, refine_pose
from motorcade.tracking.slam.mapping.map import GONE, Keyframe, SlamMap
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
_EDGE_SHARED = 30
_SAME_CORNER_PX = 2.0  # within which a corner found anew is the one that was tracked
_FEWEST_DEPTHS = 15
_MOST_SCALE_SIGMA = 0.02  # a loop closed by a scale known worse bends what it should mend


@dataclass(frozen=True, eq=False)
class LoopClosure:
    """The newest keyframe recognised an old one.

    Args:
        old, new: rows of the keyframes.
        world_S_new: the newest keyframe's pose in the old keyframe's world, with the old unit of
            length in terms of the new one.
        ids, px: ``(n,)``, ``(n, 2)`` old points that the newest keyframe sees, and where.
    """

    old: int
    new: int
    world_S_new: Similarity
    ids: IntArray
    px: FloatArray


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """What closing a loop changed.

    Args:
        old_time_ns, time_ns: stamps of the keyframe that was recognised, and of the newest.
        maps: numbers of the map that is gone and of the one that took it up; alike within one map.
        correction: the newest keyframe's pose and unit now, from what it believed them to be.
    """

    old_time_ns: int
    time_ns: int
    maps: tuple[int, int]
    correction: Similarity


def find_loop(slam_map: SlamMap, features: int, camera: Camera) -> LoopClosure | None:
    """Look for an old keyframe that the newest one sees again but the map does not tie it to."""
    new = len(slam_map.keyframes) - 1
    newest = slam_map.keyframes[new]
    if newest.gray is None:
        return None
    number = np.array([one.map_number for one in slam_map.keyframes])
    apart = ~_tied(slam_map, newest.ids) & (np.arange(new + 1) <= new - _APART)
    untied = np.flatnonzero(np.where(number == newest.map_number, apart, number != GONE))
    if not len(untied):
        return None
    corners = find_corners(newest.gray, features)
    rows = candidates(slam_map, corners, _CANDIDATES, untied)
    recognised = verified(slam_map, corners, rows, camera)
    if recognised is None:
        return None
    ids, px = _more_matches(slam_map, corners, recognised, camera)
    if len(ids) < _FEWEST_INLIERS:
        return None
    fit = refine_pose(recognised.fit.world_T_camera, slam_map.points[ids], px, camera)
    inliers = fit.inliers
    reliable = is_reliable(fit, px, newest.gray.shape)
    if np.count_nonzero(inliers) < _FEWEST_INLIERS or not reliable:
        return None
    ids, px, pose = ids[inliers], px[inliers], fit.world_T_camera
    scale = 1.0
    if not (slam_map.metric[newest.map_number] and slam_map.metric[number[recognised.keyframe]]):
        ratio = _scale_by_depths(slam_map, newest, pose, ids, px)
        if ratio is None:
            return None
        scale = ratio
    world_S_new = Similarity.from_motor_scale(pose, scale)
    return LoopClosure(recognised.keyframe, new, world_S_new, ids, px)


def _scale_by_depths(
    slam_map: SlamMap, newest: Keyframe, old_pose: Motor, ids: IntArray, px: FloatArray
) -> float | None:
    """The old unit of length by the new one: points of both passes that one corner shows."""
    own = np.flatnonzero(slam_map.located[newest.ids])
    if not len(own):
        return None
    apart = np.linalg.norm(newest.px[own][None] - px[:, None], axis=-1)
    nearest = np.argmin(apart, axis=1)
    same = apart[np.arange(len(px)), nearest] <= _SAME_CORNER_PX
    if np.count_nonzero(same) < _FEWEST_DEPTHS:
        return None
    own_points = slam_map.points[newest.ids[own[nearest[same]]]]
    depth = to_frame(old_pose, slam_map.points[ids[same]])[:, 2]
    own_depth = to_frame(newest.world_T_camera, own_points)[:, 2]
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.log(depth / own_depth)
    ratio = ratio[np.isfinite(ratio)]
    if len(ratio) < _FEWEST_DEPTHS:
        return None
    middle = float(np.median(ratio))
    spread = 1.4826 * float(np.median(np.abs(ratio - middle)))  # the deviation, were it normal
    if spread > _MOST_SCALE_SIGMA * np.sqrt(len(ratio)):
        return None
    return float(np.exp(middle))


def _tied(slam_map: SlamMap, ids: IntArray) -> BoolArray:
    """Keyframes ``(k,)`` that share points with these, or with keyframes that do."""
    near = np.flatnonzero(slam_map.shared(ids) >= _SHARED)
    if not len(near):
        return np.zeros(len(slam_map.keyframes), dtype=np.bool_)
    tied: BoolArray = slam_map.shared(slam_map.observations(near)[1]) >= _SHARED
    return tied


def _more_matches(
    slam_map: SlamMap, corners: Corners, recognised: RecognisedKeyframe, camera: Camera
) -> tuple[IntArray, FloatArray]:
    """Points of a keyframe and its neighbours, with the corners alike that lie near enough."""
    pose = recognised.fit.world_T_camera
    near = _neighbours(slam_map, recognised.keyframe)
    ids, expected = any_in_view(slam_map, near, np.zeros(0, np.int64), pose, camera)
    points, rows = alike_where_expected(expected, slam_map.descriptors[ids], corners, _ALIKE_PX)
    return ids[points], corners.px[rows]


def _neighbours(slam_map: SlamMap, row: int) -> list[int]:
    """Rows of the keyframes of the same map that were made just before and after one, and it."""
    mine = slam_map.rows_of(slam_map.keyframes[row].map_number)
    position = int(np.searchsorted(mine, row))
    near: list[int] = mine[max(position - _AROUND, 0) : position + _AROUND + 1].tolist()
    return near


def close_loop(slam_map: SlamMap, loop: LoopClosure, camera: Camera) -> ClosedLoop:
    """Spread the drift over the keyframes, move the points along, and join the two passes."""
    old, newest = slam_map.keyframes[loop.old], slam_map.keyframes[loop.new]
    before, scale_before = Similarity.from_motor_scale(newest.world_T_camera), newest.scale
    gone, into = newest.map_number, old.map_number
    first, second = (_neighbours(slam_map, row) for row in (loop.old, loop.new))
    if gone == into:
        _spread(slam_map, loop)
    else:
        into_S_gone = loop.world_S_new @ before.inverse()
        if slam_map.metric[gone] and not slam_map.metric[into]:
            gone, into, into_S_gone = into, gone, into_S_gone.inverse()
        slam_map.join_maps(gone, into, into_S_gone)
    _fuse(slam_map, first, second, camera)
    _join(slam_map, loop)
    stretch = newest.scale / scale_before
    after = Similarity.from_motor_scale(newest.world_T_camera, stretch)
    return ClosedLoop(old.time_ns, newest.time_ns, (gone, into), before.inverse() @ after)


def _spread(slam_map: SlamMap, loop: LoopClosure) -> None:
    """Spread the drift over the keyframes of one map, and move the points along."""
    rows = slam_map.rows_of(slam_map.keyframes[loop.new].map_number)
    before = Similarity.from_motor_scale(
        Motor.stack([slam_map.keyframes[row].world_T_camera for row in rows])
    )
    after = _optimised(slam_map, rows, before, loop)
    owner = np.full(len(slam_map.alive), -1)
    for position in reversed(range(len(rows))):
        owner[slam_map.keyframes[rows[position]].ids] = position
    corrections = after @ before.inverse()
    for position, row in enumerate(rows.tolist()):
        mine = np.flatnonzero((owner == position) & slam_map.located)
        slam_map.points[mine] = corrections[position].apply(slam_map.points[mine])
        slam_map.keyframes[row].move(after[position])


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


def _fuse(slam_map: SlamMap, first: list[int], second: list[int], camera: Camera) -> None:
    """Make one of points that both passes mapped, so that the map holds together there."""
    of_first = slam_map.observations(np.array(first))[1]
    for row in second:
        keyframe = slam_map.keyframes[row]
        pose = keyframe.world_T_camera
        ids, expected = any_in_view(slam_map, first, keyframe.ids, pose, camera)
        own = keyframe.ids[slam_map.located[keyframe.ids]]
        own = own[~np.isin(own, of_first)]
        px = keyframe.px[np.isin(keyframe.ids, own)]
        corners = Corners(px, slam_map.descriptors[own])
        points, rows = alike_where_expected(expected, slam_map.descriptors[ids], corners, _SAME_PX)
        slam_map.merge(own[rows], ids[points])


def _optimised(
    slam_map: SlamMap, rows: IntArray, world_S: Similarity, loop: LoopClosure
) -> Similarity:
    """Poses Similarity ``(k,)`` of the keyframes `rows` after the loop."""
    a, b, count = _edges(slam_map, rows)
    place = {int(row): position for position, row in enumerate(rows)}
    old, new = place[loop.old], place[loop.new]
    seen = world_S[old].inverse() @ loop.world_S_new
    known = world_S[a].inverse() @ world_S[b]
    between = Similarity(np.concatenate([known.coefficients, seen.coefficients[None]]))
    share = _SIGMA_SHARE * _typical_depth(slam_map)
    sigma = np.repeat((_SIGMA_RAD, share, _SIGMA_SHARE), (3, 3, 1))
    counts = np.append(count, len(loop.ids))
    graph = PoseGraph(
        np.append(a, old),
        np.append(b, new),
        between,
        sigma / np.sqrt(counts)[:, None],
        np.arange(len(rows)) == 0,
        rigid=slam_map.metric[slam_map.keyframes[loop.new].map_number],
    )
    return graph.relaxed(world_S)


def _typical_depth(slam_map: SlamMap) -> float:
    newest = slam_map.keyframes[-1]
    ids = newest.ids[slam_map.located[newest.ids]]
    return float(np.median(to_frame(newest.world_T_camera, slam_map.points[ids])[:, 2]))


def _edges(slam_map: SlamMap, rows: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Neighbours in time, and keyframes that share many points: positions, and how many points."""
    from scipy.sparse import coo_matrix

    owner, ids, _, _ = slam_map.observations(rows)
    shape = len(rows), len(slam_map.alive)
    seen: Any = coo_matrix((np.ones(len(ids), dtype=np.int64), (owner, ids)), shape=shape).tocsr()
    shared = (seen @ seen.T).toarray()
    a, b = np.triu_indices(len(rows), 1)
    count = shared[a, b]
    edge = (b == a + 1) | (count >= _EDGE_SHARED)
    return a[edge], b[edge], np.maximum(count[edge], 1)


_STOP = Stop(steps=30, gain=1e-6, damping=1e-6, what="closing the loop")


@dataclass(frozen=True, eq=False)
class PoseGraph:
    """What is known of relative poses.

    Args:
        a, b: ``(e,)`` the nodes that each edge joins.
        a_S_b: Similarity ``(e,)``, the pose of b from a.
        sigma: ``(e, 7)`` its noise: rotation (rad), translation, logarithm of the scale.
        fixed: ``(k,)`` nodes that stay.
        rigid: whether all nodes keep their scale.
    """

    a: IntArray
    b: IntArray
    a_S_b: Similarity
    sigma: FloatArray
    fixed: BoolArray
    rigid: bool

    @property
    def width(self) -> int:
        """Numbers a node has."""
        return 6 if self.rigid else 7

    def relaxed(self, world_S: Similarity) -> Similarity:
        """The nodes Similarity ``(k,)`` that fit best, from nodes that are near.

        >>> import numpy as np
        >>> from motorcade.ga import Motor, Similarity
        >>> from motorcade.tracking.slam.mapping.loops import PoseGraph
        >>> step = Similarity.from_motor_scale(Motor.from_translation([1.0, 0.0, 0.0]))
        >>> back = Similarity.from_motor_scale(Motor.from_translation([-1.7, 0.0, 0.0]))
        >>> edges = Similarity.stack([step, step, back])
        >>> first = np.array([True, False, False])
        >>> rows = np.array([0, 1, 2]), np.array([1, 2, 0])
        >>> graph = PoseGraph(*rows, edges, np.full((3, 7), 0.1), first, rigid=True)
        >>> odometry = Similarity.stack([Similarity.identity(), step, step @ step])
        >>> graph.relaxed(odometry).translation_m[:, 0].round(6)  # 0.3 spread over three edges
        array([0. , 0.9, 1.8])
        """
        minimum = minimise(world_S, partial(_Edges, self), self._retract, _STOP)
        return minimum.state

    def _retract(self, world_S: Similarity, step: FloatArray) -> Similarity:
        twist = np.zeros((len(self.fixed), 7))
        twist[~self.fixed, : self.width] = step
        return world_S.retract(twist)


class _Edges:
    """All edges against the nodes as they are."""

    def __init__(self, graph: PoseGraph, world_S: Similarity) -> None:
        self._graph = graph
        self._between = world_S[graph.a].inverse() @ world_S[graph.b]
        self._residual = graph.a_S_b.local(self._between)
        self._weighed = self._residual[:, : graph.width] / graph.sigma[:, : graph.width]
        self.cost = 0.5 * float(np.sum(self._weighed**2))

    @cached_property
    def equations(self) -> SparseEquations:
        """Normal equations of the free nodes."""
        graph, width = self._graph, self._graph.width
        by_b = Similarity.right_jacobian_inverse(self._residual)
        by_a = -by_b @ self._between.inverse().adjoint()
        scale = 1.0 / graph.sigma[:, :width, None]
        ends = [
            (node, ~graph.fixed[node], scale * jacobian[:, :width, :width])
            for node, jacobian in ((graph.a, by_a), (graph.b, by_b))
        ]
        slot = np.cumsum(~graph.fixed) - 1
        gradient = np.zeros((int(np.count_nonzero(~graph.fixed)), width))
        rows, columns, blocks = [], [], []
        for node, free, derivative in ends:
            left = derivative.swapaxes(-1, -2)
            pull = (left @ self._weighed[..., None])[..., 0]
            gradient += sum_by(pull[free], slot[node[free]], len(gradient))
            for other, other_free, by_other in ends:
                both = free & other_free
                rows.append(slot[node[both]])
                columns.append(slot[other[both]])
                blocks.append(left[both] @ by_other[both])
        index = PairIndex(np.concatenate(rows), np.concatenate(columns))
        return SparseEquations(
            index.rows, index.columns, index.sums(np.concatenate(blocks)), gradient
        )
