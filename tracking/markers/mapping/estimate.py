"""A map of markers from a recording alone, and rigs tracked by a map.

The world is the frame of the marker that was seen most; what cannot be hung on it is left out.

An adjustment starts from pairs of markers seen together. Markers seen in one frame stand to each
other as their chosen poses say. Each pair's motion is the one that most of its frames agree with;
the pairs form a graph, and the tree of its surest pairs (Prim 1957) hangs all markers on the one
seen most.

Markers that do not stand still beside the others, found by what the others see without them.

One marker that moves bends the map and the path, and its own corners need not be missed the most.
So where a map misses corners by more than they can scatter, each marker in turn is left out, and
the map made anew of a few frames: the one without which all others agree best is left aside, until
the rest do agree. Where no such rest is left, nothing is said.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.progress import track
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import MarkerObservations
from motorcade.tracking.markers.mapping.adjust import (
    AdjustedRig,
    adjust,
    pose_covariance,
    residuals_px,
)
from motorcade.tracking.markers.mapping.rig import RigObservations, agreed, gather
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.pose import SIGMA_FLOOR_PX, TrackingError

# Two observations of a pair agree within this share of the markers' distance, or of a side.
_AGREE_SHARE = 0.1
_SYNC_S = 0.05


def hang_markers(seen: RigObservations) -> tuple[Motor, NDArray[np.bool_]]:
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
    seen: RigObservations, world_T_marker: Motor, known: NDArray[np.bool_]
) -> tuple[Motor, NDArray[np.bool_]]:
    """Pose of the rig in every frame that shows a known marker.

    Of the poses that its markers propose, the one that reprojects all corners of the frame best
    (median over its observations, so that one wrong marker does not decide).

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


def _error_px(frame: RigObservations, world_T_rig: Motor, world_T_marker: Motor) -> float:
    everywhere = Motor.stack([world_T_rig] * len(frame))
    residuals = residuals_px(frame, everywhere, world_T_marker[frame.marker])
    errors: FloatArray = np.sqrt(np.mean(np.sum(residuals**2, axis=-1), axis=-1))
    return float(np.median(np.nan_to_num(errors, nan=np.inf)))


def _pairs(seen: RigObservations) -> dict[tuple[int, int], tuple[Motor, float]]:
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
    for key, row_pairs in together.items():
        a, b = np.array(row_pairs).T
        pairs[key] = _motion(seen, rig_T_marker, a, b)
    return pairs


def _motion(
    seen: RigObservations, rig_T_marker: Motor, a: IntArray, b: IntArray
) -> tuple[Motor, float]:
    motions = rig_T_marker[a].inverse() @ rig_T_marker[b]
    side_m = np.maximum(seen.side_m[seen.marker[a]], seen.side_m[seen.marker[b]])
    reach_m = np.maximum(np.linalg.norm(motions.translation_m, axis=-1), side_m)
    return agreed(motions, seen.probability[a] * seen.probability[b], _AGREE_SHARE * reach_m)


