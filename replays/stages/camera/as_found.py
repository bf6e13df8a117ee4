"""A recording seen through the cameras that its images say have taken it."""

from __future__ import annotations

from dataclasses import replace

from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.offered import camera_of
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.cameras import DepthCamera


def as_found(
    recording: Recording, camera: Camera | None, depth_camera: DepthCamera | None
) -> Recording:
    """The recording with other cameras, its depth registered anew; None leaves one as it is."""
    if camera is not None:
        recording = replace(recording, camera=camera)
    frames = recording.frames
    if not isinstance(frames, ImageFrames):
        return recording
    sensor = depth_camera or frames.depth_camera
    if sensor is None or (camera is None and depth_camera is None):
        return recording
    anew = replace(frames, depth_camera=sensor, colour_camera=camera_of(recording))
    return replace(recording, frames=anew)
