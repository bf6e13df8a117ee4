"""A real browser for the pages: Chromium without a window, spoken to over a pipe."""

import fcntl
import json
import os
import select
import shutil
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

PATIENCE_S = 60.0
FLAGS = (
    "--headless=new",
    "--no-sandbox",
    # WebGL by software, so that every machine draws alike
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--mute-audio",
    "--no-first-run",
    "--disable-extensions",
    "--disable-background-networking",
    "--disable-component-update",
    "--remote-debugging-pipe",
)
KEYS = {"Enter": 13, "Tab": 9, " ": 32, "End": 35, "Home": 36, "ArrowLeft": 37, "ArrowRight": 39}


class Browser:
    """Chromium, asked by the DevTools protocol: JSON messages that end in a zero byte.

    It reads them from its descriptor 3 and answers on 4, so there is no port to be taken.
    """

    def __init__(self, program: str, profile: Path, *flags: str) -> None:
        theirs_in, self._out = os.pipe()
        self._in, theirs_out = os.pipe()
        # Above 9, so that neither is overwritten while they become 3 and 4.
        high = [fcntl.fcntl(one, fcntl.F_DUPFD_CLOEXEC, 10) for one in (theirs_in, theirs_out)]
        log = str(profile / "log.txt")
        written = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        self._process = os.posix_spawn(
            program,
            [program, *FLAGS, *flags, f"--user-data-dir={profile / 'profile'}", "about:blank"],
            os.environ | {"HOME": str(profile)},
            file_actions=[
                (os.POSIX_SPAWN_DUP2, high[0], 3),
                (os.POSIX_SPAWN_DUP2, high[1], 4),
                (os.POSIX_SPAWN_OPEN, 1, log, written, 0o600),
                (os.POSIX_SPAWN_DUP2, 1, 2),
            ],
            setpgroup=0,
        )
        for one in (theirs_in, theirs_out, *high):
            os.close(one)
        self._buffer, self._number = b"", 0
        self.events: list[dict[str, Any]] = []

    def ask(self, method: str, session: str | None = None, **parameters: object) -> dict[str, Any]:
        """Send a command and wait for its answer; events that come before it are kept."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if session is not None:
            message["sessionId"] = session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + PATIENCE_S
        while True:
            answer = self._read(until)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return dict(answer["result"])
            self.events.append(answer)

    def wait_for(self, method: str, session: str) -> None:
        """Wait for an event of a session."""
        until = time.monotonic() + PATIENCE_S
        while not any((e["method"], e.get("sessionId")) == (method, session) for e in self.events):
            self.events.append(self._read(until))

    def close(self) -> None:
        """End it and all of its own."""
        os.close(self._out)
        os.close(self._in)
        with suppress(ProcessLookupError):  # it may have ended with its pipe
            os.killpg(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)

    def _read(self, until: float) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._in], [], [], max(0.0, until - time.monotonic()))
            chunk = os.read(self._in, 1 << 20) if ready else b""
            if not chunk:
                raise TimeoutError("Chromium does not answer")
            self._buffer += chunk
        message, self._buffer = self._buffer.split(b"\0", 1)
        found: dict[str, Any] = json.loads(message)
        return found


class Page:
    """A file or an address opened in the browser, at a width and in a colour scheme."""

    def __init__(self, browser: Browser, at: Path | str, width: int, scheme: str) -> None:
        self._browser = browser
        self.address = at if isinstance(at, str) else at.resolve().as_uri()
        made = browser.ask("Target.createTarget", url="about:blank")
        self._target = made["targetId"]
        attached = browser.ask("Target.attachToTarget", targetId=self._target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.ask(f"{domain}.enable")
        self.ask(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=800,
            deviceScaleFactor=1,
            mobile=width < 600,
        )
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.ask("Emulation.setEmulatedMedia", features=features)
        answer = self.ask("Page.navigate", url=self.address)
        assert "errorText" not in answer, answer
        browser.wait_for("Page.loadEventFired", self._session)

    def ask(self, method: str, **parameters: object) -> dict[str, Any]:
        """A command to this page."""
        return self._browser.ask(method, self._session, **parameters)

    def evaluate(self, expression: str) -> Any:
        """The value of a JavaScript expression; promises are waited for."""
        found = self.ask(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def press(self, key: str) -> None:
        """A key pressed and let go."""
        text = {"Enter": "\r", " ": " "}.get(key, "")
        code = KEYS[key]
        for kind in ("keyDown", "keyUp"):
            self.ask(
                "Input.dispatchKeyEvent",
                type=kind,
                key=key,
                code=key,
                text=text,
                windowsVirtualKeyCode=code,
            )

    def click(self, x: float, y: float) -> None:
        """A click of the mouse, CSS pixels of the window."""
        for kind in ("mousePressed", "mouseReleased"):
            self.ask(
                "Input.dispatchMouseEvent",
                type=kind,
                x=x,
                y=y,
                button="left",
                buttons=1,
                clickCount=1,
            )

    def complaints(self, beside: tuple[str, ...] = ()) -> list[str]:
        """Errors and warnings of the console, exceptions, and requests for anything else.

        `beside` names files of the page's folder that it may ask for.
        """
        self.evaluate("0")  # what is on its way arrives before the answer
        told = []
        for event in self._browser.events:
            if event.get("sessionId") != self._session:
                continue
            method, about = event["method"], event["params"]
            if method == "Runtime.exceptionThrown":
                told.append(str(about["exceptionDetails"]))
            elif method == "Runtime.consoleAPICalled" and about["type"] in ("error", "warning"):
                told.append(str(about["args"]))
            elif method == "Log.entryAdded":
                told.append(str(about["entry"]))
            elif method == "Network.requestWillBeSent":
                address = about["request"]["url"]
                expected = (
                    self.address,
                    *(self.address.rpartition("/")[0] + f"/{n}" for n in beside),
                )
                if address not in expected and not address.startswith(("data:", "blob:")):
                    told.append(address)
        return told

    def close(self) -> None:
        """Close the page and forget what it told."""
        self._browser.ask("Target.closeTarget", targetId=self._target)
        self._browser.events.clear()


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """Chromium; tests that ask for it skip where there is none."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("no Chromium here: apt-get install chromium")
    made = Browser(program, tmp_path_factory.mktemp("browser"))
    yield made
    made.close()


@pytest.fixture
def opened(browser: Browser) -> Iterator[Callable[..., Page]]:
    """Open a file at a width of so many pixels, light or dark."""
    pages = []

    def page(path: Path, width: int = 1200, scheme: str = "light") -> Page:
        pages.append(Page(browser, path, width, scheme))
        return pages[-1]

    yield page
    for one in pages:
        one.close()
