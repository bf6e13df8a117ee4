"""Everything that a report tells of: the outputs of a run's stages, in one value."""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.fusion.filter import Fused
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera_poses import CameraPoses
from motorcade.replays.stages.convergence import Convergence
from motorcade.replays.stages.errors import Errors
from motorcade.replays.stages.imu import Imu
from motorcade.replays.stages.overlay import Overlay
from motorcade.replays.stages.smoothed import Smoothed


@dataclass(frozen=True)
class Findings:
    """Stage outputs under their stages' names; `overlay` is None where nothing could be drawn."""

    recording: Recording
    camera_poses: CameraPoses
    imu: Imu
    fused: Fused
    smoothed: Smoothed
    convergence: Convergence
    errors: Errors
    overlay: Overlay | None

    @property
    def frames_per_second(self) -> float | None:
        """Rate of tracking, reading included; None where nothing was tracked."""
        poses = self.camera_poses
        return len(poses.sought_ns) / poses.seconds if poses.seconds > 0 else None

    @property
    def tracked_share(self) -> float:
        """Measured poses over stamps at which one was sought."""
        return len(self.camera_poses.measurements.trajectory) / len(self.camera_poses.sought_ns)
