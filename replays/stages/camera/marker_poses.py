"""Camera poses by loose markers: corners found or recorded, mapped together, tracked by the map."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from motorcade.ga import FloatArray, IntArray, Motor
from motorcade.replays.engine.graph import Unavailable
from motorcade.replays.engine.progress import track
from motorcade.replays.markers.loose import LooseMarkers
from motorcade.replays.readers.frames.corners import CornerFrames
from motorcade.replays.recording import Recording
from motorcade.tracking import Detection, PoseMeasurements, TrackingError, detect_markers
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import Sightings
from motorcade.tracking.markers.mapping import MappedRecording, map_markers, track_rig
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.markers.photometric import (
    PhotometricUnavailable,
    RefinedFrame,
    joined_frames,
    refine_frame,
)

__all__ = ["MarkerPoses", "Refine", "marker_poses", "markers_found"]

Refine = Literal["none", "photometric"]
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


def marker_poses(
    recording: Recording, refine: Refine = "none", moving: tuple[int, ...] = ()
) -> MarkerPoses:
    """Map the markers of a recording, unless their map is known, and track its camera by them.

    The world is the map's; of a map made here, the frame of the marker seen most. Markers that are
    `moving` are left out.

    Raises:
        ValueError: neither recorded corners nor a family to look for, no camera, or refinement
            where there are no pictures or some markers move.
        TrackingError: no marker seen.
        Unavailable: refinement without torch and kornia.
    """
    if refine != "none" and moving:
        raise ValueError(f"{recording.name}: refine={refine} takes all markers, came {moving=}")
    start = time.perf_counter()
    frames, markers = recording.frames, recording.markers
    known = None if markers is None else markers.marker_map
    posed = None
    if isinstance(frames, CornerFrames):
        if refine != "none":
            raise ValueError(f"{recording.name}: refine={refine} needs pictures, came corners")
        first, streams = next(iter(frames.streams)), frames.streams
        side_m, rig_T_camera = frames.side_m, frames.rig_T_camera
    else:
        first, loose = _ONLY, _named(recording)
        stream, sightings = markers_found(recording, loose, refine)
        streams, rig_T_camera = {_ONLY: stream}, {_ONLY: Motor.identity()}
        side_m = dict.fromkeys(np.unique(stream.marker_ids).tolist(), loose.side_m)
        posed = None if sightings is None else {_ONLY: sightings}
    streams = {name: _standing(stream, moving) for name, stream in streams.items()}
    if not any(len(stream) for stream in streams.values()):
        raise TrackingError("frames: expected some that show a marker, got none")
    found = (
        map_markers(streams, side_m, rig_T_camera, posed=posed)
        if known is None
        else track_rig(known, streams, rig_T_camera)
    )
    return _of_camera(found, first, time.perf_counter() - start)


def _of_camera(found: MappedRecording, camera: str, seconds: float) -> MarkerPoses:
    """The rig's path and covariance, carried over to one of its cameras."""
    rig_T_camera = found.rig_T_camera[camera]
    adjoint = rig_T_camera.inverse().adjoint()
    covariance = adjoint @ found.covariance @ adjoint.T + np.diag(_SIGMA_FLOOR**2)
    return MarkerPoses(
        PoseMeasurements(
            found.trajectory.transformed_by(right=rig_T_camera, child="camera"),
            0.5 * (covariance + covariance.swapaxes(-1, -2)),
        ),
        found.time_ns,
        found.frame_error_px,
        found.marker_map,
        found.left_out,
        seconds,
    )


def markers_found(
    recording: Recording, markers: LooseMarkers, refine: Refine = "none"
) -> tuple[CornerStream, Sightings | None]:
    """Detect the markers of every picture; with refinement, both their poses as well.

    Where a frame has sharp corners the others are left out; so is an id that stands there twice,
    since no map can tell its copies apart.

    Raises:
        ValueError: no camera.
        Unavailable: refinement without torch and kornia.
    """
    camera = recording.camera
    if camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    frames, family = recording.frames, markers.family
    ids, corners, refined = [], [], []
    for frame in track(frames, "detecting", len(frames)):
        gray = frame.gray()
        found = _usable(detect_markers(gray, family, camera))
        ids.append(np.array([one.marker_id for one in found], np.int64))
        corners.append(np.array([one.corners_px for one in found]).reshape(-1, 4, 2))
        if refine == "photometric":
            sides = np.full(len(found), markers.side_m)
            refined.append(_refined(gray, camera, family, ids[-1], corners[-1], sides))
    if refine == "photometric":
        return joined_frames(camera, frames.time_ns, refined)
    rows = np.repeat(np.arange(len(ids)), [len(one) for one in ids])
    stream = CornerStream(
        camera, frames.time_ns, rows, np.concatenate(ids), np.concatenate(corners)
    )
    return stream, None


def _refined(*arguments: Any) -> RefinedFrame:
    try:
        return refine_frame(*arguments)
    except PhotometricUnavailable as missing:
        raise Unavailable(str(missing)) from missing


def _standing(stream: CornerStream, moving: tuple[int, ...]) -> CornerStream:
    """What was seen of markers that stand still."""
    still = ~np.isin(stream.marker_ids, np.array(moving, dtype=np.int64))
    return CornerStream(
        stream.camera, stream.time_ns, stream.frame[still], stream.marker_ids[still],
        stream.corners_px[still],
    )  # fmt: skip


def _usable(found: tuple[Detection, ...]) -> list[Detection]:
    ids = [one.marker_id for one in found]
    once = [one for one in found if ids.count(one.marker_id) == 1]
    return [one for one in once if one.sharp] or once


def _named(recording: Recording) -> LooseMarkers:
    if recording.markers is None:
        raise ValueError(
            f"{recording.name}: no markers to look for; name their family in a manifest ([markers])"
        )
    return recording.markers
