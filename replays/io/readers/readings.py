"""Inertial readings of whatever holds them, recognised once for every command that takes them.

A bag (`BAG:/topic` names one of its topics), a video with telemetry, a trial of BROAD, a log of PX4
or ArduPilot, a folder or zip of a phone's logger, KITTI's `oxts`, a recording with an IMU, or a
table of text. Some hold a magnetometer's readings besides.

Trials of BROAD: D. Laidig et al., "BROAD: A benchmark for robust inertial orientation estimation",
Data 6(7), 2021; samples are evenly spaced, so that stamps are counted from 0.

Phones' loggers write a CSV a sensor: Sensor Logger (`TotalAcceleration.csv`, `Gravity.csv`,
`Metadata.csv`; its UNITS.md and CROSSPLATFORM.md) and phyphox, in Android's convention on every
phone. The gyroscope's stamps are kept and the force is interpolated to them. Where that holds no
gravity, that of gravity's file is added. Apple's sign is the opposite of Android's.
"""

from __future__ import annotations

import logging
import math
import tempfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING
from zipfile import BadZipFile, ZipFile

import numpy as np

from motorcade.fusion.imu.screening import screen_imu
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import admit_file
from motorcade.ga.names import one_line
from motorcade.replays.io.files import RecordingError, open_bounded, refusal, refusing
from motorcade.replays.io.imu import join_sensors, read_imu, with_gravity
from motorcade.replays.io.readers import manifest as manifests
from motorcade.replays.io.readers.columns import (
    ANGULAR_RATE,
    MAGNETIC_FIELD,
    SPECIFIC_FORCE,
    Quantity,
    names_quantity,
    read_columns,
)
from motorcade.replays.io.readers.frames import video
from motorcade.replays.io.readers.gopro import read_telemetry
from motorcade.replays.io.readers.layouts import euroc
from motorcade.replays.io.readers.opening import open_recording, recording_and_topic
from motorcade.replays.io.readers.positions import (
    is_flight_log,
    oxts_folder,
    read_flight_log,
    read_oxts_imu,
)
from motorcade.replays.io.readers.ros import recording as ros
from motorcade.replays.io.readers.tables import data_rows

if TYPE_CHECKING:
    import h5py


_LOG = logging.getLogger("motorcade.replays")
ZIP_LIMIT = 2**30
_BROKEN = (BadZipFile, NotImplementedError, EOFError, OSError, RuntimeError, zlib.error)
_MOST_PARTS = 1000
_PART_LIMIT = 2**28
_BLOCK = 2**20
_GYRO = ("gyroscope", "gyro", "rotationrate", "gyroscopeuncalibrated")
_FORCE = ("totalacceleration", "accelerometer", "acceleration", "accelerometeruncalibrated")
_FIELD = ("magnetometer", "magneticfield", "magnetometeruncalibrated")


def _is_phone_log(path: Path) -> bool:
    """Whether this is a folder, or a zip, with files of a gyroscope and an accelerometer."""
    if path.is_file() and path.suffix.lower() == ".zip":
        return True
    names = _sensors(path) if path.is_dir() else {}
    return all(any(name in names for name in known) for known in (_GYRO, _FORCE))


def _read_phone_log(folder: Path, path: Path) -> tuple[ImuStream, Field | None]:
    """The stream of what lies in a folder, and stamps and magnetic field (µT) where it was logged.

    Raises:
        RecordingError: no such files, readings without gravity, or what `read_columns` refuses.
    """
    files = _sensors(folder)
    gyro, force = (_first(files, names) for names in (_GYRO, _FORCE))
    if len(files) == 1 and folder != path:
        return _of_table(next(iter(files.values())), True)
    if gyro is None or force is None:
        listed = ", ".join(sorted(map(one_line, files))) or "no CSV"
        problem = "expected files of a gyroscope and an accelerometer"
        raise refusal(path, f"{problem} (Gyroscope.csv, Accelerometer.csv), got {listed}")
    gyro_ns, rate = _values(gyro, ANGULAR_RATE, path)
    force_ns, felt = _values(force, SPECIFIC_FORCE, path)
    gravity = files.get("gravity")
    pull = None if gravity is None else _values(gravity, SPECIFIC_FORCE, path)
    felt = with_gravity(force_ns, felt, pull, one_line(force.name))
    if _is_apples(files.get("metadata")):
        _LOG.warning("%s: forces are turned about, since Apple counts them downwards", path)
        felt = -felt
    stream = join_sensors(gyro_ns, rate, force_ns, felt)
    magnetometer = _first(files, _FIELD)
    return stream, None if magnetometer is None else _values(magnetometer, MAGNETIC_FIELD, path)


