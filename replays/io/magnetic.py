"""Inertial readings with those of a magnetometer beside them, from files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.fusion.imu.screening import screen_imu
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.readers.broad import read_broad
from motorcade.replays.io.readers.tables import Table, in_order, read_table

_IMU_COLUMNS = ("w_x", "w_y", "w_z", "a_x", "a_y", "a_z")
_FIELD_COLUMNS = ("m_x", "m_y", "m_z")
_HDF5_ENDINGS = (".hdf5", ".h5")


def read_imu_and_field(imu: Path, magnetometer: Path | None) -> tuple[ImuStream, FloatArray | None]:
    """The IMU's stream, and the magnetic field at its samples.

    Args:
        imu: EuRoC's CSV, or a trial of BROAD (.hdf5).
        magnetometer: a CSV of stamps (ns) and readings, on the IMU's clock and in its axes, at any
            rate; or `imu` once more where it holds them itself: in three more columns, or as BROAD
            does. None for no magnetometer.

    Returns:
        The stream; readings ``(N, 3)``, each at the first sample that is not before it, rows of
        NaN elsewhere, or None.

    Raises:
        RecordingError: what the readers refuse; force in g or rate in degrees, where the readings
            tell; no field within the IMU's time.
    """
    if imu.suffix.lower() in _HDF5_ENDINGS:
        stream, field = read_broad(imu)
        try:
            screen_imu(stream)
        except ValueError as fault:
            raise refusal(imu, str(fault)) from fault
        if magnetometer in (imu, None):
            return stream, None if magnetometer is None else field
    else:
        stream = read_imu(imu)
    if magnetometer is None:
        return stream, None
    columns = (*_IMU_COLUMNS, *_FIELD_COLUMNS) if magnetometer == imu else _FIELD_COLUMNS
    table = _table(magnetometer, columns)
    field = at_samples(stream.time_ns, table.time_ns, table.values[:, -3:])
    if np.all(np.isnan(field)):
        raise refusal(magnetometer, "expected readings within the time of the IMU, got none")
    return stream, field


def at_samples(imu_ns: IntArray, time_ns: IntArray, field: FloatArray) -> FloatArray:
    """Readings ``(M, 3)``, each put to the first of the samples ``(N,)`` that is not before it."""
    made = np.full((imu_ns.size, 3), np.nan)
    rows = np.searchsorted(imu_ns, time_ns)
    within = (time_ns >= imu_ns[0]) & (rows < imu_ns.size)
    made[rows[within]] = field[within]
    return made


def _table(path: Path, columns: tuple[str, ...]) -> Table:
    table = read_table(path, columns, separator=b",", unit="ns", header=True, more_columns=True)
    return table.rows(in_order(path, table.lines, table.time_ns))
