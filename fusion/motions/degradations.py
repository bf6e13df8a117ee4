"""Degradations: what measuring does to true poses and stamps, in physical units and seeded.

Rotations are perturbed in the moving frame, positions in the world; scales of similarities stay
unless a size for them is given.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.stamps import check_count

__all__ = [
    "Degradation",
    "DroppedFrames",
    "Gaussian",
    "InTurn",
    "Latency",
    "Outliers",
    "PlanarFlips",
    "Quantised",
    "StampJitter",
    "wrong_planar_pose",
]


class Degradation(ABC):
    """A way in which measuring degrades a trajectory; sizes are in metres, radians and seconds.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Degradation, Gaussian
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> noise = Gaussian(sigma_m=0.01, sigma_rad=0.02)
        >>> isinstance(noise, Degradation), noise.apply(true, rng)
        (True, Trajectory(world_T_camera, 301 poses, 10.000 s))
    """

    @abstractmethod
    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """The degraded trajectory; the given one stays as it is."""


@dataclass(frozen=True)
class InTurn(Degradation):
    """Several degradations, the first one applied first.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Gaussian, InTurn
        >>> from motorcade.fusion.motions.degradations import Blackouts
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> both = InTurn((Gaussian(0.01, 0.02), Blackouts(length_s=1.0, every_s=4.0)))
        >>> len(true), len(both.apply(true, rng))
        (301, 241)
    """

    steps: tuple[Degradation, ...]

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Apply each to what the one before it left."""
        for step in self.steps:
            trajectory = step.apply(trajectory, rng)
        return trajectory


def runs(
    rng: np.random.Generator, count: int, share: float, mean_length: float
) -> NDArray[np.bool_]:
    """Which of `count` poses are struck, a two-state Markov chain in its steady state.

    A share of all poses is struck, in runs of geometric length with mean `mean_length`; a mean of
    ``1 / (1 - share)`` is that of independent poses.
    """
    leave, enter = 1.0 / mean_length, share / ((1.0 - share) * mean_length)
    first, *chances = rng.random(count).tolist()
    struck = [first < share]
    for chance in chances:
        struck.append(chance >= leave if struck[-1] else chance < enter)
    return np.array(struck, dtype=np.bool_)


def check_number(owner: object, name: str, low: float = 0.0, high: float = np.inf) -> None:
    """Refuse a field that is not a finite number from `low` to `high`."""
    value = getattr(owner, name)
    if not (np.isfinite(value) and low <= value <= high):
        limits = f"{low:g} or more" if high == np.inf else f"{low:g} to {high:g}"
        raise ValueError(f"{type(owner).__name__}.{name}: expected {limits}, got {value}")


def check_runs(owner: object, share: float, mean_run: float) -> None:
    """Refuse a share and a mean run length, in poses, that no chain of runs can have."""
    name = type(owner).__name__
    if not 0.0 <= share < 1.0:
        raise ValueError(f"{name}.share: expected 0 to below 1, got {share}")
    if not max(1.0, share / (1.0 - share)) <= mean_run < np.inf:
        raise ValueError(
            f"{name}.mean_run: expected 1 pose or more, and {share / (1.0 - share):g} or more for "
            f"a share of {share:g}, got {mean_run}"
        )


