"""The `[imu]` table of a manifest: how a sensor sits beside a camera, errs and keeps time.

`motorcade calibrate --imu` writes one; it holds for every recording by the same camera and IMU.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import MOST_CORRECTION, ImuStream
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.ga.names import one_line
from motorcade.replays.io.imu import read_noise
from motorcade.replays.io.readers.kalibr import MOST_OFFSET_S
from motorcade.replays.io.readers.manifest.section import Section, load_toml
from motorcade.replays.io.transforms import as_float, is_number, transform

IMU_KEYS = (
    "file",
    "noise_file",
    "imu_T_camera",
    "clock_offset_s",
    "gyro_correction",
    "accel_correction",
)


@dataclass(frozen=True, eq=False)
class ImuCalibration:
    """What a table says of an IMU; None: nothing.

    Fields:
        noise: its densities and bias walks.
        imu_T_camera: pose of the camera on it.
        offset_s: what its clock shows at an event minus what the camera's shows.
        gyro_correction, accel_correction: ``(3, 3)``; times a reading, they give the true rate
            plus a bias, the true force plus a bias.
    """

    noise: ImuNoise | None
    imu_T_camera: Motor | None
    offset_s: float
    gyro_correction: FloatArray
    accel_correction: FloatArray

    def corrected(self, imu: ImuStream) -> ImuStream:
        """The readings with the corrections, on the IMU's own clock."""
        return imu.corrected(self.gyro_correction, self.accel_correction)

    def on_camera_clock(self, imu: ImuStream) -> ImuStream:
        """The corrected readings with the stamps that the camera's clock shows."""
        stamps = imu.time_ns - round(1e9 * self.offset_s)
        return replace(self.corrected(imu), time_ns=stamps)


def read_imu_calibration(path: Path) -> ImuCalibration:
    """Read the `[imu]` table of a TOML file, as `motorcade calibrate --imu` writes it.

    Raises:
        RecordingError: what the table lacks or gets wrong, or the noise file that it names.
    """
    tables = load_toml(path)
    if "imu" not in tables:
        raise Section(path, "", {}, ()).fault("imu", "the table is missing")
    section = Section(path, "imu", tables["imu"], IMU_KEYS)
    imu_calibration = section_imu(section, lambda part, key: path.parent / part.text(key))
    if imu_calibration.imu_T_camera is None:
        raise section.fault("imu_T_camera", "the key is missing", "give a 4 by 4 matrix")
    return imu_calibration


def section_imu(section: Section, file: Callable[[Section, str], Path]) -> ImuCalibration:
    """What a manifest's table says of the sensor.

    Args:
        section: the table.
        file: the file that a key of the table names.

    Raises:
        RecordingError: naming table and key.
    """
    noise = read_noise(file(section, "noise_file")) if "noise_file" in section else None
    pose, offset_s = None, 0.0
    if "imu_T_camera" in section:
        pose = transform(section["imu_T_camera"], section.path, "[imu] imu_T_camera")
    if "clock_offset_s" in section:
        offset_s = section.number("clock_offset_s", -MOST_OFFSET_S, MOST_OFFSET_S)
    matrices = (_correction(section, key) for key in ("gyro_correction", "accel_correction"))
    return ImuCalibration(noise, pose, offset_s, *matrices)


def _correction(section: Section, key: str) -> FloatArray:
    """A matrix ``(3, 3)`` close to the identity, which it is where nothing is said."""
    if key not in section:
        return np.eye(3)
    rows = section[key]
    numbers = []
    if isinstance(rows, list) and len(rows) == 3:
        numbers = [one for row in rows if isinstance(row, list) for one in row]
    if len(numbers) != 9 or not all(map(is_number, numbers)):
        raise section.fault(key, f"expected 3 rows of 3 numbers, got {one_line(rows)}")
    matrix = np.array([as_float(one) for one in numbers]).reshape(3, 3)
    if not np.abs(matrix - np.eye(3)).max() <= MOST_CORRECTION:
        expected = f"expected entries within {MOST_CORRECTION:g} of the identity's"
        raise section.fault(key, f"{expected}, got {one_line(rows)}")
    return matrix
