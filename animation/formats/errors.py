"""What a reader refuses, in one line: file, field, what was expected, what came."""

from __future__ import annotations

from pathlib import Path

_SHOWN = 80


class FormatError(ValueError):
    """A character or motion file cannot be used as it is; the message says where and why."""

    def in_file(self, path: Path) -> FormatError:
        """The same error, opened by the name of the file it was found in."""
        return type(self)(f"{shown(str(path), 300)}: {self}")


class NoMeshError(FormatError):
    """A motion was read where a character was wanted: nothing in the file has a surface."""


def expected(field: str, wanted: str, got: object) -> FormatError:
    """Make the error "field: expected ..., got ..."; what came is shortened and printable."""
    return FormatError(f"{shown(field)}: expected {wanted}, got {shown(got)}")


def shown(value: object, limit: int = _SHOWN) -> str:
    """A value from a file for a message: printable, on one line, shortened to `limit`."""
    if isinstance(value, dict | list | tuple):
        text = f"{len(value)} entries"
    else:
        text = str(value) if not isinstance(value, bytes) else repr(value[:limit])
    text = text if len(text) <= limit else text[: limit - 3] + "..."
    return "".join(letter if letter.isprintable() else "?" for letter in text)
