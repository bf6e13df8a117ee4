"""Stamps: integer nanoseconds, where they leave gaps, and how many an even rate makes of them.

One rule for the whole product, so that work grows with the poses and not with the time that passes:

* a stamp lies within ±2⁶² ns, 146 years of zero, so that differences of stamps fit into int64;
* a step of more than three median steps is a gap: differences across it are no speed;
* a gap of more than ten seconds splits a path. Nothing tells what happened within, so nothing is
  computed there: each segment is sampled, fitted and correlated for itself. Shorter gaps are
  bridged.
* samples at an even rate may be at most 50,000, and 500 more for each pose that they are made
  from; ten million where they are made of nothing but a formula.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga.arrays import FloatArray, IntArray

STAMP_LIMIT_NS = 2**62
"""Stamps lie nearer to zero than this."""
GAP_STEPS = 3.0
"""A step of more than so many median steps is a gap."""
LONGEST_BRIDGE_S = 10.0
"""A longer gap splits a path."""
LONGEST_SPAN_S = 1e9
"""No window, shift or offset is longer than this, thirty years."""
LONGEST_READOUT_S = 0.2
"""No rolling shutter takes longer from the first row of an image to the last."""
_MOST, _MOST_A_POSE, _MOST_OF_A_FORMULA = 50_000, 500, 10_000_000


def checked_stamps(value: ArrayLike, name: str) -> IntArray:
    """Stamps ``(*)`` as int64.

    Args:
        value: integer nanoseconds.
        name: what the caller calls them; it opens the error message.

    Raises:
        ValueError: no integers, or 2⁶² ns or more from zero.
    """
    values = np.asarray(value)
    if values.dtype.kind != "i":
        raise ValueError(f"{name}: expected integer nanoseconds, got dtype {values.dtype}")
    stamps = values.astype(np.int64, copy=False)
    if stamps.size:
        first, last = int(stamps.min()), int(stamps.max())
        if max(-first, last) >= STAMP_LIMIT_NS:
            far = first if -first > last else last
            raise ValueError(
                f"{name}: expected stamps within 146 years (2**62 ns) of zero, got {far} ns"
            )
    return stamps


def checked_increasing(value: ArrayLike, name: str, fewest: int) -> IntArray:
    """A read-only copy of stamps ``(N,)`` that strictly increase.

    Raises ValueError: as `checked_stamps`; another shape, fewer, or stamps that do not increase.
    """
    values = checked_stamps(value, name)
    if values.ndim != 1 or values.size < fewest:
        raise ValueError(f"{name}: expected shape (N,) with N >= {fewest}, got {values.shape}")
    backwards = np.flatnonzero(np.diff(values) <= 0)
    if backwards.size:
        at = int(backwards[0]) + 1
        raise ValueError(
            f"{name}: expected strictly increasing stamps, got {int(values[at])} at index {at} "
            f"after {int(values[at - 1])}"
        )
    stamps = values.copy()
    stamps.setflags(write=False)
    return stamps


def checked_span_ns(seconds: float, name: str) -> int:
    """A span of time in whole nanoseconds.

    Raises ValueError: not a number from -1e9 to 1e9 seconds.
    """
    if not -LONGEST_SPAN_S <= seconds <= LONGEST_SPAN_S:
        raise ValueError(
            f"{name}: expected seconds up to {LONGEST_SPAN_S:g} (thirty years), got {seconds}"
        )
    return round(seconds * 1e9)


def checked_rate(rate_hz: float, name: str) -> float:
    """A rate of stamps, from one in thirty years to one a nanosecond.

    Raises ValueError: another number.
    """
    if not 1e-9 <= rate_hz <= 1e9:
        raise ValueError(f"{name}: expected a positive number from 1e-9 to 1e9, got {rate_hz}")
    return rate_hz


def near_steps(steps: FloatArray | IntArray) -> NDArray[np.bool_]:
    """Which of the steps ``(N - 1,)`` between stamps are no gaps."""
    if not steps.size:
        return np.zeros(0, dtype=np.bool_)
    return np.asarray(steps <= GAP_STEPS * np.median(steps))


def segments(time_ns: IntArray) -> list[slice]:
    """The segments of stamps ``(N,)`` that no gap of more than ten seconds splits, in order.

    >>> import numpy as np
    >>> segments(10**9 * np.array([0, 1, 2, 3, 86_400, 86_401]))
    [slice(0, 4, None), slice(4, 6, None)]
    """
    steps = np.diff(time_ns)
    split = np.flatnonzero(~near_steps(steps) & (steps > LONGEST_BRIDGE_S * 1e9)) + 1
    edges = [0, *split.tolist(), len(time_ns)]
    return [slice(first, last) for first, last in pairwise(edges)]


def stamps_at_rate(time_ns: IntArray, rate_hz: float, name: str) -> IntArray:
    """Stamps at an even rate from the first of stamps ``(N,)`` on, anew in every segment.

    Args:
        time_ns: increasing.
        rate_hz: stamps a second.
        name: what the caller calls the rate.

    Raises:
        ValueError: as `checked_rate`, or more stamps than there may be.

    >>> import numpy as np
    >>> stamps_at_rate(10**9 * np.array([0, 1, 86_400, 86_401]), 2.0, "rate_hz") * 1e-9
    array([0.00000e+00, 5.00000e-01, 1.00000e+00, 8.64000e+04, 8.64005e+04,
           8.64010e+04])
    """
    checked_rate(rate_hz, name)
    spans = [(int(time_ns[part.start]), int(time_ns[part.stop - 1])) for part in segments(time_ns)]
    counts = [int((last - first) * 1e-9 * rate_hz + 1e-6) + 1 for first, last in spans]
    check_count(sum(counts), f"{name} of {rate_hz:g}", len(time_ns))
    return np.concatenate(
        [
            np.minimum(first + np.rint(np.arange(count) * (1e9 / rate_hz)).astype(np.int64), last)
            for (first, last), count in zip(spans, counts, strict=True)
        ]
    )


def inside_gaps(stamps_ns: IntArray, time_ns: IntArray, max_gap_s: float) -> NDArray[np.bool_]:
    """Which stamps ``(M,)`` lie between two of ``(N,)`` that are farther apart than so much.

    Raises:
        ValueError: a gap that is not above 0.

    >>> import numpy as np
    >>> inside_gaps(10**9 * np.array([0, 1, 3, 5]), 10**9 * np.array([0, 1, 5]), 1.0)
    array([False, False,  True, False])
    """
    if not max_gap_s > 0.0:
        raise ValueError(f"max_gap_s: expected seconds above 0, got {max_gap_s}")
    after = np.searchsorted(time_ns, stamps_ns)
    between = (after > 0) & (after < len(time_ns))
    after = np.clip(after, 1, max(1, len(time_ns) - 1))
    if len(time_ns) < 2:
        return np.zeros(len(stamps_ns), dtype=np.bool_)
    wide: NDArray[np.bool_] = (time_ns[after] - time_ns[after - 1]) * 1e-9 > max_gap_s
    inside: NDArray[np.bool_] = wide & between & (time_ns[after] != stamps_ns)
    return inside


def check_count(count: float, name: str, poses: int | None = None) -> None:
    """Refuse more even samples than may be made from so many poses; None: from a formula.

    Raises ValueError: such a count.
    """
    most = _MOST_OF_A_FORMULA if poses is None else _MOST + _MOST_A_POSE * poses
    if not count <= most:
        reason = "" if poses is None else f" from {poses} poses ({_MOST}, {_MOST_A_POSE} a pose)"
        raise ValueError(
            f"{name}: expected at most {most} samples{reason}, got {count:.6g}; choose a lower "
            "rate or a shorter time"
        )
