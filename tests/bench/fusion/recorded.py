"""Recorded flights with their truth, and camera poses simulated from it.

Poses come at 20 Hz with 1 cm and 0.5° an axis; 2 % of them are off besides, by Student errors of 3
degrees of freedom and scales of 0.5 m and 0.5 rad; for 2 s every 15 s there is none.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused
from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.metrics import normalised_squared
from motorcade.fusion.motions.degradations import Blackouts, Degradation, InTurn, Outliers
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.data import data_folder

__all__ = [
    "BLACKOUTS",
    "DEGRADED",
    "FLIGHTS",
    "NOISE",
    "SETTINGS",
    "Flight",
    "flight",
    "flights_asked_for",
    "measured",
    "nees",
]

_STATES = {
    "V1_02": ("V1_02_medium.csv", "V102_imu.txt"),
    "MH_05": ("flights/MH_05_difficult.csv", "flights/MH05_imu.txt"),
    "V1_03": ("flights/V1_03_difficult.csv", "flights/V103_imu.txt"),
    "V2_02": ("flights/V2_02_medium.csv", "flights/V202_imu.txt"),
}
"""EuRoC's ground truth with its biases, and its IMU."""

FLIGHTS = (*_STATES, "V1_01")
"""All by name."""

BLACKOUTS = Blackouts(2.0, 15.0)
DEGRADED = InTurn((Outliers(0.02, 0.5, 0.5), BLACKOUTS))

_DENSITY_FACTORS = 7.0, 15.0
_WALK_FACTORS = 1.0, 0.3
NOISE = ImuNoise(
    _DENSITY_FACTORS[0] * ADIS16448.gyro_density_rad_s_rthz,
    _WALK_FACTORS[0] * ADIS16448.gyro_walk_rad_s2_rthz,
    _DENSITY_FACTORS[1] * ADIS16448.accel_density_m_s2_rthz,
    _WALK_FACTORS[1] * ADIS16448.accel_walk_m_s3_rthz,
)
"""The filter's: white noise 7 and 15 times the data sheet's, as the sensor flies and shakes, and
biases that hardly walk within minutes."""

SETTINGS = FilterSettings(gravity_sigma_rad=float(np.deg2rad(1.0)))
"""The ground truth's world may lean: its vertical is estimated, from 1° of doubt."""


@dataclass(frozen=True, eq=False)
class Flight:
    """A recorded IMU with its ground truth.

    Fields:
        name: of the recording.
        imu: its stream.
        truth: ``world_T_imu``.
        gyro_bias_rad_s, accel_bias_m_s2: ``(N, 3)`` at the ground truth's stamps, None where not
        recorded.
    """

    name: str
    imu: ImuStream
    truth: Trajectory
    gyro_bias_rad_s: FloatArray | None = None
    accel_bias_m_s2: FloatArray | None = None

    def thinned(self, rate_hz: float) -> Flight:
        """The same flight with a ground truth at a rate, at the stamps of poses measured at it."""
        count = int(self.truth.duration_s * rate_hz + 1e-6) + 1
        start = self.truth.time_ns[0]
        stamps = start + np.round(np.arange(count) * 1e9 / rate_hz).astype(np.int64)
        stamps = np.minimum(stamps, self.truth.time_ns[-1])
        at = np.searchsorted(self.truth.time_ns, stamps)
        biases = (
            None if bias is None else bias[at]
            for bias in (self.gyro_bias_rad_s, self.accel_bias_m_s2)
        )
        return Flight(self.name, self.imu, self.truth.resampled(stamps), *biases)


def flight(name: str, folder: Path) -> Flight | None:
    """One of `FLIGHTS` in the folder of recordings; None where it is not there."""
    if name in _STATES:
        states, samples = (folder / "imu" / one for one in _STATES[name])
        if not states.is_file():
            return None
        truth = read_trajectory(states, child="imu")
        columns = np.loadtxt(states, delimiter=",", usecols=range(11, 17))
        imu = read_imu(samples)
        inside = (truth.time_ns >= imu.time_ns[0]) & (truth.time_ns <= imu.time_ns[-1])
        return Flight(name, imu, truth[inside], columns[inside, :3], columns[inside, 3:])
    root = folder / "replays" / "euroc_V1_01"
    if not (root / "V1_01_easy.txt").is_file():
        return None
    imu = read_imu(root / "mav0" / "imu0" / "data.csv")
    truth = read_trajectory(root / "V1_01_easy.txt", child="imu")
    inside = (truth.time_ns >= imu.time_ns[0]) & (truth.time_ns <= imu.time_ns[-1])
    return Flight(name, imu, truth[inside])


def measured(
    one: Flight, seed: int, delay_s: float = 0.0, degraded: Degradation | None = DEGRADED
) -> PoseMeasurements:
    """Camera poses of a flight, the camera in the IMU's place, stamped late by `delay_s`."""
    rng = np.random.default_rng(seed)
    poses = simulate_camera_poses(one.truth, 20.0, 0.01, np.deg2rad(0.5), rng, degraded)
    path = poses.trajectory
    late = Trajectory(path.time_ns + round(1e9 * delay_s), path.motors, path.parent, "imu")
    return PoseMeasurements(late, poses.covariance)


def nees(one: Flight, fused: Fused) -> float:
    """NEES/6 of a fused path, averaged over its poses."""
    off = fused.trajectory.motors.local(one.truth.motors_at(fused.trajectory.time_ns))
    return float(np.mean(normalised_squared(off, fused.covariance))) / 6.0


def flights_asked_for(program: str, seeds: int) -> Iterator[tuple[Flight, range]]:
    """The flights that the command line names, with as many seeds; those that lack are printed."""
    parser = argparse.ArgumentParser(prog=f"python -m {program}")
    parser.add_argument("--flights", default=",".join(FLIGHTS), help="by commas")
    parser.add_argument("--seeds", type=int, default=seeds)
    given = parser.parse_args()
    for name in given.flights.split(","):
        one = flight(name, data_folder())
        if one is None:
            print(f"{name}: not below {data_folder()}; set MOTORCADE_DATA")
        else:
            yield one, range(given.seeds)
