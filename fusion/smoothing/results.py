"""What is known of a smoothed path besides its poses, whatever method made it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.metrics import NotObservableError, jitter_above
from motorcade.fusion.smoothing.auto import SmootherChoice, smoothed_automatically
from motorcade.fusion.smoothing.batch.robust_map import estimate_path
from motorcade.fusion.smoothing.causal import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    KalmanFilter,
    smoothed_states,
)
from motorcade.fusion.smoothing.curve import PathCurve
from motorcade.fusion.smoothing.given import GivenPoses
from motorcade.fusion.smoothing.representations import Representation, representation_named
from motorcade.ga import Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# Poses that count less than this hardly say how uncertain those beside them are.
_LEAST_WEIGHT = 1e-8
# Step of differences, in a representation's units, and the poses that are differed at a time.
_STEP, _CHUNK = 1e-6, 4096


@dataclass(frozen=True, eq=False)
class SmoothingResult:
    """A smoothed path with what is known of it.

    Fields:
        trajectory: the smoothed poses, with the stamps and frames of the measured ones.
        method: a name of `METHODS`.
        representation: what was averaged.
        weights: ``(N,)`` about 1 where a measured pose counts fully, 0 where it is left out. Of
            methods that trust every pose alike they are 1.
        covariance: ``(N, 6, 6)`` of the right perturbation in the moving frame, rotation (rad)
            first; ``(N, 7, 7)`` of similarities, the logarithm of the scale last. It is what noise
            leaves, and knows nothing of errors that all poses share. None of methods that are
            told nothing of the noise (windows, low-pass filters, `spline`) and of filters that only
            look back; NaN where noise cannot be told from motion.
        jumps: rows before which the level jumps, as "auto" found; of other methods none are known.
        choice: what "auto" found out; None of other methods, and of "auto" with a lag.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.smoothing import SmoothingResult
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> rows = np.zeros((121, 7))  # x, y, z, qx, qy, qz, qw
        >>> wxyz, rows[:, :3] = noisy.motors.as_quaternion_translation()
        >>> rows[:, 3:] = wxyz[:, [1, 2, 3, 0]]
        >>> found = smooth(rows, "rts_constant_velocity", time_s=noisy.time_s, full=True)
        >>> isinstance(found, SmoothingResult), found.poses.shape, found.at([0.01, 1.5]).shape
        (True, (121, 7), (2, 7))
        >>> speed_m_s = np.linalg.norm(found.world_velocity_m_s, axis=1)
        >>> sigma_m = np.sqrt(found.covariance[60, 3:, 3:].trace())
        >>> print(f"{speed_m_s.max():.1f} m/s; the middle pose is known to {1e3 * sigma_m:.0f} mm")
        0.8 m/s; the middle pose is known to 5 mm
    """

    trajectory: Trajectory
    method: str
    representation: str
    weights: FloatArray
    covariance: FloatArray | None
    jumps: IntArray
    choice: SmootherChoice | None
    _given: GivenPoses

    @cached_property
    def poses(self) -> Any:
        """The smoothed poses as the measured ones came."""
        return self._given.written(self.trajectory, None)

    @cached_property
    def curve(self) -> PathCurve:
        """The path between its stamps.

        Raises:
            ValueError: a single pose.
        """
        return PathCurve(self.trajectory, self.jumps)

    def at(self, times: ArrayLike) -> Any:
        """Poses at other times ``(M,)``, on the curve through the smoothed ones, as those came.

        Args:
            times: increasing; what stamped the poses: seconds or datetimes, of a Trajectory integer
                nanoseconds. Without gaps, between which nothing is known but the ends.

        Raises:
            ValueError: times outside the path, or that do not increase; a single pose.
        """
        time_ns = self._given.stamps_of(times)
        like = self.trajectory
        resampled = Trajectory(time_ns, self.curve.at(time_ns), like.parent, like.child)
        return self._given.written(resampled, times)

    @property
    def body_twist(self) -> FloatArray:
        """Angular rate (rad/s) and velocity (m/s) in the moving frame ``(N, 6)``; see `PathCurve`.

        Raises:
            ValueError: a single pose.
        """
        return self.curve.body_twist

    @property
    def world_velocity_m_s(self) -> FloatArray:
        """Velocity of the moving frame's origin in the parent's axes ``(N, 3)``.

        Raises:
            ValueError: a single pose.
        """
        poses, body_m_s = self.trajectory.poses, self.body_twist[:, 3:6]
        turned = poses.rotor.apply(body_m_s)
        return poses.scale[:, None] * turned if isinstance(poses, Similarity) else turned


def smoothed_in_full(
    poses: GivenPoses,
    method: str,
    representation: Representation | None,
    function: Callable[..., Trajectory],
    parameters: dict[str, Any],
) -> SmoothingResult:
    """Run a method and keep what it knows.

    Args:
        poses: what is smoothed.
        method: its name.
        representation: what is averaged; None leaves it to "auto".
        function: what `METHODS` has under that name.
        parameters: of the method, all of them.
    """
    path, weights = poses.trajectory, np.ones(len(poses.trajectory))
    named = "rotor" if representation is None else representation.name
    if method == "auto" and parameters["lag_s"] is None:
        parameters = {name: value for name, value in parameters.items() if name != "lag_s"}
        automatic = smoothed_automatically(
            path, None if representation is None else named, **parameters
        )
        taken = representation_named(automatic.choice.representation)
        return SmoothingResult(
            automatic.trajectory,
            method,
            taken.name,
            automatic.weights,
            _covariance(automatic.trajectory, taken, automatic.deviations**2),
            automatic.jumps,
            automatic.choice,
            poses,
        )
    model: KalmanFilter | None = None
    if method == "robust_map":
        robust = estimate_path(path, named, **parameters)
        weights, smoothed = robust.weight, robust.trajectory
        model = _weighted_model(weights, named, parameters)
        deviations = smoothed_states(path, model).deviations
    elif method in _MODELS:
        model = _MODELS[method](**parameters, representation=named)
        states = smoothed_states(path, model)
        smoothed, deviations = states.trajectory, states.deviations
    else:
        smoothed = function(path, representation, **parameters)
    none = np.zeros(0, dtype=np.int64)
    covariance = None if model is None else _isotropic(deviations[:, :, 0])
    return SmoothingResult(smoothed, method, named, weights, covariance, none, None, poses)


_MODELS: dict[str, type[KalmanFilter]] = {
    "rts_constant_velocity": ConstantVelocityFilter,
    "rts_constant_acceleration": ConstantAccelerationFilter,
}


def _weighted_model(
    weights: FloatArray, representation: str, parameters: dict[str, Any]
) -> KalmanFilter:
    """The motion model of `robust_map`, with the noise that the weights make of the poses'."""
    sizes = {name: size for name, size in parameters.items() if name not in ("loss", "width")}
    larger = 1.0 / np.sqrt(np.maximum(weights, _LEAST_WEIGHT))
    for name in ("noise_m", "noise_rad", "noise_scale"):
        sizes[name] = sizes[name] * larger
    return ConstantVelocityFilter(**sizes, representation=representation)


