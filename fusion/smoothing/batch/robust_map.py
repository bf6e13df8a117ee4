"""Robust batch estimation: the most probable path under a motion model, outliers told apart.

Maximised is the posterior of poses ``X_i`` and velocities ``v_i`` at the stamps. Between them the
motion has white acceleration: with ``e = difference(X_{i+1}, X_i) - dt v_i`` and ``f = v_{i+1} -
v_i`` the prior charges ``[e f] Q⁻¹ [e f]ᵀ``, ``Q = q² [[dt³/3, dt²/2], [dt²/2, dt]]``, for each
component and any dt: gaps are long steps. A measured pose ``Z_i`` charges ``ρ(s)``, where s is the
squared length of ``difference(X_i, Z_i)`` in deviations of the noise. On motors the vectors are
twists, and a constant screw costs nothing (T. D. Barfoot, State Estimation for Robotics, 2nd ed.,
2024, ch. 11; velocities are the representation's own, and the right Jacobian of one step is taken
for 1).

Solved by Gauss-Newton with Marquardt's damping, weights following the residuals (P. W. Holland, R.
E. Welsch, Robust regression using iteratively reweighted least-squares, 1977). It starts from the
poses that make up the longest smooth chain (see `inliers`), and the loss narrows in steps from wide
to its own width (graduated non-convexity: A. Blake, A. Zisserman, Visual Reconstruction, 1987);
only then are the poses left out judged by their residuals as all others are.

Runs of wrong poses that are a flat marker's other candidate are mirrored back (see `mirrored`).
Across any other run of wrong poses nothing is known but the motion model, so that the error there
grows with the length of the run. A path that leaps for good, as when a map is corrected, is torn
smooth. Long paths are estimated in parts that overlap (`parts`), so that time is linear in the
poses and memory is some hundred bytes a pose.

What a pose tells fades away along the path. Under white acceleration of density q and noise σ at
intervals dt it does so by ``exp(-t / √2 τ)`` with ``τ = (σ √dt / q)^(1/2)``, the steady state of
the smoother of a constant velocity. A part reaches beyond what is kept of it by as many poses as
leave 1e-9 of that, and by some more for poses that are rejected; so the parts give what the whole
gives but for the tolerance at which it ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.batch.inliers import (
    LAST_STEPS,
    Problem,
    Sizes,
    inlier_poses,
    loss_weights,
    with_rigid,
)
from motorcade.fusion.smoothing.batch.mirrored import mirrored_back
from motorcade.fusion.smoothing.checks import checked_length, checked_size, in_double
from motorcade.fusion.smoothing.representations import (
    Representation,
    representation_named,
    restored,
)
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray

# Times √2 τ after which 1e-9 is left.
_FADED = 21.0
_REJECTED_POSES = 200
_FEWEST_KEPT = 1500


class PathPart(NamedTuple):
    """Rows of the path that are estimated together, and those of them that are kept."""

    rows: slice
    kept: slice


def parts(time_s: FloatArray, sizes: Sequence[Sizes]) -> Iterator[PathPart]:
    """Cut a path at stamps ``(N,)`` for the sizes of its noise and motion; `kept` joins up."""
    overlap = _overlap(time_s, sizes)
    size = max(_FEWEST_KEPT, 2 * overlap)
    count = max(1, len(time_s) // size)
    edges = np.linspace(0, len(time_s), count + 1).astype(np.int64).tolist()
    for first, last in pairwise(edges):
        start = max(0, first - overlap)
        yield PathPart(
            slice(start, min(len(time_s), last + overlap)), slice(first - start, last - start)
        )


def _overlap(time_s: FloatArray, sizes: Sequence[Sizes]) -> int:
    if len(time_s) <= _FEWEST_KEPT:
        return 0
    interval_s = float(np.quantile(np.diff(time_s), 0.05))
    longest = max(one.noise * sqrt(interval_s) / one.acceleration for one in sizes)
    reach = _FADED * sqrt(2.0 * longest) / interval_s
    return min(len(time_s), ceil(reach) + _REJECTED_POSES)


LOSSES = ("cauchy", "huber", "squares")
# Poses that count less are rejected; runs of them may be read otherwise so many times.
_REJECTED, _READINGS = 0.1, 2


@dataclass(frozen=True, eq=False)
class RobustPath:
    """The most probable path, and how much each measured pose had to say in it.

    Fields:
        trajectory: the estimate, with the stamps and frames of the measured one.
        weight: ``(N,)`` 1 where a measured pose counts fully, towards 0 where it is rejected.
        normalised_residual: ``(N,)`` of measured from estimated poses, in deviations of the noise.
        mirrored: ``(N,)`` poses that were read as a flat marker's other candidate, see `mirrored`;
            weight and residual are of the poses as they were measured.
        velocity: ``(N, d)`` in the representation's vectors; on motors the body twist.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing.batch.robust_map import RobustPath, estimate_path
        >>> found = estimate_path(screw().sampled(30.0, 2.0))
        >>> isinstance(found, RobustPath), bool(found.rejected.any())
        (True, False)
    """

    trajectory: Trajectory
    weight: FloatArray
    normalised_residual: FloatArray
    mirrored: NDArray[np.bool_]
    velocity: FloatArray

    @property
    def rejected(self) -> NDArray[np.bool_]:
        """Poses ``(N,)`` that count less than a tenth."""
        return np.asarray(self.weight < _REJECTED, dtype=np.bool_)


def robust_map(
    trajectory: Trajectory,
    representation: Representation,
    *,
    acceleration_m_s2: float = 0.5,
    angular_acceleration_rad_s2: float = 1.0,
    noise_m: float = 0.005,
    noise_rad: float = 0.01,
    scale_acceleration_s2: float = 1.0,
    noise_scale: float = 0.005,
    loss: str = "cauchy",
    width: float = 3.5,
) -> Trajectory:
    """The most probable path; see the module. `estimate_path` also tells which poses it rejected.

    Args:
        trajectory: two poses or more, at any sampling.
        representation: in whose vectors residuals and velocities are.
        acceleration_m_s2: density of the white acceleration an axis in m/s²/√Hz: in T seconds the
            velocity wanders by it times √T. Too small, and true motion is rejected as outliers.
        angular_acceleration_rad_s2: the same of the rotation in rad/s²/√Hz.
        noise_m: standard deviation of a good position an axis.
        noise_rad: the same of a rotation, about an axis.
        scale_acceleration_s2: the same of the scale in 1/s²/√Hz; rigid poses have none.
        noise_scale: the same of the scale.
        loss: "cauchy" ``w² ln(1 + s / w²)`` rejects outliers, "huber" (``s`` up to ``w²``, then
            ``2 w √s - w²``) bounds their pull, "squares" does neither.
        width: w, in deviations of the whole pose. Good poses have s near 6.

    Raises:
        ValueError: a size that is not positive, an unknown loss, a single pose.
    """
    return estimate_path(
        trajectory,
        representation.name,
        acceleration_m_s2=acceleration_m_s2,
        angular_acceleration_rad_s2=angular_acceleration_rad_s2,
        noise_m=noise_m,
        noise_rad=noise_rad,
        scale_acceleration_s2=scale_acceleration_s2,
        noise_scale=noise_scale,
        loss=loss,
        width=width,
    ).trajectory


def estimate_path(
    trajectory: Trajectory,
    representation: str = "motor",
    *,
    acceleration_m_s2: float = 0.5,
    angular_acceleration_rad_s2: float = 1.0,
    noise_m: float = 0.005,
    noise_rad: float = 0.01,
    scale_acceleration_s2: float = 1.0,
    noise_scale: float = 0.005,
    loss: str = "cauchy",
    width: float = 3.5,
) -> RobustPath:
    """The most probable path with the weights of the measured poses; parameters of `robust_map`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian, Outliers
        >>> from motorcade.fusion.smoothing.batch.robust_map import estimate_path
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> wild = Outliers(share=0.05, scale_m=0.3, scale_rad=0.5).apply(noisy, rng)
        >>> found = estimate_path(wild, noise_m=0.01, noise_rad=0.02)
        >>> print(int(found.rejected.sum()), "of", len(wild), "poses rejected")
        4 of 121 poses rejected
    """
    chosen = representation_named(representation, trajectory.poses)
    checked_length(trajectory, 2, "robust_map")
    if loss not in LOSSES:
        raise ValueError(f"loss: expected one of {', '.join(LOSSES)}, got {loss!r}")
    checked_size(width, "width", "deviations")
    parameters = {
        "acceleration_m_s2": acceleration_m_s2,
        "angular_acceleration_rad_s2": angular_acceleration_rad_s2,
        "noise_m": noise_m,
        "noise_rad": noise_rad,
        "scale_acceleration_s2": scale_acceleration_s2,
        "noise_scale": noise_scale,
    }
    for name, value in parameters.items():
        checked_size(value, name, "its unit")
    sizes = (
        Sizes(noise_rad, angular_acceleration_rad_s2),
        Sizes(noise_m, acceleration_m_s2),
        Sizes(noise_scale, scale_acceleration_s2),
    )
    trajectory = in_double(trajectory)
    estimates: list[RobustPath] = []
    for part in parts(trajectory.time_s, sizes):
        estimate = _estimated(trajectory[part.rows], chosen, sizes, loss, width)
        last = estimates[-1].velocity[-1] if estimates else None
        estimates.append(_kept(estimate, part.kept, last, chosen.signed))
    return estimates[0] if len(estimates) == 1 else _joined(estimates, trajectory)


def _kept(estimate: RobustPath, rows: slice, last: FloatArray | None, signed: int) -> RobustPath:
    """Some rows in memory of their own; components of free sign go on from the `last` velocity."""
    velocity = estimate.velocity[rows].copy()
    if signed and last is not None:
        before = estimate.velocity[rows.start - 1]
        if np.sum(before[:signed] * last[:signed]) < 0.0:
            velocity[:, :signed] *= -1.0
    poses = type(estimate.trajectory.poses)(estimate.trajectory.poses[rows].coefficients.copy())
    like = estimate.trajectory
    kept = Trajectory(like.time_ns[rows], poses, like.parent, like.child)
    weight, residual = estimate.weight[rows].copy(), estimate.normalised_residual[rows].copy()
    return RobustPath(kept, weight, residual, estimate.mirrored[rows].copy(), velocity)


def _joined(estimates: Sequence[RobustPath], like: Trajectory) -> RobustPath:
    kind = type(estimates[0].trajectory.poses)
    poses = kind(np.concatenate([one.trajectory.poses.coefficients for one in estimates]))
    return RobustPath(
        Trajectory(like.time_ns, poses, like.parent, like.child),
        np.concatenate([one.weight for one in estimates]),
        np.concatenate([one.normalised_residual for one in estimates]),
        np.concatenate([one.mirrored for one in estimates]),
        np.concatenate([one.velocity for one in estimates]),
    )


def _estimated(
    trajectory: Trajectory,
    representation: Representation,
    sizes: tuple[Sizes, Sizes, Sizes],
    loss: str,
    width: float,
) -> RobustPath:
    """The path, where need be again with runs of rejected poses mirrored back."""
    time_s, poses = trajectory.time_s, trajectory.poses
    kept = inlier_poses(time_s, poses.rigid, *sizes[:2])
    mirrored = np.zeros_like(kept)
    for reading in range(_READINGS):
        if loss != "squares":
            rigid, read = mirrored_back(time_s, poses.rigid, kept, sizes, width)
            if reading and not np.any(read):
                break
            poses, mirrored = with_rigid(poses, rigid), mirrored | read
        if reading or np.any(mirrored):
            kept = inlier_poses(time_s, poses.rigid, *sizes[:2])
        problem = Problem(representation, time_s, poses, kept, sizes)
        solution = problem.descended(
            problem.narrowed(loss, width), loss, width, np.ones_like(kept), LAST_STEPS
        )
        if loss == "squares":
            break
        kept = loss_weights(solution.squares, loss, width) >= _REJECTED
    squares = solution.squares
    if np.any(mirrored):
        problem.measured = representation.coordinates(trajectory.poses)
        as_measured = problem.charged(solution.state, loss, width, np.ones_like(kept))
        squares = np.where(mirrored, as_measured.squares, squares)
    return RobustPath(
        restored(representation, solution.state.coordinates, trajectory),
        loss_weights(squares, loss, width),
        np.sqrt(squares),
        mirrored,
        solution.state.velocity,
    )
