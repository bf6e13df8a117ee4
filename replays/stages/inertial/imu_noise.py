"""What noise is assumed of an IMU, by where its stream came from."""

from __future__ import annotations

from motorcade.fusion.imu import ImuNoise
from motorcade.replays.values.imu import ImuOrigin

__all__ = ["NOISE_FACTORS", "assumed_noise"]

NOISE_FACTORS: dict[ImuOrigin, tuple[float, float]] = {
    "recorded": (10.0, 1.0),
    "reference": (1.0, 1.0),
    "tracked": (1000.0, 1000.0),
}
"""On white densities and on bias walks, by where the IMU came from. Data sheets describe a sensor
at rest on a bench: one that is carried or flown feels what shakes it, and its scales and axes are
a little off, which looks like white noise. Tenfold is what Kalibr's authors advise, and brings the
filter's NIS to six on EuRoC's flights; biases walk as the sheet says. A stream simulated along the
tracked path repeats what the camera said, errors and all, and must not be believed twice."""


def assumed_noise(
    noise: ImuNoise, origin: ImuOrigin, white: float | None = None, walk: float | None = None
) -> ImuNoise:
    """The sensor's noise times the factors of its origin, or times those given."""
    usual_white, usual_walk = NOISE_FACTORS[origin]
    white = usual_white if white is None else white
    walk = usual_walk if walk is None else walk
    return ImuNoise(
        white * noise.gyro_density_rad_s_rthz,
        walk * noise.gyro_walk_rad_s2_rthz,
        white * noise.accel_density_m_s2_rthz,
        walk * noise.accel_walk_m_s3_rthz,
    )
