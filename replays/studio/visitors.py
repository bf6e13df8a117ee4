"""The browsers in one scene: messages taken in turn, replies, and news to the others.

The runs that are offered are opened when the first browser asks for one.
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
from typing import Any, TypeVar

from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.websockets import WebSocket, WebSocketDisconnect

from motorcade.replays.studio.access import WORK_FREE_S, WORK_SHARE, MessageRate
from motorcade.replays.studio.desk import Offer, RunDesk
from motorcade.replays.studio.messages import Answer, parsed


@dataclass
class OpenedOffers:
    """Offers, and the desks of those that were opened."""

    offers: Sequence[Offer]
    _opening: dict[int, asyncio.Task[RunDesk]] = field(default_factory=dict)

    async def desk(self, run: int) -> RunDesk:
        """The desk of a run, opened once for everybody.

        Raises HTTPException: 404 where there is no such run, 503 where it cannot be opened.
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
        rate, budget = MessageRate(), MessageRate(a_second=WORK_SHARE, at_once=WORK_FREE_S)
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
