"""Which poses of two trajectories belong together: the nearest stamps, as evo pairs them.

Differences of stamps are formed in float seconds, rounded as evo rounds them, so that ties fall and
poses are interpolated as they are there. At today's stamps that rounds to 0.2 µs.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, fields

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import inside_gaps

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
    seconds: FloatArray = whole + rest / _NS_PER_S
    return seconds


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
