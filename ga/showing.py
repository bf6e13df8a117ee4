"""From values to a picture: `motorcade.ga.show`, whose modules are read when it is first called."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motorcade.ga.drawing.picture import Drawing
    from motorcade.ga.drawing.reading import Form
    from motorcade.ga.drawing.view import View

__all__ = ["show"]


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
