"""The house itself: imports point one way, files stay small, every file says what it is for."""

import ast
from pathlib import Path

import pytest

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
        foreign = imported_rooms(ast.parse(path.read_text())) - {room}
        assert foreign <= MAY_IMPORT[room], f"{path}: {room} must not import {foreign}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_files_are_small_and_say_what_they_are_for(path: Path) -> None:
    text = path.read_text()
    written_by_hand = "generated" not in path.parts
    assert not written_by_hand or len(text.splitlines()) <= 450
    assert ast.get_docstring(ast.parse(text)), "a file opens with what it is for"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_no_caller_is_answered_with_an_assertion_or_silence(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, f"line {node.lineno}: names no exception"
            assert not all(isinstance(step, ast.Pass) for step in node.body), (
                f"line {node.lineno}: swallows an error"
            )
