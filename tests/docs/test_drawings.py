"""The drawings on the design page are those of the code as it is."""

import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"

if not (DOCS.parent / "ga").exists():
    pytest.skip("the rooms are not here: an installed wheel is tested", allow_module_level=True)


def test_the_graphs_of_rooms_and_stages_are_current(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS / "making")
    import drawings

    try:
        for name, text in drawings.drawings().items():
            kept = (DOCS / "pictures" / name).read_text(encoding="utf-8")
            assert kept == text, f"{name}: run `python docs/making/drawings.py`"
    finally:
        del sys.modules["drawings"]


def test_a_detour_takes_the_direct_arrow_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS / "making")
    import drawings

    kept = drawings.without_detours({"a": set(), "b": {"a"}, "c": {"a", "b"}, "d": {"a"}})
    assert kept == {"a": set(), "b": {"a"}, "c": {"b"}, "d": {"a"}}
    del sys.modules["drawings"]
