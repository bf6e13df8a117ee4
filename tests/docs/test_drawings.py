"""The drawings in the documentation are those of the code as it is."""

import re
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
            kept = (DOCS / "images" / name).read_text(encoding="utf-8")
            assert kept == text, f"{name}: run `python docs/making/drawings.py`"
    finally:
        del sys.modules["drawings"]


def test_a_detour_takes_the_direct_arrow_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS / "making")
    import drawings

    kept = drawings.without_detours({"a": set(), "b": {"a"}, "c": {"a", "b"}, "d": {"a"}})
    assert kept == {"a": set(), "b": {"a"}, "c": {"b"}, "d": {"a"}}
    del sys.modules["drawings"]


def test_the_images_of_objects_are_current(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS / "making")
    import drawn_objects

    try:
        made = drawn_objects.images()
        shown = sorted(path.name for path in (DOCS / "images").glob("drawn_*.svg"))
        assert sorted(made) == shown
        for name, text in made.items():
            kept = (DOCS / "images" / name).read_text(encoding="utf-8")
            assert _nearly(kept, text), f"{name}: run `python docs/making/drawn_objects.py`"
    finally:
        del sys.modules["drawn_objects"]


def _nearly(kept: str, made: str) -> bool:
    """Whether two images are one but for the last digit of some numbers."""
    number = r"-?\d+(?:\.\d+)?"
    own = r"\bm[0-9a-f]{8}\b"
    texts = [re.sub(number, "#", re.sub(own, "m", text)) for text in (kept, made)]
    values = [[float(x) for x in re.findall(number, re.sub(own, "m", t))] for t in (kept, made)]
    if texts[0] != texts[1]:
        return False
    return all(abs(a - b) <= 0.11 for a, b in zip(*values, strict=True))
