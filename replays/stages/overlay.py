"""Stage `overlay`: the character in the undistorted footage, as H.264 video."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from motorcade.ga import Trajectory
from motorcade.replays.artifacts import ASIDE
from motorcade.replays.recording import Recording
from motorcade.replays.stages.placed import Placed
from motorcade.replays.stages.smoothed import Smoothed


@dataclass(frozen=True)
class Overlay:
    """A video file, how many of its frames show the character, and what rendering took."""

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

    Frames without a pose (lost, or outside the path) are shown as they are. Raises `Unavailable`
    without OpenGL, and ValueError for a representation that was not smoothed.
    """
    trajectory = _chosen(smoothed, representation)
    raise NotImplementedError


def _chosen(smoothed: Smoothed, representation: str) -> Trajectory:
    if representation not in smoothed.trajectories:
        known = ", ".join(smoothed.trajectories)
        raise ValueError(
            f"overlay.representation: expected one of {known}, came {representation!r}"
        )
    return smoothed.trajectories[representation]
