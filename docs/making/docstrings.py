"""An extension of griffe for what our docstrings write differently: fields, and bare examples."""

from __future__ import annotations

import re
from typing import Any

import griffe

FIELDS = re.compile(r"^( *)Fields:$", re.MULTILINE)
# From a prompt to the next empty line: what is typed, and what it prints. What is indented by four
# is a block of code already.
EXAMPLE = re.compile(r"^( {0,3})>>> .*(?:\n *\S.*)*", re.MULTILINE)


def markdown(docstring: str) -> str:
    """A docstring in the Google style, with its examples as blocks of code."""
    attributes = FIELDS.sub(r"\1Attributes:", docstring)
    return EXAMPLE.sub(r"\1```pycon\n\g<0>\n\1```", attributes)


class HouseDocstrings(griffe.Extension):
    """Reads `Fields:` as the Google style's own section, and examples as code."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of one object."""
        if obj.docstring is not None:
            obj.docstring.value = markdown(obj.docstring.value)
