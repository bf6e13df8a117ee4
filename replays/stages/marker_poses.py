"""Camera poses by loose markers: corners found or recorded, mapped together, tracked by the map."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motorcade.fusion.filter.extended_pose import motor_adjoint
from motorcade.ga import FloatArray, IntArray, Motor
from motorcade.replays.loose_markers import LooseMarkers
from motorcade.replays.progress import track
from motorcade.replays.readers.corner_frames import CornerFrames
from motorcade.replays.recording import Recording
from motorcade.tracking import Detection, PoseMeasurements, TrackingError, detect_markers
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.mapping import MappedRecording, map_markers, track_rig
from motorcade.tracking.markers.marker_map import MarkerMap

__all__ = ["MarkerPoses", "corners_found", "marker_poses"]

_ONLY = "camera"
# A camera's own noise floor: a map is never more certain than its lens and its print.
_SIGMA_FLOOR = np.repeat([1e-4, 1e-4], 3)


@dataclass(frozen=True, eq=False)
class MarkerPoses:
    """What markers measured.

    Args:
        measurements: `world_T_camera` of the frames that show a marker of the map.
        sought_ns: stamps of all frames.
        error_px: ``(N,)`` root mean square reprojection error of each measured frame.
        marker_map: where the markers stand.
        left_out: markers that were seen, but never together with one of the map.
        seconds: time it took, reading and decoding included.
    """

    measurements: PoseMeasurements
    sought_ns: IntArray
    error_px: FloatArray
    marker_map: MarkerMap
    left_out: tuple[int, ...]
    seconds: float


def marker_poses(recording: Recording) -> MarkerPoses:
    """Map the markers of a recording, unless their map is known, and track its camera by them.

    The world is the map's; of a map made here, the frame of the marker seen most.

    Raises:
        ValueError: neither recorded corners nor a family to look for, or no camera.
        TrackingError: no marker seen.
    """
    start = time.perf_counter()
    frames, markers = recording.frames, recording.markers
    known = None if markers is None else markers.marker_map
    if isinstance(frames, CornerFrames):
        first = next(iter(frames.streams))
        found = _mapped(frames.streams, frames.side_m, frames.rig_T_camera, known)
    else:
        first = _ONLY
        stream = corners_found(recording, _family(recording))
        side_m = dict.fromkeys(np.unique(stream.marker_ids).tolist(), _family(recording).side_m)
        found = _mapped({_ONLY: stream}, side_m, {_ONLY: Motor.identity()}, known)
    rig_T_camera = found.rig_T_camera[first]
    path = found.trajectory.transformed_by(right=rig_T_camera, child="camera")
    adjoint = motor_adjoint(rig_T_camera.inverse())
    covariance = adjoint @ found.covariance @ adjoint.T + np.diag(_SIGMA_FLOOR**2)
    return MarkerPoses(
        PoseMeasurements(path, 0.5 * (covariance + covariance.swapaxes(-1, -2))),
        found.time_ns,
        found.frame_error_px,
        found.marker_map,
        found.left_out,
        time.perf_counter() - start,
    )


def corners_found(recording: Recording, markers: LooseMarkers) -> CornerStream:
    """Detect the markers of every picture.

    Where a frame has sharp corners the others are left out; so is an id that stands there twice,
    since no map can tell its copies apart.

    Raises:
        ValueError: no camera.
    """
    camera = recording.camera
    if camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    rows, ids, corners = [], [], []
    frames = recording.frames
    for row, frame in enumerate(track(frames, "detecting", len(frames))):
        for one in _usable(detect_markers(frame.gray(), markers.family, camera)):
            rows.append(row)
            ids.append(one.marker_id)
            corners.append(one.corners_px)
    return CornerStream(
        camera,
        frames.time_ns,
        np.array(rows, np.int64),
        np.array(ids, np.int64),
        np.array(corners, np.float64).reshape(-1, 4, 2),
    )


def _usable(found: tuple[Detection, ...]) -> list[Detection]:
    ids = [one.marker_id for one in found]
    once = [one for one in found if ids.count(one.marker_id) == 1]
    return [one for one in once if one.sharp] or once


def _family(recording: Recording) -> LooseMarkers:
    if recording.markers is None:
        raise ValueError(
            f"{recording.name}: no markers to look for; name their family in a manifest ([markers])"
        )
    return recording.markers


def _mapped(
    streams: Mapping[str, CornerStream],
    side_m: Mapping[int, float],
    rig_T_camera: Mapping[str, Motor],
    known: MarkerMap | None,
) -> MappedRecording:
    if not any(len(stream) for stream in streams.values()):
        raise TrackingError("frames: expected some that show a marker, got none")
    if known is not None:
        return track_rig(known, streams, rig_T_camera)
    return map_markers(streams, side_m, rig_T_camera)
