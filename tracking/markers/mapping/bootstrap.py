"""A first map from pairs of markers seen together, good enough for an adjustment to start from.

Markers seen in one frame stand to each other as their chosen poses say. Each pair's motion is the
one that most of its frames agree with; the pairs form a graph, and the tree of its surest pairs
(Prim 1957) hangs all markers on the one seen most.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.mapping.adjust import residuals_px
from motorcade.tracking.markers.mapping.rig import RigSightings, agreed

__all__ = ["hang_markers", "place_frames"]

# Two sightings of a pair agree within this share of the distance between the markers, or of a side.
_AGREE_SHARE = 0.1


def hang_markers(seen: RigSightings) -> tuple[Motor, NDArray[np.bool_]]:
    """Pose of every marker in the frame of the marker seen most.

    Returns:
        Motor ``(M,)``, and ``(M,)``: which of them hang together with that marker. The others were
        never seen beside one that does; their poses are the identity.
    """
    count = len(seen.marker_ids)
    pairs = _pairs(seen)
    reached = np.zeros(count, dtype=bool)
    poses = [Motor.identity()] * count
    reached[int(np.argmax(np.bincount(seen.marker, minlength=count)))] = True
    while True:
        open_pairs = [key for key in pairs if reached[key[0]] and not reached[key[1]]]
        if not open_pairs:
            return Motor.stack(poses), reached
        a, b = max(open_pairs, key=lambda key: (pairs[key][1], key))
        poses[b] = poses[a] @ pairs[a, b][0]
        reached[b] = True


def place_frames(
    seen: RigSightings, world_T_marker: Motor, known: NDArray[np.bool_]
) -> tuple[Motor, NDArray[np.bool_]]:
    """Pose of the rig in every frame that shows a known marker.

    Of the poses that its markers propose, the one that reprojects all corners of the frame best
    (median over its sightings, so that one wrong marker does not decide).

    Returns:
        Motor ``(F,)``, identity where none is known, and ``(F,)``: where one is.
    """
    count = len(seen.time_ns)
    poses = [Motor.identity()] * count
    placed = np.zeros(count, dtype=bool)
    proposed = world_T_marker[seen.marker] @ seen.rig_T_marker.inverse()
    usable = np.flatnonzero(known[seen.marker])
    for frame in np.unique(seen.frame[usable]):
        rows = usable[seen.frame[usable] == frame]
        errors = [_error_px(seen.only(rows), proposed[row], world_T_marker) for row in rows]
        poses[frame] = proposed[rows[int(np.argmin(errors))]]
        placed[frame] = True
    return Motor.stack(poses), placed


def _error_px(frame: RigSightings, world_T_rig: Motor, world_T_marker: Motor) -> float:
    everywhere = Motor.stack([world_T_rig] * len(frame))
    residuals = residuals_px(frame, everywhere, world_T_marker[frame.marker])
    errors: FloatArray = np.sqrt(np.mean(np.sum(residuals**2, axis=-1), axis=-1))
    return float(np.median(np.nan_to_num(errors, nan=np.inf)))


def _pairs(seen: RigSightings) -> dict[tuple[int, int], tuple[Motor, float]]:
    """Motion from each marker to another one seen with it, and how much weight agrees on it."""
    together: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for frame in np.unique(seen.frame):
        rows = np.flatnonzero(seen.frame == frame).tolist()
        for i in rows:
            for j in rows:
                key = int(seen.marker[i]), int(seen.marker[j])
                if key[0] != key[1]:
                    together.setdefault(key, []).append((i, j))
    rig_T_marker = seen.rig_T_marker
    pairs = {}
    for key, found in together.items():
        a, b = np.array(found).T
        pairs[key] = _motion(seen, rig_T_marker, a, b)
    return pairs


def _motion(
    seen: RigSightings, rig_T_marker: Motor, a: IntArray, b: IntArray
) -> tuple[Motor, float]:
    motions = rig_T_marker[a].inverse() @ rig_T_marker[b]
    side_m = np.maximum(seen.side_m[seen.marker[a]], seen.side_m[seen.marker[b]])
    reach_m = np.maximum(np.linalg.norm(motions.translation_m, axis=-1), side_m)
    return agreed(motions, seen.probability[a] * seen.probability[b], _AGREE_SHARE * reach_m)
