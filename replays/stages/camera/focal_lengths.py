"""The cameras of an RGB-D recording, found where its images contradict those that are stated.

Edges tell how depth lies on colour, so also the ratio of both focal lengths, but not which of the
two is wrong. That is asked of the recording's first frames: they are tracked once more than needed,
and both focal lengths adjusted with their poses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga.progress import track
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.as_found import as_found
from motorcade.replays.stages.camera.depth import measured_depth
from motorcade.replays.stages.camera.offered import camera_of
from motorcade.replays.stages.camera.sensor_audit import audited_depth
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.cameras import DepthCamera
from motorcade.tracking.depth.refine import FocalFactor, focal_factor
from motorcade.tracking.slam.geometry import seen_through

_FIRST_S = 5.0
"""A hand turns a camera by tens of degrees in that time."""
_OFF = 0.02
"""Share of a focal length that is worth telling: calibrations are good to a hundredth."""
_DEVIATIONS = 3.0
_FARTHEST = 2.0 * _OFF
"""So far may the deviations reach: a lens that is wrong by 5 % still differs from a right one."""
_NAME = "focal_lengths"


@dataclass(frozen=True, eq=False)
class FoundCameras:
    """What took images and depth, None where it is as stated, and what the audit says."""

    camera: Camera | None
    depth_camera: DepthCamera | None
    audit: tuple[AuditFinding, ...]


def found_cameras(recording: Recording) -> FoundCameras:
    """Look whether depth lies on colour; where it does not, find the cameras with which it does."""
    depth_camera, audit = audited_depth(recording)
    if depth_camera is None:
        return FoundCameras(None, None, audit)
    stated = measured_depth(recording)[0].camera
    if abs(np.log(depth_camera.camera.fx / stated.fx)) < _OFF:
        return FoundCameras(None, depth_camera, audit)
    registered = as_found(recording, None, depth_camera)
    correction = _factor(registered)
    if correction is None or _DEVIATIONS * correction.sigma > _FARTHEST:
        summary = f"the first {_FIRST_S:g} s do not tell which focal length is wrong"
        finding = AuditFinding(_NAME, "unknown", None, "share", f"{summary}; depth's was corrected")
        return FoundCameras(None, depth_camera, (*audit, finding))
    colour = _longer(camera_of(recording), correction.factor)
    depth = _longer(depth_camera.camera, correction.factor)
    finding = _told(camera_of(recording), stated, correction, (colour, depth))
    return FoundCameras(colour, DepthCamera(depth, depth_camera.colour_T_depth), (*audit, finding))


def _factor(recording: Recording) -> FocalFactor | None:
    """By what both focal lengths are wrong alike, as the first frames have it."""
    from motorcade.tracking.slam import VisualSlam

    frames, camera = recording.frames, camera_of(recording)
    slam = VisualSlam(camera)
    count = int(np.searchsorted(frames.time_ns - frames.time_ns[0], 1e9 * _FIRST_S))
    for number in track(range(count), "finding focal lengths", count):
        frame = frames[number]
        slam.track(frame.time_ns, frame.gray(), frame.still().depth_m(), None)
    result = slam.finish()
    if result.trajectory is None or not result.metric:
        return None
    taken_by, depth_m = measured_depth(recording)
    index = {stamp: row for row, stamp in enumerate(frames.time_ns.tolist())}
    return focal_factor(
        result.map,
        result.trajectory,
        seen_through(camera),
        taken_by,
        lambda time_ns: depth_m(index[time_ns]),
    )


def _longer(camera: Camera, factor: float) -> Camera:
    return replace(camera, fx=factor * camera.fx, fy=factor * camera.fy)


def _told(
    colour: Camera, depth: Camera, by: FocalFactor, cameras: tuple[Camera, Camera]
) -> AuditFinding:
    """What is said of both focal lengths beside those that were stated."""
    off = [one.fx / stated.fx - 1.0 for one, stated in zip(cameras, (colour, depth), strict=True)]
    most = max(map(abs, off))
    sigma_px = by.sigma / by.factor * cameras[0].fx, by.sigma / by.factor * cameras[1].fx
    summary = (
        f"colour's focal length looks like {cameras[0].fx:.0f} ± {sigma_px[0]:.0f} px "
        f"({colour.fx:.0f} stated), depth's like {cameras[1].fx:.0f} ± {sigma_px[1]:.0f} px "
        f"({depth.fx:.0f} stated); tracked with these"
    )
    advice = "calibrate both, or state these"
    return AuditFinding(_NAME, "contradicted", most, "share", summary, advice)
