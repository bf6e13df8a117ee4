"""Spectra of vibration from files: a CSV of frequencies and power spectral densities."""

from __future__ import annotations

from pathlib import Path

from motorcade.fusion.imu.vibration import VibrationSpectrum
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.readers.tables import read_table

_COLUMNS = ("frequency", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


def read_vibration(path: Path) -> VibrationSpectrum:
    r"""Read a spectrum: rows of Hz, (rad/s)²/Hz for three axes, and (m/s²)²/Hz for three.

    Densities are one-sided; a header is optional.

    Raises:
        RecordingError: no rows, wrong columns, frequencies that do not increase, numbers below 0.

    >>> import tempfile
    >>> from motorcade.replays.io.vibration import read_vibration
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "rotors.csv")
    ...     _ = path.write_text("50,0,0,0,0,0,0\n60,0,0,0,0.01,0.01,0.04\n70,0,0,0,0,0,0\n")
    ...     read_vibration(path).accel_rms_m_s2.round(3)
    array([0.316, 0.316, 0.632])
    """
    values = read_table(path, _COLUMNS, separator=b",", header=True).values
    try:
        return VibrationSpectrum(values[:, 0], values[:, 1:4], values[:, 4:])
    except ValueError as fault:
        raise refusal(path, str(fault)) from fault
