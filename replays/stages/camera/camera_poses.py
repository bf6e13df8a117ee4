"""Stage `camera_poses`: where the camera was, by whatever way of measuring was chosen."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.engine.stage import Chosen
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.tracking import PoseMeasurements


def camera_poses(
    tracked: Chosen[CameraPoses], *, blackouts_s: tuple[float, ...] = ()
) -> CameraPoses:
    """Take the poses that were measured, less those within blackouts.

    `tracked` is the first that works of four stages, and says which were skipped and why: the
    board, if the recording names one and it is seen; loose markers, if a family is named or
    corners were recorded; visual SLAM, with depth where there is some, else by one camera, whose
    scale is free unless a recorded IMU tells it; last a simulation from the ground truth. The
    world is the board's, that of the marker that was seen most, the first camera's, or an upright
    one where an IMU gave the metres. `tracked.by=...` names one of them instead.

    `blackouts_s` (start, end, start, end, … in seconds after the first stamp) are spans in which
    no pose is measured, whatever the way.

    Raises ValueError where the blackouts leave no pose.
    """
    poses = tracked.value
    times_ns = poses.measurements.trajectory.time_ns
    seen = ~_inside(times_ns, _spans(blackouts_s), int(poses.frame_times_ns[0]))
    if not np.any(seen):
        raise ValueError("camera_poses.blackouts_s: no measured pose is left; shorten the spans")
    common = {field.name: getattr(poses, field.name) for field in fields(CameraPoses)}
    return CameraPoses(
        **common
        | {
            "measurements": PoseMeasurements(
                poses.measurements.trajectory[seen], poses.measurements.covariance[seen]
            ),
            "reprojection_px": poses.reprojection_px[seen],
            "skipped": tracked.skipped,
        }
    )


def _spans(blackouts_s: tuple[float, ...]) -> FloatArray:
    if len(blackouts_s) % 2:
        raise ValueError(
            f"camera_poses.blackouts_s: expected start, end pairs, got {len(blackouts_s)} numbers"
        )
    spans = np.array(blackouts_s, dtype=np.float64).reshape(-1, 2)
    if np.any(spans[:, 1] <= spans[:, 0]):
        raise ValueError("camera_poses.blackouts_s: expected every end after its start")
    return spans


def _inside(time_ns: IntArray, spans: FloatArray, first_ns: int) -> NDArray[np.bool_]:
    seconds = (time_ns - first_ns) * 1e-9
    inside = np.zeros(seconds.shape, dtype=np.bool_)
    for start, end in spans:
        inside |= (seconds >= start) & (seconds < end)
    return inside
