"""The same filter with its error written in other coordinates, for `motorcade consistency`.

Many runs of one experiment go at once. Motion, noise and measurements are those of `fusion.filter`;
what differs is how an error of the state is written as 15 numbers, so what a correction does and
what the covariance means. Between measurements errors are propagated in the moving frame, as by the
filter on motors, and changed to the coordinates and back at the ends: by the chain rule that is the
linearisation of the motion in those coordinates. The gate is the filter's, but for one thing: after
five measurements left out in a row the next one is believed and the prediction doubted, without
looking back at where that would have been right.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter import FilterSettings
from motorcade.fusion.filter.extended_pose import (
    ERROR_SIZE,
    corrected,
    extended_pose,
    increments,
    process_noise,
)
from motorcade.fusion.filter.settings import MOST_NOISE, VELOCITY_SIGMA_M_S
from motorcade.fusion.imu.noise import (
    ACCEL_BIAS_SIGMA_M_S2,
    GYRO_BIAS_SIGMA_RAD_S,
    ImuNoise,
)
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.classical import euler_rates_from_body, nearest_branch
from motorcade.tracking.measurements import PoseMeasurements


@dataclass(frozen=True, eq=False)
class Runs:
    """What R runs of one experiment measured; all have the same stamps.

    Fields:
        time_ns: ``(N,)`` of the inertial samples.
        angular_rate_rad_s, specific_force_m_s2: ``(R, N, 3)``.
        nodes: ``(M,)`` rising indices of the samples at whose stamps a pose was measured.
        world_T_imu: the measured poses ``(R, M)``.
        covariance: ``(6, 6)`` of each, right perturbation, rotation (rad) first.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> path, rng = ContinuousPath.along(gimbal_crossing(), 1.0), np.random.default_rng(0)
        >>> recorded = []
        >>> for _ in range(3):
        ...     sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        ...     measured = simulate_camera_poses(sensor.path, 10.0, 0.01, 0.01, rng)
        ...     recorded.append((measured, sensor.stream))

        >>> from motorcade.fusion.filter.comparison import Runs
        >>> runs = Runs.of(recorded)
        >>> len(runs), runs.world_T_imu.shape
        (3, (3, 11))
    """

    time_ns: IntArray
    angular_rate_rad_s: FloatArray
    specific_force_m_s2: FloatArray
    nodes: IntArray
    world_T_imu: Motor
    covariance: FloatArray

    def __len__(self) -> int:
        return len(self.angular_rate_rad_s)

    @classmethod
    def of(cls, recorded: Sequence[tuple[PoseMeasurements, ImuStream]]) -> Runs:
        """Recordings as the filter on motors takes them, of the IMU's own pose.

        Raises:
            ValueError: stamps or covariances that differ, or poses at other stamps than samples'.
        """
        measured, streams = zip(*recorded, strict=True)
        time_ns, stamps = streams[0].time_ns, measured[0].trajectory.time_ns
        covariance = measured[0].covariance[0]
        for poses, stream in recorded:
            same = np.array_equal(stream.time_ns, time_ns) and np.array_equal(
                poses.trajectory.time_ns, stamps
            )
            if not same or np.any(poses.covariance != covariance):
                raise ValueError("recorded: expected the same stamps and covariances in all runs")
        if not np.all(np.isin(stamps, time_ns)):
            raise ValueError("recorded: expected poses at stamps of inertial samples")
        return cls(
            time_ns,
            np.stack([one.angular_rate_rad_s for one in streams]),
            np.stack([one.specific_force_m_s2 for one in streams]),
            np.searchsorted(time_ns, stamps).astype(np.int64),
            Motor.stack([one.trajectory.motors for one in measured]),
            covariance,
        )


@dataclass(frozen=True, eq=False)
class Estimates:
    """What R runs knew at the M measured stamps, after each measurement.

    Fields:
        state: ``(R, M)``.
        covariance: ``(R, M, 15, 15)`` in the error coordinates of the filter.
        nis: ``(R, M)`` normalised innovations squared, six degrees of freedom; NaN at the start.
        accepted: ``(R, M)`` false where a measurement was left out.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> path, rng = ContinuousPath.along(gimbal_crossing(), 1.0), np.random.default_rng(0)
        >>> recorded = []
        >>> for _ in range(3):
        ...     sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        ...     measured = simulate_camera_poses(sensor.path, 10.0, 0.01, 0.01, rng)
        ...     recorded.append((measured, sensor.stream))

        >>> from motorcade.fusion import FilterSettings
        >>> from motorcade.fusion.filter.comparison import ExtendedPoseErrors, Runs, filter_runs
        >>> settings = FilterSettings()
        >>> found = filter_runs(Runs.of(recorded), ADIS16448, ExtendedPoseErrors(), settings)
        >>> found.covariance.shape, bool(np.nanmean(found.nis) < 12.0)  # 6 where all is right
        ((3, 11, 15, 15), True)
    """

    state: RunStates
    covariance: FloatArray
    nis: FloatArray
    accepted: NDArray[np.bool_]


def filter_runs(
    runs: Runs, noise: ImuNoise, coordinates: ErrorCoordinates, settings: FilterSettings
) -> Estimates:
    """Filter every run from its first measurement to its last, each for itself.

    Args:
        runs: the data.
        noise: densities of the IMU.
        coordinates: of the error.
        settings: gravity, gate and initial tilt error, as of `fuse`.
    """
    state, covariance = _start(runs, coordinates, settings)
    gate = _Gate(settings, len(runs))
    states, covariances = [state], [covariance]
    nis = np.full((len(runs), len(runs.nodes)), np.nan)
    accepted = np.ones(nis.shape, dtype=np.bool_)
    for i in range(1, len(runs.nodes)):
        start, end = int(runs.nodes[i - 1]), int(runs.nodes[i])
        state, covariance = _predicted(
            runs, start, end, state, covariance, noise, coordinates, settings
        )
        state, covariance, nis[:, i], accepted[:, i] = _updated(
            state, covariance, runs.world_T_imu[:, i], runs.covariance, coordinates, gate
        )
        states.append(state)
        covariances.append(covariance)
    return Estimates(
        RunStates.stacked(states, axis=1), np.stack(covariances, axis=1), nis, accepted
    )


_PATIENCE = 5  # measurements left out in a row


class _Gate:
    """How far to believe a measurement, run by run."""

    def __init__(self, settings: FilterSettings, runs: int) -> None:
        self._limit = settings.gate_limit(6)
        self._left_out = np.zeros(runs, dtype=np.int64)

    def judge(self, nis: FloatArray, with_most: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Factors on the covariance (0: leave out), and where the prediction is doubted.

        From normalised squares by the measurements' own noise and by the most they may have.
        """
        noisy = (nis >= 0.5 * (1.0 + MOST_NOISE) * with_most) & (with_most <= self._limit)
        outlier = ~((nis <= self._limit) | noisy)
        self._left_out = np.where(outlier, self._left_out + 1, 0)
        doubted = self._left_out > _PATIENCE
        self._left_out[doubted] = 0
        factor = np.where(outlier, np.where(doubted, 1.0, 0.0), np.maximum(1.0, nis / self._limit))
        return factor, doubted


