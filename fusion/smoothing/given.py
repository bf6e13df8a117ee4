"""Poses as other libraries keep them, read into trajectories and written back as they came.

==========================  ========================================  ==========================
what comes                  how it is read                            stamps
==========================  ========================================  ==========================
array ``(N, 7)``            x, y, z, then qx, qy, qz, qw              `time_s`
array ``(N, 8)``            the same behind a stamp in seconds (TUM)  first column
array ``(N, 4, 4)``         homogeneous matrices                      `time_s`
array ``(B, N, 7)`` …       B bodies, each for itself                 `time_s`, for all of them
torch tensor                as the array                              as the array
Motor ``(N,)``                                                        `time_s`
scipy ``Rotation``          rotations about a point that stays        `time_s`
scipy ``RigidTransform``                                              `time_s`
list of gtsam ``Pose3``                                               `time_s`
pandas ``DataFrame``        columns x, y, z, qx, qy, qz, qw           a column or the index
evo ``PoseTrajectory3D``                                              its own
dict of any of these        each for itself                           `time_s`, for all of them
==========================  ========================================  ==========================

Arrays of floats come back in their own precision. A quaternion's sign comes back as it was given.
Other libraries are not imported: what comes brings its own.
"""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats
from motorcade.ga.names import did_you_mean

Back = Callable[[Trajectory], Any]
# Poses farther apart are no path; stamps that seem so are in milliseconds or nanoseconds.
_SLOWEST_S = 1000.0
# Quaternions that were written with three digits are off by no more.
_ROUNDED = 2e-3
_POSITION, _QUATERNION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
_STAMPS = ("time_s", "timestamp", "time", "stamp", "t")


def with_trajectories(given: Any, time_s: Any, verb: Callable[[Trajectory], Trajectory]) -> Any:
    """Do something with given poses as trajectories, and give the result as they came.

    Args:
        given: a `Trajectory`, or what the table of this module names.
        time_s: ``(N,)`` seconds, datetimes or numpy datetime64, for what has no stamps.
        verb: keeps the stamps.

    Raises:
        TypeError: poses of a kind that is not in the table.
        ValueError: poses without stamps, stamps that do not fit, or numbers that are no poses.
    """
    if isinstance(given, Trajectory):
        if time_s is not None:
            raise ValueError("time_s: expected none beside a trajectory, which has its own stamps")
        return verb(given)
    if getattr(given, "shape", None) and 0 in given.shape:
        raise ValueError(f"poses: expected at least one, got an array of shape {given.shape}")
    if isinstance(given, dict):
        return {name: with_trajectories(one, time_s, verb) for name, one in given.items()}
    if _library(given) == "torch":
        made = with_trajectories(given.detach().cpu().numpy(), time_s, verb)
        tensor = sys.modules["torch"].from_numpy(made).to(given.device)
        return tensor.to(given.dtype) if given.is_floating_point() else tensor
    if _bodies(given):
        return np.stack([with_trajectories(one, time_s, verb) for one in given])
    path, back = _read(given, time_s)
    return back(verb(path))


def _library(given: Any) -> str:
    return type(given).__module__.partition(".")[0]


def _bodies(given: Any) -> bool:
    if not isinstance(given, np.ndarray):
        return False
    shape = given.shape
    return shape[2:] in ((7,), (8,)) or (len(shape) == 4 and shape[2:] == (4, 4))


def _read(given: Any, time_s: Any) -> tuple[Trajectory, Back]:
    kind = type(given).__name__
    if isinstance(given, Motor):
        return _stamped(given, time_s), lambda made: made.motors
    if isinstance(given, np.ndarray):
        return _array(given, time_s)
    if _library(given) == "scipy" and kind in ("Rotation", "RigidTransform"):
        return _scipy(given, time_s)
    if _library(given) == "pandas" and kind == "DataFrame":
        return _table(given, time_s)
    if _library(given) == "evo" and kind == "PoseTrajectory3D":
        return _evo(given, time_s)
    if isinstance(given, list) and given and type(given[0]).__name__ == "Pose3":
        return _pose3(given, time_s)
    raise TypeError(
        "poses: expected a Trajectory, an array (N, 7), (N, 8) or (N, 4, 4), a torch tensor, "
        "scipy's Rotation or RigidTransform, a pandas DataFrame, evo's PoseTrajectory3D, a list "
        f"of gtsam's Pose3 or a dict of these, got {type(given).__name__}"
    )


def _stamped(poses: Motor, time_s: Any) -> Trajectory:
    return Trajectory(_nanoseconds(time_s, len(poses)), poses)


def _nanoseconds(time_s: Any, count: int) -> IntArray:
    """Whole nanoseconds of seconds since anything, of datetimes, or of numpy's stamps."""
    if time_s is None:
        raise ValueError("time_s: expected the stamps of these poses, got none")
    stamps = np.asarray(time_s)
    if stamps.dtype == object:
        stamps = np.array([_moment(one) for one in stamps.ravel()])
    if stamps.shape != (count,):
        raise ValueError(f"time_s: expected {count} stamps, got shape {stamps.shape}")
    if stamps.dtype.kind in "mM":
        if np.isnat(stamps).any():
            raise ValueError("time_s: expected a moment for every pose, got NaT")
        unit = "datetime64[ns]" if stamps.dtype.kind == "M" else "timedelta64[ns]"
        return stamps.astype(unit).astype(np.int64)
    seconds = checked_floats(stamps, "time_s", ())
    if count > 1 and float(np.median(np.diff(seconds))) > _SLOWEST_S:
        raise ValueError(
            "time_s: expected seconds, got stamps that lie "
            f"{float(np.median(np.diff(seconds))):.3g} s apart; divide nanoseconds by 1e9"
        )
    return np.round(1e9 * seconds).astype(np.int64)


