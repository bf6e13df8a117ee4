"""Poses as other libraries keep them, read into trajectories and written back as they came.

==========================  ========================================  ==========================
what comes                  how it is read                            stamps
==========================  ========================================  ==========================
array ``(N, 7)``            x, y, z, then qx, qy, qz, qw              `time_s`
array ``(N, 8)``            the same behind a stamp in seconds (TUM)  first column
array ``(N, 4, 4)``         homogeneous matrices, or their first      `time_s`
or ``(N, 3, 4)``            three rows
list of any such rows       as the array                              as the array
positions ``(N, 3)`` and    a `Rotor` or scipy ``Rotation``, whose    `time_s`
rotations                   maker is told the order of quaternions
array ``(B, N, 7)`` …       B bodies, each for itself                 `time_s`, for all of them
torch tensor                as the array                              as the array
Motor, Similarity ``(N,)``                                            `time_s`
scipy ``Rotation``          rotations about a point that stays        `time_s`
scipy ``RigidTransform``                                              `time_s`
list of gtsam ``Pose3``                                               `time_s`
pandas ``DataFrame``        columns x, y, z, qx, qy, qz, qw, or as    a column or the index
                            ROS names them: pose.position.x, …
evo ``PoseTrajectory3D``                                              its own
evo ``PosePath3D``                                                    `time_s`
dict of any of these        each for itself                           `time_s`, for all of them
==========================  ========================================  ==========================

Arrays of floats come back in their own precision. A quaternion's sign comes back as it was given.
Poses at other times have the sign of the nearest given one, and of tables and of evo's trajectories
what stood beside the poses is left out. Other libraries are not imported: what comes brings its
own.
"""

from __future__ import annotations

import copy
import datetime
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats
from motorcade.ga.names import did_you_mean
from motorcade.ga.stamps import STAMP_LIMIT_NS, checked_stamps

R = TypeVar("R")

# Quaternions that were written with three digits are off by no more.
_ROUNDED = 2e-3
_POSES = ("x", "y", "z", "qx", "qy", "qz", "qw")
_STAMPS = ("time_s", "timestamp", "time", "stamp", "t")
# As tables of ROS messages name the same columns, behind what leads to them.
_ROS_POSES = tuple(
    (*(f"{position}{mark}{axis}" for axis in "xyz"), *(f"{turn}{mark}{axis}" for axis in "xyzw"))
    for mark in "._/"
    for position, turn in (("position", "orientation"), ("translation", "rotation"))
)
_ROS_STAMP = "header.stamp"
# Integers as large are nanoseconds: as seconds they would be beyond any stamp.
_NANOSECONDS = 10**16


@dataclass(frozen=True, eq=False)
class GivenPoses:
    """Poses as somebody keeps them.

    Fields:
        trajectory: the same as a trajectory.
        written: a trajectory as they are kept. The stamps of others than those given are the second
            argument, in the unit that they came in; None where they are the same.
        stamped: whether times are nanoseconds, as of trajectories, or what `time_s` may be.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.smoothing.given import each_path
        >>> rows = np.array([[0, 0, 0, 0, 0, 0, 1.0], [1, 0, 0, 0, 0, 0, 1.0]])
        >>> given = each_path(rows, [0.0, 0.5], lambda one: one)
        >>> given.trajectory
        Trajectory(world_T_camera, 2 poses, 0.500 s)
        >>> bool(np.all(given.written(given.trajectory, None) == rows))
        True
    """

    trajectory: Trajectory
    written: Callable[[Trajectory, Any], Any]
    stamped: bool = False

    def stamps_of(self, times: Any) -> IntArray:
        """Times ``(M,)``, as these poses are stamped, in nanoseconds.

        Raises:
            ValueError: none, or no times.
        """
        stamps = np.asarray(times)
        if self.stamped and stamps.dtype.kind != "O" and stamps.dtype.kind not in "mM":
            return checked_stamps(stamps, "times")
        return nanoseconds_of(times, stamps.size, "times")


