"""Positions of satellite navigation as paths: GPX, NMEA, flights' logs, KITTI's `oxts`, NavSatFix.

A path is in metres east, north and up of its first fix (`fusion.measurements.GeodeticOrigin`), on
WGS 84; its poses do not turn, except KITTI's, whose unit measures how it stands. Heights of GPX and
NMEA are above the sea: as heights over the ellipsoid they are off by the geoid, which over a path
is a constant. GPX is read by gpxpy, NMEA by pynmea2.

Logs of PX4 (`.ulg`, by pyulog; docs.px4.io, "ULog File Format") and of ArduPilot (`.bin`, which
states its formats; its libraries/AP_Logger): the IMU, the magnetometer, and satellite navigation.
Axes are the body's, x ahead, y right and z down; an accelerometer at rest reads -g along z, which
is +g upwards, as everywhere here.
"""

from __future__ import annotations

import logging
import struct
from array import array
from collections.abc import Callable, Iterable, Iterator
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.measurements.positions import GeodeticOrigin
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import admit_file, open_bounded, read_bounded, refusal, refusing
from motorcade.replays.io.readers.tables import stamp_ns

ULG_LIMIT = 2**30
_PX4, _ARDUPILOT = ".ulg", ".bin"
_IMU, _FIELD = "sensor_combined", "vehicle_magnetometer"
_POSITIONS = ("vehicle_gps_position", "sensor_gps")
_UT_A_GAUSS = 100.0


def is_flight_log(path: Path) -> bool:
    """Whether this is a log of PX4, by its ending, or of ArduPilot, by its first bytes too."""
    if not path.is_file() or path.suffix.lower() != _ARDUPILOT:
        return path.is_file() and path.suffix.lower() == _PX4
    with open_bounded(path, ULG_LIMIT) as file:
        return file.read(3) == _MARK + b"\x80"


def read_flight_log(path: Path) -> tuple[ImuStream, tuple[IntArray, FloatArray] | None]:
    """The stream of the first IMU, and stamps and magnetic field (µT) where there is one.

    Raises:
        RecordingError: no log, damaged, or without an IMU.
        ModuleNotFoundError: pyulog is not installed.
    """
    topics = _topics(path, (_IMU, _FIELD))
    if _IMU not in topics:
        raise refusal(path, f"expected the topic {_IMU}, or ArduPilot's IMU, got none")
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
    """Columns of the first instance of each topic that is there, as PX4 calls them."""
    if path.suffix.lower() == _ARDUPILOT:
        return {name: topic for name, topic in _messages(path) if name in names}
    from pyulog import ULog

    admit_file(path, ULG_LIMIT)
    try:
        log = ULog(str(path), list(names))
    except Exception as fault:  # the parser's errors have no common base
        reason = one_line(str(fault) or type(fault).__name__, 100)
        raise refusal(path, f"expected a log of PX4: {reason}") from fault
    topics = sorted(log.data_list, key=lambda topic: int(topic.multi_id), reverse=True)
    return {str(topic.name): topic.data for topic in topics if len(topic.data["timestamp"])}


_MARK = b"\xa3\x95"
_FORMATS = 0x80
_MOST_MESSAGES = 10_000_000
_MOST_LOST = 100_000
_KINDS = "V64 i1 u1 <i2 <u2 <i4 <u4 <i8 <u8 <f4 <f8 <f2 S4 S16 S64 u1 <i2 <u2 <i4 <u4 <i4"
_TYPES = dict(zip("abBhHiIqQfdgnNZMcCeEL", _KINDS.split(), strict=True))
_SCALES = {**dict.fromkeys("cCeE", 0.01), "L": 1e-7}
_PLACES = {"latitude_deg": "Lat", "longitude_deg": "Lng", "altitude_ellipsoid_m": "Alt"}
_AXES = {"gyro_rad": "Gyr", "accelerometer_m_s2": "Acc"}
_AS_PX4: dict[str, tuple[str, dict[str, str]]] = {
    "IMU": (
        _IMU,
        {f"{ours}[{k}]": own + "XYZ"[k] for ours, own in _AXES.items() for k in range(3)},
    ),
    "MAG": (_FIELD, {f"magnetometer_ga[{k}]": "Mag" + "XYZ"[k] for k in range(3)}),
    "GPS": (_POSITIONS[0], _PLACES | {"fix_type": "Status"}),
}
"""ArduPilot's messages as PX4's topics, and what their columns are called in both."""