def _moment(moment: Any) -> np.datetime64:
    """A datetime, or a stamp of pandas to the nanosecond, in universal time."""
    if hasattr(moment, "as_unit"):
        return np.datetime64(moment.as_unit("ns").value, "ns")
    offset = moment.utcoffset() if hasattr(moment, "utcoffset") else None
    plain = moment if offset is None else (moment - offset).replace(tzinfo=None)
    return np.datetime64(plain, "ns")


def _from_rows(rows: FloatArray) -> Motor:
    wxyz = checked_floats(rows[:, [6, 3, 4, 5]], "poses", (4,))
    length = np.linalg.norm(wxyz, axis=-1, keepdims=True)
    off = float(np.max(np.abs(length - 1.0)))
    if off > _ROUNDED:
        raise ValueError(
            f"poses: expected unit quaternions qx, qy, qz, qw, got a length off by {off:.3g}"
        )
    return Motor.from_quaternion_translation(wxyz / length, rows[:, :3])


def _to_rows(poses: Motor, like_wxyz: FloatArray) -> FloatArray:
    """Rows ``(N, 7)`` whose quaternions have the signs of others ``(N, 4)``."""
    wxyz, translation = poses.as_quaternion_translation()
    wxyz *= np.where(np.sum(wxyz * like_wxyz, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    return np.concatenate([translation, wxyz[:, 1:], wxyz[:, :1]], axis=-1)


def _array(given: np.ndarray[Any, Any], time_s: Any) -> tuple[Trajectory, Back]:
    precision = given.dtype if given.dtype.kind == "f" else np.dtype(np.float64)
    numbers = given.astype(np.float64)
    if numbers.ndim == 3 and numbers.shape[1:] == (4, 4):
        path = _stamped(Motor.from_matrix(numbers), time_s)
        return path, lambda made: made.motors.as_matrix().astype(precision)
    if numbers.ndim != 2 or numbers.shape[1] not in (7, 8):
        raise ValueError(
            "poses: expected an array (N, 7) of x, y, z, qx, qy, qz, qw, (N, 8) with a stamp "
            f"before it, or (N, 4, 4), got {given.shape}"
        )
    rows = numbers[:, -7:]
    if numbers.shape[1] == 8:
        if time_s is not None:
            raise ValueError("time_s: expected none beside rows that begin with a stamp")
        time_s = numbers[:, 0]
    path = _stamped(_from_rows(rows), time_s)

    def back(made: Trajectory) -> np.ndarray[Any, Any]:
        out = numbers.copy()
        out[:, -7:] = _to_rows(made.motors, rows[:, [6, 3, 4, 5]])
        return out.astype(precision)

    return path, back


def _scipy(given: Any, time_s: Any) -> tuple[Trajectory, Back]:
    kind = type(given)
    if kind.__name__ == "RigidTransform":
        path = _stamped(Motor.from_matrix(given.as_matrix()), time_s)
        return path, lambda made: kind.from_matrix(made.motors.as_matrix())
    wxyz = np.atleast_2d(given.as_quat())[:, [3, 0, 1, 2]]
    turned = Motor.from_rotor_translation(Rotor.from_quaternion(wxyz), np.zeros((len(wxyz), 3)))

    def back(made: Trajectory) -> Any:
        return kind.from_quat(_to_rows(made.motors, wxyz)[:, 3:])

    return _stamped(turned, time_s), back


def _table(given: Any, time_s: Any) -> tuple[Trajectory, Back]:
    for name in (*_POSITION, *_QUATERNION):
        if name not in given.columns:
            raise ValueError(
                f"poses: expected columns {', '.join((*_POSITION, *_QUATERNION))}, got none named "
                f"{name}; {did_you_mean(name, map(str, given.columns))}"
            )
    named = [name for name in _STAMPS if name in given.columns]
    if time_s is None:
        time_s = given[named[0]].to_numpy() if named else _index(given)
    rows = given[[*_POSITION, *_QUATERNION]].to_numpy(dtype=np.float64)

    def back(made: Trajectory) -> Any:
        out = given.copy()
        out[[*_POSITION, *_QUATERNION]] = _to_rows(made.motors, rows[:, [6, 3, 4, 5]])
        return out

    return _stamped(_from_rows(rows), time_s), back


def _index(given: Any) -> Any:
    """The index, where it is one of stamps and not of row numbers."""
    stamps = given.index
    if getattr(stamps, "tz", None) is not None:
        stamps = stamps.tz_convert("UTC").tz_localize(None)
    if stamps.dtype.kind in "mMf":
        return stamps.to_numpy()
    raise ValueError(
        f"time_s: expected a column named {', '.join(_STAMPS)}, an index of stamps, or time_s"
    )


def _evo(given: Any, time_s: Any) -> tuple[Trajectory, Back]:
    if time_s is not None:
        raise ValueError("time_s: expected none beside evo's trajectory, which has its own stamps")
    wxyz = np.asarray(given.orientations_quat_wxyz, dtype=np.float64)
    poses = Motor.from_quaternion_translation(wxyz, given.positions_xyz)

    def back(made: Trajectory) -> Any:
        rows = _to_rows(made.motors, wxyz)
        return type(given)(
            positions_xyz=rows[:, :3],
            orientations_quat_wxyz=rows[:, [6, 3, 4, 5]],
            timestamps=np.array(given.timestamps),
            meta=copy.deepcopy(given.meta),
        )

    return _stamped(poses, given.timestamps), back


def _pose3(given: list[Any], time_s: Any) -> tuple[Trajectory, Back]:
    kind = type(given[0])
    path = _stamped(Motor.from_matrix(np.array([one.matrix() for one in given])), time_s)
    return path, lambda made: [kind(matrix) for matrix in made.motors.as_matrix()]
