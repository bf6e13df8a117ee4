"""Trajectories as text: TUM, EuRoC and KITTI files, read and written without losing a digit; bags.

=========  ==========================================================================  ===========
format     one row                                                                     stamps
=========  ==========================================================================  ===========
``tum``    ``stamp tx ty tz qx qy qz qw``, white space between                         s
``euroc``  ``stamp, px, py, pz, qw, qx, qy, qz`` and any more columns, commas between  ns
``kitti``  the twelve numbers of a 3 by 4 matrix, row by row; before them the frame's  none
           number, where a column more says it
=========  ==========================================================================  ===========

In a comma file whose header names its columns, these may stand in any order and unit (see
`readers.columns`); where none does, ending and stamps say whose order it is. Metres; poses are
``parent_T_child``. Text rounds, so a quaternion whose norm is within 0.01 of 1 is normalised and a
matrix block that is within 0.01 of orthonormal (largest element of ``R^T R - 1``) is replaced by
the nearest rotation; what lies further off is refused.

A trajectory in a bag is named `flight.bag:/odom` or `flight.mcap:map/base_link`. A bag is a file
that ends in .bag, .bag.bz2, .mcap or .db3, or a ROS 2 bag's folder. What follows the colon is a
topic of poses, or two frames, which `trajectories` finds in the bag.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, cast, get_args

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import did_you_mean
from motorcade.replays.io.files import refusal, write_bytes
from motorcade.replays.io.readers.columns import POSITION, QUATERNION, read_columns, read_opening
from motorcade.replays.io.readers.tables import (
    REACH_M,
    UNIT_TOLERANCE,
    Table,
    data_rows,
    in_order,
    read_table,
)

if TYPE_CHECKING:
    from motorcade.fusion.orientation.estimate import Orientation

TrajectoryFormat = Literal["tum", "euroc", "kitti"]
_MOST_FRAMES = 1e9
_LOG = logging.getLogger("motorcade.replays")
# A similarity that differs by rounding from a rigid motion is one.
_SCALE_TOLERANCE = 1e-12
_TUM = ("tx", "ty", "tz", "qx", "qy", "qz", "qw")
_MATRIX = tuple(f"m{row}{column}" for row in (1, 2, 3) for column in (1, 2, 3, 4))
_SUFFIXES: dict[str, TrajectoryFormat] = {
    ".tum": "tum",
    ".txt": "tum",
    ".csv": "euroc",
    ".kitti": "kitti",
}
TEXT_SUFFIXES = tuple(_SUFFIXES)
"""Endings of files that may hold poses or inertial readings."""
_EUROC_HEADER = (
    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []"
)


def read_trajectory(
    path: Path | str,
    fmt: TrajectoryFormat | None = None,
    *,
    rate_hz: float | None = None,
    times: Path | str | None = None,
    first_row: int | None = None,
    parent: str | None = None,
    child: str | None = None,
) -> Trajectory:
    """Read a trajectory file, or a trajectory of a ROS bag.

    Args:
        path: the file, at most 1 GiB; or a bag and what is read of it, ``flight.bag:/odom`` or
            ``flight.mcap:map/base_link`` (see `readers.ros.trajectories`); or positions of
            satellite navigation, ``.gpx``, ``.nmea``, ``.ulg``, ``.bin`` (see `readers.positions`).
        fmt: its format; by default found from its first row of numbers.
        rate_hz: for KITTI files, poses per second; the first stamp is 0.
        times: for KITTI files instead, a file with one stamp in seconds a row.
        first_row: for KITTI files, which of these stamps the first pose has (0).
        parent: name of the frame that poses map to; by default world, or what a bag calls it.
        child: name of the frame that moves; by default camera, or what a bag calls it.

    Raises:
        RecordingError: missing file, no rows, wrong count of columns, NaN, decreasing stamps,
            rotations further than `UNIT_TOLERANCE` from unit; each with its line. Of rows with
            equal stamps the first is kept, and the log names the others.
        ValueError: KITTI without `rate_hz` or `times`, or with both, or another format with one.
    """
    file, named = Path(path), split_bag_name(path) if fmt is None else None
    if named is not None:
        from motorcade.replays.io.readers.ros.trajectories import read_bag_trajectory

        _refuse_stamps(file, "a bag", rate_hz, times)
        return read_bag_trajectory(*named, parent, child)
    if fmt is None and _holds_positions(file):
        from motorcade.replays.io.readers.positions import read_positions

        _refuse_stamps(file, "positions", rate_hz, times)
        return read_positions(file, parent, child)
    stated = fmt is not None
    fmt = trajectory_format(file) if fmt is None else _known(fmt)
    parent, child = parent or "world", child or "camera"
    if fmt == "kitti":
        return _read_kitti(file, rate_hz, times, first_row, parent, child)
    _refuse_stamps(file, fmt, rate_hz, times)
    if fmt == "euroc":
        last = not stated and _scalar_last(file)
        ordered = replace(QUATERNION, axes="xyzw" if last else "wxyz")
        table = read_columns(file, (POSITION, ordered))
        wxyz = table.values[:, [6, 3, 4, 5] if last else [3, 4, 5, 6]]
    else:
        table = read_table(file, _TUM, unit="s", header=True)
        table = table.rows(in_order(file, table.lines, table.time_ns))
        wxyz = table.values[:, [6, 3, 4, 5]]
    poses = quaternion_poses(table, wxyz, table.values[:, :3])
    return Trajectory(table.time_ns, poses, parent, child)


def write_trajectory(
    trajectory: Trajectory, path: Path | str, fmt: TrajectoryFormat | None = None
) -> None:
    """Write a trajectory file, all or nothing.

    Stamps are written exactly (nine decimals of a second in TUM) and every number with the digits
    that bring the same float64 back. KITTI files hold no stamps; keep them elsewhere.

    Args:
        trajectory: rigid poses ``(N,)``; similarities of scale 1 are.
        path: the file to write or replace.
        fmt: its format; by default from the name's ending: .tum and .txt, .csv (EuRoC), .kitti.

    Raises:
        ValueError: an unknown ending without `fmt`, or a pose with a scale other than 1, which no
            text format holds; `Trajectory.save` keeps it.
        OSError: the file cannot be written; what was there before is still there.
    """
    file = Path(path)
    if fmt is None:
        if file.suffix.lower() not in _SUFFIXES:
            known = ", ".join(_SUFFIXES)
            raise ValueError(f"{file}: expected a name ending in {known}, or the format given")
        fmt = _SUFFIXES[file.suffix.lower()]
    rows = {"tum": _tum_rows, "euroc": _euroc_rows, "kitti": _kitti_rows}[_known(fmt)]
    lines = rows(trajectory.time_ns, _rigid(trajectory, file))
    write_bytes(file, "\n".join([*lines, ""]).encode("ascii"))


def trajectory_format(path: Path) -> TrajectoryFormat:
    """Tell the format of a file from its first row of numbers.

    Raises:
        RecordingError: neither commas with at least 8 columns, nor 8, nor 12 columns.
    """
    for line, row in data_rows(path, None):
        text = b" ".join(row)
        if text[:1].isalpha() and not text.lower().startswith((b"nan", b"inf")):
            continue
        if text.count(b",") >= 7:
            return "euroc"
        if b"," not in text and len(row) in (8, 12, 13):
            return "tum" if len(row) == 8 else "kitti"
        raise refusal(
            path,
            "expected a trajectory (TUM: 8 columns, KITTI: 12 or 13, EuRoC: 8 or more, commas), "
            f"got {len(text.split(b',' if b',' in text else None))} columns",
            line=line,
        )
    raise refusal(path, "expected a trajectory, got no row of numbers")


def _scalar_last(path: Path) -> bool:
    """Whether a file with commas, whose header does not name them, has TUM's order: qw last.

    The ending says so; where it does not, eight columns with stamps in seconds are TUM's. What
    contradicts the ending is said in the log.
    """
    _, header, rows, *_ = read_opening(path, 1 + len(_TUM))
    if header is not None or any(len(row) != 1 + len(_TUM) for row in rows):
        return False
    by_stamps = any(b"." in row[0] and b"e" not in row[0].lower() for row in rows)
    by_ending = {".tum": True, ".csv": False}.get(path.suffix.lower(), by_stamps)
    if by_ending != by_stamps:
        _LOG.warning(
            "%s: quaternions are read with qw %s, as the ending says, though stamps are as in %s; "
            "a first line #timestamp,tx,ty,tz,qx,qy,qz,qw (in the file's order) decides",
            path,
            "last" if by_ending else "first",
            "EuRoC's files, where it is first" if by_ending else "TUM's files, where it is last",
        )
    return by_ending


def read_times(path: Path, unit: str = "s") -> tuple[IntArray, IntArray]:
    """Read a file of one stamp a row, strictly increasing: lines ``(N,)`` and stamps ``(N,)`` ns.

    Raises:
        RecordingError: no rows, more columns, no numbers, stamps that do not increase.
    """
    table = read_table(path, (), unit=unit)
    stalls = np.flatnonzero(np.diff(table.time_ns) <= 0)
    if stalls.size:
        at = int(stalls[0]) + 1
        raise refusal(
            path,
            f"expected increasing stamps, got {table.time_ns[at]} ns after "
            f"{table.time_ns[at - 1]} ns",
            line=int(table.lines[at]),
        )
    return table.lines, table.time_ns


def even_stamps(count: int, rate_hz: float) -> IntArray:
    """Stamps ``(count,)`` from 0 at a fixed rate, each rounded to a nanosecond by itself.

    Raises:
        ValueError: a rate that is not above 0 and at most 1e6 Hz.
    """
    if not 1e-6 <= rate_hz <= 1e6:
        raise ValueError(f"rate_hz: expected a rate from 1e-6 to 1e6 Hz, got {rate_hz}")
    stamps: IntArray = np.rint(np.arange(count) * (1e9 / rate_hz)).astype(np.int64)
    return stamps


def quaternion_poses(table: Table, wxyz: FloatArray, translation_m: FloatArray) -> Motor:
    """Make motors from rows of quaternions ``(N, 4)`` and translations ``(N, 3)`` of a table.

    Raises:
        RecordingError: a quaternion's norm further than `UNIT_TOLERANCE` from 1, or a translation
            beyond 1e9 m, with its line.
    """
    with np.errstate(over="ignore"):
        norm = np.sqrt(np.sum(wxyz * wxyz, axis=1))
    _refuse_rows(
        table,
        ~(np.abs(norm - 1.0) <= UNIT_TOLERANCE),
        norm,
        f"expected a unit quaternion (norm within {UNIT_TOLERANCE} of 1), got norm",
    )
    _refuse_far(table, translation_m)
    return Motor.from_quaternion_translation(wxyz / norm[:, None], translation_m)


def matrix_poses(table: Table, rotation: FloatArray, translation_m: FloatArray) -> Motor:
    """Make motors from rows of matrices ``(N, 3, 3)`` and translations ``(N, 3)`` of a table.

    Raises:
        RecordingError: a matrix further than `UNIT_TOLERANCE` from a rotation, or a translation
            beyond 1e9 m, with its line.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        gram = np.swapaxes(rotation, 1, 2) @ rotation
        excess = np.nan_to_num(np.abs(gram - np.eye(3)).max(axis=(1, 2)), nan=np.inf)
    problem = f"expected a rotation (R^T R within {UNIT_TOLERANCE} of 1), got a difference of"
    _refuse_rows(table, excess > UNIT_TOLERANCE, excess, problem)
    left, _, right = np.linalg.svd(rotation)
    nearest = left @ right
    determinant = np.linalg.det(nearest)
    _refuse_rows(
        table, determinant < 0.0, determinant, "expected a rotation, got a reflection, determinant"
    )
    _refuse_far(table, translation_m)
    return Motor.from_rotor_translation(Rotor.from_matrix(nearest), translation_m)