def _messages(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Topics of a log of ArduPilot, of the first instance of each sensor.

    Bytes that are no message are left out, up to the next that may be one, and said.
    """
    data = read_bounded(path, ULG_LIMIT)
    lengths, kinds = {_FORMATS: 89}, dict[int, tuple[str, str, str]]()
    starts: dict[int, array[int]] = {}
    at, count, lost = 0, 0, 0
    while 0 <= at < len(data) - 2:
        kind = data[at + 2]
        length = lengths.get(kind, 0) if data.startswith(_MARK, at) else 0
        if not length or at + length > len(data):
            at, lost = data.find(_MARK, at + 1), lost + 1
        else:
            if kind in starts:
                starts[kind].append(at + 3)
            elif kind == _FORMATS:
                number, size, *texts = struct.unpack_from("<BB4s16s64s", data, at + 3)
                name, types, labels = (text.split(b"\0")[0].decode("latin-1") for text in texts)
                if number not in lengths and size > 3:
                    lengths[number] = size
                    if name in _AS_PX4 and name not in (known[0] for known in kinds.values()):
                        kinds[number], starts[number] = (name, types, labels), array("q")
            at += length
        count += 1
        if count > _MOST_MESSAGES or lost > _MOST_LOST:
            limits = f"{_MOST_MESSAGES} messages and {_MOST_LOST} damaged ones"
            raise refusal(path, f"expected at most {limits}, got more")
    if lost > 1:
        _LOG.warning("%s: %d messages are damaged, and left out", path, lost)
    for number, (name, types, labels) in kinds.items():
        if starts[number]:
            bodies = sliding_window_view(np.frombuffer(data, np.uint8), lengths[number] - 3)
            rows = bodies[np.frombuffer(starts[number], np.int64)]
            yield _AS_PX4[name][0], _columns(path, name, types, labels.split(","), rows)


def _columns(
    path: Path, name: str, types: str, labels: list[str], rows: NDArray[np.uint8]
) -> dict[str, Any]:
    if not set(types) <= _TYPES.keys() or len(types) != len(labels):
        raise refusal(path, f"expected types of ArduPilot's, got {one_line(types)}", field=name)
    kind = np.dtype([(str(at), _TYPES[letter]) for at, letter in enumerate(types)])
    if kind.itemsize != rows.shape[1]:
        raise refusal(path, "expected a format as long as its messages", field=name)
    table = rows.view(kind)[:, 0]
    held: dict[str, Any] = {}
    for at, (label, letter) in enumerate(zip(labels, types, strict=True)):
        if table[str(at)].dtype.kind in "iuf":
            with np.errstate(invalid="ignore"):
                held[label] = table[str(at)] * _SCALES.get(letter, 1)
    first = held["I"] == held["I"][0] if "I" in held else slice(None)
    try:
        time_us = held["TimeUS"] if "TimeUS" in held else 1000 * held["TimeMS"].astype(np.int64)
        columns = {ours: held[own][first] for ours, own in _AS_PX4[name][1].items()}
    except KeyError as fault:
        raise refusal(path, f"expected the column {fault}, got none", field=name) from fault
    if name == "MAG":
        columns = {ours: 1e-3 * values for ours, values in columns.items()}  # of milligauss
    return {"timestamp": time_us[first], **columns}


def _stamps(topic: dict[str, Any]) -> IntArray:
    return 1000 * np.asarray(topic["timestamp"]).astype(np.int64)


def _axes(topic: dict[str, Any], name: str) -> FloatArray:
    return np.stack([np.asarray(topic[f"{name}[{k}]"], np.float64) for k in range(3)], axis=-1)


def _rising(time_ns: IntArray) -> IntArray:
    """Rows whose stamp is later than all before: a restarted driver repeats some."""
    highest = np.maximum.accumulate(time_ns)
    return np.flatnonzero(np.diff(highest, prepend=highest[:1] - 1) > 0)


_LOG = logging.getLogger("motorcade.replays")
FILE_LIMIT = 2**26
PACKET_LIMIT = 2**12
MOST_FIXES = 10_000_000
_NMEA = (".nmea", ".nma")
_OXTS = 30
"""Numbers of a packet of KITTI's unit."""


def recognise(path: Path) -> bool:
    """Whether this is a file of positions, or a folder of KITTI's with `oxts`."""
    return _reader(path) is not None


def read_positions(path: Path, parent: str | None = None, child: str | None = None) -> Trajectory:
    """Positions as a path from 0 on, in metres east, north and up of the first.

    Raises:
        RecordingError: none of these files, damaged, or without fixes.
        ModuleNotFoundError: gpxpy, pynmea2, pyulog or pyproj is not installed.
    """
    reader = _reader(path)
    if reader is None:
        raise refusal(path, "expected positions: .gpx, .nmea, .ulg, .bin, or KITTI's oxts")
    return geodetic_path(path, *reader(path), parent, child)


def geodetic_path(
    path: Path,
    time_ns: IntArray,
    places: FloatArray,
    world_R_body: Rotor | None = None,
    parent: str | None = None,
    child: str | None = None,
) -> Trajectory:
    """The path of stamps ``(N,)`` and latitude, longitude (deg), height (m) ``(N, 3)``.

    Of fixes that are no later than one before, the first is kept. Heights that are missing are NaN:
    where all are, the path is level; else fixes without one are left out. Both are said.

    Raises:
        RecordingError: no fixes, or places that are none.
    """
    if not len(time_ns):
        raise refusal(path, "expected fixes with time and place, got none")
    high = np.isfinite(places[:, 2])
    if not high.any():
        _LOG.warning("%s: no fix has a height: the path is level", path)
        places = np.column_stack([places[:, :2], np.zeros(len(places))])
    elif not high.all():
        _LOG.warning("%s: %d fixes without a height are left out", path, np.count_nonzero(~high))
        time_ns, places = time_ns[high], places[high]
        world_R_body = world_R_body[high] if world_R_body is not None else None
    rows = np.flatnonzero(np.diff(np.maximum.accumulate(time_ns), prepend=time_ns[0] - 1) > 0)
    with refusing(path):
        origin = GeodeticOrigin(*places[rows[0]].tolist())
        local_m = origin.local_m(*places[rows].T)
        turns = world_R_body[rows] if world_R_body is not None else None
        poses = (
            Motor.from_translation(local_m)
            if turns is None
            else Motor.from_rotor_translation(turns, local_m)
        )
        result = Trajectory(time_ns[rows], poses, parent or "world", child or "antenna")
    latitude, longitude = places[rows[0], :2]
    _LOG.warning(
        "%s: metres east, north and up of %.7f, %.7f%s",
        path,
        latitude,
        longitude,
        "" if world_R_body is not None else "; positions do not turn",
    )
    return result


_Fixes = tuple[IntArray, FloatArray, Rotor | None]


def _reader(path: Path) -> Callable[[Path], _Fixes] | None:
    name = path.name.lower()
    if path.is_dir():
        return _read_oxts if oxts_folder(path) is not None else None
    if name.endswith(".gpx"):
        return _read_gpx
    if name.endswith(_NMEA):
        return _read_nmea
    return (lambda log: (*read_geodetic(log), None)) if is_flight_log(path) else None


def _fixes(rows: Iterable[tuple[int, float, float, float]], path: Path) -> _Fixes:
    kept = []
    for row in rows:
        kept.append(row)
        if len(kept) > MOST_FIXES:
            raise refusal(path, f"expected at most {MOST_FIXES} fixes, got more")
    stamps = np.array([row[0] for row in kept], dtype=np.int64)
    return stamps, np.array([row[1:] for row in kept], dtype=np.float64).reshape(-1, 3), None


def _read_gpx(path: Path) -> _Fixes:
    import gpxpy

    text = read_bounded(path, FILE_LIMIT).decode("utf-8", "replace")
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise refusal(path, "expected GPX without declarations of its own (<!DOCTYPE, <!ENTITY)")
    try:
        content = gpxpy.parse(text)
    except Exception as fault:  # of two parsers of XML, without a common base
        raise refusal(path, f"expected GPX: {one_line(fault, 100)}") from fault
    points = (
        (_nanoseconds(point.time), point.latitude, point.longitude, _height_m(point.elevation))
        for track in content.tracks
        for segment in track.segments
        for point in segment.points
        if point.time is not None
    )
    return _fixes(points, path)


def _height_m(value: float | str | None) -> float:
    """NaN where none is stated."""
    return float(value) if value not in (None, "") else float("nan")


def _nanoseconds(moment: datetime) -> int:
    """Since 1970; a time without a zone is UTC, as GPX has it."""
    whole = moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)
    seconds = whole.replace(microsecond=0).timestamp()
    return int(seconds) * 10**9 + whole.microsecond * 1000


