"""Tables of a text file whose header says what stands where, and in which units.

Columns stand between commas, semicolons or tabs, and where commas do not part them, a comma may
stand for the decimal point. A header is the last line of comment, or the row of names, above the
numbers; two rows of names are a group's and its axes'. Where it names every column that is wanted
(`w_RS_S_x [rad s^-1]`, `gyro_x`, `angular_velocity.x`, `ax (g)`, `gFx`, `qw`), the file is read by
it; where it says nothing, columns are EuRoC's, in EuRoC's order. One that names a column in another
place and leaves others open is refused, as is a unit that nobody knows. Of several columns of one
name, that of a message's header counts before the time of its arrival, and readings with gravity
before those without.

Stamps without a unit are nanoseconds, unless they cannot be: fractions that are nanoseconds apart
are seconds, and whole numbers are of the one unit in which they are sampled 0.5 to 20,000 times a
second. Times of the day (`11:23:45.123`) count from midnight.
"""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass, replace
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import open_bounded, refusal
from motorcade.replays.io.readers.tables import (
    FILE_LIMIT,
    LINE_LIMIT,
    UNITS,
    Table,
    in_order,
    is_header,
    read_table,
)

_STAMP = "stamp"
_LOOKED_AT = 64
_LEAST_STEP_NS = 1000.0
# Nothing is sampled a million times a second.
_STEPS_NS = 5e4, 2e9
"""Shortest and longest step of readings that are counted in whole units."""
_PARTS = (b";", b"\t", b",")
_WITHOUT_GRAVITY = {"linear", "user", "uncalibrated"}
_LOG = logging.getLogger("motorcade.replays")

_TIMES = {"timestamp", "timestamps", "time", "stamp", "t", "ts"}
_TIME_UNITS = {
    **dict.fromkeys(("ns", "nsec", "nsecs", "nanosecond", "nanoseconds"), "ns"),
    **dict.fromkeys(("us", "µs", "μs", "usec", "microsecond", "microseconds"), "us"),
    **dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s"),
}


@dataclass(frozen=True)
class Quantity:
    """What some columns hold, by the words of their names.

    Fields:
        words: any of which stands in the name, before the axis.
        letters: any of which opens the name, before the axis; `""` for axes alone.
        axes: in the order in which they are wanted.
        label: what a column is called in refusals, before its axis.
        units: what one of each is in our own unit.
    """

    words: frozenset[str]
    letters: frozenset[str]
    axes: str
    label: str
    units: dict[str, float]

    def axis(self, words: list[str]) -> str | None:
        """The axis that a name means; None where it means something else."""
        *before, last = words
        if last[-1] in self.axes and last[:-1] and last[:-1] in self.words | self.letters:
            return last[-1]  # gyrox, wx
        if len(last) > 1 or last not in self.axes:
            return None
        opens = before[0] if before else ""
        return last if opens in self.letters or self.words & set(before) else None


ANGULAR_RATE = Quantity(
    frozenset({"gyr", "gyro", "gyroscope", "omega", "angular", "ang", "rate"}),
    frozenset({"w", "g"}),
    "xyz",
    "w_",
    {
        **dict.fromkeys(("rad/s", "rads^-1", "rads-1", "rad/sec", "rad_s"), 1.0),
        **dict.fromkeys(("deg/s", "degs^-1", "degs-1", "deg/sec", "deg_s"), np.pi / 180.0),
        **dict.fromkeys(("°/s", "°s^-1", "dps"), np.pi / 180.0),
    },
)
SPECIFIC_FORCE = Quantity(
    frozenset({"acc", "accel", "accelerometer", "acceleration", "force"}),
    frozenset({"a", "f"}),
    "xyz",
    "a_",
    {
        **dict.fromkeys(("m/s^2", "m/s2", "m/s²", "ms^-2", "ms-2", "m/s/s", "m_s2"), 1.0),
        "g": 9.80665,
        "mg": 9.80665e-3,
    },
)
MAGNETIC_FIELD = Quantity(
    frozenset({"mag", "magn", "magnetic", "magnetometer"}),
    frozenset({"m", "b"}),
    "xyz",
    "m_",
    {
        **dict.fromkeys(("µt", "μt", "ut", "microtesla", "-", "1", "a.u."), 1.0),
        **dict.fromkeys(("g", "gauss", "ga"), 100.0),
        **dict.fromkeys(("mg", "mgauss"), 0.1),
        **dict.fromkeys(("t", "tesla"), 1e6),
    },
)
POSITION = Quantity(
    frozenset({"pos", "position", "translation"}),
    frozenset({"p", "t", ""}),
    "xyz",
    "t",
    {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0},
)
QUATERNION = Quantity(
    frozenset({"quat", "quaternion", "orientation", "rotation", "rot"}),
    frozenset({"q"}),
    "wxyz",
    "q",
    {"-": 1.0, "1": 1.0},
)


def opening_rows(path: Path, wanted: int) -> tuple[list[bytes] | None, list[list[bytes]]]:
    """Tokens of the header, if there is one of so many columns, and of the first rows below it."""
    opening = _opening(path, wanted)
    return opening.header, opening.rows


