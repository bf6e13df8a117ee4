"""KITTI's drift: error a metre over sub-sequences of 100 to 800 m of the reference's path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics.poses.relations import errors_between, steps_m
from motorcade.fusion.metrics.smooth_path import NotObservableError
from motorcade.ga import Motor

KITTI_LENGTHS_M = (100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0)


@dataclass(frozen=True)
class Drift:
    """Mean error over all sub-sequences of one length, per metre of path.

    Fields:
        length_m: of the sub-sequences.
        translation: metres of error a metre of path; times 100 the per cent of KITTI's table.
        rotation_rad_m: radians of error a metre of path.
        count: how many sub-sequences there were.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import drift_by_length
        >>> from motorcade.ga import Motor
        >>> true = Motor.from_translation(np.linspace(0.0, 10.0, 101)[:, None] * [1.0, 0.0, 0.0])
        >>> longer = Motor.from_translation(1.02 * true.translation_m)  # 2 % too long
        >>> (found,) = drift_by_length(longer, true, lengths_m=(5.0,))
        >>> found.length_m, round(found.translation, 4)
        (5.0, 0.0204)
    """

    length_m: float
    translation: float
    rotation_rad_m: float
    count: int


def drift_by_length(
    estimate: Motor,
    reference: Motor,
    lengths_m: Sequence[float] = KITTI_LENGTHS_M,
    every: int = 10,
) -> tuple[Drift, ...]:
    """KITTI's odometry errors: sub-sequences of given lengths from every tenth pose on.

    A sub-sequence ends at the first pose that lies more than its length farther along the
    reference. Errors are divided by the length before they are averaged.

    Source: Geiger, Lenz, Urtasun, Are we ready for autonomous driving? The KITTI vision benchmark
    suite, CVPR 2012, and its development kit, ``evaluate_odometry.cpp``.

    Args:
        estimate: poses ``(P,)``.
        reference: the true poses that belong to them ``(P,)``.
        lengths_m: above zero; those that the path is too short for are left out of the answer.
        every: poses from one start to the next, 1 or more.

    Raises:
        ValueError: a length or step that is not positive.
        NotObservableError: a path shorter than all lengths.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import drift_by_length
        >>> from motorcade.ga import Motor
        >>> true = Motor.from_translation(np.linspace(0.0, 10.0, 101)[:, None] * [1.0, 0.0, 0.0])
        >>> longer = Motor.from_translation(1.02 * true.translation_m)  # 2 % too long
        >>> found = drift_by_length(longer, true, lengths_m=(2.0, 5.0))
        >>> [round(one.translation, 4) for one in found]
        [0.021, 0.0204]
    """
    if every < 1:
        raise ValueError(f"every: expected 1 or more, got {every}")
    along = np.concatenate([[0.0], np.cumsum(steps_m(reference))])
    starts = np.arange(0, along.size, every)
    drifts = []
    for length_m in lengths_m:
        _check_length(length_m)
        ends = np.searchsorted(along, along[starts] + length_m, side="right")
        whole = ends < along.size
        if not np.any(whole):
            continue
        metres, radians = errors_between(
            estimate, reference, starts[whole], ends[whole], ("trans_part", "angle_rad")
        )
        drifts.append(
            Drift(
                float(length_m),
                float(np.mean(metres)) / length_m,
                float(np.mean(radians)) / length_m,
                int(np.count_nonzero(whole)),
            )
        )
    if not drifts:
        raise NotObservableError(
            f"drift: expected a path longer than one of {tuple(lengths_m)} m, got {along[-1]:.6g} m"
        )
    return tuple(drifts)


def _check_length(length_m: float) -> None:
    if not 0.0 < length_m < np.inf:
        raise ValueError(f"length_m: expected above 0, got {length_m}")
