"""A scene of three characters and two props, put together on the page as a person does it.

    python -m tests.end_to_end.pages.authored_scene OUT

By mouse and keyboard alone, on the first seconds of vamr_board (below `MOTORCADE_DATA`, where that
is set) and on a drawn recording with a marker that is carried about. The command that the page
shows then draws the film; images of the page and of the film go to OUT, with a glTF file.
"""

from __future__ import annotations

import argparse
import base64
import os
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from motorcade.animation import write_gltf
from motorcade.ga.arrays import FloatArray
from motorcade.render import read_frames
from motorcade.render.video import contact_sheet
from motorcade.replays.cli import main as motorcade
from motorcade.replays.pipeline.job import Job, run_job
from motorcade.replays.studio.desk import open_desk
from tests.bench.view.pages import chromium
from tests.end_to_end.pages.conftest import Browser
from tests.end_to_end.pages.editor_tab import Tab
from tests.end_to_end.pages.gimbal_table import typed
from tests.props import box, write_props
from tests.replays.carried_marker import ID, write_carried
from tests.replays.scenes.test_scene_recordings import write_board
from tests.replays.studio.server.conftest import running

PEOPLE = ("Person", "Person 2", "Person 3")
NAMES = (*PEOPLE, "box", "ball")
FRAMES, SHOWN = 60, 12


@dataclass(frozen=True)
class Authored:
    """What became of a scene.

    Fields:
        film: the folder of the run that drew it.
        gltf: the same as a file of glTF.
        world_m: by object where the page had it at each frame ``(F, 3)``.
        page: an image of the page at the end.
    """

    film: Path
    gltf: Path
    world_m: Mapping[str, FloatArray]
    page: bytes


def authored(
    browser: Browser, recording: Path, manifest: Path | None, out: Path, anchor: str | None
) -> Authored:
    """Run a recording, author a scene on it, draw that by the command which the page shows.

    Args:
        browser: to do it in.
        recording: the footage.
        manifest: of the recording, where it needs one.
        out: folder for all of it, which is made.
        anchor: what the first two are hung on, by its name on the page; None for the ground.
    """
    settings = ("smoothed.representations=motor",)
    run_job(Job(recording, out / "run", manifest, settings=settings))
    write_props(out / "run")
    write_gltf(out / "run" / "box.glb", box(shade=0.95))  # brighter than walls
    with running(open_desk(out / "run")) as (access, _, _):
        tab = Tab(browser, access.link(), 1400, 900, "light")
        put_together(tab, anchor)
        world_m = {name: _places(tab, name) for name in NAMES}
        tab.evaluate("editor.seek(editor.about.frames >> 1)")
        tab.until("editor.drawnFrame === editor.frame")
        shot = tab.ask("Page.captureScreenshot", format="png")["data"]
        command = shlex.split(tab.evaluate("editor.about.film"))
        assert tab.complaints() == []
        tab.close()
    assert motorcade(command[1:]) == 0
    film, gltf = Path(command[-1]), out / "scene.glb"
    assert motorcade(["export", str(film), "--gltf", str(gltf)]) == 0
    return Authored(film, gltf, world_m, base64.b64decode(shot))


