"""The editor in a tab of a real browser: by mouse, or by fingers on a phone."""

from __future__ import annotations

import json
import time
from typing import Any

import numpy as np

from tests.end_to_end.pages.conftest import Browser

PATIENCE_S = 60.0
# For so long a finger rests before it is lifted: else its stroke is a fling, and the next touch
# only stops that.
RESTS_S = 0.15
# Where the middle of an object is on the page, its pose, and whether all that was said is answered.
IDLE = "!editor.link.under_way && !editor.link.queue.length"
_BUTTON = """((word) => {
  const all = [...document.querySelectorAll("button")];
  const shown = all.filter((one) => one.offsetParent && !one.disabled);
  const said = (one) => one.textContent.trim();
  return shown.find((one) => said(one) === word) ?? shown.find((one) => said(one).includes(word));
})"""
# Where a button's middle is once it is scrolled to, and whether it is the one to be touched there.
_AIMED = f"""(() => {{
  const one = {_BUTTON}(WORD);
  one.scrollIntoView({{ block: "nearest", inline: "nearest" }});
  window.clicked = false;
  one.addEventListener("click", () => (window.clicked = true), {{ once: true }});
  const {{ x, y, width, height }} = one.getBoundingClientRect();
  const middle = [x + width / 2, y + height / 2];
  return [...middle, one.contains(document.elementFromPoint(...middle))];
}})()"""
POSE = "editor.actors.get('Person').matrix.clone()"


class Tab:
    """The editor in a tab of its own."""

    def __init__(
        self, browser: Browser, address: str, width: int, height: int, scheme: str
    ) -> None:
        self.browser = browser
        self.target = browser.ask("Target.createTarget", url="about:blank")["targetId"]
        attached = browser.ask("Target.attachToTarget", targetId=self.target, flatten=True)
        self.session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")
        self.mobile = width < 900
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": self.mobile}
        self.ask("Emulation.setDeviceMetricsOverride", **size)
        touch = {"enabled": self.mobile, "maxTouchPoints": 5}
        self.ask("Emulation.setTouchEmulationEnabled", **touch)
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.ask("Emulation.setEmulatedMedia", features=features)
        self.ask("Page.navigate", url=address)
        self.until("!!window.editor && editor.drawnFrame === 0")

    def ask(self, method: str, **parameters: object) -> dict[str, Any]:
        return self.browser.ask(method, self.session, **parameters)

    def evaluate(self, expression: str) -> Any:
        asked = {"expression": expression, "returnByValue": True, "awaitPromise": True}
        found = self.ask("Runtime.evaluate", **asked)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def until(self, expression: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while not self.evaluate(expression):
            assert time.monotonic() < end, expression
            time.sleep(0.02)

    def drag(self, places: list[tuple[int, int]]) -> None:
        """One finger, or the mouse, along places of the page; a touch of a single one."""
        if self.mobile:
            self.fingers([[one] for one in places])
            return
        for k, (x, y) in enumerate([*places, places[-1]]):
            kind = "mousePressed" if k == 0 else "mouseMoved"
            kind = "mouseReleased" if k == len(places) else kind
            about = {"type": kind, "x": x, "y": y, "button": "left", "clickCount": 1, "buttons": 1}
            self.ask("Input.dispatchMouseEvent", **about)

    def fingers(self, places: list[list[tuple[int, int]]]) -> None:
        """Fingers come down one by one, go along, and are lifted."""
        for count in range(1, len(places[0]) + 1):
            self._touch("touchStart", places[0][:count])
        for one in places[1:]:
            self._touch("touchMove", one)
        if len(places) > 1:
            time.sleep(RESTS_S)
            self._touch("touchMove", places[-1])
        self._touch("touchEnd", [])

    def _touch(self, kind: str, places: list[tuple[int, int]]) -> None:
        points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(places)]
        self.ask("Input.dispatchTouchEvent", type=kind, touchPoints=points)

    def press(self, word: str) -> None:
        """A button, by what stands on it; over once it heard the click.

        Fingers are told apart from strokes after they are lifted, so a click comes late.
        """
        self.until(f"!!({_BUTTON}({json.dumps(word)}))")
        x, y, met = self.evaluate(_AIMED.replace("WORD", json.dumps(word)))
        assert met, f"{word}: something lies over it"
        self.drag([(round(x), round(y))])
        self.until("clicked")

    def middle(self, selector: str) -> tuple[int, int]:
        """Where an element's middle is on the page, once it is scrolled to."""
        self.until(f"!!document.querySelector({selector!r})?.offsetParent")
        x, y = self.evaluate(
            f"(() => {{ const one = document.querySelector({selector!r});"
            "one.scrollIntoView({ block: 'nearest', inline: 'nearest' });"
            "const r = one.getBoundingClientRect();"
            "return [r.x + r.width / 2, r.y + r.height / 2] })()"
        )
        return round(x), round(y)

    def somebody(self) -> None:
        """Put a person in and wait until it is seen."""
        self.press("Add")
        self.press("Person")
        self.until("!!editor.actors.get('Person')?.figure && editor.chosen === 'Person'")
        self.settled()

    def settled(self) -> None:
        """Wait for answers, and until they are drawn."""
        self.until(IDLE)
        self.evaluate(
            "new Promise((seen) => requestAnimationFrame(() => requestAnimationFrame(seen)))"
        )

    def place(self, share: float = 0.0) -> np.ndarray:
        """Where the person is on the page: its foot, or so much of its height up."""
        return np.array(
            self.evaluate(
                "(() => { const one = editor.actors.get('Person'); const up = one.place;"
                f"up.z += {share} * one.height; return editor.stage.placeOf(up) }})()"
            )
        )

    def complaints(self) -> list[str]:
        self.evaluate("0")
        told = []
        for event in self.browser.events:
            about = event["params"]
            if event.get("sessionId") != self.session:
                continue
            if event["method"] == "Runtime.exceptionThrown" or (
                event["method"] == "Runtime.consoleAPICalled" and about["type"] != "log"
            ):
                told.append(str(about))
            elif event["method"] == "Log.entryAdded":
                told.append(str(about["entry"]))
        return told

    def close(self) -> None:
        self.browser.ask("Target.closeTarget", targetId=self.target)
