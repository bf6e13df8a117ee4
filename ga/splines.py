"""Smooth motion through poses: cumulative B-splines on versors, with exact derivatives.

With uniform knots and controls ``C_j`` the pose is ``C_s exp(λ_1 d_1) … exp(λ_5 d_5)``, where
``d_j`` is the screw from one control to the next and ``λ_j(u)`` sums the basis functions from
``j`` on. The order is 6 (quintic): acceleration is then twice continuously differentiable, so an
inertial sensor simulated at any rate sees no kinks at the knots, and smooth motion is reproduced to
the sixth power of the knot spacing; the cubic spline's acceleration is a polyline.

Source: Sommer, Usenko, Schubert, Demmel, Cremers, "Efficient derivative computation for cumulative
B-splines on Lie groups" (CVPR 2020); here position and rotation move together, on motors.

Least-squares fit of a cumulative B-spline's control motors to poses.

Minimised is the sum over the poses of squared rotation (rad) and displacement (m) left between
pose and spline, plus a very small multiple of the squared fourth differences of the screws from
control to control. That term decides what the poses leave open, such as the outermost controls.
Gauss-Newton with exact derivatives (Sommer et al., CVPR 2020, carried over to rigid motions),
damped after Levenberg and Marquardt where a step would raise the sum, as it may far from poses that
are plainly wrong; a segment touches six controls, so the normal equations are a band and the time
is linear in the poses.

Twists are (rotation, translation); a control moves by ``C exp(step)``, a pose by ``S exp(J step)``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import ceil, comb, factorial
from typing import Generic, NamedTuple, TypeVar

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

        Raises ValueError: stamps that are no integers, or outside the span.
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

        Raises ValueError: NaN or infinity, or times outside the span.
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
        """Least-squares approximation of a trajectory; see `motorcade.ga.splines`.

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

    Raises ValueError: more than 2,000 and 20 a pose.
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


_MAX_STEPS = 100
# Damping of steps that would raise the sum of squares, as a share of the diagonal.
_LEAST_DAMPING = 1e-3
_ROUNDING = 1e-12
# Beside plainly wrong poses steps may never end: then the sum is as small as it gets after so many
# in a row that change it by less than this share, or where none is left but with this damping.
_LEVEL_STEPS, _LEVEL = 4, 1e-9
_MOST_DAMPING = 1.0
# Largest step of any control that shapes a pose by a tenth or more, rad and m.
_CONVERGED = 1e-9
_SMOOTHNESS = 1e-6
_FIT_CHUNK = 512
# A control's say fades by 0.43, the pole of quintic splines, from knot to knot; where the roughness
# alone tells controls it does so over some knots. Of long splines so many controls are fitted at a
# time, and so many more to either side, past which nothing that float64 shows is left.
_KEPT, _OVERLAP = 1000, 100
_FOURTH_DIFFERENCE = (1.0, -4.0, 6.0, -4.0, 1.0)


def fit_controls(
    controls: Motor, segment: IntArray, weights: FloatArray, poses: Motor
) -> Motor | None:
    """Move control motors until the spline through them is closest to the poses.

    Args:
        controls: first guess, Motor ``(n,)``.
        segment: ``(N,)`` first of the six controls that shape each pose, not decreasing.
        weights: ``(5, N)`` cumulative basis at each pose.
        poses: Motor ``(N,)``.

    Returns:
        The fitted controls, or None where the steps do not settle.

    Raises:
        ModuleNotFoundError: scipy is missing.
    """
    strength = _SMOOTHNESS * len(segment) / (len(controls) - 5)
    coefficients = np.array(controls.coefficients)
    for part, kept in _parts(len(controls)):
        rows = slice(*np.searchsorted(segment, [part.start, part.stop - 5]).tolist())
        fitted = _fitted(
            controls[part], segment[rows] - part.start, weights[:, rows], poses[rows], strength
        )
        if fitted is None:
            return None
        coefficients[kept] = fitted.coefficients[kept.start - part.start : kept.stop - part.start]
    return Motor(coefficients)


