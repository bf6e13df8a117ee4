"""Depth as its sensor measured it, and whether it, or the right camera, fits the images.

Depth against colour: edges of surfaces against edges in the image (`edge_offset`). The scale of
the first Kinect's depth: by the steps that it is measured in. Left against right: points of a
rectified pair lie further left in its right image.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import DepthArray, ImageArray, Recording
from motorcade.replays.stages.camera.offered import as_found, camera_of
from motorcade.tracking import Camera
from motorcade.tracking.audit import DEPTH_ON_COLOUR_PX, AuditFinding, Verdict, centre_finding
from motorcade.tracking.depth.cameras import (
    DepthCamera,
    EdgeOffset,
    edge_offset,
    inverse_depth_step,
)
from motorcade.tracking.depth.refine import refine_by_depth
from motorcade.tracking.images import track_corners
from motorcade.tracking.slam.features import find_corners
from motorcade.tracking.slam.geometry import seen_through

if TYPE_CHECKING:
    from motorcade.tracking.slam import SlamResult

_FRAMES = 12
_CLEARLY_PX = 6.0
_ZOOMED = 0.02
_KINECT_STEP = 0.0029
"""Of the first Kinect, 1/m: 1 / (8 * 575 px * 75 mm) (Khoshelham & Elberink 2012)."""
_KINECT_SPREAD = 0.03
"""Share by which its focal length (575 to 590 px are published) and baseline scatter."""
_PAIRS = 6
_CORNERS = 400
_LEVEL_PX = 2.0
_FEWEST_MATCHES = 60
_SAME_PX, _CLEARLY = 0.05, 2.0
"""Rows that are so near are the same; another hypothesis must be so many times nearer."""
_AGREE = 0.1
"""Of a logarithm: so well pairs and depth sensors agree where both are calibrated roughly."""


def audited_depth(
    recording: Recording,
) -> tuple[DepthCamera | None, tuple[AuditFinding, ...]]:
    """Look whether depth lies on colour; where it does not, and a correction does, say by which.

    Returns:
        the depth camera that brings depth onto colour, None to leave it, and what was found.
    """
    numbers = _sampled(recording)
    if not numbers:
        return None, ()
    grays = [_undistorted(recording, recording.frames[number].gray()) for number in numbers]
    stated = edge_offset(grays, [_registered(recording, number) for number in numbers])
    findings = [_unit(recording, numbers)] if recording.layout == "seven_scenes" else []
    if not np.isfinite(stated.px):
        summary = "edges of depth and of colour do not tell whether they fit"
        finding = AuditFinding("depth_on_colour", "unknown", None, "px", summary)
        return None, (*findings, finding)
    if stated.px <= DEPTH_ON_COLOUR_PX:
        summary = f"depth lies on colour to {stated.px:.1f} px"
        finding = AuditFinding("depth_on_colour", "consistent", stated.px, "px", summary)
        return None, (*findings, finding)
    corrected = _corrected(recording, stated)
    anew = as_found(recording, None, corrected)
    again = edge_offset(grays, [_registered(anew, number) for number in numbers])
    mended = np.isfinite(again.px) and again.px <= DEPTH_ON_COLOUR_PX
    verdict: Verdict = "contradicted" if stated.px > _CLEARLY_PX else "doubtful"
    summary = (
        f"depth lies {stated.px:.1f} px off colour: it has to move {stated.right_px:.1f} px right "
        f"and {stated.down_px:.1f} px down, and to grow by {stated.zoom:.3f}"
    )
    if mended:
        summary += f"; tracked with depth registered anew, to {again.px:.1f} px"
    advice = "state both focal lengths and the depth camera's pose on the colour camera as they are"
    if abs(stated.zoom - 1.0) >= _ZOOMED:
        advice += f": colour's to depth's is {stated.zoom:.3f} times what is stated"
    finding = AuditFinding("depth_on_colour", verdict, stated.px, "px", summary, advice)
    return (corrected if mended else None), (*findings, finding)


def audited_pair(recording: Recording) -> tuple[AuditFinding, ...]:
    """Look whether the right images are a right camera's, rectified, and as far off as depth says.

    Returns:
        a finding on the images, and where there is depth one on the baseline.
    """
    count = len(recording.frames)
    lefts, rights, depths_m = [np.empty((0, 2))], [np.empty((0, 2))], [np.empty(0)]
    for number in np.unique(np.linspace(0, count - 1, _PAIRS).astype(int)).tolist():
        frame = recording.frames[number]
        left, right = frame.gray(), frame.right()
        if right is None:
            continue
        px = find_corners(left, _CORNERS).px
        there, tracked = track_corners(left, right, px, px)
        lefts.append(px[tracked])
        rights.append(there[tracked])
        columns, rows = np.rint(px[tracked]).astype(int).T
        depth_m = frame.depth_m()
        depths_m.append(np.full(len(rows), np.nan) if depth_m is None else depth_m[rows, columns])
    left_px, right_px, depths = (np.concatenate(part) for part in (lefts, rights, depths_m))
    matches = left_px - right_px
    same_row = np.abs(matches[:, 1]) <= _LEVEL_PX
    right_of, level = np.count_nonzero(matches[same_row, 0] > 0.0), np.count_nonzero(same_row)
    name, matched = "left_and_right", len(matches)
    if matched < _FEWEST_MATCHES:
        summary = "left and right share too few corners"
        return (AuditFinding(name, "unknown", None, "share", summary),)
    if 2 * level < matched:
        summary = f"only {level} of {matched} corners lie in the same row of both images"
        advice = "rectify the images, or give frames of one moment"
        return (
            AuditFinding(name, "contradicted", 1.0 - level / matched, "share", summary, advice),
        )
    share = 1.0 - right_of / level
    verdict: Verdict = "consistent" if share <= 0.5 else "contradicted"
    summary = f"{right_of} of {level} corners lie further left in the right image"
    advice = "swap the left and right images"
    if np.median(np.abs(matches)) < _SAME_PX:
        verdict, summary = "contradicted", "left and right are the same images"
        advice = "name those of the right camera in [stereo] right"
    images = AuditFinding(name, verdict, share, "share", summary, advice)
    if not images.passed:
        return (images,)
    lens = _lens_of_pair(camera_of(recording), left_px[same_row], right_px[same_row])
    return (images, *lens, *_baseline(recording, matches[same_row, 0], depths[same_row]))


def _lens_of_pair(
    camera: Camera, left_px: FloatArray, right_px: FloatArray
) -> tuple[AuditFinding, ...]:
    """Contradict a distortion without which points stand in the same rows, and with which not."""
    if not any(camera.distortion):
        return ()
    apart = left_px - right_px, camera.undistort(left_px) - camera.undistort(right_px)
    apart_px, undistorted_px = (float(np.nanmedian(np.abs(off[:, 1]))) for off in apart)
    if not undistorted_px > _CLEARLY * max(apart_px, _SAME_PX):
        return ()
    summary = (
        f"the pair is rectified: its points stand in the same rows to {apart_px:.2f} px, and to "
        f"{undistorted_px:.2f} px once the stated distortion is taken out"
    )
    advice = 'say model = "pinhole", distortion = []'
    return (AuditFinding("distortion", "contradicted", undistorted_px, "px", summary, advice),)


def _baseline(
    recording: Recording, disparity_px: FloatArray, depth_m: FloatArray
) -> tuple[AuditFinding, ...]:
    """The baseline beside the depth of the same corners; nothing where there is too little."""
    known = np.isfinite(depth_m) & (disparity_px > _LEVEL_PX)
    baseline_m, camera = recording.baseline_m, camera_of(recording)
    lens_doubted = centre_finding(camera) is not None
    if baseline_m is None or lens_doubted or np.count_nonzero(known) < _FEWEST_MATCHES:
        return ()
    by_pair_m = baseline_m * camera.fx / disparity_px[known]
    times = float(np.median(by_pair_m / depth_m[known]))
    summary = f"by left and right images points are {times:.4g} times as far as by depth"
    if abs(np.log(times)) <= _AGREE:
        return (AuditFinding("baseline", "consistent", times, "times", summary),)
    advice = f"say baseline_m = {baseline_m / times:.3g} if depth is right"
    frames = recording.frames
    if isinstance(frames, ImageFrames):
        units = frames.depth_units_per_m
        advice += f"; depth would be in units of {units / times:.4g} to the metre, not {units:g}"
    return (AuditFinding("baseline", "contradicted", times, "times", summary, advice),)


def _sampled(recording: Recording) -> list[int]:
    """Numbers of a dozen frames that have depth, evenly over the recording."""
    last = len(recording.frames) - 1
    spread = np.unique(np.linspace(0, last, 2 * _FRAMES).astype(int)).tolist()
    known = [number for number in spread if recording.frames[number].read_depth is not None]
    return known[:: max(len(known) // _FRAMES, 1)]


def _undistorted(recording: Recording, gray: ImageArray) -> ImageArray:
    return camera_of(recording).undistort_image(gray)


def _registered(recording: Recording, number: int) -> DepthArray:
    depth_m = recording.frames[number].depth_m()
    if depth_m is None:
        raise ValueError(f"frame {number}: expected depth, got none")
    return camera_of(recording).undistort_depth(depth_m)


def _corrected(recording: Recording, off: EdgeOffset) -> DepthCamera:
    """The depth camera, turned and zoomed so that edges meet."""
    frames, colour = recording.frames, camera_of(recording)
    taken_by, _ = measured_depth(recording)
    stated = frames.depth_camera if isinstance(frames, ImageFrames) else None
    lens = taken_by.camera if stated is None else stated.camera
    turn = Rotor.from_rotation_vector([-off.down_px / colour.fy, off.right_px / colour.fx, 0.0])
    return DepthCamera(
        replace(lens, fx=lens.fx / off.zoom, fy=lens.fy / off.zoom),
        Motor.from_rotor_translation(turn, np.zeros(3)) @ taken_by.colour_T_depth,
    )


def _unit(recording: Recording, numbers: list[int]) -> AuditFinding:
    """The scale of the first Kinect's depth."""
    frames = recording.frames
    name, steps = "depth_scale", []
    if isinstance(frames, ImageFrames):
        taken = (frames.measured_depth(number) for number in numbers)
        unit_m = 1.0 / frames.depth_units_per_m
        steps = [inverse_depth_step(depth_m, unit_m) for depth_m in taken if depth_m is not None]
    known = [step for step in steps if step is not None]
    if not known:
        summary = "depth stands on no lattice of disparities that would tell its scale"
        return AuditFinding(name, "unknown", None, "times", summary)
    scale = _KINECT_STEP / float(np.median(known))
    summary = f"depth is {scale:.3f} times what the sensor's steps of disparity say"
    if abs(np.log(scale)) <= np.log1p(_KINECT_SPREAD):
        return AuditFinding(name, "consistent", scale, "times", summary)
    advice = "correct the depth's unit, or its scale"
    return AuditFinding(name, "contradicted", scale, "times", summary, advice)


