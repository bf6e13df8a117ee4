"""Whether what is told of the depth sensor, or of the right camera, fits the pictures.

Depth against colour: edges of surfaces against edges in the picture (`edge_offset`). The scale of
the first Kinect's depth: by the steps that it is measured in. Left against right: points of a
rectified pair lie further left in its right picture.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.replays.io.readers.frames.files import PictureFrames
from motorcade.replays.io.recording import DepthArray, ImageArray, Recording
from motorcade.replays.stages.camera.as_found import as_found
from motorcade.replays.stages.camera.depth import measured_depth
from motorcade.replays.stages.camera.offered import camera_of
from motorcade.tracking.audit import DEPTH_ON_COLOUR_PX, AuditFinding, Verdict
from motorcade.tracking.depth.cameras import DepthCamera
from motorcade.tracking.depth.edges import EdgeOffset, edge_offset
from motorcade.tracking.depth.lattice import inverse_depth_step
from motorcade.tracking.pictures import track_corners
from motorcade.tracking.slam.features import find_corners

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
        found = AuditFinding("depth_on_colour", "unknown", None, "px", summary)
        return None, (*findings, found)
    if stated.px <= DEPTH_ON_COLOUR_PX:
        summary = f"depth lies on colour to {stated.px:.1f} px"
        found = AuditFinding("depth_on_colour", "consistent", stated.px, "px", summary)
        return None, (*findings, found)
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
    found = AuditFinding("depth_on_colour", verdict, stated.px, "px", summary, advice)
    return (corrected if mended else None), (*findings, found)


def audited_pair(recording: Recording) -> AuditFinding:
    """Look whether the right pictures are a right camera's, and rectified."""
    count = len(recording.frames)
    right_of, level, matched = 0, 0, 0
    for number in np.unique(np.linspace(0, count - 1, _PAIRS).astype(int)).tolist():
        frame = recording.frames[number]
        left, right = frame.gray(), frame.right()
        if right is None:
            continue
        px = find_corners(left, _CORNERS).px
        there, found = track_corners(left, right, px, px)
        apart = (px - there)[found]
        matched += len(apart)
        same_row = np.abs(apart[:, 1]) <= _LEVEL_PX
        level += int(np.count_nonzero(same_row))
        right_of += int(np.count_nonzero(same_row & (apart[:, 0] > 0.0)))
    name = "left_and_right"
    if matched < _FEWEST_MATCHES:
        return AuditFinding(name, "unknown", None, "share", "left and right share too few corners")
    if 2 * level < matched:
        summary = f"only {level} of {matched} corners lie in the same row of both pictures"
        advice = "rectify the pictures, or give frames of one moment"
        return AuditFinding(name, "contradicted", 1.0 - level / matched, "share", summary, advice)
    share = 1.0 - right_of / level
    if share > 0.5:
        summary = f"{level - right_of} of {level} corners lie further right in the right picture"
        return AuditFinding(
            name, "contradicted", share, "share", summary, "swap the left and right pictures"
        )
    summary = f"{right_of} of {level} corners lie further left in the right picture"
    return AuditFinding(name, "consistent", share, "share", summary)


def _sampled(recording: Recording) -> list[int]:
    """Numbers of a dozen frames that have depth, evenly over the recording."""
    known = [
        number
        for number in np.unique(
            np.linspace(0, len(recording.frames) - 1, 2 * _FRAMES).astype(int)
        ).tolist()
        if recording.frames[number].read_depth is not None
    ]
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
    stated = frames.depth_camera if isinstance(frames, PictureFrames) else None
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
    if isinstance(frames, PictureFrames):
        for number in numbers:
            depth_m = frames.measured_depth(number)
            step = (
                None
                if depth_m is None
                else inverse_depth_step(depth_m, 1.0 / frames.depth_units_per_m)
            )
            steps += [] if step is None else [step]
    if not steps:
        summary = "depth stands on no lattice of disparities that would tell its scale"
        return AuditFinding(name, "unknown", None, "times", summary)
    scale = _KINECT_STEP / float(np.median(steps))
    summary = f"depth is {scale:.3f} times what the sensor's steps of disparity say"
    if abs(np.log(scale)) <= np.log1p(_KINECT_SPREAD):
        return AuditFinding(name, "consistent", scale, "times", summary)
    advice = "correct the depth's unit, or its scale"
    return AuditFinding(name, "contradicted", scale, "times", summary, advice)
