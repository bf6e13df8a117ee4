"""How fast and how right the live page is, with Chromium's fake camera fed from a recording.

    python -m tests.bench.live                    # vamr_board below MOTORCADE_DATA, else drawn
    python -m tests.bench.live --target tag       # a drawn marker
    python -m tests.bench.live --target slam      # 7scenes_redkitchen; the floor plane is tapped
    python -m tests.bench.live --rate-hz 15 --seconds 20 --width 390 --shot page.png

Browser and server run on this machine together, WebGL by software. Printed are frames drawn a
second, latency from capture to drawn (the animation frame after the drawing), registration of
corners that had no part in the pose, states, and processor time a frame drawn.
"""

from __future__ import annotations

import argparse
import base64
import json
import os
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.replays import open_recording
from motorcade.replays.live import LiveTracker
from motorcade.replays.live.app import MAX_FRAME_BYTES, live_app
from motorcade.replays.live.session import LiveFigure, LiveRecorder, LiveSession, height_on
from motorcade.replays.live.tracker import FirstMarker, Target
from motorcade.replays.studio.access import Access
from motorcade.replays.studio.serving import Listening, configured, opened
from motorcade.tracking import Board, Camera, SingleMarker
from tests.bench.data import data_folder
from tests.end_to_end.pages.conftest import Browser
from tests.replays.live import drawn

SIZE = (640, 480)
PATIENCE_S = 60.0


@dataclass(frozen=True, eq=False)
class Filmed:
    """What the fake camera shows."""

    target: Target
    camera: Camera
    images: tuple[np.ndarray, ...]

    def tap(self, tab: LiveTab) -> None:
        """Stand the figure: in the board's middle, or where the lower part of the image lies."""
        if self.target == "slam":
            width, height = tab.value("[innerWidth, innerHeight]")
            tab.tap(0.5 * width, 0.7 * height)
        else:
            points_m = self.target.points_m if isinstance(self.target, Board) else TAG.points_m
            tab.tap_world(", ".join(map(str, points_m.mean(axis=0))))


TAG = SingleMarker("tag36h11", 5, 0.16)


def filmed(frames: int, target: str = "board") -> Filmed:
    """The board of vamr_board, cut to 640 x 480; drawn where there are no recordings."""
    data = data_folder()
    folder = data / "replays" / "vamr_board"
    if target == "tag":
        camera = Camera(*SIZE, 600.0, 600.0, 319.5, 239.5)
        poses = [drawn.world_T_camera(index, 7) for index in range(frames)]
        moved = TAG.points_m.mean(axis=0) - drawn.BOARD.points_m.mean(axis=0)
        offset = Motor.from_rotor_translation(Rotor.identity(), moved)
        images = tuple(drawn.image_of(offset @ pose, TAG, camera) for pose in poses)
        return Filmed(FirstMarker(TAG.family, TAG.side_m), camera, images)
    if target == "slam":
        recording = open_recording(data / "replays" / "7scenes_redkitchen")
        assert recording.camera is not None
        count = min(frames, len(recording.frames))
        images = tuple(recording.frames[index].gray() for index in range(count))
        return Filmed("slam", recording.camera, images)
    if not folder.is_dir():
        camera = Camera(*SIZE, 600.0, 600.0, 319.5, 239.5)
        poses = [drawn.world_T_camera(index, 7) for index in range(frames)]
        images = tuple(drawn.image_of(pose, camera=camera) for pose in poses)
        return Filmed(drawn.BOARD, camera, images)
    recording = open_recording(folder, Path("docs/manifests/vamr_board.toml"))
    assert recording.camera is not None
    assert recording.board is not None
    left = (recording.camera.width - SIZE[0]) // 2
    camera = replace(recording.camera, width=SIZE[0], cx=recording.camera.cx - left)
    count = min(frames, len(recording.frames))
    images = tuple(recording.frames[k].gray()[:, left : left + SIZE[0]] for k in range(count))
    return Filmed(recording.board, camera, images)


