"""Tables of a text file whose header says what stands where, and in which units.

Columns stand between commas, semicolons or tabs, and where commas do not part them, a comma may
stand for the decimal point. A header is the last line of comment, or the row of names, above the
numbers; two rows of names are a group's and its axes'. Where it names every column that is wanted
(`w_RS_S_x [rad s^-1]`, `gyro_x`, `angular_velocity.x`, `ax (g)`, `gFx`, `qw`), the file is read by
it; where it says nothing, columns are EuRoC's, in EuRoC's order. One that names a column in another
place and leaves others open is refused, as is a unit that nobody knows; signs that were written in
one encoding and read in another (`m/sÂ²`) are known. Of stamps, that of a message's header counts
before the time of its arrival, and that of the very sensor before others.

Stamps without a unit are nanoseconds, unless they cannot be: fractions that are nanoseconds apart
are seconds, and whole numbers are of the one unit in which they are sampled 0.5 to 20,000 times a
second. Times of the day (`11:23:45.123`) count from midnight. Xsens' `SampleTimeFine` counts 100 µs
(MTi, MTw: MT Low Level Communication Protocol, XDI 0x1060) or 1 µs (Xsens DOT User Manual, 4.2) in
32 bits; where it is empty, `PacketCounter`, of 16 bits, counts by the update rate above the header.
"""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass, replace
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any, NamedTuple

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
_RATE = re.compile(
    rb"(?i)(?:update|output|sample|sampling) ?rate\W+([1-9][0-9]{0,4}(?:\.[0-9]{1,6})?)"
)
_TICKS_US = 8000.0
"""Steps of `SampleTimeFine` below are 100 µs each: DOT's, of 1 µs, are 8333 at their fastest."""
_LOG = logging.getLogger("motorcade.replays")


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


def _spelled(spellings: dict[str, Any]) -> dict[str, Any]:
    """By each word of the keys."""
    return {word: meant for words, meant in spellings.items() for word in words.split()}


_WITHOUT_GRAVITY = _words("linear lin user free")
_ANGULAR = _words("angular ang angle")
_FORCE_WORDS = _words("acc accel accelerometer acceleration force")
_TIMES = _words("timestamp timestamps time stamp t ts")
_TIME_UNITS = {
    "ns nsec nsecs nanosecond nanoseconds": "ns",
    "ms msec millisecond milliseconds": "ms",
}
_TIME_UNITS |= {"us usec microsecond microseconds": "us", "s sec secs second seconds": "s"}
_TIME_UNITS = _spelled(_TIME_UNITS)


@dataclass(frozen=True)
class Quantity:
    """What some columns hold, by the words of their names.

    Fields:
        words: any of which stands in the name, before the axis.
        letters: any of which opens the name, before the axis; `""` for axes alone.
        axes: in the order in which they are wanted.
        label: what a column is called in refusals, before its axis.
        units: what one of each is in our own unit.
        without: words of a name that make it another quantity.
        of: words any of which the name must have too, where there are some.
    """

    words: frozenset[str]
    letters: frozenset[str]
    axes: str
    label: str
    units: dict[str, float]
    without: frozenset[str] = frozenset()
    of: frozenset[str] = frozenset()

    def axis(self, words: list[str]) -> str | None:
        """The axis that a name means; None where it means something else."""
        *before, last = words
        if self.without.intersection(words) or (self.of and not self.of.intersection(words)):
            return None
        if last[-1] in self.axes and last[:-1] and last[:-1] in self.words | self.letters:
            return last[-1]  # gyrox, wx
        if len(last) > 1 or last not in self.axes:
            return None
        opens = before[0] if before else ""
        return last if opens in self.letters or self.words & set(before) else None


