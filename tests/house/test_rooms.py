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
        foreign = imported_rooms(ast.parse(path.read_text())) - {room}
        assert foreign <= MAY_IMPORT[room], f"{path}: {room} must not import {foreign}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_files_say_what_they_are_for(path: Path) -> None:
    assert ast.get_docstring(ast.parse(path.read_text())), "a file opens with what it is for"


def test_files_are_small() -> None:
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in WRITTEN}
    large = [f"{path}: {count} lines" for path, count in lines.items() if count > MOST_LINES]
    assert not large, f"expected at most {MOST_LINES} lines a file: {large}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_no_caller_is_answered_with_an_assertion_or_silence(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, f"line {node.lineno}: names no exception"
            assert not all(isinstance(step, ast.Pass) for step in node.body), (
                f"line {node.lineno}: swallows an error"
            )