def _start(
    runs: Runs, coordinates: ErrorCoordinates, settings: FilterSettings
) -> tuple[RunStates, FloatArray]:
    """The first measurement as a state: at rest, biases zero, with room for both to be wrong."""
    count, pose, tilt = len(runs), runs.world_T_imu[:, 0], settings.initial_tilt_error_rad
    rotor = Rotor.from_rotation_vector([tilt, 0.0, 0.0]) @ pose.rotor
    state = RunStates(rotor, pose.translation_m, np.zeros((count, 3)), np.zeros((count, 6)))
    sigma = [0.0, 0.0, VELOCITY_SIGMA_M_S, GYRO_BIAS_SIGMA_RAD_S, ACCEL_BIAS_SIGMA_M_S2]
    body = np.tile(np.diag(np.repeat(sigma, 3) ** 2), (count, 1, 1))
    body[:, :6, :6] = runs.covariance
    level = rotor.as_matrix()[:, :2]
    body[:, :3, :3] += tilt**2 * level.swapaxes(-1, -2) @ level
    return state, _transformed(coordinates.from_body(state), body)


def _predicted(
    runs: Runs,
    start: int,
    end: int,
    state: RunStates,
    covariance: FloatArray,
    noise: ImuNoise,
    coordinates: ErrorCoordinates,
    settings: FilterSettings,
) -> tuple[RunStates, FloatArray]:
    """RunStates and covariance after the intervals between two samples."""
    dt_s = np.diff(runs.time_ns[start : end + 1]) * 1e-9
    rate, force = (
        0.5 * (values[:, start:end] + values[:, start + 1 : end + 1])
        for values in (runs.angular_rate_rad_s, runs.specific_force_m_s2)
    )
    turn_rad = (rate - state.bias[:, None, :3]) * dt_s[:, None]
    shape = rate.shape[:2]
    motion, matrices, _ = increments(
        np.arange(rate[..., 0].size),
        np.tile(dt_s, shape[0]),
        rate.reshape(-1, 3),
        force.reshape(-1, 3),
        np.repeat(state.bias, shape[1], axis=0),
        noise,
    )
    gained = motion.translation_m.reshape(*shape, 2, 3)
    matrices = matrices.reshape(*shape, *matrices.shape[1:])
    body = _transformed(np.linalg.inv(coordinates.from_body(state)), covariance)
    added = process_noise(dt_s, noise)
    fall = np.array([0.0, 0.0, -settings.gravity_m_s2])
    rotor, position, velocity = state.rotor, state.position_m, state.velocity_m_s
    for k, dt in enumerate(dt_s):
        body = _transformed(matrices[:, k], body) + added[k]
        position = position + velocity * dt + 0.5 * fall * dt**2 + rotor.apply(gained[:, k, 0])
        velocity = velocity + fall * dt + rotor.apply(gained[:, k, 1])
        rotor = coordinates.turned(rotor, turn_rad[:, k])
    after = RunStates(rotor, position, velocity, state.bias)
    return after, _transformed(coordinates.from_body(after), body)


