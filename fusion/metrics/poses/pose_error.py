"""How far poses are from those they should be: distance, rotation, tilt, scale, evo's relations.

Errors are in metres and radians, and both poses must describe the same moving frame in worlds that
agree (`alignment`). Of the error pose E, with rotation R and translation t, evo's relations are

==============================  =====================================================  ====
relation                        of the error pose E with rotation R and translation t  unit
==============================  =====================================================  ====
``full``                        ‖E − 1‖ (Frobenius): metres and radians mixed           none
``trans_part``                  ‖t‖                                                    m
``rot_part``                    ‖R − 1‖ (Frobenius) = 2 √2 sin(angle / 2)              none
``angle_deg``, ``angle_rad``    angle of R, from 0 to half a turn                      °
``point_distance``              relative: difference of the two distances travelled    m
``point_distance_error_ratio``  relative: the same, as a share of the true distance    %
==============================  =====================================================  ====

Between which poses a relative error is taken is chosen as by ``evo_rpe``: from end to end, or from
every pose on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Literal, get_args

import numpy as np

from motorcade.fusion.metrics.smooth_path import NotObservableError
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.ga.names import check_word


def log_scales(poses: Motor | Similarity) -> FloatArray:
    """Logarithms of the scales ``(*)``; zero for rigid poses.

    Examples:
        >>> from motorcade.fusion.metrics import log_scales
        >>> from motorcade.ga import Motor, Similarity
        >>> log_scales(Similarity.from_motor_scale(Motor.identity((2,)), [1.0, 2.0])).round(6)
        array([0.      , 0.693147])
    """
    if isinstance(poses, Motor):
        return np.zeros(poses.shape)
    return np.log(poses.scale)


@dataclass(frozen=True)
class Statistics:
    """Summary of one error over all pairs, in the unit of the error.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics.poses.pose_error import Statistics
        >>> Statistics.of(np.array([0.0, 3.0, 4.0])).median
        3.0
    """

    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of the statistics, in order."""
        return tuple(field.name for field in fields(cls))

    @classmethod
    def of(cls, errors: FloatArray) -> Statistics:
        """Summarise errors ``(N,)``, N at least 1; `std` is that of the population."""
        if errors.ndim != 1 or errors.size == 0:
            raise ValueError(f"errors: expected shape (N,) with N >= 1, got {errors.shape}")
        return cls(
            rmse=float(np.sqrt(np.mean(errors**2))),
            mean=float(np.mean(errors)),
            median=float(np.median(errors)),
            std=float(np.std(errors)),
            min=float(np.min(errors)),
            max=float(np.max(errors)),
        )


def absolute_translation_m(estimate: Motor, reference: Motor) -> FloatArray:
    """Distances ``(P,)`` between paired positions (evo: APE, translation part).

    Examples:
        >>> from motorcade.fusion.metrics import absolute_translation_m
        >>> from motorcade.ga import Motor
        >>> off = Motor.from_translation([3.0, 4.0, 0.0])
        >>> float(absolute_translation_m(off, Motor.identity()))
        5.0
    """
    distance: FloatArray = np.linalg.norm(estimate.translation_m - reference.translation_m, axis=-1)
    return distance


def rotation_rad(estimate: Motor, reference: Motor) -> FloatArray:
    """Angles ``(P,)`` between paired orientations, in [0, π] (evo: APE, rotation angle).

    Examples:
        >>> from motorcade.fusion.metrics import rotation_rad
        >>> from motorcade.ga import Motor
        >>> turned = Motor.from_euler_translation([0.0, 0.0, 0.25], [0.0, 0.0, 0.0])
        >>> round(float(rotation_rad(turned, Motor.identity())), 6)
        0.25
    """
    return (reference.rotor.inverse() @ estimate.rotor).angle()


