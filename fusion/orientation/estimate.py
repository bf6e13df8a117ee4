"""Orientation by inertial readings: sample by sample, or of a whole stream.

World axes have z up. With a magnetometer y points to magnetic north and x to the east of it;
without one heading starts at an arbitrary angle and drifts, as nothing sees it. The filter is
described in ``native/filter.h``, the pass backwards in ``native/backward.h``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.imu.noise import ADIS16448, ImuNoise
from motorcade.fusion.imu.screening import gravity_in_unit
from motorcade.fusion.imu.stream import GRAVITY_SHARE, ImuStream
from motorcade.fusion.orientation.native import _orientation
from motorcade.fusion.orientation.native._orientation import Settings
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.ga.names import check_word

_MOST_FIELD = 1e9
_USUAL = replace(ADIS16448, gyro_walk_rad_s2_rthz=2e-4)


@dataclass(frozen=True)
class OrientationModel:
    """Sensor and motion, as the filter sees them.

    The defaults are round numbers from data sheets and everyday motion, looked over on ten trials
    of BROAD: halving or doubling any of them leaves the mean inclination error within a tenth.

    Fields:
        noise: white noise and walks; the ADIS16448's, which is of today's usual class, with a gyro
            walk of ten times its data sheet's, as biases move with temperature and strain.
        gyro_matrix_deviation: of the gyro's scales and of its axes' angles, which the filter
            estimates; a few tenths of a percent is what calibration at the factory leaves.
        gyro_wander_sqrt_rad: what that matrix does not tell (temperature, sensitivity to
            acceleration) as a random walk: its deviation after turning at 1 rad/s for 1 s, and it
            grows with the rate and the root of time.
        first_bias_rad_s: deviation of the gyro's bias at the start; 0.02 is the ±1°/s of data
            sheets. One that is larger is found at rest, up to four deviations.
        first_tilt_rad: deviation of the tilt of the first sample, taken as if it stood still.
        speed_m_s, speed_time_s: the sensor's velocity is a process of at least this deviation that
            forgets itself after this time: a hand, a limb, a head. The readings tell how much
            faster it is. It tells gravity from acceleration; a vehicle that speeds up for long is
            not of this kind.
        gravity_m_s2: size of gravity.
        accel_bias_m_s2: deviation of the accelerometer's bias, each axis; nothing tells it from a
            tilt, so it only adds to the tilt's deviation. 3 mg is what data sheets allow.
        interval_s: time from correction to correction; motion is faster only in the gyro.
        rest_rate_rad_s, rest_force_m_s2, rest_after_s: rest is when readings have kept this close
            to their average of half a second for this long (Laidig and Seel's 2°/s, 0.5 m/s²,
            1.5 s).
        field_disturbance_rad, field_disturbance_time_s: by how much the direction of the magnetic
            field differs from north even where it looks undisturbed (3°: a room, the sensor's own
            iron), and how long such a difference lasts.
        readings: "interval" where a reading is the mean since the stamp before, as of gyros that
            integrate or filter before they sample; "instant" where it holds at its stamp. Half a
            sample lies between them, which inertial readings alone cannot tell: all of them, and
            the orientation with them, shift together.

    Raises:
        ValueError: a number that is not finite or not above 0, or other readings.

    Examples:
        >>> from motorcade.fusion import OrientationModel
        >>> OrientationModel(readings="interval", speed_m_s=2.0).speed_m_s  # a limb that swings
        2.0
    """

    noise: ImuNoise = _USUAL
    gyro_matrix_deviation: float = 0.0025
    gyro_wander_sqrt_rad: float = 0.001
    first_bias_rad_s: float = 0.02
    first_tilt_rad: float = 0.2
    speed_m_s: float = 0.4
    speed_time_s: float = 0.15
    gravity_m_s2: float = 9.81
    accel_bias_m_s2: float = 0.03
    interval_s: float = 0.04
    rest_rate_rad_s: float = float(np.deg2rad(2.0))
    rest_force_m_s2: float = 0.5
    rest_after_s: float = 1.5
    field_disturbance_rad: float = 0.05
    field_disturbance_time_s: float = 3.0
    readings: Literal["instant", "interval"] = "interval"

    def __post_init__(self) -> None:
        for field in fields(self):
            if field.type == "float":
                checked_positive(getattr(self, field.name), f"OrientationModel.{field.name}")
        check_word(self.readings, ("instant", "interval"), "OrientationModel.readings")

    @property
    def level_deviation_rad(self) -> float:
        """What the accelerometer's bias adds to the deviation of the tilt, both axes together."""
        return math.sqrt(2.0) * self.accel_bias_m_s2 / self.gravity_m_s2

    def settings(self) -> Settings:
        """The same for the compiled filter."""
        return Settings(
            gyro_density=self.noise.gyro_density_rad_s_rthz,
            gyro_walk=self.noise.gyro_walk_rad_s2_rthz,
            accel_density=self.noise.accel_density_m_s2_rthz,
            gyro_matrix=self.gyro_matrix_deviation,
            gyro_wander=self.gyro_wander_sqrt_rad,
            first_bias=self.first_bias_rad_s,
            first_tilt=self.first_tilt_rad,
            speed=self.speed_m_s,
            speed_time=self.speed_time_s,
            gravity=self.gravity_m_s2,
            interval=self.interval_s,
            rest_rate=self.rest_rate_rad_s,
            rest_force=self.rest_force_m_s2,
            rest_after=self.rest_after_s,
            disturbance=self.field_disturbance_rad,
            disturbance_time=self.field_disturbance_time_s,
            averaged=self.readings == "interval",
        )


