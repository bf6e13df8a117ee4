"""Measured poses that are held out, so that a path can be judged where no ground truth is.

Every fifth measured pose is left out, the stage is run again without them, and the path is asked
where the camera was there. What comes of the tracked poses alone is their cubic: a fair rival, as
it bends with the motion. Errors that last from frame to frame, as of a wrong calibration, are in
the held-out poses as well, and are not seen.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.tracking import PoseMeasurements

EVERY = 5
"""Of so many measured poses one is held out: its neighbours on both sides are kept, and those that
a cubic takes besides."""
FEWEST = 40
"""Measured poses below which too few are held out (8) for a root mean square to mean anything."""
REACH = 3.0
"""A held-out pose with no kept one within so many usual intervals stands in a gap, where only
prediction is judged, not the path."""


def held_out(count: int) -> NDArray[np.bool_]:
    """Which of so many measured poses ``(count,)`` are held out; none of a few."""
    rows = np.arange(count) % EVERY == EVERY // 2
    return rows if count >= FEWEST else np.zeros(count, dtype=np.bool_)


def without_held_out(camera_poses: CameraPoses) -> CameraPoses | None:
    """The measured poses that are kept; None where there are too few to hold any out."""
    found = camera_poses.measurements
    kept = ~held_out(len(found))
    if kept.all():
        return None
    measurements = PoseMeasurements(found.trajectory[kept], found.covariance[kept])
    return replace(
        camera_poses, measurements=measurements, reprojection_px=camera_poses.reprojection_px[kept]
    )


def judged_stamps(measured: Trajectory) -> IntArray:
    """Stamps of held-out poses with kept ones near on both sides."""
    out = held_out(len(measured))
    kept_ns, stamps = measured.time_ns[~out], measured.time_ns[out]
    after = np.searchsorted(kept_ns, stamps)
    inside = (after > 1) & (after < len(kept_ns) - 1)
    stamps, after = stamps[inside], after[inside]
    usual_ns = float(np.median(np.diff(measured.time_ns)))
    near: NDArray[np.bool_] = kept_ns[after] - kept_ns[after - 1] <= REACH * usual_ns
    return stamps[near]


def at_stamps(path: Trajectory, stamps: IntArray) -> Motor:
    """Poses ``(n,)`` of a path: its own where it has some there, else the cubic of four neighbours.

    The stamps have two poses of the path on both sides.
    """
    row = np.searchsorted(path.time_ns, stamps)
    own = path.time_ns[np.minimum(row, len(path) - 1)] == stamps
    first = np.clip(row - 2, 0, len(path) - 4)
    rows = np.where(own[:, None], row[:, None], first[:, None] + np.arange(4))
    base = path.motors[rows[:, 1]]
    around = base[:, None].local(path.motors[rows])
    times = (path.time_ns[rows] - stamps[:, None]) * 1e-9
    weights = _lagrange(np.where(own[:, None], np.arange(4), times))  # of one pose, any would do
    return base.retract(np.einsum("nk,nkc->nc", weights, around))


def _lagrange(times: FloatArray) -> FloatArray:
    """Weights ``(n, 4)`` of the cubic through times ``(n, 4)``, at zero."""
    weights = np.ones_like(times)
    for k in range(4):
        for j in range(4):
            if j != k:
                weights[:, k] *= -times[:, j] / (times[:, k] - times[:, j])
    return weights
