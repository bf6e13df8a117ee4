"""Recorded gestures: JSON lines of drags, replayed.

A line is a drag, with the amounts that it went through since it began, or a step back or forth::

    {"object": "cup", "do": "rotate", "axis": [0, 0, 1], "amounts_rad": [0.1, 0.3]}
    {"object": "cup", "do": "translate", "axis": [1, 0, 0], "frame": "global", "amounts_m": [0.2]}
    {"object": "cup", "do": "scale", "factors": [1.1, 1.3]}
    {"do": "undo"}
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from motorcade.animation.authoring.editor import Drag, SceneEditor
from motorcade.animation.authoring.scene import Scene, number, read_json_lines, vector

__all__ = ["Gesture", "read_gestures", "replay"]

MOST_GESTURES = 1_000_000
_AMOUNTS = {"rotate": "amounts_rad", "translate": "amounts_m", "scale": "factors"}


@dataclass(frozen=True, eq=False)
class Gesture:
    """A drag with its amounts, or a step back or forth.

    Args:
        drag: what is done; None for a step.
        amounts: since the drag began, in the order in which it went through them.
        step: which way through the history, where there is no drag.
    """

    drag: Drag | None
    amounts: tuple[float, ...] = ()
    step: Literal["undo", "redo"] = "undo"


def read_gestures(path: Path) -> list[Gesture]:
    """Read a file of gestures.

    Raises:
        ValueError: a file that cannot be read, a line that is no gesture; the message names file,
            line and field.
    """
    lines = read_json_lines(path)
    if len(lines) > MOST_GESTURES:
        raise ValueError(f"{path}: expected at most {MOST_GESTURES} gestures, got {len(lines)}")
    return [_gesture(given, f"{path}:{at}") for at, given in lines]


def replay(editor: SceneEditor, gestures: Iterable[Gesture]) -> Scene:
    """Do what was recorded, amount by amount; returns the scene at the end.

    Raises:
        ValueError: an object that is not there, an amount that the drag refuses.
    """
    for gesture in gestures:
        if gesture.drag is None:
            editor.undo() if gesture.step == "undo" else editor.redo()
            continue
        editor.begin(gesture.drag)
        for amount in gesture.amounts:
            editor.drag_to(amount)
        editor.end()
    return editor.scene


def _gesture(given: Any, where: str) -> Gesture:
    if not isinstance(given, dict):
        raise ValueError(f"{where}: expected an object of JSON, got {type(given).__name__}")
    kind = given.get("do")
    if kind in ("undo", "redo"):
        _only(given, {"do"}, where)
        return Gesture(None, step=kind)
    if kind not in tuple(_AMOUNTS):  # whatever JSON holds, lists too
        raise ValueError(f"{where}: do: expected {', '.join(_AMOUNTS)}, undo or redo, got {kind!r}")
    _only(given, {"object", "do", "axis", "frame", _AMOUNTS[kind]}, where)
    name = given.get("object")
    if not isinstance(name, str):
        raise ValueError(f"{where}: object: expected a name, got {name!r}")
    axis = vector(given.get("axis", [0, 0, 1]), f"{where}: axis", 3)
    amounts = _amounts(given.get(_AMOUNTS[kind]), f"{where}: {_AMOUNTS[kind]}")
    try:
        drag = Drag(name, kind, axis, given.get("frame", "local"))
    except (ValueError, TypeError) as fault:
        raise ValueError(f"{where}: {fault}") from fault
    return Gesture(drag, amounts)


def _amounts(given: object, where: str) -> tuple[float, ...]:
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        raise ValueError(f"{where}: expected a list of one number or more, got {given!r}")
    return tuple(number(one, where) for one in given)


def _only(given: dict[str, Any], known: set[str], where: str) -> None:
    unknown = sorted(set(given) - known)
    if unknown:
        raise ValueError(
            f"{where}: expected fields of {', '.join(sorted(known))}, got {unknown[0]!r}"
        )
