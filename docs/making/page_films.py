"""Films of the editor and the viewer in use, of the real pages in Chromium, driven by script.

    make demo
    python -m docs.making.page_films out/demo

writes `docs/images/editor.webp`, a phone on which somebody is put in, walks a drawn way and
waves, and `docs/images/viewer.webp`: two paths beside each other, and the world from the side.
"""

from __future__ import annotations

import argparse
import base64
import io
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
from PIL import Image

from motorcade.ga.arrays import FloatArray
from motorcade.replays.pipeline.runs import write_view
from motorcade.replays.studio.desk import open_desk
from tests.bench.view.pages import READY, chromium
from tests.end_to_end.pages.conftest import Browser, Page
from tests.end_to_end.pages.editor_tab import Tab
from tests.replays.studio.server.conftest import running

IMAGES = Path(__file__).resolve().parents[1] / "images"
STEP_MS, PAUSE_MS = 90, 900
# Where a finger is, shown on the page for the film alone.
FINGER = """(() => {
  const one = window.finger ??= document.body.appendChild(document.createElement("div"));
  Object.assign(one.style, { position: "fixed", left: "Xpx", top: "Ypx", width: "34px",
    height: "34px", margin: "-17px 0 0 -17px", borderRadius: "50%", pointerEvents: "none",
    background: "rgb(255 193 69 / 55%)", border: "2px solid #fff", zIndex: 99,
    display: Xpx < 0 ? "none" : "block" });
})()"""


class Filmable(Protocol):
    """What takes commands of the browser."""

    def ask(self, method: str, **parameters: object) -> dict[str, str]:
        """A command, and its answer."""

    def evaluate(self, expression: str) -> object:
        """The value of a JavaScript expression."""


@dataclass
class PageFilm:
    """Images of a page, and how long each stays."""

    page: Filmable
    width: int
    images: list[Image.Image] = field(default_factory=list)
    lasts_ms: list[int] = field(default_factory=list)

    def take(self, lasts_ms: int = STEP_MS) -> None:
        """An image of the page as it is once it was drawn."""
        self.page.evaluate("new Promise((seen) => requestAnimationFrame(() => setTimeout(seen)))")
        told = self.page.ask("Page.captureScreenshot", format="png")["data"]
        image = Image.open(io.BytesIO(base64.b64decode(told))).convert("RGB")
        height = round(image.height * self.width / image.width)
        self.images.append(image.resize((self.width, height), Image.Resampling.LANCZOS))
        self.lasts_ms.append(lasts_ms)

    def finger(self, place: FloatArray | None) -> None:
        """Show where the finger is, or that there is none."""
        x, y = (-9, -9) if place is None else place
        self.page.evaluate(
            FINGER.replace("Xpx < 0", f"{x:.0f} < 0")
            .replace("X", f"{x:.0f}", 1)
            .replace("Y", f"{y:.0f}", 1)
        )

    def write(self, path: Path, quality: int) -> None:
        """As an animated WebP that goes round."""
        self.images[0].save(
            path,
            save_all=True,
            append_images=self.images[1:],
            duration=self.lasts_ms,
            loop=0,
            quality=quality,
            method=6,
        )
        print(f"{path.name}: {len(self.images)} images, {path.stat().st_size / 1e3:.0f} kB")


