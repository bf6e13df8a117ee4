"""Where a camera sits on an IMU, as files of several programs say it."""

from __future__ import annotations

import json
from pathlib import Path

from motorcade.ga import Motor
from motorcade.ga.names import one_line
from motorcade.replays.io.door import read_bounded
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.transforms import TRANSFORM_LIMIT, read_transform

_KEYS = ("imu_T_camera_wxyz", "imu_T_camera_translation_m")


def read_extrinsics(path: Path) -> Motor:
    """Read ``imu_T_camera``: camera coordinates to the IMU's.

    Args:
        path: what `motorcade sync --json` or `motorcade fuse --json` wrote, a Kalibr chain (YAML,
            its first camera), a transform as evo writes it (JSON with x to qw), or 4 by 4 numbers.

    Raises:
        RecordingError: missing, none of these, or with a scale.
    """
    if path.suffix.lower() in (".yaml", ".yml"):
        from motorcade.replays.io.readers.kalibr import read_chain

        place = read_chain(path)[0].imu_T_camera
        if place is None:
            raise refusal(path, "expected T_cam_imu or T_imu_cam of cam0, got neither")
        return place
    data = read_bounded(path, TRANSFORM_LIMIT)
    if data.lstrip().startswith(b"{") and all(key.encode() in data for key in _KEYS):
        return _of_sync(path, data)
    found = read_transform(path)
    if not isinstance(found, Motor):
        raise refusal(path, "expected a rigid motion, got one with a scale")
    return found


def read_offset(path: Path) -> float | None:
    """What a Kalibr chain says that the IMU's clock is ahead of its first camera's, in seconds.

    None: a chain without `timeshift_cam_imu`, or another file: both say nothing of clocks.

    Raises:
        RecordingError: as of `read_extrinsics`.
    """
    if path.suffix.lower() not in (".yaml", ".yml"):
        return None
    from motorcade.replays.io.readers.kalibr import read_chain

    return read_chain(path)[0].offset_s


def _of_sync(path: Path, data: bytes) -> Motor:
    try:
        given = json.loads(data)
        turn, place = ([float(one) for one in given[key]] for key in _KEYS)
        if len(turn) != 4 or len(place) != 3 or not abs(sum(q * q for q in turn) - 1.0) < 1e-3:
            raise ValueError(f"a unit quaternion and a place, got {turn}, {place}")
        return Motor.from_quaternion_translation(turn, place)
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as fault:
        told = one_line(fault, 100)
        raise refusal(path, f"expected {' and '.join(_KEYS)}: {told}") from fault
