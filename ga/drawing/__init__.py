"""Images of multivectors, versors and paths: SVG for reports, and HTML that turns by the mouse.

`show` draws Python values, `draw_script` what a CLUScript marks with ``:``. `shapes` finds out what
objects look like, `marks` makes dots, strokes and faces of that, `writing` projects these, puts
them in order and writes them. Needs NumPy only.

    >>> from motorcade.ga.algebra import conformal
    >>> from motorcade.ga.drawing import show
    >>> image = show(ball=conformal.sphere([0.0, 0.0, 1.0], 1.0), at=conformal.point([2, 0, 0]))
    >>> image
    Drawing(ball: sphere, at: point)
    >>> image.svg().startswith("<svg ")
    True

Images of CLUScripts: what they mark with ``:``, as CLUCalc draws it.

``:a;``, ``:a = b^c;`` and ``:b^c;`` are drawn as they are there; ``:Red;`` and ``:Color(1, 0, 0);``
colour what follows, ``:IPNS;`` and ``:OPNS;`` say whether what follows is read in inner or in outer
form; before either, in outer form. In a branch they count where it is taken, for those of several
values that take it; in a loop in each round. A script without such marks shows its outputs.
"""

from __future__ import annotations

from typing import Any

from motorcade.ga.algebra import Algebra, Multivector
from motorcade.ga.drawing.image import Drawing, Styled, drawing, show
from motorcade.ga.drawing.reading import Form, shapes_of
from motorcade.ga.drawing.svg import OBJECT_COLORS, nearest_color
from motorcade.ga.drawing.view import View
from motorcade.ga.script import Script
from motorcade.ga.script.meaning import watched
from motorcade.ga.script.reading import syntax

__all__ = ["Drawing", "Styled", "draw_script", "show"]


MAX_DRAWN = 1000
_LARGEST_PART = 255.0


def draw_script(
    script: Script,
    /,
    algebra: Algebra | None = None,
    *,
    title: str = "",
    view: View | None = None,
    **variables: Any,
) -> Drawing:
    """The image of a script over values of its free variables, numbers or batches ``(*)``.

    What has no image (numbers, what lies at infinity) is left out; `Drawing.left_out` says so.

    Raises:
        ScriptError: what `evaluate` refuses.
        ValueError: variables as for `evaluate`, or nothing that can be drawn.

    >>> from motorcade.ga.drawing import draw_script
    >>> from motorcade.ga.script import parse
    >>> text = ":Red; :s = SphereN3(0, 0, 1, 1); :IPNS; :e3 + h*einf;"
    >>> draw_script(parse(text), h=0.5)
    Drawing(s: sphere, plane)
    """
    marked = _Marked(script)
    results = watched(script, marked, algebra, variables)
    outputs = [Styled(x, name, None, marked.form) for name, x in results.items()]
    drawn, left_out = [], []
    for item in marked.items or outputs:
        try:
            drawn.append((item, shapes_of(item.value, item.form)))
        except ValueError as refused:
            left_out.append(f"{item.name or 'an expression'} is not drawn: {refused}")
    if not drawn:
        raise ValueError(
            f"{script.source.file}: expected something to draw, got none: "
            f"{'; '.join(left_out) or 'mark objects with : or ?'}"
        )
    return drawing(drawn, title, view, tuple(left_out))


class _Marked:
    """What a script draws, each with its name, colour and form, while the script runs."""

    def __init__(self, script: Script) -> None:
        self._script = script
        self._color: str | None = None
        self.form: Form = "outer"
        self.items: list[Styled] = []

    def __call__(
        self, step: syntax.Assignment | syntax.Mark | syntax.Screen, value: Multivector | None
    ) -> None:
        """Take a mark that is run: a word if it has no value."""
        if value is None:
            if isinstance(step, syntax.Screen):
                self._set(step)
            return
        if len(self.items) >= MAX_DRAWN:
            raise self._script.source.error(
                step.place, f"expected at most {MAX_DRAWN} objects to draw", "draw fewer rounds"
            )
        name = "" if isinstance(step, syntax.Screen) else step.name
        self.items.append(Styled(value, name, self._color, self.form))

    def _set(self, screen: syntax.Screen) -> None:
        """Form and colour after a word for the image."""
        if screen.word in ("IPNS", "OPNS"):
            self.form = "inner" if screen.word == "IPNS" else "outer"
        elif screen.word == "Color" and isinstance(screen.value, syntax.Call):
            parts = [_number(argument) for argument in screen.value.arguments[:3]]
            known = [part for part in parts if part is not None]
            if len(known) == 3:
                largest = 1.0 if max(known) <= 1.0 else _LARGEST_PART
                self._color = nearest_color(*(part / largest for part in known))
        else:
            self._color = screen.word.lower() if screen.word.lower() in OBJECT_COLORS else "black"


def _number(value: syntax.Expression) -> float | None:
    if isinstance(value, syntax.Unary) and value.operator == "-":
        inside = _number(value.operand)
        return None if inside is None else -inside
    return value.value if isinstance(value, syntax.Number) else None
