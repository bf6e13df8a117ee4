"""axe finds no serious fault in the site, the viewer and the editor, light or dark, wide or not."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from motorcade.replays.pipeline.runs import write_view
from tests.end_to_end.pages.accessibility.faults import serious_faults
from tests.end_to_end.pages.conftest import Browser
from tests.end_to_end.pages.editor_tab import Tab
from tests.end_to_end.pages.test_view import READY
from tests.replays.studio.server.conftest import running
from tests.replays.studio.server.stage import desk

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("pages")]
REPOSITORY = Path(__file__).resolve().parents[4]
SHOWN = ("index", "benchmarks", "tutorials/phone_video", "reference/ga", "reference/commands")
# The theme makes what scrolls reachable by keyboard only once a page is there, and a busy machine
# is late with it: a fault counts when it stays.
STAYS_S = 20.0


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("mkdocs", reason="the site's tools are missing: pip install .[docs]")
    folder = tmp_path_factory.mktemp("site")
    subprocess.run(["make", "names"], cwd=REPOSITORY, check=True, capture_output=True)
    subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(folder)],
        cwd=REPOSITORY,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        check=True,
    )
    return folder


@pytest.mark.parametrize("width", [360, 1400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_of_the_site(scheme: str, width: int, site: Path, opened: Callable[..., Any]) -> None:
    for name in SHOWN:
        page = opened(site / f"{name}.html", width, scheme)
        page.evaluate("localStorage.clear()")  # which scheme the page before had
        page.ask("Page.reload")
        assert _faults_that_stay(page, scheme, width) == [], name


def _faults_that_stay(page: Any, scheme: str, width: int) -> list[Any]:
    """What is wrong in a page of the site once its scripts have run."""
    until = time.monotonic() + STAYS_S
    while True:
        time.sleep(1.0)
        found = serious_faults(page.evaluate)
        if (page.evaluate("document.body.dataset.mdColorScheme") == "slate") != (scheme == "dark"):
            found.append("not the scheme that was asked for")
        if page.evaluate("document.documentElement.scrollWidth") > width:
            found.append("wider than the screen")
        if not found or time.monotonic() > until:
            return found


@pytest.fixture
def viewed(board_recording: Path, tmp_path: Path) -> Path:
    """The viewer's page of a run."""
    from motorcade.replays.cli import main

    assert main(["run", str(board_recording), "--out", str(tmp_path / "run")]) == 0
    write_view([tmp_path / "run"], tmp_path / "view.html")
    return tmp_path / "view.html"


def test_the_viewer(viewed: Path, opened: Callable[..., Any], opengl: None) -> None:
    for width in (360, 1400):
        for scheme in ("light", "dark"):
            page = opened(viewed, width, scheme)
            page.evaluate(READY)
            assert serious_faults(page.evaluate) == [], (width, scheme)


@pytest.fixture
def editor(browser: Browser, tmp_path: Path) -> Iterator[Callable[..., Tab]]:
    """Open the editor in a tab."""
    tabs: list[Tab] = []
    with running(desk(tmp_path)) as (access, _, _):

        def opened(width: int, height: int, scheme: str) -> Tab:
            tabs.append(Tab(browser, access.link(), width, height, scheme))
            return tabs[-1]

        yield opened
        for one in tabs:
            one.close()
        browser.events.clear()


@pytest.mark.parametrize(
    ("width", "height", "scheme"), [(1400, 900, "light"), (1400, 900, "dark"), (360, 780, "dark")]
)
def test_the_editor(editor: Callable[..., Tab], width: int, height: int, scheme: str) -> None:
    one = editor(width, height, scheme)
    one.somebody()
    assert serious_faults(one.evaluate) == []
