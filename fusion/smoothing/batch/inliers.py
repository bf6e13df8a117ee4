"""Which poses of a path are inliers of one smooth motion, and which are not: a robust first guess.

Wrong poses often come in runs that agree with each other, such as a planar marker's wrong candidate
over ten frames; then no average over a window tells right from wrong. The path is cut wherever it
leaps, and of the pieces that chain is taken which keeps the most poses at the least price for its
joints, by dynamic programming. A joint costs the squared error of extrapolating with the speed
at both sides, in deviations that the motion model allows, but never more than 20 poses: runs of up
to twice as many are left out, longer ones are kept with both their leaps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.native import _columns
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

# Gaps are bridged by the speed of so many steps to both sides.
_NEIGHBOURS = 3
# Sizes in rad and m that rounding leaves.
_FINEST = 1e-8
# Of a normal vector of three components.
_MEDIAN_OF_NORM, _QUARTILE_OF_NORM = 1.5382, 2.0269


class Sizes(NamedTuple):
    """Deviation of a measured pose, and density of its white acceleration, of one block."""

    noise: float
    acceleration: float


def inlier_poses(
    time_s: FloatArray, poses: Motor, rotation: Sizes, translation: Sizes
) -> NDArray[np.bool_]:
    """Which of the poses ``(N,)`` belong to the longest smooth chain; at least one does.

    Args:
        time_s: ``(N,)`` increasing.
        poses: as measured.
        rotation: in rad and rad/s²/√Hz.
        translation: in m and m/s²/√Hz.
    """
    kept = np.ones(len(poses), dtype=np.bool_)
    if len(poses) >= 3:
        coefficients = np.ascontiguousarray(poses.coefficients, dtype=np.float64)
        _columns.chain(np.ascontiguousarray(time_s), coefficients, rotation, translation, kept)
    return kept


def bridged(time_s: FloatArray, poses: Motor, kept: NDArray[np.bool_]) -> Motor:
    """The path ``(N,)`` with the poses that are not kept put between their neighbours.

    In a gap the pose goes on with the speed at both sides, and what is missing at the far end is
    made up evenly along it; so a gap may hold full revolutions. Beyond the ends it stands still.
    """
    rows = np.flatnonzero(kept)
    lost = np.flatnonzero(~kept)
    if lost.size == 0 or rows.size == 1:
        return poses[rows[np.zeros(len(kept), dtype=np.int64)]] if lost.size else poses
    coefficients = np.array(poses.coefficients)
    coefficients[: rows[0]], coefficients[rows[-1] :] = coefficients[rows[[0, -1]]]
    gaps, speed, missing = crossings(time_s, poses, kept)
    lost = lost[(lost > rows[0]) & (lost < rows[-1])]
    if lost.size:
        gap = np.searchsorted(gaps[:, 1], lost)
        before = gaps[gap, 0]
        passed_s = (time_s[lost] - time_s[before])[:, None]
        share = passed_s / (time_s[gaps[gap, 1]] - time_s[before])[:, None]
        moved = Motor.from_twist(speed[gap] * passed_s) @ Motor.from_twist(missing[gap] * share)
        coefficients[lost] = (poses[before] @ moved).coefficients
    return Motor(coefficients)


def crossings(
    time_s: FloatArray, poses: Motor, kept: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Gaps between kept poses: both ends ``(G, 2)``, speed over them, and what it misses by.

    The speed ``(G, 6)`` is the median of that at both sides, the other a twist ``(G, 6)``.
    """
    rows = np.flatnonzero(kept)
    span_s = np.diff(time_s[rows])
    gap, whole = (np.flatnonzero(one) for one in (np.diff(rows) > 1, np.diff(rows) == 1))
    speed = np.zeros((len(gap), 6))
    if whole.size and gap.size:
        steps = (poses[rows[whole]].inverse() @ poses[rows[whole + 1]]).as_twist()
        rates = steps / span_s[whole, None]
        around = np.searchsorted(whole, gap)[:, None] + np.arange(-_NEIGHBOURS, _NEIGHBOURS)
        speed = np.median(rates[np.clip(around, 0, len(whole) - 1)], axis=1)
    before, after = rows[gap], rows[gap + 1]
    arrival = poses[before] @ Motor.from_twist(speed * span_s[gap, None])
    return np.stack([before, after], axis=1), speed, (arrival.inverse() @ poses[after]).as_twist()


def first_sizes(trajectory: Trajectory) -> tuple[Sizes, Sizes]:
    """Rotation and translation, as differences of measured poses tell: on the wide side."""
    time_s, poses = trajectory.time_s, trajectory.poses.rigid
    interval_s = np.diff(time_s)[:, None]
    changes = np.diff((poses[:-1].inverse() @ poses[1:]).as_twist() / interval_s, axis=0)
    blocks = changes[:, :3], changes[:, 3:]
    rotation, translation = (
        Sizes(max(noise, _FINEST), max(_usual_density(part, interval_s), _FINEST))
        for noise, part in zip(_first_noise(poses, time_s), blocks, strict=True)
    )
    return rotation, translation


def _usual_density(changes: FloatArray, interval_s: FloatArray) -> float:
    """Density of white acceleration that would explain the upper quartile of changes of speed."""
    usual = float(np.quantile(np.linalg.norm(changes, axis=1), 0.75))
    return usual / (_QUARTILE_OF_NORM * float(np.sqrt(np.median(interval_s))))


def _first_noise(poses: Motor, time_s: FloatArray) -> tuple[float, float]:
    """Noise (rad, m) that would explain the median third difference, as if stamps were even.

    The square of a third difference of white noise is 20 times that of the noise.
    """
    interval_s = np.diff(time_s)[:, None]
    rates = (poses[:-1].inverse() @ poses[1:]).as_twist() / interval_s
    third = np.diff(rates, n=2, axis=0) * np.median(interval_s)
    rotation, translation = (
        float(np.median(np.linalg.norm(part, axis=1))) / (_MEDIAN_OF_NORM * np.sqrt(20.0))
        for part in (third[:, :3], third[:, 3:])
    )
    return rotation, translation