def _refuse_stamps(
    path: Path, read_as: str, rate_hz: float | None, times: Path | str | None
) -> None:
    if rate_hz is not None or times is not None:
        raise ValueError(
            f"rate_hz, times: only KITTI files lack stamps; {path} is read as {read_as}"
        )


def _read_kitti(
    path: Path,
    rate_hz: float | None,
    times: Path | str | None,
    first_row: int | None,
    parent: str,
    child: str,
) -> Trajectory:
    if (rate_hz is None) == (times is None):
        raise ValueError(
            f"{path}: KITTI files hold no stamps; give --times FILE with a stamp for every pose, "
            f"or --rate-hz HZ where poses come evenly (of a function: times, rate_hz); got "
            f"{'neither' if times is None else 'both'}"
        )
    numbered = _columns(path) > len(_MATRIX)
    table = read_table(path, ("frame", *_MATRIX) if numbered else _MATRIX)
    rows = _frame_numbers(table) if numbered else np.arange(len(table)) + (first_row or 0)
    if times is not None:
        _, time_ns = read_times(Path(times))
        counted = numbered or first_row is not None
        if rows[-1] >= len(time_ns) or (not counted and len(time_ns) != len(table)):
            problem = f"expected {len(time_ns)} poses for the stamps of {times}, got {len(table)}"
            raise refusal(path, problem if not counted else f"{problem} from row {rows[0]} on")
        time_ns = time_ns[rows]
    elif rate_hz is not None:
        time_ns = even_stamps(int(rows[-1]) + 1, rate_hz)[rows]
    matrices = table.values[:, -len(_MATRIX) :].reshape(-1, 3, 4)
    poses = matrix_poses(table, matrices[:, :, :3], matrices[:, :, 3])
    return Trajectory(time_ns, poses, parent, child)


