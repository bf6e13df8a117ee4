"""Smoothers that average over a window of time around every pose: no lag, no memory, no model.

The window is symmetric in time. Stamps may be uneven and gaps are no special case: what lies in a
window is told by time, never by index.

Sources: W. S. Cleveland, Robust locally weighted regression and smoothing scatterplots, JASA 74
(1979), for the tricube weights; A. Savitzky and M. Golay, Analytical Chemistry 36 (1964), for equal
ones.

`automatic_window_s` tells how wide a window may be before it takes away motion instead of noise.
White noise gives up a known share of its variance to a window of a given width, so how far
smoothing moves a path tells how large the noise would have to be. Two things betray motion: that
size grows as the window widens, or it exceeds the uncertainty that the path itself claims.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.checks import checked_length, checked_order
from motorcade.fusion.smoothing.representations import REPRESENTATIONS, Representation, restored
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.ga.stamps import checked_span_ns


def local_polynomial(
    trajectory: Trajectory,
    representation: Representation,
    *,
    window_s: float = 0.3,
    order: int = 2,
) -> Trajectory:
    """Local polynomials with Cleveland's tricube weights, which fade out at the window's ends.

    At the ends of the path the window is one-sided, and less is smoothed away there.

    Args:
        trajectory: at any sampling, even or not.
        representation: what the poses are averaged as. With "motor" and "rotor", poses in one
            window must be less than half a turn from its centre for the result to mean anything.
        window_s: full width of the window in seconds. Motion faster than about 1 / window_s Hz is
            smoothed away with the noise.
        order: of the polynomial: 0 average, 1 line (both cut corners), 2 parabola (keeps
            constant acceleration), up to 5. Where the window holds too few poses for it, the
            highest order that they determine is used; a pose alone in its window stays as it is.

    Raises:
        ValueError: a window that is not positive, an order outside 0 to 5.
    """
    width_ns, degree = _settings(window_s, order)
    first, last = centred_windows(trajectory.time_ns, width_ns)

    def weights(offset_s: FloatArray, inside: NDArray[np.bool_]) -> FloatArray:
        u = offset_s * (2e9 / width_ns)
        weight = np.where(inside, (1.0 - np.minimum(np.abs(u), 1.0) ** 3) ** 3, 0.0)
        return polynomial_at_centre(u, weight, inside, degree)

    return averaged(trajectory, representation, first, last, weights)


def savitzky_golay(
    trajectory: Trajectory,
    representation: Representation,
    *,
    window_s: float = 0.3,
    order: int = 2,
) -> Trajectory:
    """Local polynomials with equal weights: Savitzky and Golay's filter, over time.

    A window of n even intervals holds n poses (n odd), and the result is that of
    scipy.signal.savgol_filter. As there (mode "interp"), poses less than half a window from an end
    of the path share the outermost whole window: its polynomial is evaluated at their stamps.

    Args:
        trajectory: at least order + 1 poses at any sampling.
        representation: what the poses are averaged as; see `local_polynomial`. Near the ends of the
            path poses up to a whole window away are averaged.
        window_s: full width of the window in seconds; half a window is open at both ends.
        order: of the polynomial, 0 to 5; see `local_polynomial`.

    Raises:
        ValueError: a window that is not positive, an order outside 0 to 5, too few poses.
    """
    width_ns, degree = _settings(window_s, order)
    checked_length(trajectory, degree + 1, f"savitzky_golay of order {degree}")
    first, last = shifted_windows(trajectory.time_ns, width_ns)

    def weights(offset_s: FloatArray, inside: NDArray[np.bool_]) -> FloatArray:
        u = offset_s * (2e9 / width_ns)
        return polynomial_at_centre(u, inside.astype(np.float64), inside, degree)

    return averaged(trajectory, representation, first, last, weights)


def centred_windows(time_ns: IntArray, width_ns: int) -> tuple[IntArray, IntArray]:
    """Rows ``(N,)`` that begin and end the open windows of a width around every stamp."""
    reach_ns = (width_ns - 1) // 2  # whole nanoseconds below half the width, which may be odd
    first = np.searchsorted(time_ns, time_ns - reach_ns, side="left")
    return first, np.searchsorted(time_ns, time_ns + reach_ns, side="right")


def shifted_windows(time_ns: IntArray, width_ns: int) -> tuple[IntArray, IntArray]:
    """The same windows, shifted to stay on the path."""
    first, last = centred_windows(time_ns, width_ns)
    early = time_ns - time_ns[0] <= (width_ns - 1) // 2
    late = time_ns[-1] - time_ns <= (width_ns - 1) // 2
    first[late] = np.searchsorted(time_ns, time_ns[-1] - width_ns, side="right")
    last[early] = np.searchsorted(time_ns, time_ns[0] + width_ns, side="left")
    first[early], last[late] = 0, len(time_ns)
    return first, last


def white_noise_removed(neighbours: int, order: int) -> float:
    """Share of white noise's variance that a window of 2 `neighbours` + 1 even stamps takes away.

    The window reaches half an interval beyond the last neighbour, with tricube weights; 0 where the
    polynomial meets every pose exactly, towards 1 in wide windows.
    """
    u = np.arange(-neighbours, neighbours + 1)[:, None] / (neighbours + 0.5)
    inside = np.ones(u.shape, dtype=np.bool_)
    weight = (1.0 - np.abs(u) ** 3) ** 3
    kernel = polynomial_at_centre(u, weight, inside, order)[:, 0]
    return float(1.0 - 2.0 * kernel[neighbours] + np.sum(kernel**2))


def _settings(window_s: float, order: int) -> tuple[int, int]:
    width_ns = checked_span_ns(checked_positive(window_s, "window_s", "seconds"), "window_s")
    if width_ns < 1:
        raise ValueError(f"window_s: expected at least 1e-9 seconds, got {window_s}")
    return width_ns, checked_order(order)


# Beyond this many standard deviations weights are lost beside the largest.
_FARTHEST = 8.0


def gaussian(
    trajectory: Trajectory,
    representation: Representation,
    *,
    sigma_s: float = 0.1,
    truncate: float = 4.0,
    order: int = 1,
) -> Trajectory:
    """Average with Gaussian weights over time, ``exp(-t² / 2 sigma_s²)``.

    On even stamps it is the usual Gaussian filter (scipy.ndimage.gaussian_filter1d) away from the
    ends. Where stamps are uneven, and at the ends, a plain mean is drawn towards the side that has
    more poses, by as much as the path moves; the line fitted with the same weights (`order` 1) is
    not, and even stamps make no difference between the two. Across a gap longer than the window
    nothing is averaged; a pose alone in its window stays.

    Args:
        trajectory: at any sampling.
        representation: what is averaged. Poses in one window must be less than half a turn from its
            centre for twists and rotation vectors to mean anything.
        sigma_s: standard deviation in seconds. Motion of frequency f is damped to
            ``exp(-½ (2π f sigma_s)²)``: to half at 0.187 / sigma_s Hz.
        truncate: standard deviations at which the window ends, on both sides and inclusively;
            at most 8.
        order: 1 line, 0 plain mean (Nadaraya and Watson's), up to 5.

    Raises:
        ValueError: sigma_s not positive, truncate outside 0 to 8, or an order outside 0 to 5.

    Source: local regression as W. S. Cleveland, JASA 74 (1979), with Gaussian weights.
    """
    sigma = checked_positive(sigma_s, "sigma_s", "seconds")
    if not 0.0 < truncate <= _FARTHEST:
        raise ValueError(f"truncate: expected above 0 and at most {_FARTHEST:g}, got {truncate}")
    reach_ns = checked_span_ns(truncate * sigma, "sigma_s times truncate")
    degree = checked_order(order)
    time_ns = trajectory.time_ns
    first = np.searchsorted(time_ns, time_ns - reach_ns, side="left")
    last = np.searchsorted(time_ns, time_ns + reach_ns, side="right")

    def weights(offset_s: FloatArray, inside: NDArray[np.bool_]) -> FloatArray:
        u = offset_s * (1.0 / sigma)
        weight = np.exp(-0.5 * u * u)
        weight *= inside
        return polynomial_at_centre(u, weight, inside, degree)

    return averaged(trajectory, representation, first, last, weights)


_FEWEST, _MOST = 2, 10
# White noise of a few hundred poses estimates its own variance to better than this factor.
_GROWTH = 1.5


def automatic_window_s(
    trajectory: Trajectory, covariance: FloatArray, order: int = 2
) -> float | None:
    """The widest window, up to 21 poses, that removes noise alone; None if none does.

    Args:
        trajectory: N poses; the window is counted in their median interval.
        covariance: ``(N, 6, 6)`` of the right perturbation, rotation (rad) then translation (m).
        order: of the local polynomials, see `local_polynomial`.

    Raises:
        ValueError: covariances that do not fit the trajectory, or as `local_polynomial`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion.smoothing import automatic_window_s
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> covariance = np.diag([0.02**2] * 3 + [0.01**2] * 3)  # rotation first
        >>> window_s = automatic_window_s(noisy, np.tile(covariance, (len(noisy), 1, 1)))
        >>> print(f"{window_s:.2f} s")
        0.70 s
    """
    if covariance.shape != (len(trajectory), 6, 6):
        raise ValueError(f"covariance: expected {(len(trajectory), 6, 6)}, got {covariance.shape}")
    if len(trajectory) < 2 * _MOST + 1:
        return None
    interval_s = float(np.median(np.diff(trajectory.time_s)))
    motors, good = REPRESENTATIONS["motor"], list[float]()
    narrowest_size = None
    for neighbours in range(_FEWEST, _MOST + 1):
        share = white_noise_removed(neighbours, order)
        if share < 1e-6:
            continue  # so few poses are met exactly
        window_s = (2 * neighbours + 1) * interval_s
        smoothed = local_polynomial(trajectory, motors, window_s=window_s, order=order)
        size = mean_square_change(trajectory, smoothed, covariance) / share
        narrowest_size = size if narrowest_size is None else narrowest_size
        if size > _GROWTH * min(1.0, narrowest_size):
            break
        good.append(window_s)
    # That one window's size does not exceed itself is no evidence: a second one must agree.
    return good[-1] if len(good) > 1 else None


def mean_square_change(
    trajectory: Trajectory, smoothed: Trajectory, covariance: FloatArray
) -> float:
    """Mean square of how far smoothing moved poses, in their own deviations, a dimension.

    Of white noise that smoothing takes away whole it is 1.

    Args:
        trajectory: N poses.
        smoothed: the same stamps.
        covariance: ``(N, 6, 6)`` of the right perturbation, rotation (rad) then translation (m).
    """
    change = trajectory.motors.local(smoothed.motors)
    weighed = np.linalg.solve(covariance, change[..., None])[..., 0]
    return float(np.mean(change * weighed))


# Weighted averages over windows of time, in the vectors that a representation gives.
#
# At every pose the vectors to its neighbours are weighted and added up, and the pose moves by the
# sum; this is repeated from where it then is, until the sum is zero. That is the Karcher mean,
# which does not depend on the noisy pose that it began from. Neighbours are visited by how many
# poses lie between, so that a whole segment of the path is one contiguous batch of the compiled
# kernels; what belongs to a window, and how much, is told by the stamps alone. Segments are short
# enough to stay in a processor's cache.

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