def _updated(
    state: RunStates,
    covariance: FloatArray,
    measured: Motor,
    spread: FloatArray,
    coordinates: ErrorCoordinates,
    gate: _Gate,
) -> tuple[RunStates, FloatArray, FloatArray, NDArray[np.bool_]]:
    """Kalman's update with poses of the IMU, in Joseph's form; the matrix is the identity."""
    seen = RunStates(measured.rotor, measured.translation_m, state.velocity_m_s, state.bias)
    innovation = coordinates.local(state, seen)[:, :6]
    spread = coordinates.measurement_noise(state, spread)
    nis, with_most = (
        np.sum(innovation * _solved(covariance[:, :6, :6] + more * spread, innovation), axis=-1)
        for more in (1.0, MOST_NOISE)
    )
    factor, doubted = gate.judge(nis, with_most)
    believed = factor > 0.0
    if np.any(doubted):
        doubt = _transformed(coordinates.from_body(state), _doubt(state, seen))
        covariance = covariance + doubted[:, None, None] * doubt
    spread = spread * np.where(believed, factor, 1.0)[:, None, None]
    total = covariance[:, :6, :6] + spread
    gain = np.linalg.solve(total, covariance[:, :6]).swapaxes(-1, -2)
    gain = gain * believed[:, None, None]
    rest = np.tile(np.eye(ERROR_SIZE), (len(gain), 1, 1))
    rest[:, :, :6] -= gain
    covariance = _transformed(rest, covariance) + _transformed(gain, spread)
    correction = (gain @ innovation[..., None])[..., 0]
    covariance = 0.5 * (covariance + covariance.swapaxes(-1, -2))
    return coordinates.retract(state, correction), covariance, nis, believed


