"""One table of a TOML manifest, read strictly: unknown keys, wrong types and ranges are refused."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

from motorcade.replays.errors import RecordingError, did_you_mean, one_line, read_bounded, refusal

__all__ = ["Section", "load_toml"]

TOML_LIMIT = 2**16
_WHOLE_LIMIT = 1_000_000


def load_toml(path: Path) -> dict[str, object]:
    """Read a TOML file of at most 64 KiB.

    Raises:
        RecordingError: missing, too large, not UTF-8, or not TOML (with the line).
    """
    data = read_bounded(path, TOML_LIMIT)
    try:
        return tomllib.loads(data.decode("utf-8"))
    except (ValueError, RecursionError) as fault:
        reason = "nested too deeply" if isinstance(fault, RecursionError) else str(fault)
        raise refusal(path, f"expected TOML: {reason}") from fault


class Section:
    """A table of a manifest and the keys it may hold.

    Args:
        path: the manifest.
        title: name of the table, "" for the top.
        table: what stands in the file.
        keys: all keys allowed.

    Raises:
        RecordingError: not a table, or a key that is not allowed (the nearest valid one is named).
    """

    def __init__(self, path: Path, title: str, table: object, keys: tuple[str, ...]) -> None:
        self.path = path
        self.title = f"[{title}]" if title else ""
        if not isinstance(table, Mapping):
            raise refusal(path, f"expected a table, got {one_line(table)}", field=self.title)
        self._table = table
        for key in table:
            if key not in keys:
                raise self.fault(one_line(key), "unknown key", did_you_mean(key, keys))

    def __contains__(self, key: str) -> bool:
        return key in self._table

    def __getitem__(self, key: str) -> object:
        if key not in self._table:
            raise self.fault(key, "the key is missing")
        return self._table[key]

    def fault(self, key: str, problem: str, advice: str | None = None) -> RecordingError:
        """Make the error for a key of this table."""
        field = f"{self.title} {key}".strip()
        return refusal(self.path, problem, field=field, advice=advice)

    def text(self, key: str, choices: tuple[str, ...] = ()) -> str:
        """A string, one of `choices` where they are given."""
        value = self[key]
        if not isinstance(value, str) or not value or len(value) > 1000:
            raise self.fault(key, f"expected text, got {one_line(value)}")
        if choices and value not in choices:
            expected = f"expected one of {', '.join(choices)}, got {one_line(value)}"
            raise self.fault(key, expected, did_you_mean(value, choices))
        return value

    def number(self, key: str, low: float, high: float) -> float:
        """A finite number from `low` to `high`."""
        return self._number(key, self[key], low, high)

    def whole(self, key: str, low: int = 0, high: int = _WHOLE_LIMIT) -> int:
        """A whole number from `low` to `high`."""
        value = self[key]
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            expected = f"expected a whole number from {low} to {high}"
            raise self.fault(key, f"{expected}, got {one_line(value)}")
        return value

    def numbers(self, key: str, most: int = 100) -> tuple[float, ...]:
        """A list of at most `most` finite numbers."""
        value = self[key]
        if not isinstance(value, list) or len(value) > most:
            raise self.fault(key, f"expected a list of numbers, got {one_line(value)}")
        return tuple(self._number(key, item, -1e12, 1e12) for item in value)

    def texts(self, key: str, most: int = 100) -> tuple[str, ...]:
        """A list of at most `most` strings."""
        value = self[key]
        if not isinstance(value, list) or len(value) > most:
            raise self.fault(key, f"expected a list of texts, got {one_line(value)}")
        for item in value:
            if not isinstance(item, str) or len(item) > 1000:
                raise self.fault(key, f"expected texts, got {one_line(item)}")
        return tuple(value)

    def only_one(self, first: str, second: str) -> None:
        """Refuse two keys that say the same thing."""
        if first in self and second in self:
            raise self.fault(second, f"expected either {first} or {second}, got both")

    def _number(self, key: str, value: object, low: float, high: float) -> float:
        if isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high:
            return float(value)
        expected = f"expected a number from {low:g} to {high:g}"
        raise self.fault(key, f"{expected}, got {one_line(value)}")