def tilt_rad(estimate: Motor, reference: Motor) -> FloatArray:
    """Angles ``(P,)`` between the two directions of "up" that paired poses give the moving frame.

    Unlike the rotation error it does not see a turn about the vertical (the worlds' z axis).

    Examples:
        >>> from motorcade.fusion.metrics import tilt_rad
        >>> from motorcade.ga import Motor
        >>> turned = Motor.from_euler_translation([[0, 0, 0.25], [0.25, 0, 0]], [0, 0, 0])
        >>> tilt_rad(turned, Motor.identity((2,))).round(6)  # a turn about the vertical is no tilt
        array([0.  , 0.25])
    """
    up = np.array([0.0, 0.0, 1.0])
    ours, theirs = estimate.rotor.inverse().apply(up), reference.rotor.inverse().apply(up)
    sine = np.linalg.norm(np.cross(ours, theirs), axis=-1)
    angle: FloatArray = np.arctan2(sine, np.sum(ours * theirs, axis=-1))
    return angle


def constant_rotation(estimate: Motor, reference: Motor) -> tuple[float, FloatArray]:
    """How far one turn takes orientations to the reference's, and what it leaves of each pose.

    The turn is of the world (an alignment by few positions turns it at will) or of the moving frame
    (wrong extrinsics), whichever leaves less: the mean of rotations in the sense of least squares.

    Returns:
        its angle, and the angles ``(P,)`` that are left, in radians.

    Source: Moakher 2002 (means of rotations).

    Examples:
        >>> from motorcade.fusion.metrics.poses.pose_error import constant_rotation
        >>> from motorcade.ga import Motor
        >>> true = Motor.from_euler_translation([[0.0, 0, 0], [1.0, 0, 0], [0, 0, 1.0]], [0, 0, 0])
        >>> tilted_world = Motor.from_euler_translation([0.01, 0, 0], [0, 0, 0])
        >>> constant_rad, rest_rad = constant_rotation(tilted_world @ true, true)
        >>> round(constant_rad, 6), bool(rest_rad.max() < 1e-9)
        (0.01, True)
    """
    back, theirs = estimate.rotor.inverse(), reference.rotor
    candidates = []
    for apart in (theirs @ back, back @ theirs):  # of the world, of the moving frame
        left, _, right = np.linalg.svd(apart.as_matrix().sum(axis=0))
        sign = np.linalg.det(left @ right)
        turn = Rotor.from_matrix(left @ np.diag([1.0, 1.0, sign]) @ right)
        candidates.append((float(turn.angle()), (apart @ turn.inverse()).angle()))
    constant, rest_rad = min(candidates, key=lambda candidate: float(np.sum(candidate[1] ** 2)))
    return constant, rest_rad


Relation = Literal[
    "full",
    "trans_part",
    "rot_part",
    "angle_deg",
    "angle_rad",
    "point_distance",
    "point_distance_error_ratio",
]

_BLOCK = 1 << 18
_ROTATION_PART = 2.0 * np.sqrt(2.0)


def absolute_errors(
    estimate: Motor, reference: Motor, relation: Relation = "trans_part"
) -> FloatArray:
    """Errors ``(P,)`` between paired poses in one world (evo: APE with a pose relation).

    Raises:
        ValueError: another relation, or a share of a distance, which absolute errors do not have.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import absolute_errors
        >>> from motorcade.ga import Motor
        >>> off = Motor.from_euler_translation([[0.0, 0.0, np.pi / 2]], [3.0, 4.0, 0.0])
        >>> for relation in ("trans_part", "angle_deg", "rot_part", "full"):
        ...     print(absolute_errors(off, Motor.identity((1,)), relation).round(6))
        [5.]
        [90.]
        [2.]
        [5.385165]
    """
    check_word(relation, get_args(Relation), "relation")
    if relation == "point_distance_error_ratio":
        raise ValueError(f"relation: absolute errors have no {relation}")
    if relation in ("trans_part", "point_distance"):
        return absolute_translation_m(estimate, reference)
    return _measured(estimate.inverse() @ reference, relation)


