"""What the objects of `conformal.objects` look like: positions, normals, radii and distances.

Every function takes objects in inner form, of any weight, over any scalars, and gives lengths in
metres, batch in front; coordinates are arrays ``(*, 3)``, or tuples of three where the scalars are
no numbers. A quantity that an object does not have (the centre of a plane, the meeting point of
parallels) is refused where the scalars are numbers; a weight that is 1e-12 of the coefficients
beside it counts as zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from motorcade.ga.algebra.algebra import CGA3
from motorcade.ga.algebra.conformal.objects import (
    Triple,
    add,
    cross,
    dot,
    normalized,
    scale,
    size_of,
    subtract,
)
from motorcade.ga.algebra.inverse import norm_squared_with_bound
from motorcade.ga.algebra.multivector import Multivector
from motorcade.ga.algebra.scalars import is_numeric, square_root

_DEGENERATE = 1e-12
# How much more than a single rounding may make a moved point's square differ from zero.
_POINT_ROUNDINGS = 1e6
_INFINITY = CGA3.blade("einf")


def coordinates(point: Multivector) -> Any:
    """Where a point ``(*)`` is, ``(*, 3)`` in metres.

    Raises:
        ValueError: no vector, a point at infinity, or a sphere whose radius is not zero.
    """
    _check_grade(point, "coordinates(point)", 1)
    value, bound = norm_squared_with_bound(point)
    if bound is not None and np.any(np.abs(value) > _POINT_ROUNDINGS * bound):
        raise ValueError(
            "coordinates(point): expected a point, got a vector whose square is not zero: "
            "`center` and `radius` read spheres"
        )
    return _joined(_center(point, "coordinates(point)"))


def center(round_object: Multivector) -> Any:
    """The centre ``(*, 3)`` of a sphere, a circle, a point pair, or a point.

    Raises:
        ValueError: a plane, line or flat point, which has none.
    """
    return _joined(_center(round_object, "center(round_object)"))


def radius_squared(round_object: Multivector) -> Any:
    """The squared radius ``(*)`` of a sphere, circle or point pair (half its length, squared).

    It is negative for imaginary ones, as where two spheres miss each other. It loses digits where
    the radius is small beside the distance from the origin.

    Raises:
        ValueError: a plane, line or flat point, which has none.
    """
    flat = _carrier_of_round(round_object, "radius_squared(round_object)")
    return round_object.norm_squared() / flat.norm_squared()


def radius(round_object: Multivector) -> Any:
    """The radius ``(*)`` of a sphere, circle or point pair (half its length).

    Raises:
        ValueError: a plane, line or flat point, or an imaginary object (see `radius_squared`).
    """
    return _radius(round_object, "radius(round_object)")


def carrier(round_object: Multivector) -> Multivector:
    """The flat that holds a round object: of a circle its plane, of a point pair its line."""
    return -(_INFINITY | round_object)


def normal(plane_or_circle: Multivector) -> Any:
    """The unit normal ``(*, 3)`` of a plane or a circle.

    Raises:
        ValueError: a sphere or point, or another kind of object.
    """
    return _joined(_plane_of(plane_or_circle, "normal(plane_or_circle)")[0])


def plane_distance(plane: Multivector) -> Any:
    """The distance ``(*)`` of a plane from the origin, along its normal: ``normal · x`` on it.

    Raises:
        ValueError: a sphere or point, or another kind of object.
    """
    return _plane_of(plane, "plane_distance(plane)")[1]


def direction(line_or_pair: Multivector) -> Any:
    """The unit direction ``(*, 3)`` of a line, or from the first point of a pair to the second.

    Raises:
        ValueError: a circle, or another kind of object.
    """
    return _joined(_line_of(line_or_pair, "direction(line_or_pair)")[0])


def nearest_to_origin(line: Multivector) -> Any:
    """The point ``(*, 3)`` of a line that is nearest to the origin.

    Raises:
        ValueError: a circle, or another kind of object.
    """
    along, moment = _line_of(line, "nearest_to_origin(line)")
    return _joined(cross(along, moment))


def flat_position(flat_point: Multivector) -> Any:
    """Where a flat point is, the meet of a line and a plane or of three planes, ``(*, 3)``.

    Raises:
        ValueError: parallel flats, which meet at infinity, or another kind of object.
    """
    _check_grade(flat_point, "flat_position(flat_point)", 3)
    outer = flat_point.undual()
    weight = outer.coefficient("e0^einf")
    place = _parts(outer, "e1^einf", "e2^einf", "e3^einf")
    round_part = _parts(outer, "e1^e0", "e2^e0", "e3^e0")
    name = "flat_position(flat_point)"
    _refuse_beside(size_of(round_part), (*place, weight), name, "a flat point", small=True)
    _refuse_beside(weight, place, name, "flats that are not parallel")
    return _joined(scale(1.0 / weight, place))


def two_points(pair: Multivector) -> tuple[Any, Any]:
    """The two points ``(*, 3)`` of a point pair, in its order; equal where objects touch.

    Raises:
        ValueError: a flat point, or an imaginary pair: the objects that were met miss each other.
    """
    _check_grade(pair, "two_points(pair)", 3)
    half = _radius(pair, "two_points(pair)")
    along, _ = _line_of(carrier(pair), "two_points(pair)")
    middle, reach = _center(pair, "two_points(pair)"), scale(half, along)
    return _joined(subtract(middle, reach)), _joined(add(middle, reach))


def distance_to_point(first: Multivector, second: Multivector) -> Any:
    """The distance ``(*)`` between two points: ``√(-2 P·Q)``, without its cancellation."""
    a = _center(first, "distance_to_point(first)")
    return size_of(subtract(a, _center(second, "distance_to_point(second)")))


def distance_to_plane(point: Multivector, plane: Multivector) -> Any:
    """The signed distance ``(*)`` of a point from a plane, positive on the normal's side."""
    across, height = _plane_of(plane, "distance_to_plane(plane)")
    return dot(across, _center(point, "distance_to_plane(point)")) - height