@dataclass(frozen=True, eq=False)
class MappedRecording:
    """Where markers and rig were.

    Args:
        marker_map: the markers.
        trajectory: ``world_T_rig`` of the n frames that show a marker of the map.
        covariance: ``(n, 6, 6)`` of these poses beside each other, right perturbation, rotation
            (rad) then translation (m), how unsure the map's shape is with it. That a planar pose
            may be the wrong one is not in it.
        frame_error_px: ``(n,)`` root mean square reprojection error of each of these frames.
        rig_T_camera: by camera; those that were not given are estimated.
        time_ns: ``(F,)`` stamps of all frames.
        error_px: ``(N,)`` root mean square reprojection errors of all observations that took part.
        left_out: ids that were seen, but never beside a marker of the map.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.tracking import MarkerMap
    >>> from motorcade.tracking.markers.mapping import MappedRecording
    >>> room = MarkerMap([4], [0.1], Motor.identity((1,)).rotor, [[0.0, 0.0, 0.0]])
    >>> time_ns = np.array([0, 50_000_000, 100_000_000])
    >>> world_T_rig = Motor.from_translation([[0.0, 0.0, 0.5], [0.1, 0.0, 0.5]])
    >>> path, covariance = Trajectory(time_ns[:2], world_T_rig), np.stack([1e-6 * np.eye(6)] * 2)
    >>> mapped = MappedRecording(room, path, covariance, np.array([0.1, 0.2]),
    ...     {"camera": Motor.identity()}, time_ns, np.array([0.1, 0.2]), left_out=(9,))
    >>> len(mapped.trajectory), len(mapped.time_ns)  # the last frame shows no marker of the map
    (2, 3)
    """

    marker_map: MarkerMap
    trajectory: Trajectory
    covariance: FloatArray
    frame_error_px: FloatArray
    rig_T_camera: Mapping[str, Motor]
    time_ns: IntArray
    error_px: FloatArray
    left_out: tuple[int, ...]


def map_markers(
    streams: Mapping[str, CornerStream],
    side_m: Mapping[int, float],
    rig_T_camera: Mapping[str, Motor] | None = None,
    *,
    sync_s: float = _SYNC_S,
    over_time: bool = True,
    posed: Mapping[str, MarkerObservations] | None = None,
    floor_px: float = SIGMA_FLOOR_PX,
    most_px: float = np.inf,
) -> MappedRecording:
    """Estimate where markers stand and where the rig was, from corners alone.

    Planar poses are resolved over time for each camera; pairs of markers seen together hang into a
    first map; a bundle adjustment refines everything. Markers must not move.

    Args:
        streams: by camera, at least one.
        side_m: side of each marker's black square, metres, by id: they give the scale.
        rig_T_camera: of the cameras whose place on the rig is known, at least one; None puts the
            rig into the first camera.
        sync_s: stamps of different cameras that are so near count as one frame.
        over_time: resolve planar poses over time; False shows what that is worth.
        posed: by camera, both planar poses of its detections where they were refined beyond what
            corners tell (see `photometric`).
        floor_px: noise of a corner a coordinate that there is at least.
        most_px: how far a marker's corners can lie off, root mean square; what lies farther hardly
            counts.

    Raises:
        ValueError: no streams, no camera with a known place, a marker without a size.
        TrackingError: nothing seen, or a camera that never sees a marker together with others.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera, map_markers, track_rig
    >>> from motorcade.tracking.markers.corner_stream import CornerStream
    >>> from motorcade.tracking.markers.families import marker_points_m
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> turn = Rotor.from_rotation_vector([[np.pi - 0.4, 0.0, 0.0], [np.pi, 0.4, 0.0]])
    >>> camera_T_world = Motor.from_rotor_translation(turn, [[-0.1, 0.0, 0.6], [-0.2, 0.0, 0.5]])
    >>> marker = Motor.from_rotor_translation(Rotor.identity(), [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
    >>> frame, which = [0, 0, 1, 1], [0, 1, 0, 1]  # two markers in both of two images
    >>> points = (camera_T_world[frame] @ marker[which])[:, None].apply(marker_points_m(0.1))
    >>> stamps, ids = [0, 100_000_000], [3, 8, 3, 8]
    >>> stream = CornerStream(camera, stamps, frame, ids, camera.project(points))
    >>> found = map_markers({"camera": stream}, side_m={3: 0.1, 8: 0.1})
    >>> world_T_marker = found.marker_map.world_T_marker  # the world is the first marker
    >>> world_T_marker[1].translation_m.round(3) + 0.0
    array([0.2, 0. , 0. ])
    >>> len(track_rig(found.marker_map, {"camera": stream}).trajectory)
    2
    """
    if not streams:
        raise ValueError("streams: expected at least one camera, got none")
    known = {next(iter(streams)): Motor.identity()} if rig_T_camera is None else rig_T_camera
    seen = gather(streams, known, side_m, sync_s, over_time, posed)
    if len(seen) == 0:
        raise TrackingError("streams: expected markers, got none")
    world_T_marker, reached = hang_markers(seen)
    world_T_rig, placed = place_frames(seen, world_T_marker, reached)
    held = np.arange(len(reached)) == np.argmax(np.bincount(seen.marker))
    result = adjust(_part(seen, reached), world_T_rig, world_T_marker, held, floor_px, most_px)
    poses = result.world_T_marker[reached]
    marker_map = MarkerMap(
        seen.marker_ids[reached], seen.side_m[reached], poses.rotor, poses.translation_m
    )
    return _mapped(marker_map, result, held, placed, list(streams), seen.marker_ids[~reached])