def _sensors(folder: Path) -> dict[str, Path]:
    """The CSV files of a folder, by their names without case and blanks."""
    files = (path for path in sorted(folder.iterdir()) if path.suffix.lower() == ".csv")
    return {"".join(path.stem.lower().split()).replace("_", ""): path for path in files}


def _first(files: dict[str, Path], names: tuple[str, ...]) -> Path | None:
    return next((files[name] for name in names if name in files), None)


def _values(file: Path, quantity: Quantity, path: Path) -> tuple[IntArray, FloatArray]:
    """Stamps and readings of a file that is one sensor's, whose columns may be axes alone."""
    alone = replace(quantity, letters=quantity.letters | {""})
    try:
        table = read_columns(file, (alone,))
    except RecordingError as fault:  # of a file that may have been unpacked
        raise refusal(path, str(fault).removeprefix(f"{file.parent}/")) from fault
    return table.time_ns, table.values


def _is_apples(metadata: Path | None) -> bool:
    """Whether Sensor Logger says that an iPhone wrote its own convention."""
    if metadata is None:
        return False
    rows = [row for _, row in zip(range(2), data_rows(metadata, b","), strict=False)]
    if len(rows) < 2:
        return False
    said = dict(zip((token.strip() for token in rows[0][1]), rows[1][1], strict=False))
    apple = said.get(b"platform", b"").strip().lower() == b"ios"
    return apple and said.get(b"standardisation", b"").strip().lower() != b"true"


@contextmanager
def _folder(path: Path) -> Iterator[Path]:
    """The folder itself, or the CSV files of a zip in a folder of their own."""
    if path.is_dir():
        yield path
        return
    with tempfile.TemporaryDirectory() as place:
        try:
            with open_bounded(path, ZIP_LIMIT) as file, ZipFile(file) as archive:
                _unpack(archive, Path(place), path)
        except _BROKEN as fault:
            raise refusal(path, f"expected a zip: {one_line(fault, 100)}") from fault
        yield Path(place)


def _unpack(archive: ZipFile, folder: Path, path: Path) -> None:
    """Write its CSV files of the uppermost folder that has any, within bounds."""
    parts = [part for part in archive.infolist() if part.filename.lower().endswith(".csv")]
    if len(archive.infolist()) > _MOST_PARTS:
        raise refusal(path, f"expected at most {_MOST_PARTS} files, got {len(archive.infolist())}")
    if not parts:
        held = ", ".join(one_line(part.filename, 40) for part in archive.infolist()[:3])
        problem = f"expected a zip of a logger's CSV files, got {held or 'an empty one'}"
        advice = f"unpack it (unzip {path.name}), and give the folder or the file within"
        raise refusal(
            path, f"{problem} and others" if len(archive.infolist()) > 3 else problem, advice=advice
        )
    depths = [len(PurePosixPath(part.filename).parts) for part in parts]
    left = ZIP_LIMIT
    for part, depth in zip(parts, depths, strict=True):
        if depth > min(depths):
            continue
        with (
            archive.open(part) as packed,
            (folder / PurePosixPath(part.filename).name).open("wb") as plain,
        ):
            size = 0
            while block := packed.read(_BLOCK):
                size, left = size + len(block), left - len(block)
                if size > _PART_LIMIT or left < 0:
                    limits = f"{_PART_LIMIT} bytes a file and {ZIP_LIMIT} in all"
                    raise refusal(path, f"expected at most {limits} unpacked, got more")
                plain.write(block)


_HDF5_ENDINGS = (".hdf5", ".h5")
Field = tuple[IntArray, FloatArray]
"""Stamps ``(M,)`` and readings ``(M, 3)`` of a magnetometer, in the IMU's axes."""


@dataclass(frozen=True)
class SensorReadings:
    """What was read.

    Fields:
        imu: the stream.
        field: of a magnetometer, None where none is held.
        held_by: what it was read as, in words.
    """

    imu: ImuStream
    field: Field | None
    held_by: str


def read_readings(path: Path, *, with_field: bool = True) -> SensorReadings:
    """Read the IMU, and a magnetometer beside it where `with_field` asks for one and it has one.

    Raises:
        RecordingError: nothing that is known, no IMU, or what the readers refuse; force in g or
            rate in degrees, where the readings tell.
        ModuleNotFoundError: a library that reads this kind is not installed.
    """
    held_by, read = _source(path)
    imu, field = read(path, with_field)
    if imu is None:
        problem = "expected accelerometer and gyroscope, got a recording without them"
        raise refusal(path, problem)
    with refusing(path):
        notices = screen_imu(imu) if held_by in _UNSCREENED else ()
    for notice in notices:
        _LOG.warning("%s: %s", path, notice)
    return SensorReadings(imu, field, held_by)


def is_log_of_readings(path: Path) -> bool:
    """Whether a path is a log: of PX4, BROAD, a phone's logger, or KITTI's oxts."""
    return _source(path)[0] in _LOGS


