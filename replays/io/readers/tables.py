"""Tables of numbers in text files: rows in blocks of columns, stamps exact, faults by line number.

Stamps go from decimal text to integer nanoseconds without passing through a float (a float64 of
today's Unix time in seconds is only good to 240 ns); digits below a nanosecond are rounded. Of rows
with equal stamps the first is kept and a warning in the log gives the lines; a stamp that
decreases is refused. Comments open with `#`; blank lines are skipped.
"""

from __future__ import annotations

import itertools
import logging
import os
import re
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, replace
from decimal import ROUND_HALF_EVEN, Context, Decimal, InvalidOperation
from pathlib import Path

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import one_line
from motorcade.ga.progress import reading
from motorcade.replays.io.files import open_bounded, refusal

FILE_LIMIT = 2**30
LINE_LIMIT = 2**16
UNITS = {"s": 9, "ms": 6, "100 us": 5, "us": 3, "ns": 0}
"""Powers of ten from a unit to nanoseconds."""
_EMPTY = {b"", b"null"}
UNIT_TOLERANCE = 0.01
"""How far a quaternion's norm, or a matrix times its transpose, may be from 1."""
REACH_M = 1e9
"""How far from the origin a position may be."""

_TOLD_EVERY = 10_000
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_CONTEXT = Context(prec=60, rounding=ROUND_HALF_EVEN)
_LOG = logging.getLogger("motorcade.replays")


@dataclass(frozen=True)
class Table:
    """Rows of numbers: where each stands in its file, its stamp, its columns.

    Fields:
        path: the file.
        lines: ``(N,)`` line numbers, from 1.
        time_ns: ``(N,)`` stamps; zeros where the table has none.
        values: ``(N, C)`` the columns without the stamp, finite.
    """

    path: Path
    lines: IntArray
    time_ns: IntArray
    values: FloatArray

    def __len__(self) -> int:
        return len(self.lines)

    def rows(self, chosen: IntArray) -> Table:
        """The rows of these rising indices; the table itself where they are all."""
        if len(chosen) == len(self):
            return self
        return replace(
            self,
            lines=self.lines[chosen],
            time_ns=self.time_ns[chosen],
            values=self.values[chosen],
        )


@dataclass(frozen=True)
class Listing:
    """Stamped file names, as in `rgb.txt` or `data.csv`, in the order of their stamps."""

    path: Path
    lines: IntArray
    time_ns: IntArray
    names: tuple[str, ...]


def data_rows(path: Path, separator: bytes | None) -> Iterator[tuple[int, list[bytes]]]:
    """Give line number and tokens of each row that is neither blank nor a comment.

    Args:
        path: a text file.
        separator: b"," or None for any white space.

    Raises:
        RecordingError: missing, empty, too large, or not text.
    """
    with (
        open_bounded(path, FILE_LIMIT) as file,
        reading(path.name, os.fstat(file.fileno()).st_size) as advance,
    ):
        for number in itertools.count(1):
            if number % _TOLD_EVERY == 0:
                advance(file.tell())
            line = file.readline(LINE_LIMIT + 1)
            if not line:
                return
            if b"\0" in line:
                raise refusal(path, "expected a text file, got binary data", line=number)
            if len(line) > LINE_LIMIT:
                raise refusal(path, f"expected lines of at most {LINE_LIMIT} bytes", line=number)
            row = (line.removeprefix(_BYTE_ORDER_MARK) if number == 1 else line).strip()
            if row and not row.startswith(b"#"):
                yield number, row.split(separator)


