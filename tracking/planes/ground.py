"""Which plane things stand on: the floor where gravity is known, a guess where it is not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.tracking.planes.plane import Plane

__all__ = ["choose_floor", "choose_stage"]

_LEVEL = np.cos(np.deg2rad(15.0))
_UPWARD = np.cos(np.deg2rad(60.0))
_LARGE = 0.2


def choose_floor(planes: Sequence[Plane], up: ArrayLike) -> Plane | None:
    """The floor: the lowest level plane that is not small against the largest level one.

    Level means facing up within 15 degrees; small, less than a fifth of its area. A ceiling faces
    down and is never chosen. A table is, where no floor is in view.

    Args:
        planes: with normals towards the camera.
        up: ``(3,)`` against gravity, in the planes' frame; any length.

    Returns:
        The plane, or None where none is level.

    Raises:
        ValueError: an up that is zero or not finite.
    """
    upward = _unit(up)
    level = [plane for plane in planes if plane.normal @ upward >= _LEVEL]
    if not level:
        return None
    least = _LARGE * max(plane.area_m2 for plane in level)
    large = [plane for plane in level if plane.area_m2 >= least]
    return min(large, key=lambda plane: float(plane.centre_m @ upward))


def choose_stage(planes: Sequence[Plane], world_T_camera: Motor) -> Plane | None:
    """A plane to stand on where gravity is unknown: the largest that faces the picture's up.

    Each plane's area counts by the cosine between its normal and the picture's up; planes beyond 60
    degrees are out. That is right for cameras held upright to within a few tens of degrees: looking
    ahead or down, level surfaces face the picture's up and walls do not. A picture taken straight
    down, or turned on its side, misleads it.

    Args:
        planes: with normals towards the camera.
        world_T_camera: its pose in the planes' frame; the picture's up is its -y.

    Returns:
        The plane, or None where none faces up.
    """
    upward = world_T_camera.rotor.apply([0.0, -1.0, 0.0])
    weights = [(float(plane.normal @ upward), plane) for plane in planes]
    facing = [(cosine * plane.area_m2, plane) for cosine, plane in weights if cosine >= _UPWARD]
    return max(facing, key=lambda one: one[0])[1] if facing else None


def _unit(up: ArrayLike) -> FloatArray:
    vector = checked_floats(up, "up", (3,))
    length = float(np.linalg.norm(vector))
    if vector.shape != (3,) or length == 0.0:
        raise ValueError(f"up: expected one vector that is not zero, got {vector}")
    return np.asarray(vector / length)
