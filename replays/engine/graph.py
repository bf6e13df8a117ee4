"""The stage graph: plain typed functions, wired by their parameters' names.

A stage is a function. Each positional parameter is an edge from the stage (or source) of that name,
and its annotation must be that stage's return annotation; `X | None` marks an optional edge, which
carries None where the stage says that it is `Unavailable` on this machine. Keyword-only parameters
are knobs with defaults. Outputs are frozen dataclasses, cached under a key made of the content of
the inputs, the knobs, and the code (see `provenance`); a killed run resumes where it was.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import logging
import time
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from motorcade.replays.engine import artifacts
from motorcade.replays.engine.progress import working
from motorcade.replays.engine.provenance import code_digest
from motorcade.replays.errors import did_you_mean

log = logging.getLogger("motorcade.graph")

Knobs = Mapping[str, Mapping[str, Any]]


class GraphError(ValueError):
    """The graph is wired wrongly, or asked for something it does not have."""


class StageError(ValueError):
    """A stage cannot work with what it was given; the message names the stage."""


class Unavailable(RuntimeError):
    """Raised by a stage that this machine cannot run; the message says what to install."""


class Source(Protocol):
    """What the graph starts from: anything that can say what its content is."""

    def digest(self) -> str:
        """SHA-256 of the content, as hexadecimal digits."""
        ...


@dataclass(frozen=True)
class Stage:
    """One function of the graph, taken apart."""

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


@dataclass(frozen=True)
class Record:
    """How one stage of a run came to its output: its key, knobs, and the seconds it took then."""

    stage: str
    key: str
    knobs: Mapping[str, str]
    seconds: float
    cached: bool


@dataclass(frozen=True)
class Run:
    """What a run left: every output, how it came about, and which stages could not run here."""

    outputs: Mapping[str, Any]
    unavailable: Mapping[str, str]
    records: tuple[Record, ...]


class Graph:
    """Stages wired by name; checked for names, types and cycles when made."""

    def __init__(
        self, stages: Sequence[Callable[..., Any]], sources: Mapping[str, type[Any]]
    ) -> None:
        self.sources = dict(sources)
        self.stages = {stage.name: stage for stage in map(Stage.of, stages)}
        for stage in self.stages.values():
            for name, kind in stage.inputs.items():
                self._check_edge(stage, name, kind)
        self.order = self._sorted()

    def _check_edge(self, stage: Stage, name: str, kind: Any) -> None:
        if name in self.sources:
            produced = self.sources[name]
        elif name in self.stages:
            produced = self.stages[name].output
        else:
            known = ", ".join([*self.sources, *self.stages])
            raise GraphError(f"{stage.name} asks for {name!r}; there are: {known}")
        if produced != kind:
            raise GraphError(f"{stage.name} takes {name}: {kind}, but {name} gives {produced}")

    def _sorted(self) -> tuple[str, ...]:
        order: list[str] = []
        state: dict[str, str] = {}

        def visit(name: str, path: tuple[str, ...]) -> None:
            if name in self.sources or state.get(name) == "done":
                return
            if state.get(name) == "open":
                raise GraphError(f"stages depend on each other: {' -> '.join([*path, name])}")
            state[name] = "open"
            for parent in self.stages[name].inputs:
                visit(parent, (*path, name))
            state[name] = "done"
            order.append(name)

        for name in self.stages:
            visit(name, ())
        return tuple(order)

    def needed(self, target: str) -> tuple[str, ...]:
        """The stages that `target` needs, itself last, in an order that can be run."""
        if target not in self.stages:
            raise GraphError(f"no stage {target!r}; there are: {', '.join(self.order)}")
        wanted = {target}
        for name in reversed(self.order):
            if name in wanted:
                wanted.update(self.stages[name].inputs)
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
        self, target: str, sources: Mapping[str, Source], cache: Path, knobs: Knobs | None = None
    ) -> Run:
        """Compute `target` and all it needs; take from `cache` what is there already.

        Raises GraphError for unknown stages and knobs, and whatever a stage raises; stages done
        before stay cached. `Unavailable` is passed on only where the stage's output is needed.
        """
        chosen = self.checked_knobs(knobs or {})
        cache.mkdir(parents=True, exist_ok=True)
        artifacts.sweep_unfinished(cache)
        outputs: dict[str, Any] = dict(sources)
        digests = {name: source.digest() for name, source in sources.items()}
        unavailable: dict[str, str] = {}
        records = []
        for name in self.needed(target):
            stage = self.stages[name]
            settings = _settings(stage, chosen.get(name, {}))
            folder = cache / f"{name}-{_key(stage, outputs, digests, settings)}"
            found = artifacts.find_artifact(folder)
            if found:
                log.info("%s: kept from before", name)
            try:
                stored = found or _compute(stage, outputs, settings, folder)
                output = _read(stored, stage, outputs, settings)
            except Unavailable as missing:
                if name == target or not self._may_be_missing(name, target):
                    raise
                log.warning("%s: left out: %s", name, missing)
                unavailable[name], outputs[name], digests[name] = str(missing), None, "none"
                continue
            knobs_as_text = {knob: repr(value) for knob, value in settings.items()}
            records.append(
                Record(name, folder.name, knobs_as_text, stored.seconds, cached=found is not None)
            )
            outputs[name] = output
            digests[name] = stored.digest
        return Run(outputs, unavailable, tuple(records))

    def _may_be_missing(self, name: str, target: str) -> bool:
        users = [self.stages[user] for user in self.needed(target)]
        return all(name in user.optional for user in users if name in user.inputs)


def _strip_none(hint: Any) -> tuple[Any, bool]:
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        present = [part for part in typing.get_args(hint) if part is not types.NoneType]
        if len(present) == 1:
            return present[0], True
    return hint, False


def _settings(stage: Stage, chosen: Mapping[str, Any]) -> dict[str, Any]:
    return {name: chosen.get(name, parameter.default) for name, parameter in stage.knobs.items()}


def _key(
    stage: Stage,
    outputs: Mapping[str, Any],
    digests: Mapping[str, str],
    settings: Mapping[str, Any],
) -> str:
    """Content of the inputs, knobs and code, as the name under which the output is cached."""
    parts = {
        "inputs": {name: digests[name] for name in stage.inputs},
        "knobs": {name: _told(value) for name, value in settings.items()},
        "code": code_digest(stage.function, [outputs[name] for name in stage.inputs]),
        "format": artifacts.FORMAT_VERSION,
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]


def _told(value: Any) -> str:
    """A knob's value as text; of a file its content as well."""
    if isinstance(value, Path) and value.is_file():
        return f"{value!r} {hashlib.sha256(value.read_bytes()).hexdigest()}"
    return repr(value)


def _read(
    stored: artifacts.Stored, stage: Stage, outputs: Mapping[str, Any], settings: Mapping[str, Any]
) -> Any:
    """The output as stored; computed once more where another run took it away just now."""
    try:
        return artifacts.read_artifact(stored, stage.output)
    except artifacts.ArtifactError:
        if artifacts.find_artifact(stored.folder) is not None:
            raise
        again = _compute(stage, outputs, settings, stored.folder)
        return artifacts.read_artifact(again, stage.output)


def _compute(
    stage: Stage, outputs: Mapping[str, Any], settings: Mapping[str, Any], folder: Path
) -> artifacts.Stored:
    log.debug("%s ...", stage.name)
    start = time.perf_counter()
    with artifacts.workspace(folder.parent), working(stage.name):
        try:
            value = stage.function(*(outputs[name] for name in stage.inputs), **settings)
        except (ValueError, OverflowError, MemoryError) as error:
            raise StageError(f"{stage.name}: {error}") from error
        seconds = time.perf_counter() - start
        stored = artifacts.write_artifact(value, folder, seconds)
    log.info("%s: %.1f s", stage.name, seconds)
    return stored
