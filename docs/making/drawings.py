"""Draws the graph of rooms, from the imports as they are, and the graph of stages, as SVG.

    python docs/making/drawings.py

writes `docs/pictures/rooms.svg` and `docs/pictures/stages.svg`; a test holds them current.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace

from motorcade.replays.engine import drawing
from motorcade.replays.pipeline import pipeline

REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")


def drawings() -> dict[str, str]:
    """The pictures by name, as they ought to be now."""
    return {"rooms.svg": drawing.svg(rooms()), "stages.svg": drawing.svg(pipeline())}


def rooms() -> SimpleNamespace:
    """The rooms as a graph that can be drawn: an arrow leads to a room that imports the other.

    What a room also reaches through another one has no arrow of its own.
    """
    direct = without_detours({room: imported(room) for room in ROOMS})
    order = [room for room in ROOMS if direct[room]]
    return SimpleNamespace(
        sources=[room for room in ROOMS if not direct[room]],
        order=order,
        stages={
            room: SimpleNamespace(inputs=sorted(direct[room]), optional=frozenset())
            for room in order
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