def read_imu_of(path: Path) -> ImuStream:
    """The inertial readings alone; raises as `read_readings`."""
    return read_readings(path, with_field=False).imu


_Read = Callable[[Path, bool], tuple[ImuStream | None, Field | None]]


def _source(path: Path) -> tuple[str, _Read]:
    """What a path holds readings as, and its reader."""
    bag, topic = recording_and_topic(path)
    known: tuple[tuple[bool, str, _Read], ...] = (
        (topic is not None or ros.recognise(bag), "a ROS bag", _of_bag),
        (video.recognise(path), "a video's telemetry", lambda at, _: (read_telemetry(at), None)),
        (path.suffix.lower() in _HDF5_ENDINGS, "a trial of BROAD", _of_broad),
        (is_flight_log(path), "a flight's log", lambda entry, _: read_flight_log(entry)),
        (_is_phone_log(path), "a phone's logger", _of_phone),
        (bool(oxts_folder(path)), "KITTI's oxts", lambda at, _: (read_oxts_imu(at), None)),
        (path.is_dir(), "a recording", _of_recording),
    )
    return next(((what, read) for holds, what, read in known if holds), ("a table", _of_table))


_LOGS = {"a trial of BROAD", "a flight's log", "a phone's logger", "KITTI's oxts"}
_UNSCREENED = _LOGS | {"a video's telemetry"}
"""Kinds whose own readers do not look for units and axes that cannot be."""


def _of_bag(path: Path, with_field: bool) -> tuple[ImuStream | None, Field | None]:
    bag, topic = recording_and_topic(path)
    if topic is None and (bag / manifests.LOCAL_NAME).exists():
        return _of_recording(bag, with_field)
    field = ros.read_bag_field(bag) if with_field else None
    return ros.read_beside_chain(bag, topic), field


def _of_broad(path: Path, _: bool) -> tuple[ImuStream, Field]:
    stream, field = read_broad(path)
    return stream, (stream.time_ns, field)


def _of_phone(path: Path, _: bool) -> tuple[ImuStream, Field | None]:
    with refusing(path), _folder(path) as folder:
        return _read_phone_log(folder, path)


def _of_recording(path: Path, _: bool) -> tuple[ImuStream | None, None]:
    if euroc.recognise(path) and not (path / manifests.LOCAL_NAME).exists():
        return euroc.read_own_imu(path), None
    return open_recording(path).imu, None


def _of_table(path: Path, with_field: bool) -> tuple[ImuStream, Field | None]:
    stream = read_imu(path)
    if not with_field or path.suffix == ".npz" or not names_quantity(path, MAGNETIC_FIELD):
        return stream, None
    table = read_columns(path, (MAGNETIC_FIELD,))
    return stream, (table.time_ns, table.values)


def read_imu_and_field(
    path: Path, magnetometer: Path | None
) -> tuple[ImuStream, FloatArray | None]:
    """The IMU's stream, and the magnetic field at its samples.

    Args:
        path: whatever holds readings.
        magnetometer: a CSV of stamps (ns) and readings, on the IMU's clock and in its axes, at any
            rate; or `path` once more where it holds them itself: by its header, in three more
            columns, or as its kind does. None for no magnetometer.

    Returns:
        The stream; readings ``(N, 3)``, each at the first sample that is not before it, rows of
        NaN elsewhere, or None.

    Raises:
        RecordingError: as `read_readings`; no magnetometer, or none within the IMU's time.
    """
    own = magnetometer == path
    readings = read_readings(path, with_field=own)
    if magnetometer is None:
        return readings.imu, None
    field = readings.field if own else None
    if field is None:
        if own and readings.held_by != "a table":
            raise refusal(path, "expected a magnetometer, got none")
        alone = replace(MAGNETIC_FIELD, letters=MAGNETIC_FIELD.letters | {""})
        columns = (ANGULAR_RATE, SPECIFIC_FORCE, MAGNETIC_FIELD) if own else (alone,)
        table = read_columns(magnetometer, columns)
        field = table.time_ns, table.values[:, -3:]
    at = at_samples(readings.imu.time_ns, *field)
    if np.all(np.isnan(at)):
        raise refusal(magnetometer, "expected readings within the time of the IMU, got none")
    return readings.imu, at


def at_samples(imu_ns: IntArray, time_ns: IntArray, field: FloatArray) -> FloatArray:
    """Readings ``(M, 3)``, each put to the first of the samples ``(N,)`` that is not before it."""
    placed = np.full((imu_ns.size, 3), np.nan)
    rows = np.searchsorted(imu_ns, time_ns)
    within = (time_ns >= imu_ns[0]) & (rows < imu_ns.size)
    placed[rows[within]] = field[within]
    return placed


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
    with refusing(path):
        return ImuStream(stamps, gyro, accel), field


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