def _doubt(state: RunStates, seen: RunStates) -> FloatArray:
    """Covariance in the moving frame that makes room for an innovation, in velocity as well."""
    predicted, measured = (
        Motor.from_rotor_translation(states.rotor, states.position_m) for states in (state, seen)
    )
    innovation = predicted.local(measured) ** 2
    turn, shift = np.sum(innovation[:, :3], axis=-1), np.sum(innovation[:, 3:], axis=-1)
    nothing = np.zeros_like(turn)
    sizes = [turn, shift, shift + VELOCITY_SIGMA_M_S**2 / 100, nothing, nothing]
    return np.repeat(np.stack(sizes, axis=-1), 3, axis=-1)[:, None] * np.eye(ERROR_SIZE)


def _transformed(matrix: NDArray[Any], covariance: FloatArray) -> FloatArray:
    product: FloatArray = matrix @ covariance @ matrix.swapaxes(-1, -2)
    return product


def _solved(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.solve(matrix, vector[..., None])[..., 0], dtype=np.float64)


# Error coordinates: how the difference of two states is written as 15 numbers.
#
# Each way comes with its own `retract` and `local`, and with the matrix from errors of the filter
# on motors, which stand in the moving frame, to it. All numbers come in the same order: rotation
# (rad), position (m), velocity (m/s), gyroscope bias, accelerometer bias. All arrays have the runs
# in front.


@dataclass(frozen=True, eq=False)
class RunStates:
    """States of R runs: ``world_T_imu``, velocity in the world, biases of gyro and accelerometer.

    Fields:
        rotor: ``(R)``.
        position_m, velocity_m_s: ``(R, 3)``.
        bias: ``(R, 6)``, rad/s and m/s².

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.comparison import RunStates
        >>> from motorcade.ga import Rotor
        >>> zero = np.zeros((1, 3))
        >>> ahead = RunStates(Rotor.identity((1,)), zero + 1.0, zero, np.zeros((1, 6)))
        >>> turned = RunStates(Rotor.from_euler([[0.0, 0.0, 0.5]]), zero, zero, np.zeros((1, 6)))
        >>> RunStates.stacked([ahead, turned]).position_m.shape
        (2, 1, 3)
    """

    rotor: Rotor
    position_m: FloatArray
    velocity_m_s: FloatArray
    bias: FloatArray

    @classmethod
    def stacked(cls, states: Sequence[RunStates], axis: int = 0) -> RunStates:
        """States of one shape as one, with a further axis."""
        return cls(
            Rotor(np.stack([one.rotor.coefficients for one in states], axis)),
            np.stack([one.position_m for one in states], axis),
            np.stack([one.velocity_m_s for one in states], axis),
            np.stack([one.bias for one in states], axis),
        )


