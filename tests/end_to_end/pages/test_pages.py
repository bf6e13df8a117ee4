"""Every page that a command leaves, in a real browser: wide and on a phone, light and dark, sorted
by mouse and by keys, and without any network.
"""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from motorcade.replays.cli import main
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.pipeline.report.page import report
from motorcade.replays.pipeline.runs import read_run
from tests.end_to_end.pages.accessibility.faults import AXE, UNFOLD, serious_faults

# One worker opens them all: they take long to make.
pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("pages")]

SWEEP = """
recordings = ["{recording}"]
[knobs]
tracked.by = "simulated"
smoothed.window_s = [0.2, 0.4]
"""
NAMES = ("report", "comparison", "motion", "consistency", "sweep")
PHONE = 360
INSIDE_READY = """new Promise((done) => {
  const look = () => {
    const frame = document.querySelector(".viewer iframe");
    if (!frame?.contentDocument?.documentElement?.dataset.ready) return setTimeout(look, 20);
    window.inside = frame.contentWindow.viewer;
    done(Object.keys(inside.runs[0].films));
  };
  look();
})"""
SOUGHT = """new Promise((done) => {
  inside.timeline.go(FRAME);
  const look = () => inside.films[0].shown === FRAME ? done(FRAME) : setTimeout(look, 5);
  look();
})"""
# What the focus is on; of what scrolls, whether a reader of the screen is told what it is.
FOCUSED = """(() => {
  const one = document.activeElement, style = getComputedStyle(one);
  const scrolls = one.tabIndex === 0 && style.overflowX === "auto";
  const named = one.getAttribute("role") === "region" && one.ariaLabel?.trim();
  return one.tagName === "DIV" && scrolls && named ? "region with a name" : one.tagName;
})()"""


