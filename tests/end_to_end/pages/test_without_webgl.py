"""Where a browser draws nothing in 3-D: the film is there, and what is missing is said."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.end_to_end.pages.conftest import Browser, Page
from tests.end_to_end.pages.test_view import CAMERAS, READY, SEEKS, made
from tests.replays.studio.server.conftest import running
from tests.replays.studio.server.stage import desk

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("pages")]
SAID = "offers no WebGL 2"


@pytest.fixture
def flat(tmp_path: Path) -> Iterator[Browser]:
    """Chromium that gives no WebGL."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("no Chromium here: apt-get install chromium")
    (tmp_path / "browser").mkdir()
    made = Browser(program, tmp_path / "browser", "--disable-3d-apis")
    yield made
    made.close()


def test_the_viewer_shows_the_film(flat: Browser, tmp_path: Path) -> None:
    look = made(CAMERAS["radtan"], 12).write(tmp_path / "view.html", film=True)
    page = Page(flat, look, 900, "light")
    assert page.evaluate(READY)
    assert SAID in page.evaluate("document.querySelector('#problem').innerText")
    shown = "[...document.querySelectorAll('#views button')].filter((one) => one.offsetParent)"
    assert page.evaluate(f"{shown}.map((one) => one.textContent)") == ["Film"]
    assert page.evaluate(SEEKS.replace("FRAMES", "[3, 11, 0, 7]")) == []
    assert page.complaints() == []


def test_the_editor_says_why_it_does_not_open(flat: Browser, tmp_path: Path) -> None:
    with running(desk(tmp_path)) as (access, _, _):
        page = Page(flat, access.link(), 900, "light")
        told = """new Promise((done) => {
          const look = () => (document.querySelector(".loading")?.textContent.includes("WebGL")
            ? done(document.body.innerText) : setTimeout(look, 20));
          look();
        })"""
        assert SAID in page.evaluate(told)