class ErrorCoordinates(ABC):
    """One way to write the error of a state.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.comparison import EulerErrors, RunStates
        >>> from motorcade.ga import Rotor
        >>> zero = np.zeros((1, 3))
        >>> ahead = RunStates(Rotor.identity((1,)), zero + 1.0, zero, np.zeros((1, 6)))
        >>> turned = RunStates(Rotor.from_euler([[0.0, 0.0, 0.5]]), zero, zero, np.zeros((1, 6)))
        >>> errors = EulerErrors()
        >>> back = errors.retract(turned, errors.local(turned, ahead))
        >>> back.position_m
        array([[1., 1., 1.]])
    """

    @abstractmethod
    def rotation_local(self, rotor: Rotor, other: Rotor) -> FloatArray:
        """What leads from orientations to others ``(R, 3)``."""

    @abstractmethod
    def rotation_retract(self, rotor: Rotor, error: FloatArray) -> Rotor:
        """Orientations plus errors ``(R, 3)``."""

    @abstractmethod
    def rotation_from_body(self, rotor: Rotor) -> FloatArray:
        """Matrices ``(R, 3, 3)`` from small turns in the moving frame to these coordinates."""

    def turned(self, rotor: Rotor, turn_rad: FloatArray) -> Rotor:
        """Orientations ``(R)`` after turns ``(R, 3)`` in the moving frame."""
        return rotor @ Rotor.from_rotation_vector(turn_rad)

    def measurement_noise(self, state: RunStates, covariance: FloatArray) -> FloatArray:
        """Covariances ``(R, 6, 6)`` of measured poses, given that of the right perturbation."""
        carrier = self.from_body(state)[..., :6, :6]
        noise: FloatArray = carrier @ covariance @ carrier.swapaxes(-1, -2)
        return noise

    def local(self, state: RunStates, other: RunStates) -> FloatArray:
        """The error ``(R, 15)`` that leads from a state to the other."""
        return np.concatenate(
            [
                self.rotation_local(state.rotor, other.rotor),
                other.position_m - state.position_m,
                other.velocity_m_s - state.velocity_m_s,
                other.bias - state.bias,
            ],
            axis=-1,
        )

    def retract(self, state: RunStates, error: FloatArray) -> RunStates:
        """The state an error ``(R, 15)`` away."""
        return RunStates(
            self.rotation_retract(state.rotor, error[..., :3]),
            state.position_m + error[..., 3:6],
            state.velocity_m_s + error[..., 6:9],
            state.bias + error[..., 9:],
        )

    def from_body(self, state: RunStates) -> FloatArray:
        """Matrices ``(R, 15, 15)`` from small errors on the right of an extended pose to these."""
        rotor = state.rotor
        matrices = np.tile(np.eye(ERROR_SIZE), (*rotor.shape, 1, 1))
        matrices[..., :3, :3] = self.rotation_from_body(rotor)
        matrices[..., 3:6, 3:6] = matrices[..., 6:9, 6:9] = rotor.as_matrix()
        return matrices


class QuaternionTranslationErrors(ErrorCoordinates):
    """The error-state filter as commonly written: turn in the moving frame, position in the world.

    Source: J. Solà, Quaternion kinematics for the error-state Kalman filter, arXiv:1711.02508,
    2017 (section 5, local angular errors), also known as the multiplicative filter.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.comparison import QuaternionTranslationErrors, RunStates
        >>> from motorcade.ga import Rotor
        >>> zero = np.zeros((1, 3))
        >>> ahead = RunStates(Rotor.identity((1,)), zero + 1.0, zero, np.zeros((1, 6)))
        >>> turned = RunStates(Rotor.from_euler([[0.0, 0.0, 0.5]]), zero, zero, np.zeros((1, 6)))
        >>> QuaternionTranslationErrors().local(turned, ahead)[:, :6].round(3) + 0.0  # rad, m
        array([[ 0. ,  0. , -0.5,  1. ,  1. ,  1. ]])
    """

    def rotation_local(self, rotor: Rotor, other: Rotor) -> FloatArray:
        """Rotation vectors ``(*, 3)`` in the moving frame."""
        return (rotor.inverse() @ other).as_rotation_vector()

    def rotation_retract(self, rotor: Rotor, error: FloatArray) -> Rotor:
        """``q Exp(error)``."""
        return rotor @ Rotor.from_rotation_vector(error)

    def rotation_from_body(self, rotor: Rotor) -> FloatArray:
        """The identity."""
        return np.tile(np.eye(3), (*rotor.shape, 1, 1))


class ExtendedPoseErrors(QuaternionTranslationErrors):
    """The filter's own: on the right of the pair of motors, position and velocity turning along.

    Orientations err as in the multiplicative filter.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.comparison import ExtendedPoseErrors, RunStates
        >>> from motorcade.ga import Rotor
        >>> zero = np.zeros((1, 3))
        >>> ahead = RunStates(Rotor.identity((1,)), zero + 1.0, zero, np.zeros((1, 6)))
        >>> turned = RunStates(Rotor.from_euler([[0.0, 0.0, 0.5]]), zero, zero, np.zeros((1, 6)))
        >>> ExtendedPoseErrors().local(turned, ahead)[:, :6].round(3) + 0.0  # rad, m
        array([[ 0.   ,  0.   , -0.5  ,  1.229,  0.729,  1.   ]])
    """

    def local(self, state: RunStates, other: RunStates) -> FloatArray:
        """Logarithms of one extended pose seen from the other, and the biases' differences."""
        ours, theirs = (
            extended_pose(states.rotor, states.position_m, states.velocity_m_s)
            for states in (state, other)
        )
        twists = ours.local(theirs)
        return np.concatenate(
            [twists[..., 0, :], twists[..., 1, 3:], other.bias - state.bias], axis=-1
        )

    def retract(self, state: RunStates, error: FloatArray) -> RunStates:
        """The extended pose times the exponential of the error."""
        pose = corrected(extended_pose(state.rotor, state.position_m, state.velocity_m_s), error)
        position, velocity = np.moveaxis(pose.translation_m, -2, 0)
        return RunStates(pose[..., 0].rotor, position, velocity, state.bias + error[..., 9:])

    def from_body(self, state: RunStates) -> FloatArray:
        """The identity."""
        return np.tile(np.eye(ERROR_SIZE), (*state.rotor.shape, 1, 1))