@dataclass(frozen=True)
class Gaussian(Degradation):
    """White Gaussian noise, independent from pose to pose.

    Args:
        sigma_m: deviation of the position an axis.
        sigma_rad: deviation of the rotation vector an axis.
        sigma_log_scale: deviation of the logarithm of the scale; trajectories of similarities only.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> float((noisy.motors.translation_m - true.motors.translation_m).std().round(3))
        0.01
    """

    sigma_m: float
    sigma_rad: float
    sigma_log_scale: float = 0.0

    def __post_init__(self) -> None:
        for name in ("sigma_m", "sigma_rad", "sigma_log_scale"):
            check_number(self, name)

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Add the noise.

        Raises:
            ValueError: noise of the scale for rigid poses.
        """
        draws = rng.standard_normal((len(trajectory), 7))
        perturbed = _perturbed(
            trajectory, self.sigma_m * draws[:, :3], self.sigma_rad * draws[:, 3:6]
        )
        if self.sigma_log_scale == 0.0:
            return perturbed
        if not isinstance(perturbed.poses, Similarity):
            raise ValueError(
                "Gaussian.sigma_log_scale: expected 0 for rigid poses, which have no scale, got "
                f"{self.sigma_log_scale}"
            )
        motor, scale = perturbed.poses.as_motor_scale()
        grown = scale * np.exp(self.sigma_log_scale * draws[:, 6])
        return replace(trajectory, poses=Similarity.from_motor_scale(motor, grown))


@dataclass(frozen=True)
class Outliers(Degradation):
    """A share of the poses, each for itself, is far off by a heavy-tailed error.

    The error is a multivariate Student t in position and another in rotation: normal, divided by
    ``sqrt(chi² / degrees_of_freedom)``. Few degrees of freedom have heavy tails (1 is Cauchy's, 2
    and below have no variance); infinity is the normal, and the whole then Tukey's contaminated
    normal. A `share` of 1 makes all noise Student's.

    Args:
        share: of the poses, 0 to 1.
        scale_m: scale of the position's error an axis.
        scale_rad: scale of the rotation vector's error an axis; turns beyond π come round.
        degrees_of_freedom: above zero.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Outliers
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> wild = Outliers(share=0.1, scale_m=0.3, scale_rad=0.5).apply(true, rng)
        >>> off_m = np.linalg.norm(wild.motors.translation_m - true.motors.translation_m, axis=1)
        >>> int(np.count_nonzero(off_m > 0.01)), len(true)
        (32, 301)
    """

    share: float
    scale_m: float
    scale_rad: float
    degrees_of_freedom: float = 3.0

    def __post_init__(self) -> None:
        check_number(self, "share", 0.0, 1.0)
        check_number(self, "scale_m")
        check_number(self, "scale_rad")
        if not self.degrees_of_freedom > 0.0:
            raise ValueError(
                f"Outliers.degrees_of_freedom: expected above 0, got {self.degrees_of_freedom}"
            )

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Throw the share of poses off."""
        count = len(trajectory)
        struck = rng.random(count) < self.share
        draws = rng.standard_normal((count, 2, 3)) * struck[:, None, None]
        if np.isfinite(self.degrees_of_freedom):
            freedom = self.degrees_of_freedom
            draws /= np.sqrt(rng.chisquare(freedom, (count, 2, 1)) / freedom)
        return _perturbed(trajectory, self.scale_m * draws[:, 0], self.scale_rad * draws[:, 1])


