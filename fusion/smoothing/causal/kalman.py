"""Kalman filters of constant velocity and constant acceleration, over any representation.

The state is a pose and its velocity (and acceleration) in the representation's own vectors: on
motors the body twist, so that a steady screw is followed without error. Process noise is white on
the highest derivative, measurement noise white on the pose, both isotropic in rotation, in
translation and in scale. Gaps are a longer prediction; those over which it adds 1e10 variances of
the noise to the pose are cut short there, since the pose behind is free of what was before, and
rates led on for longer would make steps of more than half a turn.

Poses and residuals are moved exactly. Where poses compose (motors, similarities, the rotations of
"rotor") their errors are propagated along the motion with those of the rates in one covariance, as
in J. Sola, J. Deray, D. Atchuthan, A micro Lie algebra for state estimation in robotics (2018);
where they are added component by component, a small matrix a block is the whole covariance. Two
things are neglected: what one step's length does to its effect across the axis of turn, a share
|u|²/24 for a twist u, and (of constant acceleration) the bracket of velocity and acceleration
within a step. Errors remain as large as stated at 1 rad a step. The update is linear: on motors a
turn of θ in the innovation swings a step of length s by up to sθ/2, which counts where positions
are far better known than rotations (`robust_map` iterates). Half a turn or more is read as less.

R. E. Kalman, A new approach to linear filtering and prediction problems, J. Basic Eng. 82 (1960);
noise models as in Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with applications to tracking
and navigation (2001), 6.2.2 and 6.2.3.

The Rauch-Tung-Striebel smoother runs the filter forward and corrects its estimates backward (H. E.
Rauch, F. Tung, C. T. Striebel, Maximum likelihood estimates of linear dynamic systems, AIAA J. 3,
1965). All poses inform every one, so there is no lag. Model, noise and limits are the filters'.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.smoothing.causal.stream import (
    CausalFilter,
    FilterMethod,
    coefficients_of,
    trajectory_of,
)
from motorcade.fusion.smoothing.native import _scans
from motorcade.fusion.smoothing.representations import representation_named
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive

P = TypeVar("P", Motor, Similarity)

NOISE_M, NOISE_RAD, NOISE_SCALE = 0.005, 0.01, 0.005


class KalmanFilter(CausalFilter):
    """What the two filters share; see the module and them.

    Examples:
        >>> from motorcade.fusion.smoothing.causal import ConstantVelocityFilter, KalmanFilter
        >>> live = ConstantVelocityFilter(noise_m=0.005, noise_rad=0.01)
        >>> isinstance(live, KalmanFilter), live.order  # the velocity is estimated
        (True, 1)
    """

    order: ClassVar[int]
    """How many derivatives of the pose are estimated."""

    def __init__(
        self,
        densities: tuple[float, float, float],
        noise_m: ArrayLike,
        noise_rad: ArrayLike,
        noise_scale: ArrayLike,
        representation: str,
    ) -> None:
        self.densities = densities
        self.noise = _noise_rows(noise_rad, noise_m, noise_scale)
        super().__init__(representation)

    def _scan(self, scale: bool) -> _scans.Scan:
        first = self.noise[0].tolist()
        return _scans.kalman(
            self._averaged_as.compiled,
            scale,
            self.order,
            self.densities,
            (first[0], first[1], first[2]),
        )

    def update(
        self,
        pose: P,
        time_ns: int,
        noise_m: float | None = None,
        noise_rad: float | None = None,
        noise_scale: float | None = None,
    ) -> P:
        """The filtered pose at a stamp, from a measured one; the first comes back as it is.

        The velocity is opened by the second pose, with a prior about zero so wide (1000 times the
        noise and 10 times the step, over dt) that it has no say.

        Args:
            pose: one Motor or Similarity, no batch; the result is in float64.
            time_ns: stamp in integer nanoseconds, after those before.
            noise_m: standard deviation of this pose alone where it is not the filter's own.
            noise_rad: likewise.
            noise_scale: likewise.

        Raises:
            ValueError: as `CausalFilter.update`; a deviation that is not positive; or none given
                where the filter was made with one for each pose of a trajectory.
            TypeError: another kind of pose than before.
        """
        if noise_m is None and noise_rad is None and noise_scale is None:
            return super().update(pose, time_ns)
        own = self.noise[0]
        row = _noise_rows(
            own[0] if noise_rad is None else noise_rad,
            own[1] if noise_m is None else noise_m,
            own[2] if noise_scale is None else noise_scale,
        )
        if type(pose) is not self._kind:
            self._begin(pose)
        self._weigh(row)
        try:
            return super().update(pose, time_ns)
        finally:
            self._weigh(self.noise)

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """What `update` gives for a trajectory's poses in turn, to the last bit: no look ahead.

        Raises:
            ValueError: noise for another number of poses, or a result beyond float64.
        """
        return self._filtered(trajectory)[0]

    def log_likelihood(self, trajectory: Trajectory) -> float:
        """Logarithm of the density of a trajectory's innovations: what a better model raises.

        The first `order` innovations are left out: they only open the rates. Of quaternions it is
        the density of their components.

        Raises:
            ValueError: as `smooth`.
        """
        return self._filtered(trajectory)[1].log_likelihood

    def noise_of(self, trajectory: Trajectory) -> FloatArray:
        """Deviations ``(1, 3)`` or ``(N, 3)`` of the poses: rotation, translation, scale.

        Raises:
            ValueError: noise for another number of poses.
        """
        if len(self.noise) not in (1, len(trajectory)):
            raise ValueError(
                f"noise: expected one deviation or one for each of {len(trajectory)} poses, got "
                f"{len(self.noise)}"
            )
        return self.noise

    def _filtered(self, trajectory: Trajectory) -> tuple[Trajectory, _scans.Scan]:
        scan = self._scan(isinstance(trajectory.poses, Similarity))
        return self._run(scan, trajectory, self.noise_of(trajectory)), scan

    def _begin(self, pose: Motor | Similarity) -> _scans.Scan:
        if len(self.noise) > 1:
            raise ValueError(
                "noise: expected one deviation for a stream (update takes those of single poses), "
                f"got {len(self.noise)}"
            )
        return super()._begin(pose)

    def _weigh(self, rows: FloatArray) -> None:
        if self._running is not None:
            self._running.measured_with((rows[0, 0], rows[0, 1], rows[0, 2]))


def _noise_rows(noise_rad: ArrayLike, noise_m: ArrayLike, noise_scale: ArrayLike) -> FloatArray:
    """Deviations ``(1, 3)``, or ``(N, 3)`` where one of them has one a pose."""
    columns = []
    for name, value in (
        ("noise_rad", noise_rad),
        ("noise_m", noise_m),
        ("noise_scale", noise_scale),
    ):
        checked = np.atleast_1d(checked_floats(value, name, ()))
        if checked.ndim != 1 or not np.all(checked > 0.0):
            raise ValueError(
                f"{name}: expected a positive deviation or (N,) of them, got {value!r}"
            )
        columns.append(checked)
    sizes = {len(column) for column in columns} - {1}
    if len(sizes) > 1:
        raise ValueError(f"noise: expected equal numbers of deviations, got {sorted(sizes)}")
    return np.ascontiguousarray(np.stack(np.broadcast_arrays(*columns), axis=-1))


class ConstantVelocityFilter(KalmanFilter):
    """Kalman filter of a velocity that white acceleration changes.

    Args:
        acceleration_m_s2: density of the acceleration in m/s²/√Hz: in dt seconds the velocity
            wanders by this times √dt. In the representation's vectors, on motors those of the body.
        angular_acceleration_rad_s2: the same of the rotation in rad/s²/√Hz.
        scale_acceleration_s2: the same of the scale (of its logarithm where the representation is
            "similarity") in 1/s²/√Hz; rigid poses have none.
        noise_m: standard deviation of a measured translation, an axis: one number, or ``(N,)`` for
            the poses of a trajectory.
        noise_rad: the same of a rotation, about an axis.
        noise_scale: the same of the scale.
        representation: a name of `REPRESENTATIONS`.

    Raises:
        ValueError: a number that is not positive, or an unknown representation.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import ConstantVelocityFilter
        >>> world_T_camera = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> live = ConstantVelocityFilter(noise_m=0.01, noise_rad=0.02)
        >>> for pose, time_ns in zip(world_T_camera.motors, world_T_camera.time_ns, strict=True):
        ...     smoothed = live.update(pose, int(time_ns))
        >>> behind = smoothed.inverse() @ world_T_camera.motors[-1]
        >>> print(f"{100.0 * abs(behind.translation_m).max():.1f} cm behind")
        0.0 cm behind
    """

    order = 1

    def __init__(
        self,
        acceleration_m_s2: float = 1.0,
        angular_acceleration_rad_s2: float = 2.0,
        noise_m: ArrayLike = NOISE_M,
        noise_rad: ArrayLike = NOISE_RAD,
        scale_acceleration_s2: float = 1.0,
        noise_scale: ArrayLike = NOISE_SCALE,
        representation: str = "motor",
    ) -> None:
        densities = (
            checked_positive(
                angular_acceleration_rad_s2, "angular_acceleration_rad_s2", "rad/s²/√Hz"
            ),
            checked_positive(acceleration_m_s2, "acceleration_m_s2", "m/s²/√Hz"),
            checked_positive(scale_acceleration_s2, "scale_acceleration_s2", "1/s²/√Hz"),
        )
        super().__init__(densities, noise_m, noise_rad, noise_scale, representation)


class ConstantAccelerationFilter(KalmanFilter):
    """Kalman filter of an acceleration that white jerk changes.

    Args:
        jerk_m_s3: density of the jerk in m/s³/√Hz: in dt seconds the acceleration wanders by this
            times √dt.
        angular_jerk_rad_s3: the same of the rotation in rad/s³/√Hz.
        noise_m: as `ConstantVelocityFilter`.
        noise_rad: as there.
        scale_jerk_s3: the same of the scale in 1/s³/√Hz; rigid poses have none.
        noise_scale: as there.
        representation: a name of `REPRESENTATIONS`.

    Raises:
        ValueError: a number that is not positive, or an unknown representation.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import ConstantAccelerationFilter
        >>> world_T_camera = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> live = ConstantAccelerationFilter(noise_m=0.01, noise_rad=0.02)
        >>> for pose, time_ns in zip(world_T_camera.motors, world_T_camera.time_ns, strict=True):
        ...     smoothed = live.update(pose, int(time_ns))
        >>> behind = smoothed.inverse() @ world_T_camera.motors[-1]
        >>> print(f"{100.0 * abs(behind.translation_m).max():.1f} cm behind")
        0.0 cm behind
    """

    order = 2

    def __init__(
        self,
        jerk_m_s3: float = 5.0,
        angular_jerk_rad_s3: float = 10.0,
        noise_m: ArrayLike = NOISE_M,
        noise_rad: ArrayLike = NOISE_RAD,
        scale_jerk_s3: float = 5.0,
        noise_scale: ArrayLike = NOISE_SCALE,
        representation: str = "motor",
    ) -> None:
        densities = (
            checked_positive(angular_jerk_rad_s3, "angular_jerk_rad_s3", "rad/s³/√Hz"),
            checked_positive(jerk_m_s3, "jerk_m_s3", "m/s³/√Hz"),
            checked_positive(scale_jerk_s3, "scale_jerk_s3", "1/s³/√Hz"),
        )
        super().__init__(densities, noise_m, noise_rad, noise_scale, representation)


constant_velocity = FilterMethod(ConstantVelocityFilter)
"""`ConstantVelocityFilter` over a whole trajectory, forward only."""


constant_acceleration = FilterMethod(ConstantAccelerationFilter)
"""`ConstantAccelerationFilter` over a whole trajectory, forward only."""


@dataclass(frozen=True, eq=False)
class SmoothedStates:
    """What the smoother knows of every pose.

    Fields:
        trajectory: the smoothed poses.
        rates: ``(N, order, d)`` velocity, and acceleration where it is estimated, in the
            representation's vectors: of motors the body twist (rad/s, m/s) and its derivative.
        deviations: ``(N, blocks, order + 1)`` standard deviations of pose, velocity and
            acceleration, an axis: of rotation (rad), translation (m) and, of similarities, scale.
        log_likelihood: of the innovations, see `KalmanFilter.log_likelihood`.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import ConstantVelocityFilter
        >>> from motorcade.fusion.smoothing.causal import smoothed_states
        >>> found = smoothed_states(screw().sampled(30.0, 2.0), ConstantVelocityFilter())
        >>> found.rates[30, 0].round(2)  # rad/s, then m/s
        array([ 0.  , -1.  ,  0.  ,  0.  , -0.08,  0.7 ])
    """

    trajectory: Trajectory
    rates: FloatArray
    deviations: FloatArray
    log_likelihood: float


def smoothed_states(trajectory: Trajectory, model: KalmanFilter) -> SmoothedStates:
    """Smooth a trajectory by a filter's model and noise; the filter's own stream goes on untouched.

    Memory is below 1 KiB a pose; time is linear.

    Raises:
        ValueError: noise for another number of poses, or a result beyond float64.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion.smoothing import ConstantVelocityFilter
        >>> from motorcade.fusion.smoothing.causal import smoothed_states
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> found = smoothed_states(noisy, ConstantVelocityFilter(noise_m=0.01, noise_rad=0.02))
        >>> found.rates.shape  # body twists
        (121, 1, 6)
        >>> position_m = found.deviations[60, 1, 0]
        >>> print(f"the middle position is known to {1e3 * position_m:.1f} mm an axis")
        the middle position is known to 5.3 mm an axis
    """
    representation = representation_named(model.representation)
    ends, _, _ = _scans.layout(representation.compiled, isinstance(trajectory.poses, Similarity))
    rates = np.empty((len(trajectory), model.order, ends[-1]))
    deviations = np.empty((len(trajectory), len(ends), model.order + 1))
    smoothed, log_likelihood = _scanned(trajectory, model, (rates, deviations))
    rates = representation.vectors_from_compiled(rates)
    for array in (rates, deviations):
        array.setflags(write=False)
    return SmoothedStates(smoothed, rates, deviations, log_likelihood)


def _smoothed(trajectory: Trajectory, model: KalmanFilter) -> Trajectory:
    """The poses alone, in half the time."""
    return _scanned(trajectory, model)[0]


def _scanned(
    trajectory: Trajectory,
    model: KalmanFilter,
    states: tuple[FloatArray, FloatArray] | None = None,
) -> tuple[Trajectory, float]:
    representation = representation_named(model.representation)
    measured = coefficients_of(trajectory, representation)
    out = np.empty(measured.shape, measured.dtype)
    log_likelihood = _scans.rts(
        representation.compiled,
        isinstance(trajectory.poses, Similarity),
        model.order,
        measured,
        trajectory.time_ns,
        model.noise_of(trajectory),
        model.densities,
        out,
        states,
    )
    return trajectory_of(trajectory, out, representation), log_likelihood


rts_constant_velocity = FilterMethod(ConstantVelocityFilter, _smoothed)
"""Smoother of a velocity that white acceleration changes; see `ConstantVelocityFilter`."""


rts_constant_acceleration = FilterMethod(ConstantAccelerationFilter, _smoothed)
"""Smoother of an acceleration that white jerk changes; see `ConstantAccelerationFilter`."""
