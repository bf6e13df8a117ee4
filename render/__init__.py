"""Offscreen images: scenes drawn by OpenGL, characters set into footage, video, plots.

Frames: a world is right-handed with z up, in metres. ``world_T_camera`` has OpenCV's camera axes
(x right, y down, z ahead); pixel (0, 0) is the centre of the top-left pixel. Light travels along
`Sun.direction`. Depths are metres along the optical axis, 0 where nothing was drawn.

Units: images are uint8 sRGB with rows from the top, layers have their colour premultiplied by
alpha; light is linear, and a sun of π lights white paper to white.

A half transparent red layer over a grey photograph:

>>> import numpy as np
>>> from motorcade import render
>>> photograph = np.full((2, 3, 3), 100, np.uint8)
>>> red = np.tile(np.array([128, 0, 0, 128], np.uint8), (2, 3, 1))
>>> render.over(photograph, render.Layer(red, np.ones((2, 3), np.float32)))[0, 0]
array([198,  71,  71], dtype=uint8)

`new_renderer` draws surfaces, `render_overlay` sets a character into every frame of footage; both
need a headless OpenGL, and raise `RenderUnavailable` where there is none. What is here is used
most; the packages below hold the rest: `motorcade.render.light`, `plots`, `video`. Everything loads
when it is first used.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
