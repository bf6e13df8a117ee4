"""The ways through the code that the design page lists are those that the code takes."""

from pathlib import Path

import pytest

from tests.house.files_run import TASKS, files_of

PAGE = Path(__file__).resolve().parents[2] / "docs" / "explanation" / "design.md"

if not PAGE.exists():
    pytest.skip("no page here: an installed wheel is tested", allow_module_level=True)


def ways() -> dict[str, list[str]]:
    """Files of each way, as the page lists them."""
    table = PAGE.read_text(encoding="utf-8").partition("| way | from, to | files |")[2]
    rows = [line.strip("|").split("|") for line in table.partition("\n\n")[0].splitlines()[2:]]
    return {
        name.strip(" `"): [file.strip(" `") for file in files.split(",")] for name, _, files in rows
    }


@pytest.mark.parametrize("name", ways())
def test_a_way_leads_through_the_files_that_are_listed_in_their_order(name: str) -> None:
    from motorcade.render import RenderUnavailable

    try:
        entered = files_of(TASKS[name]())
    except RenderUnavailable as missing:
        pytest.skip(str(missing))
    assert [file for file in entered if file in ways()[name]] == ways()[name]
