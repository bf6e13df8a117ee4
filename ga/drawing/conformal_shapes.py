"""Shapes of conformal multivectors: what `algebra.conformal.measure` reads of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from motorcade.ga.algebra import CGA3, Multivector, conformal
from motorcade.ga.arrays import FloatArray
from motorcade.ga.drawing.shape import (
    Circle,
    Frames,
    Line,
    PlaneShape,
    PointPair,
    Points,
    Shape,
    Sphere,
)

# A squared radius of this beside the square of the distance from the origin is rounding, and so is
# one of this square metres at the origin.
_POINT, _POINT_M2 = 1e-9, 1e-14
# A round object that is larger by this than its distance from the origin, or than a metre, is flat.
_FLAT = 1e10
# Blades of round and of flat objects: of weight w, of w times a length, of w times its square.
_BLADES = {
    1: (("e0",), ("e1", "e2", "e3"), ("einf",)),
    2: (
        ("e1^e0", "e2^e0", "e3^e0"),
        ("e2^e3", "e3^e1", "e1^e2", "e0^einf"),
        ("e1^einf", "e2^einf", "e3^einf"),
    ),
    3: (
        ("e1^e2^e0", "e2^e3^e0", "e3^e1^e0"),
        ("e1^e2^e3", "e1^e0^einf", "e2^e0^einf", "e3^e0^einf"),
        ("e1^e2^einf", "e2^e3^einf", "e3^e1^einf"),
    ),
}


def shape(x: Multivector, form: str) -> Shape:
    """The shape of an object of CGA3 in inner or outer form, or of a versor.

    Raises ValueError: why there is none.
    """
    if len(x.grades) > 1:
        return moved_frame(x, _point, _place)
    if form == "outer":
        if x.grades == (1,):
            return _outer_vector(x)
        return _inner(x.dual())
    return _inner(x)


def shape_of_plane(x: Multivector, form: str) -> Shape:
    """The shape of an object of the conformal algebra of the plane: in space, it meets z = 0 there.

    Raises ValueError: why there is none.
    """
    if len(x.grades) > 1:
        moved = moved_frame(_lifted(x), _point, _place)
        return Frames(moved.origins, moved.axes, flat=True)
    if x.grades == (1,) and _is_null(_lifted(x)):
        return _inner(_lifted(x))
    if form == "outer":
        if x.grades == (1,):
            raise ValueError("a vector in outer form is a point, and this one is none")
        x = x.dual()
    if x.grades == (3,):
        return _outer_vector(_lifted(x.undual()))
    shape = _inner(_lifted(x) ^ CGA3.blade("e3"))
    return _flattened(shape)


def _flattened(shape: Shape) -> Shape:
    """What rounding left of z is taken away."""
    keep = np.array([1.0, 1.0, 0.0])
    if isinstance(shape, Circle):
        normal = np.array([0.0, 0.0, 1.0])
        return Circle(shape.center * keep, normal, shape.radius, shape.imaginary)
    if isinstance(shape, PointPair):
        return PointPair(shape.first * keep, shape.second * keep, shape.imaginary)
    if isinstance(shape, Line):
        return Line(shape.point * keep, shape.direction * keep)
    return shape


def _lifted(x: Multivector) -> Multivector:
    return CGA3.multivector(dict(x.items()))


def _is_null(x: Multivector) -> bool:
    """Whether a vector is a point."""
    if not _is_round(x, 1):
        return False
    weight = float(x.coefficient("e0"))
    return _is_point(float(x.square().scalar_part()) / weight**2, _across(x) / weight)


def _inner(x: Multivector) -> Shape:
    (grade,) = x.grades
    if grade == 4:
        return _outer_vector(x.undual())
    if grade not in _BLADES:
        raise ValueError("a pseudoscalar has no image")
    kinds = ((_sphere, _plane), (_circle, _line), (_pair, _flat_point))
    return kinds[grade - 1][0 if _is_round(x, grade) else 1](x)


def _is_round(x: Multivector, grade: int) -> bool:
    """Whether an object has a radius that is no rounding of a flat one."""
    weight, middle, far = (
        max(abs(float(x.coefficient(blade))) for blade in blades) for blades in _BLADES[grade]
    )
    length = max(far / middle, 1.0) if middle else 1.0
    return weight > 0.0 and weight * length * _FLAT > middle


def _is_point(squared: float, center: FloatArray) -> bool:
    return abs(squared) <= _POINT * float(center @ center) + _POINT_M2


def _outer_vector(x: Multivector) -> Shape:
    if not _is_null(x):
        raise ValueError("a vector in outer form is a point, and this one is none: is it inner?")
    return _inner(x)


def _sphere(x: Multivector) -> Shape:
    weight = float(x.coefficient("e0"))
    center = _across(x) / weight
    squared = float(x.square().scalar_part()) / weight**2
    if _is_point(squared, center):
        return Points(center[None])
    return Sphere(center, abs(squared) ** 0.5, squared < 0.0)


def _plane(x: Multivector) -> Shape:
    across, far = _across(x), float(x.coefficient("einf"))
    length = float(np.linalg.norm(across))
    if length * _FLAT**1.5 <= abs(far):
        raise ValueError("it is the point at infinity")
    return PlaneShape(across * (far / length**2), across / length)


def _across(x: Multivector) -> FloatArray:
    return np.array([x.coefficient(f"e{k}") for k in (1, 2, 3)], dtype=np.float64)


def _circle(x: Multivector) -> Shape:
    squared = float(conformal.radius_squared(x))
    return Circle(
        _array(conformal.center(x)), _array(conformal.normal(x)), abs(squared) ** 0.5, squared < 0.0
    )


def _line(x: Multivector) -> Shape:
    try:
        return Line(_array(conformal.nearest_to_origin(x)), _array(conformal.direction(x)))
    except ValueError as refused:
        raise ValueError("it lies at infinity, or is no line or circle") from refused


def _pair(x: Multivector) -> Shape:
    squared = float(conformal.radius_squared(x))
    center, along = _array(conformal.center(x)), _array(conformal.direction(conformal.carrier(x)))
    reach = abs(squared) ** 0.5 * along
    if _is_point(squared, center):
        return Points(center[None])
    return PointPair(center - reach, center + reach, squared < 0.0)


def _flat_point(x: Multivector) -> Shape:
    try:
        return Points(_array(conformal.flat_position(x))[None])
    except ValueError as refused:
        raise ValueError("it lies at infinity") from refused


def _array(value: Any) -> FloatArray:
    return np.asarray(value, dtype=np.float64).reshape(3)


def moved_frame(
    x: Multivector,
    point: Callable[[FloatArray], Multivector],
    place: Callable[[Multivector], FloatArray],
) -> Frames:
    """Where a versor takes the origin and the ends of the axes.

    `point` makes a point of coordinates, `place` finds the coordinates of one.

    Raises ValueError: it is no versor that moves points to points.
    """
    ends = np.vstack([np.zeros((1, 3)), np.eye(3)])
    try:
        size = x * ~x
        beside = [abs(v) for blade, v in size.items() if blade != "1"]
        if max(beside, default=0.0) > 1e-6 * abs(size.scalar_part()) or not size.scalar_part():
            raise ValueError("its size is no scalar")
        moved = np.array([place(x.sandwich(point(end))) for end in ends])
    except (ValueError, ZeroDivisionError) as refused:
        raise ValueError("it is neither an object of one grade nor a motion") from refused
    if not np.isfinite(moved).all():
        raise ValueError("it takes the origin to infinity")
    return Frames(moved[:1], (moved[1:] - moved[:1])[None])


def _point(position: FloatArray) -> Multivector:
    return conformal.point(position)


def _place(x: Multivector) -> FloatArray:
    position: FloatArray = np.array([x.coefficient(f"e{k}") for k in (1, 2, 3)])
    return position / float(x.coefficient("e0"))