def with_trajectories(poses: Any, time_s: Any, verb: Callable[[Trajectory], Trajectory]) -> Any:
    """Do something with given poses as trajectories, and give the result as they came.

    Args:
        poses: a `Trajectory`, or what the table of this module names.
        time_s: ``(N,)`` seconds, datetimes or numpy datetime64, for what has no stamps.
        verb: keeps the stamps.

    Raises:
        TypeError: poses of a kind that is not in the table.
        ValueError: poses without stamps, stamps that do not fit, or numbers that are no poses.
    """
    written = each_path(poses, time_s, lambda body: body.written(verb(body.trajectory), None))
    return _stacked(written, poses)


def each_path(poses: Any, time_s: Any, use: Callable[[GivenPoses], R]) -> Any:
    """What a function makes of given poses; of a dict a dict of it, of a stack a list.

    Args:
        poses: as `with_trajectories`.
        time_s: as there.
        use: of the poses of each body.

    Raises:
        TypeError: as there.
        ValueError: as there.
    """
    if isinstance(poses, Trajectory):
        if time_s is not None:
            raise ValueError("time_s: expected none beside a trajectory, which has its own stamps")
        return use(GivenPoses(poses, lambda trajectory, _: trajectory, stamped=True))
    if getattr(poses, "shape", None) and 0 in poses.shape:
        raise ValueError(f"poses: expected at least one, got an array of shape {poses.shape}")
    if isinstance(poses, dict):
        return {name: each_path(one, time_s, use) for name, one in poses.items()}
    if _library(poses) == "torch":
        return each_path(
            poses.detach().cpu().numpy(), time_s, lambda body: use(_as_tensors(body, poses))
        )
    if _bodies(poses):
        return [each_path(one, time_s, use) for one in poses]
    return use(_read(poses, time_s))


def _as_tensors(poses: GivenPoses, like: Any) -> GivenPoses:
    def written(trajectory: Trajectory, times: Any) -> Any:
        tensor = sys.modules["torch"].from_numpy(poses.written(trajectory, times)).to(like.device)
        return tensor.to(like.dtype) if like.is_floating_point() else tensor

    return replace(poses, written=written)


def _stacked(bodies: Any, like: Any) -> Any:
    """Bodies that came as a stack as one."""
    if isinstance(like, dict):
        return {name: _stacked(one, like[name]) for name, one in bodies.items()}
    if not isinstance(bodies, list) or isinstance(like, list):
        return bodies
    return (sys.modules["torch"] if _library(like) == "torch" else np).stack(bodies)


def _library(instance: Any) -> str:
    return type(instance).__module__.partition(".")[0]


def _bodies(poses: Any) -> bool:
    if not isinstance(poses, np.ndarray):
        return False
    shape = poses.shape
    return shape[2:] in ((7,), (8,)) or (len(shape) == 4 and shape[2:] in ((3, 4), (4, 4)))


def _read(poses: Any, time_s: Any) -> GivenPoses:
    kind = type(poses).__name__
    if isinstance(poses, Motor | Similarity):
        return GivenPoses(_stamped(poses, time_s), lambda trajectory, _: trajectory.poses)
    if isinstance(poses, np.ndarray):
        return _array(poses, time_s)
    if _library(poses) == "scipy" and kind in ("Rotation", "RigidTransform"):
        return _scipy(poses, time_s)
    if _library(poses) == "pandas" and kind == "DataFrame":
        return _table(poses, time_s)
    if _library(poses) == "evo" and kind in ("PoseTrajectory3D", "PosePath3D"):
        return _evo(poses, time_s)
    if isinstance(poses, list) and poses and type(poses[0]).__name__ == "Pose3":
        return _pose3(poses, time_s)
    if isinstance(poses, tuple) and len(poses) == 2 and np.shape(poses[0])[1:] == (3,):
        return _positions_and_rotations(poses, time_s)
    if (
        isinstance(poses, list | tuple)
        and poses
        and isinstance(poses[0], list | tuple | np.ndarray)
    ):
        return _rows(poses, time_s)
    raise TypeError(
        "poses: expected a Trajectory, an array (N, 7), (N, 8), (N, 3, 4) or (N, 4, 4), a list of "
        "its rows, positions beside a Rotor or scipy's Rotation, a torch tensor, scipy's Rotation "
        "or RigidTransform, a pandas DataFrame, evo's PoseTrajectory3D or PosePath3D, a list "
        f"of gtsam's Pose3 or a dict of these, got {type(poses).__name__}"
    )


