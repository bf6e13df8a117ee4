"""Bring an estimate into its reference's world: by positions, heading, scale, or the first pose."""

from __future__ import annotations

import logging
from dataclasses import dataclass, fields
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import check_word
from motorcade.ga.stamps import inside_gaps

Align = Literal["none", "se3", "sim3", "yaw", "scale", "origin", "scaled_origin"]

_FITTED: tuple[Align, ...] = ("se3", "sim3", "yaw", "scale", "scaled_origin")
# Ratio of variances across and along a path, below which it is a line with rounding errors.
_STRAIGHT = 1e-14


@dataclass(frozen=True, eq=False)
class Alignment:
    """``x_reference = scale * rotor(x_estimate) + translation_m``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import alignment_of, associate
        >>> from motorcade.fusion.metrics.poses.alignment import Alignment
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
            f"{singular.tolist()} of their covariance; use align='origin' or 'none'"
        )
    signs = np.ones(3)
    if np.linalg.det(left) * np.linalg.det(right) < 0.0:
        signs[2] = -1.0
    rotation = (left * signs) @ right
    spread = float(np.mean(np.sum((source - source_mean) ** 2, axis=1)))
    scale = float(singular @ signs) / spread if with_scale else 1.0
    translation = target_mean - scale * rotation @ source_mean
    return Alignment(Rotor.from_matrix(rotation), translation, scale)


def align_heading(pairs: Pairs) -> Alignment:
    """Least-squares turn about the world's z, and translation: where gravity tells both worlds up.

    Z. Zhang, D. Scaramuzza, A tutorial on quantitative trajectory evaluation for visual(-inertial)
    odometry, IROS 2018. Orientations play no part.

    Raises:
        ValueError: fewer than two pairs, or positions above each other, which leave the turn free.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import associate
        >>> from motorcade.fusion.metrics.poses.alignment import align_heading
        >>> from motorcade.ga import Motor
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> map_T_world = Motor.from_euler_translation([0.0, 0.0, 0.5], [1.0, 2.0, 0.0])
        >>> found = align_heading(associate(true.transformed_by(map_T_world), true))
        >>> found.rotor.as_rotation_vector().round(6) + 0.0
        array([ 0. ,  0. , -0.5])
    """
    source, target = pairs.estimate.translation_m, pairs.reference.translation_m
    source_mean, target_mean = source.mean(axis=0), target.mean(axis=0)
    (x, y), (u, v) = (source - source_mean).T[:2], (target - target_mean).T[:2]
    along, across = float(x @ u + y @ v), float(x @ v - y @ u)
    size = float(np.sqrt((x @ x + y @ y) * (u @ u + v @ v)))
    if len(pairs) < 2 or np.hypot(along, across) <= np.finfo(np.float64).eps * max(1.0, size):
        raise ValueError(
            f"alignment: expected two or more positions beside each other, got {len(pairs)} that "
            "leave the heading free; use align='origin' or 'none'"
        )
    turn = Rotor.from_rotation_vector(np.array([0.0, 0.0, np.arctan2(across, along)]))
    return Alignment(turn, target_mean - turn.apply(source_mean), 1.0)


def alignment_of(pairs: Pairs, how: Align, n_to_align: int | None = None) -> Alignment:
    """The alignment with a name.

    "none" leaves the estimate where it is. "se3" and "sim3" fit its positions, without and with
    their scale; see `align`. "yaw" turns about the vertical alone; see `align_heading`. "scale"
    takes the scale of the similarity alone. "origin" moves the whole estimate rigidly until the
    first pair agrees; "scaled_origin" does so after "scale".

    Args:
        pairs: poses that belong together.
        how: the name.
        n_to_align: how many pairs, counted from the first, the fit sees (all); a start that was
            fitted shows drift that a fit over the whole path hides.

    Raises:
        ValueError: another name, pairs that cannot be aligned, `n_to_align` below three, or where
            nothing is fitted.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import absolute_translation_m, alignment_of, associate
        >>> from motorcade.ga import Motor
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> map_T_world = Motor.from_euler_translation([0.0, 0.0, 0.5], [1.0, 2.0, 0.0])
        >>> pairs = associate(true.transformed_by(map_T_world), true)
        >>> for how in ("none", "origin", "se3"):
        ...     found = alignment_of(pairs, how).apply(pairs.estimate)
        ...     print(how, bool(absolute_translation_m(found, pairs.reference).max() < 1e-9))
        none False
        origin True
        se3 True
    """
    check_word(how, get_args(Align), "align")
    if n_to_align is not None:
        if how not in _FITTED:
            raise ValueError(f"n_to_align: only {', '.join(_FITTED)} are fitted, got align={how!r}")
        if n_to_align < 3:
            raise ValueError(f"n_to_align: expected 3 or more pairs, got {n_to_align}")
        pairs = pairs.first(n_to_align)
    if how in ("se3", "sim3"):
        return align(pairs, with_scale=how == "sim3")
    if how == "yaw":
        return align_heading(pairs)
    scale = align(pairs, with_scale=True).scale if how in ("scale", "scaled_origin") else 1.0
    if how in ("none", "scale"):
        return Alignment(Rotor.identity(), np.zeros(3), scale)
    ours, true = pairs.estimate[0], pairs.reference[0]
    turn = true.rotor @ ours.rotor.inverse()
    return Alignment(turn, true.translation_m - scale * turn.apply(ours.translation_m), scale)


Plane = Literal["xy", "xz", "yz"]

_NORMAL: dict[Plane, int] = {"xy": 2, "xz": 1, "yz": 0}


def projected(poses: Motor, plane: Plane) -> Motor:
    """Poses ``(*)`` in a plane: positions without their part along its normal, turns about it.

    The turn is evo's: the Euler angle about the normal, of angles about the fixed axes x, y and z
    in that order. About z it is the heading of the moving frame's x axis, in (-π, π]. About y it
    lies within ±π/2, so that a frame that turns farther seems to turn back; `folded` says where.

    Raises:
        ValueError: another plane.

    Examples:
        >>> from motorcade.fusion.metrics.poses.alignment import projected
        >>> from motorcade.ga import Motor
        >>> pose = Motor.from_euler_translation([0.0, 0.0, 0.5], [1.0, 2.0, 3.0])
        >>> flat = projected(pose, "xy")
        >>> flat.translation_m + 0.0, flat.rotor.as_rotation_vector().round(6) + 0.0
        (array([1., 2., 0.]), array([0. , 0. , 0.5]))
    """
    check_word(plane, get_args(Plane), "plane")
    normal = _NORMAL[plane]
    vector = np.zeros((*poses.shape, 3))
    vector[..., normal] = poses.rotor.as_euler("zyx")[..., 2 - normal]
    positions = np.array(poses.translation_m)
    positions[..., normal] = 0.0
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(vector), positions)


def folded(poses: Motor, plane: Plane) -> NDArray[np.bool_]:
    """Which poses ``(*)`` face backwards in the plane xz, where the projected turn is folded.

    Examples:
        >>> from motorcade.fusion.metrics.poses.alignment import folded
        >>> from motorcade.ga import Motor, Rotor
        >>> turn = Rotor.from_rotation_vector([[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]])
        >>> folded(Motor.from_rotor_translation(turn, [0.0, 0.0, 0.0]), "xz")
        array([False,  True])
    """
    matrix = poses.rotor.as_matrix()
    backwards = (matrix[..., 0, 0] < 0.0) & (matrix[..., 2, 2] < 0.0)
    return np.asarray(backwards & (plane == "xz"), dtype=np.bool_)


# Which poses of two trajectories belong together: the nearest stamps, as evo pairs them.
#
# Differences of stamps are formed in float seconds, rounded as evo rounds them, so that ties fall
# and poses are interpolated as they are there. At today's stamps that rounds to 0.2 µs.

_NS_PER_S = 1_000_000_000
_LOG = logging.getLogger("motorcade.metrics")


@dataclass(frozen=True, eq=False)
class Pairs:
    """Poses of two trajectories that belong together.

    Fields:
        time_ns: stamps of the estimate's poses by the reference's clock ``(P,)``; they repeat where
            one pose serves two stamps.
        estimate, reference: Motors ``(P,)``.
        estimate_index, reference_index: where the poses stand in their trajectories ``(P,)``; the
            nearest ones where poses are interpolated.

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

    def first(self, count: int) -> Pairs:
        """So many pairs from the start, or all where there are no more."""
        return Pairs(*(getattr(self, field.name)[:count] for field in fields(self)))


