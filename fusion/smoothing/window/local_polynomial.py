"""Zero-lag smoothing by local polynomials: at every stamp one of its neighbourhood.

The window is symmetric in time, so there is no lag. Stamps may be uneven and gaps are no special
case: what lies in a window is told by time, never by index.

Sources: W. S. Cleveland, Robust locally weighted regression and smoothing scatterplots, JASA 74
(1979), for the tricube weights; A. Savitzky and M. Golay, Analytical Chemistry 36 (1964), for equal
ones.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.checks import checked_length, checked_order
from motorcade.fusion.smoothing.representations import Representation
from motorcade.fusion.smoothing.window.averages import averaged, polynomial_at_centre
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive

__all__ = ["local_polynomial", "savitzky_golay", "shifted_windows", "white_noise_removed"]


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
    double = 2 * (time_ns - time_ns[0])  # widths may be odd
    first = np.searchsorted(double, double - width_ns, side="right")
    return first, np.searchsorted(double, double + width_ns, side="left")


def shifted_windows(time_ns: IntArray, width_ns: int) -> tuple[IntArray, IntArray]:
    """The same windows, shifted to stay on the path."""
    first, last = centred_windows(time_ns, width_ns)
    early = 2 * (time_ns - time_ns[0]) < width_ns
    late = 2 * (time_ns[-1] - time_ns) < width_ns
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
    width_ns = round(checked_positive(window_s, "window_s", "seconds") * 1e9)
    if width_ns < 1:
        raise ValueError(f"window_s: expected at least 1e-9 seconds, got {window_s}")
    return width_ns, checked_order(order)
