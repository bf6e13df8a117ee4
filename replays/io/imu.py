"""IMU streams and noise from and to files.

A stream is EuRoC's CSV: stamp in ns, angular rate in rad/s, specific force in m/s²; or, a third as
large and thirty times as quick to read, an ``.npz`` of the same three arrays. Streams that move in
other units are refused; saturation and gaps are written to the log.

Spectra of vibration from files: a CSV of frequencies and power spectral densities.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.screening import refuse_units_of_force, screen_imu
from motorcade.fusion.imu.stream import STANDARD_GRAVITY_M_S2, ImuStream
from motorcade.fusion.imu.vibration import VibrationSpectrum
from motorcade.ga.archives import load_arrays, save_arrays_in_parts
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import FileError
from motorcade.ga.names import one_line
from motorcade.ga.stamps import near_steps
from motorcade.replays.io.files import refusal, refused, refusing, replacing
from motorcade.replays.io.readers.columns import (
    ANGULAR_RATE,
    GRAVITY,
    MAYBE_FREE,
    SPECIFIC_FORCE,
    Quantity,
    names_quantity,
    read_columns,
    stamp_column,
)
from motorcade.replays.io.readers.tables import read_table

_LOG = logging.getLogger("motorcade.replays")
_FORMAT = "motorcade imu 1"
_WITH_GRAVITY = 0.8
_ARRAYS = ("time_ns", "angular_rate_rad_s", "specific_force_m_s2")


def read_imu(path: Path) -> ImuStream:
    """Read an IMU stream as EuRoC writes it, or as its header says; more columns are ignored.

    A header that names all columns (`gyro_x [deg/s]`, `angular_velocity.x`, `ax (g)`) is heeded,
    whatever their order and units; see `readers.columns`. An ``.npz`` is read as `write_imu` writes
    it.

    Raises:
        RecordingError: no rows, wrong columns, NaN, decreasing stamps, a header that leaves open
            what stands where, each with its line; force in g or rate in degrees, where the readings
            tell.
    """
    with refusing(path):
        stream = _stream(path)
        for notice in screen_imu(stream):
            _LOG.warning("%s: %s", path, notice)
        return stream


def _stream(path: Path) -> ImuStream:
    if path.suffix == ".npz":
        with refused():
            return load_arrays(path, "a saved IMU stream", _FORMAT, _from_arrays)
    free, whole = (names_quantity(path, quantity) for quantity in (MAYBE_FREE, SPECIFIC_FORCE))
    name, of_force = (free, MAYBE_FREE) if free and not whole else (whole or b"", SPECIFIC_FORCE)
    stream = _rate_and_force(path, of_force)
    if of_force is MAYBE_FREE:
        refuse_units_of_force(stream)
        gravity = read_columns(path, (GRAVITY,)) if names_quantity(path, GRAVITY) else None
        pull = None if gravity is None else (gravity.time_ns, gravity.values)
        felt = with_gravity(stream.time_ns, stream.specific_force_m_s2, pull, one_line(name))
        stream = replace(stream, specific_force_m_s2=felt)
    if _APPLES.match(name):
        _LOG.warning("%s: forces are turned about, since Apple counts them downwards", path)
        stream = replace(stream, specific_force_m_s2=-stream.specific_force_m_s2)
    return stream


_APPLES = re.compile(rb"(?i)\W*(?:accelerometerAcceleration|(?:motion)?User_?Acceleration)")
"""How Core Motion's accelerations are called, by SensorLog and by Apple."""


def _rate_and_force(path: Path, of_force: Quantity) -> ImuStream:
    """Rows of both, or each sensor by its own stamps where the file has such."""
    both = (ANGULAR_RATE, of_force)
    named = all(names_quantity(path, quantity) for quantity in both)
    if named and len({stamp_column(path, quantity) for quantity in both}) > 1:
        gyro, accel = (read_columns(path, (quantity,)) for quantity in both)
        return join_sensors(gyro.time_ns, gyro.values, accel.time_ns, accel.values)
    table = read_columns(path, both)
    return ImuStream(table.time_ns, table.values[:, :3], table.values[:, 3:])


def with_gravity(
    time_ns: IntArray, felt: FloatArray, gravity: tuple[IntArray, FloatArray] | None, name: str
) -> FloatArray:
    """Force ``(N, 3)`` as it was felt where it holds gravity, else with that of another sensor.

    Readings hold gravity where most of the other sensor's is in them, or, without one, where their
    median size is 0.8 of it at least.

    Raises:
        ValueError: readings without gravity, and none to add.
    """
    if gravity is not None:
        since_ns, known_ns = time_ns - time_ns[0], gravity[0] - time_ns[0]
        at = [np.interp(since_ns, known_ns, axis) for axis in gravity[1].T]
        pull = np.stack(at, axis=-1)
        if np.sum(felt * pull) < 0.5 * np.sum(pull * pull):
            felt = felt + pull
    size = float(np.median(np.linalg.norm(felt, axis=1)))
    if size < _WITH_GRAVITY * STANDARD_GRAVITY_M_S2:
        raise ValueError(
            f"expected readings that hold gravity, got {size:.3g} m/s² in {name}; log the whole "
            "acceleration, or gravity beside it"
        )
    return felt


