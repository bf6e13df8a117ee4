"""Pictures of CLUScripts: what they mark with ``:``, as CLUCalc draws it.

``:a;``, ``:a = b^c;`` and ``:b^c;`` are drawn as they are there; ``:Red;`` and ``:Color(1, 0, 0);``
colour what follows, ``:IPNS;`` and ``:OPNS;`` say whether what follows is read in inner or in outer
form; before either, in outer form. A script without such marks shows its outputs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from motorcade.ga.algebra import Algebra
from motorcade.ga.drawing.picture import Drawing, Styled, drawing
from motorcade.ga.drawing.shapes.reading import Form, shapes_of
from motorcade.ga.drawing.writing.colors import OBJECT_COLORS, nearest_color
from motorcade.ga.drawing.writing.view import View
from motorcade.ga.script import Script, evaluate
from motorcade.ga.script.reading.syntax import (
    Assignment,
    Call,
    Expression,
    Mark,
    Name,
    Number,
    Screen,
    Statement,
    Unary,
)

_LARGEST_PART = 255.0


@dataclass(frozen=True)
class _Item:
    """What a script draws at one place: the output that holds it, and how it looks."""

    output: str
    name: str
    color: str | None
    form: Form


def draw_script(
    script: Script,
    /,
    algebra: Algebra | None = None,
    *,
    title: str = "",
    view: View | None = None,
    **variables: Any,
) -> Drawing:
    """The picture of a script over values of its free variables, numbers or batches ``(*)``.

    What has no picture (numbers, what lies at infinity) is left out; `Drawing.left_out` says so.

    Raises:
        ScriptError: what `evaluate` refuses.
        ValueError: variables as for `evaluate`, or nothing that can be drawn.

    >>> from motorcade.ga.drawing import draw_script
    >>> from motorcade.ga.script import parse
    >>> text = ":Red; :s = SphereN3(0, 0, 1, 1); :IPNS; :e3 + h*einf;"
    >>> draw_script(parse(text), h=0.5)
    Drawing(s: sphere, plane)
    """
    items, marked = _marked(script)
    made = evaluate(marked, algebra, **variables)
    if not items:
        items = [_Item(name, name, None, _last_form(script)) for name in made]
    drawn, left_out = [], []
    for item in items:
        one = Styled(made[item.output], item.name, item.color, item.form)
        try:
            drawn.append((one, shapes_of(one.value, one.form)))
        except ValueError as refused:
            left_out.append(f"{item.name or 'an expression'} is not drawn: {refused}")
    if not drawn:
        raise ValueError(
            f"{script.source.file}: expected something to draw, got none: "
            f"{'; '.join(left_out) or 'mark objects with : or ?'}"
        )
    return drawing(drawn, title, view, tuple(left_out))


def _marked(script: Script) -> tuple[list[_Item], Script]:
    """The items, and the script with each of them as an output, of names that no text can have."""
    items: list[_Item] = []
    statements: list[Statement] = []
    form, color = "outer", None
    for one in _in_order(script):
        value, name = _drawn(one)
        if isinstance(one, Screen):
            form, color, value = _set(one, form, color)
        else:
            statements.append(one)
        if value is not None:
            output = f":{len(items)}"
            items.append(_Item(output, name, color, "inner" if form == "inner" else "outer"))
            statements.append(Assignment(one.place, "?", output, value))
    return items, replace(script, statements=tuple(statements), screen=())


def _in_order(script: Script) -> Iterator[Statement | Screen]:
    waiting = list(script.screen)
    for index, statement in enumerate(script.statements):
        while waiting and waiting[0].after <= index:
            yield waiting.pop(0)
        yield statement
    yield from waiting


def _drawn(one: Statement | Screen) -> tuple[Expression | None, str]:
    """What a statement draws, by a mark of its own, and its name."""
    if isinstance(one, Assignment | Mark) and one.mark == ":":
        return Name(one.place, one.name), one.name
    return None, ""


def _set(one: Screen, form: str, color: str | None) -> tuple[str, str | None, Expression | None]:
    """Form and colour after a word for the picture, or what is drawn."""
    if one.word in ("IPNS", "OPNS"):
        return ("inner" if one.word == "IPNS" else "outer"), color, None
    if one.word:
        return form, one.word.lower() if one.word.lower() in OBJECT_COLORS else "black", None
    if isinstance(one.value, Call) and one.value.name == "Color":
        parts = [_number(argument) for argument in one.value.arguments[:3]]
        if len(parts) < 3 or None in parts:
            return form, color, None
        largest = 1.0 if max(p for p in parts if p is not None) <= 1.0 else _LARGEST_PART
        return form, nearest_color(*(p / largest for p in parts if p is not None)), None
    return form, color, one.value


def _number(value: Expression) -> float | None:
    if isinstance(value, Unary) and value.operator == "-":
        inside = _number(value.operand)
        return None if inside is None else -inside
    return value.value if isinstance(value, Number) else None


def _last_form(script: Script) -> Form:
    said = [one.word for one in script.screen if one.word in ("IPNS", "OPNS")]
    return "inner" if said and said[-1] == "IPNS" else "outer"
