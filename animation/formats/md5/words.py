"""The words of MD5 files: names, whole numbers, rows of numbers in brackets."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from motorcade.animation.formats.errors import FormatError, expected, shown
from motorcade.animation.formats.limits import MAX_TEXT_BYTES, read_bounded
from motorcade.ga.arrays import FloatArray

WORD = re.compile(r'//[^\n]*|"([^"\n]*)"|([(){}])|([^\s(){}"]+)')


class Words:
    """Reads an MD5 file word by word; brackets around numbers are passed over.

    Args:
        data: the file.
    """

    def __init__(self, data: bytes) -> None:
        text = data.decode("utf-8", "replace")
        self._words = [match[0] for match in WORD.finditer(text) if not match[0].startswith("//")]
        self._at = 0

    @property
    def done(self) -> bool:
        """Whether nothing is left."""
        return self._at >= len(self._words)

    def peek(self) -> str:
        """The next word; empty at the end."""
        return "" if self.done else self._words[self._at]

    def word(self, field: str) -> str:
        """The next word, without quotes.

        Raises:
            FormatError: the file ends.
        """
        if self.done:
            raise expected(field, "a word", "the end of the file")
        self._at += 1
        return self._words[self._at - 1].strip('"')

    def need(self, *wanted: str) -> None:
        """Pass over these words.

        Raises:
            FormatError: others stand there.
        """
        for one in wanted:
            got = self.word(one)
            if got != one:
                raise expected("file", f"'{one}'", got)

    def integer(self, field: str, low: int, high: int) -> int:
        """A whole number in a range.

        Raises:
            FormatError: anything else.
        """
        word = self.word(field)
        if not re.fullmatch(r"-?\d{1,9}", word, re.ASCII) or not low <= int(word) <= high:
            raise expected(field, f"a whole number from {low} to {high}", word)
        return int(word)

    def floats(self, count: int, field: str) -> FloatArray:
        """The next `count` numbers, whatever brackets stand between them.

        Raises:
            FormatError: other words, the end of the file, NaN or infinity.
        """
        found: list[str] = []
        while len(found) < count and not self.done:
            word = self._words[self._at]
            self._at += 1
            if word not in "()":
                found.append(word)
        if self.peek() == ")":
            self._at += 1
        try:
            values = np.array(found, dtype=np.float64) if found else np.zeros(0)
        except ValueError as fault:
            raise FormatError(f"{field}: expected numbers, {shown(fault)}") from fault
        if len(values) != count:
            raise expected(field, f"{count} numbers", len(values))
        if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > 1e9:
            raise expected(field, "finite numbers up to 1e9", "others")
        return values

    def skip_block(self) -> None:
        """Pass over a block in braces."""
        self.need("{")
        while self.word("a closing brace") != "}":
            pass


def opened(path: Path) -> Words:
    """The words of an MD5 file after its version and command line.

    Raises:
        FormatError: a file that is too large, or of another version.
    """
    words = Words(read_bounded(path, MAX_TEXT_BYTES))
    words.need("MD5Version")
    words.integer("MD5Version", 10, 10)
    if words.peek() == "commandline":
        words.word("commandline")
        words.word("commandline")
    return words