def put_together(tab: Tab, anchor: str | None) -> None:
    """One walks, one waves, one is posed; a box stands there, and a ball goes by keyframes.

    Whom the run itself put there goes first.
    """
    tab.until("editor.state.objects.length === 1")
    tab.evaluate("editor.choose('character')")
    tab.press("Delete")
    tab.until("editor.state.objects.length === 0")
    for name in PEOPLE:
        add(tab, "Person", name)
        if anchor is not None and name != PEOPLE[2]:
            choose_by_keys(tab, "Stands on", anchor)
    middle = on_page(tab, PEOPLE[0])
    tall = tab.evaluate(_TALL.replace("NAME", PEOPLE[0]))
    step = np.array([0.7 * tall, 0.0])
    drag_to(tab, PEOPLE[1], middle + step)
    drag_to(tab, PEOPLE[2], middle - step)

    pick(tab, PEOPLE[0])
    tab.press("Walk")
    tab.until("editor.draws")
    start = on_page(tab, PEOPLE[0])
    bend = tall * np.stack([0.8 * RAMP, 0.08 * np.sin(3.0 * RAMP)], axis=-1)
    tab.drag(_rounded(start + bend))
    tab.until("editor.one?.walk === true && (editor.timeline.playing || editor.frame > 0)")

    pick(tab, PEOPLE[1])
    tab.press("Do")
    tab.press("Wave")
    tab.until("editor.one.clip === 'wave'")
    tab.press("Close")

    pick(tab, PEOPLE[2])
    tab.press("Numbers")
    typed(tab, "turn z", "-70")
    tab.press("Close")
    rewind(tab)
    tab.press("Pose")
    tab.until("editor.posing.on && !editor.posing.handles.get('head').hidden")
    tab.settled()
    head = np.array(tab.middle(".joint[title='Head']"))
    tab.drag(_rounded(head + np.array([[0, 0], [6, 1], [12, 3]])))
    tab.until("editor.one.turns.length === 1")
    tab.press("Pose")

    add(tab, "box", "box")
    tab.press("Numbers")
    typed(tab, "size", "0.25")
    tab.press("Close")
    drag_to(tab, "box", middle + 0.5 * step + [0.0, 0.4 * tall])

    add(tab, "ball", "ball")
    tab.press("Numbers")
    typed(tab, "size", "0.25")
    tab.press("Close")
    drag_to(tab, "ball", middle - 0.5 * step + [0.0, 0.4 * tall])
    tab.press("Key")
    tab.until("editor.one.keys.length === 1")
    tab.drag([_scrubbed(tab, 0.7)])
    tab.until("editor.frame > 0 && editor.drawnFrame === editor.frame")
    drag_to(tab, "ball", on_page(tab, "ball") + 0.5 * step)
    tab.until("editor.one.keys.length === 2")
    tab.settled()


RAMP = np.linspace(0.0, 1.0, 24)


def add(tab: Tab, label: str, name: str) -> None:
    """Put somebody or something in, at the first frame."""
    rewind(tab)
    tab.press("Add")
    tab.press(label)
    tab.until(f"editor.chosen === '{name}' && !!editor.actors.get('{name}')?.figure")
    tab.settled()


def rewind(tab: Tab) -> None:
    """To the first frame, by the time bar."""
    tab.drag([_scrubbed(tab, 0.0)])
    tab.until("!editor.timeline.playing && editor.frame === 0 && editor.drawnFrame === 0")


def pick(tab: Tab, name: str) -> None:
    """Choose somebody by the buttons of their names, at the first frame."""
    rewind(tab)
    tab.evaluate(
        "for (const one of document.querySelectorAll('.chip'))"
        f" one.toggleAttribute('data-asked', one.textContent === '{name}')"
    )
    tab.drag([tab.middle(".chip[data-asked]")])
    tab.until(f"editor.chosen === '{name}'")


def drag_to(tab: Tab, name: str, goal: FloatArray) -> None:
    """Drag an object over what it stands on until what was touched of it is at a place."""
    pick_if_not(tab, name)
    found = tab.evaluate(_TOUCHED.replace("NAME", name))
    assert found, f"{name} cannot be touched"
    foot = on_page(tab, name)
    tab.drag(_rounded([found + share * (goal - foot) for share in np.linspace(0.0, 1.0, 8)]))
    tab.settled()


