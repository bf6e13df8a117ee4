"""The stage graph: plain typed functions, wired by their parameters' names.

A stage is a function. Each positional parameter is an edge from the stage (or source) of that name,
and its annotation must be that stage's return annotation; `X | None` marks an optional edge, which
carries None where the stage says that it is `Unavailable` on this machine. Keyword-only parameters
are knobs with defaults: the annotation says what one may be, the stage's docstring what it means. A
choice (`first_of`) is an edge from the first of several stages that works; other stages may take
one of these as an optional edge, None where another was chosen.

Outputs are frozen dataclasses, cached under a key made of the content of the inputs, the knobs, and
the code (see `store`); a killed run resumes where it was.
"""

from __future__ import annotations

import logging
import re
import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from motorcade.ga.names import did_you_mean, nearest_name
from motorcade.replays.engine.stage import Choice, GraphError, Stage, Unavailable
from motorcade.replays.engine.store import Computed, StageStore

log = logging.getLogger("motorcade.graph")

Knobs = Mapping[str, Mapping[str, Any]]


class GraphSource(Protocol):
    """What the graph starts from: anything that can say what its content is."""

    def digest(self) -> str:
        """SHA-256 of the content, as hexadecimal digits."""
        ...


@dataclass(frozen=True)
class GraphRun:
    """What a run left.

    Fields:
        outputs: of every stage and source by name; None of stages that were not run.
        unavailable: stages that could not run here, with the reason.
        chosen: the stage that each choice took.
        records: how every output came about, in the order of the stages.

    >>> from motorcade.replays import GraphRun
    >>> outputs = {"text": "banana", "counted": 3, "drawn": None}
    >>> run = GraphRun(outputs, {"drawn": "no OpenGL"}, {}, ())
    >>> [name for name, output in run.outputs.items() if output is not None], run.unavailable
    (['text', 'counted'], {'drawn': 'no OpenGL'})
    """

    outputs: Mapping[str, Any]
    unavailable: Mapping[str, str]
    chosen: Mapping[str, str]
    records: tuple[Computed, ...]


class Graph:
    """Stages wired by name; checked for names, types and cycles when made.

    Args:
        stages: functions and choices, in any order.
        sources: type of each source by its name.

    Raises:
        GraphError: an edge from nowhere or of another type, or stages that depend on each other.

    >>> import tempfile
    >>> from dataclasses import dataclass
    >>> from pathlib import Path
    >>> @dataclass(frozen=True)
    ... class Text:
    ...     letters: str
    ...     def digest(self) -> str: return self.letters
    >>> @dataclass(frozen=True)
    ... class Count:
    ...     value: int
    >>> def counted(text: Text, *, letter: str = "a") -> Count:
    ...     return Count(text.letters.count(letter))
    >>> graph = Graph([counted], {"text": Text})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = graph.run("counted", {"text": Text("banana")}, Path(folder))
    ...     again = graph.run("counted", {"text": Text("banana")}, Path(folder))
    >>> run.outputs["counted"], run.records[0].cached, again.records[0].cached
    (Count(value=3), False, True)
    """

    def __init__(
        self, stages: Sequence[Callable[..., Any] | Choice], sources: Mapping[str, type[Any]]
    ) -> None:
        self.sources = dict(sources)
        choices = [one for one in stages if isinstance(one, Choice)]
        self.choice_of = {stage.name: one for one in choices for stage in one.members.values()}
        self.stages: dict[str, Stage | Choice] = {}
        for entry in stages:
            if isinstance(entry, Choice):
                self.stages |= {stage.name: stage for stage in entry.members.values()}
                self.stages[entry.name] = entry
            else:
                self.stages[entry.__name__] = Stage.of(entry)
        for node in self.stages.values():
            if isinstance(node, Stage):
                for name, kind in node.inputs.items():
                    self._check_edge(node, name, kind)
        self.order = self._sorted()

    def _check_edge(self, stage: Stage, name: str, kind: Any) -> None:
        if name not in self.sources and name not in self.stages:
            known = ", ".join([*self.sources, *self.stages])
            raise GraphError(f"{stage.name} asks for {name!r}; there are: {known}")
        node = self.stages.get(name)
        produced = self.sources[name] if node is None else node.output
        fits = node.takes(kind) if isinstance(node, Choice) else produced == kind
        if not fits:
            raise GraphError(f"{stage.name} takes {name}: {kind}, but {name} gives {produced}")
        if name in self.choice_of and name not in stage.optional:
            raise GraphError(f"{stage.name}.{name}: one of a choice may be missing; allow None")

    def _parents(self, name: str) -> Iterable[str]:
        """What comes before a node; a choice does, where one of its members is asked for."""
        node = self.stages[name]
        yield from node.inputs
        if isinstance(node, Stage):
            yield from (self.choice_of[one].name for one in node.inputs if one in self.choice_of)

    def _sorted(self) -> tuple[str, ...]:
        order: list[str] = []
        state: dict[str, str] = {}

        def visit(name: str, path: tuple[str, ...]) -> None:
            if name in self.sources or state.get(name) == "done":
                return
            if state.get(name) == "open":
                raise GraphError(f"stages depend on each other: {' -> '.join([*path, name])}")
            state[name] = "open"
            for parent in self._parents(name):
                visit(parent, (*path, name))
            state[name] = "done"
            order.append(name)

        for name in self.stages:
            visit(name, ())
        return tuple(order)

    def needed(self, target: str) -> tuple[str, ...]:
        """The stages that `target` needs, itself last, in an order that can be run."""
        if target not in self.stages:
            listed = f"there are: {', '.join(self.order)}{nearest_name(target, self.order)}"
            raise GraphError(f"no stage {target!r}; {listed}")
        wanted = {target}
        for name in reversed(self.order):
            if name in wanted:
                wanted.update(self._parents(name))
        return tuple(name for name in self.order if name in wanted)

    def checked_knobs(self, knobs: Knobs) -> Knobs:
        """`knobs` as given; GraphError naming the stage or knob that does not exist."""
        for name, settings in knobs.items():
            if name not in self.stages:
                raise GraphError(f"no stage {name!r} to set; {did_you_mean(name, self.order)}")
            for knob in settings:
                if knob not in self.stages[name].knobs:
                    advice = did_you_mean(knob, self.stages[name].knobs)
                    raise GraphError(f"{name} has no knob {knob!r}; {advice}")
        return knobs

    def run(
        self,
        target: str,
        sources: Mapping[str, GraphSource],
        cache: Path,
        knobs: Knobs | None = None,
    ) -> GraphRun:
        """Compute `target` and all it needs; take from `cache` what is there already.

        Raises GraphError for unknown stages and knobs, and whatever a stage raises; stages done
        before stay cached. `Unavailable` is passed on only where the stage's output is needed.
        """
        needed = self.needed(target)
        store = StageStore(cache, sources, self.checked_knobs(knobs or {}))
        unavailable: dict[str, str] = {}
        chosen: dict[str, str] = {}
        for name in needed:
            node = self.stages[name]
            try:
                if isinstance(node, Choice):
                    chosen[name] = store.choose(node)
                elif name not in self.choice_of or name == target:
                    store.obtain(node)
            except Unavailable as missing:
                if name == target or not self._may_be_missing(name, needed):
                    raise
                log.warning("%s: left out: %s", name, missing)
                unavailable[name] = str(missing)
                store.leave_out(name)
        return GraphRun(store.outputs, unavailable, chosen, tuple(store.records))

    def _may_be_missing(self, name: str, needed: Sequence[str]) -> bool:
        users = [self.stages[user] for user in needed]
        return all(name in user.optional for user in users if name in user.inputs)


