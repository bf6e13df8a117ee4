"""Apps that log a phone's sensors, a CSV each, in a folder or a zip.

Sensor Logger (`TotalAcceleration.csv`, `Gravity.csv`, `Metadata.csv`) and phyphox name files after
sensors (`Gyroscope.csv`). The gyroscope's stamps are kept and the force is interpolated to them
(`io.imu.join_sensors`). Sources: Sensor Logger's UNITS.md and CROSSPLATFORM.md; of phyphox the
columns that its export writes, in Android's convention on every phone.

Force must hold gravity, +g upwards: where the accelerometer's file does not, that of gravity is
added. Apple's sign is the opposite of Android's; Sensor Logger notes the platform.
"""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path, PurePosixPath
from zipfile import BadZipFile, ZipFile

import numpy as np

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.errors import RecordingError, refusal
from motorcade.replays.io.files import open_bounded
from motorcade.replays.io.imu import join_sensors
from motorcade.replays.io.readers.columns import (
    ANGULAR_RATE,
    MAGNETIC_FIELD,
    SPECIFIC_FORCE,
    Quantity,
    read_columns,
)
from motorcade.replays.io.readers.tables import data_rows

_LOG = logging.getLogger("motorcade.replays")
ZIP_LIMIT = 2**30
_MOST_PARTS = 1000
_PART_LIMIT = 2**28
_BLOCK = 2**20
_GYRO = ("gyroscope", "gyro", "rotationrate", "gyroscopeuncalibrated")
_FORCE = ("totalacceleration", "accelerometer", "acceleration", "accelerometeruncalibrated")
_FIELD = ("magnetometer", "magneticfield", "magnetometeruncalibrated")
_GRAVITY_M_S2 = 9.80665
_WITH_GRAVITY = 0.2
"""How far, as a share of gravity, the median size of readings that hold it may be from it."""


def recognise(path: Path) -> bool:
    """Whether this is a folder, or a zip, with files of a gyroscope and an accelerometer."""
    if path.is_file() and path.suffix.lower() == ".zip":
        return True
    names = _sensors(path) if path.is_dir() else {}
    return all(any(name in names for name in known) for known in (_GYRO, _FORCE))


def read(path: Path) -> tuple[ImuStream, tuple[IntArray, FloatArray] | None]:
    """The stream, and stamps and magnetic field (µT) where a magnetometer was logged.

    Raises:
        RecordingError: no such files, readings without gravity, or what `read_columns` refuses.
    """
    try:
        with _folder(path) as folder:
            return _read(folder, path)
    except RecordingError:
        raise
    except ValueError as fault:
        raise refusal(path, str(fault)) from fault


def _read(folder: Path, path: Path) -> tuple[ImuStream, tuple[IntArray, FloatArray] | None]:
    files = _sensors(folder)
    gyro, force = (_first(files, names) for names in (_GYRO, _FORCE))
    if gyro is None or force is None:
        listed = ", ".join(sorted(map(one_line, files))) or "no CSV"
        problem = "expected files of a gyroscope and an accelerometer"
        raise refusal(path, f"{problem} (Gyroscope.csv, Accelerometer.csv), got {listed}")
    gyro_ns, rate = _values(gyro, ANGULAR_RATE, path)
    force_ns, felt = _values(force, SPECIFIC_FORCE, path)
    gravity = files.get("gravity")
    if gravity is not None and not _holds_gravity(felt):
        gravity_ns, pull = _values(gravity, SPECIFIC_FORCE, path)
        since_ns, known_ns = force_ns - force_ns[0], gravity_ns - force_ns[0]
        at = [np.interp(since_ns, known_ns, axis) for axis in pull.T]
        felt = felt + np.stack(at, axis=-1)
    if not _holds_gravity(felt):
        size = float(np.median(np.linalg.norm(felt, axis=1)))
        raise refusal(
            path,
            f"expected readings that hold gravity, got {size:.3g} m/s² in {one_line(force.name)}",
            advice="log the total acceleration, or gravity beside it",
        )
    if _is_apples(files.get("metadata")):
        _LOG.warning("%s: forces are turned about, since Apple counts them downwards", path)
        felt = -felt
    stream = join_sensors(gyro_ns, rate, force_ns, felt)
    magnetometer = _first(files, _FIELD)
    return stream, None if magnetometer is None else _values(magnetometer, MAGNETIC_FIELD, path)


def _holds_gravity(force: FloatArray) -> bool:
    size = float(np.median(np.linalg.norm(force, axis=1)))
    return abs(size - _GRAVITY_M_S2) < _WITH_GRAVITY * _GRAVITY_M_S2


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
        except (BadZipFile, NotImplementedError, EOFError, OSError, RuntimeError) as fault:
            raise refusal(path, f"expected a zip: {one_line(fault, 100)}") from fault
        yield Path(place)


def _unpack(archive: ZipFile, folder: Path, path: Path) -> None:
    """Write its CSV files of the uppermost folder that has any, within bounds."""
    parts = [part for part in archive.infolist() if part.filename.lower().endswith(".csv")]
    if len(archive.infolist()) > _MOST_PARTS:
        raise refusal(path, f"expected at most {_MOST_PARTS} files, got {len(archive.infolist())}")
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
