"""Estimates that others made, and how far they are from ground truth step by step.

Step errors are those from one pose to the next (RPE of `motorcade.fusion.metrics`). The world and
the scale of an estimate are aligned once, by its raw path. Stamps are taken as they come; where its
turns run whole images ahead of the ground truth's, the estimate is judged a second time, in step.
So it is of S-PTAM, whose rows are one image early: turns that do not match look like noise there,
which whatever flattens them seems to take off.

`python -m tests.bench.smoothing.estimates` tells what `smooth` leaves of step errors and of jitter
(acceleration that the ground truth has not), and how far it moves a pose, in what the path's own
steps scatter: the root mean square by which a step differs from the mean of those beside it. The
farthest is of all poses; behind it stands how many go beyond the bound, and how many of these are
not called wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from motorcade.fusion.metrics import Align, Matched, evaluate, match, relative_errors
from motorcade.fusion.metrics.lag import angular_rate_lag_s
from motorcade.fusion.smoothing import smoothed_automatically
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.trajectories import read_trajectory
from tests.bench.data import data_folder

__all__ = ["ESTIMATES", "IN_STEP", "MOST_MOVED", "Estimate", "estimates", "moved_in_scatters"]

_XYZ, _DESK, _KITTI = "freiburg1_xyz-groundtruth.txt", "fr2_desk_groundtruth.txt", "KITTI_00_gt.txt"
_TIMES, _FIRST_400 = "KITTI_00_gt_times.txt", "../cases/smooth_v102_first_400.tum"
MOST_LEFT, MOST_MEAN, MOST_MOVED = 1.05, 0.85, 5.0
"""Of each figure of the raw path, of all in the geometric mean, and of a pose in own scatters."""
ESTIMATES: dict[str, tuple[str, str, Align]] = {
    "KITTI 00, ORB-SLAM": ("KITTI_00_ORB.txt", _KITTI, "se3"),
    "KITTI 00, S-PTAM": ("KITTI_00_SPTAM.txt", _KITTI, "se3"),
    "freiburg1_xyz, RGB-D SLAM": ("freiburg1_xyz-rgbdslam.txt", _XYZ, "se3"),
    "freiburg1_xyz, keyframes": ("freiburg1_xyz-ORB_kf_mono.txt", _XYZ, "sim3"),
    "fr2_desk, ORB-SLAM": ("fr2_desk_ORB.txt", _DESK, "sim3"),
    "V1_02, visual-inertial": (_FIRST_400, "../imu/V1_02_medium.csv", "se3"),
}
"""By name: files of estimate and ground truth, and what is aligned."""
IN_STEP = ", in step"
"""Follows the name of an estimate whose clock is put right."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """An estimate, and the step errors of a path like it: root mean squares in rad and in m.

    `jitter` is of a path like it too, in rad/s² and m/s².
    """

    name: str
    raw: Trajectory
    steps: Callable[[Trajectory], tuple[float, float]]
    jitter: Callable[[Trajectory], tuple[float, float]]


def estimates(folder: Path) -> Iterator[Estimate]:
    """Those whose files are there."""
    for name, (file, reference, align) in ESTIMATES.items():
        if not (folder / "trajectories" / file).exists():
            continue
        raw, true = (_read(folder / "trajectories" / one) for one in (file, reference))
        images = _images_behind(true, raw)
        for ahead in (0, images) if images else (0,):
            matched = match(raw, _moved(true, raw, ahead), align, max_difference_s=0.02)
            yield Estimate(
                f"{name}{IN_STEP if ahead else ''}",
                raw,
                partial(_steps, matched),
                partial(_jitter, _moved(true, raw, ahead), align),
            )


def _jitter(true: Trajectory, align: Align, path: Trajectory) -> tuple[float, float]:
    found = evaluate(path, true, align, 0.02).jitter
    assert found is not None
    return found.angular_rad_s2, found.linear_m_s2


def _read(file: Path) -> Trajectory:
    times = file.parent / _TIMES if file.name.startswith("KITTI") else None
    return read_trajectory(file, times=times)


def _images_behind(true: Trajectory, raw: Trajectory) -> int:
    """By how many whole images an estimate's turns lag."""
    return round(1e9 * angular_rate_lag_s(raw, true) / _interval_ns(raw))


def _moved(true: Trajectory, raw: Trajectory, images: int) -> Trajectory:
    """Ground truth with its stamps later by so many images of an estimate."""
    moved_ns = true.time_ns + round(images * _interval_ns(raw))
    return Trajectory(moved_ns, true.poses, true.parent, true.child)


def _interval_ns(path: Trajectory) -> float:
    return float(np.median(np.diff(path.time_ns)))


def _steps(matched: Matched, path: Trajectory) -> tuple[float, float]:
    poses = matched.alignment.apply(path.motors[matched.pairs.estimate_index])
    metres, radians = relative_errors(poses, matched.pairs.reference)
    return float(np.sqrt(np.mean(radians**2))), float(np.sqrt(np.mean(metres**2)))


def moved_in_scatters(raw: Trajectory, smoothed: Trajectory) -> FloatArray:
    """How far each pose is turned and moved ``(N, 2)``, in what the path's own steps scatter."""

    def sizes(twists: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.norm(twists.reshape(-1, 2, 3), axis=2))

    poses = raw.motors
    steps = (poses[:-1].inverse() @ poses[1:]).as_twist()
    beside = sizes(steps[1:-1] - 0.5 * (steps[:-2] + steps[2:]))
    moved = sizes((poses.inverse() @ smoothed.motors).as_twist())
    return np.asarray(moved / np.sqrt(np.mean(beside**2, axis=0)))


def main() -> None:
    """A line an estimate, and the geometric mean of what is left."""
    every, broken = [], []
    head = ("step, turn", "shift", "jitter, turn", "shift", "moved, turn", "shift", "beyond")
    print(f"{'left of the raw path':<34}" + "".join(f"{one:>14}" for one in head))
    for one in estimates(data_folder()):
        found = smoothed_automatically(one.raw)
        smoothed = found.trajectory
        ratios = [
            after / before
            for figure in (one.steps, one.jitter)
            for before, after in zip(figure(one.raw), figure(smoothed), strict=True)
        ]
        moved = moved_in_scatters(one.raw, smoothed)
        beyond = np.any(moved > MOST_MOVED, axis=1)
        told = f"{np.count_nonzero(beyond)}, {np.count_nonzero(beyond & (found.weights > 0.0))}"
        figures = "".join(f"{value:>14.3f}" for value in (*ratios, *moved.max(axis=0)))
        print(f"{one.name:<34}{figures}{told:>14}")
        if not one.name.endswith(IN_STEP):
            every += ratios
        if max(ratios) > MOST_LEFT or np.any(beyond):
            broken.append(one.name)
    mean = float(np.exp(np.mean(np.log(every))))
    print(f"geometric mean {mean:.3f} (at most {MOST_MEAN}); beyond bounds: {broken or 'none'}")


if __name__ == "__main__":
    main()
