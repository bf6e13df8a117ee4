"""The map of all unknowns of a camera path beside an IMU: maximum a posteriori, by Gauss-Newton.

States stand at the camera's stamps, moved to the IMU's clock: pose, velocity, both biases. They
share the time offset, the extrinsics, gravity and the scale of the camera's world. Between states
stand preintegrated samples, summed up again at every step at the offset and the biases of the
moment, so that nothing is linearised but where it stands. Wrong poses lose their weight (Cauchy's
loss); the noise of the others is estimated along the way.

Sources: T. Qin and S. Shen, Online temporal calibration for monocular visual-inertial systems,
IROS 2018; C. Campos, J. Montiel, J. Tardós, Inertial-only optimization for visual-inertial
initialization, ICRA 2020.

Residuals and derivatives come from the code that `model` generated. It is imported where it is
called, so that it can be written again whatever state it is in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass, replace
from typing import Any

import numpy as np

from motorcade.fusion.imu.noise import ACCEL_BIAS_SIGMA_M_S2, GYRO_BIAS_SIGMA_RAD_S, ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.preintegration import Preintegrated, preintegrate
from motorcade.fusion.sync.normal_equations import Bordered, Solved
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# Enough that NumPy computes more than it is called.
_ROWS_A_CALL = 4096


def interval_residuals(
    poses: tuple[FloatArray, FloatArray],
    velocities: tuple[FloatArray, FloatArray],
    bias_steps: FloatArray,
    gravity: FloatArray,
    motion: FloatArray,
    bias_jacobian: FloatArray,
    duration_s: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """What K preintegrated intervals miss between the states at their ends.

    Args:
        poses: coefficients ``(K, 8)`` of ``world_T_imu`` at starts and ends.
        velocities: ``(K, 3)`` in the world at starts and ends.
        bias_steps: ``(K, 6)``, biases at the ends minus those at the starts.
        gravity: ``(3,)`` in the world.
        motion: ``(K, 16)`` coefficients of the preintegrated pair of motors, at the start's biases.
        bias_jacobian: ``(K, 9, 6)`` of it.
        duration_s: ``(K,)``.

    Returns:
        Residuals ``(K, 15)``, rotation, position, velocity, biases, and their derivatives
        ``(K, 15, 33)`` by the start's pose, velocity, biases, the end's, and gravity.
    """
    from motorcade.fusion.sync.generated import residuals as generated

    count = len(duration_s)
    jacobian = bias_jacobian.transpose(0, 2, 1).reshape(count, 54)  # CasADi's order is by columns
    gravities = np.broadcast_to(gravity, (count, 3))
    inputs = (*poses, *velocities, bias_steps, gravities, motion, jacobian, duration_s[:, None])
    return _by_parts(generated.interval_f64, generated.INTERVAL, (15, 33), inputs)


def pose_residuals(
    poses: FloatArray, twists: FloatArray, imu_T_camera: FloatArray, measured: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How far N measured poses of the camera are from those that the IMU's poses imply.

    Args:
        poses: coefficients ``(N, 8)`` of ``world_T_imu``.
        twists: ``(N, 6)`` of the IMU, rad/s and m/s: where a later time would find it.
        imu_T_camera: ``(8,)`` of ``imu_T_camera``.
        measured: ``(N, 8)`` of ``world_T_camera``, scaled to metres.

    Returns:
        Residuals ``(N, 6)`` in the camera's axes, and their derivatives ``(N, 6, 14)`` by the
        pose, the time offset (s), the extrinsics, and the logarithm of the measurements' scale.
    """
    from motorcade.fusion.sync.generated import residuals as generated

    extrinsics = np.broadcast_to(imu_T_camera, (len(poses), 8))
    inputs = (poses, twists, extrinsics, measured)
    return _by_parts(generated.pose_f64, generated.POSE, (6, 14), inputs)


def _by_parts(
    function: Callable[..., tuple[Any, ...]],
    places: tuple[tuple[int, int], ...],
    shape: tuple[int, int],
    inputs: tuple[FloatArray, ...],
) -> tuple[FloatArray, FloatArray]:
    """Residuals ``(n, r)`` and derivatives ``(n, r, u)`` of n rows of each input.

    The function gives r residuals, and the derivatives at `places` of `shape`; others are zero.
    """
    count = len(inputs[0])
    residual, derivative = np.empty((count, shape[0])), np.zeros((count, *shape))
    for first in range(0, count, _ROWS_A_CALL):
        part = slice(first, first + _ROWS_A_CALL)
        columns = function(*(np.asfortranarray(rows[part]) for rows in inputs))
        for i, value in enumerate(columns[: shape[0]]):
            residual[part, i] = value
        for (i, unknown), value in zip(places, columns[shape[0] :], strict=True):
            derivative[part, i, unknown] = value
    return residual, derivative


