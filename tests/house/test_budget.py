"""The budget of the house: no package has more lines than the table in CONTRIBUTING.md gives it."""

from pathlib import Path

import pytest

from tests.house.size import ROOMS, counts
from tests.house.sources import SOURCES

pytestmark = SOURCES
CONTRIBUTING = Path(__file__).resolve().parents[2] / "CONTRIBUTING.md"
SLACK = 200
"""One line in so many may be added: what a repair takes without a commit of its own."""

if not CONTRIBUTING.exists():
    pytest.skip("no table here: an installed wheel is tested", allow_module_level=True)


def budget() -> dict[str, int]:
    """Lines by package, as CONTRIBUTING.md states them."""
    table = CONTRIBUTING.read_text(encoding="utf-8").partition("| package | lines |")[2]
    rows = [line.strip("|").split("|") for line in table.partition("\n\n")[0].splitlines()[2:]]
    return {name.strip(" `"): int(lines.replace(",", "")) for name, lines in rows}


def over(lines: dict[str, int], most: dict[str, int]) -> list[str]:
    """Which packages have more lines than they may, and how many more."""
    return [
        f"{name}: {lines[name]} lines, {lines[name] - most[name]} more than its budget; delete as "
        "many, or raise the number in a commit that says what was bought and what was deleted"
        for name in most
        if lines[name] > most[name] + most[name] // SLACK
    ]


def test_every_package_keeps_its_budget() -> None:
    most = budget()
    assert set(most) == set(ROOMS)
    faults = over(counts(None), most)
    assert not faults, "\n".join(faults)


def test_a_package_that_grew_is_named() -> None:
    assert over({"ga": 1006, "render": 1005}, {"ga": 1000, "render": 1000}) == [
        "ga: 1006 lines, 6 more than its budget; delete as many, or raise the number in a commit "
        "that says what was bought and what was deleted"
    ]
