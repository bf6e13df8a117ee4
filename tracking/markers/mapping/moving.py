"""Markers that do not stand still beside the others, found by what the others see without them.

One marker that moves bends the map and the path, and its own corners need not be missed the most.
So where a map misses corners by more than they can scatter, each marker in turn is left out, and
the map made anew of a few frames: the one without which all others agree best is left aside, until
the rest do agree. Where no such rest is left, nothing is said.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.mapping.estimate import MappedRecording
from motorcade.tracking.pose import TrackingError

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
        errors = {
            tried: _error_px(without(others, [tried]), remap) for tried in _worst(others, remap)
        }
        best = min(errors, key=lambda tried: errors[tried], default=None)
        if best is None:
            return ()
        moving.append(best)
        if errors[best] <= limit_px:
            aside = without(few, [marker for marker in left if marker not in moving])
            half = 2 * len(moving) == len(left)
            return () if half and _error_px(aside, remap) <= limit_px else tuple(sorted(moving))
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


def _error_px(seen: Streams, remap: Remap) -> float:
    try:
        return _missed_px(remap(seen).frame_error_px)
    except TrackingError:
        return np.inf


def _missed_px(frame_error_px: FloatArray) -> float:
    return float(np.quantile(frame_error_px, _SHARE)) if len(frame_error_px) else np.inf