def _parts(count: int) -> Iterator[tuple[slice, slice]]:
    """Controls that are fitted together, and those of them that are kept, which join up."""
    edges = np.linspace(0, count, max(1, count // _KEPT) + 1).astype(np.int64).tolist()
    for first, last in pairwise(edges):
        yield slice(max(0, first - _OVERLAP), min(count, last + _OVERLAP)), slice(first, last)


def _fitted(
    controls: Motor, segment: IntArray, weights: FloatArray, poses: Motor, strength: float
) -> Motor | None:
    """`fit_controls` of one part, whose roughness counts by `strength`."""
    damping, equations = 0.0, _normal_equations(controls, segment, weights, poses, strength)
    level = 0
    for _ in range(_MAX_STEPS):
        step = _solve_band(equations, damping)
        moved = controls.retract(step)
        # The six weights of a pose sum to one, most of it on the middle two controls.
        if float(np.max(np.abs(step[2:-2]))) < _CONVERGED * (1.0 + damping):
            return moved
        reached = _normal_equations(moved, segment, weights, poses, strength)
        flat = abs(reached.cost - equations.cost) <= _LEVEL * equations.cost
        level = level + 1 if flat else 0
        if reached.cost <= equations.cost * (1.0 + _ROUNDING):
            controls, equations = moved, reached
            damping = damping / 8.0 if damping > _LEAST_DAMPING else 0.0
        else:
            damping = max(_LEAST_DAMPING, 4.0 * damping)
        if level == _LEVEL_STEPS or damping > _MOST_DAMPING:
            return controls
    return None


class _Chain(NamedTuple):
    """Control motors, screws between them, and how each screw changes with a control's step."""

    controls: Motor
    screws: FloatArray
    by_next: FloatArray
    by_last: FloatArray

    @classmethod
    def of(cls, controls: Motor) -> _Chain:
        screws = controls[:-1].local(controls[1:])
        by_next, by_last = Motor.right_jacobian_inverse(screws), Motor.left_jacobian_inverse(screws)
        return cls(controls, screws, by_next, -by_last)


def _pose_jacobians(
    chain: _Chain, segment: IntArray, weights: FloatArray
) -> tuple[Motor, FloatArray]:
    """Poses ``(N,)`` and their derivatives ``(N, 6, 36)`` by the steps of six controls each."""
    jacobian = np.zeros((len(segment), 6, 6, 6))
    pose = Motor.identity((len(segment),))
    chained = np.broadcast_to(np.eye(6), (len(segment), 6, 6))
    parts = weights[..., None] * chain.screws[segment + np.arange(5)[:, None]]
    weighed = weights[..., None, None] * Motor.right_jacobian(parts)
    factors = Motor.from_twist(parts)
    back = factors.inverse().adjoint()
    for j in range(4, -1, -1):
        effect = chained @ weighed[j]
        jacobian[:, :, j + 1] += effect @ chain.by_next[segment + j]
        jacobian[:, :, j] += effect @ chain.by_last[segment + j]
        pose = factors[j] @ pose
        chained = chained @ back[j]
    jacobian[:, :, 0] += chained
    return chain.controls[segment] @ pose, jacobian.reshape(-1, 6, 36)


def _roughness(chain: _Chain, first: int, last: int) -> tuple[FloatArray, FloatArray]:
    """Fourth differences of the screws ``(K, 6)`` and their derivatives ``(K, 6, 36)`` of some
    segments.
    """
    rough = np.zeros((last - first, 6))
    jacobian = np.zeros((last - first, 6, 6, 6))
    for j, factor in enumerate(_FOURTH_DIFFERENCE):
        own = slice(first + j, last + j)
        rough += factor * chain.screws[own]
        jacobian[:, :, j + 1] += factor * chain.by_next[own]
        jacobian[:, :, j] += factor * chain.by_last[own]
    return rough, jacobian.reshape(-1, 6, 36)


def _residuals(pose: Motor, target: Motor) -> FloatArray:
    """Rotation vector and displacement ``(N, 6)`` from pose to target, in the pose's own frame."""
    turn = (pose.rotor.inverse() @ target.rotor).as_rotation_vector()
    shift = pose.rotor.inverse().apply(target.translation_m - pose.translation_m)
    return np.concatenate([turn, shift], axis=-1)


class _Equations(NamedTuple):
    """Lower band ``(6 n, 36)``, a row a column; right-hand side ``(6 n,)``; sum of squares."""

    band: FloatArray
    right: FloatArray
    cost: float

    def add(self, first: int, blocks: FloatArray, gradient: FloatArray) -> None:
        """Add the blocks ``(K, 36, 36)`` and gradients ``(K, 36)`` of segments from `first` on."""
        for column in range(36):
            own = slice(6 * first + column, 6 * (first + len(blocks)) + column, 6)
            self.right[own] += gradient[:, column]
            self.band[own, : 36 - column] += blocks[:, column, column:]


def _normal_equations(
    controls: Motor, segment: IntArray, weights: FloatArray, poses: Motor, strength: float
) -> _Equations:
    chain, segments = _Chain.of(controls), len(controls) - 5
    equations = _Equations(np.zeros((6 * len(controls), 36)), np.zeros(6 * len(controls)), 0.0)
    cost = 0.0
    for start in range(0, len(segment), _FIT_CHUNK):
        part = slice(start, start + _FIT_CHUNK)
        pose, jacobian = _pose_jacobians(chain, segment[part], weights[:, part])
        residual = _residuals(pose, poses[part])
        cost += float(np.sum(residual**2))
        equations.add(
            int(segment[start]), *_summed(jacobian, residual, segment[part] - segment[start])
        )
    for start in range(0, segments, _FIT_CHUNK):
        rough, jacobian = _roughness(chain, start, min(segments, start + _FIT_CHUNK))
        turned = strength * np.swapaxes(jacobian, -1, -2)
        equations.add(start, turned @ jacobian, -(turned @ rough[..., None])[..., 0])
        cost += strength * float(np.sum(rough**2))
    return equations._replace(cost=cost)


def _summed(
    jacobian: FloatArray, residual: FloatArray, segment: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Blocks ``(K, 36, 36)`` and gradients ``(K, 36)`` of segments 0 to K - 1.

    The rows of a segment's poses are one tall matrix; segments with equally many are done at once.
    """
    blocks, gradient = np.zeros((segment[-1] + 1, 36, 36)), np.zeros((segment[-1] + 1, 36))
    firsts = np.flatnonzero(np.diff(segment, prepend=-1))
    counts = np.diff(firsts, append=len(segment))
    for count in np.unique(counts).tolist():
        alike = firsts[counts == count]
        rows = (alike[:, None] + np.arange(count)).ravel()
        tall = jacobian[rows].reshape(-1, 6 * count, 36)
        turned = np.swapaxes(tall, -1, -2)
        blocks[segment[alike]] = turned @ tall
        gradient[segment[alike]] = (turned @ residual[rows].reshape(-1, 6 * count, 1))[..., 0]
    return blocks, gradient


def _solve_band(equations: _Equations, damping: float) -> FloatArray:
    """Steps ``(n, 6)`` of all controls."""
    try:
        from scipy.linalg import solveh_banded
    except ModuleNotFoundError as missing:
        raise ModuleNotFoundError(
            'fitting a spline needs scipy: pip install "motorcade[pipeline]"'
        ) from missing
    band = equations.band.copy()
    # The smoothness term leaves out steps that are polynomials over the whole spline.
    diagonal = band[:, 0]
    diagonal += 1e-14 * np.max(diagonal) + damping * diagonal
    solution = solveh_banded(band.T, equations.right, overwrite_ab=True, lower=True)
    return np.asarray(solution).reshape(-1, 6)
