"""Paths of the camera that stages make of the measured poses: fused, then smoothed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray

FusedWith = Literal["imu", "odometry", "nothing"]


@dataclass(frozen=True, eq=False)
class FusedPath:
    """The path `world_T_camera` at N stamps, and how it came about.

    Fields:
        trajectory: the poses.
        covariance: ``(N, 6, 6)`` of the right perturbation, rotation (rad) first.
        nis: ``(N,)`` the filter's normalised innovations squared, NaN where nothing was measured
            or no filter ran.
        accepted: ``(N,)`` false where the filter left a measurement out.
        by: what was fused with the camera's poses.
        summary: the same in words.

    >>> import numpy as np
    >>> from motorcade.fusion.motions import MOTIONS
    >>> from motorcade.replays import FusedPath
    >>> from motorcade.replays.stages.smoothed import smoothed
    >>> path = MOTIONS["handheld"].sampled(rate_hz=50.0, duration_s=1.0)
    >>> covariance = np.broadcast_to(1e-6 * np.eye(6), (len(path), 6, 6))
    >>> nis, accepted = np.full(len(path), np.nan), np.ones(len(path), bool)
    >>> fused = FusedPath(path, covariance, nis, accepted, "nothing", "left as tracked")
    >>> list(smoothed(fused, representations=("motor", "euler"), window_s=0.2).trajectories)
    ['motor', 'euler']
    """

    trajectory: Trajectory
    covariance: FloatArray
    nis: FloatArray
    accepted: NDArray[np.bool_]
    by: FusedWith
    summary: str


@dataclass(frozen=True, eq=False)
class SmoothedPaths:
    """The smoothed path `world_T_camera`, a trajectory for each representation.

    `window_s` is the width of the window used; None where the path was left as it was, because
    any smoothing would have taken away motion.

    >>> from motorcade.fusion.motions import MOTIONS
    >>> from motorcade.replays import SmoothedPaths
    >>> path = MOTIONS["handheld"].sampled(rate_hz=50.0, duration_s=1.0)
    >>> list(SmoothedPaths({"motor": path, "euler": path}, window_s=None).trajectories)
    ['motor', 'euler']
    """

    trajectories: dict[str, Trajectory]
    window_s: float | None
