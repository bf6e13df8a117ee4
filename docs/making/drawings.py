"""Draws the graph of rooms, from the imports as they are, and the graph of stages, as SVG.

Both without the arrows that go beside others: what is also reached through another one.

    python docs/making/drawings.py

writes `docs/images/rooms.svg`, `docs/images/replays.svg` (the parts of that room) and
`docs/images/stages.svg`; a test holds them current.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from motorcade.replays.engine.graph import draw_svg
from motorcade.replays.pipeline.job import pipeline_graph

REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
# Its parts, from the ground up; `tests/house/test_imports.py` holds their order.
REPLAYS = (
    *("io", "engine", "web", "stages", "pipeline"),
    *("demo", "comparison", "tasks", "studio", "cli"),
)


def drawings() -> dict[str, str]:
    """The images by name, as they ought to be now."""
    graph = pipeline_graph()
    stages = {name: set(stage.inputs) for name, stage in graph.stages.items()}
    return {
        "rooms.svg": draw_svg(graph_of(imported(Path(), ROOMS), {})),
        "replays.svg": draw_svg(graph_of(imported(Path("replays"), REPLAYS), {})),
        "stages.svg": draw_svg(
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


def imported(folder: Path, names: Sequence[str]) -> dict[str, set[str]]:
    """Folders in a folder of the repository, and which of the others the modules of each import."""
    depth = len(folder.parts) + 1
    edges: dict[str, set[str]] = {}
    for name in names:
        uses = set()
        for path in (REPOSITORY / folder / name).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom) and node.module:
                    uses |= {
                        tuple(f"{node.module}.{alias.name}".split(".")) for alias in node.names
                    }
        edges[name] = {
            parts[depth]
            for parts in uses
            if parts[:depth] == ("motorcade", *folder.parts) and parts[depth] in names
        } - {name}
    return edges


def without_detours(imports: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """The same reach with the fewest arrows."""

    def reached(room: str) -> set[str]:
        return set().union(*({other} | reached(other) for other in imports[room]))

    return {
        room: others - set().union(*(reached(other) for other in others))
        for room, others in imports.items()
    }


def main() -> None:
    """Write all images."""
    for name, text in drawings().items():
        (REPOSITORY / "docs" / "images" / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
