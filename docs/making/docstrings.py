"""An extension of griffe: what our docstrings call "Fields:" is what it calls "Attributes:"."""

from __future__ import annotations

import re
from typing import Any

import griffe

FIELDS = re.compile(r"^( *)Fields:$", re.MULTILINE)


class FieldsAsAttributes(griffe.Extension):
    """Reads `Fields:`, the name that values of ours are told by, as the Google style's own."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rename the section in the docstring of one object."""
        if obj.docstring is not None:
            obj.docstring.value = FIELDS.sub(r"\1Attributes:", obj.docstring.value)
