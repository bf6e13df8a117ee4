"""The live page's server: one session, the browser's camera or a source, and all who look on.

A camera's frames are answered one by one; of those that come while one is tracked the newest is
kept. Images of a source, or of somebody else's camera, go to a viewer when it has drawn the last.

A frame in: "MLY2", its number (uint32), its stamp (float64, ms), width and height (uint16), how
long the frame before took from capture to drawn (float32, ms; NaN for none), how many readings come
with it (uint32); height × width bytes of luma, rows from the top; the readings of motion sensors
since the frame before, 7 float32 each: stamp after the frame's (ms), angular rate (°/s), specific
force (m/s²). Numbers are little-endian.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import math
import struct
import threading
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import cv2
import numpy as np
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from motorcade.ga.arrays import FloatArray
from motorcade.replays.live.frames import LiveFrame, newest
from motorcade.replays.live.inertial import ImuSample
from motorcade.replays.live.session import LivePlan, LiveSession
from motorcade.replays.studio.access import HEADERS, MAX_EDITORS, Access, Doorkeeper, MessageRate
from motorcade.replays.studio.app import KEPT, Shell, html
from motorcade.replays.studio.messages import parsed
from motorcade.replays.studio.serving import Listening, Notice, address_in_network, serve
from motorcade.tracking.checks import GrayImage

if TYPE_CHECKING:
    from starlette.types import ASGIApp

HEADER = struct.Struct("<4sIdHHfI")
MAGIC = b"MLY2"
SMALLEST_SIDE, MAX_SIDE, MAX_FRAME_PIXELS = 64, 2048, 1 << 21
READING_BYTES, MAX_READINGS = 28, 256
MAX_FRAME_BYTES = MAX_FRAME_PIXELS + HEADER.size + MAX_READINGS * READING_BYTES
MAX_READING = np.array([5000.0, *3 * [4000.0], *3 * [320.0]])
"""ms from the frame; °/s and m/s² beyond what sensors of phones measure."""
READINGS_A_SECOND, READINGS_AT_ONCE = 500.0, 1500.0
MAX_DRIFT_S = 60.0
"""By how much a browser's clock and ours may part while it is connected."""
SAME_CLOCK_S = 1.0
"""By how much they may part where a browser that comes back is taken for the one that went."""
_LATEST_MS = 1e13


@dataclass(frozen=True, eq=False)
class CameraFrame:
    """A frame as a browser sent it, by its own clock; `latency_ms` is that of the one before.

    `readings` are ``(n, 7)``: stamp (ms), angular rate (°/s), specific force (m/s²).
    """

    number: int
    stamp_ms: float
    gray: GrayImage
    latency_ms: float | None
    readings: FloatArray


def read_frame(data: bytes) -> CameraFrame:
    """A frame of the bytes of a message.

    Raises ValueError: another header, sizes out of bounds or not those of the bytes, a stamp or
    readings that are none.

    >>> from motorcade.replays.live.app import HEADER, read_frame
    >>> head = HEADER.pack(b"MLY2", 7, 1000.0, 80, 64, float("nan"), 1)
    >>> frame = read_frame(head + bytes(80 * 64 + 28))
    >>> frame.number, frame.gray.shape, frame.latency_ms, frame.readings[:, 0]
    (7, (64, 80), None, array([1000.]))
    """
    if len(data) < HEADER.size or data[:4] != MAGIC:
        raise ValueError("frame: expected a header of MLY2")
    _, number, stamp_ms, width, height, latency_ms, count = HEADER.unpack_from(data)
    if not (SMALLEST_SIDE <= width <= MAX_SIDE and SMALLEST_SIDE <= height <= MAX_SIDE):
        raise ValueError(
            f"frame: expected sides of {SMALLEST_SIDE} to {MAX_SIDE}, got {width} x {height}"
        )
    if count > MAX_READINGS:
        raise ValueError(f"frame: expected at most {MAX_READINGS} readings, got {count}")
    end = HEADER.size + width * height
    if len(data) != end + count * READING_BYTES:
        raise ValueError(
            f"frame: expected {width * height} bytes of luma and {count} readings of "
            f"{READING_BYTES}, got {len(data) - HEADER.size} bytes"
        )
    if not 0.0 <= stamp_ms < _LATEST_MS:
        raise ValueError("frame: expected a stamp in milliseconds")
    readings = np.frombuffer(data, "<f4", offset=end).reshape(count, 7).astype(float)
    if not np.all(np.abs(readings) <= MAX_READING):
        raise ValueError("frame: expected readings of a motion sensor near its stamp")
    readings[:, 0] += stamp_ms
    luma = np.frombuffer(data, np.uint8, width * height, HEADER.size)
    drawn = latency_ms if math.isfinite(latency_ms) and 0.0 <= latency_ms < 1e5 else None
    return CameraFrame(number, stamp_ms, luma.reshape(height, width), drawn, readings)


