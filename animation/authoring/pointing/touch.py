"""What fingers do: move in a plane, pinch and twist, slide along an axis, turn about one.

Each says what took place since the drag began, from the rays of then and of now: what a `Drag`
takes as its amount. `moved` and `pinched` give similarities that act in the frame of the rays, so
that what was grabbed is under the fingers again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.authoring.pointing.rays import (
    HORIZON,
    DragPlane,
    OutOfReach,
    Ray,
    checked_direction,
)
from motorcade.animation.authoring.poses import checked_vector
from motorcade.animation.vectors import perpendicular
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray

# The sine of an angle between ray and axis below which a pixel is no longer a place on the axis.
_ALONG = 0.01
# Fingers or hands this near, as a share of how far away they are, say no direction.
_APART = 1e-6


def moved(plane: DragPlane, start: Ray, now: Ray) -> Similarity:
    """One finger: the shift in the plane that brings what was under it under it again.

    Args:
        plane: through what was grabbed.
        start: the finger when the drag began.
        now: the finger.

    Raises:
        OutOfReach: see `DragPlane.met_by`.

    >>> from motorcade.animation.authoring.pointing import DragPlane, Ray, moved
    >>> ground = DragPlane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    >>> start, now = (Ray([0.0, 0.0, 2.0], [x, 0.0, -1.0]) for x in (0.0, 0.25))
    >>> moved(ground, start, now).translation_m.round(12) + 0.0
    array([0.5, 0. , 0. ])
    """
    way = plane.met_by(now) - plane.met_by(start)
    return Similarity.from_motor_scale(Motor.from_translation(way))


def pinched(plane: DragPlane, start: tuple[Ray, Ray], now: tuple[Ray, Ray]) -> Similarity:
    """Two fingers: the one similarity of the plane that brings both points under them again.

    It shifts, turns about the plane's normal, and grows.

    Args:
        plane: through what was grabbed.
        start: the fingers when the drag began.
        now: the same fingers.

    Raises:
        OutOfReach: see `DragPlane.met_by`; fingers at one place.

    >>> import numpy as np
    >>> from motorcade.animation.authoring.pointing import DragPlane, Ray, pinched
    >>> ground = DragPlane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    >>> start = tuple(Ray([0.0, 0.0, 2.0], [x, 0.0, -1.0]) for x in (-0.1, 0.1))
    >>> now = tuple(Ray([0.0, 0.0, 2.0], [0.0, y, -1.0]) for y in (-0.2, 0.2))
    >>> made = pinched(ground, start, now)
    >>> float(made.scale.round(12)), float(np.degrees(made.rotor.angle()).round(9))
    (2.0, 90.0)
    """
    first, second = ([plane.met_by(ray) for ray in pair] for pair in (start, now))
    ways = [pair[1] - pair[0] for pair in (first, second)]
    for way, pair in zip(ways, (start, now), strict=True):
        away = float(np.linalg.norm(plane.point_m - pair[0].origin_m))
        if not float(np.linalg.norm(way)) > _APART * away:
            raise OutOfReach("the fingers are at one place: expected two apart")
    across = perpendicular(plane.normal)
    aside = np.cross(plane.normal, across)
    before, after = (complex(way @ across, way @ aside) for way in ways)
    growth = after / before
    rotor = Rotor.from_rotation_vector(np.angle(growth) * plane.normal)
    still = Similarity.from_rotor_translation_scale(rotor, np.zeros(3), abs(growth))
    shift = second[0] - still.apply(first[0])
    return Similarity.from_rotor_translation_scale(rotor, shift, abs(growth))


def slid(point_m: ArrayLike, axis: ArrayLike, start: Ray, now: Ray) -> float:
    """One finger along an axis through what was grabbed: how far, in metres.

    The point of the axis nearest to the ray is taken.

    Args:
        point_m: ``(3,)``, what was grabbed.
        axis: ``(3,)`` direction.
        start: the finger when the drag began.
        now: the finger.

    Raises:
        OutOfReach: a ray along the axis, or one that passes it behind the camera.
        ValueError: an axis without direction.

    >>> from motorcade.animation.authoring.pointing import Ray, slid
    >>> start, now = (Ray([-2.0, 0.0, 0.0], [1.0, 0.0, slope]) for slope in (0.0, 0.25))
    >>> slid([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], start, now)
    0.5
    """
    point = checked_vector(point_m, "slid(point_m)")
    along = checked_direction(axis, "slid(axis)")
    return _at_m(point, along, now) - _at_m(point, along, start)


def _at_m(point: FloatArray, along: FloatArray, ray: Ray) -> float:
    """How far along an axis from a point the place is that is nearest to a ray."""
    across = np.cross(along, ray.direction)
    sine = float(np.linalg.norm(across))
    if sine < _ALONG:
        raise OutOfReach("the finger points along the axis: expected it to point across")
    away = point - ray.origin_m
    depth = float(np.cross(away, along) @ -across) / sine**2
    if not 0.0 < depth < HORIZON * float(np.linalg.norm(away)):
        raise OutOfReach("the finger points beyond the axis: expected a place on it")
    return float(np.cross(away, ray.direction) @ -across) / sine**2


def turned(point_m: ArrayLike, axis: ArrayLike, start: Ray, now: Ray) -> float:
    """One finger on a ring about an axis: by what angle, right-handed, within ±π.

    Args:
        point_m: ``(3,)``, the ring's centre.
        axis: ``(3,)`` direction, across the ring.
        start: the finger when the drag began.
        now: the finger; see `unwound` for more than half a turn.

    Raises:
        OutOfReach: see `DragPlane.met_by`, of the ring's plane; a finger at its centre.
        ValueError: an axis without direction.

    >>> import numpy as np
    >>> from motorcade.animation.authoring.pointing import Ray, turned
    >>> start, now = (Ray([0.0, 0.0, 2.0], [*at, -2.0]) for at in ([1.0, 0.0], [0.0, 1.0]))
    >>> float(np.degrees(turned([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], start, now)).round(9))
    90.0
    """
    ring = DragPlane(checked_vector(point_m, "turned(point_m)"), np.asarray(axis))
    ways = [ring.met_by(ray) - ring.point_m for ray in (start, now)]
    for way, ray in zip(ways, (start, now), strict=True):
        away = float(np.linalg.norm(ring.point_m - ray.origin_m))
        if not float(np.linalg.norm(way)) > _APART * away:
            raise OutOfReach("the finger is at the centre of the ring: expected it beside")
    return float(np.arctan2(np.cross(ways[0], ways[1]) @ ring.normal, ways[0] @ ways[1]))


def unwound(angle_rad: float, near_rad: float) -> float:
    """The angle, some whole turns on, that is nearest to another: the last one of a drag.

    >>> from motorcade.animation.authoring.pointing import unwound
    >>> round(unwound(-3.0, 3.1), 6)
    3.283185
    """
    return angle_rad + 2.0 * np.pi * round((near_rad - angle_rad) / (2.0 * np.pi))
