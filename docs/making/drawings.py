"""Draws the graph of rooms, from the imports as they are, and the graph of stages, as SVG.

Both without the arrows that go beside others: what is also reached through another one.

    python docs/making/drawings.py

writes `docs/pictures/rooms.svg` and `docs/pictures/stages.svg`; a test holds them current.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from motorcade.replays.engine import drawing
from motorcade.replays.pipeline import pipeline_graph

REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")


def drawings() -> dict[str, str]:
    """The pictures by name, as they ought to be now."""
    graph = pipeline_graph()
    stages = {name: set(stage.inputs) for name, stage in graph.stages.items()}
    rooms = {room: imported(room) for room in ROOMS}
    return {
        "rooms.svg": drawing.svg(graph_of(rooms, {})),
        "stages.svg": drawing.svg(
            graph_of(
                {name: set() for name in graph.sources} | stages,
                {name: stage.optional for name, stage in graph.stages.items()},
            )
        ),
    }


def graph_of(edges: Mapping[str, set[str]], optional: Mapping[str, frozenset[str]]) -> Any:
    """What `drawing` takes for a graph: an arrow leads to each name from those it needs."""
    direct = without_detours(edges)
    order = [name for name in edges if direct[name]]
    return SimpleNamespace(
        sources=[name for name in edges if not direct[name]],
        order=order,
        stages={
            name: SimpleNamespace(
                inputs=sorted(direct[name]), optional=optional.get(name, frozenset())
            )
            for name in order
        },
    )


def imported(room: str) -> set[str]:
    """The other rooms that the modules of a room import."""
    found = set()
    for path in (REPOSITORY / room).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module]
            found |= {name.split(".")[1] for name in names if name.startswith("motorcade.")}
    return found - {room}


def without_detours(imports: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """The same reach with the fewest arrows."""

    def reached(room: str) -> set[str]:
        return set().union(*({other} | reached(other) for other in imports[room]))

    return {
        room: others - set().union(*(reached(other) for other in others))
        for room, others in imports.items()
    }


def main() -> None:
    """Write both pictures."""
    for name, text in drawings().items():
        (REPOSITORY / "docs" / "pictures" / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