@dataclass
class BrowserClock:
    """A browser's stamps, the first at `begun_ns`: they rise, and go as fast as our clock."""

    begun_ns: int
    now_s: float
    last_ns: int = -1
    _first_ms: float = math.nan

    def stamp_ns(self, stamp_ms: float, now_s: float) -> int:
        """Where a stamp is put.

        Raises ValueError: it is not later than the one before, or has jumped.
        """
        if math.isnan(self._first_ms):
            self._first_ms, self.now_s = stamp_ms, now_s
        stamp_ns = self.at(stamp_ms)
        if stamp_ns <= self.last_ns:
            raise ValueError("frame: expected a stamp after the one before")
        if self._drift_s(stamp_ms, now_s) > MAX_DRIFT_S:
            raise ValueError("frame: expected a clock that goes as fast as this one, got a jump")
        self.last_ns = stamp_ns
        return stamp_ns

    def at(self, stamp_ms: float) -> int:
        """Where a moment of the browser's clock is put, once that has begun."""
        return self.begun_ns + round(1e6 * (stamp_ms - self._first_ms))

    def goes_on(self, stamp_ms: float, now_s: float) -> bool:
        """Whether a browser that comes goes by this clock, and is the one that went."""
        fits = self._drift_s(stamp_ms, now_s) < SAME_CLOCK_S
        return fits and self.at(stamp_ms) > self.last_ns

    def _drift_s(self, stamp_ms: float, now_s: float) -> float:
        return abs(1e-3 * (stamp_ms - self._first_ms) - (now_s - self.now_s))


def image_message(about: Mapping[str, Any], jpeg: bytes) -> bytes:
    """An image and what is known of it: the length of JSON (uint32), JSON, JPEG."""
    text = json.dumps(about, separators=(",", ":"), allow_nan=False).encode()
    return struct.pack("<I", len(text)) + text + jpeg


log = logging.getLogger("motorcade.live")

MESSAGES_A_SECOND, MESSAGES_AT_ONCE = 150.0, 300.0
MOST_REFUSED = 50
"""Messages of one visitor that may be refused before it is hung up on."""
SILENT_S = 3.0
"""A browser that films and sent no frame for so long gives way to one that comes."""
FIGURES_EVERY_S = 0.5
DRAWN_WITHIN_S = 1.0
"""A viewer that did not say for so long that it drew an image gets the next all the same."""
MAX_TEXT = 4096
_WITH_CAMERA = HEADERS["permissions-policy"].replace("camera=()", "camera=(self)")