def relative_errors(
    estimate: Motor,
    reference: Motor,
    delta: Delta | None = None,
    relations: Sequence[Relation] = ("trans_part", "angle_rad"),
) -> tuple[FloatArray, ...]:
    """Errors of the motion between poses a delta apart, ``(S,)`` for each relation (evo: RPE).

    Args:
        estimate: poses ``(P,)``.
        reference: the true poses that belong to them ``(P,)``.
        delta: how far apart, one frame unless said otherwise.
        relations: what to measure; metres and radians unless said otherwise. A share of the true
            distance leaves out pairs where that is zero.

    Raises:
        ValueError: another relation.
        NotObservableError: no two poses so far apart.

    Examples:
        >>> from motorcade.fusion.metrics import Delta, relative_errors
        >>> from motorcade.ga import Motor
        >>> true = Motor.from_translation([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
        >>> drifting = Motor.from_translation([[5.0, 0.0, 0.0], [6.1, 0.0, 0.0], [7.2, 0.0, 0.0]])
        >>> metres, radians = relative_errors(drifting, true)
        >>> metres.round(6)
        array([0.1, 0.1])
        >>> (share,) = relative_errors(drifting, true, Delta(2), ["point_distance_error_ratio"])
        >>> share.round(6)
        array([10.])
    """
    for relation in relations:
        check_word(relation, get_args(Relation), "relation")
    first, last = (Delta() if delta is None else delta).ends(estimate, reference)
    blocks = [
        errors_between(estimate, reference, first[part], last[part], relations)
        for part in (slice(start, start + _BLOCK) for start in range(0, first.size, _BLOCK))
    ]
    return tuple(np.concatenate(parts) for parts in zip(*blocks, strict=True))


def errors_between(
    estimate: Motor,
    reference: Motor,
    first: IntArray,
    last: IntArray,
    relations: Sequence[Relation],
) -> tuple[FloatArray, ...]:
    """Errors of the motion between poses with these indices ``(S,)``; see `relative_errors`."""
    sides = [(poses[first], poses[last]) for poses in (reference, estimate)]
    true, ours = (before.inverse() @ after for before, after in sides)
    error = true.inverse() @ ours
    true_m, ours_m = (
        _travelled_m(before.translation_m, after.translation_m) for before, after in sides
    )
    return tuple(
        _of_distances(true_m, ours_m, relation)
        if relation.startswith("point_distance")
        else _measured(error, relation)
        for relation in relations
    )


def _travelled_m(before_m: FloatArray, after_m: FloatArray) -> FloatArray:
    """Distances ``(S,)``; zero where they are no more than the rounding of positions in motors."""
    distance: FloatArray = np.linalg.norm(after_m - before_m, axis=-1)
    rounding = 16.0 * np.finfo(np.float64).eps * np.abs(before_m).sum(axis=-1)
    return np.where(distance > rounding, distance, 0.0)


def _of_distances(true_m: FloatArray, ours_m: FloatArray, relation: Relation) -> FloatArray:
    error = np.abs(ours_m - true_m)
    if relation == "point_distance":
        return error
    moving = true_m > 0.0
    return 100.0 * error[moving] / true_m[moving]


def _measured(error: Motor, relation: Relation) -> FloatArray:
    if relation in ("trans_part", "point_distance"):
        distance: FloatArray = np.linalg.norm(error.translation_m, axis=-1)
        return distance
    angle_rad = error.rotor.angle()
    if relation == "angle_rad":
        return angle_rad
    if relation == "angle_deg":
        return np.rad2deg(angle_rad)
    rotation: FloatArray = _ROTATION_PART * np.sin(0.5 * angle_rad)
    if relation == "rot_part":
        return rotation
    full: FloatArray = np.hypot(rotation, np.linalg.norm(error.translation_m, axis=-1))
    return full


DeltaUnit = Literal["frames", "m", "deg", "rad"]
PairsFrom = Literal["reference", "estimate"]

MOST_PAIRS = 20_000_000
MOST_POSES = 100_000
"""All pairs by angle grow with the square of the poses: so many take half a gigabyte, a minute."""

_CELLS = 1 << 22


