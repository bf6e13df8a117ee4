"""Points, planes, spheres, lines, circles and point pairs of space as multivectors of CGA3.

Convention: every object is written in its inner form (IPNS), ``x`` with ``P·x = 0`` for the points
P on it: spheres and planes are vectors, circles and lines bivectors, point pairs and flat points
trivectors. The outer form (OPNS), ``X`` with ``P∧X = 0``, is ``x.undual()``, and ``X.dual()`` leads
back. A point is a sphere of radius zero; it is also its own outer form.

    point   x + ½ x² ∞ + e0        sphere  c + ½ (c² - r²) ∞ + e0        plane  n + d ∞  (n·x = d)

Planes, lines and circles are oriented: a line by its direction, a plane and a circle by their
normal. Coordinates are arrays ``(*, 3)``, batch in front, or three scalars of any kind. Numbers are
checked and degenerate cases refused; symbols cannot be looked at and pass.

Three coordinates over any scalars: the vector calculus that points and directions need.

A triple is a tuple of three scalars; over NumPy each is a batch. Numbers are checked as they come
in, symbols cannot be looked at and pass.

Rotors, motors and similarities as multivectors, and back: coefficients stay what they are but for
``e31 = -e1∧e3``; with ``E = e0∧e∞`` the products ``e23 E`` and so on are basis blades.
``of_versor(m).sandwich(p)`` moves an object as ``m.apply`` moves a point; a similarity's sandwich
also divides the weight of a point by its scale.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

from motorcade.ga.algebra.algebra import CGA3
from motorcade.ga.algebra.multivector import Multivector
from motorcade.ga.algebra.scalars import is_numeric, magnitude, square_root
from motorcade.ga.arrays import checked_floats
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.rotor import Rotor
from motorcade.ga.versors.similarity import Similarity
from motorcade.ga.versors.versor import Versor

# What is smaller than this beside the terms that it is made of, counts as zero.
_DEGENERATE = 1e-12

_AXES = ("e1", "e2", "e3")


def point(position: Any) -> Multivector:
    """The point at `position` ``(*, 3)`` in metres, of weight 1."""
    return _point(triple(position, "point(position)"))


def infinity() -> Multivector:
    """The point at infinity, ``∞``, on every plane and line."""
    return CGA3.blade("einf")


def sphere(center: Any, radius_m: Any) -> Multivector:
    """The sphere around `center` ``(*, 3)`` with `radius_m` ``(*)``, of weight 1.

    Raises:
        ValueError: a negative radius. Imaginary spheres (r² < 0) only arise from meets and joins.
    """
    c = triple(center, "sphere(center)")
    r = length(radius_m, "sphere(radius_m)")
    return _sphere(c, r)


def plane(normal: Any, distance_m: Any) -> Multivector:
    """The plane ``normal · x = distance_m``; `normal` ``(*, 3)`` is a unit vector.

    Raises:
        ValueError: a normal whose length is more than 1e-6 from 1.
    """
    n = unit_triple(normal, "plane(normal)")
    return _vector(n, number(distance_m, "plane(distance_m)"))


def line(position: Any, direction: Any) -> Multivector:
    """The line through `position` ``(*, 3)`` along the unit vector `direction` ``(*, 3)``.

    Raises:
        ValueError: a direction whose length is more than 1e-6 from 1.
    """
    p = triple(position, "line(position)")
    return _line(p, unit_triple(direction, "line(direction)"))


def circle(center: Any, normal: Any, radius_m: Any) -> Multivector:
    """The circle around `center` ``(*, 3)`` across the unit vector `normal`, with `radius_m`.

    Raises:
        ValueError: a negative radius, a normal whose length is more than 1e-6 from 1.
    """
    c = triple(center, "circle(center)")
    n = unit_triple(normal, "circle(normal)")
    return _sphere(c, length(radius_m, "circle(radius_m)")) ^ _vector(n, dot(n, c))


def point_pair(first: Any, second: Any) -> Multivector:
    """The two points at ``(*, 3)``, in this order.

    Raises:
        ValueError: equal points.
    """
    a, b = triple(first, "point_pair(first)"), triple(second, "point_pair(second)")
    way = subtract(b, a)
    _independent("point_pair", (way,), "two points apart")
    return (_point(a) ^ _point(b)).dual()._divided(size_of(way))


def line_through(first: Any, second: Any) -> Multivector:
    """The line from the point at `first` ``(*, 3)`` to the one at `second`, of unit weight.

    Raises:
        ValueError: equal points.
    """
    a, b = triple(first, "line_through(first)"), triple(second, "line_through(second)")
    way = subtract(b, a)
    _independent("line_through", (way,), "two points apart")
    return _line(a, normalized(way))


def plane_through(first: Any, second: Any, third: Any) -> Multivector:
    """The plane of three points ``(*, 3)``, its normal on the side where they run anticlockwise.

    Raises:
        ValueError: points on one line.
    """
    a, ab, ac = _spread("plane_through", first, second, third)
    n = normalized(cross(ab, ac))
    return _vector(n, dot(n, a))


def circle_through(first: Any, second: Any, third: Any) -> Multivector:
    """The circle through three points ``(*, 3)``, its normal as in `plane_through`.

    Raises:
        ValueError: points on one line: `line_through` is meant for these.
    """
    a, ab, ac = _spread("circle_through", first, second, third)
    circle = -(_point(a) ^ _point(add(a, ab)) ^ _point(add(a, ac))).dual()
    return circle._divided(size_of(cross(ab, ac)))


def sphere_through(first: Any, second: Any, third: Any, fourth: Any) -> Multivector:
    """The sphere through four points ``(*, 3)``, of weight 1.

    Raises:
        ValueError: points on one plane or circle.
    """
    points = (first, second, third, fourth)
    a, b, c, d = (triple(x, "sphere_through(points)") for x in points)
    edges = (subtract(b, a), subtract(c, a), subtract(d, a))
    _independent("sphere_through", edges, "four points that lie on no plane")
    sphere = (_point(a) ^ _point(b) ^ _point(c) ^ _point(d)).dual()
    return sphere._divided(sphere.coefficient("e0"))


def meet(first: Multivector, *others: Multivector) -> Multivector:
    """What the objects have in common: the outer product of inner forms.

    Two spheres meet in a circle, a line and a plane in a flat point, a line and a sphere in a
    point pair. Where they miss each other the circle or pair is imaginary (`radius_squared` is
    negative), where they touch its radius is zero; parallel flats meet at infinity.

    Raises:
        ValueError: multivectors that are no objects of CGA3 in inner form.
    """
    met = _checked_object(first, "meet")
    for other in others:
        met = met ^ _checked_object(other, "meet")
    return met


def join(first: Multivector, *points: Multivector) -> Multivector:
    """The smallest object that holds an object and further points: the outer form's product.

    A line and a point span a plane, a circle and a point a sphere, a point pair and `infinity` a
    line. Its orientation follows the outer product's order, and it is zero where a point lies on
    the object already.

    Raises:
        ValueError: multivectors that are no objects of CGA3 in inner form, or further ones that
            are no points.
    """
    grown = _checked_object(first, "join").undual()
    for other in points:
        if _checked_object(other, "join").grades != (1,):
            raise ValueError(f"join(points): expected points, got grades {other.grades}")
        grown = grown ^ other
    return grown.dual()


def _vector(space: Triple, infinite: Any, origin: Any = None) -> Multivector:
    named = dict(zip(_AXES, space, strict=True))
    if origin is not None:
        named["e0"] = origin
    return CGA3.multivector({**named, "einf": infinite})


def _point(x: Triple) -> Multivector:
    return _vector(x, 0.5 * dot(x, x), origin=1.0)


def _sphere(c: Triple, r: Any) -> Multivector:
    return _vector(c, 0.5 * (dot(c, c) - r * r), origin=1.0)


def _line(p: Triple, d: Triple) -> Multivector:
    names = ("e2^e3", "e3^e1", "e1^e2", "e1^einf", "e2^einf", "e3^einf")
    return CGA3.multivector(dict(zip(names, (*d, *cross(p, d)), strict=True)))


def _spread(name: str, first: Any, second: Any, third: Any) -> tuple[Triple, Triple, Triple]:
    """A corner of a triangle and the edges from it, refused where they are on one line."""
    a, b, c = (triple(x, f"{name}(points)") for x in (first, second, third))
    edges = subtract(b, a), subtract(c, a)
    _independent(name, edges, "three points that lie on no line")
    return a, *edges


def _independent(name: str, edges: tuple[Triple, ...], expected: str) -> None:
    """Refuse edges that span nothing: their volume beside the product of their lengths."""
    lengths = [size_of(edge) for edge in edges]
    if len(edges) == 1:
        volume, size = lengths[0], 1.0
        smallest = 0.0
    elif len(edges) == 2:
        volume, size = size_of(cross(edges[0], edges[1])), lengths[0] * lengths[1]
        smallest = _DEGENERATE
    else:
        volume = magnitude(dot(cross(edges[0], edges[1]), edges[2]))
        size = lengths[0] * lengths[1] * lengths[2]
        smallest = _DEGENERATE
    if is_numeric(volume):
        lost = int(np.count_nonzero(np.asarray(volume) <= smallest * size))
        if lost:
            raise ValueError(f"{name}: expected {expected}, got {lost} sets that do not")


def _checked_object(x: Multivector, name: str) -> Multivector:
    if not isinstance(x, Multivector) or x.algebra != CGA3:
        raise ValueError(f"{name}: expected multivectors of {CGA3}, got {x!r}")
    if len(x.grades) != 1 or x.grades[0] not in (1, 2, 3, 4):
        raise ValueError(f"{name}: expected objects of one grade from 1 to 4, got {x.grades}")
    return x


# How far from 1 the length of a direction may be before it is refused.
_UNIT_TOLERANCE = 1e-6

Triple = tuple[Any, Any, Any]


def triple(value: Any, name: str) -> Triple:
    """Three coordinates from an array ``(*, 3)``, or from three scalars of any kind.

    Raises ValueError: another number of them, NaN or infinity.
    """
    if isinstance(value, list | tuple) and len(value) == 3:
        plain = all(is_numeric(part) for part in value)
        if not plain and not any(isinstance(part, list | tuple) for part in value):
            return value[0], value[1], value[2]
    if hasattr(value, "numel"):
        return _unpacked(value, name)
    array = checked_floats(value, name, (3,))
    return array[..., 0], array[..., 1], array[..., 2]


def _unpacked(value: Any, name: str) -> Triple:
    """A CasADi column of three, or a tensor ``(*, 3)``."""
    shape = tuple(value.shape)
    if hasattr(value, "nnz") and shape in ((3, 1), (1, 3)):
        return value[0], value[1], value[2]
    if hasattr(value, "nnz") or shape[-1:] != (3,):
        raise ValueError(f"{name}: expected shape (*, 3), got {shape}")
    return value[..., 0], value[..., 1], value[..., 2]


def unit_triple(value: Any, name: str) -> Triple:
    """As `triple`, for unit vectors. Raises ValueError: a length more than 1e-6 from 1."""
    vector = triple(value, name)
    size = square_root(dot(vector, vector))
    if is_numeric(size):
        worst = float(np.max(np.abs(size - 1.0), initial=0.0))
        if worst > _UNIT_TOLERANCE:
            raise ValueError(
                f"{name}: expected a unit vector (length within {_UNIT_TOLERANCE:g} of 1), got a "
                f"length off by {worst:.3g}; divide by it first"
            )
    return vector


def length(value: Any, name: str) -> Any:
    """A length, not negative where it can be looked at."""
    lengths = number(value, name)
    if is_numeric(lengths) and np.any(np.asarray(lengths) < 0.0):
        raise ValueError(f"{name}: expected a length >= 0, got {float(np.min(lengths)):g}")
    return lengths


def dot(a: Triple, b: Triple) -> Any:
    """Scalar product of two triples."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Triple, b: Triple) -> Triple:
    """Vector product of two triples."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def add(a: Triple, b: Triple) -> Triple:
    """Sum of two triples."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Triple, b: Triple) -> Triple:
    """Difference of two triples."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(factor: Any, a: Triple) -> Triple:
    """Multiple of a triple."""
    return a[0] * factor, a[1] * factor, a[2] * factor


def normalized(a: Triple) -> Triple:
    """A triple divided by its length."""
    return scale(1.0 / square_root(dot(a, a)), a)


def number(value: Any, name: str) -> Any:
    """A scalar of any kind, or a batch of numbers; NaN and infinity are refused."""
    if is_numeric(value) or isinstance(value, list | tuple):
        return checked_floats(value, name, ())[()]
    return value


def size_of(a: Triple) -> Any:
    """Length of a triple."""
    return square_root(dot(a, a))


V = TypeVar("V", bound=Versor)

_ROTOR = ("1", "e2^e3", "e3^e1", "e1^e2")
_GROWTH = ("e0^einf", "e2^e3^e0^einf", "e3^e1^e0^einf", "e1^e2^e0^einf")
_MOVED = ("e1^einf", "e2^einf", "e3^einf", "e1^e2^e3^einf")
_BLADES: dict[type[Versor], tuple[str, ...]] = {
    Rotor: _ROTOR,
    Motor: (*_ROTOR, *_MOVED),
    Similarity: (*_ROTOR, *_GROWTH, *_MOVED),
}


def of_versor(versor: Versor) -> Multivector:
    """The multivector of a rotor, motor or similarity ``(*)``, coefficients over its batch.

    Raises:
        ValueError: another type.
    """
    names = _BLADES.get(type(versor))
    if names is None:
        raise ValueError(
            f"of_versor(versor): expected a Rotor, Motor or Similarity, got {type(versor).__name__}"
        )
    parts = np.moveaxis(versor.coefficients, -1, 0)
    return CGA3.multivector(dict(zip(names, parts, strict=True)))


def as_rotor(x: Multivector) -> Rotor:
    """The rotor ``(*)`` of a multivector on ``1, e23, e31, e12``.

    Raises:
        ValueError: other blades, coefficients that are no numbers, or not unit.
    """
    return _versor(Rotor, x)


def as_motor(x: Multivector) -> Motor:
    """The motor ``(*)`` of a multivector on ``1, e23, e31, e12, e1∞, e2∞, e3∞, e123∞``.

    Raises:
        ValueError: other blades, coefficients that are no numbers, or no rigid motion.
    """
    return _versor(Motor, x)


def as_similarity(x: Multivector) -> Similarity:
    """The similarity ``(*)`` of a multivector on its twelve blades.

    Raises:
        ValueError: other blades, coefficients that are no numbers, or no similarity.
    """
    return _versor(Similarity, x)


def _versor(kind: type[V], x: Multivector) -> V:
    name = f"as_{kind.__name__.lower()}(x)"
    if x.algebra != CGA3:
        raise ValueError(f"{name}: expected a multivector of {CGA3}, got one of {x.algebra}")
    names = _BLADES[kind]
    known = {blade for name in names for blade in CGA3.blade(name).blades}
    foreign = [blade for blade in x.blades if blade not in known]
    if foreign:
        raise ValueError(f"{name}: expected blades of a {kind.__name__}, got {' '.join(foreign)}")
    parts = [x.coefficient(blade) for blade in names]
    if not all(map(is_numeric, parts)):
        raise ValueError(f"{name}: expected coefficients that are numbers, got symbols")
    return kind(np.stack(np.broadcast_arrays(*parts), axis=-1))
