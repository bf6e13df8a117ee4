"""The browsers in one scene: messages taken in turn, replies, and news to the others.

The runs that are offered are opened when the first browser asks for one. Fields of messages
are checked one by one: what a browser sends may be anything.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import logging
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar, get_args

import numpy as np
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.websockets import WebSocket, WebSocketDisconnect

from motorcade.animation.authoring.poses import Frame
from motorcade.ga.arrays import FloatArray
from motorcade.replays.studio.access import MessageRate, WorkBudget

if TYPE_CHECKING:
    from motorcade.replays.studio.desk import RunDesk


@dataclass(frozen=True)
class Answer:
    """What a message leads to.

    Args:
        reply: to whoever sent it.
        news: to all others; None where nothing changed for them.
    """

    reply: Mapping[str, Any]
    news: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class Offer:
    """A run on the start page.

    Args:
        open: reads it; may take seconds.
        summary: a line on what is in it.
    """

    name: str
    open: Callable[[], RunDesk]
    summary: str = ""


@dataclass
class OpenedOffers:
    """Offers, and the desks of those that were opened."""

    offers: Sequence[Offer]
    _opening: dict[int, asyncio.Task[RunDesk]] = field(default_factory=dict)

    async def desk(self, run: int) -> RunDesk:
        """The desk of a run, opened once for everybody.

        Raises:
            HTTPException: 404 where there is no such run, 503 where it cannot be opened.
        """
        if not 0 <= run < len(self.offers):
            raise HTTPException(404)
        if run not in self._opening:
            opening = run_in_threadpool(self.offers[run].open)
            self._opening[run] = asyncio.ensure_future(opening)
        try:
            return await asyncio.shield(self._opening[run])
        except (ValueError, OSError, RuntimeError) as fault:
            self._opening.pop(run, None)  # it may be there the next time
            raise HTTPException(503, " ".join(str(fault).split())) from fault

    async def close(self) -> None:
        """Close the desks that were opened."""
        for run, opening in self._opening.items():
            try:
                await run_in_threadpool((await opening).close)
            except (ValueError, OSError, RuntimeError) as fault:
                log.warning("%s: %s", self.offers[run].name, fault)


log = logging.getLogger("motorcade.studio")

MAX_UNSENT = 256
"""A browser that lets so many messages lie is taken for gone, and can come back."""
_END = ""
Result = TypeVar("Result")


def parsed(text: str) -> Mapping[str, Any]:
    """A message of JSON.

    Raises:
        ValueError: no JSON, no object, a number that is none.

    >>> from motorcade.replays.studio.visitors import parsed
    >>> parsed('{"n": 1, "do": "undo"}')
    {'n': 1, 'do': 'undo'}
    """
    try:
        document = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as fault:
        raise ValueError("expected a message of JSON") from fault
    if not isinstance(document, dict):
        raise ValueError(f"expected an object of JSON, got {type(document).__name__}")
    return document


def _no_number(text: str) -> float:
    raise ValueError(f"expected a number, got {text}")


class Visitors:
    """The browsers that have one scene open; a thread of its own does what they ask for.

    So the event loop, which hears all runs' browsers, waits for nobody's edit.
    """

    def __init__(self) -> None:
        self._unsent: dict[int, asyncio.Queue[str]] = {}
        self._numbers = itertools.count(1)
        self._present = 0
        self._worker = ThreadPoolExecutor(1, "edits")

    def __len__(self) -> int:
        return self._present

    def close(self) -> None:
        """Wait for what is under way."""
        self._worker.shutdown()

    async def serve(self, socket: WebSocket, desk: RunDesk) -> None:
        """Take one browser's messages until it goes, or asks for too much."""
        visitor, unsent = next(self._numbers), asyncio.Queue[str](MAX_UNSENT)
        self._present += 1
        sending = asyncio.create_task(_send(socket, unsent))
        try:
            hello = await self._work(lambda: _text(desk.joined(visitor)))
            # Others' news from here on: what they did before is in the scene already.
            self._unsent[visitor] = unsent
            self._put(visitor, hello)
            await self._listen(socket, desk, visitor)
        except WebSocketDisconnect:
            log.debug("browser %d went", visitor)
        finally:
            self._present -= 1
            self._unsent.pop(visitor, None)
            sending.cancel()
            with suppress(RuntimeError):  # the server ends, and has nobody left to tell
                leaving = self._work(lambda: _text(desk.left(visitor)))
                leaving.add_done_callback(lambda done: self._tell_others(visitor, done.result()))

    async def _listen(self, socket: WebSocket, desk: RunDesk, visitor: int) -> None:
        rate, budget = MessageRate(), WorkBudget()
        while visitor in self._unsent:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text")
            if text is None:
                await socket.close(1003, "expected text")
                return
            await asyncio.sleep(budget.owed_s())  # others are heard between two that wait
            if not rate.takes():
                await socket.close(1008, "too many messages")
                return
            reply, news, seconds = await self._work(partial(_answered, desk, visitor, text))
            budget.spend(seconds)
            self._put(visitor, reply)
            self._tell_others(visitor, news)

    def _work(self, act: Callable[[], Result]) -> asyncio.Future[Result]:
        """Do something in the thread of this scene, after what was asked for before."""
        return asyncio.get_running_loop().run_in_executor(self._worker, act)

    def _tell_others(self, visitor: int, news: str) -> None:
        if news:
            for other in [number for number in self._unsent if number != visitor]:
                self._put(other, news)

    def _put(self, visitor: int, text: str) -> None:
        unsent = self._unsent.get(visitor)
        if unsent is None:
            return
        try:
            unsent.put_nowait(text)
        except asyncio.QueueFull:
            log.debug("browser %d does not read", visitor)
            while not unsent.empty():
                unsent.get_nowait()
            unsent.put_nowait(_END)