@dataclass(frozen=True, eq=False)
class Orientation:
    """Orientation of a sensor at its stream's stamps ``(N,)``.

    Fields:
        time_ns: the stamps.
        world_R_imu: Rotor ``(N,)``.
        tilt_deviation_rad, heading_deviation_rad: ``(N,)``, the deviations that the filter expects
            of itself: of both axes of the tilt together, and of the turn about the vertical, which
            without magnetometer is that since the start.
        gyro_bias_rad_s: ``(N, 3)``.
        at_rest: ``(N,)``, whether the sensor had been found at rest by then.
        field_deviation_rad: ``(N,)``, how far the magnetic field was from its reference, as an
            angle of the heading; 0 without magnetometer.
        magnetometer_lag_s: by how much the magnetometer was found to read late; 0 without one.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream
        >>> white = np.random.default_rng(0).normal(0.0, 0.1, (2000, 2, 3))
        >>> time_ns = 10_000_000 * np.arange(2000)
        >>> still = ImuStream(time_ns, 0.01 * white[:, 0], [0.0, 0.0, 9.81] + white[:, 1])

        >>> from motorcade.fusion import estimate_orientation
        >>> found = estimate_orientation(still)
        >>> bool(found.at_rest[-1]), found.gyro_bias_rad_s.shape
        (True, (2000, 3))
    """

    time_ns: IntArray
    world_R_imu: Rotor
    tilt_deviation_rad: FloatArray
    heading_deviation_rad: FloatArray
    gyro_bias_rad_s: FloatArray
    at_rest: NDArray[np.bool_]
    field_deviation_rad: FloatArray
    magnetometer_lag_s: float


class OrientationFilter:
    """Orientation online: samples in one after another, a rotor out for each.

    Samples more than 0.25 s apart leave a gap, after which the filter knows as much less.

    Args:
        model: sensor and motion.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import OrientationFilter
        >>> live = OrientationFilter()
        >>> for k in range(100):
        ...     world_R_imu = live.update(10_000_000 * k, np.zeros(3), np.array([9.81, 0.0, 0.0]))
        >>> bool(world_R_imu.apply([1.0, 0.0, 0.0])[2] > 0.999)  # its x points up
        True
    """

    def __init__(self, model: OrientationModel | None = None) -> None:
        self.model = OrientationModel() if model is None else model
        self._stream = _orientation.Stream(self.model.settings())

    def update(
        self,
        time_ns: int,
        angular_rate_rad_s: FloatArray,
        specific_force_m_s2: FloatArray,
        magnetic_field: FloatArray | None = None,
    ) -> Rotor:
        """Orientation ``world_R_imu`` at a stamp, from the readings there.

        Args:
            time_ns: integer nanoseconds, after the stamp before.
            angular_rate_rad_s: ``(3,)`` float64.
            specific_force_m_s2: ``(3,)`` float64; the first sets the tilt that the filter starts
                from.
            magnetic_field: ``(3,)`` float64 in any unit, the same for all; None where the
                magnetometer has no new reading. The first one sets north.

        Raises:
            ValueError: a stamp that does not increase, NaN or infinity; the filter is then as
                it was.
            TypeError: a stamp that is no integer, readings that are not ``(3,)`` float64.
        """
        out = np.empty(4)
        self._stream.update(time_ns, angular_rate_rad_s, specific_force_m_s2, magnetic_field, out)
        return Rotor._trusted(out)

    @property
    def gyro_bias_rad_s(self) -> FloatArray:
        """The gyro's bias ``(3,)``, by what is known now."""
        return np.array(self._stream.bias)

    @property
    def at_rest(self) -> bool:
        """Whether the sensor rests."""
        return self._stream.at_rest

    @property
    def tilt_deviation_rad(self) -> float:
        """Deviation of the tilt, both axes together, that the filter expects of itself."""
        return math.hypot(self._stream.tilt_deviation, self.model.level_deviation_rad)

    @property
    def heading_deviation_rad(self) -> float:
        """Deviation of the heading that the filter expects of itself."""
        return self._stream.heading_deviation

    @property
    def field_deviation_rad(self) -> float:
        """How far the magnetic field is from its reference, as an angle of the heading."""
        return self._stream.field_deviation