_ITERATIONS = 30
_SETTLED = 0.1  # of its own deviation, the most that an unknown still moves
_CAUCHY = 16.8  # χ² with six degrees of freedom exceeds it in one of a hundred poses
_MEDIAN_CHI2 = 2.366  # median of χ² with three degrees of freedom
_SMALLEST_SIGMA = 1e-6
_LEAST_LEFT = 1e-3
_FASTEST = 100.0  # most that a variance may grow or shrink in one step
# Preintegration over a single step is rank deficient; far below any sensor's noise.
_JITTER = np.repeat([1e-9, 1e-8, 1e-8, 1e-10, 1e-10], 3) ** 2
_ROWS_AT_ONCE = 256  # of products of intervals, which a processor's cache then holds
# How the shared unknowns stand in a row.
OFFSET, ROTATION, LEVER = slice(0, 1), slice(1, 4), slice(4, 7)
GRAVITY, SCALE = slice(7, 10), slice(10, 11)


@dataclass(frozen=True, eq=False)
class Shared:
    """Unknowns that belong to the recording.

    Fields:
        offset_s: IMU's clock minus the camera's.
        imu_T_camera: the extrinsics.
        gravity_m_s2: ``(3,)`` in the camera's world.
        scale: metres a unit of the camera's world.
    """

    offset_s: float
    imu_T_camera: Motor
    gravity_m_s2: FloatArray
    scale: float = 1.0


@dataclass(frozen=True)
class Beliefs:
    """Deviations of what is known beforehand; 0 holds an unknown where it starts."""

    offset_s: float
    rotation_rad: float
    lever_m: float
    gravity_m_s2: float
    log_scale: float

    @property
    def sigma(self) -> FloatArray:
        """``(11,)``; gravity's holds for its size alone."""
        values = [self.offset_s, self.rotation_rad, self.lever_m, self.gravity_m_s2]
        return np.append(np.repeat(values, [1, 3, 3, 3]), self.log_scale)


@dataclass(frozen=True, eq=False)
class Aligned:
    """Where the estimate stands, or has ended.

    Fields:
        shared: unknowns of the recording.
        covariance: ``(11, 11)`` of offset (s), extrinsics (right perturbation: rotation in rad,
            lever in m, camera's axes), gravity (m/s²) and logarithm of the scale; 0 where held.
        time_ns: ``(N,)`` on the camera's clock.
        world_T_imu: Motor ``(N,)``, in metres.
        velocity_m_s: ``(N, 3)``; bias: ``(N, 6)`` of gyroscope and accelerometer.
        sigma: rad and m, an axis, of the camera's poses.
        weight: ``(N,)`` of the poses, up to 1.
        noise: of the IMU, as found; at least what was stated.
    """

    shared: Shared
    covariance: FloatArray
    time_ns: IntArray
    world_T_imu: Motor
    velocity_m_s: FloatArray
    bias: FloatArray
    sigma: tuple[float, float]
    weight: FloatArray
    noise: ImuNoise

    @property
    def imu_ns(self) -> IntArray:
        """Stamps ``(N,)`` on the IMU's clock."""
        return self.time_ns + round(self.shared.offset_s * 1e9)


def align(
    camera: Trajectory,
    imu: ImuStream,
    noise: ImuNoise,
    start: Shared,
    beliefs: Beliefs,
    sigma: tuple[float, float] = (np.deg2rad(0.5), 0.01),
    *,
    adapt: bool = True,
) -> Aligned:
    """Estimate everything from `start` on.

    Args:
        camera: ``world_T_camera``; the IMU covers them with room to shift.
        imu: the stream.
        noise: its densities and walks.
        start: where to start.
        beliefs: what is known of `start`.
        sigma: the poses' noise, rad and m, an axis.
        adapt: take `sigma` for a first guess, and raise the IMU's noise where the residuals do.
            Both believe that the poses' errors are independent of each other.

    Raises:
        ValueError: poses that move off the IMU's span, motion that determines nothing, or no
            settling.
    """
    state = _first(camera, start, sigma, noise)
    free = beliefs.sigma > 0.0
    for iteration in range(_ITERATIONS):
        biases = state.bias[:-1, :3], state.bias[:-1, 3:]
        summed = preintegrate(imu, state.imu_ns, state.noise, *biases)
        rate = imu.at(state.imu_ns).angular_rate_rad_s
        intervals = _Intervals.of(state, summed)
        poses = _white_poses(state, camera, rate)
        solved = _equations(state, poses, intervals, start, beliefs).solve(free)
        state = _stepped(state, solved, rate)
        if iteration and adapt:
            left = _left_over(poses, solved)
            grown = intervals.excess(solved)
            state = replace(
                state,
                sigma=_found_sigma(state, camera, left),
                noise=_at_least(noise, state.noise, grown),
            )
        if iteration:
            state = replace(state, weight=_weights(state, camera))
        sigmas = np.sqrt(np.diag(solved.covariance))
        if iteration > 2 and np.all(np.abs(solved.shared) <= _SETTLED * sigmas):
            return replace(state, covariance=solved.covariance)
    doubt = "" if beliefs.rotation_rad > 0.0 else "; is imu_T_camera the right one?"
    raise ValueError(
        f"camera and imu: expected an estimate that settles, got none in {_ITERATIONS} steps{doubt}"
    )


