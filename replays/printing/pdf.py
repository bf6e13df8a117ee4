"""Sheets as the pages of one PDF."""

from __future__ import annotations

import io
from collections.abc import Sequence

from motorcade.replays.printing.sheets import Sheet

_POINTS_PER_MM = 72.0 / 25.4
_THIN_MM = 0.15
_EVEN_ODD = 0


def sheets_pdf(sheets: Sequence[Sheet]) -> bytes:
    """Write sheets as a PDF of their true sizes; the same sheets give the same bytes.

    >>> from motorcade.replays.printing import lay_out, paper_named
    >>> from motorcade.replays.printing.pdf import sheets_pdf
    >>> from motorcade.tracking import SingleMarker
    >>> sheets_pdf(lay_out([SingleMarker("tag36h11", 3, 0.08)], paper_named("a4")))[:5]
    b'%PDF-'
    """
    from reportlab.pdfgen.canvas import Canvas

    file = io.BytesIO()
    canvas = Canvas(file, invariant=1, pageCompression=1)
    canvas.setTitle(", ".join(board.name for sheet in sheets for board in sheet.boards)[:200])
    canvas.setViewerPreference("PrintScaling", "None")
    for sheet in sheets:
        width, height = sheet.paper.width_mm, sheet.paper.height_mm
        canvas.setPageSize((width * _POINTS_PER_MM, height * _POINTS_PER_MM))
        canvas.scale(_POINTS_PER_MM, _POINTS_PER_MM)
        path = canvas.beginPath()
        for shape in sheet.outlines:
            path.moveTo(shape[0, 0], height - shape[0, 1])
            for x, y in shape[1:]:
                path.lineTo(x, height - y)
            path.close()
        canvas.drawPath(path, stroke=0, fill=1, fillMode=_EVEN_ODD)
        canvas.setLineWidth(_THIN_MM)
        canvas.lines([(a[0], height - a[1], b[0], height - b[1]) for a, b in sheet.lines])
        for one in sheet.words:
            canvas.setFont("Helvetica", one.size_mm)
            canvas.drawString(one.x_mm, height - one.y_mm, one.text)
        canvas.showPage()
    canvas.save()
    return file.getvalue()
