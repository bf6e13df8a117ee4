"""Names and values in messages: the nearest of those that are known, and quotes on one line."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Collection, Iterable

_NAMES_SHOWN = 12
_LONG_NUMBER = re.compile(r"Exceeds the limit \((\d+) digits\) for integer string conversion.*")


def nearest_name(name: str, allowed: Iterable[str]) -> str:
    """`"; did you mean …?"` to close a message that lists all names; nothing where none is near.

    >>> nearest_name("gausian", ["gaussian", "spline"])
    '; did you mean gaussian?'
    >>> nearest_name("7", ["gaussian", "spline"])
    ''
    """
    near = difflib.get_close_matches(name[:100], list(allowed), n=1, cutoff=0.5)
    return f"; did you mean {near[0]}?" if near else ""


def did_you_mean(name: str, allowed: Iterable[str]) -> str:
    """Give the nearest valid name, or the first dozen of them, as advice for an unknown one."""
    names = list(allowed)
    if near := nearest_name(name, names):
        return near.removeprefix("; ")
    shown = ", ".join(names[:_NAMES_SHOWN]) or "none"
    more = len(names) - _NAMES_SHOWN
    return f"known here: {shown}" + (f" and {more} more" if more > 0 else "")


def check_word(word: object, words: Collection[str], field: str) -> None:
    """Refuse what is none of these words. Raises ValueError: naming the field and the words."""
    if word not in words:
        raise ValueError(f"{field}: expected one of {', '.join(words)}, got {word!r}")


def plain_reason(reason: str) -> str:
    """What a parser says of a number of thousands of digits, without its advice to programmers.

    >>> plain_reason("Exceeds the limit (4300 digits) for integer string conversion: ...")
    'expected numbers of at most 4300 digits, got a longer one'
    """
    long = _LONG_NUMBER.search(reason)
    if long is None:
        return reason
    return f"{reason[: long.start()]}expected numbers of at most {long[1]} digits, got a longer one"


def one_line(value: object, limit: int = 60) -> str:
    """Quote a value from a file for a message: printable, on one line, shortened to `limit`."""
    if isinstance(value, bytes):
        text = value[: 4 * limit].decode("utf-8", "replace")
    elif isinstance(value, list | tuple | dict):
        text = reprlib.repr(value)  # bounds the depth and the count of what it shows
    else:
        text = plain_reason(str(value))
    text = printable(text[: limit + 1])
    return repr(text if len(text) <= limit else text[: limit - 3] + "...")


def printable(text: str) -> str:
    """`text` with a question mark for every letter that a terminal does not show."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)
