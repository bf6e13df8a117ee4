"""Kinds that measure poses: of a body that carries the IMU, and from one moment to another."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.measurements.interface import (
    EARLIER,
    ERROR_NUMBERS,
    Measurements,
    PredictedState,
    checked_stamps,
    set_checked,
    spread,
)
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray


def _checked_poses(poses: Motor, name: str, count: int, body: Motor) -> None:
    if poses.shape != (count,):
        raise ValueError(f"{name}: expected {(count,)} motors, got {poses.shape}")
    if body.shape != ():
        raise ValueError(f"imu_T_body: expected one motor, got {body.shape}")


@dataclass(frozen=True, eq=False, kw_only=True)
class BodyPoseMeasurements(Measurements):
    """Poses of a body fixed to the IMU, as of motion capture or of a second tracker.

    Args:
        time_ns: ``(N,)`` of the IMU's clock.
        world_T_body: Motor ``(N,)``.
        covariance: ``(6, 6)`` or ``(N, 6, 6)`` of the right perturbation, in the body's axes,
            rotation (rad) first.
        imu_T_body: where the body's frame is on the IMU.

    Raises:
        ValueError: shapes that do not agree.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements import BodyPoseMeasurements, PredictedState
        >>> from motorcade.ga import Motor
        >>> imu_T_body = Motor.from_translation([0.1, 0.0, 0.0])
        >>> seen = BodyPoseMeasurements(
        ...     time_ns=np.array([0]), world_T_body=Motor.identity((1,)), covariance=np.eye(6),
        ...     imu_T_body=imu_T_body,
        ... )
        >>> seen.residual(0, PredictedState.at(imu_T_body.inverse(), np.zeros(3))) + 0.0
        array([0., 0., 0., 0., 0., 0.])
    """

    name: ClassVar[str] = "pose"
    time_ns: IntArray
    world_T_body: Motor
    covariance: FloatArray
    imu_T_body: Motor = field(default_factory=Motor.identity)

    def __post_init__(self) -> None:
        count = set_checked(self, 6)
        _checked_poses(self.world_T_body, "world_T_body", count, self.imu_T_body)

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """The twist ``(6,)`` from the predicted pose to the measured one."""
        return (state.world_T_imu @ self.imu_T_body).local(self.world_T_body[row])

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(6, 30)`` of that."""
        jacobian = np.zeros((6, ERROR_NUMBERS))
        back = Motor.left_jacobian_inverse(self.residual(row, state))
        jacobian[:, :6] = -back @ self.imu_T_body.inverse().adjoint()
        return jacobian


@dataclass(frozen=True, eq=False, kw_only=True)
class RelativePoseMeasurements(Measurements):
    """How a body moved from earlier moments to later ones: odometry, or a scan matched to another.

    The filter keeps one earlier pose beside the state, with its covariance (stochastic cloning), so
    that nothing is approximated; steps must not overlap there: each starts where the last one
    ended, or later, or with it. The factor graph takes any.

    Args:
        earlier_ns, time_ns: ``(N,)`` of the IMU's clock, between which each step was measured.
        earlier_T_body: Motor ``(N,)``: the later pose of the body in its earlier frame.
        covariance: ``(6, 6)`` or ``(N, 6, 6)`` of the right perturbation, in the body's axes at
            the later moment, rotation (rad) first; steps err independently.
        imu_T_body: where the body's frame is on the IMU.

    Raises:
        ValueError: shapes that do not agree.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements import PredictedState, RelativePoseMeasurements
        >>> from motorcade.ga import Motor
        >>> step = Motor.from_translation([[0.0, 0.3, 0.0]])
        >>> moved = RelativePoseMeasurements(
        ...     earlier_ns=np.array([0]), time_ns=np.array([100]), earlier_T_body=step,
        ...     covariance=1e-4 * np.eye(6),
        ... )
        >>> state = PredictedState.at(Motor.identity(), np.zeros(3))  # which did not move
        >>> moved.residual(0, state) + 0.0
        array([0. , 0. , 0. , 0. , 0.3, 0. ])
    """

    name: ClassVar[str] = "relative_pose"
    earlier_ns: IntArray
    time_ns: IntArray
    earlier_T_body: Motor
    covariance: FloatArray
    imu_T_body: Motor = field(default_factory=Motor.identity)

    def __post_init__(self) -> None:
        count, earlier = set_checked(self, 6), checked_stamps(self.earlier_ns, "earlier_ns")
        if earlier.shape != (count,):
            raise ValueError(f"earlier_ns: expected shape {(count,)}, got {earlier.shape}")
        _checked_poses(self.earlier_T_body, "earlier_T_body", count, self.imu_T_body)
        object.__setattr__(self, "earlier_ns", earlier)

    @classmethod
    def along(
        cls, odometry: Trajectory, covariance: ArrayLike, imu_T_body: Motor | None = None
    ) -> RelativePoseMeasurements:
        """The steps of an odometry's path; its own frame and origin do not matter.

        Args:
            odometry: N + 1 poses of the body, in any world.
            covariance: ``(6, 6)`` or ``(N, 6, 6)`` of a step.
            imu_T_body: where the body's frame is on the IMU; by default its own.
        """
        path, stamps = odometry.motors, odometry.time_ns
        return cls(
            earlier_ns=stamps[:-1],
            time_ns=stamps[1:],
            earlier_T_body=path[:-1].inverse() @ path[1:],
            covariance=spread(covariance, "covariance", len(stamps) - 1, 6),
            imu_T_body=Motor.identity() if imu_T_body is None else imu_T_body,
        )

    @property
    def since_ns(self) -> IntArray:
        """The earlier moments."""
        return self.earlier_ns

    def _predicted(self, state: PredictedState) -> Motor:
        earlier, later = (
            pose @ self.imu_T_body for pose in (state.earlier_world_T_imu, state.world_T_imu)
        )
        return earlier.inverse() @ later

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """The twist ``(6,)`` from the predicted step to the measured one."""
        return self._predicted(state).local(self.earlier_T_body[row])

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(6, 30)`` of that."""
        jacobian = np.zeros((6, ERROR_NUMBERS))
        step, body = self._predicted(state), self.imu_T_body.inverse()
        back = Motor.left_jacobian_inverse(step.local(self.earlier_T_body[row]))
        jacobian[:, :6] = -back @ body.adjoint()
        jacobian[:, EARLIER] = back @ (step.inverse() @ body).adjoint()
        return jacobian
