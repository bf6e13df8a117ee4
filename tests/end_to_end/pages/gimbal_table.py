"""The gimbal table through the real page: rings of an object's own axes dragged near ±90° of pitch.

    python -m tests.end_to_end.pages.gimbal_table OUT.png

prints, for each pitch and axis, how far the drag went and how far from there the object ends, held
as a rotor and as Euler angles, and draws the two beside each other.
"""

from __future__ import annotations

import argparse
import base64
import json
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from motorcade.animation.authoring import Dragged, SceneEditor, gesture_of
from motorcade.ga import Rotor
from motorcade.replays.studio.desk import RunDesk
from tests.end_to_end.pages.conftest import Browser
from tests.end_to_end.pages.editor_tab import Tab
from tests.replays.studio.server.conftest import running
from tests.replays.studio.server.stage import desk

PITCHES_DEG = (85.0, 89.0, 89.9)
AXES = "xyz"
# A place on the ring of an axis that a click takes hold of, and the one so many degrees on.
ON_RING = """(() => {
  const { handles, stage } = editor;
  const ring = handles.object.children.filter((one) => !one.userData.arrow)[AXIS];
  const at = (angle) => stage.placeOf(
    editor.actors.get("Person").place.set(62 * Math.cos(angle), 62 * Math.sin(angle), 0)
      .applyMatrix4(ring.matrixWorld));
  for (let k = 0; k < 360; k += 5) {
    const way = [0, 5, 10, 15, 20, 25, 30].map((more) => at((k + more) * Math.PI / 180));
    if (way.some((one) => !one)) continue;
    const [x, y] = way[0].map(Math.round);
    const found = editor.pick(x, y, false)?.handle;
    const far = Math.hypot(way[6][0] - way[0][0], way[6][1] - way[0][1]);
    if (found?.gesture === "ring" && found.axis[AXIS] === 1 && far > 12) return way;
  }
  return null;
})()"""


@dataclass(frozen=True)
class DraggedRing:
    """A ring dragged on the page.

    Fields:
        pitch_deg, axis: where the object was, and about which of its own axes it was dragged.
        asked_deg: how far the drag went, by what the page recorded of it.
        rotor_off_deg: between where that leads and where the page's scene has the object.
        euler_off_deg: the same with the recorded gesture on Euler angles.
        images: of the page with either, where they were asked for.
    """

    pitch_deg: float
    axis: str
    asked_deg: float
    rotor_off_deg: float
    euler_off_deg: float
    images: tuple[np.ndarray, ...] = ()


def typed_turn(tab: Tab, angles_deg: tuple[float, float, float]) -> None:
    """The three angles of what is chosen, typed into the form of numbers."""
    tab.press("Numbers")
    for axis, angle in zip(AXES, angles_deg, strict=True):
        typed(tab, f"turn {axis}", f"{angle:.9f}")
    tab.press("Close")


def typed(tab: Tab, field: str, text: str) -> None:
    """A number typed into a field of a form, by what stands before it."""
    tab.drag([tab.middle(f"input[data-field='{field}']")])
    tab.until(f"document.activeElement.dataset.field === {field!r}")
    tab.evaluate("document.activeElement.select()")
    tab.ask("Input.insertText", text=text)
    enter = {"key": "Enter", "code": "Enter", "text": "\r", "windowsVirtualKeyCode": 13}
    for kind in ("keyDown", "keyUp"):
        tab.ask("Input.dispatchKeyEvent", type=kind, **enter)
    tab.settled()


def dragged_rings(tab: Tab, at: RunDesk, images: bool = False) -> Iterator[DraggedRing]:
    """Each axis at each pitch, by the mouse on the page."""
    tab.somebody()
    tab.press("Axes")
    tab.press("More")
    tab.evaluate(
        "(() => { const one = document.querySelector('[data-field=\"Handles along\"]');"
        "one.value = 'local'; one.dispatchEvent(new Event('change')); })()"
    )
    tab.press("Close")
    for pitch in PITCHES_DEG:
        for number, axis in enumerate(AXES):
            typed_turn(tab, (0.0, pitch, 0.0))
            before = at.session.history.scene
            way = tab.evaluate(ON_RING.replace("AXIS", str(number)))
            assert way, f"no place on the ring of {axis} can be taken hold of"
            tab.drag([(round(x), round(y)) for x, y in way])
            tab.settled()
            after = at.session.history.scene
            gesture = last_gesture(at)
            asked = float(gesture.amounts[-1])
            start = before.pose("Person").as_similarity().rotor
            wanted = start @ Rotor.from_rotation_vector(asked * np.eye(3)[number])
            by_rotor = after.pose("Person").as_similarity().rotor
            editor = SceneEditor(before.on_euler_angles())
            by_euler = editor.do(gesture).pose("Person").as_similarity().rotor
            drawn = [shot(tab)] if images else []
            if images:
                x, y, z = np.degrees(by_euler.as_euler())
                typed_turn(tab, (x, y, z))
                drawn.append(shot(tab))
            yield DraggedRing(
                pitch,
                axis,
                float(np.degrees(asked)),
                off_deg(wanted, by_rotor),
                off_deg(wanted, by_euler),
                tuple(drawn),
            )


def last_gesture(at: RunDesk) -> Dragged:
    """What the page's session recorded last."""
    line = at.session.history.write_log.gestures.read_text().splitlines()[-1]
    gesture = gesture_of(json.loads(line))
    assert isinstance(gesture, Dragged)
    return gesture


def off_deg(one: Rotor, other: Rotor) -> float:
    """The angle between two turns."""
    return float(np.degrees((one.inverse() @ other).angle()))


def shot(tab: Tab) -> np.ndarray:
    """The stage as it is seen."""
    tab.settled()
    data = base64.b64decode(tab.ask("Page.captureScreenshot", format="png")["data"])
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    x, y = np.round(tab.place(0.5)).astype(int)
    return np.asarray(image[max(y - 150, 0) : y + 150, max(x - 150, 0) : x + 150])


def main() -> int:
    """Print the table and draw it."""
    parser = argparse.ArgumentParser(description="The gimbal table through the editor's page.")
    parser.add_argument("out", type=Path, metavar="OUT.png")
    given = parser.parse_args()
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        print("no Chromium here: apt-get install chromium", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        at, browser = desk(Path(folder)), Browser(program, Path(folder))
        print("pitch  axis  dragged  off by rotor  off by Euler angles (deg)")
        drawn = []
        with running(at) as (access, _, _):
            tab = Tab(browser, access.link(), 1400, 900, "light")
            for row in dragged_rings(tab, at, images=True):
                offs = f"{row.rotor_off_deg:12.2e}  {row.euler_off_deg:6.2f}"
                print(f"{row.pitch_deg:5.1f}  {row.axis:4}  {row.asked_deg:7.2f}  {offs}")
                drawn.append(np.hstack(row.images))
        browser.close()
    rows = [np.hstack(drawn[k : k + 3]) for k in range(0, len(drawn), 3)]
    cv2.imwrite(str(given.out), np.vstack(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
