"""Does `motorcade live` stay as it is? A camera that films for minutes, is cut off, and is watched.

    python -m tests.end_to_end.live_minutes --minutes 10

The command runs in a process of its own, and records. Like the page, the client sends its newest
frame once the last was answered, with what its motion sensors felt; two others look on. In the
middle the line is cut for five seconds, without a word to the server. By the minute: memory of the
server's process, answers' latency, states. It fails where memory after the first minute varies by
more than 50 MiB, where the last minute's latency is above twice the second's and 20 ms, where a
viewer was not shown at least one image a second, or where the camera is not let in again.
"""

from __future__ import annotations

import argparse
import json
import re
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from websockets import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from motorcade.replays.io.readers.manifest.section import camera_toml
from motorcade.replays.live.app import HEADER
from tests.replays.live import drawn

PERIOD_S = 200.0 * np.pi * 1e-9 * drawn.STEP_NS
"""After which the drawn camera is where it was."""
SEED, SENSOR_HZ, CUT_S = 51, 60.0, 5.0
MOST_MIB, MOST_GROWTH, MOST_MORE_MS = 50.0, 2.0, 20.0


@dataclass
class Minute:
    """What was seen in one."""

    latency_ms: list[float] = field(default_factory=list)
    memory_mib: list[float] = field(default_factory=list)
    states: Counter[str] = field(default_factory=Counter)
    watched: list[int] = field(default_factory=lambda: [0, 0])
    said: str = ""

    def line(self) -> str:
        """For people."""
        p50, p95 = np.percentile(self.latency_ms or [np.nan], [50.0, 95.0])
        low, high = min(self.memory_mib), max(self.memory_mib)
        states = " ".join(f"{state} {count}" for state, count in self.states.items())
        return (
            f"memory {low:6.1f} to {high:6.1f} MiB  latency {p50:6.1f} ms, 95 % {p95:6.1f}  "
            f"watched {self.watched[0]:5} {self.watched[1]:5}  {states}"
        )


@cache
def felt() -> np.ndarray:
    """Readings of one period: ms, °/s, m/s²."""
    samples = drawn.readings(PERIOD_S, SEED, SENSOR_HZ)
    return np.array(
        [[1e-6 * s.time_ns, *np.degrees(s.rate_rad_s), *s.force_m_s2] for s in samples], "<f4"
    )


@cache
def filmed(index: int, count: int) -> bytes:
    """Luma of an image of one period."""
    at = index / count * PERIOD_S * 1e9 / drawn.STEP_NS
    return drawn.image_of(drawn.world_T_camera(at, SEED)).tobytes()


