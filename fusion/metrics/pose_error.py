"""How far an estimated trajectory is from a reference: association, alignment, APE, RPE, rotation.

The definitions are those of evo (github.com/MichaelGrupp/evo), so that figures can be compared
with published ones: stamps are paired to the nearest, the trajectory with fewer poses leading;
alignment is Umeyama's over the paired positions; the relative error runs over one frame. Errors
are in metres and radians, and both trajectories must describe the same moving frame.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal, get_args

import numpy as np

from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray


def without_scale(trajectory: Trajectory) -> Trajectory:
    """The same orientations and positions as rigid poses; the metrics take no others.

    Examples:
        >>> from motorcade.fusion.metrics import without_scale
        >>> from motorcade.fusion.motions import zoom
        >>> without_scale(zoom().sampled(30.0, 1.0)).motors.shape
        (31,)
    """
    if isinstance(trajectory.poses, Motor):
        return trajectory
    return Trajectory(
        trajectory.time_ns, trajectory.poses.rigid, trajectory.parent, trajectory.child
    )


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
    logarithms: FloatArray = np.log(poses.scale)
    return logarithms


Align = Literal["none", "se3", "sim3"]

_NS_PER_S = 1_000_000_000
# Ratio of variances across and along a path, below which it is a line with rounding errors.
_STRAIGHT = 1e-14


@dataclass(frozen=True)
class Statistics:
    """Summary of one error over all pairs, in the unit of the error.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import Statistics
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


@dataclass(frozen=True, eq=False)
class Pairs:
    """Poses of two trajectories that belong together.

    Fields:
        time_ns: stamps of the estimate ``(P,)``; they repeat where one pose serves two stamps.
        estimate, reference: Motors ``(P,)``.
        estimate_index, reference_index: where the poses stand in their trajectories ``(P,)``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import associate
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> pairs = associate(true[::2], true)
        >>> len(pairs), pairs.reference_index[:3]
        (31, array([0, 2, 4]))
    """

    time_ns: IntArray
    estimate: Motor
    reference: Motor
    estimate_index: IntArray
    reference_index: IntArray

    def __len__(self) -> int:
        return int(self.time_ns.size)


@dataclass(frozen=True, eq=False)
class Alignment:
    """``x_reference = scale * rotor(x_estimate) + translation_m``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import Alignment, alignment_of, associate
        >>> from motorcade.ga import Motor
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> map_T_world = Motor.from_euler_translation([0.0, 0.0, 0.5], [1.0, 2.0, 0.0])
        >>> pairs = associate(true.transformed_by(map_T_world), true)
        >>> found = alignment_of(pairs, "se3")
        >>> isinstance(found, Alignment), found.rotor.as_rotation_vector().round(6) + 0.0
        (True, array([ 0. ,  0. , -0.5]))
    """

    rotor: Rotor
    translation_m: FloatArray
    scale: float

    @classmethod
    def identity(cls) -> Alignment:
        """Leave everything where it is."""
        return cls(Rotor.identity(), np.zeros(3), 1.0)

    def apply(self, poses: Motor) -> Motor:
        """Move poses into the reference's world; orientations turn, positions also scale."""
        positions = self.scale * self.rotor.apply(poses.translation_m) + self.translation_m
        return Motor.from_rotor_translation(self.rotor @ poses.rotor, positions)

    def apply_to(self, trajectory: Trajectory) -> Trajectory:
        """The whole trajectory in the reference's world."""
        aligned = self.apply(trajectory.motors)
        return Trajectory(trajectory.time_ns, aligned, trajectory.parent, trajectory.child)


def associate(estimate: Trajectory, reference: Trajectory, max_difference_s: float = 0.01) -> Pairs:
    """Pair poses with the nearest stamps, as ``evo.core.sync`` does.

    The trajectory with fewer poses leads: each of its poses takes the other's nearest one, the
    earlier of two equally near, and is left out if that is more than `max_difference_s` away.
    A pose of the longer trajectory may serve twice. Differences are formed in float seconds, so
    that ties fall as they do in evo.

    Raises:
        ValueError: `max_difference_s` negative or not finite, or no two stamps near enough.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import associate
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> len(associate(true[5:40], true))
        35
    """
    if not (np.isfinite(max_difference_s) and max_difference_s >= 0.0):
        raise ValueError(f"max_difference_s: expected 0 or more, got {max_difference_s}")
    reference_leads = len(estimate) > len(reference)
    short, long = (reference, estimate) if reference_leads else (estimate, reference)
    short_index, long_index = _nearest(
        _seconds(short.time_ns), _seconds(long.time_ns), max_difference_s
    )
    if short_index.size == 0:
        raise ValueError(
            f"estimate and reference: expected stamps within max_difference_s = "
            f"{max_difference_s} s of each other, got none; the estimate spans "
            f"{estimate.time_ns[0]} to {estimate.time_ns[-1]} ns, the reference "
            f"{reference.time_ns[0]} to {reference.time_ns[-1]} ns"
        )
    e, r = (long_index, short_index) if reference_leads else (short_index, long_index)
    return Pairs(estimate.time_ns[e], estimate.motors[e], reference.motors[r], e, r)