def _stamped(poses: Motor | Similarity, time_s: Any) -> Trajectory:
    return Trajectory(nanoseconds_of(time_s, len(poses)), poses)


def _from_rows(rows: FloatArray) -> Motor:
    lost = np.flatnonzero(~np.isfinite(rows).all(axis=-1))
    if lost.size:
        raise ValueError(
            f"poses: expected finite numbers in every row, got {lost.size} with NaN or infinity: "
            f"{listed(lost)}; leave these rows and their stamps out"
        )
    wxyz = checked_floats(rows[:, [6, 3, 4, 5]], "poses", (4,))
    length = np.linalg.norm(wxyz, axis=-1, keepdims=True)
    off = float(np.max(np.abs(length - 1.0)))
    if off > _ROUNDED:
        raise ValueError(
            f"poses: expected unit quaternions qx, qy, qz, qw, got a length off by {off:.3g}"
        )
    return Motor.from_quaternion_translation(wxyz / length, rows[:, :3])


def _to_rows(trajectory: Trajectory, like_wxyz: FloatArray, like_ns: IntArray) -> FloatArray:
    """Rows ``(M, 7)`` with the signs of the quaternions ``(N, 4)`` at the nearest of stamps."""
    wxyz, translation = trajectory.motors.as_quaternion_translation()
    if not np.array_equal(trajectory.time_ns, like_ns):
        after = np.clip(np.searchsorted(like_ns, trajectory.time_ns), 1, max(1, len(like_ns) - 1))
        late = (
            len(like_ns) > 1
            and trajectory.time_ns - like_ns[after - 1] > like_ns[after] - trajectory.time_ns
        )
        like_wxyz = like_wxyz[np.where(late, after, after - 1)]
    wxyz *= np.where(np.sum(wxyz * like_wxyz, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    return np.concatenate([translation, wxyz[:, 1:], wxyz[:, :1]], axis=-1)


def _array(array: np.ndarray[Any, Any], time_s: Any) -> GivenPoses:
    precision = array.dtype if array.dtype.kind == "f" else np.dtype(np.float64)
    if array.dtype.kind == "c":
        raise ValueError(f"poses: expected real numbers, got dtype {array.dtype}")
    numbers = without_mask(array, "poses").astype(np.float64)
    if numbers.ndim == 3 and numbers.shape[1:] in ((3, 4), (4, 4)):
        kept = numbers.shape[1]
        whole = np.concatenate(
            [numbers, np.tile([0.0, 0.0, 0.0, 1.0], (len(numbers), 4 - kept, 1))], 1
        )
        path = _stamped(Motor.from_matrix(whole), time_s)
        return GivenPoses(
            path, lambda trajectory, _: trajectory.motors.as_matrix()[:, :kept].astype(precision)
        )
    if numbers.ndim != 2 or numbers.shape[1] not in (7, 8):
        raise ValueError(
            "poses: expected an array (N, 7) of x, y, z, qx, qy, qz, qw, (N, 8) with a stamp "
            f"before it, (N, 3, 4) or (N, 4, 4), got {array.shape}"
        )
    rows, own = numbers[:, -7:], numbers.shape[1] == 8
    if own:
        if time_s is not None:
            raise ValueError("time_s: expected none beside rows that begin with a stamp")
        time_s = numbers[:, 0]
    path = _stamped(_from_rows(rows), time_s)

    def written(trajectory: Trajectory, times: Any) -> np.ndarray[Any, Any]:
        out = _to_rows(trajectory, rows[:, [6, 3, 4, 5]], path.time_ns)
        if own:
            out = np.column_stack([time_s if times is None else _seconds(trajectory, times), out])
        return out.astype(precision)

    return GivenPoses(path, written)


def _rows(sequence: Any, time_s: Any) -> GivenPoses:
    """Rows in a list or tuple, of numbers or of arrays, which come back in a list."""
    try:
        poses = _array(np.asarray(sequence, dtype=np.float64), time_s)
    except TypeError as no_numbers:
        raise TypeError(f"poses: expected rows of numbers, {no_numbers}") from no_numbers
    in_arrays = isinstance(sequence[0], np.ndarray)

    def written(trajectory: Trajectory, times: Any) -> Any:
        rows = poses.written(trajectory, times)
        return list(rows) if in_arrays else rows.tolist()

    return replace(poses, written=written)


def _positions_and_rotations(pair: tuple[Any, Any], time_s: Any) -> GivenPoses:
    """Positions beside rotations that know their own order, as bare quaternions do not.

    No recording tells it: to read qx, qy, qz, qw for qw, qx, qy, qz inverts every rotation between
    two that are constant, so that a path is as smooth, and turns by as much, in either order.
    """
    positions, turns = pair
    if not isinstance(turns, Rotor) and _library(turns) != "scipy":
        raise ValueError(
            "poses: expected rotations beside the positions that tell the order of their "
            f"quaternions, got {type(turns).__name__}; give Rotor.from_quaternion(quaternions) "
            "where these are qw, qx, qy, qz, scipy's Rotation.from_quat(quaternions) where they "
            "are qx, qy, qz, qw"
        )
    own = isinstance(turns, Rotor)
    xyzw = turns.as_quaternion()[..., [1, 2, 3, 0]] if own else turns.as_quat()
    if np.shape(xyzw) != (len(positions), 4):
        raise ValueError(
            f"poses: expected {len(positions)} rotations, one beside each position, got shape "
            f"{np.shape(xyzw)[:-1]}"
        )
    poses = _array(np.column_stack([positions, xyzw]), time_s)

    def written(trajectory: Trajectory, times: Any) -> Any:
        rows = poses.written(trajectory, times)
        back = rows[:, [6, 3, 4, 5]] if own else rows[:, 3:]
        return rows[:, :3], Rotor.from_quaternion(back) if own else type(turns).from_quat(back)

    return replace(poses, written=written)


def _seconds(trajectory: Trajectory, times: Any) -> FloatArray:
    """Other times as the seconds that poses were stamped with."""
    stamps = np.asarray(times)
    return np.asarray(
        stamps if stamps.dtype.kind in "fiu" else 1e-9 * trajectory.time_ns, dtype=np.float64
    )


def _scipy(transforms: Any, time_s: Any) -> GivenPoses:
    kind = type(transforms)
    if kind.__name__ == "RigidTransform":
        path = _stamped(Motor.from_matrix(transforms.as_matrix()), time_s)
        return GivenPoses(
            path, lambda trajectory, _: kind.from_matrix(trajectory.motors.as_matrix())
        )
    wxyz = np.atleast_2d(transforms.as_quat())[:, [3, 0, 1, 2]]
    turned = Motor.from_rotor_translation(Rotor.from_quaternion(wxyz), np.zeros((len(wxyz), 3)))
    path = _stamped(turned, time_s)

    def written(trajectory: Trajectory, _: Any) -> Any:
        return kind.from_quat(_to_rows(trajectory, wxyz, path.time_ns)[:, 3:])

    return GivenPoses(path, written)


def _table(table: Any, time_s: Any) -> GivenPoses:
    columns = [str(one) for one in table.columns]
    poses = _pose_columns(columns)
    spare = [name for name in columns if name not in poses]
    stamps = [*_STAMPS, *(name for name in columns if name.endswith(_ROS_STAMP))]
    for name in (*poses, *stamps):
        if columns.count(name) > 1:
            raise ValueError(
                f"poses: expected one column of a name, got {columns.count(name)} named {name}"
            )
    named = [name for name in stamps if name in columns]
    kept = named[0] if named and time_s is None else None
    if time_s is None:
        time_s = _index(table, spare) if kept is None else table[kept].to_numpy()
        if time_s.dtype.kind in "iu" and np.all(time_s > _NANOSECONDS):
            time_s = time_s.astype("m8[ns]")
    rows = np.column_stack([_column(table, name) for name in poses])
    path = _stamped(_from_rows(rows), time_s)

    def written(trajectory: Trajectory, times: Any) -> Any:
        moved = _to_rows(trajectory, rows[:, [6, 3, 4, 5]], path.time_ns)
        if times is None:
            out = table.copy()
            out[poses] = moved
            return out
        if kept is None:
            return type(table)(moved, columns=poses, index=times)
        return type(table)(moved, columns=poses).assign(**{kept: times})[[kept, *poses]]

    return GivenPoses(path, written)


def _pose_columns(columns: list[str]) -> list[str]:
    """Those of x, y, z, qx, qy, qz, qw, by these names or as ROS has them."""
    by_ros = [
        [name.removesuffix(ends[0]) + end for end in ends]
        for ends in _ROS_POSES
        for name in columns
        if name.endswith(ends[0])
    ]
    whole = [names for names in by_ros if set(names) <= set(columns)]
    if len(whole) > 1:
        raise ValueError(
            f"poses: expected the columns of one pose, got those of {whole[0][0]} and of "
            f"{whole[1][0]}; leave the others out"
        )
    if whole and not set(_POSES) <= set(columns):
        return whole[0]
    for name in _POSES:
        if name not in columns:
            raise ValueError(
                f"poses: expected columns {', '.join(_POSES)}, got none named {name}; "
                + _near_column(name, [other for other in columns if other not in _POSES])
            )
    return list(_POSES)


def _column(table: Any, name: str) -> FloatArray:
    """The numbers ``(N,)`` of a table's column."""
    if table[name].dtype.kind == "c":
        raise ValueError(f"poses: expected real numbers in column {name}, got complex ones")
    try:
        return np.asarray(table[name].to_numpy(dtype=np.float64))
    except (TypeError, ValueError) as no_numbers:
        raise ValueError(f"poses: expected numbers in column {name}, {no_numbers}") from no_numbers


def _near_column(name: str, spare: list[str]) -> str:
    """Advice on a column's name: the same but for its case, else the nearest of those unused."""
    alike = [one for one in spare if one.lower() == name]
    return f"did you mean {alike[0]}?" if alike else did_you_mean(name, spare)


def _index(table: Any, spare: list[str]) -> Any:
    """The index, where it is one of stamps and not of row numbers."""
    stamps = table.index
    if getattr(stamps, "tz", None) is not None:
        stamps = stamps.tz_convert("UTC").tz_localize(None)
    if stamps.dtype.kind in "mMf":
        return stamps.to_numpy()
    near = [one for one in spare if "time" in one.lower() or "stamp" in one.lower()]
    advice = f"; did you mean {near[0]}?" if near else ""
    raise ValueError(
        f"time_s: expected a column named {', '.join(_STAMPS)}, an index of stamps, or time_s"
        + advice
    )


def _evo(evo_path: Any, time_s: Any) -> GivenPoses:
    stamped = type(evo_path).__name__ == "PoseTrajectory3D"
    if stamped and time_s is not None:
        raise ValueError("time_s: expected none beside evo's trajectory, which has its own stamps")
    wxyz = np.asarray(evo_path.orientations_quat_wxyz, dtype=np.float64)
    poses = Motor.from_quaternion_translation(wxyz, evo_path.positions_xyz)
    path = _stamped(poses, evo_path.timestamps if stamped else time_s)

    def written(trajectory: Trajectory, times: Any) -> Any:
        rows = _to_rows(trajectory, wxyz, path.time_ns)
        own = {}
        if stamped:
            seconds = evo_path.timestamps if times is None else _seconds(trajectory, times)
            own["timestamps"] = np.array(seconds)
        return type(evo_path)(
            positions_xyz=rows[:, :3],
            orientations_quat_wxyz=rows[:, [6, 3, 4, 5]],
            meta=copy.deepcopy(evo_path.meta),
            **own,
        )

    return GivenPoses(path, written)


def _pose3(poses: list[Any], time_s: Any) -> GivenPoses:
    kind = type(poses[0])
    path = _stamped(Motor.from_matrix(np.array([one.matrix() for one in poses])), time_s)
    return GivenPoses(
        path, lambda trajectory, _: [kind(matrix) for matrix in trajectory.motors.as_matrix()]
    )


# Stamps as people keep them, seconds or datetimes of any library, read as whole nanoseconds.

# Poses farther apart are no path; stamps that seem so are in milliseconds or nanoseconds.
_SLOWEST_S = 1000.0
# Rows that a message lists.
_ROWS_NAMED = 5


def nanoseconds_of(times: Any, count: int, name: str = "time_s") -> IntArray:
    """Whole nanoseconds of seconds since anything, of datetimes, or of numpy's stamps.

    Raises:
        ValueError: none, another count, what is no stamp, or stamps beyond 146 years of zero.

    >>> import datetime
    >>> nanoseconds_of([0.0, 0.5], 2)
    array([        0, 500000000])
    >>> nanoseconds_of([datetime.datetime(1970, 1, 1, 0, 0, 1)], 1)
    array([1000000000])
    """
    if times is None:
        raise ValueError(f"{name}: expected the stamps of these poses, got none")
    stamps = without_mask(times, name)
    if stamps.dtype == object:
        stamps = _moments(stamps.ravel(), name)
    if stamps.shape != (count,):
        raise ValueError(f"{name}: expected {count} stamps, got shape {stamps.shape}")
    if stamps.dtype.kind in "US":
        raise ValueError(
            f"{name}: expected seconds or datetimes, got text such as {str(stamps[0])!r}; "
            "pandas.to_datetime reads it"
        )
    if stamps.dtype.kind in "mM":
        if np.isnat(stamps).any():
            raise ValueError(f"{name}: expected a moment for every pose, got NaT")
        in_ns = stamps.astype(f"{stamps.dtype.kind}8[ns]")
        days = f"{stamps.dtype.kind}8[D]"
        far = np.flatnonzero(in_ns.astype(days) != stamps.astype(days))
        if far.size:
            raise ValueError(
                f"{name}: expected stamps within 146 years of 1970, got {stamps[far[0]]}"
            )
        return in_ns.astype(np.int64)
    seconds = checked_floats(stamps, name, ())
    if count > 1 and float(np.median(np.diff(seconds))) > _SLOWEST_S:
        raise ValueError(
            f"{name}: expected seconds, got stamps that lie "
            f"{float(np.median(np.diff(seconds))):.3g} s apart; divide nanoseconds by 1e9"
        )
    if np.max(np.abs(seconds), initial=0.0) >= 1e-9 * STAMP_LIMIT_NS:
        raise ValueError(
            f"{name}: expected seconds within 146 years of zero, got "
            f"{float(seconds[np.argmax(np.abs(seconds))]):.6g}; divide milliseconds by 1e3, "
            "nanoseconds by 1e9"
        )
    return np.round(1e9 * seconds).astype(np.int64)


def without_mask(array: Any, name: str) -> np.ndarray[Any, Any]:
    """The plain array of what comes.

    Raises:
        ValueError: rows that are masked, whose numbers mean nothing.
    """
    rows = np.unique(np.nonzero(np.ma.getmaskarray(array))[0]) if np.ma.isMA(array) else ()
    if len(rows):
        raise ValueError(
            f"{name}: expected numbers in every row, got {len(rows)} masked: {listed(rows)}; leave "
            "these rows out"
        )
    return np.asarray(array)


def listed(rows: Sequence[int] | IntArray) -> str:
    """The first few of some rows, for a message."""
    return ", ".join(map(str, rows[:_ROWS_NAMED])) + (", …" if len(rows) > _ROWS_NAMED else "")


def _moments(moments: np.ndarray[Any, Any], name: str) -> np.ndarray[Any, Any]:
    """Datetimes, or stamps of pandas to the nanosecond, in universal time; all or none zoned."""
    zones = {getattr(one, "tzinfo", None) is not None for one in moments}
    if len(zones) > 1:
        raise ValueError(f"{name}: expected datetimes all with a zone or all without, got both")
    return np.array([_moment(one, name) for one in moments])


def _moment(moment: Any, name: str) -> np.datetime64 | np.timedelta64:
    if hasattr(moment, "as_unit"):
        kind = np.timedelta64 if type(moment).__name__ == "Timedelta" else np.datetime64
        return kind(moment.as_unit("ns").value, "ns")
    if isinstance(moment, str):
        raise ValueError(
            f"{name}: expected seconds or datetimes, got text such as {moment!r}; "
            "pandas.to_datetime reads it"
        )
    if moment is None or type(moment).__name__ == "NaTType":
        raise ValueError(f"{name}: expected a moment for every pose, got {moment}")
    if not isinstance(moment, datetime.datetime | np.datetime64):
        raise ValueError(
            f"{name}: expected seconds or datetimes, got {type(moment).__name__} {moment}"
        )
    if isinstance(moment, np.datetime64):
        return moment
    offset = moment.utcoffset()
    plain = moment if offset is None else (moment - offset).replace(tzinfo=None)
    return np.datetime64(plain, "us")
