"""Trials of the BROAD data set: inertial and magnetic readings in an HDF5 file.

D. Laidig, M. Caruso, A. Cereatti and T. Seel, "BROAD: A benchmark for robust inertial orientation
estimation", Data 6(7), 2021. Samples are evenly spaced, so that stamps are counted from 0.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import admit_file
from motorcade.replays.io.errors import RecordingError, refusal

if TYPE_CHECKING:
    import h5py

FILE_LIMIT = 1 << 30
_MOST_SAMPLES = 20_000_000
_MOST_CHUNK_BYTES = 1 << 28
_NAMES = ("imu_gyr", "imu_acc", "imu_mag")


def read_broad(path: Path) -> tuple[ImuStream, FloatArray]:
    """The IMU's stream, and the magnetic field (µT) at its samples.

    Raises:
        RecordingError: no HDF5 file, one without these data sets or with others than numbers of
            shape (N, 3), no sampling rate, NaN; data sets that lie in other files.
        ModuleNotFoundError: h5py is not installed.
    """
    import h5py

    admit_file(path, FILE_LIMIT)
    try:
        with h5py.File(path, "r") as file:
            rate_hz = float(file.attrs.get("sampling_rate", np.nan))
            gyro, accel, field = (_data(file, name, path) for name in _NAMES)
    except RecordingError:
        raise
    except OSError as fault:
        raise refusal(path, "expected an HDF5 file, got something else") from fault
    except (TypeError, ValueError, RuntimeError, KeyError) as fault:
        raise refusal(path, f"expected a trial of BROAD: {fault}") from fault
    if not (len(gyro) == len(accel) == len(field)):
        raise refusal(path, "expected as many rows of imu_gyr as of imu_acc and imu_mag")
    if not 1.0 <= rate_hz <= 1e6:
        raise refusal(path, f"sampling_rate: expected 1 to 1000000 Hz, got {rate_hz:g}")
    stamps = np.round(np.arange(len(gyro)) * (1e9 / rate_hz)).astype(np.int64)
    try:
        return ImuStream(stamps, gyro, accel), field
    except ValueError as fault:
        raise refusal(path, str(fault)) from fault


def _data(file: h5py.File, name: str, path: Path) -> FloatArray:
    """A data set of numbers (N, 3) that lies in this very file."""
    import h5py

    link = file.get(name, getlink=True)
    data = file.get(name) if isinstance(link, h5py.HardLink) else None
    if not isinstance(data, h5py.Dataset) or data.external or data.is_virtual:
        raise refusal(path, f"{name}: expected a data set of BROAD's in this file, got none")
    if data.dtype.kind not in "fiu" or data.ndim != 2 or data.shape[1] != 3:
        raise refusal(
            path, f"{name}: expected numbers of shape (N, 3), got {data.dtype} {data.shape}"
        )
    if len(data) > _MOST_SAMPLES:
        raise refusal(path, f"{name}: expected at most {_MOST_SAMPLES} rows, got {len(data)}")
    if data.dtype.itemsize * math.prod(data.chunks or (0,)) > _MOST_CHUNK_BYTES:
        raise refusal(path, f"{name}: expected chunks of at most {_MOST_CHUNK_BYTES} bytes")
    return np.asarray(data[:], dtype=np.float64)
