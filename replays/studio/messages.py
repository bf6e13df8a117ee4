"""Messages of browsers: replies and news, and fields that are checked one by one.

What a browser sends may be anything.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np

from motorcade.animation.authoring.poses import Frame
from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True)
class Answer:
    """What a message leads to: a reply, and news to all others where something changed."""

    reply: Mapping[str, Any]
    news: Mapping[str, Any] | None = None


def parsed(text: str) -> Mapping[str, Any]:
    """A message of JSON.

    Raises ValueError: no JSON, no object, a number that is none.

    >>> from motorcade.replays.studio.messages import parsed
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
    if axes not in get_args(Frame):
        raise ValueError("in: expected local, parent or global")
    return axes  # type: ignore[no-any-return]


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