@dataclass(frozen=True)
class PlanarFlips(Degradation):
    """A share of the poses is the wrong one of the two that a flat marker allows, in runs.

    In each run the camera tracks a marker that stood straight ahead when the run began, at rest in
    the world, its normal tilted by `tilt_rad` against the line of sight towards a random side; see
    `wrong_planar_pose`. At the start of a run the error is a turn by twice the tilt, and of the
    position ``2 distance sin(tilt)``. "Ahead" is the moving frame's z axis.

    Args:
        share: of the poses, 0 to below 1.
        mean_run: mean length of a run in poses, 1 or more; lengths are geometric.
        distance_m: from the camera to the marker, above zero.
        tilt_rad: 0 to below π/2.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import PlanarFlips
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> flipped = PlanarFlips(share=0.1, mean_run=5.0).apply(true, rng)
        >>> turned = (true.motors.inverse() @ flipped.motors).rotor.angle() > 0.1
        >>> int(np.count_nonzero(turned)), len(true)
        (26, 301)
    """

    share: float
    mean_run: float = 10.0
    distance_m: float = 1.0
    tilt_rad: float = float(np.deg2rad(25.0))

    def __post_init__(self) -> None:
        check_runs(self, self.share, self.mean_run)
        check_number(self, "distance_m", 1e-9)
        check_number(self, "tilt_rad", 0.0, 0.5 * np.pi - 1e-9)

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Put the wrong candidate in the place of the true pose."""
        struck = runs(rng, len(trajectory), self.share, self.mean_run)
        side_rad = rng.uniform(-np.pi, np.pi, len(trajectory))
        starts = np.flatnonzero(struck & ~np.concatenate([[False], struck[:-1]]))
        if starts.size == 0:
            return trajectory
        at = np.flatnonzero(struck)
        first = starts[np.searchsorted(starts, at, side="right") - 1]
        rigid = trajectory.poses.rigid
        side, sine = side_rad[first], np.sin(self.tilt_rad)
        upright = np.full(at.size, -np.cos(self.tilt_rad))
        normal = np.stack([sine * np.cos(side), sine * np.sin(side), upright], axis=-1)
        centre_m = rigid[first].apply(np.array([0.0, 0.0, self.distance_m]))
        coefficients = np.array(rigid.coefficients)
        wrong = wrong_planar_pose(rigid[at], centre_m, rigid[first].rotor.apply(normal))
        coefficients[at] = wrong.coefficients
        return _with_rigid(trajectory, Motor(coefficients))


@dataclass(frozen=True)
class Quantised(Degradation):
    """Positions and quaternions rounded to multiples of a step, as logs with few digits keep them.

    Args:
        step_m: of each coordinate; 0 leaves positions as they are.
        step_rad: turns come in steps of about this size: quaternion components are rounded to
            multiples of half of it and renormalised; below 0.5, and 0 leaves rotations.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Quantised
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> Quantised(step_m=0.05, step_rad=0.0).apply(true, rng).motors.translation_m[10]
        array([ 0.25, -0.65,  0.05])
    """

    step_m: float
    step_rad: float

    def __post_init__(self) -> None:
        check_number(self, "step_m")
        check_number(self, "step_rad", 0.0, 0.5)

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Round; nothing is drawn."""
        rigid = trajectory.poses.rigid
        rotor, position_m = rigid.rotor, rigid.translation_m
        if self.step_m > 0.0:
            position_m = self.step_m * np.round(position_m / self.step_m)
        if self.step_rad > 0.0:
            step = 0.5 * self.step_rad
            rotor = Rotor.normalize(step * np.round(rotor.coefficients / step))
        return _with_rigid(trajectory, Motor.from_rotor_translation(rotor, position_m))


def wrong_planar_pose(
    world_T_camera: Motor, marker_m: ArrayLike, marker_normal: ArrayLike
) -> Motor:
    """The other pose that a small flat marker's image allows.

    Seen from afar a marker keeps its image when the depths of its points change sign: its normal
    ``n`` is mirrored about the line of sight ``v`` to ``2 (v·n) v - n``, the centre stays. In the
    camera's frame that is the turn with the rotor ``v n``, by twice the angle between the two,
    about the marker's centre; here the camera moves instead of the marker. Head on both agree.

    Source: Schweighofer, Pinz, Robust pose estimation from a planar target, IEEE PAMI 28(12), 2006;
    Collins, Bartoli, Infinitesimal plane-based pose estimation, IJCV 109, 2014. Close up, and for
    large markers, the second minimum of the reprojection error lies elsewhere, by about the
    marker's size over its distance in radians.

    Args:
        world_T_camera: true poses ``(*)``.
        marker_m: the marker's centre ``(*, 3)`` in the world.
        marker_normal: its unit normal ``(*, 3)`` in the world, either side.

    Raises:
        ValueError: a normal of another length, or a marker at the camera's centre.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions.degradations import wrong_planar_pose
        >>> from motorcade.ga import Motor
        >>> world_T_camera = Motor.identity()
        >>> normal = [0.0, np.sin(0.3), -np.cos(0.3)]  # of a marker 2 m ahead, tilted by 0.3 rad
        >>> wrong = wrong_planar_pose(world_T_camera, [0.0, 0.0, 2.0], normal)
        >>> wrong.rotor.as_rotation_vector().round(6) + 0.0  # twice the tilt
        array([0.6, 0. , 0. ])
    """
    centre = world_T_camera.inverse().apply(checked_floats(marker_m, "marker_m", (3,)))
    normal = checked_floats(marker_normal, "marker_normal", (3,))
    if np.any(np.abs(np.linalg.norm(normal, axis=-1) - 1.0) > 1e-6):
        raise ValueError("marker_normal: expected vectors of length 1")
    distance = np.linalg.norm(centre, axis=-1, keepdims=True)
    if not np.all(distance > 0.0):
        raise ValueError("marker_m: expected points away from the camera's centre")
    sight, n = centre / distance, world_T_camera.rotor.inverse().apply(normal)
    inner, outer = np.sum(sight * n, axis=-1, keepdims=True), np.cross(sight, n)
    turn = Rotor.normalize(np.concatenate([inner, outer], axis=-1))
    about_marker = Motor.from_rotor_translation(turn, centre - turn.apply(centre))
    return world_T_camera @ about_marker.inverse()