_DEGREES = "deg/s degs-1 deg/sec deg_s °/s °s-1 dps"
ANGULAR_RATE = Quantity(
    _words("gyr gyro gyroscope omega angular ang rate"),
    _words("w g"),
    "xyz",
    "w_",
    _spelled({"rad/s rads-1 rad/sec rad_s": 1.0, _DEGREES: np.pi / 180.0}),
    without=_FORCE_WORDS | {"angle"},
)
_FORCE_UNITS = _spelled({"m/s2 ms-2 m/s/s m_s2": 1.0, "g": 9.80665, "mg": 9.80665e-3})
SPECIFIC_FORCE = Quantity(
    _FORCE_WORDS, _words("a f"), "xyz", "a_", _FORCE_UNITS, _WITHOUT_GRAVITY | _ANGULAR
)
MAYBE_FREE = Quantity(
    _FORCE_WORDS, frozenset(), "xyz", "a_", _FORCE_UNITS, _ANGULAR, of=_WITHOUT_GRAVITY
)
"""Android's linear, Apple's of the user, Xsens' free: without gravity; ROS' linear: with it."""
GRAVITY = Quantity(_words("gravity"), frozenset(), "xyz", "g_", _FORCE_UNITS)
_FIELD_UNITS = {"ut microtesla - 1 a.u.": 1.0, "g gauss ga": 100.0, "mg mgauss": 0.1}
_FIELD_UNITS |= {"t tesla": 1e6, "mt": 1e3, "nt": 1e-3}
MAGNETIC_FIELD = Quantity(
    _words("mag magn magnetic magnetometer"), _words("m b"), "xyz", "m_", _spelled(_FIELD_UNITS)
)
_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0}
POSITION = Quantity(
    _words("pos position translation"), frozenset({"p", "t", ""}), "xyz", "t", _LENGTHS
)
QUATERNION = Quantity(
    _words("quat quaternion orientation rotation rot"),
    _words("q"),
    "wxyz",
    "q",
    {"-": 1.0, "1": 1.0},
)


def names_quantity(path: Path, quantity: Quantity) -> bytes | None:
    """The name of a quantity's first axis, where the file's header names all; None elsewhere."""
    header = read_opening(path, len(quantity.axes)).header or []
    meant = {_meant(*_name_and_unit(token), (quantity,))[0]: token for token in reversed(header)}
    names = [quantity.label + axis for axis in quantity.axes]
    return meant[names[0]] if meant.keys() >= set(names) else None