def _columns(path: Path) -> int:
    return len(next(data_rows(path, None), (0, ()))[1])


def _frame_numbers(table: Table) -> IntArray:
    frames = table.values[:, 0]
    steps = np.diff(frames, prepend=-1.0)
    bad = ~((steps > 0.0) & (frames == np.floor(frames)) & (frames < _MOST_FRAMES))
    _refuse_rows(table, bad, frames, "expected rising numbers of frames from 0 on, got")
    return frames.astype(np.int64)


def check_rows(paths: Mapping[Path, Trajectory]) -> None:
    """Refuse KITTI files that only their rows pair, where they have not as many.

    Raises:
        ValueError: such files.
    """
    counts = {path: len(one) for path, one in paths.items()}
    bare = all(
        not is_only_read(path)
        and trajectory_format(path) == "kitti"
        and _columns(path) == len(_MATRIX)
        for path in counts
    )
    if bare and len(set(counts.values())) > 1:
        said = " and ".join(f"{count} in {path}" for path, count in counts.items())
        raise ValueError(
            f"expected as many poses in KITTI files, whose rows are paired, got {said}; --rows "
            "FROM says at which row of the reference an estimate begins (0: at its first), or a "
            "first column the frame of each pose"
        )


def _known(fmt: str) -> TrajectoryFormat:
    if fmt not in get_args(TrajectoryFormat):
        advice = did_you_mean(fmt, get_args(TrajectoryFormat))
        raise ValueError(f"fmt: expected a trajectory format, got {fmt!r}; {advice}")
    return cast("TrajectoryFormat", fmt)


