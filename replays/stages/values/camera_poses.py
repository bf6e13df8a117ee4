"""Measured poses of the camera, however they were found."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.engine.aside import ASIDE
from motorcade.replays.stages.values.inertial_history import InertialHistory
from motorcade.replays.stages.values.sighted_points import SightedPoints
from motorcade.tracking import PoseMeasurements
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.cameras import DepthCamera
from motorcade.tracking.frame_history import SlamHistory

PoseOrigin = Literal["board", "markers", "slam", "simulated", "turning"]
HELD_HEIGHT = 1.5
"""Of a camera that only turns above the floor: an adult's chest or eyes, were the unit a metre."""


@dataclass(frozen=True, eq=False)
class CameraPoses:
    """Measured poses `world_T_camera`, and every stamp at which one was looked for.

    Fields:
        measurements: N poses with covariances.
        frame_times_ns: ``(F,)`` stamps at which a pose was looked for.
        reprojection_px: ``(N,)``, NaN where nothing was reprojected.
        origin: how the poses were found.
        summary: the same in one line.
        metric: False where the unit of length is free (SLAM by one camera alone, where no IMU
            tells it).
        points: ``(p, 3)`` of the map, where SLAM made one.
        metres_a_unit, scale_sigma: where an IMU gave the scale, what the map's unit was found to
            be, and the relative deviation of that.
        sighted: points that the poses were measured by, where these are no board's.
        skipped: ways that were tried before this one, with the reason.
        slam_history: what became of every frame, where SLAM tracked them.
        inertial: when and how the IMU told metres, where SLAM ran with one inside.
        audit: whether what was told of cameras, rig, board or markers agrees with what was seen.
        camera, depth_camera: what took the pictures and their depth, where the recording states
            otherwise than was found; whatever shows pictures along these poses takes these.
        has_odometry: whether the recorded odometry is in the poses already.
        seconds: what tracking took, reading and decoding the pictures included.

    >>> import numpy as np
    >>> from pathlib import Path
    >>> from motorcade.fusion.motions import MOTIONS
    >>> from motorcade.replays import Recording
    >>> from motorcade.replays.io.readers.frames.files import PictureFrames
    >>> from motorcade.replays.stages.camera.simulated_poses import simulated_poses
    >>> truth = MOTIONS["handheld"].sampled(rate_hz=100.0, duration_s=1.0)
    >>> frames = PictureFrames((Path("0.png"),), np.array([0]))
    >>> recording = Recording("by hand", Path(), "images", frames, truth=truth)
    >>> poses = simulated_poses(recording, rate_hz=20.0)
    >>> poses.origin, len(poses.measurements), poses.metric
    ('simulated', 21, True)
    """

    measurements: PoseMeasurements
    frame_times_ns: IntArray
    reprojection_px: FloatArray
    origin: PoseOrigin
    summary: str
    metric: bool = True
    points: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    metres_a_unit: float | None = None
    scale_sigma: float | None = None
    sighted: SightedPoints | None = None
    skipped: tuple[str, ...] = ()
    slam_history: SlamHistory | None = None
    inertial: InertialHistory | None = None
    audit: tuple[AuditFinding, ...] = ()
    camera: Camera | None = None
    depth_camera: DepthCamera | None = None
    has_odometry: bool = False
    seconds: float = field(default=0.0, metadata=ASIDE)

    @property
    def frames_per_s(self) -> float | None:
        """Rate of tracking, reading included; None where nothing was tracked."""
        return len(self.frame_times_ns) / self.seconds if self.seconds > 0 else None
