"""IMU streams written to files: EuRoC's CSV, which `readers.inertial` reads back."""

from __future__ import annotations

from pathlib import Path

from motorcade.fusion.imu.stream import ImuStream
from motorcade.replays.files.atomic import write_bytes

__all__ = ["write_imu"]

_HEADER = (
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"
)


def write_imu(stream: ImuStream, path: Path) -> None:
    """Write a stream with every digit that its numbers have, all at once or not at all.

    Raises:
        OSError: a file that cannot be written.
    """
    rows = zip(
        stream.time_ns.tolist(),
        stream.angular_rate_rad_s.tolist(),
        stream.specific_force_m_s2.tolist(),
        strict=True,
    )
    lines = [f"{stamp},{','.join(map(repr, [*rate, *force]))}" for stamp, rate, force in rows]
    write_bytes(path, "\n".join([_HEADER, *lines, ""]).encode("ascii"))