def read_columns(path: Path, quantities: tuple[Quantity, ...]) -> Table:
    """Read a stamp and quantities by the file's header, in our units and in the order given.

    Of rows with equal stamps the first is kept; rows that leave one of the columns empty are not.

    Raises:
        RecordingError: as `read_table` and `in_order`; a header that contradicts EuRoC's order and
            does not say where everything is; a unit that is not known.
    """
    known = {entry.label + axis: entry for entry in quantities for axis in entry.axes}
    names = tuple(known)
    opening = read_opening(path, 1 + len(names))
    layout = _layout(path, opening, quantities)
    stamps = [row[layout.places[0]] for row in opening.rows if layout.places[0] < len(row)]
    unit, wraps, stretch = _counter(path, opening, layout, stamps)
    table = read_table(
        path,
        names,
        separator=opening.separator,
        decimal_comma=opening.decimal_comma,
        unit=unit or _stamp_unit(path, opening.line, layout.units[0], stamps),
        header=True,
        below=opening.line,
        more_columns=True,
        places=tuple(layout.places),
    )
    if wraps:
        turns = np.cumsum(np.diff(table.time_ns, prepend=table.time_ns[0]) < -wraps // 2)
        time_ns = np.rint((table.time_ns + wraps * turns) * stretch).astype(np.int64)
        table = replace(table, time_ns=time_ns)
    units = layout.units[1:]
    if unit == "us" and quantities[0] is ANGULAR_RATE and not any(units[:3]):
        _LOG.warning("%s: rates are in degrees, as Xsens DOT's; else say: Gyr_X (rad/s)", path)
        units[:3] = ["deg/s"] * 3
    scale = _scales(path, opening.line, known, units)
    if np.any(scale != 1.0):
        table = replace(table, values=table.values * scale)
    return table.rows(in_order(path, table.lines, table.time_ns))


def stamp_column(path: Path, quantity: Quantity) -> int:
    """Where the stamps of a quantity stand."""
    return _layout(path, read_opening(path, 1 + len(quantity.axes)), (quantity,)).places[0]


def _counter(
    path: Path, opening: _Opening, layout: _Layout, stamps: list[bytes]
) -> tuple[str | None, int, float]:
    """Of Xsens' counters the unit, the ns after which they begin anew, and what stretches these."""
    if layout.clock == ["packet", "counter"]:
        if opening.rate_hz is None:
            problem = "expected stamps, or 'Update Rate: 100 Hz' above the header, got a counter"
            advice = "add that line, or a column of stamps: time_s"
            raise refusal(path, problem, line=opening.line, advice=advice)
        return "ns", 2**16, 1e9 / opening.rate_hz
    if layout.clock != ["sample", "time", "fine"] or layout.units[0]:
        return None, 0, 1.0
    try:
        counts = np.array([float(stamp) for stamp in stamps if stamp.strip()])
    except ValueError:
        counts = np.zeros(0)  # whoever reads them all says which line is wrong
    steps = np.diff(counts)[np.diff(counts) > 0]
    dot = len(steps) > 0 and float(np.median(steps)) >= _TICKS_US
    unit = "us" if dot else "100 us"
    return unit, 2**32 * 10 ** UNITS[unit], 1.0


class _Opening(NamedTuple):
    """Line number and tokens of the header, if there is one, the first rows below it, how columns
    are parted (None: by white space), and the rate of samples that a line above states.
    """

    line: int
    header: list[bytes] | None
    rows: list[list[bytes]]
    separator: bytes | None
    decimal_comma: bool
    rate_hz: float | None


def read_opening(path: Path, wanted: int) -> _Opening:
    """Look at the first rows, and for a header of so many columns above them."""
    at, header, rows, group = 0, None, list[list[bytes]](), list[bytes]()
    separator: bytes | None = b","
    above, rate_hz = True, None
    with open_bounded(path, FILE_LIMIT) as file:
        number = 0
        while len(rows) < _LOOKED_AT and (line := file.readline(LINE_LIMIT)):
            number += 1
            text = line.removeprefix(b"\xef\xbb\xbf").strip(b" \r\n")
            parts = next((part for part in _PARTS if part in text), None)
            row = text.lstrip(b"#, ").split(parts)
            if above and (stated := _RATE.search(text)):
                rate_hz = float(stated[1])
            names = text.startswith(b"#") or (above and is_header(row))
            if not names and text:
                rows.append(row)
                separator = parts
                above = above and len(row) < wanted
            elif above and len(row) >= wanted and is_header(row):
                grouped = len(group) == len(row) and not text.startswith(b"#")
                group, header = row, _grouped(group, row) if grouped else row
                at, rows = number, []
    by_comma = separator not in (b",", None) and any(b"," in b"".join(row) for row in rows)
    if by_comma:
        rows = [[token.replace(b",", b".") for token in row] for row in rows]
    return _Opening(at, header, rows, separator, by_comma, rate_hz)


def _grouped(groups: list[bytes], axes: list[bytes]) -> list[bytes]:
    """Names of two rows: that of a group holds until the next one."""
    names, above = [], b""
    for group, axis in zip(groups, axes, strict=True):
        above = group.strip() or above
        names.append(above + b" " + axis)
    return names


class _Layout(NamedTuple):
    """Where the stamp and each column stand, their units, and the words of the stamp's name."""

    places: list[int]
    units: list[str]
    clock: list[str]


def _layout(path: Path, opening: _Opening, quantities: tuple[Quantity, ...]) -> _Layout:
    """By the header, or in EuRoC's order where it says nothing."""
    names = (_STAMP, *(entry.label + axis for entry in quantities for axis in entry.axes))
    order, units = list(range(len(names))), [""] * len(names)
    if opening.header is None:
        return _Layout(order, units, [])
    said = [_name_and_unit(token) for token in opening.header]
    seen: dict[str, list[int]] = {}
    for at, (words, unit) in enumerate(said):
        name, unit = _meant(words, unit, quantities)
        if name is not None:
            seen.setdefault(name, []).append(at)
            said[at] = (words, unit)
    stamps = _by_rank(seen, said, opening.rows)
    twice = [name for name, places in seen.items() if len(places) > 1]
    seen |= {_STAMP: stamps} if stamps else {}
    missing = [name for name in names if name not in seen]
    in_order = all(places == [names.index(name)] for name, places in seen.items())
    if twice or (missing and not in_order):
        what = f"{twice[0]} twice" if twice else f"no {missing[0]}"
        expected = f"expected a header that names {' '.join(names)}, or leaves them in this order"
        problem = f"{expected}, got {what} in {one_line(b','.join(opening.header))}"
        raise refusal(path, problem, line=opening.line, advice="rename its columns")
    if not missing:
        order = [seen[name][0] for name in names]
    units = [said[at][1] if name in seen else "" for name, at in zip(names, order, strict=True)]
    return _Layout(order, units, said[stamps[0]][0] if stamps else [])


def _by_rank(
    seen: dict[str, list[int]], said: list[tuple[list[str], str]], rows: list[list[bytes]]
) -> list[int]:
    """Leave the best columns of each name, take the stamps out of them, and give the best one."""
    stamps = seen.pop(_STAMP, [])
    for name, places in seen.items():
        ranks = [_rank(name, said[at][0]) for at in places]
        seen[name] = [at for at, rank in zip(places, ranks, strict=True) if rank == min(ranks)]
    sensors = {said[at][0][0] for places in seen.values() for at in places}

    def rank(at: int) -> tuple[bool, ...]:
        words, unit = said[at]
        empty = bool(rows) and not any(at < len(row) and row[at].strip() for row in rows)
        counts = words == ["packet", "counter"]
        unknown = bool(unit) and unit not in _TIME_UNITS
        return empty, counts, unknown, "header" not in words, words[0] not in sensors

    return sorted(stamps, key=rank)[:1]


def _rank(name: str, words: list[str]) -> int:
    """The lower, the sooner a column is taken among several of one name."""
    if "uncalibrated" in words:
        return 3
    if words[0] == "motion":  # Core Motion's, without biases, beside raw readings
        return 0 if name.startswith(MAGNETIC_FIELD.label) else 2
    return 0 if words[0] == "g" else 1


_DAMAGED = {"m/s\ufffd": "m/s2", "\ufffdt": "ut", "\ufffd/s": "°/s"}
_SIGNS = str.maketrans({"²": "2", "μ": "u", "µ": "u", "⁻": "-", "¹": "1", "^": None, "?": "\ufffd"})


def _decoded(token: bytes) -> str:
    """Text in UTF-8 or Windows' Latin, also where UTF-8 was read as that and saved, twice even."""
    try:
        text = token.decode("utf-8")
    except UnicodeDecodeError:
        text = token.decode("cp1252", "replace")
    for encoding in ("latin-1", "cp1252", "latin-1") if not text.isascii() else ():
        try:
            text = text.encode(encoding).decode("utf-8")
        except UnicodeError:
            continue
    return text


def _name_and_unit(token: bytes) -> tuple[list[str], str]:
    """Words of a column's name, lower-case, and what it says in brackets, in one spelling."""
    text = _decoded(token).strip().strip("\"'").strip()
    brackets = re.search(r"[\[(](?:in )?([^\])]*)[\])]", text)
    unit = re.sub(r"[\s·*]", "", brackets[1]).lower().translate(_SIGNS) if brackets else ""
    unit = re.sub("\ufffd+", "\ufffd", unit)
    bare = text[: brackets.start()] if brackets else text
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", bare).lower()
    words = [word for word in re.split(r"[^a-z0-9°]+", parted) if word]
    if not unit and words[:2] in _IN_G:
        unit = "g"
    return words, _DAMAGED.get(unit, unit)


_IN_G = (["accelerometer", "acceleration"], ["motion", "user"], ["motion", "gravity"])
"""How names begin of what Apple's Core Motion counts in g, as SensorLog writes them."""
_ENDINGS = (("rad", "s"), ("deg", "s"), ("m", "s2"), ("dps",), ("g",), ("mg",), ("m",), ("mm",))


def _meant(words: list[str], unit: str, quantities: tuple[Quantity, ...]) -> tuple[str | None, str]:
    """Which column a name means, None for another one; and its unit, also where a word says it."""
    if not words or words[0] in ("b", "bias"):
        return None, unit
    if len(words) == 2 and words[0] == "g" and words[1] in ("fx", "fy", "fz"):
        words, unit = [words[1]], unit or "g"  # g-force
    if words[-1] in _TIME_UNITS and len(words) > 1 and set(words[:-1]) & _TIMES:
        return _STAMP, unit or words[-1]
    timed = set(words) & _TIMES or words == ["packet", "counter"]
    if timed and words[-1] not in ("x", "y", "z"):
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


def _scales(path: Path, line: int, known: dict[str, Quantity], units: list[str]) -> FloatArray:
    for (name, of), unit in zip(known.items(), units, strict=True):
        if unit and unit not in of.units:
            problem = f"expected one of the units {', '.join(of.units)}, got {unit!r}"
            raise refusal(path, problem, line=line, field=name)
    return np.array(
        [of.units.get(unit, 1.0) for of, unit in zip(known.values(), units, strict=True)]
    )


def _stamp_unit(path: Path, line: int, stated: str, stamps: list[bytes]) -> str:
    """A key of `tables.UNITS`, by what the header states and what the stamps can be."""
    if stated and stated not in _TIME_UNITS:
        expected = "expected stamps in ns, us, ms or s"
        raise refusal(path, f"{expected}, got {stated!r}", line=line, field=_STAMP)
    if not stated and stamps and b":" in stamps[0]:
        return "clock"
    if (unit := _TIME_UNITS.get(stated, "ns")) != "ns":
        return unit
    by_steps, whole = _unit_by_steps(stamps)
    if stated and by_steps is not None and not whole:
        problem = f"expected stamps in {stated}, as the header says, got {one_line(stamps[0])}"
        raise refusal(path, f"{problem} and others a fraction apart", field=_STAMP)
    if stated or by_steps is None:
        return unit
    if whole:
        _LOG.warning("%s: stamps without a unit are taken as %s, by their steps", path, by_steps)
    return by_steps


def _unit_by_steps(stamps: list[bytes]) -> tuple[str | None, bool]:
    """The unit of stamps that cannot be nanoseconds, None where they can; whether all are whole.

    Fractions that stand too close together are seconds.
    """
    try:
        numbers = [Decimal(stamp.decode("ascii").strip()) for stamp in stamps]
        whole = all(number == number.to_integral_value() for number in numbers)
        steps = np.diff(np.array([float(entry - numbers[0]) for entry in numbers]))
    except (InvalidOperation, UnicodeDecodeError, OverflowError):
        return None, False  # whoever reads them all says which line is wrong
    step = float(np.median(steps if whole else np.abs(steps))) if len(steps) > whole else np.inf
    if not step < _LEAST_STEP_NS or (whole and step <= 0.0):
        return None, whole
    known = [unit for unit in UNITS if unit in _TIME_UNITS]
    fitting = [u for u in known if _STEPS_NS[0] <= step * 10 ** UNITS[u] <= _STEPS_NS[1]]
    return ("s" if not whole else fitting[0] if len(fitting) == 1 else None), whole
