"""Stamps as people keep them, seconds or datetimes of any library, read as whole nanoseconds."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from typing import Any

import numpy as np

from motorcade.ga.arrays import IntArray, checked_floats
from motorcade.ga.stamps import STAMP_LIMIT_NS

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