def distance_to_line(point: Multivector, line: Multivector) -> Any:
    """The distance ``(*)`` of a point from a line."""
    along, moment = _line_of(line, "distance_to_line(line)")
    off = subtract(_center(point, "distance_to_line(point)"), cross(along, moment))
    return size_of(cross(off, along))


def distance_to_sphere(point: Multivector, sphere: Multivector) -> Any:
    """The signed distance ``(*)`` of a point from a sphere, negative inside."""
    _check_grade(sphere, "distance_to_sphere(sphere)", 1)
    return distance_to_point(point, sphere) - _radius(sphere, "distance_to_sphere(sphere)")


# Parts -----------------------------------------------------------------------------------------


def _parts(x: Multivector, first: str, second: str, third: str) -> Triple:
    return x.coefficient(first), x.coefficient(second), x.coefficient(third)


def _joined(parts: Triple) -> Any:
    if all(map(is_numeric, parts)):
        return np.stack(np.broadcast_arrays(*parts), axis=-1)
    return parts


def _center(x: Multivector, name: str) -> Triple:
    """``x ∞ x`` is the centre as a point: of a sphere, a circle and a point pair alike."""
    _carrier_of_round(x, name)
    image = x if x.grades == (1,) else x.sandwich(_INFINITY)
    return scale(1.0 / image.coefficient("e0"), _parts(image, "e1", "e2", "e3"))


def _carrier_of_round(x: Multivector, name: str) -> Multivector:
    _check_grade(x, name, 1, 2, 3)
    flat = carrier(x)
    free = [value for blade, value in x.items() if "e0" not in blade and "einf" not in blade]
    _refuse_beside(flat.norm(), free, name, "a sphere, circle or point pair")
    return flat


def _radius(x: Multivector, name: str) -> Any:
    flat = _carrier_of_round(x, name)
    value, bound = norm_squared_with_bound(x)
    if bound is not None:
        missed = int(np.count_nonzero(np.asarray(value) < -bound))
        if missed:
            raise ValueError(
                f"{name}: expected real objects, got {missed} with a negative squared radius: "
                "what was met does not touch"
            )
        value = np.maximum(value, 0.0)
    return square_root(value / flat.norm_squared())


def _plane_of(x: Multivector, name: str) -> tuple[Triple, Any]:
    """Unit normal and distance of a plane, or of a circle's plane."""
    _check_grade(x, name, 1, 2)
    flat = carrier(x) if x.grades == (2,) else x
    across = _parts(flat, "e1", "e2", "e3")
    far = flat.coefficient("einf")
    size = size_of(across)
    if x.grades == (1,):
        _refuse_beside(flat.coefficient("e0"), (size, far), name, "a plane", small=True)
    _refuse_beside(size, (far,), name, "a plane or circle")
    return scale(1.0 / size, across), far / size


def _line_of(x: Multivector, name: str) -> tuple[Triple, Triple]:
    """Unit direction and moment of a line, or of a point pair's line."""
    _check_grade(x, name, 2, 3)
    flat = carrier(x) if x.grades == (3,) else x
    along = _parts(flat, "e2^e3", "e3^e1", "e1^e2")
    moment = _parts(flat, "e1^einf", "e2^einf", "e3^einf")
    size = size_of(along)
    if x.grades == (2,):
        round_part = _parts(flat, "e1^e0", "e2^e0", "e3^e0")
        _refuse_beside(size_of(round_part), (size, size_of(moment)), name, "a line", small=True)
    _refuse_beside(size, moment, name, "a line or point pair")
    return normalized(along), scale(1.0 / size, moment)


def _refuse_beside(
    value: Any, others: Sequence[Any], name: str, expected: str, *, small: bool = False
) -> None:
    """Refuse a number that vanishes beside `others`, or with `small` one that does not."""
    if all(map(is_numeric, (value, *others))):
        beside = np.broadcast_arrays(np.asarray(value), *map(np.abs, others))
        size = np.max(np.stack(beside)[1:], axis=0, initial=0.0)
        vanishes = np.abs(value) <= _DEGENERATE * size
        bad = int(np.count_nonzero(~vanishes if small else vanishes))
    else:  # symbols pass, a number among them is zero by structure
        bad = int(not small and is_numeric(value) and not np.any(value))
    if bad:
        raise ValueError(f"{name}: expected {expected}, got {bad} that are none")


def _check_grade(x: Multivector, name: str, *grades: int) -> None:
    if not isinstance(x, Multivector) or x.algebra != CGA3:
        raise ValueError(f"{name}: expected a multivector of {CGA3}, got {x!r}")
    if len(x.grades) != 1 or x.grades[0] not in grades:
        wanted = " or ".join(map(str, grades))
        raise ValueError(f"{name}: expected an object of grade {wanted}, got grades {x.grades}")
