"""The page of a room shows what the room lists, no more and no less."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
STUBS = sorted(REPOSITORY.glob("*/__init__.pyi"))

if not STUBS:
    pytest.skip("the source tree is not here: a wheel is tested", allow_module_level=True)


@pytest.mark.parametrize("stub", STUBS, ids=lambda path: path.parent.name)
def test_the_reference_shows_the_face(stub: Path) -> None:
    room = stub.parent.name
    page = (REPOSITORY / "docs" / "reference" / f"{room}.md").read_text(encoding="utf-8")
    block = re.search(rf"^::: motorcade\.{room}\n((?: .*\n)*)", page, re.MULTILINE)
    assert block, f"expected a block '::: motorcade.{room}'"
    shown = re.findall(r"^ +- (\w+)$", block[1], re.MULTILINE)
    listed = re.findall(r"^from \.\S+ import \w+ as (\w+)$", stub.read_text(), re.MULTILINE)
    assert sorted(shown) == sorted(listed)