def write_y4m(path: Path, images: Iterable[np.ndarray], rate_hz: int) -> None:
    """A film as Chromium's fake camera reads it, there and back so that it loops smoothly."""
    images = list(images)
    height, width = images[0].shape
    colour = bytes([128]) * (width * height // 2)
    with path.open("wb") as file:
        file.write(f"YUV4MPEG2 W{width} H{height} F{rate_hz}:1 Ip A1:1 C420mpeg2\n".encode())
        for image in [*images, *images[-2:0:-1]]:
            file.write(b"FRAME\n" + image.tobytes() + colour)


@contextmanager
def running(session: LiveSession, frames: Any = None) -> Iterator[Access]:
    """A live server, for as long as the block lasts."""
    listening = Listening()
    with opened(listening) as (listener, access):
        server = configured(live_app(session, frames, access), listening, MAX_FRAME_BYTES)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
        thread.start()
        until = time.monotonic() + PATIENCE_S
        while not server.started:
            assert time.monotonic() < until, "the server does not start"
            time.sleep(0.01)
        yield access
        server.should_exit = True
        thread.join(PATIENCE_S)


class LiveTab:
    """The live page in a tab of its own."""

    def __init__(self, browser: Browser, address: str, width: int, height: int) -> None:
        self.browser = browser
        target = browser.ask("Target.createTarget", url="about:blank")["targetId"]
        attached = browser.ask("Target.attachToTarget", targetId=target, flatten=True)
        self.session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")
        phone = width < 900
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": phone}
        self.ask("Emulation.setDeviceMetricsOverride", **size)
        self.ask("Page.navigate", url=address)

    def ask(self, method: str, **parameters: object) -> dict[str, Any]:
        return self.browser.ask(method, self.session, **parameters)

    def value(self, expression: str) -> Any:
        answer = self.ask("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def until(self, expression: str, patience_s: float = PATIENCE_S) -> None:
        end = time.monotonic() + patience_s
        while not self.value(expression):
            assert time.monotonic() < end, (expression, self.value("document.body.innerText"))
            time.sleep(0.05)

    def tap(self, x: float, y: float) -> None:
        for kind in ("mousePressed", "mouseReleased"):
            mouse = {"x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1}
            self.ask("Input.dispatchMouseEvent", type=kind, **mouse)

    def tap_world(self, point: str) -> None:
        """A tap where a point of the world is seen, `x, y, z` as JavaScript."""
        code = f"livePage.stage.placeOf(livePage.stage.figures.position.clone().set({point}))"
        self.tap(*self.value(code))

    def shot(self, path: Path) -> None:
        data = self.ask("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(data))


def processor_s(group: int) -> float:
    """Processor time of a group of processes so far."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()
            ticks += (int(fields[11]) + int(fields[12])) * (int(fields[2]) == group)
    return ticks / os.sysconf("SC_CLK_TCK")


@contextmanager
def fake_camera(film: Path) -> Iterator[Browser]:
    """Chromium whose camera plays a film."""
    flags = (
        "--use-fake-device-for-media-stream",
        "--use-fake-ui-for-media-stream",
        f"--use-file-for-fake-video-capture={film}",
    )
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser("/usr/bin/chromium", Path(profile), *flags)
        try:
            yield browser
        finally:
            browser.close()


def measured(
    shown: Filmed, film: Path, seconds: float, width: int, *, find: bool, shots: Path | None
) -> dict[str, Any]:
    """Figures of a live session of so many seconds."""
    with tempfile.TemporaryDirectory() as kept:
        tracker = LiveTracker(shown.target, None if find else shown.camera)
        recorder = LiveRecorder(Path(kept, "session"))
        figure = LiveFigure("mannequin", height_on(shown.target))
        session = LiveSession(tracker, figure, recorder)
        with fake_camera(film) as browser, running(session) as access:
            tab = LiveTab(browser, access.link(), width, 800)
            began_s = time.monotonic()
            tab.until("window.livePage && livePage.stage.hasPose")
            found_s = time.monotonic() - began_s
            while not tab.value("!!(livePage.figure.figure && livePage.figure.state)"):
                if not tab.value("livePage.figure.state"):
                    shown.tap(tab)
                time.sleep(0.3)
            time.sleep(1.0)
            drawn_before, cpu, start = tab.value("livePage.drawn"), os.times(), time.monotonic()
            states = dict(session.measure.states)
            browser_s = processor_s(browser._process)
            latencies_s: list[float] = []
            keep = session.measure.drawn

            def noted(latency_s: float, keep: Callable[[float], None] = keep) -> None:
                latencies_s.append(latency_s)
                keep(latency_s)

            session.measure.drawn = noted  # type: ignore[method-assign]
            time.sleep(seconds)
            passed_s = time.monotonic() - start
            drawn_count = tab.value("livePage.drawn") - drawn_before
            spent = os.times()
            browser_s = processor_s(browser._process) - browser_s
            figures = session.measure.figures()
            if shots is not None:
                tab.shot(shots)
        session.close()
    after = session.measure.states
    return {
        "pose_after_s": round(found_s, 2),
        "frames_drawn_s": round(drawn_count / passed_s, 1),
        "latency_ms": {
            f"p{percent}": round(1e3 * float(np.percentile(latencies_s, percent)), 1)
            for percent in (50, 95)
        },
        "registration_px": figures["registration_px"],
        "registration_p95_px": figures["registration_p95_px"],
        "states": {state: after[state] - states.get(state, 0) for state in after},
        "server_ms_a_frame": round(
            1e3 * (spent.user + spent.system - cpu.user - cpu.system) / max(drawn_count, 1), 1
        ),
        "browser_ms_a_frame": round(1e3 * browser_s / max(drawn_count, 1), 1),
        "camera": session.tracker.camera_status,
        "load": os.getloadavg()[0],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--target", choices=("board", "tag", "slam"), default="board")
    parser.add_argument("--rate-hz", type=int, default=30)
    parser.add_argument("--width", type=int, default=1200, help="of the window; 390 as a phone")
    parser.add_argument("--frames", type=int, default=150, help="of the film, there and back")
    parser.add_argument("--find-camera", action="store_true", help="from the board, live")
    parser.add_argument("--shot", type=Path, help="write an image of the page")
    arguments = parser.parse_args()
    shown = filmed(arguments.frames, arguments.target)
    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder, "camera.y4m")
        write_y4m(film, shown.images, arguments.rate_hz)
        figures = measured(
            shown,
            film,
            arguments.seconds,
            arguments.width,
            find=arguments.find_camera,
            shots=arguments.shot,
        )
    print(json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
