"""Fields of JSON files that others wrote: numbers, vectors, tables, lines; refused by name."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.files import read_bounded

MOST_BYTES = 16 * 2**20


def number(given: object, where: str) -> float:
    """A finite number of JSON.

    Raises:
        ValueError: anything else.
    """
    if isinstance(given, bool) or not isinstance(given, int | float) or not abs(given) < 1e9:
        raise ValueError(f"{where}: expected a number, got {_short(given)}")
    return float(given)


def vector(given: object, where: str, size: int) -> FloatArray:
    """A list of finite numbers of JSON.

    Raises:
        ValueError: anything else.
    """
    if not isinstance(given, list) or len(given) != size:
        raise ValueError(f"{where}: expected {size} numbers, got {_short(given)}")
    return checked_floats([number(one, where) for one in given], where, ())


def text(given: object, where: str) -> str:
    """A text of 1 to 1000 printable letters.

    Raises:
        ValueError: anything else.
    """
    if not isinstance(given, str) or not 1 <= len(given) <= 1000 or not given.isprintable():
        raise ValueError(f"{where}: expected a text, got {_short(given)}")
    return given


def listed(given: object, where: str, most: int) -> list[Any]:
    """A list of JSON of at most so many entries.

    Raises:
        ValueError: anything else.
    """
    if not isinstance(given, list) or len(given) > most:
        raise ValueError(f"{where}: expected a list of at most {most}, got {_short(given)}")
    return given


def table(given: object, where: str, known: Iterable[str]) -> dict[str, Any]:
    """An object of JSON that has no keys but those known.

    Raises:
        ValueError: anything else; the message names the first key that is not.
    """
    if not isinstance(given, dict):
        raise ValueError(f"{where}: expected an object of JSON, got {_short(given)}")
    allowed = sorted(known)
    for key in given:
        if key not in allowed:
            raise ValueError(f"{where}: expected fields of {', '.join(allowed)}, got {_short(key)}")
    return given


def read_json(path: Path) -> Any:
    """A file of JSON.

    Raises:
        ValueError: a file that cannot be read, is larger than 16 MiB, or no JSON.
    """
    return _json(path.name, _text(path))


def read_json_lines(path: Path) -> list[tuple[int, Any]]:
    """Line numbers and values of a file of JSON lines; empty lines are left out.

    Raises:
        ValueError: a file that cannot be read or is too large, a line that is no JSON.
    """
    lines = enumerate(_text(path).splitlines(), start=1)
    return [(at, _json(f"{path.name}:{at}", line)) for at, line in lines if line.strip()]


def _text(path: Path) -> str:
    try:
        return read_bounded(path, MOST_BYTES).decode("utf-8")
    except UnicodeDecodeError as fault:
        raise ValueError(f"{path}: expected UTF-8, got other bytes") from fault


def _json(where: str, text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as fault:  # also numbers of thousands of digits
        raise ValueError(f"{where}: expected JSON, got {' '.join(str(fault).split())}") from fault


def _short(given: object) -> str:
    told = repr(given)
    return told if len(told) <= 80 else f"{told[:77]}..."
