"""Depth images: registered to a colour camera, compared with colour and with each other.

Frames: ``colour_T_depth`` maps the depth camera's coordinates to the colour camera's; both have
OpenCV's axes. Depth is metres along the optical axis of the camera that it belongs to, NaN where
unknown.

A wall 2 m away, seen by a depth camera that sits 25 mm to the left of the colour camera:

>>> import numpy as np
>>> from motorcade.ga import Motor
>>> from motorcade.tracking import Camera
>>> from motorcade.tracking.depth import DepthCamera, register_depth
>>> colour = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
>>> sensor = Camera(640, 480, 585.0, 585.0, 319.5, 239.5)
>>> taken_by = DepthCamera(sensor, Motor.from_translation([-0.025, 0.0, 0.0]))
>>> registered = register_depth(np.full((480, 640), 2.0, np.float32), taken_by, colour)
>>> float(registered[240, 320]), bool(np.isnan(registered[240, 5]))  # the rim is not covered
(2.0, True)
"""

from motorcade.tracking.depth.cameras import DepthCamera, register_depth
from motorcade.tracking.depth.refine import focal_factor

__all__ = [
    "DepthCamera",
    "focal_factor",
    "register_depth",
]
