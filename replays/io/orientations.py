"""Estimated orientations to files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.fusion.orientation.estimate import Orientation
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.atomic import write_bytes
from motorcade.replays.io.trajectories import write_trajectory

_HEADER = (
    "#timestamp [ns],tilt_deviation [rad],heading_deviation [rad],b_w_x [rad s^-1],"
    "b_w_y [rad s^-1],b_w_z [rad s^-1],field_deviation [rad],at_rest []"
)


def write_orientation(found: Orientation, path: Path) -> None:
    """Write ``world_T_imu`` with positions of 0; the name's ending says the format.

    Raises:
        ValueError: an unknown ending.
        OSError: a file that cannot be written.
    """
    poses = Motor.from_rotor_translation(found.world_R_imu, np.zeros((found.time_ns.size, 3)))
    write_trajectory(Trajectory(found.time_ns, poses, "world", "imu"), path)


def write_deviations(found: Orientation, path: Path) -> None:
    """Write what the filter expects of itself, a row a sample, as CSV.

    Raises:
        OSError: a file that cannot be written.
    """
    columns = np.column_stack(
        [
            found.tilt_deviation_rad,
            found.heading_deviation_rad,
            found.gyro_bias_rad_s,
            found.field_deviation_rad,
        ]
    )
    rows = zip(found.time_ns.tolist(), columns.tolist(), found.at_rest.tolist(), strict=True)
    lines = [f"{stamp},{','.join(map(repr, row))},{rest:d}" for stamp, row, rest in rows]
    write_bytes(path, "\n".join([_HEADER, *lines, ""]).encode("ascii"))
