"""Results of stages: what they depend on besides their inputs, and how they are kept.

`code_digest(function, given)` covers the source of the function's module, of those of the types of
the values that it is given, and of every module of ours that these use, directly or through others,
wherever in the file the import stands; the bytes of compiled modules; templates, shaders and
figures that lie beside them; and the versions of Python and of each foreign package that is
imported.

Names are followed, not packages: ``from motorcade.ga import Motor`` leads through the `__init__`
that lists the name, whether that imports it at once or lazily (an `__init__.pyi` attached by
`lazy_loader`), to the module that defines it. The packages passed on the way count with their own
source; what else they list does not. What stands under ``if TYPE_CHECKING:`` never runs and is left
out: what a value can do stands with its own type, and so do a recording's readers.

The outputs of a run: taken from the cache where they are there, computed and kept otherwise.

A key covers the content of the inputs, the knobs and the code; files that a stage opens are kept
with its output, which holds for as long as they are as they were.

What a stage reads is known only once it has run, so that a key of inputs, knobs and code leads to
several artifacts, each with the files that it was made from. The first one has the key's name.
Where a file of it is in another state now, the next one to look at is named after that state, and
so on. Files that change back lead back to what was made of them.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.metadata
import importlib.util
import json
import logging
import pkgutil
import platform
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

from motorcade.ga.files import UNSETTLED, files_now, files_read, off_record, put_on_record
from motorcade.ga.progress import working
from motorcade.ga.unfinished import remove_unfinished
from motorcade.replays.engine import artifacts
from motorcade.replays.engine.artifacts import Stored, discard_artifact, find_artifact
from motorcade.replays.engine.stage import AUTO, Choice, Chosen, NotOffered, Stage, StageError

OURS = "motorcade"
BESIDE = {".html", ".css", ".js", ".jinja", ".vert", ".frag", ".glsl", ".glb"}
_A_PACKAGE = re.compile(rf"({OURS}(\.\w+)*)\.")
# Source that may hold the start of a template of module names, be it joined of several strings.
_A_TEMPLATE = re.compile(rf"""["']{OURS}(\.\w+)*\.["'{{]""")
_STATEMENTS = (ast.stmt, ast.excepthandler, ast.match_case)


@dataclass(frozen=True)
class Reach:
    """What a module uses, itself included.

    Fields:
        modules: names of our modules that are followed: all that they import counts too.
        faces: names of our packages that are passed on the way; their `__init__` counts alone.
        foreign: top-level names of packages that are not ours, Python's own left out.
    """

    modules: frozenset[str]
    faces: frozenset[str]
    foreign: frozenset[str]


def code_digest(function: Callable[..., Any], values: Iterable[object] = ()) -> str:
    """SHA-256 over all that a function can run on the values given, and the versions beneath."""
    types = {one for value in values for one in types_within(value)}
    used = reach(function.__module__, *sorted({one.__module__ for one in types}))
    content = hashlib.sha256(platform.python_version().encode())
    for name in sorted(used.modules | used.faces):
        content.update(name.encode())
        content.update(hashlib.sha256(_origin(name).read_bytes()).digest())
    for path in sorted({path for name in used.modules for path in _beside(_origin(name).parent)}):
        content.update(path.name.encode())
        content.update(hashlib.sha256(path.read_bytes()).digest())
    for name in sorted(used.foreign):
        content.update(f"{name}={_version(name)}".encode())
    return content.hexdigest()


@functools.cache
def reach(*modules: str) -> Reach:
    """Everything that modules use, directly or through others."""
    followed: set[str] = set()
    faces: set[str] = set()
    foreign: set[str] = set()
    waiting = [name for name in modules if _find(name) is not None]
    while waiting:
        name = waiting.pop()
        if name in followed:
            continue
        followed.add(name)
        faces.update(_parents(name))
        for used in _uses(name):
            if used.module.partition(".")[0] != OURS:
                foreign.add(used.module.partition(".")[0])
                continue
            for target, passed in _definers(used):
                faces.update(passed)
                waiting.append(target)
    outside = foreign - set(sys.stdlib_module_names)
    return Reach(frozenset(followed), frozenset(faces - followed), frozenset(outside))


def types_within(value: object) -> set[type[Any]]:
    """Types of ours among a value and what it holds: fields of dataclasses, and containers."""
    types: set[type[Any]] = set()
    waiting = [value]
    while waiting:
        inner = waiting.pop()
        if isinstance(inner, dict):
            waiting.extend(inner.values())
        elif isinstance(inner, (tuple, list)):
            waiting.extend(inner)
        elif type(inner).__module__.partition(".")[0] == OURS:
            types.add(type(inner))
            if is_dataclass(inner):
                waiting.extend(getattr(inner, field.name) for field in fields(inner))
    return types


@dataclass(frozen=True)
class _Use:
    """One name imported from a module; the module as a whole without a name."""

    module: str
    name: str | None = None


@functools.cache
def _uses(module: str) -> frozenset[_Use]:
    """What stands in import statements of a module, and of a face's `__init__.pyi`."""
    uses: set[_Use] = set()
    for text in _sources(module):
        # Expressions are most of a tree: they are looked at where one may name modules.
        parts = (ast.AST,) if _A_TEMPLATE.search(text) else _STATEMENTS
        uses.update(_imports(ast.parse(text), module, parts))
    return frozenset(uses)


@functools.cache
def _trees(package: str) -> tuple[ast.Module, ...]:
    """What a package's face says, and its stub; trees of all modules would be much to keep."""
    return tuple(ast.parse(text) for text in _sources(package))


def _sources(module: str) -> list[str]:
    """Source of a module, and the stub where that lists what the module loads lazily."""
    origin = _origin(module)
    if origin.suffix != ".py":
        return []
    stub = origin.with_suffix(".pyi")
    files = (origin, stub) if origin.name == "__init__.py" and stub.is_file() else (origin,)
    return [file.read_text(encoding="utf-8") for file in files]


def _imports(tree: ast.Module, module: str, parts: tuple[type[ast.AST], ...]) -> Iterator[_Use]:
    for node in _running(tree, parts):
        if isinstance(node, ast.Import):
            yield from (_Use(alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            source = _source(node, module)
            yield from (_Use(source, alias.name) for alias in node.names)
        elif isinstance(node, ast.JoinedStr):  # import_module(f"motorcade.package.{name}")
            yield from map(_Use, _modules_of_template(node))


def _running(tree: ast.AST, parts: tuple[type[ast.AST], ...] = _STATEMENTS) -> Iterator[ast.AST]:
    """All nodes of some kinds but those that only type checkers see."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            waiting.extend(node.orelse)
            continue
        yield node
        waiting.extend(one for one in ast.iter_child_nodes(node) if isinstance(one, parts))


def _source(node: ast.ImportFrom, module: str) -> str:
    """The module that a from-import names, relative ones included."""
    if not node.level:
        return node.module or ""
    package = module if _is_package(module) else module.rpartition(".")[0]
    return importlib.util.resolve_name("." * node.level + (node.module or ""), package)


def _modules_of_template(node: ast.JoinedStr) -> list[str]:
    start = node.values[0] if node.values else None
    text = start.value if isinstance(start, ast.Constant) else ""
    named = _A_PACKAGE.fullmatch(str(text))
    if named is None or not _is_package(named[1]):
        return []
    folder = str(_origin(named[1]).parent)
    return [f"{named[1]}.{one.name}" for one in pkgutil.iter_modules([folder])]


@functools.cache
def _definers(use: _Use) -> tuple[tuple[str, frozenset[str]], ...]:
    """The modules that give a name its meaning, each with the packages passed on the way there."""
    name = use.name
    if _find(use.module) is None:
        return ()  # a bare folder on the way to a module holds no code of its own
    if name is None or not _is_package(use.module) or _defines(use.module, name):
        return ((use.module, frozenset()),)
    listed = [_definers(one) for one in _listed(use.module, name)]
    definers = [(target, passed | {use.module}) for one in listed for target, passed in one]
    if _find(f"{use.module}.{name}") is not None:
        definers.append((f"{use.module}.{name}", frozenset({use.module})))
    return tuple(definers) or ((use.module, frozenset()),)


def _defines(package: str, name: str) -> bool:
    """Whether a package's `__init__` makes the name itself, or makes names up as they are asked."""
    strings: set[str] = set()
    for node in _trees(package)[0].body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.AsyncFunctionDef)):
            strings.add(node.name)
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            inside = (part for target in targets for part in ast.walk(target))
            strings.update(part.id for part in inside if isinstance(part, ast.Name))
    lazily = len(_trees(package)) > 1
    return name in strings or ("__getattr__" in strings and not lazily)


def _listed(package: str, name: str) -> Iterator[_Use]:
    """Where a package's face has a name from."""
    for tree in _trees(package):
        for node in _running(tree):
            if isinstance(node, ast.Import):
                yield from (_Use(one.name) for one in node.names if one.asname == name)
            elif isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    if name == (alias.asname or alias.name) or alias.name == "*":
                        source = _source(node, package)
                        if source != package:  # else it is the module of that name
                            yield _Use(source, None if alias.name == "*" else alias.name)


def _parents(name: str) -> set[str]:
    """The packages above a module, whose `__init__` runs before it."""
    parts = name.split(".")
    above = (".".join(parts[:end]) for end in range(1, len(parts)))
    return {one for one in above if _find(one) is not None}


@functools.cache
def _beside(folder: Path) -> frozenset[Path]:
    """Templates, shaders and figures beside modules, and in folders there that are no packages."""
    plain = [one for one in folder.iterdir() if one.is_dir() and not (one / "__init__.py").exists()]
    within = [path for place in (folder, *plain) for path in place.iterdir()]
    return frozenset(path for path in within if path.suffix in BESIDE)


def _is_package(name: str) -> bool:
    origin = _find(name)
    return origin is not None and origin.name == "__init__.py"


@functools.cache
def _find(name: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(name)
    except ModuleNotFoundError:
        return None
    return Path(spec.origin) if spec is not None and spec.origin else None


def _origin(name: str) -> Path:
    origin = _find(name)
    if origin is None:
        raise ModuleNotFoundError(f"no source found for module {name}")
    return origin


@functools.cache
def _version(package: str) -> str:
    names = _distributions().get(package, [])
    return "+".join(sorted(f"{name} {importlib.metadata.version(name)}" for name in set(names)))


@functools.cache
def _distributions() -> dict[str, list[str]]:
    return {key: list(value) for key, value in importlib.metadata.packages_distributions().items()}


log = logging.getLogger("motorcade.graph")

_MISSING = "none"


@dataclass(frozen=True)
class Computed:
    """How one stage of a run came to its output.

    Fields:
        stage: its name.
        key: the name of the output in the cache.
        knobs: their values.
        files: those that it opened beside the recording, with the state that they were in.
        seconds: how long it took when it was computed.
        cached: whether that was in an earlier run.
    """

    stage: str
    key: str
    knobs: Mapping[str, str]
    files: Mapping[str, str]
    seconds: float
    cached: bool


@dataclass(frozen=True)
class _NothingFound:
    """Stored in the place of an output where a stage of a choice found nothing."""

    reason: str


class StageStore:
    """Outputs of stages by name, as a run goes on.

    Args:
        cache: the folder of artifacts; made where it is missing.
        knobs: settings by stage and name.
    """

    def __init__(
        self, cache: Path, sources: Mapping[str, Any], knobs: Mapping[str, Mapping[str, Any]]
    ) -> None:
        cache.mkdir(parents=True, exist_ok=True)
        remove_unfinished(cache)
        self.outputs: dict[str, Any] = dict(sources)
        self.records: list[Computed] = []
        self._cache, self._knobs = cache, knobs
        with off_record():  # what they read is in their digests
            self._digests = {name: source.digest() for name, source in sources.items()}

    def obtain(self, stage: Stage) -> None:
        """Have the output of a stage whose inputs are there; raises whatever the stage raises."""
        output, digest = self._find_or_compute(stage)
        if isinstance(output, _NothingFound):
            raise StageError(f"{stage.name}: {output.reason}")
        self._keep(stage.name, output, digest)

    def choose(self, choice: Choice) -> str:
        """Have the output of the first stage of a choice that works; gives that stage's name.

        Raises StageError: none works, or the one that is asked for does not.
        """
        by = self._knobs.get(choice.name, {}).get("by", AUTO)
        for stage in choice.members.values():
            self.leave_out(stage.name)
        if by != AUTO:
            self.obtain(choice.members[by])
            return self._chosen(choice, by, ())
        skipped, lacking = [], []
        for label, stage in choice.members.items():
            try:
                output, digest = self._find_or_compute(stage, choice.skips)
            except NotOffered as reason:
                lacking.append(str(reason))
                continue
            if isinstance(output, _NothingFound):
                log.warning("%s: skipped: %s", stage.name, output.reason)
                skipped.append(f"{label}: {output.reason}")
                continue
            self._keep(stage.name, output, digest)
            return self._chosen(choice, label, tuple(skipped))
        raise StageError(f"{choice.name}: {'; '.join(dict.fromkeys([*skipped, *lacking]))}")

    def _chosen(self, choice: Choice, label: str, skipped: tuple[str, ...]) -> str:
        name = choice.members[label].name
        content = json.dumps([self._digests[name], label, skipped]).encode()
        value = Chosen(self.outputs[name], label, skipped)
        self._keep(choice.name, value, hashlib.sha256(content).hexdigest())
        return name

    def leave_out(self, name: str) -> None:
        """Have nothing of a stage."""
        self._keep(name, None, _MISSING)

    def _keep(self, name: str, output: Any, digest: str) -> None:
        self.outputs[name], self._digests[name] = output, digest

    def _find_or_compute(
        self, stage: Stage, skips: type[Exception] | None = None
    ) -> tuple[Any, str]:
        """Output and digest, cached or computed; `_NothingFound` where it raises what is skipped.

        Raises NotOffered: the stage does, and something is skipped.
        """
        settings = stage.settings(self._knobs.get(stage.name, {}))
        folder, kept = find_kept(self._cache / f"{stage.name}-{self._key(stage, settings)}")
        if kept:
            log.info("%s: kept from before", stage.name)
        stored = kept or self._compute(stage, settings, folder, skips)
        kind = stage.output | _NothingFound
        try:
            output = artifacts.read_artifact(stored, kind)
        except artifacts.ArtifactError:
            if artifacts.find_artifact(stored.folder) is not None:
                raise
            # Another run took it away just now.
            stored = self._compute(stage, settings, folder, skips)
            output = artifacts.read_artifact(stored, kind)
        texts = {knob: repr(value) for knob, value in settings.items()}
        files = {str(path): state for path, state in stored.files.items()}
        name, cached = stored.folder.name, kept is not None
        self.records.append(Computed(stage.name, name, texts, files, stored.seconds, cached))
        return output, stored.digest

    def _key(self, stage: Stage, settings: Mapping[str, Any]) -> str:
        """Content of the inputs, knobs and code, as the name under which outputs are cached."""
        parts = {
            "inputs": {name: self._digests[name] for name in stage.inputs},
            "knobs": {name: repr(value) for name, value in settings.items()},
            "code": code_digest(stage.function, [self.outputs[name] for name in stage.inputs]),
            "format": artifacts.FORMAT_VERSION,
        }
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]

    def _compute(
        self,
        stage: Stage,
        settings: Mapping[str, Any],
        folder: Path,
        skips: type[Exception] | None,
    ) -> artifacts.Stored:
        log.debug("%s ...", stage.name)
        start = time.perf_counter()
        with artifacts.workspace(folder.parent), working(stage.name):
            try:
                with files_read() as files:
                    value = stage.function(*(self.outputs[one] for one in stage.inputs), **settings)
            except (ValueError, OverflowError, MemoryError) as error:
                if skips is None or not isinstance(error, (skips, NotOffered)):
                    raise StageError(f"{stage.name}: {error}") from error
                if isinstance(error, NotOffered):
                    raise
                value = _NothingFound(str(error))
            seconds = time.perf_counter() - start
            stored = artifacts.write_artifact(value, folder, seconds, files)
        log.info("%s: %.1f s", stage.name, seconds)
        if stored.files != files:  # another run was faster, with other files under the same names
            return self._compute(stage, settings, find_kept(folder)[0], skips)
        return stored


def find_kept(folder: Path) -> tuple[Path, Stored | None]:
    """Among the artifacts of a key, the first of which lies in `folder`, the one that holds.

    Its files are put on record, as if they were read here. Where none holds, the place is given
    where one may be stored.
    """
    while (stored := find_artifact(folder)) is not None:
        now = files_now(stored.files)
        if now == stored.files:
            put_on_record(now)
            return folder, stored
        if UNSETTLED in stored.files.values():  # it will never hold
            discard_artifact(stored)
            break
        folder = folder.with_name(_next_name(folder.name, now))
    return folder, None


def holds(stored: Stored | None) -> bool:
    """Whether there is an artifact, and all files that it was made from are as they were."""
    return stored is not None and files_now(stored.files) == stored.files


def _next_name(name: str, files: Mapping[Path, str]) -> str:
    """What an artifact is called that is looked for where another one does not hold."""
    states = sorted((str(path), state) for path, state in files.items())
    digest = hashlib.sha256(json.dumps([name, states]).encode()).hexdigest()
    return f"{name.rpartition('-')[0]}-{digest[:24]}"