def join_sensors(
    gyro_ns: IntArray, rate: FloatArray, accel_ns: IntArray, force: FloatArray
) -> ImuStream:
    """One stream of a gyroscope ``(N,)``, ``(N, 3)`` and an accelerometer ``(M,)``, ``(M, 3)``.

    The gyroscope's stamps are kept, and the force is interpolated linearly to them. Where the
    accelerometer is silent (outside its time, or in its gaps), so is the stream.

    Raises:
        ValueError: fewer than two stamps at which both read; what `ImuStream` refuses.

    >>> import numpy as np
    >>> rate, force = np.zeros((4, 3)), np.array([[0.0, 0.0, 9.0], [0.0, 0.0, 10.0]])
    >>> stream = join_sensors(np.array([0, 1, 2, 3]), rate, np.array([1, 3]), force)
    >>> stream.specific_force_m_s2[:, 2]
    array([ 9. ,  9.5, 10. ])
    """
    after = np.clip(np.searchsorted(accel_ns, gyro_ns), 1, max(len(accel_ns) - 1, 1))
    both = np.zeros(len(gyro_ns), dtype=np.bool_)
    if len(accel_ns) > 1:
        both = (gyro_ns >= accel_ns[0]) & (gyro_ns <= accel_ns[-1])
        both &= near_steps(np.diff(accel_ns))[after - 1]
    if np.count_nonzero(both) < 2:
        raise ValueError("expected both sensors at once, got one after the other")
    at = (gyro_ns[both] - accel_ns[0]).astype(np.float64)
    known = (accel_ns - accel_ns[0]).astype(np.float64)
    resampled = np.stack([np.interp(at, known, column) for column in force.T], axis=-1)
    return ImuStream(gyro_ns[both], rate[both], resampled)


def _from_arrays(arrays: Mapping[str, NDArray[Any]]) -> ImuStream:
    return ImuStream(*(arrays[name] for name in _ARRAYS))


def read_noise(path: Path) -> ImuNoise:
    """Read noise densities from a YAML file of Kalibr's or EuRoC's.

    Raises:
        RecordingError: missing, not YAML, or a density that is missing or not above 0.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.replays import read_noise
    >>> kalibr = '''
    ... gyroscope_noise_density: 1.7e-4
    ... gyroscope_random_walk: 1.9e-5
    ... accelerometer_noise_density: 2.0e-3
    ... accelerometer_random_walk: 3.0e-3
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = Path(folder, "imu.yaml").write_text(kalibr)
    ...     noise = read_noise(Path(folder, "imu.yaml"))
    >>> noise.gyro_density_rad_s_rthz, noise.accel_walk_m_s3_rthz
    (0.00017, 0.003)
    """
    try:
        return ImuNoise.load(path)
    except FileError as fault:
        raise refusal(path, fault.problem) from fault
    except ValueError as fault:
        raise refusal(path, str(fault).removeprefix(f"{path}: ")) from fault


def kalibr_noise(noise: ImuNoise) -> dict[str, float]:
    """Noise densities under the names that Kalibr and EuRoC use, as `read_noise` takes them."""
    return {
        "gyroscope_noise_density": noise.gyro_density_rad_s_rthz,
        "gyroscope_random_walk": noise.gyro_walk_rad_s2_rthz,
        "accelerometer_noise_density": noise.accel_density_m_s2_rthz,
        "accelerometer_random_walk": noise.accel_walk_m_s3_rthz,
    }


EUROC_HEADER = (
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
)


def write_imu(stream: ImuStream | Iterable[ImuStream], path: Path) -> None:
    """Write a stream with every digit that its numbers have, all at once or not at all.

    Args:
        stream: one, or its parts one after another, each of which is written as it comes.
        path: ``.npz``, or EuRoC's CSV under any other name.

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
    parts = [stream] if isinstance(stream, ImuStream) else stream
    with replacing(path) as building:
        if path.suffix == ".npz":
            columns = ({name: getattr(part, name) for name in _ARRAYS} for part in parts)
            save_arrays_in_parts(building, "ImuStream", _FORMAT, columns)
        else:
            with building.open("w", encoding="ascii", newline="\n") as file:
                file.write(EUROC_HEADER)
                for part in parts:
                    file.writelines(_rows(part))


def _rows(stream: ImuStream) -> Iterator[str]:
    rows = zip(
        stream.time_ns.tolist(),
        stream.angular_rate_rad_s.tolist(),
        stream.specific_force_m_s2.tolist(),
        strict=True,
    )
    for stamp, (x, y, z), (u, v, w) in rows:
        yield f"{stamp},{x!r},{y!r},{z!r},{u!r},{v!r},{w!r}\n"


_COLUMNS = ("frequency", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


def read_vibration(path: Path) -> VibrationSpectrum:
    r"""Read a spectrum: rows of Hz, (rad/s)²/Hz for three axes, and (m/s²)²/Hz for three.

    Densities are one-sided; a header is optional.

    Raises:
        RecordingError: no rows, wrong columns, frequencies that do not increase, numbers below 0.

    >>> import tempfile
    >>> from motorcade.replays.io.imu import read_vibration
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "rotors.csv")
    ...     _ = path.write_text("50,0,0,0,0,0,0\n60,0,0,0,0.01,0.01,0.04\n70,0,0,0,0,0,0\n")
    ...     read_vibration(path).accel_rms_m_s2.round(3)
    array([0.316, 0.316, 0.632])
    """
    values = read_table(path, _COLUMNS, separator=b",", header=True).values
    with refusing(path):
        return VibrationSpectrum(values[:, 0], values[:, 1:4], values[:, 4:])
