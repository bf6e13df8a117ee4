"""Twist, acceleration and jerk of a sampled trajectory, by local polynomials on the tangent.

Around every pose a polynomial is fitted to the twists from it to its neighbours; the coefficients
are the derivatives. The fit is repeated about the pose that it finds, so that the polynomial passes
through zero there: then the body twist is its slope, ``w = x'``, and with ``w' = x''`` and
``w'' = x''' - ½ [x', x'']`` the rest follows from the series of the right Jacobian.

Everything is told by time: stamps may be uneven. Noise of the poses is amplified with every
derivative, by about the order-th power of the inverse window.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.checks import checked_length
from motorcade.fusion.smoothing.representations import REPRESENTATIONS
from motorcade.fusion.smoothing.window import (
    Windows,
    polynomial_at_centre,
    shifted_windows,
    weighted_vectors,
)
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive
from motorcade.ga.motion import twist_bracket
from motorcade.ga.stamps import checked_span_ns

_LEAST_ORDER, _LARGEST_ORDER = 3, 8
_ROUNDS = 3
_SEGMENT = 2048


@dataclass(frozen=True, eq=False)
class PathDerivatives:
    """A path with its derivatives at its stamps, N poses.

    Fields:
        trajectory: the fitted poses, those that the derivatives belong to.
        body_twist: ``(N, 6)`` angular rate (rad/s) and velocity of the origin (m/s) in the moving
            frame; similarities have the rate of the logarithm of the scale (1/s) besides.
        body_twist_rate: its derivative, in 1/s more.
        body_twist_jerk: its second derivative.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import differentiated
        >>> from motorcade.fusion.motions import MOTIONS
        >>> found = differentiated(MOTIONS["screw"].sampled(50.0, 2.0))
        >>> found.world_velocity_m_s.shape
        (101, 3)
    """

    trajectory: Trajectory
    body_twist: FloatArray
    body_twist_rate: FloatArray
    body_twist_jerk: FloatArray

    @property
    def world_twist(self) -> FloatArray:
        """The twist in the parent's frame ``(N, 6)``: ``pose' = world_twist pose``.

        Its last three are the velocity of that point of the body which is at the parent's origin.
        """
        return self.trajectory.poses.transform_twist(self.body_twist)

    @property
    def world_velocity_m_s(self) -> FloatArray:
        """Velocity of the moving frame's origin in the parent's axes ``(N, 3)``."""
        return self._in_world(self.body_twist[:, 3:6])

    @property
    def world_acceleration_m_s2(self) -> FloatArray:
        """Acceleration of the origin in the parent's axes ``(N, 3)``, without gravity."""
        return self._in_world(self._origin_rates()[0])

    @property
    def world_jerk_m_s3(self) -> FloatArray:
        """Jerk of the origin in the parent's axes ``(N, 3)``."""
        return self._in_world(self._origin_rates()[1])

    def _origin_rates(self) -> tuple[FloatArray, FloatArray]:
        """Acceleration and jerk of the origin in the body's axes: ``(s R v)' = s R (v' + Ω v)``
        with the rate of the logarithm of the scale on the diagonal of Ω.
        """
        twist, rate, jerk = self.body_twist, self.body_twist_rate, self.body_twist_jerk
        velocity = twist[:, 3:6]

        def turned(by: FloatArray, vector: FloatArray) -> FloatArray:
            return np.cross(by[:, :3], vector) + _growth(by) * vector

        acceleration = rate[:, 3:6] + turned(twist, velocity)
        change = jerk[:, 3:6] + turned(rate, velocity) + turned(twist, rate[:, 3:6])
        return acceleration, change + turned(twist, acceleration)

    def _in_world(self, vectors: FloatArray) -> FloatArray:
        poses = self.trajectory.poses
        turned = poses.rotor.apply(vectors)
        return poses.scale[:, None] * turned if isinstance(poses, Similarity) else turned


def differentiated(
    trajectory: Trajectory, window_s: float = 0.3, order: int = 4
) -> PathDerivatives:
    """Derivatives of a trajectory at its stamps.

    Args:
        trajectory: at least order + 1 poses, in windows of which each must turn by less than π.
        window_s: full width of the windows in seconds; at the ends of the path they are shifted to
            stay on it, and derivatives are less accurate there. Wider windows suppress noise,
            narrower ones follow faster motion. Where a window holds too few poses for the order,
            that of the polynomial falls, and derivatives beyond it are 0.
        order: of the polynomials, 3 to 8. The error of the k-th derivative falls with the
            ``order + 1 - k``-th power of the window.

    Raises:
        ValueError: a window that is not positive, an order outside 3 to 8, or too few poses.

    Source: A. Savitzky and M. Golay, Analytical Chemistry 36 (1964), over time and on the tangent.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import differentiated
        >>> from motorcade.ga import Motor, Trajectory
        >>> time_s = np.arange(30) / 30.0
        >>> falling = Motor.from_translation(np.outer(-4.905 * time_s**2, [0.0, 0.0, 1.0]))
        >>> path = Trajectory((1e9 * time_s).astype(np.int64), falling)
        >>> differentiated(path).world_acceleration_m_s2[15].round(2) + 0.0
        array([ 0. ,  0. , -9.81])
    """
    width_ns = checked_span_ns(checked_positive(window_s, "window_s", "seconds"), "window_s")
    if not _LEAST_ORDER <= order <= _LARGEST_ORDER:
        raise ValueError(f"order: expected {_LEAST_ORDER} to {_LARGEST_ORDER}, got {order}")
    checked_length(trajectory, order + 1, f"differentiated of order {order}")
    scaled = isinstance(trajectory.poses, Similarity)
    representation = REPRESENTATIONS["similarity" if scaled else "motor"]
    coordinates = np.asfortranarray(representation.coordinates(trajectory.poses))
    first, last = shifted_windows(trajectory.time_ns, width_ns)

    def weights(offset_s: FloatArray, inside: NDArray[np.bool_]) -> FloatArray:
        u = offset_s * (2e9 / width_ns)
        equal = inside.astype(np.float64)
        units = [factorial(k) * (2e9 / width_ns) ** k for k in range(4)]
        rows = [polynomial_at_centre(u, equal, inside, order, k) for k in range(4)]
        return np.stack([unit * row for unit, row in zip(units, rows, strict=True)])

    derived = np.empty((4, len(trajectory), 7 if scaled else 6))
    fitted = coordinates.copy()
    for start in range(0, len(trajectory), _SEGMENT):
        part = slice(start, min(start + _SEGMENT, len(trajectory)))
        windows = Windows.of(trajectory.time_ns, part, first, last, weights)
        for _ in range(_ROUNDS):
            derived[:, part] = weighted_vectors(coordinates, fitted[part], representation, windows)
            fitted[part] = representation.retract(fitted[part], derived[0, part])
    poses = representation.poses(fitted)
    assert isinstance(poses, Motor | Similarity)
    path = Trajectory(trajectory.time_ns, poses, trajectory.parent, trajectory.child)
    _, slope, curvature, twist_jerk = derived
    return PathDerivatives(
        path, slope, curvature, twist_jerk - 0.5 * twist_bracket(slope, curvature)
    )


def _growth(twist: FloatArray) -> FloatArray:
    """Rate of the logarithm of the scale ``(N, 1)``; 0 of rigid motions."""
    return twist[:, 6:] if twist.shape[1] == 7 else np.zeros((len(twist), 1))