@pytest.fixture(scope="module")
def pages(board_recording: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Pages by name, each left by its command."""
    out = tmp_path_factory.mktemp("pages")
    plan = out / "sweep.toml"
    plan.write_text(SWEEP.format(recording=board_recording))
    for arguments in (
        ["run", str(board_recording), "--out", str(out / "run")],
        ["sweep", str(plan), "--out", str(out / "sweep"), "--executor", "local"],
        [
            "consistency",
            "--motions",
            "gimbal_crossing",
            "--filters",
            "motor,euler",
            "--runs",
            "2",
            "--duration-s",
            "10",
            "--executor",
            "local",
            "--out",
            str(out / "consistency"),
        ],
        [
            "compare",
            "--quick",
            "--trajectories",
            "gimbal_crossing",
            "--noise",
            "gaussian",
            "--methods",
            "exponential",
            "gaussian",
            "--representations",
            "motor",
            "quaternion",
            "euler",
            "--seeds",
            "2",
            "--executor",
            "local",
            "--out",
            str(out / "compare"),
        ],
    ):
        assert main(arguments) == 0
    return {
        "report": out / "run" / "report.html",
        "comparison": out / "compare" / "report.html",
        "motion": out / "compare" / "motions" / "gimbal_crossing.html",
        "consistency": out / "consistency" / "consistency.html",
        "sweep": out / "sweep" / "sweep.html",
    }


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [PHONE, 1200])
@pytest.mark.parametrize("name", NAMES)
def test_pages_open_without_complaint_and_fit(
    name: str, width: int, scheme: str, pages: dict[str, Path], opened: Callable[..., Any]
) -> None:
    """No error or warning, nothing fetched, nothing wider than the page but what scrolls itself."""
    page = opened(pages[name], width, scheme)
    page.evaluate(UNFOLD)
    assert page.complaints() == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    wide = page.evaluate(
        "[...document.querySelectorAll('body *')].filter(one => !one.closest('.scroll') &&"
        " one.getBoundingClientRect().right > document.documentElement.clientWidth + 1)"
        ".map(one => one.outerHTML.slice(0, 80))"
    )
    assert wide == []
    ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert ground == {"light": "rgb(255, 255, 255)", "dark": "rgb(20, 24, 30)"}[scheme]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", NAMES)
def test_axe_finds_no_serious_fault(
    name: str, scheme: str, pages: dict[str, Path], opened: Callable[..., Any]
) -> None:
    page = opened(pages[name], PHONE, scheme)
    assert serious_faults(page.evaluate) == []


def test_axe_sees_what_is_wrong(tmp_path: Path, opened: Callable[..., Any]) -> None:
    if not AXE.is_file():
        pytest.skip("no axe-core here: make lint brings it")
    wrong = tmp_path / "wrong.html"
    wrong.write_text(
        "<!doctype html><html><title>wrong</title><button></button>"
        "<p style='color:#aaa;background:#fff'>pale</p>"
    )
    page = opened(wrong)
    page.evaluate(AXE.read_text(encoding="utf-8") + "; 0")
    found = page.evaluate("axe.run().then(all => all.violations.map(one => one.id))")
    assert {"button-name", "color-contrast", "html-has-lang"} <= set(found)


@pytest.mark.parametrize("width", [PHONE, 1400])
def test_the_viewer_opens_inside_the_report(
    width: int, pages: dict[str, Path], opened: Callable[..., Any], opengl: None
) -> None:
    """From a local file, once it is asked for; every frame that is sought is the one on show."""
    page = opened(pages["report"], width)
    assert page.evaluate("document.querySelector('iframe')") is None
    page.evaluate("document.getElementById('open-viewer').click()")
    assert page.evaluate(INSIDE_READY) == ["footage", "overlay"]
    for film in ("footage", "overlay"):
        page.evaluate(f"inside.view = {int(film == 'footage')}, inside.arrange()")
        for frame in (17, 3, 23, 0):
            assert page.evaluate(SOUGHT.replace("FRAME", str(frame))) == frame
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.complaints() == []


def test_a_report_is_the_same_for_the_same_run(pages: dict[str, Path]) -> None:
    """Page and figures, byte for byte, made twice of what the stages gave."""
    recording, run = read_run(pages["report"].parent, "report")
    given = {one.name: run.outputs.get(one.name) for one in fields(Findings)}
    made = report(**given | {"recording": recording})
    assert made.page.read_bytes() == pages["report"].read_bytes()
    assert made.summary.read_bytes() == pages["report"].with_suffix(".json").read_bytes()
    assert (made.footage, made.viewer) == (None, None), "24 small frames are inside"


@pytest.mark.parametrize("name", NAMES)
def test_letters_in_plots_can_be_read_on_a_phone(
    name: str, pages: dict[str, Path], opened: Callable[..., Any]
) -> None:
    page = opened(pages[name], PHONE)
    page.evaluate(UNFOLD)
    sizes = page.evaluate(
        "[...document.querySelectorAll('figure svg')].filter(svg => svg.querySelector('text') && "
        "!svg.closest('.scroll')).flatMap(svg => { const scale = svg.getBoundingClientRect().width "
        "/ svg.viewBox.baseVal.width; return [...svg.querySelectorAll('text')].map(text => scale * "
        "parseFloat(getComputedStyle(text).fontSize)); })"
    )
    assert sizes
    assert min(sizes) >= 8.0


@pytest.mark.parametrize("name", NAMES)
def test_headings_sort_by_mouse_and_by_key(
    name: str, pages: dict[str, Path], opened: Callable[..., Any]
) -> None:
    page = opened(pages[name])
    page.evaluate(UNFOLD)
    page.evaluate(
        "window.table = [...document.querySelectorAll('table.sortable')]"
        ".find(one => one.querySelectorAll('td data').length > 1)"
    )
    column = page.evaluate(
        "window.column = [...table.tBodies[0].rows[0].cells].findLastIndex("
        "one => one.querySelector('data'))"
    )
    assert column > 0
    told = (
        "[...table.tBodies[0].rows].map(row => row.cells[column].querySelector('data'))"
        ".map(one => one ? Number(one.value) : null)"
    )
    given = page.evaluate(told)
    known = sorted(one for one in given if one is not None)
    unknown = [None] * (len(given) - len(known))
    page.evaluate("table.tHead.rows[0].cells[column].querySelector('button').click()")
    assert page.evaluate(told) == known + unknown
    page.evaluate("table.tHead.rows[0].cells[column].querySelector('button').focus()")
    page.press("Enter")
    assert page.evaluate(told) == known[::-1] + unknown
    sorted_by = page.evaluate("table.tHead.rows[0].cells[column].ariaSort")
    assert sorted_by == "descending"
    page.press("Tab")
    assert page.evaluate(FOCUSED) in ("BUTTON", "A", "SELECT", "SUMMARY", "region with a name")
    page.evaluate("table.tHead.rows[0].cells[0].querySelector('button').click()")
    first = page.evaluate(
        "[...table.tBodies[0].rows].map(row => row.cells[0].querySelector('data') ? null : "
        "row.cells[0].textContent.trim())"
    )
    if None not in first:
        assert first == page.evaluate(f"{first!r}.sort((a, b) => a.localeCompare(b))")
    assert page.complaints() == []


def test_the_video_plays(pages: dict[str, Path], opened: Callable[..., Any], opengl: None) -> None:
    """24 frames at 20 Hz, decoded from inside the page."""
    page = opened(pages["report"])
    page.evaluate(UNFOLD)
    film = page.evaluate(
        "(async () => { const film = document.querySelector('video');"
        " if (film.readyState < 2) await new Promise((done, failed) => {"
        " film.addEventListener('loadeddata', done); film.addEventListener('error', failed); });"
        " film.pause(); film.currentTime = 0; const before = film.currentTime; await film.play();"
        " await new Promise(done => setTimeout(done, 600));"
        " return [film.duration, before, film.currentTime, film.videoWidth, film.videoHeight]; })()"
    )
    assert film[0] == pytest.approx(1.2, abs=0.06)
    assert film[1] == 0.0
    assert film[2] > 0.1
    assert film[3:] == [320, 240]
    size = page.evaluate(
        "[document.querySelector('video'), document.querySelector('img.sheet')]"
        ".map(one => one.getBoundingClientRect()).map(one => one.width / one.height)"
    )
    assert size[0] == pytest.approx(320 / 240, rel=0.01)
    assert page.evaluate("document.querySelector('img.sheet').naturalWidth") > 900


def test_before_and_after_are_compared_by_a_slider(
    pages: dict[str, Path], opened: Callable[..., Any], opengl: None
) -> None:
    page = opened(pages["report"], PHONE)
    sizes = page.evaluate(
        "[...document.querySelectorAll('.wipe img')].map(one => [one.naturalWidth, one.width])"
    )
    assert [one[0] for one in sizes] == [320, 320]
    page.evaluate("document.querySelector('.wipe input').focus()")
    page.press("End")
    cut = page.evaluate("getComputedStyle(document.querySelector('.wipe .after')).clipPath")
    assert cut == "inset(0px 0px 0px 100%)"


def test_the_lock_can_be_played_and_stopped(
    pages: dict[str, Path], opened: Callable[..., Any]
) -> None:
    page = opened(pages["comparison"])
    assert page.evaluate("document.getElementById('crossing-play').textContent") == "Pause"
    page.evaluate("document.getElementById('crossing-play').click()")
    before = page.evaluate("document.getElementById('crossing-camera-euler').getAttribute('d')")
    page.evaluate(
        "(() => { const slider = document.getElementById('crossing-time'); slider.value = 3;"
        " slider.dispatchEvent(new Event('input')); })()"
    )
    after = page.evaluate("document.getElementById('crossing-camera-euler').getAttribute('d')")
    assert before != after
    assert page.complaints() == []


def test_the_browser_sees_what_is_wrong(tmp_path: Path, opened: Callable[..., Any]) -> None:
    """The same questions, asked of a page that fetches, complains, throws and is too wide."""
    wrong = tmp_path / "wrong.html"
    wrong.write_text(
        "<!doctype html><title>wrong</title><meta name=viewport content='width=device-width'>"
        "<img src='http://127.0.0.1:9/away.png'><div style='width:900px'>wide</div>"
        "<script>console.error('told'); setTimeout(() => { throw new Error('thrown'); });</script>"
    )
    page = opened(wrong, PHONE)
    told = " ".join(page.complaints())
    assert "away.png" in told
    assert "told" in told
    assert "thrown" in told
    assert page.evaluate("document.documentElement.scrollWidth") > PHONE
