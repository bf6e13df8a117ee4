"""Camera poses by visual SLAM: no board needed.

The world is the first camera that has a pose; where an IMU gives one camera's map its metres, the
world stands upright where that map has its origin.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motorcade.ga import FloatArray, Motor
from motorcade.replays.engine.progress import track
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera.metres import Metres, NoMetres, in_metres
from motorcade.tracking import PoseMeasurements, TrackingError

if TYPE_CHECKING:
    from motorcade.tracking.slam import MapSnapshot, SlamResult

__all__ = ["SlamPoses", "slam_poses"]

_SIGMA_FLOOR_RAD, _SIGMA_FLOOR_M = 1e-4, 1e-4


@dataclass(frozen=True, eq=False)
class SlamPoses:
    """What SLAM measured.

    Args:
        measurements: `world_T_camera` of the frames that have a pose.
        metric: whether lengths are metres; with one camera alone their unit is free, unless an
            IMU tells it.
        points: ``(p, 3)`` of the map, in the same world.
        map: the map as it may be saved and gone on in, in a world of its own.
        seconds: time it took, reading and decoding included.
        account: where lengths come from.
        metres_a_unit, scale_sigma: what the IMU found the map's unit to be, and the relative
            deviation of that; None where it was not asked, or did not tell.
    """

    measurements: PoseMeasurements
    metric: bool
    points: FloatArray
    map: MapSnapshot
    seconds: float
    account: str
    metres_a_unit: float | None = None
    scale_sigma: float | None = None


def slam_poses(
    recording: Recording,
    *,
    adjust: bool = True,
    close_loops: bool = True,
    threads: bool = False,
) -> SlamPoses:
    """Track a recording by what it sees, with its depth or else its right pictures if it has any.

    In a saved map of the place, where the recording brings one, it goes on: the world is then that
    map's, and until the camera finds itself in it there is no pose. The covariance is that of each
    frame's pose within the map; that the map itself drifts is not in it. `adjust`, `close_loops`
    and `threads` are those of `SlamSettings`.

    Raises:
        ValueError: no camera known.
        TrackingError: nothing in the pictures from which a map could start.
    """
    from motorcade.tracking.slam import SlamSettings, VisualSlam

    if recording.camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    start = time.perf_counter()
    paired = recording.baseline_m is not None and recording.frames[0].read_depth is None
    settings = SlamSettings(
        adjust=adjust,
        close_loops=close_loops,
        threads=threads,
        baseline_m=recording.baseline_m if paired else None,
    )
    known = recording.slam_map
    slam = VisualSlam(recording.camera, settings, known=known, extend=known is not None)
    for frame in track(recording.frames, "mapping", len(recording.frames)):
        right = frame.right() if paired else None
        slam.track(frame.time_ns, frame.gray(), frame.depth_m(), right)
    found = slam.finish()
    if found.trajectory is None:
        raise TrackingError(
            f"{recording.name}: visual SLAM found no pose: too little texture, or a camera that "
            "only turns; camera_poses.source=simulated or a board would do"
        )
    if found.metric:
        return _as_mapped(found, known is not None, "with depth", start)
    try:
        metres = in_metres(recording, found)
    except NoMetres as why:
        told = f"by one camera (scale: free, lengths have no unit; {why})"
        return _as_mapped(found, known is not None, told, start)
    return _by_inertia(found, metres, start)


def _as_mapped(found: SlamResult, resumed: bool, account: str, start: float) -> SlamPoses:
    """The path as it was tracked."""
    path = found.trajectory
    if path is None:
        raise ValueError("found: expected a run of SLAM that found poses, got none")
    floor = np.repeat((_SIGMA_FLOOR_RAD**2, _SIGMA_FLOOR_M**2), 3)
    covariance: FloatArray = found.covariance + np.diag(floor)
    first_T_world = Motor.identity() if resumed else path.motors[0].inverse()
    return SlamPoses(
        PoseMeasurements(path.transformed_by(left=first_T_world), covariance),
        found.metric,
        first_T_world.apply(found.map.points),
        found.map,
        time.perf_counter() - start,
        account,
    )


def _by_inertia(found: SlamResult, metres: Metres, start: float) -> SlamPoses:
    """The path in metres, z up."""
    unit, sigma = metres.made.metres_a_unit, metres.scale_sigma
    return SlamPoses(
        metres.made.measurements,
        True,
        metres.made.keyframes.landmarks_m,
        found.map,
        time.perf_counter() - start,
        f"by one camera, metres and up found by the IMU (the map's unit is {unit:.4g} m "
        f"± {100 * sigma:.2g} %)",
        unit,
        sigma,
    )
