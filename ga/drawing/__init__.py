"""Pictures of multivectors, versors and paths: SVG for reports, and HTML that turns by the mouse.

`show` draws Python values, `draw_script` what a CLUScript marks with ``:``. `shapes` finds out what
objects look like, `marks` makes dots, strokes and faces of that, `writing` projects these, puts
them in order and writes them. Needs NumPy only.

    >>> from motorcade.ga.algebra import conformal
    >>> from motorcade.ga.drawing import show
    >>> picture = show(ball=conformal.sphere([0.0, 0.0, 1.0], 1.0), at=conformal.point([2, 0, 0]))
    >>> picture
    Drawing(ball: sphere, at: point)
    >>> picture.svg().startswith("<svg ")
    True
"""

from __future__ import annotations

from motorcade.ga.drawing.picture import Drawing, Styled, show
from motorcade.ga.drawing.script import draw_script

__all__ = ["Drawing", "Styled", "draw_script", "show"]