@dataclass(frozen=True)
class Delta:
    """How far apart two poses are whose relative motion is compared.

    Fields:
        value: above zero; of frames a whole number, of angles at most half a turn.
        unit: "frames", "m" of path, "deg" or "rad".
        all_pairs: from every pose on, rather than each from where the one before ended.
        tolerance: of all pairs in metres or angles, by what share of `value` they may miss it.
        pairs_from: whose motion is measured. The reference's, unless said otherwise, as the noise
            of an estimate would shorten its own yardstick; evo measures the estimate's unless
            ``--pairs_from_reference`` is given. Frames are the same for both.

    Consecutive pairs in metres and angles end at the first pose at which `value` or more has been
    accumulated; all pairs take the nearest end by length of path, and every end by the direct angle
    between the two poses.

    Raises:
        ValueError: a value, unit, tolerance or side other than these.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import Delta
        >>> from motorcade.ga import Motor
        >>> walk = Motor.from_translation(np.arange(6.0)[:, None] * [1.0, 0.0, 0.0])
        >>> Delta(2.0, "m").ends(walk, walk)
        (array([0, 2]), array([2, 4]))
        >>> Delta(2, all_pairs=True).ends(walk, walk)
        (array([0, 1, 2, 3]), array([2, 3, 4, 5]))
    """

    value: float = 1.0
    unit: DeltaUnit = "frames"
    all_pairs: bool = False
    tolerance: float = 0.1
    pairs_from: PairsFrom = "reference"

    def __post_init__(self) -> None:
        check_word(self.unit, get_args(DeltaUnit), "delta unit")
        check_word(self.pairs_from, get_args(PairsFrom), "pairs_from")
        most = {"deg": 180.0, "rad": np.pi}.get(self.unit, np.inf)
        if not 0.0 < self.value <= most or not np.isfinite(self.value):
            range_ = "above 0" if most == np.inf else f"above 0 and at most {most:.6g}"
            raise ValueError(f"delta: expected {range_} {self.unit}, got {self.value}")
        if self.unit == "frames" and self.value != int(self.value):
            raise ValueError(f"delta: expected a whole number of frames, got {self.value}")
        if not 0.0 <= self.tolerance < np.inf:
            raise ValueError(f"delta tolerance: expected 0 or more, got {self.tolerance}")

    def __str__(self) -> str:
        return f"{self.value:g} {self.unit}, {'all' if self.all_pairs else 'consecutive'} pairs"

    def ends(self, estimate: Motor, reference: Motor) -> tuple[IntArray, IntArray]:
        """Indices of the first and of the last pose of each pair, ``(S,)`` both.

        Args:
            estimate: poses ``(P,)``.
            reference: the true poses that belong to them ``(P,)``.

        Raises:
            NotObservableError: no pair is so far apart.
            ValueError: all pairs by angle of more than `MOST_POSES` poses, or more than
                `MOST_PAIRS` of them.
        """
        poses = reference if self.pairs_from == "reference" else estimate
        if self.unit == "frames":
            first, last = self._by_frames(poses.shape[0])
        elif self.unit == "m":
            first, last = self._by_path(poses)
        else:
            first, last = self._by_angle(poses)
        if first.size == 0:
            count = poses.shape[0]
            raise NotObservableError(
                f"relative error: expected {self.value + 1:g} or more pairs, got {count}"
                if self.unit == "frames"
                else f"relative error: expected poses {self.value:g} {self.unit} apart, got none "
                f"among {count}"
            )
        return first, last

    def _by_frames(self, count: int) -> tuple[IntArray, IntArray]:
        step = int(min(self.value, count))
        if self.all_pairs:
            first = np.arange(count - step)
            return first, first + step
        return _end_to_end(np.arange(0, count, step))

    def _by_path(self, poses: Motor) -> tuple[IntArray, IntArray]:
        steps = steps_m(poses)
        if not self.all_pairs:
            return _end_to_end(_reached(steps, self.value))
        along = np.concatenate([[0.0], np.cumsum(steps)])
        first = np.arange(along.size - 1)
        beyond = np.searchsorted(along, along[:-1] + self.value, side="left")
        # Of poses that stand still between them, the earliest; but never the first pose itself.
        before = np.searchsorted(along, along[beyond - 1], side="left")
        ends = np.stack([before, np.minimum(beyond, along.size - 1)])
        ends = np.maximum(ends, first + 1)
        missed = np.abs(along[ends] - along[first] - self.value)
        nearest = np.argmin(missed, axis=0)
        kept = missed[nearest, first] <= self.value * self.tolerance
        return first[kept], ends[nearest, first][kept]

    def _by_angle(self, poses: Motor) -> tuple[IntArray, IntArray]:
        turn_rad = float(np.deg2rad(self.value)) if self.unit == "deg" else self.value
        if self.all_pairs:
            missed_rad = turn_rad * self.tolerance
            return _all_turned(poses.rotor, turn_rad - missed_rad, turn_rad + missed_rad)
        steps = (poses.rotor[:-1].inverse() @ poses.rotor[1:]).angle()
        return _end_to_end(_reached(steps, turn_rad))