def estimate_orientation(
    imu: ImuStream,
    model: OrientationModel | None = None,
    *,
    magnetic_field: FloatArray | None = None,
    smooth: bool = True,
) -> Orientation:
    """Orientation along a recorded stream.

    Args:
        imu: the stream.
        model: sensor and motion.
        magnetic_field: ``(N, 3)`` readings of a magnetometer in the IMU's axes, in any unit; rows
            of NaN where it has no new one. Hard and soft iron are calibrated before; disturbances
            from outside are found and bridged by the gyro.
        smooth: forwards and backwards, so that all of the stream speaks for every sample; False
            for what `OrientationFilter` gives sample by sample, to the last bit. Smoothing keeps
            2.6 kB for every 0.04 s: 235 MB an hour.

    Raises:
        ValueError: a magnetic field of another shape, beyond 1e9, infinite or without any reading.

    Source: Bierman's form of the Rauch-Tung-Striebel smoother over an error-state filter; see
    ``native/backward.h``. It breaks down where the speed of `model` is left for long (a car, a
    centrifuge): acceleration is then taken for tilt.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream
        >>> white = np.random.default_rng(0).normal(0.0, 0.1, (2000, 2, 3))
        >>> time_ns = 10_000_000 * np.arange(2000)
        >>> still = ImuStream(time_ns, 0.01 * white[:, 0], [0.0, 0.0, 9.81] + white[:, 1])

        >>> from motorcade.fusion import estimate_orientation
        >>> up = estimate_orientation(still).world_R_imu[-1].apply([0.0, 0.0, 1.0])
        >>> bool(up[2] > 0.9999)
        True
    """
    model = OrientationModel() if model is None else model
    fields = None if magnetic_field is None else _checked_field(magnetic_field, len(imu))
    rate, force = map(np.ascontiguousarray, (imu.angular_rate_rad_s, imu.specific_force_m_s2))
    rotors, biases = np.empty((len(imu), 4)), np.empty((len(imu), 3))
    deviations, disturbances = np.empty((len(imu), 2)), np.empty(len(imu))
    rest = np.empty(len(imu), dtype=np.bool_)
    results = rotors, biases, deviations, disturbances, rest
    lag_s = _orientation.run(model.settings(), rate, force, fields, imu.time_ns, smooth, *results)
    tilt, heading = np.ascontiguousarray(deviations.T)
    return Orientation(
        time_ns=imu.time_ns,
        world_R_imu=Rotor._trusted(rotors),
        tilt_deviation_rad=np.sqrt(tilt**2 + model.level_deviation_rad**2),
        heading_deviation_rad=heading,
        gyro_bias_rad_s=biases,
        at_rest=rest,
        field_deviation_rad=disturbances,
        magnetometer_lag_s=lag_s,
    )


def _checked_field(field: FloatArray, count: int) -> FloatArray:
    """Readings as the compiled filter takes them: rows are finite or NaN."""
    readings = np.array(field, dtype=np.float64)
    if readings.shape != (count, 3):
        raise ValueError(f"magnetic_field: expected shape {(count, 3)}, got {readings.shape}")
    missing = np.isnan(readings).any(axis=1)
    readings[missing] = np.nan
    if np.all(missing):
        raise ValueError("magnetic_field: expected a reading, got rows of NaN alone")
    largest = float(np.nanmax(np.abs(readings)))
    if not largest < _MOST_FIELD:
        raise ValueError(
            f"magnetic_field: expected readings within {_MOST_FIELD:g}, got {largest:g}"
        )
    return readings