def names_quantity(path: Path, quantity: Quantity) -> bool:
    """Whether the file's header names every axis of a quantity."""
    header = _opening(path, len(quantity.axes)).header or []
    meant = {_meant(*_name_and_unit(token), (quantity,))[0] for token in header}
    return meant.issuperset(quantity.label + axis for axis in quantity.axes)


def read_columns(path: Path, quantities: tuple[Quantity, ...]) -> Table:
    """Read a stamp and quantities by the file's header, in our units and in the order given.

    Of rows with equal stamps the first is kept; rows that leave one of the columns empty are not.

    Raises:
        RecordingError: as `read_table` and `in_order`; a header that contradicts EuRoC's order and
            does not say where everything is; a unit that is not known.
    """
    names = tuple(entry.label + axis for entry in quantities for axis in entry.axes)
    opening = _opening(path, 1 + len(names))
    number, header, rows = opening.line, opening.header, opening.rows
    places, units = list(range(1 + len(names))), [""] * (1 + len(names))
    if header is not None:
        columns = _Header(path, number, header)
        places, units = columns.layout(quantities, (_STAMP, *names))
    unit = _stamp_unit(
        path, number, units[0], [row[places[0]] for row in rows if places[0] < len(row)]
    )
    table = read_table(
        path,
        names,
        separator=opening.separator,
        decimal_comma=opening.decimal_comma,
        unit=unit,
        header=True,
        more_columns=True,
        places=tuple(places),
    )
    scale = _scales(path, number, quantities, units[1:], names)
    if np.any(scale != 1.0):
        table = replace(table, values=table.values * scale)
    return table.rows(in_order(path, table.lines, table.time_ns))


class _Opening(NamedTuple):
    """Line number and tokens of the header, if there is one, the first rows below it, and how
    columns are parted; None: by white space.
    """

    line: int
    header: list[bytes] | None
    rows: list[list[bytes]]
    separator: bytes | None
    decimal_comma: bool


def _opening(path: Path, wanted: int) -> _Opening:
    at, header, rows, group = 0, None, list[list[bytes]](), list[bytes]()
    separator: bytes | None = b","
    with open_bounded(path, FILE_LIMIT) as file:
        number = 0
        while len(rows) < _LOOKED_AT and (line := file.readline(LINE_LIMIT)):
            number += 1
            text = line.removeprefix(b"\xef\xbb\xbf").strip(b" \r\n")
            parts = next((part for part in _PARTS if part in text), None)
            row = text.lstrip(b"#, ").split(parts)
            names = text.startswith(b"#") or (not rows and is_header(row))
            if not names and text:
                rows.append(row)
                separator = parts
            elif not rows and len(row) >= wanted and is_header(row):
                grouped = len(group) == len(row) and not text.startswith(b"#")
                group, header = row, _grouped(group, row) if grouped else row
                at = number
    by_comma = separator not in (b",", None) and any(b"," in b"".join(row) for row in rows)
    if by_comma:
        rows = [[token.replace(b",", b".") for token in row] for row in rows]
    return _Opening(at, header, rows, separator, by_comma)


def _grouped(groups: list[bytes], axes: list[bytes]) -> list[bytes]:
    """Names of two rows: that of a group holds until the next one."""
    names, above = [], b""
    for group, axis in zip(groups, axes, strict=True):
        above = group.strip() or above
        names.append(above + b" " + axis)
    return names


@dataclass(frozen=True)
class _Header:
    path: Path
    line: int
    tokens: list[bytes]

    def layout(
        self, quantities: tuple[Quantity, ...], names: tuple[str, ...]
    ) -> tuple[list[int], list[str]]:
        """Where the columns of these names stand, and their units."""
        order, units = list(range(len(names))), [""] * len(names)
        seen: dict[str, list[int]] = {}
        said = [_name_and_unit(token) for token in self.tokens]
        for at, (words, unit) in enumerate(said):
            name, unit = _meant(words, unit, quantities)
            if name is not None:
                seen.setdefault(name, []).append(at)
                said[at] = (words, unit)
        for name, places in seen.items():
            ranks = [_rank(name, said[at][0]) for at in places]
            seen[name] = [at for at, rank in zip(places, ranks, strict=True) if rank == min(ranks)]
        seen[_STAMP] = seen[_STAMP][:1] if _STAMP in seen else []
        if not seen[_STAMP]:
            del seen[_STAMP]
        twice = [name for name, places in seen.items() if len(places) > 1]
        missing = [name for name in names if name not in seen]
        in_order = all(places == [names.index(name)] for name, places in seen.items())
        if twice or (missing and not in_order):
            self._refuse(f"{twice[0]} twice" if twice else f"no {missing[0]}", names)
        if not missing:
            order = [seen[name][0] for name in names]
        for number, at in enumerate(order):
            if names[number] in seen:
                units[number] = said[at][1]
        return order, units

    def _refuse(self, what: str, names: tuple[str, ...]) -> NoReturn:
        raise refusal(
            self.path,
            f"expected a header that names {' '.join(names)}, or leaves them in this order, got "
            f"{what} in {one_line(b','.join(self.tokens))}",
            line=self.line,
            advice="rename its columns",
        )