def stamp_ns(text: bytes, unit: str) -> int:
    """Convert a decimal number to integer nanoseconds, exactly, or rounded below a nanosecond.

    Args:
        text: such as b"1305031098.6659" or b"1.403715273262142976e+18".
        unit: "s", "ms", "us" or "ns".

    Raises:
        ValueError: not a decimal number, or more than 146 years (2**62 ns) from zero, so that
            differences of stamps fit into int64.
    """
    if unit == "clock":
        return _clock_ns(text)
    power = UNITS[unit]
    if text.isdigit() and len(text) + power <= 18:
        whole: int = int(text) * 10**power
        return whole
    try:
        value = Decimal(text.decode("ascii").strip())
    except (InvalidOperation, UnicodeDecodeError) as fault:
        raise ValueError(f"expected a stamp in {unit}, got {one_line(text)}") from fault
    if not value.is_finite() or b"_" in text:
        raise ValueError(f"expected a stamp in {unit}, got {one_line(text)}")
    if not value or value.adjusted() + power < -1:
        return 0
    if value.adjusted() + power > 18:
        raise ValueError(f"expected a stamp in {unit}, got {one_line(text)}, too large for one")
    stamp = int(value.scaleb(power, _CONTEXT).to_integral_value(ROUND_HALF_EVEN))
    if abs(stamp) >= 2**62:
        raise ValueError(f"expected a stamp in {unit}, got {one_line(text)}, too large for one")
    return stamp


_CLOCK = re.compile(rb"(?:.*[ T])?(\d{1,2}):(\d{1,2}):(\d{1,2})(?:[.,:](\d{1,9}))?\s*")


def _clock_ns(text: bytes) -> int:
    """Nanoseconds since midnight of a time of the day, with a date before it or not."""
    clock = _CLOCK.fullmatch(text)
    if clock is None:
        raise ValueError(f"expected a time of the day, 11:23:45.123, got {one_line(text)}")
    hours, minutes, seconds = (int(part) for part in clock.groups()[:3])
    return ((hours * 60 + minutes) * 60 + seconds) * 10**9 + int((clock[4] or b"0").ljust(9, b"0"))


def read_table(
    path: Path,
    columns: tuple[str, ...],
    *,
    separator: bytes | None = None,
    decimal_comma: bool = False,
    unit: str | None = None,
    header: bool = False,
    below: int = 0,
    more_columns: bool = False,
    places: tuple[int, ...] | None = None,
) -> Table:
    """Read rows of finite numbers.

    Args:
        path: the file.
        columns: names of the columns without the stamp; they are counted and name the faults.
        separator: b"," or None for any white space.
        decimal_comma: whether a comma stands for the decimal point.
        unit: unit of a leading stamp column (see `UNITS`), or "clock" for times of the day; None
            where there is no such column.
        header: allow rows of names above the numbers that are not marked as comments.
        below: the line above the first that may hold numbers.
        more_columns: ignore columns after these, and leave out rows with an empty one among these.
        places: where the stamp and each column stand in a row; by default one after another.

    Raises:
        RecordingError: no rows, a wrong count of columns, something that is no finite number.
    """
    stamped = unit is not None
    wanted = len(columns) + stamped
    moved = places is not None and places != tuple(range(wanted))
    least = max(places) + 1 if places is not None else wanted
    lines, stamps, numbers, empty = array("q"), array("q"), array("d"), 0
    for line, row in data_rows(path, separator):
        if line <= below or (header and not lines and is_header(row)):
            continue
        if decimal_comma:
            row = [token.replace(b",", b".") for token in row]
        if len(row) < least or (len(row) > least and not more_columns):
            names = ("stamp", *columns) if stamped else columns
            expected = f"{least}{' or more' if more_columns else ''} columns ({' '.join(names)})"
            raise refusal(path, f"expected {expected}, got {len(row)}", line=line)
        if moved and places is not None:
            row = [row[place] for place in places]
        if more_columns and not _EMPTY.isdisjoint(map(bytes.strip, row[:wanted])):
            empty += 1
            continue
        try:
            numbers.extend(map(float, row[stamped:wanted]))
            if unit is not None:
                stamps.append(stamp_ns(row[0], unit))
        except ValueError as fault:
            raise _faulty_row(path, line, row, columns, unit) from fault
        if b"_" in b"".join(row[:wanted]):
            raise _faulty_row(path, line, row, columns, unit)
        lines.append(line)
    if not lines:
        raise refusal(path, "expected at least one row of numbers, got none")
    if empty:
        _LOG.warning("%s: %d rows leave out %s", path, empty, " ".join(columns))
    # The arrays' own memory, not copies: tables may be long.
    where = np.frombuffer(lines, dtype=np.int64)
    values = np.frombuffer(numbers, dtype=np.float64).reshape(len(where), len(columns))
    _refuse_not_finite(path, where, values, columns)
    time_ns = np.frombuffer(stamps, np.int64) if stamped else np.zeros(len(where), dtype=np.int64)
    return Table(path, where, time_ns, values)


