"""Paths of the camera that stages make of the measured poses: fused, then smoothed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.findings import LatencyCurve, LearntNoise
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
        noise: what was learnt of the IMU's noise, where that was asked for; else None.
        latency: what looking ahead by less would leave, where that was asked for; else None.
        held_out: the path made without every fifth measured pose, which it is judged by where
            there is no ground truth; else None.
        lag_s: how much later a pose may be told, in seconds, so that it knows what was measured
            until then; infinite where it may know all of the recording.

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
    noise: LearntNoise | None = None
    latency: LatencyCurve | None = None
    held_out: Trajectory | None = None
    lag_s: float = np.inf


@dataclass(frozen=True, eq=False)
class SmoothedPaths:
    """The smoothed path `world_T_camera`, a trajectory for each representation.

    `method` is the smoother's name and `parameters` are its numbers, in its own units; None and
    empty where the path was left as it was, because any smoothing would have taken away motion or
    was done in fusing. `held_out` is the first representation's path, made of `FusedPath.held_out`.

    >>> from motorcade.fusion.motions import MOTIONS
    >>> from motorcade.replays import SmoothedPaths
    >>> path = MOTIONS["handheld"].sampled(rate_hz=50.0, duration_s=1.0)
    >>> list(SmoothedPaths({"motor": path, "euler": path}, None, {}).trajectories)
    ['motor', 'euler']
    """

    trajectories: dict[str, Trajectory]
    method: str | None
    parameters: dict[str, float | str]
    held_out: Trajectory | None = None