def track_rig(
    marker_map: MarkerMap,
    streams: Mapping[str, CornerStream],
    rig_T_camera: Mapping[str, Motor] | None = None,
    *,
    sync_s: float = _SYNC_S,
    floor_px: float = SIGMA_FLOOR_PX,
    most_px: float = np.inf,
) -> MappedRecording:
    """Where a rig was, by a map that stands; markers that are not in it are passed over.

    Args:
        marker_map: the markers, which stay where they are.
        streams: by camera, at least one.
        rig_T_camera: see `map_markers`.
        sync_s: see `map_markers`.
        floor_px: see `map_markers`.
        most_px: see `map_markers`.

    Raises:
        ValueError: no streams, no camera with a known place.
        TrackingError: no marker of the map seen.
    """
    if not streams:
        raise ValueError("streams: expected at least one camera, got none")
    known = {next(iter(streams)): Motor.identity()} if rig_T_camera is None else rig_T_camera
    mapped = {name: _of_map(stream, marker_map) for name, stream in streams.items()}
    seen = gather(mapped, known, marker_map.sides, sync_s)
    if len(seen) == 0:
        raise TrackingError("streams: expected markers of the map, got none")
    rows = np.searchsorted(marker_map.marker_ids, seen.marker_ids)
    world_T_marker = marker_map.world_T_marker[rows]
    everywhere = np.ones(len(rows), dtype=bool)
    world_T_rig, placed = place_frames(seen, world_T_marker, everywhere)
    result = adjust(seen, world_T_rig, world_T_marker, everywhere, floor_px, most_px)
    return _mapped(marker_map, result, everywhere, placed, list(streams), np.zeros(0, np.int64))


def _part(seen: RigObservations, reached: NDArray[np.bool_]) -> RigObservations:
    return seen.only(np.flatnonzero(reached[seen.marker]))


def _of_map(stream: CornerStream, marker_map: MarkerMap) -> CornerStream:
    own = np.isin(stream.marker_ids, marker_map.marker_ids)
    return replace(
        stream,
        frame=stream.frame[own],
        marker_ids=stream.marker_ids[own],
        corners_px=stream.corners_px[own],
    )


def _mapped(
    marker_map: MarkerMap,
    result: AdjustedRig,
    held: NDArray[np.bool_],
    placed: NDArray[np.bool_],
    names: list[str],
    left_out: IntArray,
) -> MappedRecording:
    stamps = result.seen.time_ns
    return MappedRecording(
        marker_map,
        Trajectory(stamps[placed], result.world_T_rig[placed], "world", "rig"),
        pose_covariance(result, held)[placed],
        _frame_error_px(result)[placed],
        {name: result.seen.rig_T_camera[which] for which, name in enumerate(names)},
        stamps,
        result.error_px,
        tuple(left_out.tolist()),
    )


def _frame_error_px(result: AdjustedRig) -> FloatArray:
    """Of every frame ``(F,)``; 0 where nothing is seen."""
    count = len(result.seen.time_ns)
    squares = np.bincount(result.seen.frame, result.error_px**2, minlength=count)
    seen = np.bincount(result.seen.frame, minlength=count)
    return np.asarray(np.sqrt(squares / np.maximum(seen, 1)))


