"""Kinds that measure how the body is turned: headings, and the magnetic field."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from motorcade.fusion.measurements.interface import (
    ERROR_NUMBERS,
    ROTATION,
    Measurements,
    PredictedState,
    skew,
)
from motorcade.fusion.measurements.values import set_checked
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray, frozen


@dataclass(frozen=True, eq=False, kw_only=True)
class HeadingMeasurements(Measurements):
    """Directions in the world's horizontal plane of an axis of the body: compass, two antennas.

    It breaks down where the axis stands upright, which has no heading.

    Args:
        time_ns: ``(N,)`` of the IMU's clock.
        heading_rad: ``(N,)`` from the world's x towards its y. A compass counts from north
            clockwise: with x east and y north that is ``pi/2 - heading``.
        covariance: variance (rad²): one, ``(N,)`` or ``(N, 1, 1)``.
        axis: ``(3,)`` the direction whose heading it is, in the IMU's axes.

    Raises:
        ValueError: shapes that do not agree, NaN or infinity, an axis of zero.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements import HeadingMeasurements, PredictedState
        >>> from motorcade.ga import Motor
        >>> seen = HeadingMeasurements(time_ns=np.array([0]), heading_rad=[3.1], covariance=0.01)
        >>> world_T_imu = Motor.from_twist([0.0, 0.0, -3.1, 0.0, 0.0, 0.0])
        >>> seen.residual(0, PredictedState.at(world_T_imu, np.zeros(3))).round(4)  # the short way
        array([-0.0832])
    """

    name: ClassVar[str] = "heading"
    time_ns: IntArray
    heading_rad: FloatArray
    covariance: FloatArray
    axis: FloatArray = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))

    def __post_init__(self) -> None:
        set_checked(self, 1, ("axis",), heading_rad=())
        if not np.any(self.axis):
            raise ValueError("axis: expected a direction, got zero")
        object.__setattr__(self, "axis", frozen(self.axis / np.linalg.norm(self.axis)))

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted heading ``(1,)``, within ±π."""
        x, y, _ = state.world_R_imu @ self.axis
        return np.array([np.remainder(self.heading_rad[row] - np.arctan2(y, x) + np.pi, 2 * np.pi)
                         - np.pi])  # fmt: skip

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(1, 30)`` of that."""
        jacobian = np.zeros((1, ERROR_NUMBERS))
        x, y, _ = state.world_R_imu @ self.axis
        turned = state.world_R_imu @ skew(self.axis)
        jacobian[0, ROTATION] = (x * turned[1] - y * turned[0]) / (x * x + y * y)
        return jacobian


@dataclass(frozen=True, eq=False, kw_only=True)
class MagneticFieldMeasurements(Measurements):
    """The magnetic field by a magnetometer whose own offsets and scales were taken off.

    Args:
        time_ns: ``(N,)`` of the IMU's clock.
        measured_field: ``(N, 3)`` in the sensor's axes, in any unit.
        world_field: ``(3,)`` what it is in the world's axes, in the same unit.
        covariance: ``(3, 3)`` or ``(N, 3, 3)`` in the sensor's axes.
        imu_R_sensor: turns the sensor's axes to the IMU's.

    Raises:
        ValueError: shapes that do not agree, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements import MagneticFieldMeasurements, PredictedState
        >>> from motorcade.ga import Motor
        >>> seen = MagneticFieldMeasurements(
        ...     time_ns=np.array([0]), measured_field=[[0.0, 20.0, -43.0]],
        ...     world_field=[0.0, 20.0, -43.0], covariance=np.eye(3),
        ... )
        >>> seen.residual(0, PredictedState.at(Motor.identity(), np.zeros(3)))
        array([0., 0., 0.])
    """

    name: ClassVar[str] = "magnetic_field"
    time_ns: IntArray
    measured_field: FloatArray
    world_field: FloatArray
    covariance: FloatArray
    imu_R_sensor: Rotor = field(default_factory=Rotor.identity)

    def __post_init__(self) -> None:
        if self.imu_R_sensor.shape != ():
            raise ValueError(f"imu_R_sensor: expected one rotor, got {self.imu_R_sensor.shape}")
        set_checked(self, 3, ("world_field",), measured_field=(3,))

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted field ``(3,)``, in the sensor's axes."""
        own = self.imu_R_sensor.as_matrix().T @ (self.world_field @ state.world_R_imu)
        seen: FloatArray = self.measured_field[row] - own
        return seen

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(3, 30)`` of that."""
        jacobian = np.zeros((3, ERROR_NUMBERS))
        turned = skew(self.world_field @ state.world_R_imu)
        jacobian[:, ROTATION] = -self.imu_R_sensor.as_matrix().T @ turned
        return jacobian