def _first(
    camera: Trajectory, start: Shared, sigma: tuple[float, float], noise: ImuNoise
) -> Aligned:
    """States at the measured poses, at rest."""
    count, covariance = len(camera), np.zeros((11, 11))
    poses = _in_metres(camera, start.scale) @ start.imu_T_camera.inverse()
    rest = np.zeros((count, 3)), np.zeros((count, 6))
    return Aligned(start, covariance, camera.time_ns, poses, *rest, sigma, np.ones(count), noise)


def _in_metres(camera: Trajectory, scale: float) -> Motor:
    motors = camera.motors
    return Motor.from_rotor_translation(motors.rotor, scale * motors.translation_m)


def _equations(
    state: Aligned,
    poses: tuple[FloatArray, ...],
    intervals: _Intervals,
    start: Shared,
    beliefs: Beliefs,
) -> Bordered:
    equations = Bordered(len(state.time_ns), 15, 11)
    equations.add_states(*poses)
    intervals.add_to(equations)
    biases = np.repeat([GYRO_BIAS_SIGMA_RAD_S, ACCEL_BIAS_SIGMA_M_S2], 3)
    equations.add_prior(0, slice(9, 15), state.bias[0], biases)
    _add_beliefs(equations, state.shared, start, beliefs)
    return equations


def _twists(state: Aligned, rate: FloatArray) -> FloatArray:
    own = state.world_T_imu.rotor.inverse().apply(state.velocity_m_s)
    return np.concatenate([rate - state.bias[:, :3], own], axis=-1)


