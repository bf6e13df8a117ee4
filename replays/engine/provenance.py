"""What a stage's result depends on besides its inputs: code and the versions that run it.

`code_digest(function)` covers the source of the function's module and of every module of ours that
it imports, directly or through others, wherever in the file the import stands; the bytes of
compiled modules; the templates and shaders that lie beside them; and the versions of Python and of
each foreign package that these modules import.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.metadata
import importlib.util
import platform
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

OURS = "motorcade"
TEXTS = {".html", ".css", ".js", ".jinja", ".vert", ".frag", ".glsl"}


def code_digest(function: Callable[..., Any]) -> str:
    """SHA-256 over all code that `function` can reach by imports, and over the versions beneath."""
    modules, foreign = _reachable(function.__module__)
    content = hashlib.sha256(platform.python_version().encode())
    for name in sorted(modules):
        content.update(name.encode())
        content.update(hashlib.sha256(_origin(name).read_bytes()).digest())
    for path in sorted({path for name in modules for path in _texts(_origin(name).parent)}):
        content.update(path.name.encode())
        content.update(hashlib.sha256(path.read_bytes()).digest())
    for name in sorted(foreign):
        content.update(f"{name}={_version(name)}".encode())
    return content.hexdigest()


@functools.cache
def _reachable(start: str) -> tuple[frozenset[str], frozenset[str]]:
    """Names of our modules and of foreign top-level packages reachable from module `start`."""
    ours: set[str] = set()
    foreign: set[str] = set()
    waiting = [start]
    while waiting:
        name = waiting.pop()
        if name in ours:
            continue
        if _find(name) is None:
            continue  # a bare folder on the way to a module holds no code of its own
        ours.add(name)
        for imported in _imports(name):
            if imported.partition(".")[0] != OURS:
                foreign.add(imported.partition(".")[0])
            elif imported not in ours:
                waiting.append(imported)
    return frozenset(ours), frozenset(foreign - set(sys.stdlib_module_names))


@functools.cache
def _imports(name: str) -> frozenset[str]:
    origin = _origin(name)
    if origin.suffix != ".py":
        return frozenset()
    return frozenset(_imported_names(ast.parse(origin.read_text(encoding="utf-8"))))


def _imported_names(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield from _with_parents(alias.name)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from _with_parents(node.module)
            for alias in node.names:
                candidate = f"{node.module}.{alias.name}"
                if candidate.startswith(f"{OURS}.") and _find(candidate) is not None:
                    yield candidate


def _with_parents(name: str) -> Iterator[str]:
    """A module and, for ours, the packages above it, whose `__init__` runs too."""
    parts = name.split(".")
    if parts[0] != OURS:
        yield name
        return
    for end in range(2, len(parts) + 1):
        yield ".".join(parts[:end])


@functools.cache
def _texts(folder: Path) -> frozenset[Path]:
    """Templates and shaders in a folder of modules, and in its folders that are no packages."""
    plain = [one for one in folder.iterdir() if one.is_dir() and not (one / "__init__.py").exists()]
    within = [path for place in (folder, *plain) for path in place.iterdir()]
    return frozenset(path for path in within if path.suffix in TEXTS)


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
