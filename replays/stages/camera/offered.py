"""What each way of measuring poses needs from a recording, and the cameras it is seen through."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from motorcade.replays.engine.stage import NotOffered
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import Frame, ImageArray, Recording
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


log = logging.getLogger("motorcade.camera_poses")
_SPREAD = 8


def camera_of(recording: Recording) -> Camera:
    """The recording's camera.

    Raises:
        NotOffered: none is known.
    """
    if recording.camera is None:
        raise NotOffered(
            f"{recording.name}: no camera known, so its poses cannot be tracked; describe it in a "
            "manifest: [camera] with fx, fy, cx, cy as `motorcade calibrate` finds them, or with "
            "fov_deg = 65 where only a guess of how wide it sees can be had"
        )
    return recording.camera


def rows_readout_s(recording: Recording) -> float:
    """The rolling shutter's time where its rows run down the image, as SLAM with an IMU takes it.

    Of turned images it is left aside, which the log says.
    """
    if recording.readout_s and recording.rows_run.tolist() != [0, 1]:
        log.warning(
            "%s: readout_s is left aside by SLAM: the images are turned, and their rows are not "
            "read one after the other from the first",
            recording.name,
        )
        return 0.0
    return recording.readout_s


def spread_frames(recording: Recording) -> list[Frame]:
    """A few frames, evenly over the recording, in which what was stated is looked at."""
    frames = recording.frames
    return [frames[k] for k in np.unique(np.linspace(0, len(frames) - 1, _SPREAD, dtype=int))]


def require_images(recording: Recording) -> None:
    """Refuse a recording of marker corners alone.

    Raises:
        NotOffered: there are no images.
    """
    if isinstance(recording.frames, CornerFrames):
        raise NotOffered(f"{recording.name}: it holds corners of markers, and no images")


def sampled_images(recording: Recording) -> list[ImageArray]:
    """The grey images of `spread_frames`."""
    return [frame.gray() for frame in spread_frames(recording)]