def serve_live(
    plan: LivePlan,
    listening: Listening,
    *,
    open_browser: bool = True,
    out: TextIO | None = None,
) -> None:
    """Serve a live session until it is interrupted.

    For others of the network it is served by https: by `listening.tls`, or a certificate that is
    made now, since browsers give no camera to a page of plain http.

    Raises ValueError, OSError: as `LivePlan.open` and `studio.serving.serve`.
    """
    session, frames = plan.open()
    kept = "" if plan.record is None else f"The session is kept in {plan.record}. "
    notice = Notice("look on, and put the figure elsewhere", f"{kept}Stop with Ctrl-C.")
    with contextlib.ExitStack() as stack:
        stack.callback(session.close)
        if listening.lan and listening.tls is None:
            from motorcade.replays.studio.serving import own_certificate

            tls, fingerprint = stack.enter_context(own_certificate(address_in_network()))
            listening = replace(listening, tls=tls)
            notice = replace(notice, fingerprint=fingerprint)
        serve(
            lambda access: live_app(session, frames, access),
            listening,
            open_browser=open_browser,
            out=out,
            notice=notice,
            max_message_bytes=MAX_FRAME_BYTES,
        )


def live_app(session: LiveSession, frames: Iterator[LiveFrame] | None, access: Access) -> ASGIApp:
    """What is served of a session to those whom `access` admits.

    `frames` of a source are taken from when the first viewer comes; None for a browser's camera.
    """
    site = _Site(session, frames)
    routes = [
        Route("/", site.page),
        Route("/studio/{name}", site.shell.module),
        Route("/figure.glb", site.figure),
        Route("/motion/{number:int}.json", site.motion),
        WebSocketRoute("/live", site.live),
    ]
    return Doorkeeper(Starlette(routes=routes, lifespan=site.lifespan), access)


@dataclass(eq=False)
class _Viewer:
    """A browser that looks on: the newest image that it has not seen."""

    socket: WebSocket
    message: bytes | str | None = None
    changed: asyncio.Event = field(default_factory=asyncio.Event)
    drew: asyncio.Event = field(default_factory=asyncio.Event)
    captured_s: dict[int, float] = field(default_factory=dict)

    def put(self, message: bytes | str, number: int, captured_s: float) -> None:
        self.message = message
        self.captured_s[number] = captured_s
        while len(self.captured_s) > 64:
            del self.captured_s[next(iter(self.captured_s))]
        self.changed.set()

    async def send(self) -> None:
        """Send the newest, each time that the last was drawn, until it goes."""
        while True:
            await self.changed.wait()
            self.changed.clear()
            message, self.message = self.message, None
            if isinstance(message, bytes):
                self.drew.clear()
                await self.socket.send_bytes(message)
                with suppress(TimeoutError):
                    await asyncio.wait_for(self.drew.wait(), DRAWN_WITHIN_S)
            elif message is not None:
                await self.socket.send_text(message)