def read_listing(path: Path, *, separator: bytes | None, unit: str) -> Listing:
    """Read rows of a stamp and a file name, stamps strictly increasing after `in_order`.

    Raises:
        RecordingError: no rows, not two columns, stamps that decrease, names that are not UTF-8.
    """
    lines, stamps, names = array("q"), array("q"), list[str]()
    for line, row in data_rows(path, separator):
        if not lines and is_header(row):
            continue
        if len(row) != 2:
            problem = f"expected a stamp and a file name, got {len(row)} columns"
            raise refusal(path, problem, line=line)
        try:
            stamps.append(stamp_ns(row[0], unit))
            names.append(row[1].strip().decode("utf-8"))
        except ValueError as fault:
            raise refusal(path, str(fault), line=line) from fault
        lines.append(line)
    if not lines:
        raise refusal(path, "expected at least one row of stamp and file name, got none")
    where, time_ns = np.array(lines, dtype=np.int64), np.array(stamps, dtype=np.int64)
    kept = in_order(path, where, time_ns)
    return Listing(path, where[kept], time_ns[kept], tuple(names[i] for i in kept))


def in_order(path: Path, lines: IntArray, time_ns: IntArray) -> IntArray:
    """Give the indices to keep: all but the repeats of a stamp, which are named in the log.

    Raises:
        RecordingError: a stamp that is smaller than the one before.
    """
    steps = np.diff(time_ns)
    backwards = np.flatnonzero(steps < 0)
    if backwards.size:
        at = int(backwards[0]) + 1
        got = f"got {time_ns[at]} ns after {time_ns[at - 1]} ns"
        problem = f"expected stamps in increasing order, {got}"
        raise refusal(path, problem, line=int(lines[at]), advice="sort the file by its stamps")
    repeats = np.flatnonzero(steps == 0) + 1
    if repeats.size:
        named = ", ".join(str(line) for line in lines[repeats[:8]])
        more = f" and {repeats.size - 8} more" if repeats.size > 8 else ""
        said = "%s: stamp equal to the row before on line %s%s; the first row of each is kept"
        _LOG.warning(said, path, named, more)
    return np.delete(np.arange(len(time_ns)), repeats)


def is_header(row: list[bytes]) -> bool:
    """Whether no token of the row is a number, so that it can only be names."""
    return not any(_is_number(token.replace(b",", b".")) for token in row)


def _is_number(token: bytes) -> bool:
    try:
        float(token)
    except ValueError:
        return False
    return True


def _faulty_row(
    path: Path, line: int, row: list[bytes], columns: tuple[str, ...], unit: str | None
) -> Exception:
    """Find the token that is no number, and say so."""
    tokens = row
    if unit is not None:
        try:
            stamp_ns(row[0], unit)
        except ValueError as fault:
            return refusal(path, str(fault), line=line)
        tokens = row[1:]
    for name, token in zip(columns, tokens, strict=False):
        if b"_" in token or not _is_number(token):
            return refusal(path, f"expected a number, got {one_line(token)}", line=line, field=name)
    return refusal(path, "expected numbers", line=line)


def _refuse_not_finite(
    path: Path, lines: IntArray, values: FloatArray, columns: tuple[str, ...]
) -> None:
    faults = np.argwhere(~np.isfinite(values))
    if faults.size:
        row, column = (int(i) for i in faults[0])
        problem = f"expected a finite number, got {values[row, column]}"
        raise refusal(path, problem, line=int(lines[row]), field=columns[column])
