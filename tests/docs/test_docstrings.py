"""Examples in docstrings run, and print what they say."""

import doctest
import importlib
from pathlib import Path

import pytest

import motorcade.ga

REPOSITORY = Path(__file__).resolve().parents[2]
# The source tree, or the installed package where a wheel is tested.
HOME = REPOSITORY if (REPOSITORY / "ga").is_dir() else Path(motorcade.ga.__file__).parents[1]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
MODULES = sorted(
    path
    for room in ROOMS
    for path in (HOME / room).rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


def module_name(path: Path) -> str:
    parts = path.relative_to(HOME).with_suffix("").parts
    return ".".join(("motorcade", *parts)).removesuffix(".__init__")


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(HOME)))
def test_examples_print_what_they_say(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(module_name(path))
    failed, ran = doctest.testmod(module, optionflags=OPTIONS)
    assert ran, "an example was found by its prompt, and none ran"
    assert not failed, "the output above shows what came instead"
