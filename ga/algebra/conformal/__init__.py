"""Conformal geometry of space in CGA3: objects, their meets, joins and measures, versors.

`objects` states the conventions (inner form, orientation, degenerate cases); `measure` reads
positions, radii and distances back; `versors` leads to Rotor, Motor and Similarity and back.

    >>> from motorcade.ga.algebra import conformal
    >>> ball = conformal.sphere([0.0, 0.0, 1.0], 2.0)
    >>> ground = conformal.plane([0.0, 0.0, 1.0], 0.0)
    >>> print(round(float(conformal.radius(conformal.meet(ball, ground))) ** 2, 6))
    3.0
"""

from __future__ import annotations

from motorcade.ga.algebra.conformal.measure import (
    carrier,
    center,
    coordinates,
    direction,
    distance_to_line,
    distance_to_plane,
    distance_to_point,
    distance_to_sphere,
    flat_position,
    nearest_to_origin,
    normal,
    plane_distance,
    radius,
    radius_squared,
    two_points,
)
from motorcade.ga.algebra.conformal.objects import (
    as_motor,
    as_rotor,
    as_similarity,
    circle,
    circle_through,
    infinity,
    join,
    line,
    line_through,
    meet,
    of_versor,
    plane,
    plane_through,
    point,
    point_pair,
    sphere,
    sphere_through,
)

__all__ = [
    "as_motor",
    "as_rotor",
    "as_similarity",
    "carrier",
    "center",
    "circle",
    "circle_through",
    "coordinates",
    "direction",
    "distance_to_line",
    "distance_to_plane",
    "distance_to_point",
    "distance_to_sphere",
    "flat_position",
    "infinity",
    "join",
    "line",
    "line_through",
    "meet",
    "nearest_to_origin",
    "normal",
    "of_versor",
    "plane",
    "plane_distance",
    "plane_through",
    "point",
    "point_pair",
    "radius",
    "radius_squared",
    "sphere",
    "sphere_through",
    "two_points",
]
