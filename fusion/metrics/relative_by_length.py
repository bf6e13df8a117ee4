"""Relative pose error over lengths of path: evo's delta in metres, and KITTI's drift.

The path is measured on the reference (evo: `pairs_from_reference`), so that the noise of an
estimate does not shorten its own yardstick.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics.smooth_path import NotObservableError
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray


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


def relative_errors_by_length(
    estimate: Motor, reference: Motor, length_m: float
) -> tuple[FloatArray, FloatArray]:
    """Errors of the motion over consecutive stretches of path: metres ``(S,)``, radians ``(S,)``.

    A stretch ends at the first pose at which `length_m` or more has been covered since it began,
    and the next begins there; the rest of the path is left out. evo's RPE with a delta in metres,
    consecutive pairs taken from the reference; translation part and rotation angle.

    Args:
        estimate: poses ``(P,)``.
        reference: the true poses that belong to them ``(P,)``.
        length_m: above zero; far above the distance between poses, or stretches are much longer.

    Raises:
        ValueError: a length that is not positive.
        NotObservableError: a reference whose path is shorter.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import relative_errors_by_length
        >>> from motorcade.ga import Motor
        >>> true = Motor.from_translation(np.linspace(0.0, 10.0, 101)[:, None] * [1.0, 0.0, 0.0])
        >>> longer = Motor.from_translation(1.02 * true.translation_m)  # 2 % too long
        >>> metres, radians = relative_errors_by_length(longer, true, length_m=2.0)
        >>> metres.round(3)
        array([0.04, 0.04, 0.04, 0.04, 0.04])
    """
    _check_length(length_m)
    ends = [0]
    covered = 0.0
    for i, step in enumerate(_steps_m(reference), start=1):
        covered += step
        if covered >= length_m:
            ends.append(i)
            covered = 0.0
    if len(ends) < 2:
        raise NotObservableError(
            f"relative error: expected a path of {length_m:g} m or more, got {covered:.6g} m"
        )
    index = np.array(ends, dtype=np.int64)
    return _errors(estimate, reference, index[:-1], index[1:])


def drift_by_length(
    estimate: Motor,
    reference: Motor,
    lengths_m: Sequence[float] = (100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0),
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
    along = np.concatenate([[0.0], np.cumsum(_steps_m(reference))])
    starts = np.arange(0, along.size, every)
    found = []
    for length_m in lengths_m:
        _check_length(length_m)
        ends = np.searchsorted(along, along[starts] + length_m, side="right")
        whole = ends < along.size
        if not np.any(whole):
            continue
        metres, radians = _errors(estimate, reference, starts[whole], ends[whole])
        found.append(
            Drift(
                float(length_m),
                float(np.mean(metres)) / length_m,
                float(np.mean(radians)) / length_m,
                int(np.count_nonzero(whole)),
            )
        )
    if not found:
        raise NotObservableError(
            f"drift: expected a path longer than one of {tuple(lengths_m)} m, got {along[-1]:.6g} m"
        )
    return tuple(found)


def _check_length(length_m: float) -> None:
    if not 0.0 < length_m < np.inf:
        raise ValueError(f"length_m: expected above 0, got {length_m}")


def _steps_m(poses: Motor) -> FloatArray:
    steps: FloatArray = np.linalg.norm(np.diff(poses.translation_m, axis=0), axis=-1)
    return steps


def _errors(
    estimate: Motor, reference: Motor, first: IntArray, last: IntArray
) -> tuple[FloatArray, FloatArray]:
    true = reference[first].inverse() @ reference[last]
    error = true.inverse() @ (estimate[first].inverse() @ estimate[last])
    return np.linalg.norm(error.translation_m, axis=-1), error.rotor.angle()
