"""Logs of PX4 (`.ulg`), read by pyulog: the IMU, the magnetometer, and satellite navigation.

Axes are the body's, x ahead, y right and z down (PX4's `sensor_combined`); an accelerometer at rest
reads -g along z, which is +g upwards, as everywhere here. Format: docs.px4.io, "ULog File Format".
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import admit_file, refusal

FILE_LIMIT = 2**30
SUFFIX = ".ulg"
_IMU, _FIELD = "sensor_combined", "vehicle_magnetometer"
_POSITIONS = ("vehicle_gps_position", "sensor_gps")
_UT_A_GAUSS = 100.0


def recognise(path: Path) -> bool:
    """Whether this is a log, by its ending."""
    return path.is_file() and path.suffix.lower() == SUFFIX


def read(path: Path) -> tuple[ImuStream, tuple[IntArray, FloatArray] | None]:
    """The stream of the first IMU, and stamps and magnetic field (µT) where there is one.

    Raises:
        RecordingError: no log, damaged, or without an IMU.
        ModuleNotFoundError: pyulog is not installed.
    """
    topics = _topics(path, (_IMU, _FIELD))
    if _IMU not in topics:
        raise refusal(path, f"expected the topic {_IMU}, got none")
    try:
        time_ns = _stamps(topics[_IMU])
        rate, force = (_axes(topics[_IMU], name) for name in ("gyro_rad", "accelerometer_m_s2"))
        rows = _rising(time_ns)
        stream = ImuStream(time_ns[rows], rate[rows], force[rows])
        if _FIELD not in topics:
            return stream, None
        field_ns = _stamps(topics[_FIELD])
        rows = _rising(field_ns)
        return stream, (
            field_ns[rows],
            _UT_A_GAUSS * _axes(topics[_FIELD], "magnetometer_ga")[rows],
        )
    except (KeyError, ValueError) as fault:
        raise refusal(path, f"expected PX4's topics: {one_line(fault, 100)}") from fault


def read_geodetic(path: Path) -> tuple[IntArray, FloatArray]:
    """Stamps ``(N,)``, and latitude (deg), longitude (deg) and height (m) ``(N, 3)`` of its fixes.

    Raises:
        RecordingError: no log, damaged, or without satellite navigation.
        ModuleNotFoundError: pyulog is not installed.
    """
    topics = _topics(path, _POSITIONS)
    topic = next((topics[name] for name in _POSITIONS if name in topics), None)
    if topic is None:
        raise refusal(path, f"expected a topic of {' or '.join(_POSITIONS)}, got none")
    try:
        fixed = np.asarray(topic["fix_type"]) >= 3
        if "latitude_deg" in topic:
            names = ("latitude_deg", "longitude_deg", "altitude_ellipsoid_m")
            places = np.stack([np.asarray(topic[name], np.float64) for name in names], axis=-1)
        else:
            columns = (("lat", 1e-7), ("lon", 1e-7), ("alt_ellipsoid", 1e-3))
            places = np.stack(
                [unit * np.asarray(topic[name], np.float64) for name, unit in columns], axis=-1
            )
    except KeyError as fault:
        raise refusal(path, f"expected PX4's positions, got none of {fault}") from fault
    return _stamps(topic)[fixed], places[fixed]


def _topics(path: Path, names: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """Columns of the first instance of each topic that is there."""
    from pyulog import ULog

    admit_file(path, FILE_LIMIT)
    try:
        log = ULog(str(path), list(names))
    except Exception as fault:  # the parser's errors have no common base
        reason = one_line(str(fault) or type(fault).__name__, 100)
        raise refusal(path, f"expected a log of PX4: {reason}") from fault
    topics = sorted(log.data_list, key=lambda topic: int(topic.multi_id), reverse=True)
    return {str(topic.name): topic.data for topic in topics if len(topic.data["timestamp"])}


def _stamps(topic: dict[str, Any]) -> IntArray:
    return 1000 * np.asarray(topic["timestamp"]).astype(np.int64)


def _axes(topic: dict[str, Any], name: str) -> FloatArray:
    return np.stack([np.asarray(topic[f"{name}[{k}]"], np.float64) for k in range(3)], axis=-1)


def _rising(time_ns: IntArray) -> IntArray:
    """Rows whose stamp is later than all before: a restarted driver repeats some."""
    highest = np.maximum.accumulate(time_ns)
    return np.flatnonzero(np.diff(highest, prepend=highest[:1] - 1) > 0)