MeasuredDepth = Callable[[int], DepthArray | None]
"""The depth of a frame by its number, None without."""


def measured_depth(recording: Recording) -> tuple[DepthCamera, MeasuredDepth]:
    """The pinhole that took the depth images, and their undistorted pixels.

    Depth that was recorded on colour's pixels counts as taken by the colour camera.
    """
    frames = recording.frames
    if isinstance(frames, ImageFrames) and frames.depth_camera is not None:
        lens, colour_T_depth = frames.depth_camera.camera, frames.depth_camera.colour_T_depth
        read: MeasuredDepth = frames.measured_depth
    else:
        lens, colour_T_depth = camera_of(recording), Motor.identity()

        def read(index: int) -> DepthArray | None:
            return frames[index].still().depth_m()

    def undistorted(index: int) -> DepthArray | None:
        depth_m = read(index)
        return None if depth_m is None else lens.undistort_depth(depth_m)

    return DepthCamera(lens.undistorted(), colour_T_depth), undistorted


def refined_by_depth(recording: Recording, result: SlamResult) -> SlamResult | None:
    """SLAM's path and map, refined by depth; None without a path, or as `refine_by_depth` says."""
    if result.trajectory is None:
        return None
    taken_by, depth_m = measured_depth(recording)
    index = {stamp: row for row, stamp in enumerate(recording.frames.time_ns.tolist())}
    refined = refine_by_depth(
        result.map,
        result.trajectory,
        seen_through(camera_of(recording)),
        taken_by,
        lambda time_ns: depth_m(index[time_ns]),
    )
    if refined is None:
        return None
    return replace(result, trajectory=refined.trajectory, map=refined.map)
