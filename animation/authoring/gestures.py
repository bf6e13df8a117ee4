"""Gestures: what was done to a scene, one a line of JSON, each one step of the history.

A line is a drag with the amounts that it went through since it began, an edit, several of both
that are one step, where anchors stand from here on, or a step back or forth::

    {"object": "cup", "do": "rotate", "axis": [0, 0, 1], "amounts_rad": [0.1, 0.3]}
    {"object": "cup", "do": "translate", "axis": [1, 0, 0], "frame": "global", "amounts_m": [0.2]}
    {"object": "cup", "do": "scale", "factors": [1.1, 1.3]}
    {"object": "cup", "do": "similarity", "frame": "parent", "time_s": 1.5, "similarities": [[…]]}
    {"do": "copy", "object": "cup", "name": "mug"}
    {"do": "together", "gestures": [{"do": "copy", …}, {"object": "mug", "do": "translate", …}]}
    {"do": "anchors", "world_T_anchor": {"table": […]}}
    {"do": "undo"}

A similarity is its 12 coefficients.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from motorcade.animation.authoring.drags import FRAMES, KINDS, Amount, Drag
from motorcade.animation.authoring.edits import EDITS, Edit
from motorcade.animation.authoring.fields import (
    listed,
    number,
    object_name,
    read_json_lines,
    short,
    table,
    vector,
)
from motorcade.ga import Similarity

MOST_GESTURES = 1_000_000
_MOST_TOGETHER = 10_000
_WORDS = (*KINDS, *EDITS, "together", "anchors", "undo", "redo")
_AMOUNTS = {
    "rotate": "amounts_rad",
    "translate": "amounts_m",
    "scale": "factors",
    "similarity": "similarities",
}


@dataclass(frozen=True, eq=False)
class Dragged:
    """A drag with what it went through.

    Args:
        drag: what is done.
        amounts: since the drag began, in the order in which it went through them; the last counts.

    Raises:
        ValueError: no amount, or one that the drag refuses.

    >>> from motorcade.animation.authoring import Drag, Dragged
    >>> Dragged(Drag("cup", "scale"), (1.5,)).as_json()
    {'object': 'cup', 'do': 'scale', 'factors': [1.5]}
    """

    drag: Drag
    amounts: tuple[Amount, ...]

    def __post_init__(self) -> None:
        if not self.amounts:
            raise ValueError("Dragged.amounts: expected one or more, got none")
        for amount in self.amounts:
            self.drag.checked(amount)

    def as_json(self) -> dict[str, Any]:
        """Its line."""
        drag = self.drag
        line: dict[str, Any] = {"object": drag.object_name, "do": drag.kind}
        if drag.kind in ("rotate", "translate"):
            line["axis"] = drag.axis.tolist()
        if drag.frame != "local":
            line["frame"] = drag.frame
        if drag.time_s is not None:
            line["time_s"] = float(drag.time_s)
        line[_AMOUNTS[drag.kind]] = [
            amount.coefficients.tolist() if isinstance(amount, Similarity) else float(amount)
            for amount in self.amounts
        ]
        return line


@dataclass(frozen=True, eq=False)
class Together:
    """Drags and edits, one after another, that are one step.

    Args:
        gestures: one or more.

    Raises:
        ValueError: none.
    """

    gestures: tuple[Dragged | Edit, ...]

    def __post_init__(self) -> None:
        if not self.gestures:
            raise ValueError("Together.gestures: expected one or more, got none")

    def as_json(self) -> dict[str, Any]:
        """Its line."""
        return {"do": "together", "gestures": [one.as_json() for one in self.gestures]}


@dataclass(frozen=True, eq=False)
class AnchorsStand:
    """Where anchors stand from here on, as global axes and new parents need it; no step.

    Args:
        world_T_anchor: by name, batch shape ().

    Raises:
        ValueError: a batch.
    """

    world_T_anchor: Mapping[str, Similarity]

    def __post_init__(self) -> None:
        for name, stand in self.world_T_anchor.items():
            if stand.shape != ():
                raise ValueError(
                    f"AnchorsStand: expected one similarity of '{name}', got shape {stand.shape}"
                )
        object.__setattr__(self, "world_T_anchor", MappingProxyType(dict(self.world_T_anchor)))

    def as_json(self) -> dict[str, Any]:
        """Its line."""
        places = {name: one.coefficients.tolist() for name, one in self.world_T_anchor.items()}
        return {"do": "anchors", "world_T_anchor": places}


@dataclass(frozen=True)
class HistoryStep:
    """A step back or forth.

    Args:
        way: undo or redo.

    Raises:
        ValueError: another word.
    """

    way: Literal["undo", "redo"]

    def __post_init__(self) -> None:
        if self.way not in ("undo", "redo"):
            raise ValueError(f"HistoryStep.way: expected undo or redo, got {short(self.way)}")

    def as_json(self) -> dict[str, Any]:
        """Its line."""
        return {"do": self.way}


Gesture = Dragged | Edit | Together | AnchorsStand | HistoryStep


def read_gestures(path: Path) -> list[Gesture]:
    """Read a file of gestures.

    Raises:
        ValueError: a file that cannot be read or is larger than 64 MiB, more than a million
            lines, a line that is no gesture; the message names file, line and field.
    """
    gestures: list[Gesture] = []
    for at, line in read_json_lines(path):
        if len(gestures) == MOST_GESTURES:
            raise ValueError(f"{path}:{at}: expected at most {MOST_GESTURES} gestures, got more")
        gestures.append(gesture_of(line, f"{path}:{at}"))
    return gestures


def gestures_text(gestures: Sequence[Gesture]) -> str:
    """A file of gestures, one a line, as `read_gestures` reads it."""
    lines = (json.dumps(one.as_json(), allow_nan=False) + "\n" for one in gestures)
    return "".join(lines)


def gesture_of(value: object, where: str = "gesture") -> Gesture:
    """A gesture by its line of JSON.

    Raises:
        ValueError: a line that is none; the message begins with `where` and names the field.

    >>> from motorcade.animation.authoring import gesture_of
    >>> gesture_of({"do": "undo"})
    HistoryStep(way='undo')
    """
    if not isinstance(value, dict):
        raise ValueError(f"{where}: expected an object of JSON, got {type(value).__name__}")
    kind = value.get("do")
    try:
        if kind in ("undo", "redo"):
            table(value, "step", ("do",))
            return HistoryStep(kind)
        if kind == "anchors":
            return _anchors(value)
        if kind == "together":
            table(value, "together", ("do", "gestures"))
            rows = listed(value.get("gestures"), "gestures", _MOST_TOGETHER)
            return Together(tuple(_read_gesture(one) for one in rows))
        return _read_gesture(value)
    except (ValueError, TypeError) as fault:
        raise ValueError(f"{where}: {fault}") from fault


def _read_gesture(value: object) -> Dragged | Edit:
    """A drag or an edit."""
    if not isinstance(value, dict):
        raise ValueError(f"expected an object of JSON, got {short(value)}")
    kind = value.get("do")
    if kind not in KINDS:  # whatever JSON holds, lists too
        if kind not in EDITS:
            raise ValueError(f"do: expected one of {', '.join(_WORDS)}, got {short(kind)}")
        return Edit(value)
    key = _AMOUNTS[kind]
    table(value, kind, ("object", "do", "axis", "frame", "time_s", key))
    axis = vector(value.get("axis", [0, 0, 1]), "axis", 3)
    frame, time = value.get("frame", "local"), value.get("time_s")
    if frame not in FRAMES:
        raise ValueError(f"frame: expected local, parent or global, got {short(frame)}")
    drag = Drag(
        object_name(value.get("object"), "object"),
        kind,
        axis,
        frame,
        None if time is None else number(time, "time_s"),
    )
    return Dragged(drag, _amounts(value.get(key), key))


def _amounts(value: object, key: str) -> tuple[Amount, ...]:
    if not isinstance(value, list) or not value:
        raise ValueError(f"{key}: expected a list of one number or more, got {short(value)}")
    if key == "similarities":
        return tuple(_similarity(one, key) for one in value)
    return tuple(number(one, key) for one in value)


def _anchors(fields: dict[str, Any]) -> AnchorsStand:
    table(fields, "anchors", ("do", "world_T_anchor"))
    places = fields.get("world_T_anchor")
    if not isinstance(places, dict) or len(places) > 1000:
        raise ValueError("world_T_anchor: expected at most 1000 similarities by anchor")
    return AnchorsStand(
        {object_name(name, "anchors"): _similarity(one, "anchors") for name, one in places.items()}
    )


def _similarity(value: object, where: str) -> Similarity:
    try:
        return Similarity(vector(value, where, 12))
    except ValueError as fault:
        raise ValueError(f"{where}: {fault}") from fault
