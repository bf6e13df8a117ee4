"""Imports, followed name by name to where each is defined: they run one way, and in no circle.

Imports inside functions and those for type checkers alone count as any other.
"""

import ast
import functools
import subprocess
import sys
from pathlib import Path

import pytest

from motorcade.replays.engine import store
from tests.house.sources import SOURCES

pytestmark = SOURCES
REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
BELOW = {
    "ga": (),
    "tracking": ("ga",),
    "fusion": ("ga", "tracking"),
    "animation": ("ga",),
    "render": ("ga", "animation", "tracking"),
    "replays": ("ga", "tracking", "fusion", "animation", "render"),
}

REPLAYS = (
    {"io", "engine", "web"},
    {"stages"},
    {"pipeline", "demo"},
    {"comparison", "tasks", "studio"},
    {"live"},
    {"cli"},
)
"""The parts of that room, from the ground up."""

if not (REPOSITORY / "ga").is_dir():
    pytest.skip("the source tree is not here: a wheel is tested", allow_module_level=True)


def module_of(path: Path) -> str:
    parts = path.relative_to(REPOSITORY).with_suffix("").parts
    return ".".join(("motorcade", *parts)).removesuffix(".__init__")


def used_names(tree: ast.Module, module: str) -> set[store._Use]:
    """Every import of ours, wherever it stands."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {store._Use(alias.name) for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            source = store._source(node, module)
            found |= {store._Use(source, alias.name) for alias in node.names}
    return {use for use in found if use.module.partition(".")[0] == "motorcade"}


@functools.cache
def imports() -> dict[str, set[str]]:
    """The modules of ours that each module imports names of."""
    edges: dict[str, set[str]] = {}
    for room in ROOMS:
        for path in (REPOSITORY / room).rglob("*.py"):
            name = module_of(path)
            uses = {use for tree in store._trees(name) for use in used_names(tree, name)}
            ends = {end for use in uses for end, _ in store._definers(use)}
            edges[name] = ends - {name}
    return edges


def circles(edges: dict[str, set[str]]) -> list[list[str]]:
    """Groups of modules that all lead to each other (Tarjan 1972, without recursion)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []
    for root in sorted(edges):
        if root in index:
            continue
        index[root] = low[root] = len(index)
        stack.append(root)
        path = [(root, iter(sorted(edges[root])))]
        while path:
            name, rest = path[-1]
            for end in rest:
                if end not in edges:
                    continue
                if end not in index:
                    index[end] = low[end] = len(index)
                    stack.append(end)
                    path.append((end, iter(sorted(edges[end]))))
                    break
                if end in stack:
                    low[name] = min(low[name], index[end])
            else:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[name])
                if low[name] == index[name]:
                    group = stack[stack.index(name) :]
                    del stack[stack.index(name) :]
                    if len(group) > 1:
                        found.append(sorted(group))
    return found


def test_no_import_leads_back_to_where_it_began() -> None:
    assert circles(imports()) == []


@pytest.mark.parametrize("room", ROOMS)
def test_names_come_from_rooms_below(room: str) -> None:
    allowed = {room, *BELOW[room]}
    for name, ends in imports().items():
        if name.split(".")[1] == room:
            rooms = {end.split(".")[1] for end in ends if "." in end}
            assert rooms <= allowed, f"{name} imports from {rooms - allowed}"


def test_the_parts_of_replays_stand_on_six_floors_and_no_import_leads_up() -> None:
    places = {place: height for height, floor in enumerate(REPLAYS) for place in floor}
    part = {name: name.split(".")[2] for name in imports() if name.count(".") > 1}
    for name, ends in imports().items():
        if not name.startswith("motorcade.replays."):
            continue
        for end in ends:
            if end.startswith("motorcade.replays.") and part[end] != part[name]:
                assert places[part[end]] < places[part[name]], f"{name} imports {end}, above it"


def test_a_circle_would_be_found() -> None:
    edges = {"a": {"b"}, "b": {"c", "d"}, "c": {"a"}, "d": {"e"}, "e": {"d"}, "f": {"a"}}
    assert sorted(circles(edges)) == [["a", "b", "c"], ["d", "e"]]
    assert circles({"a": {"b"}, "b": {"c"}, "c": set()}) == []


def test_imports_in_functions_and_for_type_checkers_are_seen() -> None:
    tree = ast.parse(
        "from typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    from motorcade.ga import Motor\n"
        "def work():\n    from motorcade.ga import Rotor\n    import json\n"
    )
    names = {use.name for use in used_names(tree, "motorcade.tracking.pose")}
    assert names == {"Motor", "Rotor"}


@pytest.mark.parametrize(
    "module", ["motorcade.tracking.pose", "motorcade.replays.pipeline.report.images"]
)
def test_modules_that_a_package_leads_back_to_can_be_imported_first(module: str) -> None:
    """Packages run on the way to a module: what they import must not need it yet."""
    subprocess.run([sys.executable, "-c", f"import {module}"], check=True)
