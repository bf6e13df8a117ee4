"""Fields of messages, checked one by one: what a browser sends may be anything."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

import numpy as np

from motorcade.animation.authoring.poses import Frame
from motorcade.ga.arrays import FloatArray

MAX_NAME = 200
_FARTHEST = 1e7
"""Pixels and metres that a message may hold."""


def name_of(message: Mapping[str, Any], key: str) -> str:
    """A name.

    Raises:
        ValueError: none, or a long one.
    """
    found = message.get(key)
    if not isinstance(found, str) or not 0 < len(found) <= MAX_NAME:
        raise ValueError(f"{key}: expected a name")
    return found


def frame_of_axes(message: Mapping[str, Any]) -> Frame:
    """Whose axes a handle goes by; the parent's unless told.

    Raises:
        ValueError: another word.
    """
    found = message.get("in", "parent")
    for frame in get_args(Frame):
        if found == frame:
            return frame  # type: ignore[no-any-return]
    raise ValueError("in: expected local, parent or global")


def number_of(message: Mapping[str, Any], key: str) -> float:
    """A number.

    Raises:
        ValueError: none, or a huge one.
    """
    found = message.get(key)
    if isinstance(found, bool) or not isinstance(found, int | float) or not abs(found) < _FARTHEST:
        raise ValueError(f"{key}: expected a number")
    return float(found)


def frame_number(message: Mapping[str, Any], frames: int) -> int:
    """The number of the picture that the browser shows; the first where it does not say.

    Raises:
        ValueError: there is no such picture.
    """
    found = message.get("frame", 0)
    if type(found) is not int or not 0 <= found < frames:
        raise ValueError(f"frame: expected 0 to {frames - 1}")
    return found


def pixels_of(message: Mapping[str, Any], most: int) -> FloatArray:
    """Pixels ``(N, 2)``, none where the message has none.

    Raises:
        ValueError: something else, or more than so many.
    """
    found = message.get("pixels", [])
    if not isinstance(found, list) or len(found) > most:
        raise ValueError(f"pixels: expected at most {most}")
    return np.array([_numbers(one, "pixels", 2) for one in found]).reshape(-1, 2)


def point_of(message: Mapping[str, Any], key: str) -> FloatArray | None:
    """Three numbers, None where there are none.

    Raises:
        ValueError: something else.
    """
    found = message.get(key)
    return None if found is None else np.array(_numbers(found, key, 3))


def _numbers(given: object, key: str, count: int) -> list[float]:
    if not isinstance(given, list) or len(given) != count:
        raise ValueError(f"{key}: expected {count} numbers")
    return [number_of({key: one}, key) for one in given]