def steps_m(poses: Motor) -> FloatArray:
    """Distances ``(P-1,)`` between neighbouring positions."""
    steps: FloatArray = np.linalg.norm(np.diff(poses.translation_m, axis=0), axis=-1)
    return steps


def _end_to_end(ends: IntArray) -> tuple[IntArray, IntArray]:
    return ends[:-1], ends[1:]


def _reached(steps: FloatArray, amount: float) -> IntArray:
    """Where `amount` or more has been covered since the place before, beginning with 0."""
    ends = [0]
    covered = 0.0
    for i, step in enumerate(steps.tolist(), start=1):
        covered += step
        if covered >= amount:
            ends.append(i)
            covered = 0.0
    return np.array(ends, dtype=np.int64)


def _all_turned(rotors: Rotor, least_rad: float, most_rad: float) -> tuple[IntArray, IntArray]:
    """All pairs ``i < j`` whose orientations are so far apart, by blocks of rows."""
    wxyz = rotors.as_quaternion()
    if len(wxyz) > MOST_POSES:
        raise ValueError(
            f"delta: expected at most {MOST_POSES} poses for all pairs by angle, got {len(wxyz)}; "
            "use consecutive pairs or fewer poses"
        )
    high = np.cos(0.5 * max(least_rad, 0.0))
    low = np.cos(0.5 * min(most_rad, np.pi))
    first, last, total = [], [], 0
    height = max(1, _CELLS // len(wxyz))
    for start in range(0, len(wxyz) - 1, height):
        rows = wxyz[start : start + height]
        cosine = np.minimum(np.abs(rows @ wxyz[start:].T), 1.0)
        i, j = np.nonzero((cosine >= low) & (cosine <= high))
        later = j > i
        first.append(i[later] + start)
        last.append(j[later] + start)
        total += int(np.count_nonzero(later))
        if total > MOST_PAIRS:
            raise ValueError(
                f"delta: expected at most {MOST_PAIRS} pairs, got more among {len(wxyz)} poses; "
                "use consecutive pairs, a smaller tolerance or fewer poses"
            )
    return np.concatenate([*first, _NONE]), np.concatenate([*last, _NONE])


_NONE: IntArray = np.zeros(0, dtype=np.int64)


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
        checked_positive(length_m, "length_m")
        ends = np.searchsorted(along, along[starts] + length_m, side="right")
        whole = ends < along.size
        if not np.any(whole):
            continue
        errors = errors_between(
            estimate, reference, starts[whole], ends[whole], ("trans_part", "angle_rad")
        )
        metre, radian = (float(np.mean(error)) / length_m for error in errors)
        drifts.append(Drift(float(length_m), metre, radian, int(np.count_nonzero(whole))))
    if not drifts:
        raise NotObservableError(
            f"drift: expected a path longer than one of {tuple(lengths_m)} m, got {along[-1]:.6g} m"
        )
    return tuple(drifts)
