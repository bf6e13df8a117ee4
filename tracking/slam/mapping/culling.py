"""Keyframes that show nothing which others do not show as well leave the map.

A map then grows with what the camera has seen, not with how long it has looked. Frames that were
told by such a keyframe hang on its neighbour from then on.

Source: Mur-Artal & Tardos 2017 (ORB-SLAM2): 90 % of the points seen by three others at the same or
a finer scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor
from motorcade.tracking.slam.mapping.map import SlamMap

_OTHERS = 3
_SHARE = 0.9
_COARSER = 1.2  # an octave of the pyramid there, and how much farther away counts as the same scale
# Frames are as rigid with a keyframe as it is near; inertial samples are summed up over no more.
_LONGEST_GAP_NS = 500_000_000


@dataclass(frozen=True, eq=False)
class CulledKeyframe:
    """A keyframe that left the map.

    Args:
        row: its row; kept: that of the neighbour which stands for it.
        kept_T_culled: its pose from there.
        scale, kept_scale: `Keyframe.scale` of both at that moment.
    """

    row: int
    kept: int
    kept_T_culled: Motor
    scale: float
    kept_scale: float


def is_redundant(slam_map: SlamMap, row: int) -> bool:
    """Whether almost all points that a keyframe sees are seen by enough others as well as by it."""
    keyframe = slam_map.keyframes[row]
    ids = keyframe.ids[slam_map.located[keyframe.ids]]
    if not len(ids):
        return False
    points, place = slam_map.points[ids], np.full(len(slam_map.alive), -1)
    place[ids] = np.arange(len(ids))
    apart_m = np.linalg.norm(points - keyframe.world_T_camera.translation_m, axis=1)
    seen = np.zeros(len(ids), dtype=np.int64)
    for other in slam_map.rows_of(keyframe.map_number):
        mine = place[slam_map.keyframes[other].ids]
        mine = mine[mine >= 0]
        if other == row or not len(mine):
            continue
        from_m = slam_map.keyframes[other].world_T_camera.translation_m
        seen[mine] += np.linalg.norm(points[mine] - from_m, axis=1) <= _COARSER * apart_m[mine]
    return bool(np.mean(seen >= _OTHERS) >= _SHARE)


def cull(slam_map: SlamMap, row: int) -> CulledKeyframe | None:
    """Take a keyframe out of its map if it is redundant there; a map's first and last one stay.

    It stays where it would leave its neighbours far apart in time, and beside keyframes of a stored
    map, whose stamps are of another clock.
    """
    keyframe = slam_map.keyframes[row]
    mine = slam_map.rows_of(keyframe.map_number)
    position = int(np.searchsorted(mine, row))
    if not 0 < position < len(mine) - 1:
        return None
    before, after = (int(mine[position + step]) for step in (-1, 1))
    gap_ns = slam_map.keyframes[after].time_ns - slam_map.keyframes[before].time_ns
    if before < slam_map.stored_count or not 0 < gap_ns <= _LONGEST_GAP_NS:
        return None
    if not is_redundant(slam_map, row):
        return None
    kept = slam_map.keyframes[before]
    relative = kept.world_T_camera.inverse() @ keyframe.world_T_camera
    slam_map.remove_keyframe(row)
    return CulledKeyframe(row, before, relative, keyframe.scale, kept.scale)
