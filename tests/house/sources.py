"""Source that several tests of the house look through, parsed once in a process.

Those tests share a group (`SOURCES`), so that one worker does all of it.
"""

import ast
from functools import cache
from pathlib import Path

import pytest

SOURCES = pytest.mark.xdist_group("sources")


@cache
def parsed(text: str) -> ast.Module:
    """The tree of a module's source."""
    return ast.parse(text)


def tree_of(path: Path) -> ast.Module:
    """The tree of a file."""
    return parsed(path.read_text(encoding="utf-8"))
