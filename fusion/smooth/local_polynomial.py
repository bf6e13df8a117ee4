"""Zero-lag smoothing by local polynomials: at every stamp one of its neighbourhood, weighted.

W. S. Cleveland, Robust locally weighted regression and smoothing scatterplots, JASA 74 (1979),
with his tricube weights, over time instead of neighbours by count: stamps may be uneven and gaps
are no special case. On even stamps it is Savitzky and Golay's filter with weights. The window is
symmetric in time, so there is no lag; at the ends it is one-sided, and less is smoothed away there.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.smooth.representations import (
    Representation,
    representation_named,
    restored,
)
from motorcade.ga import FloatArray, IntArray, Trajectory

__all__ = ["smooth", "white_noise_removed"]

_LARGEST_ORDER = 5
# Neighbours handled at once; bounds memory to a few hundred megabytes whatever the length.
_CHUNK = 500_000


def smooth(
    trajectory: Trajectory,
    representation: str = "motor",
    window_s: float = 0.3,
    order: int = 2,
) -> Trajectory:
    """Smooth a trajectory; the result has the same stamps and frames.

    Args:
        trajectory: at any sampling, even or not.
        representation: a name of `REPRESENTATIONS`: what the poses are averaged as.
        window_s: full width of the window in seconds. Motion faster than about 1 / window_s Hz is
            smoothed away with the noise.
        order: of the polynomial: 0 average, 1 line (both cut corners), 2 parabola (keeps
            constant acceleration), up to 5. Where the window holds too few poses for it, the
            highest order that they determine is used; a pose alone in its window stays as it is.

    Raises:
        ValueError: an unknown representation, a window that is not positive, an order outside
            0 to 5. With "motor", poses in one window must be less than half a turn from its centre
            for the result to mean anything; "quaternion" likewise for consecutive poses.
    """
    chosen = representation_named(representation)
    if not (np.isfinite(window_s) and window_s > 0.0):
        raise ValueError(f"window_s: expected a positive number of seconds, got {window_s}")
    if not 0 <= order <= _LARGEST_ORDER:
        raise ValueError(f"order: expected 0 to {_LARGEST_ORDER}, got {order}")
    chart = chosen.coordinates(trajectory.poses)
    half_ns = round(window_s * 0.5e9)
    first = np.searchsorted(trajectory.time_ns, trajectory.time_ns - half_ns, side="right")
    last = np.searchsorted(trajectory.time_ns, trajectory.time_ns + half_ns, side="left")
    centres = np.arange(len(trajectory))
    size = max(1, _CHUNK // int(np.max(last - first)))
    parts = [
        _smooth_part(
            trajectory.time_ns, chart, chosen, part, first[part], last[part], half_ns, order
        )
        for part in np.split(centres, range(size, len(trajectory), size))
    ]
    return restored(chosen, np.concatenate(parts), trajectory)


def white_noise_removed(neighbours: int, order: int) -> float:
    """Share of white noise's variance that a window of 2 `neighbours` + 1 even stamps takes away.

    The window reaches half an interval beyond the last neighbour; 0 where the polynomial meets
    every pose exactly, towards 1 in wide windows.
    """
    u = np.arange(-neighbours, neighbours + 1)[None] / (neighbours + 0.5)
    kernel = _kernel(u, np.ones(u.shape, dtype=np.bool_), order)[0]
    return float(1.0 - 2.0 * kernel[neighbours] + np.sum(kernel**2))


def _smooth_part(
    time_ns: IntArray,
    chart: FloatArray,
    representation: Representation,
    centres: IntArray,
    first: IntArray,
    last: IntArray,
    half_ns: int,
    order: int,
) -> FloatArray:
    """Smoothed coordinates at `centres` (M,), whose windows are rows `first` to `last` of the chart."""
    widest = int(np.max(last - first))
    neighbours = first[:, None] + np.arange(widest)
    inside = neighbours < last[:, None]
    neighbours = np.minimum(neighbours, len(time_ns) - 1)
    u = (time_ns[neighbours] - time_ns[centres][:, None]) / half_ns
    kernel = _kernel(u, inside, order)
    centre = chart[centres]
    values = representation.difference(chart[neighbours], centre[:, None])
    return representation.moved(centre, np.einsum("mk,mkd->md", kernel, values))


def _kernel(
    u: FloatArray, inside: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], order: int
) -> FloatArray:
    """Weights (M, K) that give the polynomial's value at u = 0 as a sum over the window.

    With weights W and powers V of u the fit is the first row of (VᵀWV)⁻¹VᵀW.
    """
    weight = np.where(inside, (1.0 - np.minimum(np.abs(u), 1.0) ** 3) ** 3, 0.0)
    kernel = np.zeros_like(u)
    degree = np.minimum(order, np.count_nonzero(inside, axis=1) - 1)
    for p in range(order + 1):
        rows = degree == p
        if not np.any(rows):
            continue
        powers = u[rows][..., None] ** np.arange(p + 1)
        weighted = powers * weight[rows][..., None]
        normal = np.einsum("mki,mkj->mij", weighted, powers)
        unit = np.zeros((p + 1, 1))
        unit[0] = 1.0
        solution = np.linalg.solve(normal, np.broadcast_to(unit, (len(normal), p + 1, 1)))
        kernel[rows] = np.einsum("mki,mi->mk", weighted, solution[..., 0])
    return kernel
