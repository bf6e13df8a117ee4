"""Kinds that measure where a point of the body is: satellite navigation, beacons, altimeters."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.measurements.geodesy import GeodeticOrigin
from motorcade.fusion.measurements.interface import (
    ERROR_NUMBERS,
    POSITION,
    ROTATION,
    Measurements,
    PredictedState,
    skew,
)
from motorcade.fusion.measurements.values import (
    checked_rows,
    checked_stamps,
    checked_vector,
    spread,
)
from motorcade.ga.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class PositionMeasurements(Measurements):
    """Places in the world of a point on the body: an antenna, a prism, an ultra-wideband tag.

    Args:
        time_ns: ``(N,)`` of the IMU's clock.
        position_m: ``(N, 3)`` in the world.
        covariance: ``(3, 3)`` or ``(N, 3, 3)`` in the world's axes.
        arm_m: ``(3,)`` the point from the IMU, in the IMU's axes (lever arm).

    Raises:
        ValueError: shapes that do not agree, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements import PositionMeasurements, PredictedState
        >>> from motorcade.ga import Motor
        >>> seen = PositionMeasurements(
        ...     time_ns=np.array([0]), position_m=[[1.0, 0.0, 2.0]], covariance=0.01 * np.eye(3),
        ...     arm_m=[0.0, 0.0, 1.5],  # the antenna on its mast
        ... )
        >>> seen.residual(0, PredictedState.at(Motor.identity(), np.zeros(3)))
        array([1. , 0. , 0.5])
    """

    name: ClassVar[str] = "position"
    time_ns: IntArray
    position_m: FloatArray
    covariance: FloatArray
    arm_m: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        stamps = checked_stamps(self.time_ns, "time_ns")
        count = len(stamps)
        for name, value in (
            ("time_ns", stamps),
            ("position_m", checked_rows(self.position_m, "position_m", count, (3,))),
            ("covariance", spread(self.covariance, "covariance", count, 3)),
            ("arm_m", checked_vector(self.arm_m, "arm_m")),
        ):
            object.__setattr__(self, name, value)

    @classmethod
    def from_geodetic(
        cls,
        time_ns: IntArray,
        latitude_deg: ArrayLike,
        longitude_deg: ArrayLike,
        height_m: ArrayLike,
        covariance: ArrayLike,
        origin: GeodeticOrigin,
        arm_m: ArrayLike = (0.0, 0.0, 0.0),
    ) -> PositionMeasurements:
        """Of satellite navigation, in a world whose x points east, y north and z up at `origin`.

        Args:
            time_ns: ``(N,)`` of the IMU's clock, not of the satellites'.
            latitude_deg: ``(N,)`` on WGS 84.
            longitude_deg: likewise.
            height_m: likewise, above its ellipsoid.
            covariance: ``(3, 3)`` or ``(N, 3, 3)``: east, north, up.
            origin: where the world's origin is.
            arm_m: the antenna from the IMU.

        Raises:
            ValueError: latitudes beyond ±90°, shapes that do not agree, NaN or infinity.
            ModuleNotFoundError: without pyproj.
        """
        stamps = checked_stamps(time_ns, "time_ns")
        position_m = origin.local_m(latitude_deg, longitude_deg, height_m)
        own = spread(covariance, "covariance", len(stamps), 3)
        return cls(
            time_ns=stamps,
            position_m=position_m,
            covariance=own,
            arm_m=checked_vector(arm_m, "arm_m"),
        )

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted place ``(3,)``, in the world's axes."""
        seen: FloatArray = self.position_m[row] - state.position_m - state.world_R_imu @ self.arm_m
        return seen

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(3, 30)`` of that."""
        made = np.zeros((3, ERROR_NUMBERS))
        made[:, ROTATION] = state.world_R_imu @ skew(self.arm_m)
        made[:, POSITION] = -state.world_R_imu
        return made


@dataclass(frozen=True, eq=False, kw_only=True)
class AltitudeMeasurements(Measurements):
    """Heights of a point on the body above the world's z = 0: barometer, altimeter, a level floor.

    Args:
        time_ns: ``(N,)`` of the IMU's clock.
        altitude_m: ``(N,)``.
        covariance: variance (m²): one, ``(N,)`` or ``(N, 1, 1)``.
        arm_m: ``(3,)`` the point from the IMU, in the IMU's axes.

    Raises:
        ValueError: shapes that do not agree, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements import AltitudeMeasurements, PredictedState
        >>> from motorcade.ga import Motor
        >>> seen = AltitudeMeasurements(
        ...     time_ns=np.array([0]), altitude_m=[2.0], covariance=0.01
        ... )
        >>> state = PredictedState.at(Motor.from_translation([9.0, 9.0, 1.5]), np.zeros(3))
        >>> seen.residual(0, state)
        array([0.5])
    """

    name: ClassVar[str] = "altitude"
    time_ns: IntArray
    altitude_m: FloatArray
    covariance: FloatArray
    arm_m: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        stamps = checked_stamps(self.time_ns, "time_ns")
        for name, value in (
            ("time_ns", stamps),
            ("altitude_m", checked_rows(self.altitude_m, "altitude_m", len(stamps), ())),
            ("covariance", spread(self.covariance, "covariance", len(stamps), 1)),
            ("arm_m", checked_vector(self.arm_m, "arm_m")),
        ):
            object.__setattr__(self, name, value)

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted height ``(1,)``."""
        height = state.position_m[2] + state.world_R_imu[2] @ self.arm_m
        return np.array([self.altitude_m[row] - height])

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(1, 30)`` of that."""
        made = np.zeros((1, ERROR_NUMBERS))
        made[0, ROTATION] = state.world_R_imu[2] @ skew(self.arm_m)
        made[0, POSITION] = -state.world_R_imu[2]
        return made
