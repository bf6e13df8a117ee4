"""A Collada document: elements by id, and the arrays of its sources."""

from __future__ import annotations

import numpy as np

from motorcade.animation.formats.collada.xml import Element
from motorcade.animation.formats.errors import FormatError, expected
from motorcade.animation.formats.limits import MAX_VALUES
from motorcade.ga.arrays import FloatArray


class Library:
    """Looks up what a document refers to.

    Args:
        root: the `COLLADA` element.
    """

    def __init__(self, root: Element) -> None:
        if root.name != "COLLADA":
            raise expected("root element", "COLLADA", root.name)
        self.root = root
        self._by_id: dict[str, Element] = {}
        for one in self._everything():
            if one.get("id"):
                self._by_id.setdefault(one.get("id"), one)
        self._floats: dict[str, FloatArray] = {}
        self._total = 0

    def _everything(self) -> list[Element]:
        found, waiting = [], [self.root]
        while waiting:
            one = waiting.pop()
            found.append(one)
            waiting += one.children[::-1]
        return found

    def find(self, url: str) -> Element | None:
        """The element that `#id` names, or None."""
        return self._by_id.get(url[1:]) if url.startswith("#") else None

    def named(self, url: str, name: str, field: str) -> Element:
        """The element of that name that `#id` refers to.

        Raises:
            FormatError: there is none.
        """
        found = self.find(url)
        if found is None or found.name != name:
            raise expected(field, f"the id of a <{name}>", url or "nothing")
        return found

    def source(self, url: str, field: str, width: int) -> FloatArray:
        """Values (n, width) of a source of numbers, as its accessor takes them apart.

        Raises:
            FormatError: no such source, or an accessor that does not fit its array.
        """
        key = f"{url} {width}"
        if key not in self._floats:
            self._floats[key] = self._values(url, field, width)
        return self._floats[key]

    def _values(self, url: str, field: str, width: int) -> FloatArray:
        source = self.named(url, "source", field)
        array = source.first("float_array")
        if array is None:
            raise expected(f"{field} {url}", "a <float_array>", "none")
        values = array.floats()
        self._total += len(values)
        if self._total > MAX_VALUES:
            raise FormatError(f"sources: expected at most {MAX_VALUES} numbers in all, got more")
        accessor = source.first("technique_common", "accessor")
        stride, offset, count = width, 0, len(values) // width
        if accessor is not None:
            stride = number(accessor.get("stride") or "1", f"{url} stride", 1, 1000)
            offset = number(accessor.get("offset") or "0", f"{url} offset", 0, len(values))
            count = number(accessor.get("count"), f"{url} count", 0, len(values))
        if stride < width or offset + count * stride > len(values):
            raise expected(
                f"{url} accessor", f"{width} of {len(values)} numbers", f"{count} x {stride}"
            )
        rows = values[offset : offset + count * stride].reshape(count, stride)
        return rows[:, :width]

    def names(self, url: str, field: str) -> list[str]:
        """Strings of a source of names or ids.

        Raises:
            FormatError: no such source.
        """
        source = self.named(url, "source", field)
        array = source.first("Name_array") or source.first("IDREF_array")
        if array is None:
            raise expected(f"{field} {url}", "a <Name_array> or <IDREF_array>", "none")
        return array.text.split()


def inputs_of(element: Element) -> dict[str, Element]:
    """The inputs of an element by their semantic; of several the first."""
    made: dict[str, Element] = {}
    for one in element.all("input"):
        made.setdefault(one.get("semantic"), one)
    return made


def number(text: str, field: str, low: int, high: int) -> int:
    """A whole number in a range, out of an attribute.

    Raises:
        FormatError: anything else.
    """
    digits = text.strip()
    if not (digits.isascii() and digits.isdigit() and len(digits) < 12):
        raise expected(field, "a whole number", text)
    value = int(digits)
    if not low <= value <= high:
        raise expected(field, f"a number from {low} to {high}", value)
    return value


def matrices_of(values: FloatArray) -> FloatArray:
    """Matrices (n, 4, 4) out of rows (n, 16), written row by row as Collada does."""
    return np.ascontiguousarray(values.reshape(-1, 4, 4))
