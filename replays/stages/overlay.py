"""Stage `overlay`: the character in the undistorted footage, as H.264 video."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from motorcade.ga import Trajectory
from motorcade.render import (
    RENDERERS,
    RendererName,
    RenderUnavailable,
    render_overlay,
    write_video,
)
from motorcade.render.scene import DepthArray, ImageArray
from motorcade.replays.artifacts import ASIDE, new_file
from motorcade.replays.characters.acting import character_named, clip_named, walked
from motorcade.replays.graph import Unavailable
from motorcade.replays.progress import track
from motorcade.replays.readers.corner_frames import CornerFrames
from motorcade.replays.recording import Recording
from motorcade.replays.stages.placed import Placed
from motorcade.replays.stages.smoothed import Smoothed


@dataclass(frozen=True)
class Overlay:
    """A video, how many of its frames show something drawn, and on what the character stands."""

    path: Path
    frames_with_character: int
    frames: int
    stands_on: str
    seconds: float = field(metadata=ASIDE)


def overlay(
    recording: Recording,
    smoothed: Smoothed,
    placed: Placed,
    *,
    representation: str | None = None,
    renderer: str = "fast",
) -> Overlay:
    """Draw the placed character into every frame that has a smoothed pose.

    `representation` says along which of the smoothed paths; without it, the first of them.
    `renderer` draws: "fast", or "pyrender" (docs/rendering.md says when to take which).
    Frames without a pose (before the first, after the last) are shown as they are. Where the
    recording has depth, what is nearer hides the character. Raises `Unavailable` without OpenGL and
    for recordings of corners, which hold no pictures, and ValueError without a camera or for a
    representation that was not smoothed or an unknown renderer.
    """
    if recording.camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    if isinstance(recording.frames, CornerFrames):
        raise Unavailable("the recording holds corners of markers and no pictures to draw into")
    path = _chosen(smoothed, representation)
    character = character_named(placed.character)
    clip = clip_named(character, placed.clip)
    if len(placed.path_m):
        clip = walked(
            character, clip, placed.path_m, placed.placement.scale, placed.plane_T_character
        )
    start = time.perf_counter()
    footage = _Footage(recording)
    pictures = render_overlay(
        footage.undistorted(),
        recording.camera.undistorted(),
        path,
        character,
        clip,
        placed.placement,
        renderer=_known(renderer),
    )
    file = new_file("overlay.mp4")
    try:
        write_video(file, footage.counted(pictures), recording.frames.time_ns)
    except RenderUnavailable as missing:
        raise Unavailable(str(missing)) from missing
    return Overlay(
        file,
        footage.drawn_into,
        len(recording.frames),
        placed.stands_on,
        time.perf_counter() - start,
    )


class _Footage:
    """The frames on their way to the renderer and back, and how many of them came back changed."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.drawn_into = 0
        self._given: ImageArray | None = None

    def undistorted(self) -> Iterator[tuple[int, ImageArray, DepthArray | None]]:
        """Stamp, picture and depth of every frame, as a camera without distortion has them."""
        camera = self.recording.camera
        assert camera is not None  # checked by the stage
        for frame in track(self.recording.frames, "drawing", len(self.recording.frames)):
            depth_m = frame.depth_m()
            if depth_m is not None:
                depth_m = camera.undistort_depth(depth_m)
            self._given = camera.undistort_image(frame.image())
            yield frame.time_ns, self._given, depth_m

    def counted(self, pictures: Iterable[ImageArray]) -> Iterator[ImageArray]:
        """The drawn frames as they are."""
        for picture in pictures:
            given = self._given
            if given is not None:
                before = given if given.ndim == 3 else given[..., None]
                self.drawn_into += bool(np.any(picture != before))
            yield picture


def _known(renderer: str) -> RendererName:
    for name in RENDERERS:
        if renderer == name:
            return name
    raise ValueError(f"overlay.renderer: expected one of {', '.join(RENDERERS)}, came {renderer!r}")


def _chosen(smoothed: Smoothed, representation: str | None) -> Trajectory:
    if representation is None:
        return next(iter(smoothed.trajectories.values()))
    if representation not in smoothed.trajectories:
        known = ", ".join(smoothed.trajectories)
        raise ValueError(
            f"overlay.representation: expected one of {known}, came {representation!r}"
        )
    return smoothed.trajectories[representation]
