"""Which poses the others predict well enough to call them wrong, and whether a path is resolved.

That a run of poses lies off the path that bridges it says nothing where such a bridge errs as much
over good poses: where motion is jerky, or the run is long. How much it errs is told by the path
itself: stretches of good poses as long as the run, next to it, are left out and bridged likewise
(cross-validation that leaves out blocks: P. Burman, E. Chow, D. Nolan, A cross-validatory method
for dependent data, Biometrika 81, 1994).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.batch.inliers import bridged
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# A run is wrong where it lies off by more than so many times what good poses do: three deviations.
_WRONG = 3.0
# Stretches to both sides of a run that its prediction is judged by, and good poses between them,
# which tell the speed.
_BESIDE, _BETWEEN = 6, 4
_FEWEST = 2
# Where a larger share of the poses would be left out, they must differ from the others.
_MANY = 0.1
# By how much rougher than usual the path must then be where it goes over to them.
_ROUGHER = 3.0
# Errors that last are not seen in third differences: of those that keep 0.97 of the one before an
# eighth is. A path that lies off good poses by more than so many times these is not near them.
_FAR = 10.0
# The square of a third difference of white noise is so many times that of the noise.
_THIRD = 20.0
# Of the way that a path spans, what rounding explains.
_ROUNDING = 1e-9

Kept = NDArray[np.bool_]


def with_unpredicted(time_s: FloatArray, poses: Motor, kept: Kept) -> Kept:
    """The poses that are kept ``(N,)``, and those left out that the kept ones do not predict.

    Args:
        time_s: ``(N,)`` increasing.
        poses: as measured.
        kept: which belong to the motion.
    """
    runs = np.flatnonzero(np.diff(np.concatenate([[0], ~kept, [0]]))).reshape(-1, 2)
    rows = np.flatnonzero(kept)
    if not len(runs) or not np.any(kept[1:] & kept[:-1]):
        return kept
    off = _off(poses, bridged(time_s, poses, kept))
    speed = _off(poses[1:], poses[:-1]) / np.diff(time_s)[:, None]
    fastest = _WRONG * _size(speed[kept[1:] & kept[:-1]])
    usual_s = float(np.median(np.diff(time_s[rows])))
    lengths = np.array([min(_length(time_s, run, usual_s), len(rows)) for run in runs])
    made = kept.copy()
    for length in np.unique(lengths):
        own = runs[lengths == length]
        stretches = np.arange(_BETWEEN, len(rows) - length - _BETWEEN + 1, length + _BETWEEN)
        bridging, steps = _errors(time_s, poses, rows, stretches, int(length))
        for first, last in own:
            place = int(np.searchsorted(rows[stretches], first))
            errors, judged = bridging, slice(first, last)
            if first == 0 or last == len(kept):
                # Nothing is bridged there: the step over to the run is judged as one.
                errors = steps
                judged = slice(last - 1, last) if first == 0 else slice(first, first + 1)
            near = errors[max(place - _BESIDE, 0) : place + _BESIDE]
            allowed = _WRONG * np.sqrt(np.mean(near**2, axis=0)) if len(near) >= _FEWEST else np.inf
            inside = speed[first : last - 1]
            if len(inside) and np.any(np.median(inside, axis=0) > fastest):
                continue  # its poses do not agree with each other either
            if not np.any(_size(off[judged]) > allowed):
                made[first:last] = True
    return made


def _length(time_s: FloatArray, run: IntArray, usual_s: float) -> int:
    """Good poses in as long a time as a run and the gaps beside it take, in powers of √2."""
    first, last = max(int(run[0]) - 1, 0), min(int(run[1]), len(time_s) - 1)
    count = max(round((time_s[last] - time_s[first]) / usual_s) - 1.0, 1.0)
    return int(np.ceil(2.0 ** (np.ceil(2.0 * np.log2(count)) / 2.0) - 1e-9))


def _errors(
    time_s: FloatArray, poses: Motor, rows: IntArray, stretches: IntArray, length: int
) -> tuple[FloatArray, FloatArray]:
    """Errors ``(S, 2)`` over so many of the kept rows, from some of their places on.

    These are of bridging them, and of standing still for the step before.
    """
    among = np.ones(len(rows), dtype=np.bool_)
    inside = stretches[:, None] + np.arange(length)
    among[inside] = False
    good = poses[rows]
    bridging = _off(good, bridged(time_s[rows], good, among))[inside]
    return _size(bridging), _off(good[stretches], good[stretches - 1])


def _off(poses: Motor, predicted: Motor) -> FloatArray:
    """By how much each lies off, in rad and m ``(N, 2)``."""
    apart = (predicted.inverse() @ poses).as_twist()
    return np.stack([np.linalg.norm(apart[:, :3], axis=1), np.linalg.norm(apart[:, 3:], axis=1)], 1)


def _size(off: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(off**2, axis=-2)), dtype=np.float64)


def unresolved(measured: Trajectory, smoothed: Trajectory, kept: Kept) -> str:
    """Why a smoothed path is not to be trusted; empty where it is.

    Args:
        measured: poses.
        smoothed: at the same stamps.
        kept: which of the measured poses ``(N,)`` counted.
    """
    poses = measured.poses.rigid
    if np.mean(~kept) > _MANY and _go_over_smoothly(poses, kept):
        return "their motion is not resolved"
    steps = (poses[:-1].inverse() @ poses[1:]).as_twist()
    third = np.diff(steps, n=2, axis=0)[kept[:-3] & kept[1:-2] & kept[2:-1] & kept[3:]]
    if not len(third):
        return ""
    noise = np.sqrt(np.mean(np.sum(third.reshape(-1, 2, 3) ** 2, axis=2), axis=0) / _THIRD)
    span = np.array([1.0, float(np.max(np.ptp(poses.translation_m, axis=0)))])
    far = _size(_off(poses[kept], smoothed.poses.rigid[kept]))
    if np.any(far > _FAR * noise + _ROUNDING * span):
        return "a smooth path lies farther off than their noise explains"
    return ""


def _go_over_smoothly(poses: Motor, kept: Kept) -> bool:
    """Whether steps between poses kept and left out change as little as others do."""
    steps = (poses[:-1].inverse() @ poses[1:]).as_twist()
    change = np.linalg.norm(np.diff(steps, axis=0).reshape(-1, 2, 3), axis=2)
    within = kept[:-2] & kept[1:-1] & kept[2:]
    over = kept[:-2] != kept[1:-1]
    if not np.any(within) or not np.any(over):
        return not np.any(within)
    usual = np.median(change[within], axis=0)
    return bool(np.all(np.median(change[over], axis=0) < _ROUGHER * usual))
