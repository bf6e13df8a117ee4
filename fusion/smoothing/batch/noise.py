"""Measurement and process noise of a path; `method="auto"` takes its first guess alone.

A first guess of the noise is what third differences leave, by their medians. Poses that belong to
no smooth chain are then set aside as outliers (a second time with what the first told), and of what
is left the noise and the density of the process are those under which a Kalman filter's innovations
are most likely (maximum likelihood: R. H. Shumway, D. S. Stoffer, J. Time Series Analysis 3, 1982),
for a velocity changed by white acceleration and for an acceleration changed by white jerk; the
likelier of the two models is taken. Rotation, translation and scale are searched for in turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.batch.inliers import Sizes, inlier_poses
from motorcade.fusion.smoothing.causal import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    KalmanFilter,
)
from motorcade.fusion.smoothing.checks import in_double
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

FEWEST_POSES = 16
# The likelihood is taken over so many poses at most, in a few stretches of the path.
_STRETCHES, _STRETCH = 4, 1000
_ROUNDS = 2
# Sizes are searched for from this to that, in rad, m and seconds; the finest are lost in rounding.
_FINEST, _FINEST_LOG, _LARGEST_LOG = 1e-8, log(1e-8), log(1e6)
# What the process adds from one pose to the next at least, of the noise, for rounding's sake.
_STIFFEST = 1e-6
_WIDEST_STEP, _FINEST_STEP = 1.5, 0.05
_COMPASS = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0], [-1.0, -1.0]])
# Of a normal vector of three components.
_MEDIAN_OF_NORM, _QUARTILE_OF_NORM = 1.5382, 2.0269


@dataclass(frozen=True)
class NoiseModel:
    """Noise of good poses and density of the process noise, an axis.

    Fields:
        order: 1 where the velocity is changed by white acceleration, 2 where the acceleration is
            changed by white jerk: whichever is likelier.
        rotation, translation, scale: noise (rad, m, log scale) and density of the process (those
            over s^(order + 1) √Hz).
        outliers: share of the poses that belong to no smooth chain.
    """

    order: int
    rotation: Sizes
    translation: Sizes
    scale: Sizes
    outliers: float


def estimate_noise(
    trajectory: Trajectory, representation: str = "motor", order: int | None = None
) -> NoiseModel:
    """Estimate measurement and process noise of a trajectory; see the module.

    Args:
        trajectory: at least 16 poses.
        representation: whose vectors the filters run in.
        order: of the motion model, 1 or 2; by default the likelier.

    Raises:
        ValueError: fewer poses.
    """
    if len(trajectory) < FEWEST_POSES:
        raise ValueError(
            f"trajectory: expected at least {FEWEST_POSES} poses to tell noise from motion, got "
            f"{len(trajectory)}"
        )
    trajectory = in_double(trajectory)
    wide = kept = _chain(trajectory, *first_sizes(trajectory))
    if not np.all(wide):
        _, sizes, _ = _likeliest(_stretches(trajectory[wide]), 1, representation)
        kept = _chain(trajectory, sizes[0], sizes[1])
    parts = _stretches(trajectory[kept])
    found = [_likeliest(parts, one, representation) for one in ((order,) if order else (1, 2))]
    chosen, sizes, _ = max(found, key=lambda one: one[2])
    rotation, translation, scale = sizes
    outliers = float(1.0 - np.mean(kept | wide))
    return NoiseModel(chosen, rotation, translation, scale, outliers)


def _chain(trajectory: Trajectory, rotation: Sizes, translation: Sizes) -> NDArray[np.bool_]:
    return inlier_poses(trajectory.time_s, trajectory.poses.rigid, rotation, translation)


def first_sizes(trajectory: Trajectory) -> tuple[Sizes, Sizes]:
    """Rotation and translation, as differences of measured poses tell: on the wide side."""
    time_s, poses = trajectory.time_s, trajectory.poses.rigid
    interval_s = np.diff(time_s)[:, None]
    changes = np.diff((poses[:-1].inverse() @ poses[1:]).as_twist() / interval_s, axis=0)
    blocks = changes[:, :3], changes[:, 3:]
    rotation, translation = (
        Sizes(max(noise, _FINEST), max(_usual_density(part, interval_s), _FINEST))
        for noise, part in zip(_first_noise(poses, time_s), blocks, strict=True)
    )
    return rotation, translation


def _usual_density(changes: FloatArray, interval_s: FloatArray) -> float:
    """Density of white acceleration that would explain the upper quartile of changes of speed."""
    usual = float(np.quantile(np.linalg.norm(changes, axis=1), 0.75))
    return usual / (_QUARTILE_OF_NORM * float(np.sqrt(np.median(interval_s))))


def _first_noise(poses: Motor, time_s: FloatArray) -> tuple[float, float]:
    """Noise (rad, m) that would explain the median third difference, as if stamps were even.

    The square of a third difference of white noise is 20 times that of the noise.
    """
    interval_s = np.diff(time_s)[:, None]
    rates = (poses[:-1].inverse() @ poses[1:]).as_twist() / interval_s
    third = np.diff(rates, n=2, axis=0) * np.median(interval_s)
    rotation, translation = (
        float(np.median(np.linalg.norm(part, axis=1))) / (_MEDIAN_OF_NORM * np.sqrt(20.0))
        for part in (third[:, :3], third[:, 3:])
    )
    return rotation, translation


def _stretches(trajectory: Trajectory) -> list[Trajectory]:
    if len(trajectory) <= _STRETCHES * _STRETCH:
        return [trajectory]
    starts = np.linspace(0, len(trajectory) - _STRETCH, _STRETCHES).astype(np.int64)
    return [trajectory[start : start + _STRETCH] for start in starts]


def _likeliest(
    parts: list[Trajectory], order: int, representation: str
) -> tuple[int, list[Sizes], float]:
    """The sizes of all blocks under which the innovations are likeliest, and how likely."""
    time_s = parts[0].time_s
    interval_s = float(np.median(np.diff(time_s)))
    first = [max(noise, _FINEST) for noise in (*_first_noise(parts[0].poses.rigid, time_s), 0.005)]
    # As much process as noise from one pose to the next.
    sizes = [Sizes(noise, noise / interval_s ** (order + 0.5)) for noise in first]
    blocks = 3 if isinstance(parts[0].poses, Similarity) else 2
    best = -np.inf
    for _ in range(_ROUNDS):
        for block in range(blocks):
            sizes, best = _searched(parts, order, representation, sizes, block)
    return order, sizes, best


def _searched(
    parts: list[Trajectory], order: int, representation: str, sizes: list[Sizes], block: int
) -> tuple[list[Sizes], float]:
    """Sizes with one block at its likeliest, by a compass search over both logarithms."""
    stiffest = _STIFFEST / float(np.median(np.diff(parts[0].time_s))) ** (order + 0.5)

    def with_block(logarithms: FloatArray) -> list[Sizes]:
        made = list(sizes)
        noise, density = (exp(one) for one in np.clip(logarithms, _FINEST_LOG, _LARGEST_LOG))
        made[block] = Sizes(noise, max(density, stiffest * noise))
        return made

    def likelihood(logarithms: FloatArray) -> float:
        model = _filter(order, with_block(logarithms), representation)
        try:
            found = sum(model.log_likelihood(part) for part in parts)
        except ValueError:  # the filter ran away: nothing is less likely
            return -np.inf
        return found if np.isfinite(found) else -np.inf

    place = np.array([log(size) for size in sizes[block]])
    best, step = likelihood(place), _WIDEST_STEP
    while step > _FINEST_STEP:
        tried = [place + step * way for way in _COMPASS]
        values = [likelihood(one) for one in tried]
        if max(values) > best:
            best = max(values)
            place = tried[values.index(best)]
        else:
            step *= 0.5
    return with_block(place), best


def _filter(order: int, sizes: list[Sizes], representation: str) -> KalmanFilter:
    kind = ConstantVelocityFilter if order == 1 else ConstantAccelerationFilter
    rotation, translation, scale = sizes
    return kind(
        translation.acceleration,
        rotation.acceleration,
        translation.noise,
        rotation.noise,
        scale.acceleration,
        scale.noise,
        representation,
    )
