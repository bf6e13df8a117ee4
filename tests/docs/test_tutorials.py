"""What the pages show works as it stands there: every block runs, and answers what is shown."""

import importlib
import sys
from pathlib import Path

import pytest

from tests.docs.pages import agrees, blocks, line_agrees, run

DOCS = Path(__file__).resolve().parents[2] / "docs"
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
OTHERS = [DOCS / f"{name}.md" for name in ("fusion", "cluscript", "drawing", "rendering")]
OTHERS += sorted((DOCS / "explanation").glob("*.md"))
LONG = {
    "ar_on_my_video",
    "calibrate_camera_and_imu",
    "compare_representations",
    "filters_in_c",
    "imu_and_camera",
    "phone_video",
    "rendering",
}
DRAWS = {"ar_on_my_video", "phone_video", "rendering"}
COMPILES = {"generate_code"}

if not DOCS.exists():
    pytest.skip("no pages here: an installed wheel is tested", allow_module_level=True)


def cases() -> list[object]:
    pages = [page for page in TUTORIALS + OTHERS if any(block.runs for block in blocks(page))]
    marks = {True: [pytest.mark.slow], False: []}
    return [pytest.param(page, id=page.stem, marks=marks[page.stem in LONG]) for page in pages]


@pytest.mark.parametrize("page", cases())
def test_a_page_runs_and_answers_what_it_shows(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    if page.stem in DRAWS:
        request.getfixturevalue("opengl")
    if page.stem in COMPILES:
        pytest.importorskip("casadi", reason="CasADi, which only code generation needs, is missing")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    before = set(sys.modules)
    importlib.invalidate_caches()
    ran = 0
    try:
        for block, said in run(page):
            ran += 1
            if block.answer is not None:
                assert agrees(block.answer, said), f"{page.name}:{block.line} answers\n{said}"
    finally:
        for name in set(sys.modules) - before:  # files of the page, which the next one lacks
            if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
                del sys.modules[name]
    assert ran


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_tutorial_shows_what_comes_out(page: Path) -> None:
    assert any(block.runs and block.answer for block in blocks(page))


@pytest.mark.parametrize(
    ("shown", "said", "same"),
    [
        ("APE 0.12 m", "APE 0.1249 m", True),
        ("APE 0.12 m", "APE 0.14 m", False),
        ("8 frames", "9 frames", False),
        ("30 Hz", "30.000001 Hz", True),
        ("a … c", "a bb c", True),
        ("a … c", "a bb d", False),
        ("[1.0, 2.0]", "[1.0, 2.0]", True),
        ("[1.0, 2.0]", "(1.0, 2.0)", False),
        ("1.5e-3 m", "1.52e-3 m", True),
        ("1.5e-3 m", "1.8e-3 m", False),
    ],
)
def test_answers_are_compared_to_the_digits_shown(shown: str, said: str, same: bool) -> None:
    assert line_agrees(shown, said) is same