def _with_rigid(trajectory: Trajectory, rigid: Motor) -> Trajectory:
    """The trajectory with other orientations and positions, and its own scales."""
    poses = trajectory.poses
    if isinstance(poses, Similarity):
        return replace(trajectory, poses=Similarity.from_motor_scale(rigid, poses.scale))
    return replace(trajectory, poses=rigid)


def _perturbed(trajectory: Trajectory, shift_m: FloatArray, turn_rad: FloatArray) -> Trajectory:
    rigid = trajectory.poses.rigid
    rotor = rigid.rotor @ Rotor.from_rotation_vector(turn_rad)
    perturbed = Motor.from_rotor_translation(rotor, rigid.translation_m + shift_m)
    return _with_rigid(trajectory, perturbed)


# Errors of the stamps: they tremble, frames are missing, or all come late.

# Neighbours that move towards each other by this part of the gap between them stay in order.
_REACH = 0.49


@dataclass(frozen=True)
class StampJitter(Degradation):
    """Stamps off by independent Gaussian errors of deviation `sigma_s`; poses stay.

    So that the order stays, no stamp moves by more than 0.49 of the gap to its neighbour: from a
    deviation of a fifth of the interval on, the errors are smaller than asked for.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import StampJitter
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> moved = StampJitter(sigma_s=0.002).apply(true, rng)
        >>> print(f"{1e-6 * (moved.time_ns - true.time_ns).std():.1f} ms")
        2.0 ms
    """

    sigma_s: float

    def __post_init__(self) -> None:
        check_number(self, "sigma_s", high=1e6)

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Move the stamps."""
        time_ns = trajectory.time_ns
        offset = 1e9 * self.sigma_s * rng.standard_normal(time_ns.size)
        gaps = np.concatenate([[np.inf], _REACH * np.diff(time_ns), [np.inf]])
        held = np.clip(offset, -gaps[:-1], gaps[1:])
        return replace(trajectory, time_ns=time_ns + np.trunc(held).astype(np.int64))


@dataclass(frozen=True)
class DroppedFrames(Degradation):
    """A share of the poses is missing, in bursts of a mean length; the first one always stays.

    Args:
        share: of the poses, 0 to below 1.
        mean_run: mean length of a burst in poses, geometric; None drops each pose for itself.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import DroppedFrames
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> len(true), len(DroppedFrames(share=0.2, mean_run=3.0).apply(true, rng))
        (301, 244)
    """

    share: float
    mean_run: float | None = None

    def __post_init__(self) -> None:
        check_runs(self, self.share, self._mean_run())

    def _mean_run(self) -> float:
        alone = 1.0 / (1.0 - self.share) if self.share < 1.0 else np.inf
        return alone if self.mean_run is None else self.mean_run

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Leave the rest."""
        lost = runs(rng, len(trajectory), self.share, self._mean_run())
        lost[0] = False
        return trajectory[~lost]


