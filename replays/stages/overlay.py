"""Stage `overlay`: the character in the undistorted footage, as H.264 video."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from motorcade.ga import Trajectory
from motorcade.render import RenderUnavailable, render_overlay, write_video
from motorcade.render.scene import DepthArray, ImageArray
from motorcade.replays.artifacts import ASIDE, new_file
from motorcade.replays.graph import Unavailable
from motorcade.replays.progress import track
from motorcade.replays.recording import Recording
from motorcade.replays.stages.placed import Placed, character_named
from motorcade.replays.stages.smoothed import Smoothed


@dataclass(frozen=True)
class Overlay:
    """A video file, how many of its frames show the character, and what making it took."""

    path: Path
    frames: int
    frames_with_character: int
    seconds: float = field(metadata=ASIDE)


def overlay(
    recording: Recording,
    smoothed: Smoothed,
    placed: Placed,
    *,
    representation: str = "motor",
) -> Overlay:
    """Draw the placed character into every frame that has a smoothed pose.

    Frames without a pose (before the first, after the last) are shown as they are. Where the
    recording has depth, what is nearer hides the character. Raises `Unavailable` without OpenGL,
    and ValueError without a camera or for a representation that was not smoothed.
    """
    if recording.camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    path = _chosen(smoothed, representation)
    character = character_named(placed.character)
    start = time.perf_counter()
    pictures = render_overlay(
        _undistorted(recording),
        recording.camera.undistorted(),
        path,
        character,
        character.clip(placed.clip),
        placed.placement,
    )
    file = new_file("overlay.mp4")
    stamps = recording.frames.time_ns
    try:
        write_video(file, pictures, stamps)
    except RenderUnavailable as missing:
        raise Unavailable(str(missing)) from missing
    covered = np.count_nonzero((stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1]))
    return Overlay(file, len(stamps), int(covered), time.perf_counter() - start)


def _undistorted(recording: Recording) -> Iterator[tuple[int, ImageArray, DepthArray | None]]:
    """Stamp, picture and depth of every frame, as a camera without distortion would have it."""
    camera = recording.camera
    assert camera is not None  # checked by the stage
    for frame in track(recording.frames, "drawing", len(recording.frames)):
        depth_m = frame.depth_m()
        if depth_m is not None:
            depth_m = camera.undistort_depth(depth_m)
        yield frame.time_ns, camera.undistort_image(frame.image()), depth_m


def _chosen(smoothed: Smoothed, representation: str) -> Trajectory:
    if representation not in smoothed.trajectories:
        known = ", ".join(smoothed.trajectories)
        raise ValueError(
            f"overlay.representation: expected one of {known}, came {representation!r}"
        )
    return smoothed.trajectories[representation]
