"""IMU streams and noise from and to files.

A stream is EuRoC's CSV: stamp in ns, angular rate in rad/s, specific force in m/s². Streams that
move in other units are refused; saturation and gaps are written to the log.
"""

from __future__ import annotations

import logging
from pathlib import Path

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.screening import screen_imu
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.files import FileError
from motorcade.replays.errors import RecordingError, refusal
from motorcade.replays.files.atomic import write_bytes
from motorcade.replays.readers.tables import in_order, read_table

_LOG = logging.getLogger("motorcade.replays")
_COLUMNS = ("w_x", "w_y", "w_z", "a_x", "a_y", "a_z")


def read_imu(path: Path) -> ImuStream:
    """Read an IMU stream as EuRoC writes it; more columns are ignored, a header is optional.

    Raises:
        RecordingError: no rows, wrong columns, NaN, decreasing stamps, each with its line; force
            in g or rate in degrees, where the readings tell.
    """
    try:
        stream = _stream(path)
        for notice in screen_imu(stream):
            _LOG.warning("%s: %s", path, notice)
        return stream
    except RecordingError:
        raise
    except ValueError as fault:
        raise refusal(path, str(fault)) from fault


def _stream(path: Path) -> ImuStream:
    table = read_table(path, _COLUMNS, separator=b",", unit="ns", header=True, more_columns=True)
    table = table.rows(in_order(path, table.lines, table.time_ns))
    return ImuStream(table.time_ns, table.values[:, :3], table.values[:, 3:])


def read_noise(path: Path) -> ImuNoise:
    """Read noise densities from a YAML file of Kalibr's or EuRoC's.

    Raises:
        RecordingError: missing, not YAML, or a density that is missing or not above 0.
    """
    try:
        return ImuNoise.load(path)
    except FileError as fault:
        raise refusal(path, fault.problem) from fault
    except ValueError as fault:
        raise refusal(path, str(fault).removeprefix(f"{path}: ")) from fault


_HEADER = (
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"
)


def write_imu(stream: ImuStream, path: Path) -> None:
    """Write a stream with every digit that its numbers have, all at once or not at all.

    Raises:
        OSError: a file that cannot be written.

    >>> import tempfile
    >>> import numpy as np
    >>> from pathlib import Path
    >>> from motorcade.fusion import ImuStream
    >>> from motorcade.replays import read_imu, write_imu
    >>> at_rest = np.array([[0.0, 0.0, 9.81]] * 3)  # an accelerometer at rest reads +g upward
    >>> stream = ImuStream(np.array([0, 5_000_000, 10_000_000]), np.zeros((3, 3)), at_rest)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_imu(stream, Path(folder, "imu.csv"))
    ...     again = read_imu(Path(folder, "imu.csv"))
    >>> np.array_equal(again.specific_force_m_s2, at_rest)
    True
    """
    rows = zip(
        stream.time_ns.tolist(),
        stream.angular_rate_rad_s.tolist(),
        stream.specific_force_m_s2.tolist(),
        strict=True,
    )
    lines = [f"{stamp},{','.join(map(repr, [*rate, *force]))}" for stamp, rate, force in rows]
    write_bytes(path, "\n".join([_HEADER, *lines, ""]).encode("ascii"))
