"""XML into elements, without entities, DTDs or depths that a hostile file could use.

Namespaces are dropped. Text of long arrays stays one string until it is asked for as numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.parsers import expat

import numpy as np

from motorcade.animation.formats.errors import FormatError, expected
from motorcade.animation.formats.limits import MAX_DEPTH
from motorcade.animation.formats.numbers import numbers_in
from motorcade.ga.arrays import FloatArray, IntArray

MAX_ELEMENTS = 500_000


class Element:
    """An XML element: name, attributes, children, text before the first child.

    Args:
        name: without its namespace.
        attributes: by name.
    """

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
        """The first descendant along a path of names.

        Raises:
            FormatError: there is none.
        """
        found = self.first(*path)
        if found is None:
            raise expected(f"<{self.name} {self.get('id')}>", f"<{'/'.join(path)}>", "none")
        return found

    def all(self, name: str) -> list[Element]:
        """Children of that name."""
        return [child for child in self.children if child.name == name]

    def every(self, name: str) -> Iterator[Element]:
        """Descendants of that name, in the order of the file."""
        waiting = self.children[::-1]
        while waiting:
            one = waiting.pop()
            if one.name == name:
                yield one
            waiting += one.children[::-1]

    def floats(self, count: int | None = None) -> FloatArray:
        """The text as finite numbers.

        Raises:
            FormatError: other text, or another count.
        """
        values = numbers_in(self.text, f"<{self.name} {self.get('id')}>")
        if count is not None and len(values) != count:
            raise expected(f"<{self.name} {self.get('id')}>", f"{count} numbers", len(values))
        return values

    def integers(self) -> IntArray:
        """The text as whole numbers.

        Raises:
            FormatError: other text.
        """
        values = self.floats()
        made = values.astype(np.int64)
        if not np.array_equal(made, values):
            raise expected(f"<{self.name}>", "whole numbers", "others")
        return made


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
        made = Element(name.rpartition(" ")[2], attributes)
        stack[-1].children.append(made)
        stack.append(made)

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