def _rank(name: str, words: list[str]) -> int:
    """The lower, the sooner a column is taken among several of one name."""
    if name == _STAMP:
        return 0 if "header" in words else 1
    if _WITHOUT_GRAVITY.intersection(words):
        return 2
    return 0 if words[0] == "g" else 1


def _name_and_unit(token: bytes) -> tuple[list[str], str]:
    """Words of a column's name, lower-case, and what it says in brackets."""
    text = token.decode("utf-8", "replace").strip().strip("\"'").strip()
    brackets = re.search(r"[\[(]([^\])]*)[\])]", text)
    unit = re.sub(r"[\s·*]", "", brackets[1]).lower() if brackets else ""
    bare = text[: brackets.start()] if brackets else text
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", bare).lower()
    return [word for word in re.split(r"[^a-z0-9°]+", parted) if word], unit


_ENDINGS = (("rad", "s"), ("deg", "s"), ("m", "s2"), ("dps",), ("g",), ("mg",), ("m",), ("mm",))


def _meant(words: list[str], unit: str, quantities: tuple[Quantity, ...]) -> tuple[str | None, str]:
    """Which column a name means, None for another one; and its unit, also where a word says it."""
    if not words or words[0] in ("b", "bias"):
        return None, unit
    if len(words) == 2 and words[0] == "g" and words[1] in ("fx", "fy", "fz"):
        words, unit = [words[1]], unit or "g"  # g-force
    if words[-1] in _TIME_UNITS and len(words) > 1 and set(words[:-1]) & _TIMES:
        return _STAMP, unit or words[-1]
    if set(words) & _TIMES and words[-1] not in ("x", "y", "z"):
        return _STAMP, unit
    for ending in ((), *_ENDINGS):
        rest = words[: len(words) - len(ending)]
        if not rest or tuple(words[len(rest) :]) != ending:
            continue
        for quantity in quantities:
            axis = quantity.axis(rest)
            if axis is not None:
                return quantity.label + axis, unit or "_".join(ending)
    return None, unit


def _scales(
    path: Path,
    line: int,
    quantities: tuple[Quantity, ...],
    units: list[str],
    names: tuple[str, ...],
) -> FloatArray:
    known = [entry.units for entry in quantities for _ in entry.axes]
    for name, unit, of in zip(names, units, known, strict=True):
        if unit and unit not in of:
            problem = f"expected one of the units {', '.join(of)}, got {unit!r}"
            raise refusal(path, problem, line=line, field=name)
    return np.array([of.get(unit, 1.0) for unit, of in zip(units, known, strict=True)])


def _stamp_unit(path: Path, line: int, stated: str, stamps: list[bytes]) -> str:
    """A key of `tables.UNITS`, by what the header states and what the stamps can be."""
    if stated and stated not in _TIME_UNITS:
        expected = "expected stamps in ns, us, ms or s"
        raise refusal(path, f"{expected}, got {stated!r}", line=line, field=_STAMP)
    if not stated and stamps and b":" in stamps[0]:
        return "clock"
    unit = _TIME_UNITS.get(stated, "ns")
    if not stated and (counted := _counted_in(stamps)) is not None:
        _LOG.warning("%s: stamps without a unit are taken as %s, by their steps", path, counted)
        return counted
    if unit != "ns" or not _are_no_nanoseconds(stamps):
        return unit
    if stated:
        problem = f"expected stamps in {stated}, as the header says, got {one_line(stamps[0])}"
        raise refusal(path, f"{problem} and others a fraction apart", field=_STAMP)
    return "s"


def _counted_in(stamps: list[bytes]) -> str | None:
    """The unit of whole stamps that can be no nanoseconds; None where they can, or none can be."""
    digits = [int(stamp) for stamp in stamps if stamp.strip().isdigit() and len(stamp) < 20]
    if len(digits) < max(len(stamps), 3):
        return None
    step = float(np.median(np.diff(digits)))
    if step >= _LEAST_STEP_NS or step <= 0.0:
        return None
    fitting = [
        unit for unit, power in UNITS.items() if _STEPS_NS[0] <= step * 10**power <= _STEPS_NS[1]
    ]
    return fitting[0] if len(fitting) == 1 else None


def _are_no_nanoseconds(stamps: list[bytes]) -> bool:
    """Whether stamps have fractions and stand too close together to be nanoseconds."""
    try:
        numbers = [Decimal(stamp.decode("ascii").strip()) for stamp in stamps]
        if all(number == number.to_integral_value() for number in numbers):
            return False
        steps = np.abs(np.diff(np.array([float(entry - numbers[0]) for entry in numbers])))
    except (InvalidOperation, UnicodeDecodeError, OverflowError):
        return False  # whoever reads them all says which line is wrong
    return len(steps) > 0 and float(np.median(steps)) < _LEAST_STEP_NS