def _refuse_rows(table: Table, bad: NDArray[np.bool_], amount: FloatArray, problem: str) -> None:
    if np.any(bad):
        row = int(np.flatnonzero(bad)[0])
        raise refusal(table.path, f"{problem} {amount[row]:.6g}", line=int(table.lines[row]))


def _refuse_far(table: Table, translation_m: FloatArray) -> None:
    reach = np.abs(translation_m).max(axis=1)
    _refuse_rows(table, reach > REACH_M, reach, f"expected a position within {REACH_M:g} m, got")


def _rigid(trajectory: Trajectory, path: Path) -> Motor:
    if not isinstance(trajectory.poses, Similarity):
        return trajectory.poses
    motors, scale = trajectory.poses.as_motor_scale()
    off = int(np.argmax(np.abs(scale - 1.0)))
    if abs(scale[off] - 1.0) > _SCALE_TOLERANCE:
        raise ValueError(
            f"{path}: expected poses of scale 1, which is all that this format holds, got scale "
            f"{float(scale[off]):.9g} at index {off}; a .npz file keeps it"
        )
    return motors


def _tum_rows(time_ns: IntArray, poses: Motor) -> Iterator[str]:
    wxyz, translation_m = poses.as_quaternion_translation()
    yield "# timestamp tx ty tz qx qy qz qw"
    numbers = np.concatenate([translation_m, wxyz[:, [1, 2, 3, 0]]], axis=1)
    for stamp, row in zip(time_ns.tolist(), numbers.tolist(), strict=True):
        seconds, rest = divmod(abs(stamp), 10**9)
        sign = "-" if stamp < 0 else ""
        yield f"{sign}{seconds}.{rest:09d} {' '.join(map(repr, row))}"