# Over windows of this length the acceleration of a hand, a limb or a small aircraft averages out,
# and gravity does not.
_WINDOW_S = 2.0
# What windows may leave of horizontal specific force. Clean trials of BROAD and flights of EuRoC
# have 0.01 to 0.08 of gravity; a gyro in degrees, with axes swapped or turned around 0.1 to 1.
_LEVEL_SHARE = 0.1
# Beyond this the field is disturbed (20° of heading); for half of the time, and it is no use.
_DISTURBED_RAD, _DISTURBED_SHARE = 0.35, 0.5
# Tilt and heading are called unknown beyond these deviations.
_TILT_RAD, _HEADING_RAD = 0.1, 0.2


def orientation_doubts(
    imu: ImuStream,
    orientation: Orientation,
    model: OrientationModel | None = None,
    *,
    with_magnetometer: bool = False,
) -> tuple[str, ...]:
    """What speaks against an estimated orientation, a line each; nothing where all is well.

    A sensor that hardly turns shows no fault of its gyro or magnetometer, and one whose specific
    force is negative as a whole stands upside down without a sign of it.

    Args:
        imu: the stream.
        orientation: its orientation.
        model: the model that it was estimated with.
        with_magnetometer: whether a magnetic field was given.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream, estimate_orientation
        >>> from motorcade.fusion.orientation import orientation_doubts
        >>> still, up = np.zeros((2000, 3)), np.tile([0.0, 0.0, 1.0], (2000, 1))
        >>> in_g = ImuStream(5_000_000 * np.arange(2000), still, up)
        >>> orientation_doubts(in_g, estimate_orientation(in_g))
        ('specific force averages to 1 upwards, which is gravity in g; multiply by 9.80665',)
    """
    model = OrientationModel() if model is None else model
    gravity = model.gravity_m_s2
    world = orientation.world_R_imu.apply(imu.specific_force_m_s2)
    count = max(1, min(len(imu), round(_WINDOW_S * imu.rate_hz)))
    windows = world[: len(imu) // count * count].reshape(-1, count, 3).mean(axis=1)
    up = float(np.median(windows[:, 2]))
    level = float(np.sqrt(np.mean(np.sum(windows[:, :2] ** 2, axis=1))))
    warnings = []
    if level > _LEVEL_SHARE * max(abs(up), 0.1 * gravity):
        warnings.append(
            f"specific force averages to {level:.3g} m/s² sideways where gravity should stand "
            "upright: the gyroscope is in degrees a second, or its axes or signs are not the "
            "accelerometer's; or the sensor speeds up for seconds, as in a vehicle"
        )
    elif abs(up / gravity - 1.0) > GRAVITY_SHARE:
        warnings.append(_wrong_gravity(up, gravity))
    if np.median(orientation.tilt_deviation_rad) > _TILT_RAD:
        warnings.append(f"tilt is known to {_degrees(orientation.tilt_deviation_rad)} only")
    if with_magnetometer:
        warnings += _magnetic(orientation)
    return tuple(warnings)


def _wrong_gravity(up: float, gravity: float) -> str:
    if named := gravity_in_unit(up):
        return f"specific force averages to {up:.4g} upwards, {named}"
    return (
        f"specific force averages to {up:.3g} m/s² upwards, expected {gravity:g}: without gravity "
        "there is no tilt; give the accelerometer's readings as they are"
    )


def _magnetic(orientation: Orientation) -> list[str]:
    warnings = []
    disturbed = float(np.mean(orientation.field_deviation_rad > _DISTURBED_RAD))
    if disturbed > _DISTURBED_SHARE:
        warnings.append(
            f"the magnetic field is disturbed {disturbed:.0%} of the time: magnets or iron nearby, "
            "a magnetometer that is not calibrated, or axes that are not the gyroscope's"
        )
    if np.median(orientation.heading_deviation_rad) > _HEADING_RAD:
        warnings.append(f"heading is known to {_degrees(orientation.heading_deviation_rad)} only")
    return warnings


def _degrees(deviations_rad: FloatArray) -> str:
    return f"±{np.degrees(np.median(deviations_rad)):.0f}°"
