"""A Collada document: elements by id, and the arrays of its sources.

XML is read without entities, DTDs or depths that a hostile file could use.
Namespaces are dropped. Text of long arrays stays one string until it is asked for as numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from urllib.parse import unquote
from xml.parsers import expat

import numpy as np

from motorcade.animation.formats.limits import (
    MAX_DEPTH,
    MAX_VALUES,
    FormatError,
    expected,
    numbers_in,
)
from motorcade.ga.arrays import FloatArray, IntArray

MAX_ELEMENTS = 500_000


class Element:
    """An XML element: name (without its namespace), attributes, children, text before them."""

    __slots__ = ("attributes", "children", "name", "text")

    def __init__(self, name: str, attributes: dict[str, str]) -> None:
        self.name = name
        self.attributes = attributes
        self.children: list[Element] = []
        self.text = ""

    def get(self, attribute: str) -> str:
        """An attribute; empty where it is missing."""
        return self.attributes.get(attribute, "")

    def first(self, *path: str) -> Element | None:
        """The first descendant along a path of names, or None."""
        at: Element | None = self
        for name in path:
            below = () if at is None else at.children
            at = next((child for child in below if child.name == name), None)
        return at

    def needed(self, *path: str) -> Element:
        """The first descendant along a path of names. Raises FormatError: there is none."""
        element = self.first(*path)
        if element is None:
            raise expected(f"<{self.name} {self.get('id')}>", f"<{'/'.join(path)}>", "none")
        return element

    def all(self, name: str) -> list[Element]:
        """Children of that name."""
        return [child for child in self.children if child.name == name]

    def every(self, name: str = "") -> Iterator[Element]:
        """Descendants of that name, or all, in the order of the file."""
        waiting = self.children[::-1]
        while waiting:
            element = waiting.pop()
            if name in ("", element.name):
                yield element
            waiting += element.children[::-1]

    def floats(self, count: int | None = None) -> FloatArray:
        """The text as finite numbers. Raises FormatError: other text, or another count."""
        values = numbers_in(self.text, f"<{self.name} {self.get('id')}>")
        if count is not None and len(values) != count:
            raise expected(f"<{self.name} {self.get('id')}>", f"{count} numbers", len(values))
        return values

    def integers(self) -> IntArray:
        """The text as whole numbers. Raises FormatError: other text."""
        values = self.floats()
        numbers = values.astype(np.int64)
        if not np.array_equal(numbers, values):
            raise expected(f"<{self.name}>", "whole numbers", "others")
        return numbers


def parse_xml(data: bytes) -> Element:
    """The root element of a document.

    Raises:
        FormatError: not well-formed, with a document type or entities, or too deep or large.
    """
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    top = Element("", {})
    stack = [top]
    count = 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if len(stack) > MAX_DEPTH or count > MAX_ELEMENTS:
            raise FormatError(
                f"XML: expected at most {MAX_DEPTH} levels and {MAX_ELEMENTS} elements, got more"
            )
        element = Element(name.rpartition(" ")[2], attributes)
        stack[-1].children.append(element)
        stack.append(element)

    def text(data: str) -> None:
        if not stack[-1].children:
            stack[-1].text += data

    def refuse(*_: object) -> int:
        raise FormatError("XML: expected no document type and no entities, got some")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: stack.pop()
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    parser.ExternalEntityRefHandler = refuse
    try:
        parser.Parse(data, True)
    except expat.ExpatError as fault:
        raise FormatError(f"XML: {fault}") from fault
    except (LookupError, ValueError) as fault:  # encodings that Python does not know
        if isinstance(fault, FormatError):
            raise
        raise FormatError(f"XML: {fault}") from fault
    return top.children[0]


class Library:
    """Looks up what a document refers to."""

    def __init__(self, root: Element) -> None:
        if root.name != "COLLADA":
            raise expected("root element", "COLLADA", root.name)
        self.root = root
        self._by_id: dict[str, Element] = {}
        for element in (root, *root.every()):
            if element.get("id"):
                self._by_id.setdefault(element.get("id"), element)
        self._floats: dict[str, FloatArray] = {}
        self._total = 0

    def find(self, url: str) -> Element | None:
        """The element that `#id` names, blanks in it written as such or as ``%20``; or None."""
        if not url.startswith("#"):
            return None
        return self._by_id.get(url[1:]) or self._by_id.get(unquote(url[1:]))

    def named(self, url: str, name: str, field: str) -> Element:
        """The element of that name that `#id` refers to.

        Raises:
            FormatError: there is none.
        """
        element = self.find(url)
        if element is None or element.name != name:
            raise expected(field, f"the id of a <{name}>", url or "nothing")
        return element

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
    inputs: dict[str, Element] = {}
    for element_input in element.all("input"):
        inputs.setdefault(element_input.get("semantic"), element_input)
    return inputs


def number(text: str, field: str, low: int, high: int) -> int:
    """A whole number in a range, out of an attribute. Raises FormatError: anything else."""
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
