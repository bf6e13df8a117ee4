"""`motorcade.ga.compile` and `show`, whose modules are read when they are first called."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from motorcade.ga.algebra import CGA3, Algebra

if TYPE_CHECKING:
    from motorcade.ga.codegen.functions import CompiledFunction
    from motorcade.ga.drawing.picture import Drawing
    from motorcade.ga.drawing.reading import Form
    from motorcade.ga.drawing.view import View
    from motorcade.ga.script import Script

__all__ = ["compile", "show"]


def compile(
    source: Callable[..., Any] | Script | str,
    *,
    algebra: Algebra | None = None,
    name: str = "script",
    **blades: str,
) -> CompiledFunction:
    """A function that runs a program: as NumPy source at once, as compiled C when that is ready.

    Args:
        source: a function of multivectors, as `motorcade.ga.codegen.compile_function` takes it, or
            a CLUScript, whose free variables are the parameters in the order of first use and
            whose results come by their names.
        algebra: CGA3 unless given here or by the script's algebra pragma.
        name: of a script, an identifier; a function has its own.
        blades: of a function's parameters, separated by blanks; others are real scalars.

    Raises:
        ScriptError: what is wrong with the script, and where.
        ValueError: a function that cannot be traced, blades for a script.

    >>> from motorcade.ga import compile
    >>> area = compile("?area = (x*e1) ^ (y*e2);")
    >>> area(2.0, y=3.0)["area"]["e1^e2"]
    6.0
    """
    from motorcade.ga.codegen.functions import CompiledFunction, compile_function
    from motorcade.ga.codegen.programs import compile_script
    from motorcade.ga.script import parse

    if callable(source):
        return compile_function(source, algebra=CGA3 if algebra is None else algebra, **blades)
    if blades:
        raise ValueError(
            f"{name}: expected blades of a function's parameters, got some of "
            f"{', '.join(blades)} for a script, whose variables are scalars"
        )
    script = parse(source, name) if isinstance(source, str) else source
    return CompiledFunction(compile_script(script, name, algebra), single=False)


def show(
    *objects: Any, title: str = "", view: View | None = None, form: Form = "inner", **named: Any
) -> Drawing:
    """A picture of multivectors, versors, trajectories and points; see `motorcade.ga.drawing.show`.

    Raises:
        ValueError: no object, or one that cannot be drawn, with its place or name and why.

    >>> from motorcade.ga import Motor, show
    >>> show(pose=Motor.from_translation([1.0, 0.0, 0.0]))
    Drawing(pose: pose)
    """
    from motorcade.ga.drawing.picture import show as drawn

    return drawn(*objects, title=title, view=view, form=form, **named)
