"""What the orientation filter assumes of sensor and motion; every default has a stated ground."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from motorcade.fusion.imu.noise import ADIS16448, ImuNoise
from motorcade.fusion.orientation.native._orientation import Settings
from motorcade.ga.arrays import checked_positive

__all__ = ["OrientationModel"]


@dataclass(frozen=True)
class OrientationModel:
    """Sensor and motion, as the filter sees them. Nothing here was fitted to a recording.

    Fields:
        noise: white noise and walks; those of the ADIS16448, which is of today's usual class.
        gyro_scale_deviation: of the scale of each gyro axis, which the filter estimates; 1 % is
            what data sheets of such sensors allow.
        gyro_wander_sqrt_rad: what scale does not tell (axes that are not square, sensitivity to
            acceleration) as a random walk: its deviation after turning at 1 rad/s for 1 s, and it
            grows with the rate and the root of time. Half a percent, data sheets' cross-axis term.
        first_bias_rad_s: deviation of the gyro's bias at the start; 0.02 is the ±1°/s of data
            sheets. One that is larger is found at rest, up to four deviations.
        first_tilt_rad: deviation of the tilt of the first sample, taken as if it stood still.
        speed_m_s, speed_time_s: the sensor's velocity is a process of this deviation that forgets
            itself after this time: a hand, a limb, a head. It tells gravity from acceleration; a
            vehicle that speeds up for long is not of this kind.
        gravity_m_s2: size of gravity.
        interval_s: time from correction to correction; motion is faster only in the gyro.
        rest_rate_rad_s, rest_force_m_s2, rest_after_s: rest is when readings have kept this close
            to their average of half a second for this long (Laidig and Seel's 2°/s, 0.5 m/s²,
            1.5 s).
        readings: "instant" where a reading holds at its stamp, "interval" where it is the mean
            since the stamp before, as of gyros that integrate. Half a sample lies between them.

    Raises:
        ValueError: a number that is not finite or not above 0, or other readings.

    Examples:
        >>> from motorcade.fusion import OrientationModel
        >>> OrientationModel(readings="interval", speed_m_s=2.0).speed_m_s  # a limb that swings
        2.0
    """

    noise: ImuNoise = ADIS16448
    gyro_scale_deviation: float = 0.01
    gyro_wander_sqrt_rad: float = 0.005
    first_bias_rad_s: float = 0.02
    first_tilt_rad: float = 0.2
    speed_m_s: float = 0.5
    speed_time_s: float = 0.5
    gravity_m_s2: float = 9.81
    interval_s: float = 0.04
    rest_rate_rad_s: float = float(np.deg2rad(2.0))
    rest_force_m_s2: float = 0.5
    rest_after_s: float = 1.5
    readings: Literal["instant", "interval"] = "instant"

    def __post_init__(self) -> None:
        for field in fields(self):
            if field.type == "float":
                checked_positive(getattr(self, field.name), f"OrientationModel.{field.name}")
        if self.readings not in ("instant", "interval"):
            raise ValueError(
                'OrientationModel.readings: expected "instant" or "interval", '
                f"got {self.readings!r}"
            )

    def settings(self) -> Settings:
        """The same for the compiled filter."""
        return Settings(
            gyro_density=self.noise.gyro_density_rad_s_rthz,
            gyro_walk=self.noise.gyro_walk_rad_s2_rthz,
            accel_density=self.noise.accel_density_m_s2_rthz,
            gyro_scale=self.gyro_scale_deviation,
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
            averaged=self.readings == "interval",
        )
