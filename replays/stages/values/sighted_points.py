"""Points of the world, and where a camera saw them: what a path can be drawn against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera


@dataclass(frozen=True, eq=False)
class SightedPoints:
    """Points that stand still, as one camera saw them.

    Fields:
        camera: who saw them, with the distortion of `px`.
        time_ns: ``(F,)`` stamps of frames.
        frame: ``(n,)`` row of `time_ns` of each sighting.
        points: ``(n, 3)`` in the world of the measured poses and in its unit.
        px: ``(n, 2)`` where they were seen.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.replays.stages.values.sighted_points import SightedPoints
    >>> from motorcade.tracking import Camera
    >>> camera = Camera(640, 480, 300.0, 300.0, 319.5, 239.5)
    >>> row, point, px = np.array([0]), np.array([[0.0, 0.0, 2.0]]), np.array([[319.5, 239.5]])
    >>> seen = SightedPoints(camera, np.array([0]), row, point, px)
    >>> beside = Trajectory([0], Motor.from_translation([[0.01, 0.0, 0.0]]))  # world_T_camera
    >>> seen.registration_px(beside).round(6)
    array([1.5])
    """

    camera: Camera
    time_ns: IntArray
    frame: IntArray
    points: FloatArray
    px: FloatArray

    def registration_px(self, path: Trajectory) -> FloatArray:
        """How far points drawn along a path lie from where they were seen, a frame.

        Returns:
            ``(M,)`` root mean square over the points of each frame that has some and lies within
            the path's span; NaN where one is behind the camera.
        """
        stamps = self.time_ns[self.frame]
        inside = (stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1])
        world_T_camera = path.motors_at(stamps[inside])
        expected = self.camera.project(world_T_camera.inverse().apply(self.points[inside]))
        squares = np.sum((expected - self.px[inside]) ** 2, axis=-1)
        count = np.bincount(self.frame[inside], minlength=len(self.time_ns))
        total = np.bincount(self.frame[inside], squares, minlength=len(self.time_ns))
        return np.asarray(np.sqrt(total[count > 0] / count[count > 0]))
