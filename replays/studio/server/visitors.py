"""The browsers in one scene: messages taken in turn, replies, and news to the others."""

from __future__ import annotations

import asyncio
import itertools
import json
import logging
from collections.abc import Mapping
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from motorcade.replays.studio.server.bounds import MessageRate
from motorcade.replays.studio.server.offers import Desk

log = logging.getLogger("motorcade.studio")

MAX_UNSENT = 256
"""A browser that lets so many messages lie is taken for gone, and can come back."""
_END = ""


def parsed(text: str) -> Mapping[str, Any]:
    """A message of JSON.

    Raises:
        ValueError: no JSON, no object, a number that is none.

    >>> from motorcade.replays.studio.server.visitors import parsed
    >>> parsed('{"n": 1, "do": "undo"}')
    {'n': 1, 'do': 'undo'}
    """
    try:
        found = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as fault:
        raise ValueError("expected a message of JSON") from fault
    if not isinstance(found, dict):
        raise ValueError(f"expected an object of JSON, got {type(found).__name__}")
    return found


def _no_number(text: str) -> float:
    raise ValueError(f"expected a number, got {text}")


class Visitors:
    """The browsers that have one scene open."""

    def __init__(self) -> None:
        self._unsent: dict[int, asyncio.Queue[str]] = {}
        self._numbers = itertools.count(1)

    def __len__(self) -> int:
        return len(self._unsent)

    async def serve(self, socket: WebSocket, desk: Desk) -> None:
        """Take one browser's messages until it goes, or asks for too much."""
        visitor = next(self._numbers)
        unsent = self._unsent[visitor] = asyncio.Queue(MAX_UNSENT)
        sending = asyncio.create_task(_send(socket, unsent))
        try:
            self._put(visitor, desk.joined(visitor))
            await self._listen(socket, desk, visitor)
        except WebSocketDisconnect:
            log.debug("browser %d went", visitor)
        finally:
            self._unsent.pop(visitor, None)
            sending.cancel()
            self._tell_others(visitor, desk.left(visitor))

    async def _listen(self, socket: WebSocket, desk: Desk, visitor: int) -> None:
        rate = MessageRate()
        while visitor in self._unsent:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text")
            if text is None:
                await socket.close(1003, "expected text")
                return
            await asyncio.sleep(0)  # others are heard between two messages that wait
            if not rate.takes():
                await socket.close(1008, "too many messages")
                return
            try:
                given = parsed(text)
                answer = desk.answer(visitor, given)
            except ValueError as fault:
                self._put(visitor, {"n": None, "ok": False, "error": str(fault)})
                continue
            self._put(visitor, answer.reply)
            self._tell_others(visitor, answer.news)

    def _tell_others(self, visitor: int, news: Mapping[str, Any] | None) -> None:
        if news is not None:
            for other in [one for one in self._unsent if one != visitor]:
                self._put(other, news)

    def _put(self, visitor: int, message: Mapping[str, Any]) -> None:
        unsent = self._unsent.get(visitor)
        if unsent is None:
            return
        try:
            unsent.put_nowait(json.dumps(message, separators=(",", ":")))
        except asyncio.QueueFull:
            log.debug("browser %d does not read", visitor)
            while not unsent.empty():
                unsent.get_nowait()
            unsent.put_nowait(_END)


async def _send(socket: WebSocket, unsent: asyncio.Queue[str]) -> None:
    """Send what is put there, until the end."""
    while (text := await unsent.get()) != _END:
        await socket.send_text(text)
    await socket.close(1013, "this browser was too slow; load the page again")
