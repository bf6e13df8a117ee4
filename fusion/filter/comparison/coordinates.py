"""Error coordinates: how the difference of two states is written as 15 numbers.

Each way comes with its own `retract` and `local`, and with the matrix from errors of the filter on
motors, which stand in the moving frame, to it. All numbers come in the same order:
rotation (rad), position (m), velocity (m/s), gyroscope bias, accelerometer bias. All arrays have
the runs in front.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.fusion.filter.extended_pose import ERROR_SIZE, corrected, extended_pose
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.ga.classical import euler_rates_from_body, nearest_branch


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
