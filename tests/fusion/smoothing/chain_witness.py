"""The longest smooth chain of poses in NumPy, every joint tried: a witness of the compiled one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.batch.inliers import Sizes
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray

# Poses that one joint may cost at most, and pieces that may be left out between two joined ones.
_DEAREST_JOINT = 20.0
_PIECES_BACK = 48
_LEAP_DEVIATIONS = 5.0
_LEAP_MEDIANS = 6.0
_NEIGHBOURS = 3
_END_STEPS = 6
# Medians at once, for the sake of memory.
_CHUNK = 4096
# Deviation of the speed at an end, times the span that it is taken from, in deviations of a pose.
_SPEED_ERROR = 2.0


def witnessed_chain(
    time_s: FloatArray, poses: Motor, rotation: Sizes, translation: Sizes
) -> NDArray[np.bool_]:
    """Which of the poses ``(N,)`` belong to the longest smooth chain; see `inlier_poses`."""
    if len(poses) < 3:
        return np.ones(len(poses), dtype=np.bool_)
    interval_s = np.diff(time_s)
    steps = (poses[:-1].inverse() @ poses[1:]).as_twist()
    rates = steps / interval_s[:, None]
    usual = _moving_median(rates)
    leaps = np.zeros(len(steps), dtype=np.bool_)
    for block, (noise, acceleration) in ((slice(0, 3), rotation), (slice(3, 6), translation)):
        off = np.linalg.norm((rates - usual)[:, block], axis=1) * interval_s
        allowed = np.sqrt(2.0 * noise**2 + acceleration**2 * interval_s**3)
        limit = np.maximum(_LEAP_DEVIATIONS * allowed, _LEAP_MEDIANS * np.median(off))
        leaps |= off > limit
    cuts = np.flatnonzero(leaps) + 1
    first, last = np.append(0, cuts), np.append(cuts, len(poses)) - 1
    kept = _best_chain(_Pieces.of(time_s, poses, rates, first, last), rotation, translation)
    made = np.zeros(len(poses), dtype=np.bool_)
    for piece in kept:
        made[first[piece] : last[piece] + 1] = True
    return made


class _Pieces(NamedTuple):
    """Segments without leaps; arrays of ends have the start first, ``(K, 2)``.

    `rate` is the twist a second at either end, from steps that span `span_s`; 0 and infinity where
    a pose stands alone.
    """

    size: IntArray
    time_s: FloatArray
    start: Motor
    end: Motor
    rate: FloatArray
    span_s: FloatArray

    @classmethod
    def of(
        cls, time_s: FloatArray, poses: Motor, rates: FloatArray, first: IntArray, last: IntArray
    ) -> _Pieces:
        rate, span_s = np.zeros((len(first), 2, 6)), np.full((len(first), 2), np.inf)
        for piece, (a, b) in enumerate(zip(first, last, strict=True)):
            if b > a:
                head, tail = min(b, a + _END_STEPS), max(a, b - _END_STEPS)
                rate[piece] = np.median(rates[a:head], axis=0), np.median(rates[tail:b], axis=0)
                span_s[piece] = time_s[head] - time_s[a], time_s[b] - time_s[tail]
        ends_s = np.stack([time_s[first], time_s[last]], axis=-1)
        return cls(last - first + 1, ends_s, poses[first], poses[last], rate, span_s)


def _best_chain(pieces: _Pieces, rotation: Sizes, translation: Sizes) -> list[int]:
    score = pieces.size.astype(np.float64)
    before = np.full(len(score), -1)
    for piece in range(1, len(score)):
        earlier = np.arange(max(0, piece - _PIECES_BACK), piece)
        joined = score[earlier] - _joint_cost(pieces, earlier, piece, rotation, translation)
        best = int(np.argmax(joined))
        if joined[best] > 0.0:
            score[piece] += joined[best]
            before[piece] = earlier[best]
    chain = [int(np.argmax(score))]
    while before[chain[-1]] >= 0:
        chain.append(int(before[chain[-1]]))
    return chain[::-1]


def _joint_cost(
    pieces: _Pieces, earlier: IntArray, piece: int, rotation: Sizes, translation: Sizes
) -> FloatArray:
    """Poses ``(K,)`` that it costs to go on from each earlier piece to this one."""
    gap_s = pieces.time_s[piece, 0] - pieces.time_s[earlier, 1]
    step = (pieces.end[earlier].inverse() @ pieces.start[piece]).as_twist()
    span_s = np.stack([pieces.span_s[earlier, 1], np.full(len(earlier), pieces.span_s[piece, 0])])
    # A pose alone has no speed of its own: that of the other side is taken for both.
    known = np.maximum(np.sum(np.isfinite(span_s), axis=0), 1)
    rate = (pieces.rate[earlier, 1] + pieces.rate[piece, 0]) / known[:, None]
    off = step - rate * gap_s[:, None]
    cost = np.zeros(len(earlier))
    for block, (noise, acceleration) in ((slice(0, 3), rotation), (slice(3, 6), translation)):
        extrapolated = np.sum((_SPEED_ERROR * noise * gap_s / span_s) ** 2, axis=0) / known**2
        variance = 2.0 * noise**2 + acceleration**2 * gap_s**3 + extrapolated
        cost += 0.5 * np.sum(off[:, block] ** 2, axis=1) / variance
    return np.minimum(cost, _DEAREST_JOINT)


def _moving_median(values: FloatArray) -> FloatArray:
    """Medians ``(N, d)`` over a few neighbours to both sides, fewer at the ends."""
    margin = ((_NEIGHBOURS, _NEIGHBOURS), (0, 0))
    mirror = len(values) > _NEIGHBOURS
    padded = np.pad(values, margin, "reflect") if mirror else np.pad(values, margin, "edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEIGHBOURS + 1, axis=0)
    made = np.empty(values.shape)
    for start in range(0, len(values), _CHUNK):
        np.median(windows[start : start + _CHUNK], axis=-1, out=made[start : start + _CHUNK])
    return made