@dataclass(frozen=True)
class Blackouts(Degradation):
    """No pose at all for `length_s` every `every_s`, the first time `every_s` after the first pose.

    A blackout that would not end before the path does is left out.

    Args:
        length_s: of each blackout, above zero and below `every_s`.
        every_s: from the start of one to the start of the next.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Blackouts
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> dark = Blackouts(length_s=1.0, every_s=4.0)
        >>> dark.spans_s(10.0)
        array([[4., 5.],
               [8., 9.]])
        >>> len(true), len(dark.apply(true, rng))
        (301, 241)
    """

    length_s: float
    every_s: float

    def __post_init__(self) -> None:
        check_number(self, "every_s", 1e-9)
        check_number(self, "length_s", 1e-9, self.every_s)

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Leave the poses outside the blackouts."""
        offset_s = (trajectory.time_ns - trajectory.time_ns[0]) * 1e-9
        return trajectory[~self.dark(offset_s, trajectory.duration_s)]

    def spans_s(self, duration_s: float) -> FloatArray:
        """Start and end ``(K, 2)`` of every blackout on a path so long, in seconds from its start.

        Poses are missing from each start on, up to but not at the end.

        Raises:
            ValueError: more than ten million of them.
        """
        check_count(duration_s / self.every_s, "Blackouts.spans_s(duration_s)")
        starts: FloatArray = self.every_s * np.arange(1.0, self._count(duration_s) + 1.0)
        return np.stack([starts, starts + self.length_s], axis=-1)

    def dark(self, offset_s: FloatArray, duration_s: float) -> NDArray[np.bool_]:
        """Which times ``(N,)`` after the start of a path so long lie in a blackout.

        Times within half a microsecond of an edge count as on it.
        """
        at = np.round(offset_s, 6)[:, None]
        # Which blackout began last, or the neighbours of that by rounding.
        number = np.floor(at / self.every_s) + np.arange(-1.0, 2.0)
        start = self.every_s * number
        end = start + self.length_s
        there = (number >= 1.0) & (number <= self._count(duration_s))
        dark: NDArray[np.bool_] = (there & (at >= start) & (at < end)).any(axis=1)
        return dark

    def _count(self, duration_s: float) -> int:
        return max(0, int(np.floor((duration_s - self.length_s) / self.every_s + 1e-9)))


@dataclass(frozen=True)
class Latency(Degradation):
    """Poses are stamped when they arrive, `delay_s` late on average.

    Delays are gamma distributed with deviation `spread_s`, and no pose overtakes another. Where the
    mean is `known` it is taken off the stamps again: a constant known delay then harms nothing
    after the fact, a varying one leaves its variation.

    Args:
        delay_s: mean delay, above zero.
        spread_s: deviation of the delay from pose to pose; 0 is a constant delay.
        known: whether the mean is taken off.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Latency
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> late = Latency(delay_s=0.03).apply(true, rng)
        >>> (late.time_ns - true.time_ns)[:3]
        array([30000000, 30000000, 30000000])
    """

    delay_s: float
    spread_s: float = 0.0
    known: bool = False

    def __post_init__(self) -> None:
        check_number(self, "delay_s", 1e-9, 1e6)
        check_number(self, "spread_s", 1e-9 if self.spread_s > 0.0 else 0.0, 1e6)

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Stamp the poses with their arrival, or what is thought to be their time."""
        count = len(trajectory)
        delay_s = np.full(count, self.delay_s)
        if self.spread_s > 0.0:
            shape = (self.delay_s / self.spread_s) ** 2
            delay_s = rng.gamma(shape, self.delay_s / shape, count)
        if self.known:
            delay_s = delay_s - self.delay_s
        arrival_ns = trajectory.time_ns + np.round(1e9 * delay_s).astype(np.int64)
        # One nanosecond each, so that poses that arrive together stay in order.
        places = np.arange(count)
        stamps = np.maximum.accumulate(arrival_ns - places) + places
        return replace(trajectory, time_ns=stamps)