def _answered(desk: RunDesk, visitor: int, text: str) -> tuple[str, str, float]:
    """The reply to a message, the news to others, and the seconds that both took."""
    began = time.thread_time()
    try:
        answer = desk.answer(visitor, parsed(text))
    except ValueError as fault:
        answer = Answer({"n": None, "ok": False, "error": str(fault)})
    return _text(answer.reply), _text(answer.news), time.thread_time() - began


_ENCODER = json.JSONEncoder(separators=(",", ":"))


def _text(message: Mapping[str, Any] | None) -> str:
    """A message as JSON, piece by piece: at once it keeps the interpreter from the event loop."""
    return "" if message is None else "".join(_ENCODER.iterencode(message))


async def _send(socket: WebSocket, unsent: asyncio.Queue[str]) -> None:
    """Send what is put there, until the end."""
    while (text := await unsent.get()) != _END:
        await socket.send_text(text)
    await socket.close(1013, "this browser was too slow; load the page again")


MAX_NAME = 200
_FARTHEST = 1e7
"""Pixels and metres that a message may hold."""


def name_of(message: Mapping[str, Any], key: str) -> str:
    """A name. Raises ValueError: none, or a long one."""
    name = message.get(key)
    if not isinstance(name, str) or not 0 < len(name) <= MAX_NAME:
        raise ValueError(f"{key}: expected a name")
    return name


def frame_of_axes(message: Mapping[str, Any]) -> Frame:
    """Whose axes a handle goes by; the parent's unless told. Raises ValueError: another word."""
    axes = message.get("in", "parent")
    for frame in get_args(Frame):
        if axes == frame:
            return frame  # type: ignore[no-any-return]
    raise ValueError("in: expected local, parent or global")


def number_of(message: Mapping[str, Any], key: str) -> float:
    """A number. Raises ValueError: none, or a huge one."""
    value = message.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < _FARTHEST:
        raise ValueError(f"{key}: expected a number")
    return float(value)


def frame_number(message: Mapping[str, Any], frames: int) -> int:
    """The number of the image that the browser shows; the first where it does not say.

    Raises ValueError: there is no such image.
    """
    number = message.get("frame", 0)
    if type(number) is not int or not 0 <= number < frames:
        raise ValueError(f"frame: expected 0 to {frames - 1}")
    return number


def pixels_of(message: Mapping[str, Any], most: int) -> FloatArray:
    """Pixels ``(N, 2)``, none where the message has none.

    Raises ValueError: something else, or more than so many.
    """
    pixels = message.get("pixels", [])
    if not isinstance(pixels, list) or len(pixels) > most:
        raise ValueError(f"pixels: expected at most {most}")
    return np.array([_numbers(one, "pixels", 2) for one in pixels]).reshape(-1, 2)


def point_of(message: Mapping[str, Any], key: str) -> FloatArray | None:
    """Three numbers, None where there are none. Raises ValueError: something else."""
    point = message.get(key)
    return None if point is None else np.array(_numbers(point, key, 3))


def _numbers(value: object, key: str, count: int) -> list[float]:
    if not isinstance(value, list) or len(value) != count:
        raise ValueError(f"{key}: expected {count} numbers")
    return [number_of({key: one}, key) for one in value]
