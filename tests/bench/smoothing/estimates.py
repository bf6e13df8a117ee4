"""Estimates that others made, and how far they are from ground truth step by step.

Step errors are those from one pose to the next (RPE of `motorcade.fusion.metrics`). The world and
the scale of an estimate are aligned once, by its raw path. Stamps are taken as they come; where its
turns run whole pictures ahead of the ground truth's, the estimate is judged a second time, in step.
So it is of S-PTAM, whose rows are one picture early: turns that do not match look like noise there,
which whatever flattens them seems to take off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from motorcade.fusion.metrics import Align, Matched, match, relative_errors
from motorcade.fusion.metrics.lag import angular_rate_lag_s
from motorcade.ga import Trajectory
from motorcade.replays.io.trajectories import read_trajectory

__all__ = ["ESTIMATES", "IN_STEP", "Estimate", "estimates"]

_XYZ, _DESK, _KITTI = "freiburg1_xyz-groundtruth.txt", "fr2_desk_groundtruth.txt", "KITTI_00_gt.txt"
_TIMES = "KITTI_00_gt_times.txt"
ESTIMATES: dict[str, tuple[str, str, Align]] = {
    "KITTI 00, ORB-SLAM": ("KITTI_00_ORB.txt", _KITTI, "se3"),
    "KITTI 00, S-PTAM": ("KITTI_00_SPTAM.txt", _KITTI, "se3"),
    "freiburg1_xyz, RGB-D SLAM": ("freiburg1_xyz-rgbdslam.txt", _XYZ, "se3"),
    "freiburg1_xyz, keyframes": ("freiburg1_xyz-ORB_kf_mono.txt", _XYZ, "sim3"),
    "fr2_desk, ORB-SLAM": ("fr2_desk_ORB.txt", _DESK, "sim3"),
}
"""By name: files of estimate and ground truth, and what is aligned."""
IN_STEP = ", in step"
"""Follows the name of an estimate whose clock is put right."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """An estimate, and the step errors of a path like it: root mean squares in rad and in m."""

    name: str
    raw: Trajectory
    steps: Callable[[Trajectory], tuple[float, float]]


def estimates(folder: Path) -> Iterator[Estimate]:
    """Those whose files are there."""
    for name, (file, reference, align) in ESTIMATES.items():
        if not (folder / "trajectories" / file).exists():
            continue
        raw, true = (_read(folder / "trajectories" / one) for one in (file, reference))
        pictures = _pictures_behind(true, raw)
        for ahead in (0, pictures) if pictures else (0,):
            matched = match(raw, _moved(true, raw, ahead), align, max_difference_s=0.02)
            yield Estimate(f"{name}{IN_STEP if ahead else ''}", raw, partial(_steps, matched))


def _read(file: Path) -> Trajectory:
    times = file.parent / _TIMES if file.name.startswith("KITTI") else None
    return read_trajectory(file, times=times)


def _pictures_behind(true: Trajectory, raw: Trajectory) -> int:
    """By how many whole pictures an estimate's turns lag."""
    return round(1e9 * angular_rate_lag_s(raw, true) / _interval_ns(raw))


def _moved(true: Trajectory, raw: Trajectory, pictures: int) -> Trajectory:
    """Ground truth with its stamps later by so many pictures of an estimate."""
    moved_ns = true.time_ns + round(pictures * _interval_ns(raw))
    return Trajectory(moved_ns, true.poses, true.parent, true.child)


def _interval_ns(path: Trajectory) -> float:
    return float(np.median(np.diff(path.time_ns)))


def _steps(matched: Matched, path: Trajectory) -> tuple[float, float]:
    poses = matched.alignment.apply(path.motors[matched.pairs.estimate_index])
    metres, radians = relative_errors(poses, matched.pairs.reference)
    return float(np.sqrt(np.mean(radians**2))), float(np.sqrt(np.mean(metres**2)))
