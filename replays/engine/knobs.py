"""Knobs as text: what can be set, to what, and what it means; and `stage.knob=value` as read.

A knob's annotation says what it may be, and its stage's docstring what it means.
"""

from __future__ import annotations

import re
import types
import typing
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from motorcade.ga.names import nearest_name
from motorcade.replays.engine.graph import Graph
from motorcade.replays.engine.stage import Choice, GraphError, Stage

LARGEST = 1e9
"""No knob's number is larger than this in any unit that it could have."""
_SENTENCES = re.compile(r"""\n\s*\n|(?:(?<=\.)|(?<=\.\)))\s+(?=[A-Z`("])""")
_TYPES = {bool: "true, false", str: "text"}


@dataclass(frozen=True)
class Knob:
    """One knob as a user is told of it.

    Fields:
        name: as in the stage's signature; it ends in the unit, where there is one.
        values: those allowed where they are few, else the type.
        default: as one would write it behind `--set stage.knob=`.
        meaning: the first sentence of the stage's docstring that names it, or nothing.
    """

    name: str
    values: str
    default: str
    meaning: str


def described_knobs(stage: Stage | Choice) -> tuple[Knob, ...]:
    """The knobs of a stage, in the order of its signature."""
    sentences = _SENTENCES.split(stage.doc)
    return tuple(
        Knob(name, _values(knob.annotation), _typed(knob.default), _meaning(name, sentences))
        for name, knob in stage.knobs.items()
    )


def _values(kind: Any) -> str:
    """What a knob of an annotation may be, as `_parse` reads it."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(
            "none" if part is types.NoneType else _values(part) for part in arguments
        )
    if origin is typing.Literal:
        return ", ".join(arguments)
    if origin is tuple:
        return f"{_values(arguments[0])},{_values(arguments[0])},…"
    return _TYPES.get(kind) or str(kind.__name__).lower()


def _typed(value: Any) -> str:
    """A value as `_parse` reads it."""
    if isinstance(value, tuple):
        return ",".join(map(_typed, value))
    return str(value).lower() if value is None or isinstance(value, bool) else str(value)


def _meaning(name: str, sentences: Iterable[str]) -> str:
    named = re.compile(rf"`{name}(=[^`]*)?`")
    return next((" ".join(text.split()) for text in sentences if named.search(text)), "")


def parse_knobs(settings: Iterable[str], graph: Graph) -> dict[str, dict[str, Any]]:
    """`["fused.gate=0.99", ...]` as {stage: {knob: value}}.

    Raises GraphError where the form, a name or a value is wrong, saying what would be right.

    >>> from motorcade.replays import parse_knobs, pipeline_graph
    >>> parse_knobs(["smoothed.window_s=0.4", "tracked.by=slam"], pipeline_graph())
    {'smoothed': {'window_s': 0.4}, 'tracked': {'by': 'slam'}}
    >>> parse_knobs(["smoothed.width_s=0.4"], pipeline_graph())
    Traceback (most recent call last):
    ...
    motorcade.replays.engine.stage.GraphError: smoothed has no knob 'width_s'; did ...
    """
    knobs: dict[str, dict[str, Any]] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        stage, dot, knob = name.strip().partition(".")
        if not (equals and dot and stage and knob):
            raise GraphError(f"setting {setting!r}: expected stage.knob=value")
        graph.checked_knobs({stage: {knob: text}})
        kind = graph.stages[stage].knobs[knob].annotation
        knobs.setdefault(stage, {})[knob] = _parse(text.strip(), kind, name)
    return knobs


def _parse(text: str, kind: Any, name: str) -> Any:
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        if text.lower() == "none" and types.NoneType in arguments:
            return None
        (present,) = (part for part in arguments if part is not types.NoneType)
        return _parse(text, present, name)
    if origin is typing.Literal:
        if text not in arguments:
            problem = f"{name}: expected one of {', '.join(arguments)}, got {text!r}"
            raise GraphError(problem + nearest_name(text, arguments))
        return text
    if origin is tuple:
        return tuple(_parse(part.strip(), arguments[0], name) for part in text.split(",") if part)
    if kind is bool:
        if text.lower() not in ("true", "false"):
            raise GraphError(f"{name}: expected true or false, got {text!r}")
        return text.lower() == "true"
    try:
        value = kind(text)
    except ValueError:
        raise GraphError(f"{name}: expected {kind.__name__}, got {text!r}") from None
    if isinstance(value, float) and not abs(value) <= LARGEST:
        raise GraphError(f"{name}: expected a number within ±{LARGEST:g}, got {text!r}")
    return value