class _Site:
    """What answers. All that the session does is done in one thread."""

    def __init__(self, session: LiveSession, frames: Iterator[LiveFrame] | None) -> None:
        self.shell = Shell(Path(__file__).parent)
        self._session, self._frames = session, frames
        self._worker = ThreadPoolExecutor(1, "live")
        self._viewers: list[_Viewer] = []
        self._present = 0
        self._camera: WebSocket | None = None
        self._heard_s = 0.0
        self._source: threading.Thread | None = None
        self._ended = threading.Event()
        self._last_s, self._told_s = math.inf, 0.0
        self._clock = BrowserClock(0, 0.0)

    @contextlib.asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        """While the server runs; what is under way at its end is finished."""
        yield
        self._ended.set()
        if self._source is not None:
            await run_in_threadpool(self._source.join, 5.0)
        self._worker.shutdown()

    async def page(self, request: Request) -> Response:
        """The one page; it alone may have a camera."""
        nonce, base = request.scope["nonce"], request.scope["root_path"]
        target = self._session.tracker.target_name
        answer = html(self.shell.page("live.html", base, nonce, target=target))
        answer.headers["permissions-policy"] = _WITH_CAMERA
        return answer

    async def figure(self, _: Request) -> Response:
        """What the figure looks like, as glTF."""
        glb = await run_in_threadpool(lambda: self._session.figure.glb)
        return Response(glb, media_type="model/gltf-binary", headers=KEPT)

    async def motion(self, request: Request) -> Response:
        """What its joints do in a motion."""
        number = request.path_params["number"]
        joints = await self._work(lambda: self._session.figure.joints(number))
        if joints is None:
            raise HTTPException(404)
        return JSONResponse(joints, headers=KEPT)

    async def live(self, socket: WebSocket) -> None:
        """One browser, from when it comes until it goes."""
        await socket.accept()
        if self._present >= MAX_EDITORS:
            await socket.close(1013, f"{MAX_EDITORS} browsers look on already")
            return
        self._present += 1
        viewer = _Viewer(socket)
        films = self._frames is None
        if self._camera is not None:
            films = time.monotonic() - self._heard_s > SILENT_S
        if films:
            if self._camera is not None:  # cut off, and not known to be: nobody waits for it
                closing = self._camera.close(1013, "another browser films now")
                self._closing = asyncio.gather(closing, return_exceptions=True)
            self._camera, self._heard_s = socket, time.monotonic()
        else:
            self._viewers.append(viewer)
        sending = asyncio.create_task(viewer.send())
        try:
            hello = {"hello": "film" if films else "watch"}
            await socket.send_text(json.dumps(hello))
            self._start_source()
            await (self._film(socket) if films else self._listen(viewer))
        except (WebSocketDisconnect, RuntimeError):
            log.debug("a browser went")
        finally:
            self._present -= 1
            sending.cancel()
            if self._camera is socket:
                self._camera = None
            elif not films:
                self._viewers.remove(viewer)

    # A browser's camera --------------------------------------------------------------------------

    async def _film(self, socket: WebSocket) -> None:
        """Track the frames that a browser sends, the newest of those that wait."""
        waiting: list[tuple[CameraFrame, float]] = []
        readings = MessageRate(a_second=READINGS_A_SECOND, at_once=READINGS_AT_ONCE)
        wake, comes = asyncio.Event(), True

        async def track() -> None:
            nonlocal comes
            while True:
                await wake.wait()
                wake.clear()
                frame, came_s = waiting.pop()
                answer = await self._work(partial(self._answer, frame, came_s, comes))
                comes = False
                await socket.send_text(answer)

        async def take(message: Mapping[str, Any]) -> str:
            data = message.get("bytes")
            if data is None:
                return await self._gesture(message.get("text") or "")
            if self._camera is not socket:
                return "another browser films now"
            self._heard_s = time.monotonic()
            try:
                frame = read_frame(data)
            except ValueError as fault:
                return str(fault)
            if not readings.takes(len(frame.readings)):
                return f"frame: expected at most {READINGS_A_SECOND:.0f} readings a second"
            if waiting:  # what was felt meanwhile is not lost with its frame
                since = np.concatenate([waiting[-1][0].readings, frame.readings])
                frame = replace(frame, readings=since[-MAX_READINGS:])
            waiting[:] = [(frame, self._heard_s)]
            wake.set()
            return ""

        tracking = asyncio.create_task(track())
        try:
            await _hear(socket, take)
        finally:
            tracking.cancel()

    def _answer(self, sent: CameraFrame, came_s: float, comes: bool) -> str:
        """The pose of a frame that a browser sent, as text; in the session's thread.

        `comes` says that it is the first of a connection. A browser that was cut off goes on by its
        clock; another's is put after it, and nothing is known of how its sensors sit.
        """
        if sent.latency_ms is not None:
            self._session.measure.drawn(1e-3 * sent.latency_ms)
        if comes and not self._clock.goes_on(sent.stamp_ms, came_s):
            since_ns = round(1e9 * max(0.001, came_s - self._last_s))
            self._clock = BrowserClock(self._clock.last_ns + since_ns, came_s)
            self._session.tracker.forget_inertial()
        try:
            time_ns = self._clock.stamp_ns(sent.stamp_ms, came_s)
            self._last_s = came_s
            near = np.abs(sent.readings[:, 0] - sent.stamp_ms) <= MAX_READING[0]
            imu = tuple(
                ImuSample(self._clock.at(row[0]), np.radians(row[1:4]), row[4:])
                for row in sent.readings[near]
            )
            about = self._tracked(LiveFrame(time_ns, sent.gray, came_s, imu), sent.number)
        except ValueError as fault:
            about = {"frame": sent.number, "state": "refused", "why": str(fault), "pose": None}
        return json.dumps(about, separators=(",", ":"), allow_nan=False)

    def _tracked(self, frame: LiveFrame, number: int) -> dict[str, Any]:
        """Track a frame, show it to those who look on, and say what the page draws."""
        pose = self._session.take(frame, number)
        about = {"frame": number, **self._session.shown(pose)}
        now = time.monotonic()
        if now - self._told_s >= FIGURES_EVERY_S:
            self._told_s = now
            about["figures"] = self._session.told()
        if self._viewers:
            image = frame.image if frame.image.ndim == 2 else frame.image[..., ::-1]
            _, jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 85])
            message = image_message(about, jpeg.tobytes())
            for viewer in tuple(self._viewers):
                self._loop.call_soon_threadsafe(viewer.put, message, number, frame.captured_s)
        return about

    # Those who look on ---------------------------------------------------------------------------

    async def _listen(self, viewer: _Viewer) -> None:
        """Hear what a viewer drew, and its gestures."""

        async def take(message: Mapping[str, Any]) -> str:
            text = message.get("text") or ""
            if not (text.startswith("drew ") and text[5:].isdecimal() and len(text) < 20):
                return await self._gesture(text)
            captured_s = viewer.captured_s.pop(int(text[5:]), None)
            viewer.drew.set()
            if captured_s is not None and self._frames is not None:
                self._session.measure.drawn(time.monotonic() - captured_s)
            return ""

        await _hear(viewer.socket, take)

    async def _gesture(self, text: str) -> str:
        """Do what a message says; what was wrong with it, or nothing."""
        if len(text) > MAX_TEXT:
            return f"expected a message of at most {MAX_TEXT} letters"
        try:
            message = parsed(text)
            await self._work(lambda: self._session.gesture(message))
        except ValueError as fault:
            return str(fault)
        return ""

    # The source ----------------------------------------------------------------------------------

    def _start_source(self) -> None:
        self._loop = asyncio.get_running_loop()
        if self._frames is None or self._source is not None:
            return
        self._source = threading.Thread(target=self._run_source, daemon=True, name="source")
        self._source.start()

    def _run_source(self) -> None:
        """Take the source's frames until it ends, and say why it did."""
        assert self._frames is not None  # asked before
        why = "the source has ended"
        try:
            for number, frame in enumerate(newest(self._frames)):
                if self._ended.is_set():
                    return
                self._worker.submit(self._tracked, frame, number).result()
        except Exception as fault:  # a camera that was unplugged ends the source, not the page
            log.debug("source", exc_info=True)
            why = str(fault)
        text = json.dumps({"ended": why})
        for viewer in tuple(self._viewers):
            self._loop.call_soon_threadsafe(viewer.put, text, -1, 0.0)

    def _work(self, act: Any) -> asyncio.Future[Any]:
        return asyncio.get_running_loop().run_in_executor(self._worker, act)


async def _hear(socket: WebSocket, take: Callable[[Mapping[str, Any]], Awaitable[str]]) -> None:
    """Hand on a browser's messages until it goes or asks for too much.

    `take` gives what is wrong with one, which the browser is told; "" for nothing.
    """
    rate, refused = MessageRate(a_second=MESSAGES_A_SECOND, at_once=MESSAGES_AT_ONCE), 0
    while (message := await socket.receive())["type"] != "websocket.disconnect":
        if not rate.takes() or refused > MOST_REFUSED:
            await socket.close(1008, "too many messages")
            return
        if fault := await take(message):
            refused += 1
            await socket.send_text(json.dumps({"error": fault}))