def between(from_ms: float, to_ms: float) -> np.ndarray:
    """Readings of a path that repeats itself."""
    period_ms, rows = 1e3 * PERIOD_S, []
    for lap in range(int(from_ms // period_ms), int(to_ms // period_ms) + 1):
        moved = felt().copy()
        moved[:, 0] += lap * period_ms
        rows.append(moved[(moved[:, 0] > from_ms) & (moved[:, 0] <= to_ms)])
    return np.concatenate(rows)[-256:]


def memory_mib(process: int) -> float:
    """What it holds in memory."""
    status = Path(f"/proc/{process}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024.0  # type: ignore[index]


class Visits:
    """A camera and two viewers of one server, and what they see."""

    def __init__(self, link: str, rate_hz: float) -> None:
        self.link, self.count = link, round(PERIOD_S * rate_hz)
        self.began_s = time.monotonic()
        self.minutes: list[Minute] = [Minute()]
        self.open = ExitStack()
        self.number = 0

    def now(self) -> Minute:
        """The minute that it is."""
        while len(self.minutes) <= (time.monotonic() - self.began_s) // 60.0:
            self.minutes.append(Minute())
        return self.minutes[-1]

    def visit(self) -> ClientConnection:
        """A socket of the page; it stays open when it is left."""
        address = self.link.replace("http", "ws", 1) + "live"
        origin = re.match(r"https?://[^/]+", self.link)
        assert origin is not None
        options: Any = {"origin": origin[0], "proxy": None, "max_size": 1 << 23}
        return self.open.enter_context(connect(address, **options))

    def film(self, until_s: float) -> None:
        """Send frames from now on, one at a time, until a moment."""
        browser, step_s = self.visit(), PERIOD_S / self.count
        assert json.loads(browser.recv(60.0)) == {"hello": "film"}, "the camera is not let in"
        felt_ms = 1e3 * (time.monotonic() - self.began_s)
        while (at_s := time.monotonic()) < until_s:
            index = int((at_s - self.began_s) / step_s)
            stamp_ms = 1e3 * index * step_s
            rows = between(felt_ms, stamp_ms)
            felt_ms = max(felt_ms, stamp_ms)
            rows[:, 0] -= stamp_ms
            size = (drawn.CAMERA.width, drawn.CAMERA.height)
            head = HEADER.pack(b"MLY2", self.number, stamp_ms, *size, np.nan, len(rows))
            luma = filmed(index % self.count, self.count)
            sent_s, self.number = time.monotonic(), self.number + 1
            browser.send(head + luma + rows.astype("<f4").tobytes())
            answer = json.loads(browser.recv(60.0))
            self.now().latency_ms.append(1e3 * (time.monotonic() - sent_s))
            self.now().states[answer.get("state", "refused")] += 1
            if "figures" in answer:
                self.now().said = answer["figures"]["camera_status"]
            wait_s = self.began_s + (index + 1) * step_s - time.monotonic()
            time.sleep(max(0.0, wait_s))

    def watch(self, which: int) -> None:
        """Look on, as a page does."""
        browser = self.visit()
        with suppress(ConnectionClosed):
            for data in browser:
                if isinstance(data, bytes):
                    (length,) = struct.unpack_from("<I", data)
                    browser.send(f"drew {json.loads(data[4 : 4 + length])['frame']}")
                    self.now().watched[which] += 1


def faults_of(minutes: list[Minute], minutes_s: float) -> list[str]:
    """What does not stay as it is."""
    faults = []
    memory = [mib for minute in minutes[1:] for mib in minute.memory_mib]
    if np.ptp(memory) > MOST_MIB:
        faults.append(f"memory varies by {np.ptp(memory):.1f} MiB")
    first, last = (float(np.median(minute.latency_ms)) for minute in (minutes[1], minutes[-1]))
    if last > MOST_GROWTH * first + MOST_MORE_MS:
        faults.append(f"latency grew from {first:.1f} to {last:.1f} ms")
    if min(sum(m.watched[k] for m in minutes) for k in (0, 1)) < minutes_s:
        faults.append("a viewer was shown less than one image a second")
    return faults


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--rate-hz", type=float, default=20.0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        camera = Path(folder, "camera.toml")
        camera.write_text(camera_toml(drawn.CAMERA))
        command = [str(Path(sys.executable).with_name("motorcade")), "live", "--no-open"]
        command += ["--board", drawn.BOARD.name, "--camera", str(camera)]
        command += ["--record", str(Path(folder, "session"))]
        server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            assert server.stdout is not None
            link = next(line.split()[1] for line in server.stdout if line.startswith("Open "))
            filmed(0, 1), felt()
            visits = Visits(link, arguments.rate_hz)
            minutes_s = 60.0 * arguments.minutes
            middle_s, end_s = visits.began_s + 0.5 * minutes_s, visits.began_s + minutes_s
            filming = threading.Thread(target=visits.film, args=(middle_s,), daemon=True)
            filming.start()
            time.sleep(2.0)
            for which in (0, 1):
                threading.Thread(target=visits.watch, args=(which,), daemon=True).start()
            while time.monotonic() < end_s:
                visits.now().memory_mib.append(memory_mib(server.pid))
                if not filming.is_alive() and time.monotonic() > middle_s + CUT_S:
                    filming = threading.Thread(target=visits.film, args=(end_s,), daemon=True)
                    filming.start()
                    middle_s = end_s
                time.sleep(1.0)
        finally:
            server.send_signal(signal.SIGINT)
            server.wait(120.0)
    visits.open.close()
    minutes = [minute for minute in visits.minutes if minute.memory_mib]
    for number, minute in enumerate(minutes, 1):
        print(f"minute {number:2}  {minute.line()}")
    print(minutes[-1].said)
    faults = faults_of(minutes, minutes_s)
    print("\n".join(faults) or "it stays as it is")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