def align(pairs: Pairs, with_scale: bool) -> Alignment:
    """Least-squares rotation, translation and (on request) scale of the estimate's positions.

    S. Umeyama, Least-squares estimation of transformation parameters between two point patterns,
    IEEE PAMI 13(4), 1991. Orientations play no part.

    Raises:
        ValueError: fewer than three pairs, or positions on one line, which leave a turn free.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import absolute_translation_m, align, associate
        >>> from motorcade.ga import Motor
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> map_T_world = Motor.from_euler_translation([0.0, 0.0, 0.5], [1.0, 2.0, 0.0])
        >>> pairs = associate(true.transformed_by(map_T_world), true)
        >>> found = align(pairs, with_scale=False)
        >>> bool(absolute_translation_m(found.apply(pairs.estimate), pairs.reference).max() < 1e-9)
        True
    """
    if len(pairs) < 3:
        raise ValueError(f"alignment: expected 3 or more pairs, got {len(pairs)}")
    source, target = pairs.estimate.translation_m, pairs.reference.translation_m
    source_mean, target_mean = source.mean(axis=0), target.mean(axis=0)
    covariance = (target - target_mean).T @ (source - source_mean) / len(pairs)
    left, singular, right = np.linalg.svd(covariance)
    if singular[1] <= max(np.finfo(np.float64).eps, _STRAIGHT * singular[0]):
        raise ValueError(
            "alignment: expected positions that do not lie on one line, got singular values "
            f"{singular.tolist()} of their covariance; use align='none'"
        )
    signs = np.ones(3)
    if np.linalg.det(left) * np.linalg.det(right) < 0.0:
        signs[2] = -1.0
    rotation = (left * signs) @ right
    spread = float(np.mean(np.sum((source - source_mean) ** 2, axis=1)))
    scale = float(singular @ signs) / spread if with_scale else 1.0
    translation = target_mean - scale * rotation @ source_mean
    return Alignment(Rotor.from_matrix(rotation), translation, scale)


def alignment_of(pairs: Pairs, how: Align) -> Alignment:
    """The alignment named "none", "se3" or "sim3"; see `align`.

    Raises:
        ValueError: another name, or pairs that cannot be aligned.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import absolute_translation_m, alignment_of, associate
        >>> from motorcade.ga import Motor
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> map_T_world = Motor.from_euler_translation([0.0, 0.0, 0.5], [1.0, 2.0, 0.0])
        >>> pairs = associate(true.transformed_by(map_T_world), true)
        >>> found = alignment_of(pairs, "se3")
        >>> bool(absolute_translation_m(found.apply(pairs.estimate), pairs.reference).max() < 1e-9)
        True
    """
    if how not in get_args(Align):
        raise ValueError(f"align: expected one of {', '.join(get_args(Align))}, got {how!r}")
    return Alignment.identity() if how == "none" else align(pairs, with_scale=how == "sim3")


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


def relative_errors(estimate: Motor, reference: Motor) -> tuple[FloatArray, FloatArray]:
    """Errors of the motion from each pair to the next: metres ``(P-1,)`` and radians ``(P-1,)``.

    evo's RPE with a delta of one frame and consecutive pairs, translation part and rotation angle.

    Raises:
        ValueError: fewer than two pairs.

    Examples:
        >>> from motorcade.fusion.metrics import relative_errors
        >>> from motorcade.ga import Motor
        >>> true = Motor.from_translation([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
        >>> drifting = Motor.from_translation([[5.0, 0.0, 0.0], [6.1, 0.0, 0.0], [7.2, 0.0, 0.0]])
        >>> metres, radians = relative_errors(drifting, true)
        >>> metres.round(6)
        array([0.1, 0.1])
    """
    if len(estimate) < 2:
        raise ValueError(f"relative error: expected 2 or more pairs, got {len(estimate)}")
    true_step = reference[:-1].inverse() @ reference[1:]
    step = estimate[:-1].inverse() @ estimate[1:]
    error = true_step.inverse() @ step
    return np.linalg.norm(error.translation_m, axis=-1), error.rotor.angle()


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


def _seconds(time_ns: IntArray) -> FloatArray:
    """Float seconds, rounded once: the double that a file's decimal stamp is read as."""
    whole, rest = np.divmod(time_ns, _NS_PER_S)
    seconds: FloatArray = whole + rest / _NS_PER_S
    return seconds


def _nearest(
    short: FloatArray, long: FloatArray, max_difference_s: float
) -> tuple[IntArray, IntArray]:
    after = np.searchsorted(long, short, side="right")
    before = after - 1
    inside = np.minimum(after, long.size - 1)
    to_after = np.where(after < long.size, long[inside] - short, np.inf)
    to_before = np.where(before >= 0, short - long[np.maximum(before, 0)], np.inf)
    nearest = np.where(to_after < to_before, inside, before)
    kept = np.minimum(to_after, to_before) <= max_difference_s
    chosen: IntArray = np.flatnonzero(kept).astype(np.int64)
    return chosen, nearest[kept].astype(np.int64)
