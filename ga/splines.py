"""Smooth motion through poses: cumulative B-splines on versors, with exact derivatives.

With uniform knots and controls ``C_j`` the pose is ``C_s exp(λ_1 d_1) … exp(λ_5 d_5)``, where
``d_j`` is the screw from one control to the next and ``λ_j(u)`` sums the basis functions from
``j`` on. The order is 6 (quintic): acceleration is then twice continuously differentiable, so an
inertial sensor simulated at any rate sees no kinks at the knots, and smooth motion is reproduced to
the sixth power of the knot spacing; the cubic spline's acceleration is a polyline.

Source: Sommer, Usenko, Schubert, Demmel, Cremers, "Efficient derivative computation for cumulative
B-splines on Lie groups" (CVPR 2020); here position and rotation move together, on motors.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, comb, factorial
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.ga.motion import (
    SplineSample,
    TwistSample,
    check_within,
    sampled_motion,
    twist_bracket,
)
from motorcade.ga.spline_fit import fit_controls
from motorcade.ga.stamps import GAP_STEPS
from motorcade.ga.trajectory import Trajectory
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.similarity import Similarity

V = TypeVar("V", Motor, Similarity)

ORDER = 6
# A gap that is longer than this too is bridged by the screw: nothing tells how to curve there.
_GAP_KNOTS = 4.0
# More knots than these are none that poses could tell.
_MOST_KNOTS, _MOST_KNOTS_A_POSE = 2_000, 20
# Steps whose median tells the rate of a motion.
_RATE_STEPS = 15
_CHUNK = 4096


def _basis_polynomials() -> FloatArray:
    """Coefficients ``(order, order)``: basis function by power of ``u``, uniform knots."""
    top = ORDER - 1
    return np.array([
        [
            comb(top, power) / factorial(top) * sum(
                (-1) ** (row - first) * comb(ORDER, row - first) * (top - row) ** (top - power)
                for row in range(first, ORDER)
            )
            for power in range(ORDER)
        ]
        for first in range(ORDER)
    ])  # fmt: skip


_CUMULATIVE = frozen(np.cumsum(_basis_polynomials()[::-1], axis=0)[::-1])


@dataclass(frozen=True, eq=False)
class _CumulativeBSpline(Generic[V]):
    """What splines through motors and through similarities share."""

    start_ns: int
    knot_spacing_s: float
    controls: V
    parent: str = "world"
    child: str = "camera"

    def __post_init__(self) -> None:
        _check_spacing(self.knot_spacing_s)
        if len(self.controls.shape) != 1 or len(self.controls) < ORDER:
            raise ValueError(
                f"{type(self).__name__}.controls: expected shape (n,) with n >= {ORDER}, "
                f"got {self.controls.shape}"
            )

    @property
    def duration_s(self) -> float:
        """Seconds from the first knot to the last."""
        return (len(self.controls) - ORDER + 1) * self.knot_spacing_s

    def at(self, time_ns: ArrayLike) -> V:
        """Poses at stamps ``(*)`` in nanoseconds.

        Raises:
            ValueError: stamps that are no integers, or outside the span.
        """
        stamps = np.asarray(time_ns)
        if stamps.dtype.kind != "i":
            raise ValueError(
                f"{type(self).__name__}.at(time_ns): expected integer nanoseconds, "
                f"got dtype {stamps.dtype}"
            )
        segment, fraction = self._locate((stamps - self.start_ns) * 1e-9)
        screws = self._screws
        pose = self.controls[segment]
        for j, weight in enumerate(cumulative_weights(fraction, 0)[1:]):
            pose = pose @ self.controls.from_twist(weight[..., None] * screws[segment + j])
        return pose

    def twists(self, time_s: ArrayLike) -> TwistSample[V]:
        """Poses, body twists and their derivatives at times ``(*)`` in seconds from the start.

        Raises:
            ValueError: NaN or infinity, or times outside the span.
        """
        checked = checked_floats(time_s, f"{type(self).__name__}.twists(time_s)", ())
        segment, fraction = self._locate(checked)
        h = self.knot_spacing_s
        weights = zip(
            cumulative_weights(fraction, 0)[1:], cumulative_weights(fraction, 1)[1:] / h,
            cumulative_weights(fraction, 2)[1:] / h**2, strict=True,
        )  # fmt: skip
        screws = self._screws
        pose = self.controls[segment]
        twist: FloatArray = np.zeros_like(screws[segment])
        twist_rate = np.zeros_like(twist)
        for j, (value, slope, bend) in enumerate(weights):
            screw = screws[segment + j]
            factor = self.controls.from_twist(value[..., None] * screw)
            back = factor.inverse()
            push = slope[..., None] * screw
            pose = pose @ factor
            twist, twist_rate = back.transform_twist(twist), back.transform_twist(twist_rate)
            twist_rate += twist_bracket(twist, push) + bend[..., None] * screw
            twist += push
        return TwistSample(pose, twist, twist_rate)

    @cached_property
    def _screws(self) -> FloatArray:
        """Twists ``(n - 1, 6)`` or ``(n - 1, 7)`` from each control to the next."""
        return self.controls[:-1].local(self.controls[1:])

    def _locate(self, time_s: FloatArray) -> tuple[IntArray, FloatArray]:
        """Segment and place in it, in [0, 1], of times after the first knot."""
        check_within(type(self).__name__, time_s, self.start_ns, self.duration_s)
        return located(time_s, self.knot_spacing_s, len(self.controls) - ORDER + 1)


@dataclass(frozen=True, eq=False)
class SimilaritySpline(_CumulativeBSpline[Similarity]):
    """Quintic cumulative B-spline through similarities; `CumulativeBSpline` with a scale besides.

    Args:
        start_ns: stamp of the first knot.
        knot_spacing_s: seconds from knot to knot, positive.
        controls: Similarity ``(n,)``, n at least 6; n - 5 segments, each shaped by six controls.
        parent: name of the frame that poses map to.
        child: name of the frame that moves.

    Raises:
        ValueError: a spacing that is not positive, or fewer than six controls.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Similarity, SimilaritySpline
        >>> growth = np.zeros((7, 7))
        >>> growth[:, 6] = np.arange(7) * np.log(2.0)
        >>> spline = SimilaritySpline(0, 1.0, Similarity.from_twist(growth))
        >>> np.round(spline.at([0, 1_000_000_000]).scale, 6)
        array([4., 8.])
    """


@dataclass(frozen=True, eq=False)
class CumulativeBSpline(_CumulativeBSpline[Motor]):
    """Quintic cumulative B-spline over uniform knots.

    Args:
        start_ns: stamp of the first knot.
        knot_spacing_s: seconds from knot to knot, positive.
        controls: Motor ``(n,)``, n at least 6; n - 5 segments, each shaped by six controls.
        parent: name of the frame that poses map to.
        child: name of the frame that moves.

    Raises:
        ValueError: a spacing that is not positive, or fewer than six control motors.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import CumulativeBSpline, Motor
        >>> controls = Motor.from_translation([[k, 0.0, 0.0] for k in range(8)])
        >>> spline = CumulativeBSpline(0, 0.5, controls)
        >>> sample = spline.evaluate([0.0, spline.duration_s])
        >>> np.round(sample.world_velocity_m_s, 6)
        array([[2., 0., 0.],
               [2., 0., 0.]])
    """

    @classmethod
    def fit(cls, trajectory: Trajectory, knot_spacing_s: float) -> CumulativeBSpline:
        """Least-squares approximation of a trajectory; see `motorcade.ga.spline_fit`.

        The spacing is shortened a little where it does not divide the span. Turns must stay below
        π from knot to knot. Over an interval longer than four knots and three median intervals
        the spline keeps to the screw between its ends. Where knots are as dense as the poses, the
        fit follows their noise, and its acceleration is that of the noise.

        Args:
            trajectory: two poses or more; noise is averaged where several lie between knots.
            knot_spacing_s: seconds; handheld motion wants 0.05 to 0.1.

        Raises:
            ValueError: a spacing that is not positive or makes more than 2,000 knots and 20 more a
                pose, a single pose, or motion too fast for it.
            ModuleNotFoundError: scipy is missing.
        """
        _check_spacing(knot_spacing_s)
        if len(trajectory) < 2:
            raise ValueError("CumulativeBSpline.fit(trajectory): expected two poses or more, got 1")
        segments, spacing = segments_of(trajectory, knot_spacing_s)
        bridged = bridged_gaps(trajectory, spacing)
        turn_rad = _fastest_rad_s(bridged) * spacing
        if turn_rad > np.pi:
            raise ValueError(
                "knot_spacing_s: expected knots short enough for the motion, which turns by less "
                f"than half a turn from one to the next, got {knot_spacing_s} s and {turn_rad:.1f} "
                "rad"
            )
        segment, fraction = located(bridged.time_s, spacing, segments)
        fitted = fit_controls(
            _first_guess(trajectory, segments), segment,
            cumulative_weights(fraction, 0)[1:], bridged.motors,
        )  # fmt: skip
        if fitted is None:
            raise ValueError(
                f"knot_spacing_s: expected knots short enough for the motion, got {knot_spacing_s}"
                " s, with which the fit does not settle"
            )
        start = int(trajectory.time_ns[0])
        return cls(start, spacing, fitted, trajectory.parent, trajectory.child)

    def evaluate(self, time_s: ArrayLike) -> SplineSample:
        """Poses and derivatives at times ``(*)`` in seconds after the first knot.

        Raises:
            ValueError: NaN or infinity, or times outside the span.
        """
        return sampled_motion(self.twists(time_s))


def _fastest_rad_s(trajectory: Trajectory) -> float:
    """Largest angular rate, by medians of neighbouring steps: single wrong poses do not count."""
    rotors = trajectory.motors.rotor
    turns = (rotors[:-1].inverse() @ rotors[1:]).as_rotation_vector()
    rates = turns / np.diff(trajectory.time_s)[:, None]
    windows = np.lib.stride_tricks.sliding_window_view(rates, min(_RATE_STEPS, len(rates)), axis=0)
    # Some at a time, as a median copies what it is taken of.
    return max(
        float(np.max(np.linalg.norm(np.median(windows[start : start + _CHUNK], axis=-1), axis=-1)))
        for start in range(0, len(windows), _CHUNK)
    )


def _check_spacing(knot_spacing_s: float) -> None:
    if not (np.isfinite(knot_spacing_s) and knot_spacing_s > 0.0):
        raise ValueError(f"knot_spacing_s: expected a positive number, got {knot_spacing_s}")


def segments_of(trajectory: Trajectory, knot_spacing_s: float) -> tuple[int, float]:
    """How many segments span a trajectory, and their spacing, which is at most the given one.

    Raises:
        ValueError: more than 2,000 and 20 a pose.
    """
    wanted = trajectory.duration_s / knot_spacing_s - 1e-9
    most = _MOST_KNOTS + _MOST_KNOTS_A_POSE * len(trajectory)
    if not wanted <= most:
        raise ValueError(
            f"knot_spacing_s: expected at most {most} knots for {len(trajectory)} poses "
            f"({_MOST_KNOTS}, {_MOST_KNOTS_A_POSE} a pose), got {wanted:.6g} over "
            f"{trajectory.duration_s:.6g} s; set them farther apart, or cut the path at its gaps"
        )
    segments = max(1, ceil(wanted))
    return segments, trajectory.duration_s / segments


def bridged_gaps(trajectory: Trajectory, spacing_s: float) -> Trajectory:
    """The trajectory with poses along the screw, one a knot, across its gaps."""
    intervals_s = np.diff(trajectory.time_ns) * 1e-9
    longest_s = max(_GAP_KNOTS * spacing_s, GAP_STEPS * float(np.median(intervals_s)))
    added = [
        np.arange(start, end, spacing_s * 1e9)[1:].astype(np.int64)
        for start, end in zip(trajectory.time_ns[:-1][intervals_s > longest_s],
                              trajectory.time_ns[1:][intervals_s > longest_s], strict=True)
    ]  # fmt: skip
    if not added:
        return trajectory
    return trajectory.resampled(np.union1d(trajectory.time_ns, np.concatenate(added)))


def _first_guess(trajectory: Trajectory, segments: int) -> Motor:
    """The trajectory's own poses where each control weighs most, held still beyond its ends."""
    span = int(trajectory.time_ns[-1] - trajectory.time_ns[0])
    place = np.clip((np.arange(segments + ORDER - 1) - (ORDER - 2) / 2) / segments, 0.0, 1.0)
    return trajectory.motors_at(trajectory.time_ns[0] + (place * span).astype(np.int64))


def located(time_s: FloatArray, spacing: float, segments: int) -> tuple[IntArray, FloatArray]:
    """Segment and place in it, in [0, 1], of times ``(*)`` in seconds after the first knot."""
    place = np.clip(time_s / spacing, 0.0, segments)
    segment = np.minimum(place.astype(np.int64), segments - 1)
    return segment, place - segment


def cumulative_weights(fraction: FloatArray, derivative: int) -> FloatArray:
    """Cumulative basis ``(6, *)`` or its derivatives with respect to ``u``."""
    powers = np.zeros((ORDER, *fraction.shape))
    for power in range(derivative, ORDER):
        falling = factorial(power) // factorial(power - derivative)
        powers[power] = falling * fraction ** (power - derivative)
    return np.tensordot(_CUMULATIVE, powers, axes=1)