# How tall somebody is, in pixels of the page, seen from the side.
_TALL = """(() => {
  const one = editor.actors.get("NAME");
  return one.height / editor.stage.metresAPixel(one.place);
})()"""
# A place of the page where an object is touched, and no handle of it.
_TOUCHED = """(() => {
  const one = editor.actors.get("NAME"), box = editor.stage.ground.getBoundingClientRect();
  const around = editor.stage.placeOf(one.place);
  for (let up = 0; up < 260; up += 4) for (const aside of [0, 6, -6, 14, -14, 24, -24]) {
    const [x, y] = [Math.round(around[0] + aside), Math.round(around[1] - up)];
    if (y < box.top) continue;
    const got = editor.pick(x, y, false);
    if (got?.name === "NAME" && !got.handle) return [x, y];
  }
  return null;
})()"""


def pick_if_not(tab: Tab, name: str) -> None:
    """Choose an object unless it is; the moment stays for what is chosen already."""
    if tab.evaluate("editor.chosen") != name:
        pick(tab, name)


def choose_by_keys(tab: Tab, field: str, word: str) -> None:
    """A choice of *More*, by the arrow keys: each press goes one on, and is done at once."""
    tab.press("More")
    select = f"document.querySelector('[data-field=\"{field}\"]')"
    tab.evaluate(f"{select}.focus()")
    down = {"key": "ArrowDown", "code": "ArrowDown", "windowsVirtualKeyCode": 40}
    for _ in range(tab.evaluate(f"{select}.length")):
        if tab.evaluate(f"{select}.selectedOptions[0].text") == word:
            break
        before = tab.evaluate(f"{select}.value")
        for kind in ("rawKeyDown", "keyUp"):
            tab.ask("Input.dispatchKeyEvent", type=kind, **down)
        tab.until(f"{select}.value !== {before!r}")
        tab.settled()
    tab.until(f"{select}.selectedOptions[0].text === {word!r}")
    tab.press("Close")


def on_page(tab: Tab, name: str) -> FloatArray:
    """Where an object stands on the page, CSS pixels."""
    return np.array(tab.evaluate(f"editor.stage.placeOf(editor.actors.get('{name}').place)"))


def _scrubbed(tab: Tab, share: float) -> tuple[int, int]:
    """A place of the time bar; its knob is 16 pixels wide and stays within."""
    left, top, wide, high = tab.evaluate(
        "(({left, top, width, height}) => [left, top, width, height])("
        "document.querySelector('.scrub').getBoundingClientRect())"
    )
    return round(left + 8 + share * (wide - 16)), round(top + high / 2)


def _places(tab: Tab, name: str) -> FloatArray:
    """Where the page has an object at every frame, metres in the world: ``(F, 3)``."""
    return np.array(
        tab.evaluate(
            "[...editor.about.time_s.data.keys()].map((frame) => {"
            f" const one = editor.actors.get('{name}');"
            " one.show(frame, editor.about.time_s.data[frame]); return one.place.toArray(); })"
        )
    )


def _rounded(places: Iterable[FloatArray]) -> list[tuple[int, int]]:
    return [(round(float(x)), round(float(y))) for x, y in places]


def main() -> None:
    """Author both, and write images to look at."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("out", type=Path, metavar="OUT")
    out = parser.parse_args().out
    out.mkdir(parents=True)
    with chromium() as browser:
        given: dict[str, tuple[Path, Path | None, str | None]] = {}
        write_carried(out / "carried" / "recording")
        given["carried"] = out / "carried" / "recording", None, f"Marker {ID}"
        if data := os.environ.get("MOTORCADE_DATA"):
            given["board"] = *write_board(Path(data), out / "board", FRAMES), None
        for name, (recording, manifest, anchor) in given.items():
            made = authored(browser, recording, manifest, out / name, anchor)
            (out / f"{name}-page.png").write_bytes(made.page)
            film = [image for _, image in read_frames(made.film / "overlay.mp4")]
            sheet = contact_sheet(film[:: max(1, len(film) // SHOWN)][:SHOWN], 3, 640)
            cv2.imwrite(str(out / f"{name}-film.png"), sheet[..., ::-1])
            print(f"{name}: {len(film)} frames in {made.film}, glTF in {made.gltf}")


if __name__ == "__main__":
    main()
