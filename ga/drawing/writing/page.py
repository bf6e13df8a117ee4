"""Pictures that turn: the SVG with its marks beside it, and the script that draws them anew.

Nothing is asked of anywhere else. Where scripts do not run, the SVG stands as it is.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

from motorcade.ga.drawing.marks.mark import BallMark, Dot, Face, Label, Mark, Stroke
from motorcade.ga.drawing.writing.colors import OBJECT_COLORS, PAPER_COLORS
from motorcade.ga.drawing.writing.view import Projection

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>{title}</title>
<style>
body {{ margin: 1rem; font-family: system-ui, sans-serif; color-scheme: light dark }}
svg {{ max-width: 100%; height: auto }}
</style>
</head>
<body>
{part}</body>
</html>
"""


def part(svg: str, marks: Sequence[Mark], projection: Projection, notes: Sequence[str]) -> str:
    """What a notebook shows: the picture, what was left out of it, and the script."""
    told = "".join(f"<p>{escape(note)}</p>" for note in notes)
    return (
        f'<div class="motorcade-drawing">{svg}{told}'
        f'<script type="application/json">{in_script(scene(marks, projection))}</script>'
        f"<script>{_script()}</script></div>\n"
    )


def whole(title: str, content: str) -> str:
    """A page of its own."""
    return _PAGE.format(title=escape(title), part=content)


def in_script(value: Any) -> str:
    """JSON that no text in it can end the script of."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def scene(marks: Sequence[Mark], projection: Projection) -> dict[str, Any]:
    """What the script draws: the view, the colours and the marks."""
    view = projection.view
    return {
        "view": [view.azimuth_deg, view.elevation_deg, view.width, view.height, view.flat],
        "objects": OBJECT_COLORS,
        "paper": {name: light for name, (light, _) in PAPER_COLORS.items()},
        "marks": [_mark(mark, 1.0 / projection.scale) for mark in marks],
    }


def _mark(mark: Mark, pixel: float) -> list[Any]:
    if isinstance(mark, Stroke):
        points = _rounded(mark.points, pixel)
        return ["stroke", points, mark.color, mark.width, mark.opacity]
    if isinstance(mark, Face):
        return ["face", _rounded(mark.points, pixel), mark.color, mark.opacity, mark.owner]
    if isinstance(mark, Dot):
        return ["dot", _rounded(mark.point[None], pixel), mark.color, mark.radius, mark.hollow]
    if isinstance(mark, BallMark):
        center = _rounded(mark.center[None], pixel)
        return ["ball", center, mark.color, mark.radius, mark.imaginary]
    assert isinstance(mark, Label)
    return ["name", _rounded(mark.places, pixel), mark.color, mark.text, mark.reach]


def _rounded(points: Any, pixel: float) -> Any:
    """Coordinates to a hundredth of a pixel."""
    unit = 10.0 ** _digits(pixel / 100.0)
    return [[float(f"{round(v / unit) * unit:.12g}") for v in row] for row in points.reshape(-1, 3)]


def _digits(size: float) -> int:
    return math.floor(math.log10(size))


@cache
def _script() -> str:
    return (Path(__file__).parent / "turning.js").read_text(encoding="utf-8")