def _read_nmea(path: Path) -> _Fixes:
    """GGA has the place, RMC the day; a fix before the first day counts from midnight of it."""
    import pynmea2

    day: date | None = None
    last_s, days, bad = -1.0, 0, 0
    rows: list[tuple[int, float, float, float]] = []
    for line in read_bounded(path, FILE_LIMIT).decode("ascii", "replace").splitlines():
        start = line.find("$")
        if start < 0 or len(line) - start > 200:
            continue
        try:
            sentence = pynmea2.parse(line[start:], check=True)
            kind = getattr(sentence, "sentence_type", "")
            if kind == "RMC" and day is None and sentence.datestamp is not None:
                day = sentence.datestamp
            if kind != "GGA" or not sentence.gps_qual or sentence.timestamp is None:
                continue
            clock = sentence.timestamp
            of_day_s = clock.hour * 3600 + clock.minute * 60 + clock.second
            days += int(of_day_s < last_s - 43_200)
            last_s = float(of_day_s)
            stamp = (days * 86_400 + of_day_s) * 10**9 + clock.microsecond * 1000
            height_m = _height_m(sentence.altitude)
            rows.append((stamp, sentence.latitude, sentence.longitude, height_m))
        except (pynmea2.ParseError, ValueError, TypeError, AttributeError):
            bad += 1
    if bad:
        _LOG.warning("%s: %d sentences are damaged, and left out", path, bad)
    midnight = 0
    if day is not None:
        midnight = int(datetime(day.year, day.month, day.day, tzinfo=UTC).timestamp()) * 10**9
    return _fixes(((midnight + row[0], *row[1:]) for row in rows), path)