def film_editor(browser: Browser, run: Path) -> None:
    """Somebody is put in, carried, sent along a way, and waves on it."""
    with tempfile.TemporaryDirectory() as folder:
        at = open_desk(run, Path(folder, "scene.json"))
        with running(at) as (access, _, _):
            tab = Tab(browser, access.link(), 390, 700, "dark")
            film = PageFilm(tab, 312)
            film.take(PAUSE_MS)
            for word in ("Add", "Person"):
                tapped(tab, film, word)
            tab.until("!!editor.actors.get('Person')?.figure && editor.chosen === 'Person'")
            tab.settled()
            film.take(PAUSE_MS)
            start = tab.place(0.4)
            stroke(tab, film, start + np.linspace(0.0, 1.0, 8)[:, None] * [-30.0, 16.0])
            tapped(tab, film, "Walk")
            share = np.linspace(0.0, 1.0, 16)[:, None]
            way = tab.place() + share * [-120.0, 0.0] + 12.0 * np.sin(4.0 * share) * [0.0, 1.0]
            stroke(tab, film, way)
            tab.until("editor.one?.walk === true")
            tab.evaluate("editor.timeline.pause()")
            play(tab, film, at.frames // 2)
            tapped(tab, film, "Do")
            tapped(tab, film, "Add a layer")
            tab.until("editor.one.layers.length === 1")
            tapped(tab, film, "Close")
            play(tab, film, at.frames)
            film.lasts_ms[-1] = PAUSE_MS
            tab.close()
    film.write(IMAGES / "editor.webp", 45)


def tapped(tab: Tab, film: PageFilm, word: str) -> None:
    """A button, touched."""
    film.finger(np.array(tab.evaluate(_MIDDLE.replace("WORD", word))))
    film.take(5 * STEP_MS)
    tab.press(word)
    film.finger(None)
    tab.settled()
    film.take(5 * STEP_MS)


_MIDDLE = """(() => {
  const all = [...document.querySelectorAll("button")].filter((one) => one.offsetParent);
  const box = all.find((one) => one.textContent.trim() === "WORD").getBoundingClientRect();
  return [box.x + box.width / 2, box.y + box.height / 2];
})()"""


def stroke(tab: Tab, film: PageFilm, places: FloatArray) -> None:
    """One finger along places of the page."""
    for k, place in enumerate(places):
        x, y = place.round().tolist()
        points = [{"x": x, "y": y, "id": 0}]
        kind = "touchMove" if k else "touchStart"
        tab.ask("Input.dispatchTouchEvent", type=kind, touchPoints=points)
        tab.settled()
        film.finger(place)
        film.take()
    tab.ask("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    film.finger(None)
    tab.settled()
    film.take(3 * STEP_MS)


def play(tab: Tab, film: PageFilm, until: int) -> None:
    """The footage from where it is, every sixth frame."""
    for frame in range(tab.evaluate("editor.frame"), until, 6):
        tab.evaluate(f"editor.seek({frame})")
        tab.until(f"editor.drawnFrame === {frame}")
        film.take(200)


def film_viewer(browser: Browser, run: Path) -> None:
    """Plots and world go on with the film; two paths beside each other; the world is turned."""
    with tempfile.TemporaryDirectory() as folder:
        write_view([run], Path(folder, "view.html"))
        page = Page(browser, Path(folder, "view.html"), 1200, "light")
        page.evaluate(READY)
        film = PageFilm(page, 640)
        last = page.evaluate("viewer.timeline.last")
        for frame in range(0, last // 3, 8):
            shown(page, film, frame, 200)
        pressed(page, film, "Camera")
        pressed(page, film, "Side by side")
        for frame in range(last // 3, 2 * last // 3, 4):
            shown(page, film, frame, 160)
        pressed(page, film, "Side by side")
        pressed(page, film, "World")
        left, top, wide, high = page.evaluate(_BOX.replace("WHAT", "'.pane.world'"))
        middle = np.array([left + 0.4 * wide, top + 0.5 * high])
        for k in range(14):
            x, y = middle + k * np.array([12.0, 4.0])
            about = {"x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1}
            page.ask(
                "Input.dispatchMouseEvent", type="mouseMoved" if k else "mousePressed", **about
            )
            film.finger(np.array([x, y]))
            film.take()
        film.finger(None)
        page.ask("Input.dispatchMouseEvent", type="mouseReleased", **about)
        film.lasts_ms[-1] = PAUSE_MS
        page.close()
    film.write(IMAGES / "viewer.webp", 40)


_BOX = """(({ left, top, width, height }) => [left, top, width, height])(
  document.querySelector(WHAT).getBoundingClientRect())"""


def pressed(page: Page, film: PageFilm, word: str) -> None:
    """A button of the viewer, clicked."""
    x, y = page.evaluate(_MIDDLE.replace("WORD", word))
    film.finger(np.array([x, y]))
    film.take(5 * STEP_MS)
    page.click(x, y)
    film.finger(None)
    shown(page, film, page.evaluate("viewer.timeline.frame"), 3 * STEP_MS)


def shown(page: Page, film: PageFilm, frame: int, lasts_ms: int) -> None:
    """A frame of the viewer, once every pane shows it."""
    page.evaluate(
        f"new Promise((done) => {{ viewer.timeline.go({frame}); const look = () => "
        "viewer.stage.panes.every((one) => !one.film || one.film.shown === viewer.timeline.frame)"
        " ? done(0) : setTimeout(look, 5); look(); })"
    )
    film.take(lasts_ms)


def main() -> None:
    """Both films."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("run", type=Path, help="of the demo")
    run = parser.parse_args().run
    with chromium() as browser:
        film_editor(browser, run)
        film_viewer(browser, run)


if __name__ == "__main__":
    main()
