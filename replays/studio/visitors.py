"""The browsers in one scene: messages taken in turn, replies, and news to the others.

Fields of messages, checked one by one: what a browser sends may be anything.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import logging
from collections.abc import Mapping
from typing import Any, get_args

import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect

from motorcade.animation.authoring.poses import Frame
from motorcade.ga.arrays import FloatArray
from motorcade.replays.studio.access import MessageRate
from motorcade.replays.studio.offers import Desk

log = logging.getLogger("motorcade.studio")

MAX_UNSENT = 256
"""A browser that lets so many messages lie is taken for gone, and can come back."""
_END = ""


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
                request = parsed(text)
                answer = desk.answer(visitor, request)
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
