"""Pictures of a stage graph: Mermaid text for documents, SVG for everything else."""

from __future__ import annotations

from motorcade.replays.engine.graph import Graph

BOX_W, BOX_H, GAP_X, GAP_Y, MARGIN = 132, 40, 56, 26, 16

_STYLE = """
  .box { fill: none; stroke: currentColor; stroke-width: 1.4 }
  .source { stroke-dasharray: 5 3 }
  .edge { fill: none; stroke: currentColor; stroke-width: 1.2; opacity: .65 }
  .optional { stroke-dasharray: 2 4 }
  text { font: 14px system-ui, sans-serif; fill: currentColor; text-anchor: middle }
  svg { color: #223 } @media (prefers-color-scheme: dark) { svg { color: #dde } }
"""


def mermaid(graph: Graph) -> str:
    """The graph as a Mermaid flowchart; dotted edges are optional."""
    lines = ["flowchart LR"]
    lines += [f"    {name}[({name})]" for name in graph.sources]
    lines += [f"    {name}[{name}]" for name in graph.order]
    for name in graph.order:
        for parent in graph.stages[name].inputs:
            arrow = "-.->" if parent in graph.stages[name].optional else "-->"
            lines.append(f"    {parent} {arrow} {name}")
    return "\n".join(lines) + "\n"


def svg(graph: Graph) -> str:
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