def associate(
    estimate: Trajectory,
    reference: Trajectory,
    max_difference_s: float = 0.01,
    *,
    offset_s: float = 0.0,
    interpolate: bool = False,
    max_gap_s: float | None = None,
) -> Pairs:
    """Pair poses with the nearest stamps, as ``evo.core.sync`` does.

    The trajectory with fewer poses leads: each of its poses takes the other's nearest one, the
    earlier of two equally near, and is left out if that is more than `max_difference_s` away.
    A pose of the longer trajectory may serve twice.

    Args:
        estimate: the trajectory to judge.
        reference: the ground truth.
        max_difference_s: how far apart paired stamps may be.
        offset_s: what to add to the estimate's stamps to have the reference's clock.
        interpolate: pair the same poses, but take the longer trajectory at the stamps of the
            shorter one: positions on straight lines, rotations on great circles (slerp), the end
            poses beyond the ends.
        max_gap_s: where poses are interpolated, those between which more time lies lead nowhere:
            pairs there are left out, and the log says how many.

    Raises:
        ValueError: `max_difference_s` negative or not finite, `offset_s` not finite or beyond a
            hundred years, no two stamps near enough, or a single pose to interpolate.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.metrics import associate
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> len(associate(true[5:40], true))
        35
        >>> late = true.at_rate(25.0)
        >>> len(associate(late, true, 0.001)), len(associate(late, true, 0.02, interpolate=True))
        (11, 51)
    """
    if not (np.isfinite(max_difference_s) and max_difference_s >= 0.0):
        raise ValueError(f"max_difference_s: expected 0 or more, got {max_difference_s}")
    offset_ns = checked_offset_ns(offset_s)
    reference_leads = len(estimate) > len(reference)
    short, long = (reference, estimate) if reference_leads else (estimate, reference)
    to_short_s = offset_s if reference_leads else -offset_s
    short_s, long_s = stamps_s(short), stamps_s(long)
    short_index, long_index = _nearest(short_s, long_s + to_short_s, max_difference_s)
    if short_index.size == 0:
        apart_s = 1e-9 * float(reference.time_ns[0] - estimate.time_ns[0])
        raise ValueError(
            f"estimate and reference: expected stamps within max_difference_s = "
            f"{max_difference_s} s of each other, got none; the estimate spans "
            f"{estimate.time_ns[0] + offset_ns} to {estimate.time_ns[-1] + offset_ns} ns, the "
            f"reference {reference.time_ns[0]} to {reference.time_ns[-1]} ns; if both begin at the "
            f"same moment, offset_s={apart_s:.9g} (--offset-s {apart_s:.9g}) says so"
        )
    if interpolate and max_gap_s is not None:
        asked_ns = short.time_ns[short_index] - (offset_ns if reference_leads else -offset_ns)
        bad = inside_gaps(asked_ns, long.time_ns, max_gap_s)
        short_index, long_index = short_index[~bad], long_index[~bad]
        if not short_index.size:
            raise ValueError(
                f"max_gap_s: expected poses around some pair, got gaps over {max_gap_s} s"
            )
        if np.any(bad):
            text = "%d pairs are left out: they lie in gaps of more than %g s"
            _LOG.warning(text, np.count_nonzero(bad), max_gap_s)
    e, r = (long_index, short_index) if reference_leads else (short_index, long_index)
    ours, true, stamps = estimate.motors[e], reference.motors[r], estimate.time_ns[e] + offset_ns
    if interpolate:
        between = _interpolated(long, long_s, short_s[short_index] - to_short_s)
        ours, true = (between, true) if reference_leads else (ours, between)
        stamps = reference.time_ns[r] if reference_leads else stamps
    return Pairs(stamps, ours, true, e, r)


