"""Render room: offscreen scenes, characters set into footage, video. OpenGL loads on first use."""

from motorcade.render.backends.choice import RENDERERS, RendererName, new_renderer
from motorcade.render.backends.platform import ContextLost, RenderUnavailable
from motorcade.render.backends.pyrender_backend import OffscreenRenderer
from motorcade.render.backends.renderer import Renderer
from motorcade.render.composite import over
from motorcade.render.overlay import render_overlay
from motorcade.render.scene import Lamp, Layer, Lighting, Sun, Surface
from motorcade.render.video import read_frames, write_video

__all__ = [
    "RENDERERS",
    "ContextLost",
    "Lamp",
    "Layer",
    "Lighting",
    "OffscreenRenderer",
    "RenderUnavailable",
    "Renderer",
    "RendererName",
    "Sun",
    "Surface",
    "new_renderer",
    "over",
    "read_frames",
    "render_overlay",
    "write_video",
]
