"""Runs of the tests in forked processes: measured once, then over one mutant each.

A source file is never written: in the child a finder hands out the mutated module instead. Tests
that start another Python run the real module there.
"""

from __future__ import annotations

import ast
import contextlib
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import multiprocessing
import os
import resource
import signal
import sys
from collections.abc import Callable, Generator, Iterable, Sequence
from math import ceil
from multiprocessing.connection import Connection
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

import pytest

__all__ = ["Watch", "forked", "import_others", "install", "module_name", "run_tests"]

_MOST_MEMORY = 16 << 30
# How much longer than its processor time a run may take beside others.
_PATIENCE = 10.0
# Hypothesis is among what was imported beforehand.
_QUIET = ["-q", "-p", "no:cacheprovider", "-m", "not slow"]
_QUIET += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]


class Watch:
    """Keeps the tests that were chosen, in their order; notes their processor time and failures."""

    def __init__(self, chosen: Sequence[str] | None = None) -> None:
        self.seconds: dict[str, float] = {}
        self.failed: list[str] = []
        self._rank = None if chosen is None else {name: k for k, name in enumerate(chosen)}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        rank = self._rank
        if rank is not None:
            kept = [item for item in items if item.nodeid in rank]
            items[:] = sorted(kept, key=lambda item: rank[item.nodeid])

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.failed.append(report.nodeid)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        start = sum(os.times()[:4])
        answer = yield
        self.seconds[item.nodeid] = sum(os.times()[:4]) - start
        return answer

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed.append(report.nodeid)


def run_tests(watch: Watch, *arguments: str) -> int:
    """What `pytest` ends with; all that it prints is dropped."""
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
        return int(pytest.main([*_QUIET, *arguments], plugins=[watch]))


def forked(work: Callable[[], Any], seconds: float) -> Any:
    """What the work gives, in a child process that may take so much of a processor's time.

    Raises:
        TimeoutError: nothing came in ten times as long; the child and all its own are ended.
        ChildProcessError: the child died, or the work raised what the message says.
    """
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    child = context.Process(target=_send, args=(work, ceil(seconds), there))
    child.start()
    there.close()
    try:
        if not here.poll(_PATIENCE * seconds):
            raise TimeoutError(f"nothing came in {_PATIENCE * seconds:.0f} s")
        found, raised = here.recv()
        if raised is not None:
            raise ChildProcessError(raised)
        return found
    except EOFError as gone:
        raise ChildProcessError("the child died") from gone
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid or 0, signal.SIGKILL)
        child.join()


def _send(work: Callable[[], Any], seconds: int, there: Connection) -> None:
    os.setsid()
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
    try:
        answer = (work(), None)
    except Exception as raised:
        answer = (None, f"{type(raised).__name__}: {raised}")
    there.send(answer)


def module_name(path: Path) -> str:
    """Import name of a source file of a room, given from the repository's root."""
    parts = path.with_suffix("").parts
    return ".".join(("motorcade", *(parts[:-1] if parts[-1] == "__init__" else parts)))


class _Mutated(importlib.machinery.SourceFileLoader):
    """Loads one module from another text than its file's."""

    def __init__(self, name: str, path: str, text: str) -> None:
        super().__init__(name, path)
        self._text = text

    def get_code(self, fullname: str) -> CodeType:
        return compile(self._text, self.path, "exec", dont_inherit=True)


class _Finder(importlib.abc.MetaPathFinder):
    def __init__(self, path: Path, text: str) -> None:
        self._name, self._path, self._text = module_name(path), path.resolve(), text

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname != self._name:
            return None
        folder = [str(self._path.parent)] if self._path.stem == "__init__" else None
        loader = _Mutated(fullname, str(self._path), self._text)
        return importlib.util.spec_from_file_location(
            fullname, self._path, loader=loader, submodule_search_locations=folder
        )


def install(path: Path, text: str) -> None:
    """From now on this process imports the module of a file from the given text.

    Raises:
        RuntimeError: the module was imported before.
    """
    if module_name(path) in sys.modules:
        raise RuntimeError(f"install(path): {path} was imported before")
    sys.meta_path.insert(0, _Finder(path, text))


def import_others(files: Iterable[Path]) -> None:
    """Import what these files import, but for our own rooms: every fork then has it at once."""
    names = {name for file in files for name in _imported(ast.parse(file.read_text("utf-8")))}
    for name in sorted(names):
        if name.split(".")[0] not in ("motorcade", "tests", "conftest"):
            with contextlib.suppress(ImportError):  # the tests that need it skip
                importlib.import_module(name)


def _imported(tree: ast.Module) -> Iterable[str]:
    for node in tree.body:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
