"""What each way of measuring poses needs from a recording, and the message when it is missing."""

from __future__ import annotations

from motorcade.replays.engine.stage import NotOffered
from motorcade.replays.readers.frames.corners import CornerFrames
from motorcade.replays.recording import Recording
from motorcade.tracking.cameras.camera import Camera


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


def require_pictures(recording: Recording) -> None:
    """Refuse a recording of marker corners alone.

    Raises:
        NotOffered: there are no pictures.
    """
    if isinstance(recording.frames, CornerFrames):
        raise NotOffered(f"{recording.name}: it holds corners of markers, and no pictures")
