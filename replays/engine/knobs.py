"""Knobs as text: `stage.knob=value` from a command line, read by the knob's own annotation."""

from __future__ import annotations

import types
import typing
from collections.abc import Iterable
from typing import Any

from motorcade.replays.engine.graph import Graph, GraphError

LARGEST = 1e9
"""No knob's number is larger than this in any unit that it could have."""


def parse_knobs(settings: Iterable[str], graph: Graph) -> dict[str, dict[str, Any]]:
    """`["fused.gate=0.99", ...]` as {stage: {knob: value}}.

    Raises GraphError where the form, a name or a value is wrong, saying what would be right.
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
            raise GraphError(f"{name}: expected one of {', '.join(arguments)}, came {text!r}")
        return text
    if origin is tuple:
        return tuple(_parse(part.strip(), arguments[0], name) for part in text.split(",") if part)
    if kind is bool:
        if text.lower() not in ("true", "false"):
            raise GraphError(f"{name}: expected true or false, came {text!r}")
        return text.lower() == "true"
    try:
        value = kind(text)
    except ValueError:
        raise GraphError(f"{name}: expected {kind.__name__}, came {text!r}") from None
    if isinstance(value, float) and not abs(value) <= LARGEST:
        raise GraphError(f"{name}: expected a number within ±{LARGEST:g}, came {text!r}")
    return value
