"""Weighted averages over windows of time, in the vectors that a representation gives.

At every pose the vectors to its neighbours are weighted and added up, and the pose moves by the
sum; this is repeated from where it then is, until the sum is zero. That is the Karcher mean, which
does not depend on the noisy pose that it began from. Neighbours are visited by how many poses lie
between, so that a whole segment of the path is one contiguous batch of the compiled kernels; what
belongs to a window, and how much, is told by the stamps alone. Segments are short enough to stay
in a processor's cache.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.representations import Representation, restored
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# Weights of a segment, in numbers: with the vectors a quarter of a common second-level cache.
_SEGMENT = 65_536
_SHORTEST, _LONGEST = 16, 4096
# Means are found when no pose of a segment moves farther, in radians and metres. Each round leaves
# about the square of the window's turn of what was left: four to six are usual, and where a window
# turns by nearly π there may be no mean to be found.
_SETTLED, _ROUNDS = 1e-11, 20

Weights = Callable[[FloatArray, NDArray[np.bool_]], FloatArray]
"""From times ``(K, M)`` in seconds after the centre, and which of them are in the window, to the
factors ``(K, M)`` of the vectors, or P ways ``(P, K, M)``."""


def averaged(
    trajectory: Trajectory,
    representation: Representation,
    first: IntArray,
    last: IntArray,
    weights: Weights,
) -> Trajectory:
    """Move every pose to where the weighted sum of the vectors to the poses in its window is zero.

    Where that sum does not shrink any more (poses too far apart to have a mean) a pose stays.

    Args:
        trajectory: N poses.
        representation: what the vectors are.
        first: ``(N,)`` row at which each window begins.
        last: ``(N,)`` row before which it ends; at least one more than `first`.
        weights: see `Weights`.
    """
    coordinates = np.asfortranarray(representation.coordinates(trajectory.poses))
    means = np.empty_like(coordinates)
    for part in _segments(first, last):
        windows = Windows.of(trajectory.time_ns, part, first, last, weights)
        at, before = coordinates[part], np.inf
        for _ in range(_ROUNDS if representation.coupled else 1):
            moves = weighted_vectors(coordinates, at, representation, windows)[0]
            sizes = np.max(np.abs(moves), axis=1)
            moves[sizes >= before] = 0.0
            at = representation.retract(at, moves)
            if np.max(np.abs(moves)) < _SETTLED:
                break
            before = sizes
        means[part] = at
    return restored(representation, means, trajectory)


@dataclass(frozen=True, eq=False)
class Windows:
    """The windows of a segment of poses, with the factors of the vectors in them.

    Fields:
        part: the M poses of the segment.
        nearest: how many rows from a pose the first pose of any window is, at most 0.
        factors: ``(P, K, M)`` of the vectors to the poses `nearest` and more rows on, P ways.
    """

    part: slice
    nearest: int
    factors: FloatArray

    @classmethod
    def of(
        cls, time_ns: IntArray, part: slice, first: IntArray, last: IntArray, weights: Weights
    ) -> Windows:
        """Windows from rows `first` ``(N,)`` to before `last`; of weights ``(K, M)`` P is 1."""
        rows = np.arange(part.start, part.stop)
        from_row, to_row = first[part] - rows, last[part] - rows
        nearest, farthest = int(np.min(from_row)), int(np.max(to_row))
        steps = np.arange(nearest, farthest)[:, None]
        inside = (steps >= from_row) & (steps < to_row)
        factors = weights(_offsets_s(time_ns, part, nearest, farthest), inside)
        return cls(part, nearest, factors if factors.ndim == 3 else factors[None])


def weighted_vectors(
    coordinates: FloatArray, bases: FloatArray, representation: Representation, windows: Windows
) -> FloatArray:
    """Sums ``(P, M, d)`` of the vectors from M bases to the poses around them, weighted P ways.

    Args:
        coordinates: ``(N, D)``.
        bases: ``(M, D)`` where the vectors start, one a pose of the segment.
        representation: what the vectors are.
        windows: of the segment.
    """
    start, count = windows.part.start, len(bases)
    total = None
    for k in range(windows.factors.shape[1]):
        step = windows.nearest + k
        own = slice(max(0, -step - start), min(count, len(coordinates) - step - start))
        theirs = slice(start + own.start + step, start + own.stop + step)
        vectors = representation.local(coordinates[theirs], bases[own]).T
        if total is None:
            total = np.zeros((len(windows.factors), len(vectors), count))
        for p, factor in enumerate(windows.factors[:, k, own]):
            total[p, :, own] += factor * vectors
    assert total is not None  # every window holds its own pose
    return np.swapaxes(total, 1, 2)


def _offsets_s(time_ns: IntArray, part: slice, nearest: int, farthest: int) -> FloatArray:
    """Seconds ``(farthest - nearest, M)`` from poses to those so many rows on; 0 off the path."""
    start, stop = part.start + nearest, part.stop + farthest - 1
    near = time_ns[max(start, 0) : stop]
    padded = np.zeros(stop - start, dtype=np.int64)
    padded[max(-start, 0) : max(-start, 0) + len(near)] = near
    windows = np.lib.stride_tricks.sliding_window_view(padded, part.stop - part.start)
    return np.asarray((windows - time_ns[part]) * 1e-9, dtype=np.float64)


def polynomial_at_centre(
    u: FloatArray, weight: FloatArray, inside: NDArray[np.bool_], order: int, derivative: int = 0
) -> FloatArray:
    """Factors ``(K, M)`` that give a fitted polynomial's coefficient at u = 0 as a sum.

    The polynomial fits the values at `u` in weighted least squares: with weights W and powers V of
    u its coefficients are ``(VᵀWV)⁻¹VᵀW``, of which this is row `derivative`. Windows that hold too
    few poses for the order get the highest that they determine, and 0 where that has no such row.
    """
    factors = np.zeros_like(u)
    degree = np.minimum(order, np.count_nonzero(inside, axis=0) - 1)
    for p in np.unique(degree):
        columns = degree == p
        if p < derivative:
            continue
        if np.all(columns):
            return _fitted(u, weight, int(p), derivative)
        factors[:, columns] = _fitted(u[:, columns], weight[:, columns], int(p), derivative)
    return factors


def _fitted(u: FloatArray, weight: FloatArray, order: int, derivative: int) -> FloatArray:
    moments = []
    term = weight
    for _ in range(2 * order + 1):
        moments.append(np.sum(term, axis=0))
        term = term * u
    if order == 0:
        factors = np.broadcast_to(1.0 / moments[0], u.shape)
    elif order == 1:
        s0, s1, s2 = moments
        constant, slope = (s2, -s1) if derivative == 0 else (-s1, s0)
        determinant = s0 * s2 - s1 * s1
        factors = u * (slope / determinant) + constant / determinant
    else:
        factors = _polynomials(moments, u, order, derivative)
    weighted: FloatArray = weight * factors
    return weighted


def _polynomials(
    moments: list[FloatArray], u: FloatArray, order: int, derivative: int
) -> FloatArray:
    """Values at `u` of the polynomials that the moments' normal equations give."""
    normal = np.stack([np.stack(moments[i : i + order + 1], -1) for i in range(order + 1)], -2)
    unit = np.zeros((len(normal), order + 1, 1))
    unit[:, derivative] = 1.0
    solution = np.linalg.solve(normal, unit)[..., 0].T
    value = np.broadcast_to(solution[order], u.shape)
    for row in solution[order - 1 :: -1]:
        value = value * u + row
    return value


def _segments(first: IntArray, last: IntArray) -> list[slice]:
    """Consecutive poses, as many at once as suits the widest window."""
    widest = max(1, int(np.max(last - first)))
    size = min(max(_SEGMENT // widest, _SHORTEST), _LONGEST)
    count = len(first)
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]
