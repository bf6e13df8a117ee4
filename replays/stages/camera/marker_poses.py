"""Stage `marker_poses`: camera poses by loose markers.

Their corners are found or were recorded; they are mapped together and tracked by the map.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.ga.progress import track
from motorcade.replays.engine.stage import NotOffered, Unavailable
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import ImageArray, LooseMarkers, Recording
from motorcade.replays.stages.camera.board_audit import audited_markers, pixels_finding
from motorcade.replays.stages.camera.offered import camera_of, sampled_images, spread_frames
from motorcade.replays.stages.values.camera_poses import MarkerPoses, SightedPoints
from motorcade.tracking import (
    PoseMeasurements,
    SingleMarker,
    TrackingError,
    detect_markers,
)
from motorcade.tracking.audit import AuditFinding, scatter_px
from motorcade.tracking.images import print_noise_px
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import MarkerObservations
from motorcade.tracking.markers.families import border_share
from motorcade.tracking.markers.mapping.estimate import (
    MappedRecording,
    map_markers,
    moving_markers,
    track_rig,
    without,
)
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.markers.photometric.refine import (
    PhotometricUnavailable,
    RefinedFrame,
    joined_frames,
    refine_frame,
)
from motorcade.tracking.markers.refinding import refind_markers
from motorcade.tracking.markers.scenes import MarkerScene
from motorcade.tracking.markers.scenes.estimate import map_scene
from motorcade.tracking.pose import SIGMA_FLOOR_PX
from motorcade.tracking.rolling import unrolled_stream, with_unsure_readout
from motorcade.tracking.targets.finding import doubled_ids
from motorcade.tracking.targets.stated import name_target

Refine = Literal["none", "photometric"]
_ONLY, _DRAWN = "camera", 3
# A camera's own noise floor: a map is never more certain than its lens and its print.
_SIGMA_FLOOR = np.repeat([1e-4, 1e-4], 3)


def marker_poses(
    recording: Recording, *, refine: Refine = "none", moving: tuple[int, ...] = ()
) -> MarkerPoses:
    """Map the markers of a recording, unless their map is known, and track its camera by them.

    The world is the map's; of a map made here, the frame of the marker seen most.

    `refine=photometric` refines the poses of loose markers in images on their whole print; it
    needs torch and kornia (the extra `photometric`), and pays on small markers and for steadiness
    (`make bench SUITE=tracking` says how much), at 30 to 150 ms a marker on one core.

    `moving` names markers that do not stand still: they neither map nor track. Others that do
    not are looked for where corners do not agree, left aside and named.

    Raises:
        NotOffered: no camera known, or neither recorded corners nor a family to look for.
        ValueError: refinement where there are no images or some markers move.
        TrackingError: no marker seen.
        Unavailable: refinement without torch and kornia.
    """
    if refine != "none" and moving:
        raise ValueError(f"{recording.name}: refine={refine} takes all markers, got {moving=}")
    camera_of(recording)
    start = time.perf_counter()
    frames = recording.frames
    if isinstance(frames, CornerFrames) and frames.scene is not None and refine == "none":
        return _by_scene(frames, frames.scene, moving, start)
    seen = _seen_markers(recording, refine)
    twice = tuple(marker for marker in seen.twice if marker not in moving)
    streams = without(seen.streams, moving)
    once = without(streams, twice if seen.posed is None else ())
    if any(len(stream) for stream in once.values()):
        streams = once
    if not any(len(stream) for stream in streams.values()):
        raise TrackingError(
            f"frames: expected some that show a marker, got none{_instead(recording)}"
        )
    known = None if recording.markers is None else recording.markers.marker_map
    shown, noise_px, scale_sigma = {}, 0.0, 0.0
    if recording.markers is not None and not isinstance(frames, CornerFrames):
        shown = {frame.time_ns: frame.gray() for frame in spread_frames(recording)}
        noise_px, scale = _noise(shown, streams[_ONLY], border_share(recording.markers.family))
        scale_sigma = scale if known is None else 0.0
    floor_px = max(noise_px, SIGMA_FLOOR_PX)
    by_corners: Callable[..., MappedRecording] = partial(
        map_markers, side_m=seen.side_m, posed=seen.posed
    )
    if known is not None:
        by_corners = partial(track_rig, known)
    map_or_track = partial(by_corners, rig_T_camera=seen.rig_T_camera, floor_px=floor_px)

    mapped = map_or_track(streams)
    audit: tuple[AuditFinding, ...] = (_doubled(twice),) if twice else ()
    limit_px = scatter_px(next(iter(streams.values())).camera, noise_px)
    if seen.posed is None:
        restless = moving_markers(streams, mapped, map_or_track, limit_px)
        if restless:
            before_px = float(np.median(mapped.frame_error_px))
            streams = without(streams, restless)
            mapped = map_or_track(streams)
            audit += (_restless(restless, before_px, float(np.median(mapped.frame_error_px))),)
    if mapped.error_px.max() > limit_px:
        mapped = map_or_track(streams, most_px=limit_px)
    unsure_s2 = np.zeros((0, 0))
    if len(streams) == 1 and seen.posed is None:
        remap = partial(map_or_track, most_px=limit_px)
        streams, mapped, findings, unsure_s2 = _read_at_once(
            recording, streams, mapped, remap, noise_px
        )
        audit += findings
    if recording.markers is not None and shown:
        drawn = _drawn(shown, streams[_ONLY], mapped, recording.markers.family)
        audit = (pixels_finding(drawn, streams[_ONLY].camera, limit_px), *audit)
    where = "mapped from this recording alone" if known is None else "where a map places them"
    recorded = isinstance(recording.frames, CornerFrames)
    summary = (
        f"tracked by the {'recorded corners' if recorded else 'images'} of "
        f"{len(mapped.marker_map)} loose markers, {where}"
        + (", refined on their prints" if refine == "photometric" else "")
        + (f"; {len(mapped.left_out)} markers never seen beside them" if mapped.left_out else "")
        + ("" if recording.metric else "; their size is not known: lengths have no unit")
    )
    name, stream = next(iter(streams.items()))
    measured = _of_camera(mapped, name, scale_sigma)
    if unsure_s2.size:
        measured = with_unsure_readout(measured, stream, mapped.marker_map, unsure_s2)
    return MarkerPoses(
        measured,
        mapped.time_ns,
        mapped.frame_error_px,
        "markers",
        summary,
        metric=recording.metric,
        audit=audit,
        seconds=time.perf_counter() - start,
        corner_px=noise_px,
        marker_map=mapped.marker_map,
        sighted=_sighted(stream, mapped.marker_map),
    )


def _read_at_once(
    recording: Recording,
    streams: dict[str, CornerStream],
    mapped: MappedRecording,
    remap: Callable[[Mapping[str, CornerStream]], MappedRecording],
    noise_px: float,
) -> tuple[dict[str, CornerStream], MappedRecording, tuple[AuditFinding, ...], FloatArray]:
    """One camera's corners and map without its shutter's read-out, as stated or as they deny it.

    With the finding on that, and the mean square ``(2, 2)`` of what is left, where images tell.
    """
    name, rolled = next(iter(streams.items()))

    def unrolled(shutter_s: FloatArray) -> tuple[dict[str, CornerStream], MappedRecording]:
        path = _of_camera(mapped, name).trajectory
        still = {name: unrolled_stream(rolled, path, mapped.marker_map, shutter_s)}
        return still, remap(still)

    if recording.readout_s:
        streams, mapped = unrolled(recording.shutter_s)
    if recording.markers is None:
        return streams, mapped, (), np.zeros((0, 0))
    findings, off_s, unsure_s2 = audited_markers(recording, streams[name], mapped, noise_px)
    if off_s.any():
        streams, mapped = unrolled(recording.shutter_s + off_s)
    return streams, mapped, findings, unsure_s2


def _instead(recording: Recording) -> str:
    """What images show in place of the markers that were stated."""
    if recording.markers is None or isinstance(recording.frames, CornerFrames):
        return ""
    shown = name_target(sampled_images(recording), recording.markers.family)
    return f"; {shown}" if shown else ""


def _noise(
    shown: Mapping[int, ImageArray], stream: CornerStream, cell_share: float
) -> tuple[float, float]:
    """How far corners can scatter in these images, pixels, and sides by blur, as a share.

    Blur draws all of a marker's images alike: their number does not make a map's scale surer.
    """
    rows = [stream.corners_px[stream.time_ns[stream.frame] == stamp] for stamp in shown]
    noise_px, bias_px = print_noise_px([*shown.values()], rows, cell_share)
    quads = np.concatenate([np.zeros((0, 4, 2)), *rows])
    if not len(quads):
        return noise_px, 0.0
    side_px = np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=-1)
    return noise_px, float(np.sqrt(2.0) * bias_px / np.median(side_px))


def _drawn(
    shown: Mapping[int, ImageArray], stream: CornerStream, mapped: MappedRecording, family: str
) -> Iterator[tuple[ImageArray, SingleMarker, Motor]]:
    """Images, and the largest markers in each where the map and the path put them."""
    area_px = np.ptp(stream.corners_px, axis=1).prod(axis=-1)
    known, path = mapped.marker_map, mapped.trajectory
    for stamp, image in shown.items():
        if stamp not in path.time_ns:
            continue
        at_stamp = stream.time_ns[stream.frame] == stamp
        rows = np.flatnonzero(at_stamp & np.isin(stream.marker_ids, known.marker_ids))
        for row in rows[np.argsort(-area_px[rows], kind="stable")][:_DRAWN]:
            place = int(np.searchsorted(known.marker_ids, stream.marker_ids[row]))
            marker_T_world = known.world_T_marker[place].inverse()
            marker = SingleMarker(family, int(known.marker_ids[place]), float(known.side_m[place]))
            yield image, marker, marker_T_world @ path.motors_at(np.int64(stamp))


def _doubled(markers: tuple[int, ...]) -> AuditFinding:
    """The finding on markers that were left aside since their ids stand twice."""
    ids, several = " and ".join(map(str, markers)), len(markers) > 1
    summary = f"marker{'s' * several} {ids} {'stand' if several else 'stands'} there twice"
    advice = (
        "no map can tell copies apart: print each id once, or say "
        f"marker_poses.moving={','.join(map(str, markers))}"
    )
    return AuditFinding("doubled_markers", "doubtful", float(len(markers)), "ids", summary, advice)


def _restless(markers: tuple[int, ...], before_px: float, left_px: float) -> AuditFinding:
    """The finding on markers that were left aside since they do not stand still."""
    several = len(markers) > 1
    ids = " and ".join(map(str, markers))
    summary = (
        f"{'markers' if several else 'marker'} {ids} {'do' if several else 'does'} not stand still "
        f"beside the others, and {'are' if several else 'is'} left aside: the others are met to "
        f"{left_px:.2f} px without, {before_px:.2f} px with"
    )
    advice = f"say marker_poses.moving={','.join(map(str, markers))}"
    off = before_px / max(left_px, 1e-9)
    return AuditFinding("moving_markers", "contradicted", off, "times", summary, advice)


def _by_scene(
    frames: CornerFrames, scene: MarkerScene, moving: tuple[int, ...], start: float
) -> MarkerPoses:
    """All that was stated of bodies, markers, cameras and lengths, and all corners, together."""
    streams = without(frames.streams, moving)
    mapped = map_scene(streams, scene)
    first = next(iter(streams))
    path = mapped.seen_from(first)
    if not len(path.measurements):
        raise TrackingError("frames: expected some that show a marker, got none")
    summary = (
        f"tracked by the recorded corners of {len(path.marker_map)} markers, with all that was "
        "stated of them"
        + (", joined with the recorded odometry" if mapped.has_odometry else "")
        + (f"; {len(mapped.left_out)} markers never seen beside them" if mapped.left_out else "")
    )
    spread = path.measurements.covariance + np.diag(_SIGMA_FLOOR**2)
    return MarkerPoses(
        PoseMeasurements(path.measurements.trajectory, spread),
        mapped.seen.time_ns,
        path.error_px,
        "markers",
        summary,
        seconds=time.perf_counter() - start,
        audit=mapped.audit,
        has_odometry=mapped.has_odometry,
        marker_map=path.marker_map,
        sighted=_sighted(streams[first], path.marker_map),
    )


@dataclass(frozen=True, eq=False)
class _SeenMarkers:
    """Corners by camera, sides by marker, cameras on the rig, poses where they were refined, and
    ids that stand twice.
    """

    streams: Mapping[str, CornerStream]
    side_m: Mapping[int, float]
    rig_T_camera: Mapping[str, Motor]
    posed: dict[str, MarkerObservations] | None = None
    twice: tuple[int, ...] = ()


def _seen_markers(recording: Recording, refine: Refine) -> _SeenMarkers:
    """What was recorded of markers, or is found in the images."""
    frames = recording.frames
    if isinstance(frames, CornerFrames):
        if refine != "none":
            raise ValueError(f"{recording.name}: refine={refine} needs images, got corners")
        return _SeenMarkers(frames.streams, frames.side_m, frames.rig_T_camera)
    if recording.markers is None:
        raise NotOffered(
            f"{recording.name}: no markers to look for; name their family in a manifest ([markers])"
        )
    loose = recording.markers
    stream, observations, twice = markers_found(recording, loose, refine)
    side_m = dict.fromkeys(np.unique(stream.marker_ids).tolist(), loose.side_m)
    posed = None if observations is None else {_ONLY: observations}
    return _SeenMarkers({_ONLY: stream}, side_m, {_ONLY: Motor.identity()}, posed, twice)


def _of_camera(mapped: MappedRecording, camera: str, scale_sigma: float = 0.0) -> PoseMeasurements:
    """The rig's path and covariance at one of its cameras, with that of the map's scale."""
    rig_T_camera = mapped.rig_T_camera[camera]
    adjoint = rig_T_camera.inverse().adjoint()
    covariance = adjoint @ mapped.covariance @ adjoint.T + np.diag(_SIGMA_FLOOR**2)
    path = mapped.trajectory.transformed_by(right=rig_T_camera, child="camera")
    away = scale_sigma * path.motors.inverse().translation_m
    covariance[:, 3:, 3:] += away[:, :, None] * away[:, None]
    return PoseMeasurements(path, 0.5 * (covariance + covariance.swapaxes(-1, -2)))


def markers_found(
    recording: Recording, markers: LooseMarkers, refine: Refine = "none"
) -> tuple[CornerStream, MarkerObservations | None, tuple[int, ...]]:
    """Detect the markers of every image; with refinement, both their poses as well.

    Those whose sides do not all show are left out; so is an id that stands there twice, since no
    map can tell its copies apart. Ids that do so in several frames come last.

    Raises:
        NotOffered: no camera known.
        Unavailable: refinement without torch and kornia.
    """
    camera = camera_of(recording)
    frames, family = recording.frames, markers.family
    ids, corners, refined, read = [], [], [], []
    for frame in track(frames, "detecting", len(frames)):
        gray = frame.gray()
        seen = detect_markers(gray, family, camera)
        if markers.marker_map is not None:
            seen = refind_markers(gray, family, camera, markers.marker_map, seen)
        read.append([detection.marker_id for detection in seen])
        usable = [one for one in seen if one.sharp and read[-1].count(one.marker_id) == 1]
        ids.append(np.array([detection.marker_id for detection in usable], np.int64))
        corners.append(np.array([detection.corners_px for detection in usable]).reshape(-1, 4, 2))
        if refine == "photometric":
            sides = np.full(len(usable), markers.side_m)
            refined.append(_refined(gray, camera, family, ids[-1], corners[-1], sides))
    if refine == "photometric":
        return *joined_frames(camera, frames.time_ns, refined), doubled_ids(read)
    rows = np.repeat(np.arange(len(ids)), [len(in_frame) for in_frame in ids])
    stream = CornerStream(
        camera, frames.time_ns, rows, np.concatenate(ids), np.concatenate(corners)
    )
    return stream, None, doubled_ids(read)


def _refined(*arguments: Any) -> RefinedFrame:
    try:
        return refine_frame(*arguments)
    except PhotometricUnavailable as missing:
        raise Unavailable(str(missing)) from missing


def _sighted(seen: CornerStream, known: MarkerMap) -> SightedPoints:
    """Four corners of every observation of a mapped marker."""
    mapped = np.isin(seen.marker_ids, known.marker_ids)
    rows = np.searchsorted(known.marker_ids, seen.marker_ids[mapped])
    return SightedPoints(
        seen.camera,
        seen.time_ns,
        np.repeat(seen.frame[mapped], 4),
        known.points_m.reshape(-1, 4, 3)[rows].reshape(-1, 3),
        seen.corners_px[mapped].reshape(-1, 2),
    )