def checked_offset_ns(offset_s: float) -> int:
    """An offset of a clock in nanoseconds.

    Raises:
        ValueError: not finite, or more than a hundred years: no stamp could carry it.
    """
    if not abs(offset_s) <= 3.2e9:
        raise ValueError(f"offset_s: expected at most 3.2e9 s (a hundred years), got {offset_s}")
    return round(offset_s * _NS_PER_S)


def cropped(
    trajectory: Trajectory, start_s: float | None = None, end_s: float | None = None
) -> Trajectory:
    """The poses from `start_s` to `end_s`, in seconds of the trajectory's own clock, ends included.

    Raises:
        ValueError: a start after the end, NaN, or no pose in between.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import cropped
        >>> from motorcade.ga import Motor, Trajectory
        >>> path = Trajectory(np.arange(5) * 1_000_000_000, Motor.identity((5,)))
        >>> cropped(path, start_s=2.0).time_ns
        array([2000000000, 3000000000, 4000000000])
    """
    first = -np.inf if start_s is None else start_s
    last = np.inf if end_s is None else end_s
    if not first <= last:
        raise ValueError(f"start_s, end_s: expected a start before the end, got {first}, {last}")
    seconds = stamps_s(trajectory)
    kept = (seconds >= first) & (seconds <= last)
    if not np.any(kept):
        raise ValueError(
            f"start_s, end_s: expected poses from {first} to {last} s, got none; the trajectory "
            f"spans {seconds[0]:.9f} to {seconds[-1]:.9f} s"
        )
    return trajectory if np.all(kept) else trajectory[kept]


def stamps_s(trajectory: Trajectory) -> FloatArray:
    """Float seconds, rounded once: the doubles that a file's decimal stamps are read as."""
    whole, rest = np.divmod(trajectory.time_ns, _NS_PER_S)
    return whole + rest / _NS_PER_S


def _interpolated(path: Trajectory, path_s: FloatArray, time_s: FloatArray) -> Motor:
    if len(path) < 2:
        raise ValueError("interpolate: expected 2 or more poses to interpolate between, got 1")
    after = np.clip(np.searchsorted(path_s, time_s, side="left"), 1, len(path) - 1)
    before = after - 1
    step = path_s[after] - path_s[before]
    since = time_s - path_s[before]
    fraction = np.clip(np.divide(since, step, out=np.zeros_like(since), where=step > 0.0), 0.0, 1.0)
    poses, positions = path.motors, path.motors.translation_m
    between = positions[before] + fraction[:, None] * (positions[after] - positions[before])
    rotors = poses.rotor
    return Motor.from_rotor_translation(
        rotors[before].interpolate(rotors[after], fraction), between
    )


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