def oxts_folder(path: Path) -> Path | None:
    """The folder with `timestamps.txt` and `data` of KITTI's unit: this one, or `oxts` in it."""
    folders = (path, path / "oxts")
    return next(
        (entry for entry in folders if (entry / "timestamps.txt").is_file() and _packets(entry)),
        None,
    )


def _packets(folder: Path) -> list[Path]:
    data = folder / "data"
    return sorted(data.glob("??????????.txt")) if data.is_dir() else []


def _oxts_table(path: Path) -> tuple[IntArray, FloatArray]:
    """Stamps ``(N,)`` and the numbers ``(N, 30)`` of the packets."""
    folder = oxts_folder(path) or path
    files = _packets(folder)
    lines = read_bounded(folder / "timestamps.txt", FILE_LIMIT).split(b"\n")
    texts = [line.strip() for line in lines if line.strip()]
    if len(texts) != len(files):
        problem = f"expected {len(files)} stamps for as many packets, got {len(texts)}"
        raise refusal(folder / "timestamps.txt", problem)
    rows = []
    for file in files:
        try:
            numbers = [float(token) for token in read_bounded(file, PACKET_LIMIT).split()]
        except ValueError as fault:
            raise refusal(file, "expected numbers") from fault
        if len(numbers) < _OXTS or not np.all(np.isfinite(numbers[:_OXTS])):
            raise refusal(file, f"expected {_OXTS} finite numbers, got {len(numbers)}")
        rows.append(numbers[:_OXTS])
    stamps = [_dated_ns(text, folder / "timestamps.txt") for text in texts]
    return np.array(stamps, dtype=np.int64), np.array(rows, dtype=np.float64)


def _dated_ns(text: bytes, path: Path) -> int:
    """`2011-09-26 13:02:25.964389445`, whose ninth decimal is kept."""
    try:
        day = datetime.fromisoformat(text[:10].decode("ascii")).replace(tzinfo=UTC)
        return int(day.timestamp()) * 10**9 + stamp_ns(text, "clock")
    except (ValueError, UnicodeDecodeError) as fault:
        raise refusal(path, f"expected a day and a time, got {one_line(text)}") from fault


def _read_oxts(path: Path) -> _Fixes:
    """Positions, and rotations by roll, pitch and yaw (from east, counter-clockwise)."""
    time_ns, numbers = _oxts_table(path)
    roll, pitch, yaw = numbers[:, 3:6].T
    none = np.zeros_like(yaw)
    about_z, about_y, about_x = (
        Rotor.from_rotation_vector(np.stack(axes, axis=-1))
        for axes in ((none, none, yaw), (none, pitch, none), (roll, none, none))
    )
    return time_ns, numbers[:, :3], about_z @ about_y @ about_x


def read_oxts_imu(path: Path) -> ImuStream:
    """Angular rate and specific force in the unit's axes (x ahead, y left, z up).

    Raises:
        RecordingError: files that are missing or damaged.
    """
    time_ns, numbers = _oxts_table(path)
    with refusing(path):
        return ImuStream(time_ns, numbers[:, 17:20], numbers[:, 11:14])
