"""Sheets as SVG, in millimetres: one file a sheet."""

from __future__ import annotations

from xml.sax.saxutils import escape

from motorcade.replays.printing.sheets import Sheet

_THIN_MM = 0.15


def sheet_svg(sheet: Sheet) -> bytes:
    """Write a sheet as an SVG of its true size; browsers and Inkscape print it so at 100 %.

    >>> from motorcade.replays.printing import lay_out, paper_named
    >>> from motorcade.replays.printing.svg import sheet_svg
    >>> from motorcade.tracking import SingleMarker
    >>> sheet_svg(lay_out([SingleMarker("tag36h11", 3, 0.08)], paper_named("a4"))[0])[:49]
    b'<svg xmlns="http://www.w3.org/2000/svg" width="21'
    """
    width, height = sheet.paper.width_mm, sheet.paper.height_mm
    shapes = " ".join(
        "M" + "L".join(f"{x:.6g},{y:.6g}" for x, y in shape) + "Z" for shape in sheet.outlines
    )
    lines = " ".join(f"M{a[0]:.6g},{a[1]:.6g}L{b[0]:.6g},{b[1]:.6g}" for a, b in sheet.lines)
    words = "\n".join(
        f'<text x="{one.x_mm:.6g}" y="{one.y_mm:.6g}" font-size="{one.size_mm:.6g}">'
        f"{escape(one.text)}</text>"
        for one in sheet.words
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
        f'viewBox="0 0 {width:g} {height:g}">\n'
        f'<path fill="#fff" d="M0,0H{width:g}V{height:g}H0Z"/>\n'
        f'<path fill-rule="evenodd" d="{shapes}"/>\n'
        f'<path fill="none" stroke="#000" stroke-width="{_THIN_MM}" d="{lines}"/>\n'
        f'<g font-family="Helvetica, Arial, sans-serif">\n{words}\n</g>\n</svg>\n'
    ).encode()
