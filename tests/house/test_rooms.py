"""The house itself: imports point one way, files stay small, every file says what it is for."""

import ast
from pathlib import Path

import pytest

from tests.house.sources import SOURCES, tree_of

pytestmark = SOURCES
REPOSITORY = Path(__file__).resolve().parents[2]
MAY_IMPORT = {
    "ga": set(),
    "tracking": {"ga"},
    "fusion": {"ga", "tracking"},
    "animation": {"ga"},
    "render": {"ga", "animation", "tracking"},
    "replays": {"ga", "tracking", "fusion", "animation", "render"},
}
FILES = sorted(path for room in MAY_IMPORT for path in (REPOSITORY / room).rglob("*.py"))
MOST_LINES = 600
WRITTEN = sorted(
    path
    for room in (*MAY_IMPORT, "tests")
    for kind in ("py", "c", "cpp", "h")
    for path in (REPOSITORY / room).rglob(f"*.{kind}")
    if "generated" not in path.parts
)

if not FILES:
    pytest.skip(
        "the source tree is not here: an installed wheel is tested", allow_module_level=True
    )


def imported_rooms(tree: ast.Module) -> set[str]:
    names: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names.append(node.module or "")
    return {name.split(".")[1] for name in names if name.startswith("motorcade.")}


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_imports_point_one_way(room: str) -> None:
    for path in (REPOSITORY / room).rglob("*.py"):
        foreign = imported_rooms(tree_of(path)) - {room}
        assert foreign <= MAY_IMPORT[room], f"{path}: {room} must not import {foreign}"


def test_files_say_what_they_are_for() -> None:
    silent = [str(path) for path in FILES if not ast.get_docstring(tree_of(path))]
    assert not silent, f"a file opens with what it is for: {silent}"


def test_files_are_small() -> None:
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in WRITTEN}
    large = [f"{path}: {count} lines" for path, count in lines.items() if count > MOST_LINES]
    assert not large, f"expected at most {MOST_LINES} lines a file: {large}"


def test_no_caller_is_answered_with_an_assertion_or_silence() -> None:
    for path in FILES:
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.ExceptHandler):
                place = f"{path}:{node.lineno}"
                assert node.type is not None, f"{place}: names no exception"
                assert not all(isinstance(step, ast.Pass) for step in node.body), (
                    f"{place}: swallows an error"
                )