BOX_W, BOX_H, GAP_X, GAP_Y, MARGIN = 132, 40, 56, 26, 16

_STYLE = """
  .box { fill: none; stroke: currentColor; stroke-width: 1.4 }
  .source { stroke-dasharray: 5 3 }
  .edge { fill: none; stroke: currentColor; stroke-width: 1.2; opacity: .65 }
  .optional { stroke-dasharray: 2 4 }
  text { font: 14px system-ui, sans-serif; fill: currentColor; text-anchor: middle }
  svg { color: #223 } @media (prefers-color-scheme: dark) { svg { color: #dde } }
"""


def draw_mermaid(graph: Graph) -> str:
    """The graph as a Mermaid flowchart; dotted edges are optional."""
    lines = ["flowchart LR"]
    lines += [f"    {name}[({name})]" for name in graph.sources]
    lines += [f"    {name}[{name}]" for name in graph.order]
    for name in graph.order:
        for parent in graph.stages[name].inputs:
            arrow = "-.->" if parent in graph.stages[name].optional else "-->"
            lines.append(f"    {parent} {arrow} {name}")
    return "\n".join(lines) + "\n"


def draw_svg(graph: Graph) -> str:
    """The graph as a standalone SVG: columns by distance from the source, dotted edges optional."""
    places = _places(graph)
    width = max(x for x, _ in places.values()) + BOX_W + MARGIN
    height = max(y for _, y in places.values()) + BOX_H + MARGIN
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}"><style>{_STYLE}</style>',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0 0 8 4 0 8z" fill="currentColor"/>'
        "</marker></defs>",
    ]
    for name in graph.order:
        for parent in graph.stages[name].inputs:
            optional = parent in graph.stages[name].optional
            parts.append(_edge(places[parent], places[name], optional=optional))
    for name, (x, y) in places.items():
        kind = "box source" if name in graph.sources else "box"
        parts.append(
            f'<rect class="{kind}" x="{x}" y="{y}" width="{BOX_W}" height="{BOX_H}" rx="9"/>'
            f'<text x="{x + BOX_W / 2:g}" y="{y + BOX_H / 2 + 5:g}">{name}</text>'
        )
    return "\n".join([*parts, "</svg>"]) + "\n"


def _places(graph: Graph) -> dict[str, tuple[int, int]]:
    """Upper left corner of every box: a column a depth, rows centred."""
    depth = dict.fromkeys(graph.sources, 0)
    for name in graph.order:
        depth[name] = 1 + max(depth[parent] for parent in graph.stages[name].inputs)
    columns: dict[int, list[str]] = {}
    for name, column in depth.items():
        columns.setdefault(column, []).append(name)
    tallest = max(map(len, columns.values()))
    places = {}
    for column, names in columns.items():
        top = MARGIN + (tallest - len(names)) * (BOX_H + GAP_Y) // 2
        for row, name in enumerate(names):
            places[name] = (MARGIN + column * (BOX_W + GAP_X), top + row * (BOX_H + GAP_Y))
    return places


def _edge(start: tuple[int, int], end: tuple[int, int], *, optional: bool) -> str:
    x0, y0 = start[0] + BOX_W, start[1] + BOX_H / 2
    x1, y1 = end[0], end[1] + BOX_H / 2
    bend = (x1 - x0) / 2
    kind = "edge optional" if optional else "edge"
    return (
        f'<path class="{kind}" marker-end="url(#tip)" '
        f'd="M{x0} {y0:g}C{x0 + bend:g} {y0:g} {x1 - bend:g} {y1:g} {x1} {y1:g}"/>'
    )


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