class ExactEulerErrors(ErrorCoordinates):
    """Three angles, intrinsic x-y′-z″, added and subtracted one by one; all else converted exactly.

    Differences are wrapped to [-π, π]. Motion is composed as rotations, and the noise of a measured
    orientation is converted to that of angles where the estimate stands. Breaks down at gimbal
    lock, where a middle angle of ±π/2 divides by zero.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.comparison import ExactEulerErrors, RunStates
        >>> from motorcade.ga import Rotor
        >>> zero = np.zeros((1, 3))
        >>> ahead = RunStates(Rotor.identity((1,)), zero + 1.0, zero, np.zeros((1, 6)))
        >>> turned = RunStates(Rotor.from_euler([[0.0, 0.0, 0.5]]), zero, zero, np.zeros((1, 6)))
        >>> ExactEulerErrors().local(turned, ahead)[:, :6].round(3) + 0.0  # rad, m
        array([[ 0. ,  0. , -0.5,  1. ,  1. ,  1. ]])
    """

    def rotation_local(self, rotor: Rotor, other: Rotor) -> FloatArray:
        """Differences of the angles ``(*, 3)``."""
        return nearest_branch(other.as_euler() - rotor.as_euler(), 0.0)

    def rotation_retract(self, rotor: Rotor, error: FloatArray) -> Rotor:
        """Angles plus errors."""
        return Rotor.from_euler(rotor.as_euler() + error)

    def rotation_from_body(self, rotor: Rotor) -> FloatArray:
        """Rates of the angles for angular rates in the moving frame."""
        return euler_rates_from_body(rotor.as_euler())


class EulerErrors(ExactEulerErrors):
    """The extended Kalman filter on Euler angles as practitioners write it.

    Angles are integrated by their rates, one Euler step a sample, and a measured orientation is
    three angles with the noise that its covariance states, taken as that of the angles.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.comparison import EulerErrors, RunStates
        >>> from motorcade.ga import Rotor
        >>> zero = np.zeros((1, 3))
        >>> ahead = RunStates(Rotor.identity((1,)), zero + 1.0, zero, np.zeros((1, 6)))
        >>> turned = RunStates(Rotor.from_euler([[0.0, 0.0, 0.5]]), zero, zero, np.zeros((1, 6)))
        >>> EulerErrors().local(turned, ahead)[:, :6].round(3) + 0.0  # rad, m
        array([[ 0. ,  0. , -0.5,  1. ,  1. ,  1. ]])
    """

    def turned(self, rotor: Rotor, turn_rad: FloatArray) -> Rotor:
        """Angles plus their rates times the interval."""
        rates = self.rotation_from_body(rotor) @ turn_rad[..., None]
        return Rotor.from_euler(rotor.as_euler() + rates[..., 0])

    def measurement_noise(self, state: RunStates, covariance: FloatArray) -> FloatArray:
        """The turn's covariance as it is; the position's in the world."""
        carrier = self.from_body(state)[..., :6, :6]
        carrier[..., :3, :3] = np.eye(3)
        noise: FloatArray = carrier @ covariance @ carrier.swapaxes(-1, -2)
        return noise
