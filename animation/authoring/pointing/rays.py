"""Rays through pixels, and planes in which what they grabbed is dragged.

All of it is in one frame of the caller's choice, in metres. In an object's parent frame a drag is
the same wherever the parent goes meanwhile: `Ray.seen_from` takes a ray there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.authoring.poses import checked_vector
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray, frozen

# A ray meets a plane at its horizon where it does so this many times farther away, or nearer, than
# what was grabbed: there a pixel is more than the whole scene.
HORIZON = 1000.0


class OutOfReach(ValueError):
    """A ray leads to no point that something could be dragged to: above a horizon, or behind."""


@dataclass(frozen=True, eq=False)
class Ray:
    """What lies under a pixel.

    Args:
        origin_m: ``(3,)``, where the camera is.
        direction: ``(3,)`` of any length but 0.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity, no direction.

    >>> from motorcade.animation.authoring.pointing import DragPlane, Ray
    >>> down = Ray([0.0, 0.0, 2.0], [1.0, 0.0, -1.0])
    >>> DragPlane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]).met_by(down).round(12) + 0.0
    array([2., 0., 0.])
    """

    origin_m: FloatArray
    direction: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin_m", frozen(checked_vector(self.origin_m, "Ray.origin_m")))
        object.__setattr__(self, "direction", checked_direction(self.direction, "Ray.direction"))

    def seen_from(self, frame_T_here: Similarity) -> Ray:
        """The same ray in another frame."""
        rotor = frame_T_here.rotor
        return Ray(frame_T_here.apply(self.origin_m), rotor.apply(self.direction))


@dataclass(frozen=True, eq=False)
class DragPlane:
    """The plane in which a grabbed point is dragged.

    Args:
        point_m: ``(3,)``, what was grabbed.
        normal: ``(3,)`` of any length but 0: that of the ground, or along the camera's axis for
            what follows the finger in a plane parallel to the picture.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity, no direction.
    """

    point_m: FloatArray
    normal: FloatArray

    def __post_init__(self) -> None:
        point = frozen(checked_vector(self.point_m, "DragPlane.point_m"))
        object.__setattr__(self, "point_m", point)
        object.__setattr__(self, "normal", checked_direction(self.normal, "DragPlane.normal"))

    def met_by(self, ray: Ray) -> FloatArray:
        """Where a ray meets the plane, ``(3,)``.

        Raises:
            OutOfReach: above the horizon, along the plane, or behind the camera.
        """
        away = self.point_m - ray.origin_m
        height, slope = float(self.normal @ away), float(self.normal @ ray.direction)
        size = float(np.linalg.norm(away))
        # By products, as quotients of nearly nothing are no numbers.
        if not abs(slope) * size < HORIZON * abs(height) or not height * slope > 0.0:
            raise OutOfReach("the finger points past the plane: expected at a place in it")
        if not abs(height) < HORIZON * size * abs(slope):
            raise OutOfReach("the finger points above the horizon of the plane: expected below it")
        made: FloatArray = ray.origin_m + (height / slope) * ray.direction
        return made


def checked_direction(value: ArrayLike, name: str) -> FloatArray:
    """A vector ``(3,)`` at length 1.

    Raises:
        ValueError: another shape, NaN or infinity, no direction.
    """
    given = checked_vector(value, name)
    most = float(np.abs(given).max())
    if not most > 0.0:
        raise ValueError(f"{name}: expected a direction, got {given}")
    scaled = given / most  # so that no square overflows, or comes to nothing
    return frozen(scaled / np.linalg.norm(scaled))