def _white_poses(
    state: Aligned, camera: Trajectory, rate: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Residuals ``(N, 6)`` of the poses in deviations, derivatives by states and what is shared."""
    extrinsics = state.shared.imu_T_camera.coefficients
    measured = _in_metres(camera, state.shared.scale).coefficients
    residual, slope = pose_residuals(
        state.world_T_imu.coefficients, _twists(state, rate), extrinsics, measured
    )
    root = np.sqrt(state.weight)[:, None] / np.repeat(state.sigma, 3)
    residual, slope = root * residual, root[..., None] * slope
    own, shared = np.zeros((*residual.shape, 15)), np.zeros((*residual.shape, 11))
    own[..., :6] = slope[..., :6]
    shared[..., OFFSET.start : LEVER.stop] = slope[..., 6:13]
    shared[..., SCALE] = slope[..., 13:]
    return residual, own, shared


def _left_over(poses: tuple[FloatArray, ...], solved: Solved) -> FloatArray:
    """What share of the noise of rotations and of positions the estimate leaves in residuals."""
    _, own, shared = poses
    taken = np.einsum("kii->ki", solved.state_covariance(own, shared)).reshape(-1, 2, 3)
    left: FloatArray = np.maximum(1.0 - taken.mean(axis=(0, 2)), _LEAST_LEFT)
    return left


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Residuals ``(N - 1, 15)`` of all intervals, derivatives by both ends and what is shared."""

    residual: FloatArray
    start: FloatArray
    end: FloatArray
    shared: FloatArray
    covariance: FloatArray

    @classmethod
    def of(cls, state: Aligned, summed: Preintegrated) -> _Intervals:
        poses, velocity = state.world_T_imu.coefficients, state.velocity_m_s
        residual, slope = interval_residuals(
            (poses[:-1], poses[1:]),
            (velocity[:-1], velocity[1:]),
            np.diff(state.bias, axis=0),
            state.shared.gravity_m_s2,
            summed.motion.coefficients.reshape(-1, 16),
            summed.bias_jacobian,
            summed.duration_s,
        )
        shared = np.zeros((*residual.shape, 11))
        shared[..., GRAVITY] = slope[..., 30:]
        covariance = summed.covariance + np.diag(_JITTER)
        return cls(residual, slope[..., :15], slope[..., 15:30], shared, covariance)

    def add_to(self, equations: Bordered) -> None:
        for first in range(0, len(self.residual), _ROWS_AT_ONCE):
            rows = slice(first, first + _ROWS_AT_ONCE)
            root = np.linalg.inv(np.linalg.cholesky(self.covariance[rows]))
            slopes = self.start[rows], self.end[rows], self.shared[rows]
            residual = (root @ self.residual[rows, :, None])[..., 0]
            equations.add_intervals(first, residual, *(root @ slope for slope in slopes))

    def excess(self, solved: Solved) -> FloatArray:
        """Variances, in the order of `ImuNoise`, over those that were assumed.

        What is left after the step, over what should be left: the residuals' own part of their
        covariance, without what the unknowns took of them (Förstner 1979).
        """
        step, known = solved.states[..., None], self.covariance
        stepped = self.start @ step[:-1] + self.end @ step[1:]
        left = self.residual[..., None] + stepped + self.shared @ solved.shared[:, None]
        expected = known - solved.interval_covariance(self.start, self.end, self.shared)
        ratios = []
        for first in (0, 9, 6, 12):  # rows that this noise rules: turn, velocity, biases
            rows = slice(first, first + 3)
            inverse = np.linalg.inv(known[:, rows, rows])
            misfit = np.sum(left[:, rows] * (inverse @ left[:, rows]))
            ratios.append(misfit / np.einsum("kij,kji->", inverse, expected[:, rows, rows]))
        return np.array(ratios)


def _at_least(stated: ImuNoise, now: ImuNoise, grown: FloatArray) -> ImuNoise:
    """The noise of the moment with its variances grown or shrunk, but never below the stated."""
    factors = np.sqrt(np.clip(grown, 1 / _FASTEST, _FASTEST))
    return ImuNoise(*np.maximum(astuple(stated), np.array(astuple(now)) * factors).tolist())


def _add_beliefs(equations: Bordered, now: Shared, start: Shared, beliefs: Beliefs) -> None:
    size = float(np.linalg.norm(now.gravity_m_s2))
    expected = float(np.linalg.norm(start.gravity_m_s2))
    extrinsics = start.imu_T_camera.local(now.imu_T_camera)
    later_s, growth = now.offset_s - start.offset_s, np.log(now.scale / start.scale)
    error = np.array([later_s, *extrinsics, size - expected, growth])
    slope = np.zeros((9, 11))
    slope[np.arange(7), np.arange(7)] = slope[8, 10] = 1.0
    slope[7, GRAVITY] = now.gravity_m_s2 / size
    sigma = beliefs.sigma[[0, 1, 2, 3, 4, 5, 6, 7, 10]]
    known = (sigma > 0.0) & np.isfinite(sigma)
    white = error[known] / sigma[known], slope[known] / sigma[known, None]
    equations.add_shared(white[0][None], white[1][None])


def _stepped(state: Aligned, solved: Solved, rate: FloatArray) -> Aligned:
    """All unknowns moved; a later offset takes the states along their paths."""
    step, shared = solved.states, state.shared
    later = float(solved.shared[0])
    poses = state.world_T_imu.retract(step[:, :6] + later * _twists(state, rate))
    return replace(
        state,
        shared=Shared(
            shared.offset_s + later,
            shared.imu_T_camera.retract(solved.shared[1:7]),
            shared.gravity_m_s2 + solved.shared[GRAVITY],
            shared.scale * float(np.exp(solved.shared[10])),
        ),
        world_T_imu=poses,
        velocity_m_s=state.velocity_m_s + step[:, 6:9],
        bias=state.bias + step[:, 9:],
    )


def _squares(state: Aligned, camera: Trajectory) -> FloatArray:
    """Squared errors ``(2, N)`` of the poses: rotation (rad²), position (m²)."""
    expected = state.world_T_imu @ state.shared.imu_T_camera
    apart = (_in_metres(camera, state.shared.scale).inverse() @ expected).as_twist()
    return np.stack([np.sum(apart[:, part] ** 2, axis=-1) for part in (slice(3), slice(3, 6))])


def _found_sigma(state: Aligned, camera: Trajectory, left: FloatArray) -> tuple[float, float]:
    """The poses' noise from the residuals' medians."""
    variance = np.median(_squares(state, camera), axis=-1) / _MEDIAN_CHI2 / left
    turn, shift = np.sqrt(np.maximum(variance, _SMALLEST_SIGMA**2))
    return float(turn), float(shift)


def _weights(state: Aligned, camera: Trajectory) -> FloatArray:
    chi2 = np.sum(_squares(state, camera) / np.square(state.sigma)[:, None], axis=0)
    weights: FloatArray = 1.0 / (1.0 + chi2 / _CAUCHY)
    return weights
