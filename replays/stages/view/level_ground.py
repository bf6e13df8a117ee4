"""A floor before a camera that stays at its place: level, as far below as eyes are above one."""

from __future__ import annotations

from motorcade.ga import Motor, Trajectory
from motorcade.replays.stages.values.camera_poses import HELD_HEIGHT
from motorcade.replays.stages.view.ground import FLOOR_HEIGHT_M, Ground
from motorcade.replays.stages.view.in_view import tall_at
from motorcade.tracking.cameras.camera import Camera

_FEET = 0.88
"""Of the picture's height: so far down the soles are seen."""


def level_ground(camera: Camera, path: Trajectory, floor_m: float) -> Ground:
    """The floor, and a place on it where the first camera sees a figure down to its soles.

    The picture's up is taken for the world's, and a camera that looks up or down for one that
    looks level: nothing in poses that only turn tells otherwise. How high the camera is held is
    a guess, and so the figure is as high as one sees it well.
    """
    below = max(HELD_HEIGHT - floor_m, 0.1)
    soles_px = (0.5 * (camera.width - 1), _FEET * camera.height)
    gaze = path.motors[0].rotor.apply(camera.bearings([soles_px])[0])
    reach = below / -gaze[2] if gaze[2] < -0.05 else 4.0 * below
    place = path.motors[0].translation_m[:2] + reach * gaze[:2]
    plane, x, y = Motor.from_translation([0.0, 0.0, floor_m]), float(place[0]), float(place[1])
    height_m = min(FLOOR_HEIGHT_M, tall_at((x, y), camera, plane.inverse() @ path.motors))
    name = "a level floor below the camera, up being the picture's"
    return Ground(plane, (x, y), height_m, name)
