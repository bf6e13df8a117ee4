"""Measured poses of the camera, however they were found; those of SLAM stand in `slam_poses`.

With each comes what was seen: the board's track, the markers' map, and points of the world with
where a camera saw them, which a path can be drawn against.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.stages.values.inertial import InertialHistory
from motorcade.tracking import BoardTrack, PoseMeasurements
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.cameras import DepthCamera
from motorcade.tracking.frame_history import SlamHistory
from motorcade.tracking.markers.marker_map import MarkerMap

ASIDE = {"aside": True}
"""Metadata for `dataclasses.field`: the field is stored, but is not part of the value's content."""


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
        camera, depth_camera: what took the images and their depth, where the recording states
            otherwise than was found; whatever shows images along these poses takes these.
        corner_px: how far noise lets a corner scatter in these images, standard deviation; 0 where
            that was not looked at.
        has_odometry: whether the recorded odometry is in the poses already.
        seconds: what tracking took, reading and decoding the images included.

    >>> import numpy as np
    >>> from pathlib import Path
    >>> from motorcade.fusion.motions import MOTIONS
    >>> from motorcade.replays import Recording
    >>> from motorcade.replays.io.readers.frames.files import ImageFrames
    >>> from motorcade.replays.stages.camera.simulated_poses import simulated_poses
    >>> truth = MOTIONS["handheld"].sampled(rate_hz=100.0, duration_s=1.0)
    >>> frames = ImageFrames((Path("0.png"),), np.array([0]))
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
    corner_px: float = 0.0
    has_odometry: bool = False
    seconds: float = field(default=0.0, metadata=ASIDE)

    @property
    def frames_per_s(self) -> float | None:
        """Rate of tracking, reading included; None where nothing was tracked."""
        return len(self.frame_times_ns) / self.seconds if self.seconds > 0 else None


@dataclass(frozen=True, eq=False, kw_only=True)
class BoardPoses(CameraPoses):
    """Poses by a board.

    Fields:
        track: the corners and both planar candidates of every frame.
        corners_m: ``(n, 3)`` where the board's corners are, which paper that curls does not say.
    """

    track: BoardTrack
    corners_m: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class MarkerPoses(CameraPoses):
    """Poses by loose markers; `marker_map` says where these stand in the same world."""

    marker_map: MarkerMap


@dataclass(frozen=True, eq=False)
class SightedPoints:
    """Points that stand still, as one camera saw them.

    Fields:
        camera: who saw them, with the distortion of `px`.
        time_ns: ``(F,)`` stamps of frames.
        frame: ``(n,)`` row of `time_ns` of each observation.
        points: ``(n, 3)`` in the world of the measured poses and in its unit.
        px: ``(n, 2)`` where they were seen.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.replays.stages.values.camera_poses import SightedPoints
    >>> from motorcade.tracking import Camera
    >>> camera = Camera(640, 480, 300.0, 300.0, 319.5, 239.5)
    >>> row, point, px = np.array([0]), np.array([[0.0, 0.0, 2.0]]), np.array([[319.5, 239.5]])
    >>> seen = SightedPoints(camera, np.array([0]), row, point, px)
    >>> beside = Trajectory([0], Motor.from_translation([[0.01, 0.0, 0.0]]))  # world_T_camera
    >>> seen.registration_px(beside).round(6)
    array([1.5])
    """

    camera: Camera
    time_ns: IntArray
    frame: IntArray
    points: FloatArray
    px: FloatArray

    def registration_px(self, path: Trajectory) -> FloatArray:
        """How far points drawn along a path lie from where they were seen, a frame.

        Returns:
            ``(M,)`` root mean square over the points of each frame that has some and lies within
            the path's span; NaN where one is behind the camera.
        """
        stamps = self.time_ns[self.frame]
        inside = (stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1])
        world_T_camera = path.motors_at(stamps[inside])
        expected = self.camera.project(world_T_camera.inverse().apply(self.points[inside]))
        squares = np.sum((expected - self.px[inside]) ** 2, axis=-1)
        count = np.bincount(self.frame[inside], minlength=len(self.time_ns))
        total = np.bincount(self.frame[inside], squares, minlength=len(self.time_ns))
        return np.asarray(np.sqrt(total[count > 0] / count[count > 0]))
