"""Examples in docstrings run, and print what they say."""

import doctest
import importlib
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
MODULES = sorted(
    path
    for room in ROOMS
    for path in (REPOSITORY / room).rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)

if not any((REPOSITORY / room).exists() for room in ROOMS):
    pytest.skip("the source tree is not here: a wheel is tested", allow_module_level=True)


def module_name(path: Path) -> str:
    parts = path.relative_to(REPOSITORY).with_suffix("").parts
    return ".".join(("motorcade", *parts)).removesuffix(".__init__")


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_examples_print_what_they_say(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(module_name(path))
    failed, ran = doctest.testmod(module, optionflags=OPTIONS)
    assert ran, "an example was found by its prompt, and none ran"
    assert not failed, "the output above shows what came instead"
