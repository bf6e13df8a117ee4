"""Overshoot: how far an estimate runs on where the truth stops or turns back.

A stop or turn is a local minimum of the truth's speed (linear, or angular) that lies below a fifth
of the speed's peaks on both sides; the end of the trajectory may stand for the second. The
direction is that of the truth's way from the peak before to the minimum. From the peak before to
the peak after, overshoot is the farthest the estimate gets in that direction, less the farthest
the truth gets, and never below zero. As whole stretches are compared, an estimate that is merely
late has none; noise has some, and so has a constant offset: compare with the raw poses. For
rotations the way is the rotation vector seen from the pose at the minimum. It is the maximum
overshoot of a step response (K. Ogata, Modern Control Engineering), in metres or radians and for
any motion.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from motorcade.fusion.metrics.smooth_path import NotObservableError, SmoothPath
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

__all__ = ["position_overshoot_m", "rotation_overshoot_rad", "stops"]

_STOP_SHARE = 0.2
# Speeds below this part of the fastest are standing still.
_STILL_SHARE = 1e-6
# Speeds nearer to each other than this are equal, and the first one counts in every frame.
_TIE = 1e-9

# Way (*, 3) from the first pose to the second, as seen from the first.
Way = Callable[[Motor, Motor], FloatArray]


def position_overshoot_m(estimate: Trajectory, truth: Trajectory) -> float:
    """Largest overshoot of the position in metres; the worlds must be aligned.

    Raises:
        NotObservableError: fewer than five stamps within the truth, or a truth that neither stops
            nor turns back on its way.

    Examples:
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import position_overshoot_m
        >>> from motorcade.fusion.motions import stop_and_go
        >>> true = stop_and_go().sampled(50.0, 8.0)
        >>> late = smooth(true, "double_exponential", cutoff_hz=1.0)
        >>> for path in (late, true):
        ...     print(f"{position_overshoot_m(path, true):.2f} m")
        0.13 m
        0.00 m
    """
    return _overshoot(estimate, truth, lambda at, poses: poses.translation_m - at.translation_m)


def rotation_overshoot_rad(estimate: Trajectory, truth: Trajectory) -> float:
    """Largest overshoot of the orientation in radians, in the moving frame of the truth.

    Turns between neighbouring peaks of the angular rate must stay below half a turn.

    Raises:
        NotObservableError: as `position_overshoot_m`.

    Examples:
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import rotation_overshoot_rad
        >>> from motorcade.fusion.motions import stop_and_go
        >>> true = stop_and_go().sampled(50.0, 8.0)
        >>> late = smooth(true, "double_exponential", cutoff_hz=1.0)
        >>> print(f"{rotation_overshoot_rad(late, true):.2f} rad")
        0.13 rad
    """
    return _overshoot(
        estimate,
        truth,
        lambda at, poses: (at.rotor.inverse() @ poses.rotor).as_rotation_vector(),
    )


def _overshoot(estimate: Trajectory, truth: Trajectory, way: Way) -> float:
    path = SmoothPath.through(truth)
    time_s = path.seconds(estimate.time_ns)
    kept = np.flatnonzero(path.covers(time_s))
    if kept.size < 5:
        raise NotObservableError(
            f"overshoot: expected 5 or more stamps within the truth, got {kept.size}"
        )
    ours, true = estimate.motors[kept], path.poses(time_s[kept])
    speed = np.linalg.norm(way(true[:-1], true[1:]), axis=-1) / np.diff(time_s[kept])
    found = []
    for before, stop, after in stops(speed):
        at, stretch = true[stop], slice(before, after + 1)
        course = -way(at, true[before])
        length = float(np.linalg.norm(course))
        if length > 0.0:
            true_way, our_way = (way(at, poses[stretch]) @ course for poses in (true, ours))
            found.append(float(np.max(our_way) - np.max(true_way)) / length)
    if not found:
        raise NotObservableError(
            "overshoot: expected a truth that stops or turns back on its way, got none"
        )
    return max(0.0, *found)


def stops(speed: FloatArray) -> list[tuple[int, int, int]]:
    """Peak before, minimum and peak after (or the end), for speeds ``(N-1,)`` of steps.

    A minimum follows a peak once the speed is below a fifth of it, and a peak follows a minimum
    once the speed is five times as high again.
    """
    moving = np.where(speed > _STILL_SHARE * float(np.max(speed)), speed, 0.0)
    extremes = [0]
    falling = False
    for i, now in enumerate(moving):
        best = moving[extremes[-1]]
        if falling:
            turned, better = _STOP_SHARE * now > best, now < (1.0 - _TIE) * best
        else:
            turned, better = now < _STOP_SHARE * best, now > (1.0 + _TIE) * best
        if turned:
            extremes.append(i)
            falling = not falling
        elif better:
            extremes[-1] = i
    peaks, stops = extremes[::2], extremes[1::2]
    ends = [*peaks[1:], moving.size]
    return list(zip(peaks, stops, ends, strict=False))
