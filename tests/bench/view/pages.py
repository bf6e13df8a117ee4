"""How quick the viewer's and the editor's pages are in Chromium, with WebGL by software.

    python -m tests.bench.view.pages out/demo             # a run that was made
    python -m tests.bench.view.pages out/demo --seeks 500

Of the viewer: from opening the page until it is drawn, random seeks until the asked frame is shown,
and frames a second while scrubbing. Of the editor: from a move of mouse or finger until the image
with its answer is drawn, and frames a second while scrubbing; a scene is kept in a folder of its
own, and the run stays as it is.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.replays.pipeline.runs import write_view
from motorcade.replays.studio.desk import open_desk
from tests.end_to_end.pages.conftest import Browser, Page
from tests.end_to_end.pages.editor_tab import Tab
from tests.replays.studio.server.conftest import running

__all__ = ["editor_figures", "viewer_figures"]

VIEWS = {"camera": 1, "both": 3}
OPENINGS, SCRUBBED_S, DRAGS, MOVES = 3, 4.0, 40, 10
READY = """new Promise((done) => {
  const look = () => (document.documentElement.dataset.ready ? done(performance.now())
    : setTimeout(look, 5));
  look();
})"""
SEEKS = """(async () => {
  const pane = viewer.stage.panes[0], waited = [];
  let wrong = 0;
  for (const frame of FRAMES) {
    const start = performance.now();
    viewer.timeline.go(frame);
    while (pane.film.shown !== frame && performance.now() - start < 5000) {
      await new Promise((next) => setTimeout(next, 1));
    }
    waited.push(performance.now() - start);
    wrong += pane.film.shown !== frame;
  }
  return [waited, wrong];
})()"""
SCRUB = """(async () => {
  const film = viewer.films[0], told = film.onshown, start = performance.now();
  let shown = 0, frame = 0;
  film.onshown = (k) => { shown += 1; told(k); };
  while (performance.now() - start < LASTS) {
    viewer.timeline.go((frame = (frame + 1) % viewer.timeline.last));
    await new Promise((next) => setTimeout(next, 16));
  }
  film.onshown = told;
  return shown / (performance.now() - start);
})()"""
# From each move that is sent until an image is drawn after its answer; some moves are passed over
# for newer ones.
WATCH = """{
  window.waited = [];
  const send = editor.link.send.bind(editor.link);
  editor.link.send = (message) => {
    const start = performance.now(), answered = send(message);
    if (message.do === "drag") answered.then((answer) => {
      if (answer.passed) return;
      const now = performance.now();
      const look = () => editor.drawn_at >= now ? waited.push(editor.drawn_at - start)
        : requestAnimationFrame(look);
      look();
    });
    return answered;
  };
}
0"""


# Frames that were drawn, footage and figure, while the bar is pulled along; the first time round
# brings the images here.
PULL = """(async () => {
  const start = performance.now(), last = editor.about.frames - 1;
  let drawn = 0, seen = -1;
  for (let frame = 0; performance.now() - start < LASTS; frame = (frame + 1) % last) {
    editor.seek(frame);
    await new Promise((next) => setTimeout(next, 16));
    drawn += editor.drawnFrame !== seen;
    seen = editor.drawnFrame;
  }
  return drawn / (performance.now() - start);
})()"""


@contextmanager
def chromium() -> Iterator[Browser]:
    """A browser for as long as the block lasts.

    Raises:
        OSError: there is none.
    """
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        raise OSError("no Chromium here: apt-get install chromium")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        browser = Browser(program, Path(folder))
        try:
            yield browser
        finally:
            browser.close()


def viewer_figures(run: Path, seeks: int) -> dict[str, Any]:
    """Of the viewer's page of a run: `page_mib`, `drawn_s` of each opening, and by view `seek_ms`
    (median and 95 %), `wrong` seeks and `scrub_hz`.

    Raises:
        ValueError: a folder that holds no run.
        OSError: there is no browser.
    """
    rng = np.random.default_rng(7)
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        path = Path(folder, "view.html")
        write_view([run], path)
        drawn_s = []
        for _ in range(OPENINGS):
            page = Page(browser, path, 1400, "light")
            drawn_s.append(1e-3 * page.evaluate(READY))
        figures: dict[str, Any] = {"page_mib": path.stat().st_size / 2**20, "drawn_s": drawn_s}
        for name, view in VIEWS.items():
            page.evaluate(f"viewer.view = {view}, viewer.arrange()")
            time.sleep(1.0)
            last = page.evaluate("viewer.timeline.last")
            waited: list[float] = []
            wrong = 0
            for some in np.array_split(rng.integers(0, last + 1, seeks), max(seeks // 50, 1)):
                found, missed = page.evaluate(SEEKS.replace("FRAMES", str(some.tolist())))
                waited, wrong = [*waited, *found], wrong + missed
            scrubbed = page.evaluate(SCRUB.replace("LASTS", str(1e3 * SCRUBBED_S)))
            seek_ms = np.percentile(waited, [50, 95]).tolist()
            figures[name] = {"seek_ms": seek_ms, "wrong": wrong, "scrub_hz": 1e3 * scrubbed}
    return figures


def editor_figures(run: Path, width: int, height: int) -> dict[str, Any]:
    """Of the editor on a page of so many pixels, one narrower than 900 a phone's and touched:
    `drag_ms` from a move to the drawn answer (median and 95 %), and `scrub_hz`.

    Raises:
        ValueError: a folder that holds no run.
        OSError: there is no browser.
    """
    rng = np.random.default_rng(5)
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        at = open_desk(run, Path(folder, "scene.json"))
        with running(at) as (access, _, _):
            one = Tab(browser, access.link(), width, height, "light")
            one.somebody()
            one.evaluate(WATCH)
            for _ in range(DRAGS):
                start = one.place(rng.uniform(0.2, 0.6))
                goal = start + rng.uniform(-40.0, 40.0, 2)
                way = np.linspace(start, goal, MOVES).round().astype(int).tolist()
                one.drag([(x, y) for x, y in way])
                one.settled()
            waited = one.evaluate("waited")
            pull = PULL.replace("LASTS", str(1e3 * SCRUBBED_S))
            scrubbed = [one.evaluate(pull) for _ in range(2)][-1]
    return {"drag_ms": np.percentile(waited, [50, 95]).tolist(), "scrub_hz": 1e3 * scrubbed}


def main() -> None:
    """A line a figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("run", type=Path)
    parser.add_argument("--seeks", type=int, default=100)
    given = parser.parse_args()
    found = viewer_figures(given.run, given.seeks)
    drawn = ", ".join(f"{one:.1f}" for one in found["drawn_s"])
    print(f"the viewer: {found['page_mib']:.1f} MiB, drawn after {drawn} s")
    for name in VIEWS:
        one = found[name]
        median, most = one["seek_ms"]
        print(
            f"  {name}: {given.seeks} seeks, {one['wrong']} wrong, {median:.0f} ms, 95 % "
            f"{most:.0f} ms; scrubbing {one['scrub_hz']:.1f} frames/s"
        )
    for name, size in {"mouse": (1400, 900), "touch": (390, 844)}.items():
        one = editor_figures(given.run, *size)
        median, most = one["drag_ms"]
        print(
            f"the editor by {name}: move to drawn {median:.0f} ms, 95 % {most:.0f} ms; scrubbing "
            f"{one['scrub_hz']:.1f} frames/s"
        )


if __name__ == "__main__":
    main()
