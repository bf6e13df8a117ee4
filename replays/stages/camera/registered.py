"""A recording's depth, registered from the camera that the pictures say has taken it."""

from __future__ import annotations

from dataclasses import replace

from motorcade.replays.readers.frames.files import PictureFrames
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera.offered import camera_of
from motorcade.tracking.depth.cameras import DepthCamera


def registered_by(recording: Recording, depth_camera: DepthCamera | None) -> Recording:
    """The recording with its depth registered from another camera; None leaves it as it is."""
    frames = recording.frames
    if depth_camera is None or not isinstance(frames, PictureFrames):
        return recording
    anew = replace(frames, depth_camera=depth_camera, colour_camera=camera_of(recording))
    return replace(recording, frames=anew)
