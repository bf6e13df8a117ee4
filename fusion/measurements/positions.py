"""Kinds that measure where a point of the body is, how it moves, and how the body is turned."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.measurements.interface import (
    Measurements,
    PredictedState,
    by_error,
    checked_rows,
    set_checked,
    skew,
)
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive, frozen


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
        >>> from motorcade.fusion.measurements import PositionMeasurements
        >>> from motorcade.fusion.measurements.interface import PredictedState
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
        set_checked(self, 3, ("arm_m",), position_m=(3,))

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
        return cls(
            time_ns=time_ns,
            position_m=origin.local_m(latitude_deg, longitude_deg, height_m),
            covariance=np.asarray(covariance),
            arm_m=np.asarray(arm_m),
        )

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted place ``(3,)``, in the world's axes."""
        seen: FloatArray = self.position_m[row] - state.position_m - state.world_R_imu @ self.arm_m
        return seen

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(3, 30)`` of that."""
        world_R_imu = state.world_R_imu
        return by_error(3, rotation=world_R_imu @ skew(self.arm_m), position=-world_R_imu)


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
        >>> from motorcade.fusion.measurements.positions import AltitudeMeasurements
        >>> from motorcade.fusion.measurements.interface import PredictedState
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
        set_checked(self, 1, ("arm_m",), altitude_m=())

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted height ``(1,)``."""
        height = state.position_m[2] + state.world_R_imu[2] @ self.arm_m
        return np.array([self.altitude_m[row] - height])

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(1, 30)`` of that."""
        up = state.world_R_imu[2]
        return by_error(1, rotation=up @ skew(self.arm_m), position=-up)


@dataclass(frozen=True, eq=False, kw_only=True)
class VelocityMeasurements(Measurements):
    """Velocities of a point on the body in the world: satellite navigation, motion capture, rest.

    The point moves about the IMU by the gyroscope's rate, whose noise is left out: with an arm of
    a metre that is some mm/s.

    Args:
        time_ns: ``(N,)`` of the IMU's clock.
        velocity_m_s: ``(N, 3)`` in the world.
        covariance: ``(3, 3)`` or ``(N, 3, 3)`` in the world's axes.
        arm_m: ``(3,)`` the point from the IMU, in the IMU's axes.

    Raises:
        ValueError: shapes that do not agree, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements.interface import PredictedState
        >>> from motorcade.fusion.measurements.positions import VelocityMeasurements
        >>> from motorcade.ga import Motor
        >>> still = VelocityMeasurements.zero(time_ns=np.array([0]), sigma_m_s=0.01)
        >>> still.residual(0, PredictedState.at(Motor.identity(), [0.0, 0.2, 0.0])) + 0.0
        array([ 0. , -0.2,  0. ])
    """

    name: ClassVar[str] = "velocity"
    time_ns: IntArray
    velocity_m_s: FloatArray
    covariance: FloatArray
    arm_m: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        set_checked(self, 3, ("arm_m",), velocity_m_s=(3,))

    @classmethod
    def zero(cls, time_ns: IntArray, sigma_m_s: float) -> VelocityMeasurements:
        """Rest at given stamps, to within a deviation an axis (m/s).

        Raises:
            ValueError: a deviation that is not above zero.
        """
        square = checked_positive(sigma_m_s, "sigma_m_s") ** 2
        none = np.zeros((len(time_ns), 3))
        return cls(time_ns=time_ns, velocity_m_s=none, covariance=square * np.eye(3))

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted velocity ``(3,)``, in the world's axes."""
        about = state.world_R_imu @ np.cross(state.angular_rate_rad_s, self.arm_m)
        seen: FloatArray = self.velocity_m_s[row] - state.velocity_m_s - about
        return seen

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(3, 30)`` of that."""
        about = np.cross(state.angular_rate_rad_s, self.arm_m)
        turned, by_bias = state.world_R_imu @ skew(about), -state.world_R_imu @ skew(self.arm_m)
        return by_error(3, rotation=turned, velocity=-state.world_R_imu, gyro_bias=by_bias)


@dataclass(frozen=True, eq=False, kw_only=True)
class BodyVelocityMeasurements(Measurements):
    """Velocities of a point on the body in the body's own axes: wheels, Doppler sensors.

    Args:
        time_ns: ``(N,)`` of the IMU's clock.
        velocity_m_s: ``(N, 3)`` over the ground, in the body's axes.
        covariance: ``(3, 3)`` or ``(N, 3, 3)`` in the body's axes.
        imu_R_body: turns the body's axes to the IMU's.
        arm_m: ``(3,)`` the point from the IMU, in the IMU's axes.

    Raises:
        ValueError: shapes that do not agree, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements.positions import BodyVelocityMeasurements
        >>> from motorcade.fusion.measurements.interface import PredictedState
        >>> from motorcade.ga import Motor
        >>> driven = BodyVelocityMeasurements.of_wheels(
        ...     time_ns=np.array([0]), speed_m_s=[3.0], sigma_m_s=0.1, slip_sigma_m_s=0.05
        ... )
        >>> world_T_imu = Motor.from_twist([0.0, 0.0, np.pi / 2, 0.0, 0.0, 0.0])  # faces +y
        >>> driven.residual(0, PredictedState.at(world_T_imu, [0.0, 3.0, 0.0])).round(9) + 0.0
        array([0., 0., 0.])
    """

    name: ClassVar[str] = "body_velocity"
    time_ns: IntArray
    velocity_m_s: FloatArray
    covariance: FloatArray
    imu_R_body: Rotor = field(default_factory=Rotor.identity)
    _body_R_imu: FloatArray = field(init=False, repr=False)
    arm_m: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        if self.imu_R_body.shape != ():
            raise ValueError(f"imu_R_body: expected one rotor, got {self.imu_R_body.shape}")
        set_checked(self, 3, ("arm_m",), velocity_m_s=(3,))
        object.__setattr__(self, "_body_R_imu", self.imu_R_body.inverse().as_matrix())

    @classmethod
    def of_wheels(
        cls,
        time_ns: IntArray,
        speed_m_s: ArrayLike,
        sigma_m_s: float,
        slip_sigma_m_s: float,
        imu_R_body: Rotor | None = None,
        arm_m: ArrayLike = (0.0, 0.0, 0.0),
    ) -> BodyVelocityMeasurements:
        """Of wheels that roll along the body's x and slip neither sideways nor upwards.

        Args:
            time_ns: ``(N,)``.
            speed_m_s: ``(N,)`` along x, backwards negative.
            sigma_m_s: its deviation.
            slip_sigma_m_s: deviation of the velocity sideways and upwards, which is measured as 0.
            imu_R_body: turns the vehicle's axes (x ahead) to the IMU's; by default they agree.
            arm_m: the middle of the axle that does not steer, from the IMU.

        Raises:
            ValueError: deviations that are not above zero.
        """
        along = checked_positive(sigma_m_s, "sigma_m_s") ** 2
        across = checked_positive(slip_sigma_m_s, "slip_sigma_m_s") ** 2
        speed = checked_rows(speed_m_s, "speed_m_s", len(time_ns), ())
        return cls(
            time_ns=time_ns,
            velocity_m_s=speed[:, None] * np.array([1.0, 0.0, 0.0]),
            covariance=np.diag([along, across, across]),
            imu_R_body=Rotor.identity() if imu_R_body is None else imu_R_body,
            arm_m=np.asarray(arm_m),
        )

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted velocity ``(3,)``, in the body's axes."""
        own = state.velocity_m_s @ state.world_R_imu
        own = own + np.cross(state.angular_rate_rad_s, self.arm_m)
        seen: FloatArray = self.velocity_m_s[row] - self._body_R_imu @ own
        return seen

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(3, 30)`` of that."""
        body_R_imu, own = self._body_R_imu, state.velocity_m_s @ state.world_R_imu
        turned, by_bias = -body_R_imu @ skew(own), -body_R_imu @ skew(self.arm_m)
        return by_error(3, rotation=turned, velocity=-body_R_imu, gyro_bias=by_bias)


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
        >>> from motorcade.fusion.measurements.positions import HeadingMeasurements
        >>> from motorcade.fusion.measurements.interface import PredictedState
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
        x, y, _ = state.world_R_imu @ self.axis
        turned = state.world_R_imu @ skew(self.axis)
        return by_error(1, rotation=(x * turned[1] - y * turned[0]) / (x * x + y * y))


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
        >>> from motorcade.fusion.measurements.positions import MagneticFieldMeasurements
        >>> from motorcade.fusion.measurements.interface import PredictedState
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
        turned = skew(self.world_field @ state.world_R_imu)
        return by_error(3, rotation=-self.imu_R_sensor.as_matrix().T @ turned)


@dataclass(frozen=True)
class GeodeticOrigin:
    """The place on WGS 84 where a world has its origin; x points east, y north, z up there.

    Args:
        latitude_deg, longitude_deg: latitude from -90 to 90.
        height_m: above the ellipsoid, not above the sea.

    Raises:
        ValueError: a latitude out of its range, NaN or infinity.

    Examples:
        >>> from motorcade.fusion.measurements import GeodeticOrigin
        >>> GeodeticOrigin(latitude_deg=47.0, longitude_deg=8.5, height_m=400.0).height_m
        400.0
    """

    latitude_deg: float
    longitude_deg: float
    height_m: float

    def __post_init__(self) -> None:
        _checked(self.latitude_deg, self.longitude_deg, self.height_m)

    @cached_property
    def _pipeline(self) -> Any:
        from pyproj import Transformer

        return Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
            "+step +proj=cart +ellps=WGS84 +step +proj=topocentric +ellps=WGS84 "
            f"+lat_0={self.latitude_deg!r} +lon_0={self.longitude_deg!r} +h_0={self.height_m!r}"
        )

    def local_m(
        self, latitude_deg: ArrayLike, longitude_deg: ArrayLike, height_m: ArrayLike
    ) -> FloatArray:
        """Places ``(N, 3)`` east, north and up of the origin, of N on the ellipsoid.

        Raises:
            ValueError: latitudes beyond ±90°, shapes that do not agree, NaN or infinity.
            ModuleNotFoundError: without pyproj.
        """
        latitude, longitude, height = _checked(latitude_deg, longitude_deg, height_m)
        columns = self._pipeline.transform(longitude, latitude, height)
        return np.stack(columns, axis=-1)

    def geodetic(self, local_m: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Latitudes (deg), longitudes (deg) and heights (m) ``(N,)`` of places ``(N, 3)``.

        Raises:
            ValueError: another shape, NaN or infinity.
            ModuleNotFoundError: without pyproj.
        """
        east, north, up = np.moveaxis(checked_floats(local_m, "local_m", (3,)), -1, 0)
        longitude, latitude, height = self._pipeline.transform(east, north, up, direction="INVERSE")
        return latitude, longitude, height


def _checked(
    latitude_deg: ArrayLike, longitude_deg: ArrayLike, height_m: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    latitude = checked_floats(latitude_deg, "latitude_deg", ())
    longitude = checked_floats(longitude_deg, "longitude_deg", ())
    height = checked_floats(height_m, "height_m", ())
    if latitude.shape != longitude.shape or latitude.shape != height.shape:
        raise ValueError(
            "latitude_deg, longitude_deg, height_m: expected one shape, got "
            f"{latitude.shape}, {longitude.shape}, {height.shape}"
        )
    if np.any(np.abs(latitude) > 90.0):
        raise ValueError("latitude_deg: expected -90 to 90, got more; is it the longitude?")
    return latitude, longitude, height