Streams = Mapping[str, CornerStream]
Remap = Callable[[Streams], MappedRecording]
_FRAMES = 40
"""That trial maps are made of, evenly over the recording."""
_CANDIDATES = 8
"""Markers whose corners are missed the most, that are tried in turn."""
_SHARE = 0.9
"""Of the frames, that must agree."""


def moving_markers(
    streams: Streams,
    mapped: MappedRecording,
    remap: Remap,
    limit_px: float,
) -> tuple[int, ...]:
    """Ids of the markers without which all others stand still; none where all do, or none would.

    Args:
        streams: what was seen, by camera.
        mapped: the map of all of it.
        remap: maps part of it.
        limit_px: by how much corners may be missed, root mean square over a frame.

    Breaks down where more than half of the markers move, or half of them together.
    """
    if _missed_px(mapped.frame_error_px) <= limit_px:
        return ()
    few = {name: _thinned(stream) for name, stream in streams.items()}
    left, moving = mapped.marker_map.marker_ids.tolist(), list[int]()
    most = min(len(left) // 2, len(left) - 2)
    while len(moving) < most:
        others = without(few, moving)
        worst = _worst(others, remap)
        errors = {
            tried: _trial_px(without(others, [tried]), remap)
            for tried in track(worst, "leaving markers out", len(worst))
        }
        best = min(errors, key=lambda tried: errors[tried], default=None)
        if best is None:
            return ()
        moving.append(best)
        if errors[best] <= limit_px:
            aside = without(few, [marker for marker in left if marker not in moving])
            half = 2 * len(moving) == len(left)
            return () if half and _trial_px(aside, remap) <= limit_px else tuple(sorted(moving))
    return ()


def without(streams: Streams, markers: Sequence[int]) -> dict[str, CornerStream]:
    """What was seen of other markers."""
    return {
        name: stream.where(~np.isin(stream.marker_ids, np.array(markers, dtype=np.int64)))
        for name, stream in streams.items()
    }


def _thinned(stream: CornerStream) -> CornerStream:
    """Of the frames that show markers, some, evenly spread."""
    frames = np.unique(stream.frame)
    chosen = frames[np.unique(np.linspace(0, len(frames) - 1, _FRAMES).astype(int))]
    return stream.where(np.isin(stream.frame, chosen)) if len(frames) else stream


def _worst(seen: Streams, remap: Remap) -> list[int]:
    """Markers of the map whose corners are missed the most."""
    try:
        mapped = remap(seen)
    except TrackingError:
        return []
    known, path = mapped.marker_map, mapped.trajectory
    missed: dict[int, list[float]] = {marker: [] for marker in known.marker_ids.tolist()}
    if len(missed) <= _CANDIDATES:
        return sorted(missed)
    for name, stream in seen.items():
        rows = np.searchsorted(path.time_ns, stream.time_ns[stream.frame])
        rows = np.minimum(rows, len(path) - 1)
        world_T_camera = path.motors[rows] @ mapped.rig_T_camera[name]
        places = np.searchsorted(known.marker_ids, stream.marker_ids)
        points = known.points_m.reshape(-1, 4, 3)[np.minimum(places, len(missed) - 1)]
        px = stream.camera.project(world_T_camera.inverse()[:, None].apply(points))
        off = np.linalg.norm(px - stream.corners_px, axis=-1).mean(axis=-1)
        for marker, error in zip(stream.marker_ids.tolist(), off.tolist(), strict=True):
            if marker in missed and np.isfinite(error):
                missed[marker].append(error)
    order = sorted(missed, key=lambda marker: -float(np.median(missed[marker] or [0.0])))
    return order[:_CANDIDATES]


def _trial_px(seen: Streams, remap: Remap) -> float:
    try:
        return _missed_px(remap(seen).frame_error_px)
    except TrackingError:
        return np.inf


def _missed_px(frame_error_px: FloatArray) -> float:
    return float(np.quantile(frame_error_px, _SHARE)) if len(frame_error_px) else np.inf
