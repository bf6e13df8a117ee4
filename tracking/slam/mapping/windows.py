"""Which keyframes and points are adjusted together."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.tracking.slam.mapping.map import SlamMap


def connected(slam_map: SlamMap, rows: IntArray, fewest: int) -> IntArray:
    """Those keyframes that the last of `rows` is tied to by points, directly or by others.

    Args:
        slam_map: the map.
        rows: of keyframes, rising.
        fewest: points that tie a keyframe to the others.
    """
    tied = np.zeros(len(slam_map.alive), dtype=np.bool_)
    tied[slam_map.keyframes[rows[-1]].ids] = True
    kept = [rows[-1]]
    for row in rows[-2::-1]:
        ids = slam_map.keyframes[row].ids
        if np.count_nonzero(tied[ids]) >= fewest:
            tied[ids] = True
            kept.append(row)
    return np.array(kept[::-1], dtype=np.int64)


def points_seen(slam_map: SlamMap, rows: IntArray) -> IntArray:
    """Numbers of the located points that some keyframes see."""
    seen = np.unique(slam_map.observations(rows)[1])
    return seen[slam_map.located[seen]]


def held_by(slam_map: SlamMap, rows: IntArray, points: IntArray) -> IntArray:
    """Points but for those that one keyframe of `rows` sees and that others elsewhere hold.

    Such a point would follow the one, and then count as seen by too few.
    """
    count = len(slam_map.alive)
    _, ids, _, depth = slam_map.observations(rows)
    here = np.bincount(ids, 1.0 + np.isfinite(depth), count)
    every = slam_map.observations(slam_map.keyframe_rows)[1]
    elsewhere = np.bincount(every, minlength=count) - np.bincount(ids, minlength=count)
    held: IntArray = points[(here[points] >= 2.0) | (elsewhere[points] == 0)]
    return held


def windows_along(rows: IntArray, old: int, size: int) -> list[tuple[IntArray, IntArray]]:
    """Windows of keyframes to adjust after a loop, with those that each may be held by.

    They overlap by half, from the newest keyframe back to the old one. The first is held by the old
    pass alone, which draws it there; the others carry that on.

    Args:
        rows: of the map's keyframes, rising.
        old: the row that was recognised.
        size: of a window.
    """
    first = max(int(np.searchsorted(rows, old)) - size, 1)  # the map's first one stays
    stops = range(len(rows), first, -(size // 2))
    free = [rows[max(stop - size, first) : stop] for stop in stops]
    holders = [rows[: max(len(rows) - 2 * size, 1)], *[rows] * len(free)]
    return list(zip(free, holders, strict=False))
