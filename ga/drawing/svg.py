"""Writes an image as SVG that needs nothing else, on light paper or on dark as the reader has it.

What is written is what ``turning.js`` writes in the browser, number by number. An image that turns
is the SVG with its marks and that script beside it; where scripts do not run it stands as it is.
Colours of objects are chosen to be told apart on light and on dark paper; black and white are the
ink, and a grey.
"""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Sequence
from functools import cache
from html import escape
from itertools import groupby
from pathlib import Path
from typing import Any

from motorcade.ga.arrays import FloatArray
from motorcade.ga.drawing.mark import BallMark, Dot, Face, Label, Mark, Stroke
from motorcade.ga.drawing.view import Placed, Projection, placed

LONGEST_NAME = 40
_LETTER, _WIDE_LETTER, _LINE = 7.4, 13.0, 15.0
_EDGE, _GAP = 3.0, 6.0
_SIDES = ((1, -1), (1, 1), (-1, -1), (-1, 1), (0, -1), (0, 1))
_Box = tuple[float, float, float, float]


def document(title: str, marks: list[Mark], projection: Projection) -> str:
    """The whole SVG.

    Texts are escaped, and shortened where they are longer than `LONGEST_NAME`.
    """
    inside = elements(marks, projection)
    own = f"m{zlib.crc32(inside.encode()):08x}"
    view = projection.view
    group = (
        '<g fill="none" stroke-linecap="round" stroke-linejoin="round" font-size="13" '
        'font-family="system-ui, sans-serif">'
    )
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {view.width} {view.height}" '
        f'width="{view.width}" height="{view.height}" class="{own}" role="img">',
        f"<title>{escaped(title)}</title>",
        f"<style>{_style(own)}</style>",
        f"<defs>{_shades(own)}</defs>",
        f'<rect class="paper" width="{view.width}" height="{view.height}" rx="6" '
        f'fill="{PAPER_COLORS["paper"][0]}"/>',
        # In texts a quotation mark is an entity: this one is an attribute's.
        group + inside.replace('fill="url(#', f'fill="url(#{own}-') + "</g>",
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Any text as text of XML: marked-up characters as entities, those that XML lacks replaced."""
    short = text if len(text) <= LONGEST_NAME else text[: LONGEST_NAME - 1] + "…"
    return escape("".join(letter if _in_xml(ord(letter)) else "�" for letter in short))


def _in_xml(code: int) -> bool:
    return (
        code in (9, 10, 13)
        or 0x20 <= code < 0xD800
        or 0xE000 <= code < 0xFFFE
        or 0x10000 <= code < 0x110000
    )


def _style(own: str) -> str:
    dark = "".join(
        f".{own} .{name}{{fill:{dark}}}.{own} .{name}-line{{stroke:{dark}}}"
        for name, (_, dark) in PAPER_COLORS.items()
    )
    focus = f".{own}:focus{{outline:1px solid {PAPER_COLORS['axis'][0]}}}"
    return f"{focus}@media (prefers-color-scheme:dark){{{dark}}}"


def _shades(own: str) -> str:
    """The shading of balls: a gradient for each colour."""
    colors = OBJECT_COLORS | {"black": PAPER_COLORS["black"][0]}
    return "".join(
        f'<radialGradient id="{own}-{name}" cx=".36" cy=".32" r=".75">'
        f'<stop stop-color="{color}" stop-opacity=".12"/>'
        f'<stop offset="1" stop-color="{color}" stop-opacity=".42"/></radialGradient>'
        for name, color in colors.items()
    )


def elements(marks: list[Mark], projection: Projection) -> str:
    """The marks as elements, in order; neighbours of one look become one path."""
    ordered = placed(marks, projection)
    parts = [_element(list(same)) for _, same in groupby(ordered, _look)]
    boxes: list[_Box] = []
    parts += [_name(mark, projection, boxes) for mark in marks if isinstance(mark, Label)]
    return "".join(parts)


def number(value: float) -> str:
    """A coordinate to a tenth of a pixel.

    >>> from motorcade.ga.drawing.svg import number
    >>> [number(x) for x in (3.0, -0.04, 12.34)]
    ['3', '0', '12.3']
    """
    text = f"{value:.1f}".removesuffix(".0")
    return "0" if text == "-0" else text


def _look(placed: Placed) -> tuple[object, ...]:
    mark = placed.mark
    if isinstance(mark, Stroke):
        return "stroke", mark.color, mark.width, mark.opacity
    if isinstance(mark, Face):
        return "face", mark.color, mark.opacity, mark.owner
    return "alone", id(placed)


def _element(same: list[Placed]) -> str:
    mark = same[0].mark
    if isinstance(mark, Stroke):
        path = "".join(_path(one.points) for one in same)
        faint = f' opacity="{mark.opacity:g}"' if mark.opacity < 1.0 else ""
        return f'<path d="{path}" {_line(mark.color)} stroke-width="{mark.width:g}"{faint}/>'
    if isinstance(mark, Face):
        path = "".join(_path(one.points) + "Z" for one in same)
        crisp = 'shape-rendering="crispEdges"'
        return f'<path d="{path}" {_fill(mark.color)} opacity="{mark.opacity:g}" {crisp}/>'
    x, y = (number(value) for value in same[0].points[0, :2])
    if isinstance(mark, Dot):
        ring = (_fill("paper"), _line(mark.color)) if mark.hollow else (
            _fill(mark.color), _line("paper"))  # fmt: skip
        width = 1.8 if mark.hollow else 1.2
        return (
            f'<g {ring[1]} stroke-width="{width:g}"><circle cx="{x}" cy="{y}" r="{mark.radius:g}" '
            f"{ring[0]}/></g>"
        )
    return _ball(mark, same[0].near, x, y, same[0].radius) if isinstance(mark, BallMark) else ""


def _ball(mark: BallMark, near: bool, x: str, y: str, radius: float) -> str:
    circle = f'<circle cx="{x}" cy="{y}" r="{number(radius)}"'
    if mark.imaginary:
        return f'{circle} {_line(mark.color)} stroke-width="1.6" stroke-dasharray="5 5"/>'
    if near:
        return f'{circle} fill="url(#{mark.color})" {_line(mark.color)} stroke-width="1.2"/>'
    return f'{circle} {_fill(mark.color)} opacity="0.1"/>'


def _path(points: FloatArray) -> str:
    first, *others = (f"{number(x)} {number(y)}" for x, y in points[:, :2])
    return f"M{first}L{' '.join(others)}"


def _line(color: str) -> str:
    if color in PAPER_COLORS:
        return f'class="{color}-line" stroke="{PAPER_COLORS[color][0]}"'
    return f'stroke="{OBJECT_COLORS[color]}"'


def _fill(color: str) -> str:
    if color in PAPER_COLORS:
        return f'class="{color}" fill="{PAPER_COLORS[color][0]}"'
    return f'fill="{OBJECT_COLORS[color]}"'


def _name(mark: Label, projection: Projection, boxes: list[_Box]) -> str:
    """A name where it fits beside its object; numbers of axes that fit nowhere are left out."""
    text = mark.text if len(mark.text) <= LONGEST_NAME else mark.text[: LONGEST_NAME - 1] + "…"
    width = sum(_LETTER if ord(letter) < 128 else _WIDE_LETTER for letter in text)
    off = mark.reach * projection.scale * 0.7071 + _GAP
    tried: list[_Box] = []
    for x, y, _ in projection.place(mark.places):
        for side, up in _SIDES:
            left = x + side * off - (width if side < 0 else 0.0 if side > 0 else width / 2)
            top = y + up * off - (_LINE if up < 0 else 0.0) - (0.5 * _GAP * up if side else 0.0)
            tried.append((left, top, left + width, top + _LINE))
    view = projection.view
    free = [box for box in tried if _within(box, view.width, view.height) and _clear(box, boxes)]
    if not free and mark.color == "axis":
        return ""
    left, top, right, bottom = free[0] if free else _moved_in(tried[0], view.width, view.height)
    boxes.append((left, top, right, bottom))
    return (
        f'<g {_line("paper")} stroke-width="3" paint-order="stroke">'
        f'<text x="{number(left)}" y="{number(bottom - 3.5)}" {_fill(mark.color)}>'
        f"{escaped(text)}</text></g>"
    )


def _within(box: _Box, width: float, height: float) -> bool:
    return (
        box[0] >= _EDGE and box[1] >= _EDGE and box[2] <= width - _EDGE and box[3] <= height - _EDGE
    )


def _clear(box: _Box, boxes: list[_Box]) -> bool:
    return all(box[2] < b[0] or b[2] < box[0] or box[3] < b[1] or b[3] < box[1] for b in boxes)


def _moved_in(box: _Box, width: float, height: float) -> _Box:
    right = max(0.0, box[2] + _EDGE - width)
    left = max(0.0, _EDGE - box[0] + right)
    down = max(0.0, box[3] + _EDGE - height)
    up = max(0.0, _EDGE - box[1] + down)
    return box[0] - right + left, box[1] - down + up, box[2] - right + left, box[3] - down + up


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
    """What a notebook shows: the image, what was left out of it, and the script."""
    text = "".join(f"<p>{escape(note)}</p>" for note in notes)
    return (
        f'<div class="motorcade-drawing">{svg}{text}'
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


OBJECT_COLORS = {
    "blue": "#3a7fd5",
    "orange": "#e07a1f",
    "green": "#2f9e57",
    "magenta": "#c2459f",
    "cyan": "#1798a8",
    "red": "#d8453e",
    "yellow": "#b8930f",
    "white": "#8d98a5",
}
# On light paper, and on dark.
PAPER_COLORS = {
    "paper": ("#ffffff", "#161b22"),
    "black": ("#1f2933", "#e6edf3"),
    "axis": ("#6b7785", "#8b98a6"),
    "grid": ("#e3e7ec", "#2a323c"),
}
CYCLE = tuple(OBJECT_COLORS)[:7]


def checked_color(name: str) -> str:
    """The name of a colour in small letters. Raises ValueError: no colour of ours."""
    small = name.lower() if isinstance(name, str) else ""
    if small not in OBJECT_COLORS and small != "black":
        known = ", ".join([*OBJECT_COLORS, "black"])
        raise ValueError(f"color: expected {known}, got {name!r}")
    return small


def nearest_color(red: float, green: float, blue: float) -> str:
    """The colour of ours that is nearest to one with parts from 0 to 1."""
    pure = {
        "blue": (0, 0, 1), "orange": (1, 0.5, 0), "green": (0, 1, 0), "magenta": (1, 0, 1),
        "cyan": (0, 1, 1), "red": (1, 0, 0), "yellow": (1, 1, 0), "white": (1, 1, 1),
        "black": (0, 0, 0),
    }  # fmt: skip
    return min(
        pure,
        key=lambda name: sum(
            (a - b) ** 2 for a, b in zip(pure[name], (red, green, blue), strict=True)
        ),
    )
