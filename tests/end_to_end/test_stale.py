"""Every kind of file that a run opens: one byte changes, and what was made of it is made again."""

from pathlib import Path

import pytest

from tests.end_to_end.stale.__main__ import cases, row
from tests.end_to_end.stale.kinds import Kind

CASES = [
    pytest.param(kind, way, id=f"{kind.name}, {way}", marks=[pytest.mark.slow] * (way == "sweep"))
    for kind, way in cases()
]


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.mark.parametrize(("kind", "way"), CASES)
def test_what_read_a_changed_file_is_made_again_and_nothing_else(
    kind: Kind, way: str, tmp_path: Path, cache: Path
) -> None:
    made = row(kind, way, tmp_path, cache)
    assert made.faults == (), made
