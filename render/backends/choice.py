"""Which renderers there are, and one by its name."""

from __future__ import annotations

from typing import Literal, get_args

from motorcade.ga.names import nearest_name
from motorcade.render.backends.fast.renderer import FastRenderer
from motorcade.render.backends.pyrender_backend import OffscreenRenderer
from motorcade.render.backends.renderer import Renderer

RendererName = Literal["fast", "pyrender"]
RENDERERS: tuple[RendererName, ...] = get_args(RendererName)


def new_renderer(name: str, width: int, height: int) -> Renderer:
    """The renderer of a name.

    Args:
        name: one of `RENDERERS`; docs/rendering.md says when to take which.
        width: of the images, pixels.
        height: of the images, pixels.

    Raises:
        ValueError: another name, or a size that is not positive.
        RenderUnavailable: this machine has no OpenGL.

    >>> from motorcade.render import new_renderer
    >>> new_renderer("paper", 640, 480)
    Traceback (most recent call last):
    ValueError: renderer: expected one of fast, pyrender, got 'paper'
    """
    if name == "fast":
        return FastRenderer(width, height)
    if name == "pyrender":
        return OffscreenRenderer(width, height)
    known = ", ".join(RENDERERS)
    near = nearest_name(name, RENDERERS)
    raise ValueError(f"renderer: expected one of {known}, got {name!r}{near}")
