"""What a graph is made of: stages, which are functions, and choices among several of them."""

from __future__ import annotations

import inspect
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar

Value = TypeVar("Value")

AUTO = "auto"


class GraphError(ValueError):
    """The graph is wired wrongly, or asked for something it does not have."""


class StageError(ValueError):
    """A stage cannot work with what it was given; the message names the stage."""


class Unavailable(RuntimeError):
    """Raised by a stage that this machine cannot run; the message says what to install."""


class NotOffered(ValueError):
    """Raised by a stage of a choice whose input lacks what it works on; the next one is tried."""


@dataclass(frozen=True)
class Chosen(Generic[Value]):
    """What the first of several stages gave that worked.

    Fields:
        value: its output.
        by: what the choice calls that stage.
        skipped: of the stages that were tried before, "name: reason".

    >>> Chosen(3.2, by="laser").value
    3.2
    """

    value: Value
    by: str = ""
    skipped: tuple[str, ...] = ()


@dataclass(frozen=True)
class Stage:
    """One function of the graph, taken apart.

    >>> def halved(number: int, *, times: int = 1) -> int:
    ...     "Halve `times` times."
    ...     return number >> times
    >>> stage = Stage.of(halved)
    >>> stage.name, dict(stage.inputs), list(stage.knobs), stage.output
    ('halved', {'number': <class 'int'>}, ['times'], <class 'int'>)
    """

    name: str
    function: Callable[..., Any]
    inputs: Mapping[str, Any]
    optional: frozenset[str]
    knobs: Mapping[str, inspect.Parameter]
    output: Any

    @classmethod
    def of(cls, function: Callable[..., Any]) -> Stage:
        """Read a stage off a function's signature; GraphError where an annotation is missing."""
        hints = typing.get_type_hints(function)
        inputs: dict[str, Any] = {}
        optional = set()
        knobs = {}
        for parameter in inspect.signature(function).parameters.values():
            if parameter.name not in hints:
                raise GraphError(f"{function.__name__}.{parameter.name}: no type annotation")
            if parameter.kind is parameter.KEYWORD_ONLY:
                knobs[parameter.name] = parameter.replace(annotation=hints[parameter.name])
                continue
            kind, may_be_missing = _strip_none(hints[parameter.name])
            inputs[parameter.name] = kind
            if may_be_missing:
                optional.add(parameter.name)
        name = function.__name__
        return cls(name, function, inputs, frozenset(optional), knobs, hints.get("return"))

    @property
    def doc(self) -> str:
        """The function's docstring, without its indentation."""
        return inspect.getdoc(self.function) or ""

    def settings(self, chosen: Mapping[str, Any]) -> dict[str, Any]:
        """Every knob's value: as chosen, or its default; of files their whole names."""
        return {
            name: from_anywhere(chosen.get(name, knob.default)) for name, knob in self.knobs.items()
        }


def from_anywhere(value: Any) -> Any:
    """A knob's value; of a file its whole name, as a cache may be used from several folders."""
    return value.absolute() if isinstance(value, Path) and value.exists() else value


@dataclass(frozen=True)
class Choice:
    """The first of several stages that works; made by `first_of`.

    Fields:
        name: of the edge that carries what was chosen, as `Chosen`.
        members: stages in the order in which they are tried, by what the choice calls them.
        skips: what a member raises where it finds nothing, so that the next one is tried.
    """

    name: str
    members: Mapping[str, Stage]
    skips: type[Exception]

    @property
    def inputs(self) -> dict[str, Any]:
        """The members by their stages' names, and what they give."""
        return {stage.name: stage.output for stage in self.members.values()}

    @property
    def optional(self) -> frozenset[str]:
        """All members: one of them is enough."""
        return frozenset(self.inputs)

    @property
    def output(self) -> type[Any]:
        """What the edge carries."""
        return Chosen

    @property
    def knobs(self) -> dict[str, inspect.Parameter]:
        """One knob, `by`, that names the member to take."""
        kinds = Literal[(AUTO, *self.members)]  # type: ignore[valid-type]
        kind = inspect.Parameter.KEYWORD_ONLY
        return {"by": inspect.Parameter("by", kind, default=AUTO, annotation=kinds)}

    @property
    def doc(self) -> str:
        """What the choice does, as a stage's docstring would say it."""
        order = ", ".join(stage.name for stage in self.members.values())
        return (
            f"The first of these stages that works: {order}.\n\n"
            "`by=auto` tries them in that order; a name takes that one alone."
        )

    def takes(self, kind: Any) -> bool:
        """Whether every member gives what a consumer annotated with `Chosen[...]` asks for."""
        if typing.get_origin(kind) is not Chosen:
            return False
        (wanted,) = typing.get_args(kind)
        return all(issubclass(stage.output, wanted) for stage in self.members.values())


def first_of(
    name: str, *, skips: type[Exception] = NotOffered, **members: Callable[..., Any]
) -> Choice:
    """Make a choice: the members are tried in order, and the first that works is taken.

    A member that raises `NotOffered` is left out without a word; one that raises `skips` is left
    out with its reason in `Chosen.skipped` and in the log.

    >>> def far(number: int) -> int: return number
    >>> def near(number: int) -> int: return -number
    >>> first_of("measured", far=far, near=near).doc.splitlines()[0]
    'The first of these stages that works: far, near.'
    """
    return Choice(name, {label: Stage.of(member) for label, member in members.items()}, skips)


def _strip_none(hint: Any) -> tuple[Any, bool]:
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        present = [part for part in typing.get_args(hint) if part is not types.NoneType]
        if len(present) == 1:
            return present[0], True
    return hint, False