def _isotropic(deviations: FloatArray) -> FloatArray:
    """Covariances of deviations ``(N, 2)`` or ``(N, 3)``: rotation, position, scale, an axis."""
    variance = np.repeat(deviations[:, :2] ** 2, 3, axis=1)
    variance = np.concatenate([variance, deviations[:, 2:] ** 2], axis=1)
    return np.asarray(variance[:, :, None] * np.eye(variance.shape[1]), dtype=np.float64)


def _covariance(
    path: Trajectory, representation: Representation, variance: FloatArray
) -> FloatArray:
    """Covariances in the moving frame of variances ``(N, d)`` of a representation's components."""
    size = 7 if isinstance(path.poses, Similarity) else 6
    covariances = np.empty((len(path), size, size))
    coordinates = representation.coordinates(path.poses)
    for first in range(0, len(path), _CHUNK):
        rows = slice(first, first + _CHUNK)
        base, poses = coordinates[rows], path.poses[rows]
        jacobian = np.empty((len(base), size, variance.shape[1]))
        for column in range(variance.shape[1]):
            step = np.zeros(variance.shape[1])
            step[column] = _STEP
            ends = [
                representation.poses(representation.retract(base, move)) for move in (step, -step)
            ]
            later, earlier = (
                poses.local(end if size == 7 else end.rigid)  # type: ignore[arg-type]
                for end in ends
            )
            jacobian[:, :, column] = (later - earlier) / (2.0 * _STEP)
        unobservable = np.isnan(variance[rows])
        weighted = jacobian * np.where(unobservable, 0.0, variance[rows])[:, None, :]
        covariances[rows] = weighted @ np.swapaxes(jacobian, 1, 2)
        if np.any(unobservable):
            reached = (np.abs(jacobian) > _STEP) & unobservable[:, None, :]
            lost = np.any(reached, axis=2)
            covariances[rows][lost[:, :, None] | lost[:, None, :]] = np.nan
    return covariances


# What smoothing did to a path, in figures that need no ground truth.

# Motion of cameras and hands lies below; above it most acceleration is noise.
_ABOVE_HZ = 5.0


def changes(raw: Trajectory, smoothed: Trajectory) -> dict[str, float | None]:
    """How far poses were moved and how much jitter is left; None where it cannot be told.

    Jitter is the RMS acceleration above 5 Hz, or above a quarter of the rate where that is less;
    see `fusion.metrics.jitter_above`.

    Args:
        raw: the measured path.
        smoothed: the same stamps.

    Raises:
        ValueError: other stamps.
    """
    if not np.array_equal(raw.time_ns, smoothed.time_ns):
        raise ValueError("smoothed: expected the stamps of the raw trajectory, got others")
    before, after = raw.poses.rigid, smoothed.poses.rigid
    shift_m = np.linalg.norm(after.translation_m - before.translation_m, axis=-1)
    turn = (before.rotor.inverse() @ after.rotor).as_rotation_vector()
    turn_deg = np.rad2deg(np.linalg.norm(turn, axis=-1))
    figures: dict[str, float | None] = {
        "shift_rms_m": float(np.sqrt(np.mean(shift_m**2))),
        "shift_max_m": float(np.max(shift_m)),
        "turned_rms_deg": float(np.sqrt(np.mean(turn_deg**2))),
        "turned_max_deg": float(np.max(turn_deg)),
    }
    for name, trajectory in (("raw", raw), ("smoothed", smoothed)):
        linear, angular = _jitter(trajectory)
        figures[f"{name}_linear_jitter_m_s2"] = linear
        figures[f"{name}_angular_jitter_rad_s2"] = angular
    return figures


def _jitter(trajectory: Trajectory) -> tuple[float | None, float | None]:
    if len(trajectory) < 3:
        return None, None
    rate_hz = 1.0 / float(np.median(np.diff(trajectory.time_s)))
    rigid = Trajectory(trajectory.time_ns, trajectory.poses.rigid)
    try:
        jitter = jitter_above(rigid, min(_ABOVE_HZ, 0.25 * rate_hz))
    except NotObservableError:
        return None, None
    return jitter.linear_m_s2, jitter.angular_rad_s2
