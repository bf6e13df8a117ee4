"""Images of multivectors, versors and paths: SVG for reports, and HTML that turns by the mouse.

`show` draws Python values, `draw_script` what a CLUScript marks with ``:``. `reading` finds what
objects look like, `mark` makes dots, strokes and faces of that, `view` projects these and puts them
in order, `svg` writes them. Needs NumPy only.

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

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from motorcade.ga.algebra import Algebra, Multivector
from motorcade.ga.drawing import svg
from motorcade.ga.drawing.mark import Extent, Mark, extent_of, ground, marks_of, name_of
from motorcade.ga.drawing.reading import Form, shapes_of
from motorcade.ga.drawing.shape import Shape, is_flat
from motorcade.ga.drawing.svg import CYCLE, OBJECT_COLORS, checked_color, nearest_color
from motorcade.ga.drawing.view import Projection, View, projection_of
from motorcade.ga.script import Script, syntax
from motorcade.ga.script.meaning import watched

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


@dataclass(frozen=True)
class Styled:
    """An object of an image, with what stands beside it and how it is read.

    Args:
        value: a multivector, a batch of them, a versor ``(*)``, a `Trajectory`, or points
            ``(*, 3)`` in space or ``(*, 2)`` in the plane.
        name: what is written beside it; nothing if empty.
        color: blue, orange, green, magenta, cyan, red, yellow, white, black; the next one of a
            cycle if None.
        form: whether a conformal object is in inner or in outer form; see `algebra.conformal`.
    """

    value: Any
    name: str = ""
    color: str | None = None
    form: Form = "inner"


@dataclass(frozen=True)
class Object:
    """What of a drawn object is seen: its shapes, in a colour."""

    name: str
    color: str
    shapes: tuple[Shape, ...]


@dataclass(frozen=True, repr=False)
class Drawing:
    """An image: objects, seen from a side. Notebooks show it, turned by the mouse.

    `left_out` tells what could not be drawn, and why.
    """

    objects: tuple[Object, ...]
    title: str
    view: View
    left_out: tuple[str, ...] = ()

    def svg(self) -> str:
        """The image as SVG: text that any browser and report takes as it is."""
        marks, projection = self._placed()
        return svg.document(self.title or repr(self), marks, projection)

    def html(self) -> str:
        """The image as a page of its own that turns by mouse, finger or arrow keys."""
        return svg.whole(self.title or repr(self), self._repr_html_())

    def save(self, path: Path | str) -> None:
        """Write the image, as SVG or HTML by the file's suffix.

        Raises:
            ValueError: another suffix.
        """
        file = Path(path)
        kinds = {".svg": self.svg, ".html": self.html}
        if file.suffix not in kinds:
            raise ValueError(f"{file}: expected a name that ends in .svg or .html")
        file.write_text(kinds[file.suffix](), encoding="utf-8")

    def __repr__(self) -> str:
        shown = [f"{o.name}: {_kinds(o)}" if o.name else _kinds(o) for o in self.objects]
        return f"Drawing({', '.join(shown)})"

    def _repr_html_(self) -> str:
        marks, projection = self._placed()
        return svg.part(self.svg(), marks, projection, self.left_out)

    def _repr_svg_(self) -> str:
        return self.svg()

    def _placed(self) -> tuple[list[Mark], Projection]:
        extent = extent_of([shape for one in self.objects for shape in one.shapes])
        marks = [*self._marks(extent), *ground(extent, flat=self.view.flat)]
        return marks, projection_of(self.view, marks)

    def _marks(self, extent: Extent) -> Iterator[Mark]:
        for owner, drawn in enumerate(self.objects):
            for shape in drawn.shapes:
                yield from marks_of(shape, extent, drawn.color, owner)
        for drawn in self.objects:
            if drawn.name:
                yield name_of(drawn.name, drawn.shapes[-1], extent, "black")


def _kinds(drawn: Object) -> str:
    kinds = [shape.kind for shape in drawn.shapes]
    return kinds[0] if len(kinds) == 1 else f"{len(kinds)} of {', '.join(dict.fromkeys(kinds))}"


def show(
    *objects: Any, title: str = "", view: View | None = None, form: Form = "inner", **named: Any
) -> Drawing:
    """An image of objects; those given by a keyword have that name written beside them.

    Args:
        objects: what `Styled` takes, or `Styled` itself for a colour or form of its own.
        title: what readers who cannot see the image are told; the objects' kinds if empty.
        view: from where, and of how many pixels; an image of the plane looks down on it.
        form: of conformal objects that are no `Styled`: ``inner``, or ``outer``.
        named: objects by their names.

    Raises:
        ValueError: no object, or one that cannot be drawn, with its place or name and why.

    >>> from motorcade.ga import Motor
    >>> from motorcade.ga.algebra import conformal
    >>> from motorcade.ga.drawing import show
    >>> line = conformal.line_through([0, 0, 0], [1, 1, 1])
    >>> ahead = Motor.from_translation([1.0, 0.0, 0.0])
    >>> path = Motor.identity().interpolate(ahead, [0.0, 0.5, 1.0])
    >>> show(line=line, path=path)
    Drawing(line: line, path: path)
    """
    plain = [one if isinstance(one, Styled) else Styled(one, form=form) for one in objects]
    plain += [
        replace(value, name=name) if isinstance(value, Styled) else Styled(value, name, form=form)
        for name, value in named.items()
    ]
    drawn = []
    for place, styled in enumerate(plain):
        try:
            shapes = shapes_of(styled.value, styled.form)
        except ValueError as refused:
            raise ValueError(f"show: {styled.name or f'object {place}'}: {refused}") from refused
        drawn.append((styled, shapes))
    return drawing(drawn, title, view)


def drawing(
    drawn: list[tuple[Styled, list[Shape]]],
    title: str,
    view: View | None,
    left_out: tuple[str, ...] = (),
) -> Drawing:
    """The image of objects that have been read.

    Raises:
        ValueError: none of them, or a colour that is not known.
    """
    if not drawn:
        raise ValueError("show: expected at least one object, got none")
    colors = iter(CYCLE * (1 + len(drawn) // len(CYCLE)))
    objects = tuple(
        Object(
            styled.name,
            next(colors) if styled.color is None else checked_color(styled.color),
            tuple(shapes),
        )
        for styled, shapes in drawn
    )
    flat = all(is_flat(shape) for one in objects for shape in one.shapes)
    return Drawing(objects, title, replace(view or View(), flat=flat), left_out)