def _euroc_rows(time_ns: IntArray, poses: Motor) -> Iterator[str]:
    wxyz, translation_m = poses.as_quaternion_translation()
    yield _EUROC_HEADER
    numbers = np.concatenate([translation_m, wxyz], axis=1)
    for stamp, row in zip(time_ns.tolist(), numbers.tolist(), strict=True):
        yield f"{stamp},{','.join(map(repr, row))}"


def _kitti_rows(time_ns: IntArray, poses: Motor) -> Iterator[str]:
    for row in poses.as_matrix()[:, :3].reshape(-1, 12).tolist():
        yield " ".join(map(repr, row))


_HEADER = (
    "#timestamp [ns],tilt_deviation [rad],heading_deviation [rad],b_w_x [rad s^-1],"
    "b_w_y [rad s^-1],b_w_z [rad s^-1],field_deviation [rad],at_rest []"
)


def write_orientation(orientation: Orientation, path: Path) -> None:
    """Write ``world_T_imu`` with positions of 0; the name's ending says the format.

    Raises:
        ValueError: an unknown ending.
        OSError: a file that cannot be written.
    """
    poses = Motor.from_rotor_translation(
        orientation.world_R_imu, np.zeros((orientation.time_ns.size, 3))
    )
    write_trajectory(Trajectory(orientation.time_ns, poses, "world", "imu"), path)


def write_deviations(orientation: Orientation, path: Path) -> None:
    """Write what the filter expects of itself, a row a sample, as CSV.

    Raises:
        OSError: a file that cannot be written.
    """
    columns = np.column_stack(
        [
            orientation.tilt_deviation_rad,
            orientation.heading_deviation_rad,
            orientation.gyro_bias_rad_s,
            orientation.field_deviation_rad,
        ]
    )
    rows = zip(
        orientation.time_ns.tolist(), columns.tolist(), orientation.at_rest.tolist(), strict=True
    )
    lines = [f"{stamp},{','.join(map(repr, row))},{rest:d}" for stamp, row, rest in rows]
    write_bytes(path, "\n".join([_HEADER, *lines, ""]).encode("ascii"))


_BAG_SUFFIXES = (".bag", ".bag.bz2", ".mcap", ".db3")


def split_bag_name(name: Path | str) -> tuple[Path, str] | None:
    """The bag, and what is named in it ("" where nothing is); None where this is no bag's name.

    >>> split_bag_name("flight.bag:/odom")
    (PosixPath('flight.bag'), '/odom')
    >>> split_bag_name("flight.tum") is None
    True
    """
    text = str(name)
    if not text.lower().endswith(_BAG_SUFFIXES) and Path(text).is_file():
        return None
    places = [at for at, letter in enumerate(text) if letter == ":"]
    for at in (*places, len(text)):
        if is_bag(text[:at]):
            return Path(text[:at]), text[at + 1 :]
    return None


def is_only_read(name: Path | str) -> bool:
    """Whether this names a bag or a log of positions, which have stamps and are never written."""
    return split_bag_name(name) is not None or _holds_positions(Path(name))


_POSITION_SUFFIXES = (".gpx", ".nmea", ".nma", ".ulg", ".bin")


def _holds_positions(path: Path) -> bool:
    if path.is_dir():
        return (path / "timestamps.txt").is_file() or (path / "oxts" / "timestamps.txt").is_file()
    return path.name.lower().endswith(_POSITION_SUFFIXES)


def is_bag(path: Path | str) -> bool:
    """Whether this is the name of a bag's file, or a ROS 2 bag's folder."""
    text = str(path)
    return text.lower().endswith(_BAG_SUFFIXES) or (Path(text) / "metadata.yaml").is_file()
