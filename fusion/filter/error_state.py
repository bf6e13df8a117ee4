"""The forward pass: camera poses fused with an IMU by an invariant error-state Kalman filter.

State: pose ``world_T_imu``, velocity in the world, biases of gyroscope and accelerometer. Pose and
velocity are one extended pose, a pair of motors, and their error stands on its right, in the IMU's
own axes. Two things follow. The error moves as if the system were linear, whatever the estimate
is, so a start that is degrees wrong (in tilt or in velocity) converges as one that is right; an
error split into angles and world coordinates would be linearised at the wrong place. And a camera
pose, whose covariance is that of a right perturbation, observes this error directly: the
measurement matrix is the identity and no Jacobian depends on the estimate. Invariance on the left
of the estimate would suit landmarks of the world instead (Barrau and Bonnabel, see `increments`).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.extended_pose import ERROR_SIZE, corrected, extended_pose, skew
from motorcade.fusion.filter.increments import (
    Intervals,
    advance,
    increments,
    intervals,
    process_noise,
    transitions,
)
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import FloatArray, IntArray, Motor, Rotor
from motorcade.tracking.measurements import PoseMeasurements

__all__ = ["FilterSettings", "Forward", "filter_forwards", "motor_adjoint"]

_GYRO_BIAS_SIGMA_RAD_S = 0.1
_ACCEL_BIAS_SIGMA_M_S2 = 0.5
# Wide on purpose: the error's dynamics do not depend on the velocity, so it costs nothing.
_VELOCITY_SIGMA_M_S = 20.0
# Innovations up to so many times the gate are weighed down, larger ones left out.
_GROSS = 10.0
_CONSECUTIVE_REJECTIONS = 5


@dataclass(frozen=True)
class FilterSettings:
    """What the filter assumes beyond its data.

    Fields:
        gravity_m_s2: size of gravity, which pulls along -z of the world.
        gate: probability that a good measurement passes the χ² test (1 switches it off).
            A measurement beyond it is weighed down so that its pull stays that of one at the
            gate; one ten times beyond it is left out. After five left out in a row the next is
            believed, and the prediction doubted.
        initial_tilt_error_rad: turn the first orientation by this much about the world's x, and
            start with that uncertainty, to watch the filter converge.

    Raises:
        ValueError: gravity not above zero, a gate outside (0, 1], a tilt that is not finite.
    """

    gravity_m_s2: float = 9.81
    gate: float = 0.9999
    initial_tilt_error_rad: float = 0.0

    def __post_init__(self) -> None:
        for name, good, expected in (
            ("gravity_m_s2", 0.0 < self.gravity_m_s2 < np.inf, "a number above 0"),
            ("gate", 0.0 < self.gate <= 1.0, "a probability above 0 and up to 1"),
            ("initial_tilt_error_rad", np.isfinite(self.initial_tilt_error_rad), "a finite angle"),
        ):
            if not good:
                raise ValueError(
                    f"FilterSettings.{name}: expected {expected}, got {getattr(self, name)}"
                )


@dataclass(frozen=True, eq=False)
class Forward:
    """What the forward pass knew at each of N stamps, after the measurement there if any.

    Filled in place while the filter runs. `transition` belongs to the step that leads to the stamp
    (the first is unused); `correction` and `doubt` hold, by stamp, the error that a measurement
    took off and the covariance added where the prediction was doubted.
    """

    time_ns: IntArray
    rotor: FloatArray
    position_m: FloatArray
    velocity_m_s: FloatArray
    bias: FloatArray
    covariance: FloatArray
    transition: FloatArray
    noise: ImuNoise
    nis: FloatArray
    accepted: NDArray[np.bool_]
    correction: dict[int, FloatArray] = field(default_factory=dict)
    doubt: dict[int, FloatArray] = field(default_factory=dict)

    @classmethod
    def empty(cls, time_ns: IntArray, noise: ImuNoise) -> Forward:
        """Room for a run over `time_ns`."""
        n, square = len(time_ns), (ERROR_SIZE, ERROR_SIZE)
        return cls(
            time_ns, np.empty((n, 4)), np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 6)),
            np.empty((n, *square)), np.empty((n, *square)), noise,
            np.full(n, np.nan), np.ones(n, dtype=np.bool_),
        )  # fmt: skip

    def added(self, start: int, end: int) -> FloatArray:
        """Covariances that inertial noise adds in the steps from stamp `start` to stamp `end`."""
        return process_noise(np.diff(self.time_ns[start : end + 1]) * 1e-9, self.noise)

    def extended(self, index: int | slice) -> Motor:
        """Extended poses at one or several stamps."""
        return extended_pose(
            Rotor(self.rotor[index]), self.position_m[index], self.velocity_m_s[index]
        )

    def set_extended(self, index: int, pose: Motor) -> None:
        """Write an extended pose down."""
        self.rotor[index] = pose[0].rotor.coefficients
        self.position_m[index], self.velocity_m_s[index] = pose.translation_m


def filter_forwards(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray,
    settings: FilterSettings,
) -> Forward:
    """Run over `stamps_ns`: rising, from the first measurement on, with every measured one."""
    data = intervals(imu, stamps_ns)
    run = Forward.empty(stamps_ns, noise)
    camera_T_imu = imu_T_camera.inverse()
    measured = measurements.trajectory.motors @ camera_T_imu
    adjoint = motor_adjoint(imu_T_camera)
    spread = adjoint @ measurements.covariance @ adjoint.T
    _start(run, measured[0], spread[0], settings)
    nodes = np.searchsorted(stamps_ns, measurements.trajectory.time_ns)
    gate = _Gate(settings.gate)
    for i in range(1, len(nodes)):
        _predict(run, int(nodes[i - 1]), int(nodes[i]), data, settings.gravity_m_s2)
        _update(run, int(nodes[i]), measured[i], spread[i], gate)
    _predict(run, int(nodes[-1]), len(stamps_ns) - 1, data, settings.gravity_m_s2)
    return run


def motor_adjoint(motor: Motor) -> FloatArray:
    """Adjoint ``(6, 6)`` on twists, rotation first: ``m Exp(ξ) = Exp(Ad ξ) m``."""
    rotation = motor.rotor.as_matrix()
    adjoint = np.zeros((6, 6))
    adjoint[:3, :3] = adjoint[3:, 3:] = rotation
    adjoint[3:, :3] = skew(motor.translation_m) @ rotation
    return adjoint


class _Gate:
    """How far to believe a measurement, by its normalised innovation squared."""

    def __init__(self, probability: float) -> None:
        from scipy.special import gammaincinv

        # χ² with 6 degrees of freedom is a gamma distribution of shape 3 and scale 2.
        self._limit = 2.0 * float(gammaincinv(3.0, probability))
        self._left_out = 0

    def judge(self, nis: float) -> tuple[float, bool]:
        """Factor on the measurement's covariance (0: leave it out), and whether the prediction
        is doubted instead.
        """
        if nis > _GROSS * self._limit:
            self._left_out += 1
            if self._left_out <= _CONSECUTIVE_REJECTIONS:
                return 0.0, False
            self._left_out = 0
            return 1.0, True
        self._left_out = 0
        return max(1.0, nis / self._limit), False


def _start(run: Forward, pose: Motor, spread: FloatArray, settings: FilterSettings) -> None:
    """The first measurement as a state: at rest, biases zero, with room for both to be wrong."""
    tilt = settings.initial_tilt_error_rad
    rotor = Rotor.from_rotation_vector([tilt, 0.0, 0.0]) @ pose.rotor
    run.rotor[0], run.position_m[0] = rotor.coefficients, pose.translation_m
    run.velocity_m_s[0] = run.bias[0] = 0.0
    sigma = [0.0, 0.0, _VELOCITY_SIGMA_M_S, _GYRO_BIAS_SIGMA_RAD_S, _ACCEL_BIAS_SIGMA_M_S2]
    covariance = np.diag(np.repeat(sigma, 3) ** 2)
    covariance[:6, :6] = spread
    level = rotor.as_matrix()[:2]  # the world's x and y in the IMU's axes
    covariance[:3, :3] += tilt**2 * level.T @ level
    run.covariance[0] = covariance


def _predict(run: Forward, start: int, end: int, data: Intervals, gravity_m_s2: float) -> None:
    """Fill the stamps after `start` up to `end` from inertial data alone."""
    if end == start:
        return
    bias = run.bias[start]
    steps = increments(data[start:end], bias[:3], bias[3:])
    after = slice(start + 1, end + 1)
    rotors, run.position_m[after], run.velocity_m_s[after] = advance(
        Rotor(run.rotor[start]), run.position_m[start], run.velocity_m_s[start], steps, gravity_m_s2
    )
    run.rotor[after], run.bias[after] = rotors.coefficients, bias
    run.transition[after] = transitions(steps)
    covariance = run.covariance[start]
    for k, added in enumerate(run.added(start, end), start + 1):
        matrix = run.transition[k]
        covariance = matrix @ covariance @ matrix.T + added
        run.covariance[k] = covariance


def _update(run: Forward, index: int, measured: Motor, spread: FloatArray, gate: _Gate) -> None:
    """Kalman's update with a pose of the IMU; the covariance in Joseph's form."""
    predicted, covariance = run.extended(index), run.covariance[index]
    innovation = (predicted[0].inverse() @ measured).as_twist()
    total = covariance[:6, :6] + spread
    nis = float(innovation @ np.linalg.solve(total, innovation))
    factor, doubted = gate.judge(nis)
    run.nis[index], run.accepted[index] = nis, factor > 0.0
    if factor == 0.0:
        return
    if doubted:
        run.doubt[index] = _doubt(innovation)
        covariance = covariance + run.doubt[index]
    spread = spread * factor
    gain = np.linalg.solve(covariance[:6, :6] + spread, covariance[:6]).T
    rest = np.eye(ERROR_SIZE)
    rest[:, :6] -= gain
    covariance = rest @ covariance @ rest.T + gain @ spread @ gain.T
    correction = gain @ innovation
    run.covariance[index] = 0.5 * (covariance + covariance.T)
    run.correction[index] = correction
    run.bias[index] += correction[9:]
    run.set_extended(index, corrected(predicted, correction))


def _doubt(innovation: FloatArray) -> FloatArray:
    """Covariance that makes room for an innovation, in the pose and as much again in velocity."""
    turn, shift = innovation[:3] @ innovation[:3], innovation[3:] @ innovation[3:]
    return np.diag(np.repeat([turn, shift, shift + _VELOCITY_SIGMA_M_S**2 / 100, 0.0, 0.0], 3))
