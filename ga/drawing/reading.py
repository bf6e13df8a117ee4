"""What an object looks like: multivectors, versors and arrays of points as `shapes`.

The algebras that have images are those of the plane and of space: Euclidean, plane-based and
conformal ones. An object of CGA is read in its inner form, or in its outer form where that is said;
a point is both. Objects of plane conformal and plane-based algebras are those of space that meet
the plane of x and y in them: what ``x ∧ e3`` says in inner form.

In plane-based algebra a vector ``n + d e0`` is the plane ``n·x + d = 0``, a bivector a line and a
trivector a point; its even versors are motors. In Euclidean algebra vectors are arrows from the
origin, bivectors discs of their area, and even versors turn the axes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector, conformal
from motorcade.ga.algebra.scalars import is_numeric
from motorcade.ga.arrays import FloatArray
from motorcade.ga.drawing.shape import (
    Arrow,
    Circle,
    Frames,
    Line,
    PlaneShape,
    PointPair,
    Points,
    Shape,
    Sphere,
)
from motorcade.ga.trajectory import Trajectory
from motorcade.ga.versors.versor import Versor

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
        return moved_frame(x, _conformal_point, _conformal_place)
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
        moved = moved_frame(_lifted(x), _conformal_point, _conformal_place)
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


def _conformal_point(position: FloatArray) -> Multivector:
    return conformal.point(position)


def _conformal_place(x: Multivector) -> FloatArray:
    position: FloatArray = np.array([x.coefficient(f"e{k}") for k in (1, 2, 3)])
    return position / float(x.coefficient("e0"))


Form = Literal["inner", "outer"]

MAX_OBJECTS = 1000
_CGA2 = Algebra(3, 1, null_pair=True)
_PGA2 = Algebra(2, 0, 1, ("e1", "e2", "e0"))
_EGA2 = Algebra(2)
# Beside the largest coefficient, what rounding leaves of other grades.
_ROUNDING = 1e-12


def shapes_of(x: Any, form: Form = "inner") -> list[Shape]:
    """The shapes of a multivector, a batch of them, a versor, a trajectory, or points ``(*, 3)``.

    Raises:
        ValueError: nothing that can be drawn, and why: symbols, another algebra, a number, what
            lies at infinity, more than `MAX_OBJECTS`.
    """
    if isinstance(x, Trajectory):
        return shapes_of(x.poses)
    if isinstance(x, Versor):
        return [_frames(x)]
    if isinstance(x, Multivector):
        return _of_multivectors(_rows(x), form)
    return [_points(x)]


def _frames(poses: Versor) -> Frames:
    """Where the origin and the axes go."""
    flat = poses.reshape(-1)
    if len(flat.coefficients) > MAX_OBJECTS:
        step = -(-len(flat.coefficients) // MAX_OBJECTS)
        flat = flat[::step]
    zero = np.zeros((len(flat.coefficients), 1, 3))
    ends = np.concatenate([zero, np.broadcast_to(np.eye(3), (len(zero), 3, 3))], axis=1)
    moved = np.stack([_applied(flat, ends[:, k]) for k in range(4)], axis=1)
    return Frames(moved[:, 0], moved[:, 1:] - moved[:, :1])


def _applied(poses: Any, points: FloatArray) -> FloatArray:
    return np.asarray(poses.apply(points.astype(poses.coefficients.dtype)), dtype=np.float64)


def _points(x: Any) -> Points:
    """An array of points of space, or of the plane."""
    try:
        array = np.asarray(x, dtype=np.float64)
    except (TypeError, ValueError) as refused:
        raise ValueError(
            f"expected multivectors, versors or points, got {type(x).__name__}"
        ) from refused
    if array.ndim == 0 or array.shape[-1] not in (2, 3) or not np.isfinite(array).all():
        raise ValueError(f"expected finite points of shape (*, 2) or (*, 3), got {array.shape}")
    rows = array.reshape(-1, array.shape[-1])
    return Points(np.pad(rows, ((0, 0), (0, 3 - rows.shape[1]))))


def _rows(x: Multivector) -> list[Multivector]:
    """The multivectors of a batch, without what rounding left of other grades."""
    if not all(map(is_numeric, x.values)):
        raise ValueError("expected numbers, got symbols")
    values = np.broadcast_arrays(*[np.asarray(v, np.float64) for v in x.values or (0.0,)])
    rows = np.stack([v.ravel() for v in values], axis=1)
    if len(rows) > MAX_OBJECTS:
        raise ValueError(f"expected at most {MAX_OBJECTS} objects, got {len(rows)}")
    algebra: Any = x.algebra
    grades = np.array([blade.count("^") + (blade != "1") for blade in x.blades], dtype=np.int64)
    multivectors = []
    for row in rows[:, : len(grades)]:
        least = _ROUNDING * np.abs(row).max(initial=0.0)
        large = set(grades[np.abs(row) > least])
        kept = [grade in large and value != 0.0 for grade, value in zip(grades, row, strict=True)]
        parts = {b: float(v) for b, v, keep in zip(x.blades, row, kept, strict=True) if keep}
        multivectors.append(algebra.multivector(parts))
    return multivectors


def _of_multivectors(rows: list[Multivector], form: Form) -> list[Shape]:
    shapes = [_shape(x, form) for x in rows]
    if all(isinstance(shape, Points) for shape in shapes):
        return [Points(np.concatenate([shape.extent() for shape in shapes]))]  # type: ignore[union-attr]
    if all(isinstance(shape, Frames) for shape in shapes):
        return [_joined([shape for shape in shapes if isinstance(shape, Frames)])]
    return shapes


def _joined(frames: list[Frames]) -> Frames:
    origins = np.concatenate([frame.origins for frame in frames])
    axes = np.concatenate([frame.axes for frame in frames])
    return Frames(origins, axes, all(frame.flat for frame in frames))


def _shape(x: Multivector, form: Form) -> Shape:
    if not x.masks:
        raise ValueError("it is zero")
    if x.grades == (0,):
        raise ValueError(f"it is the number {x.scalar_part():g}")
    algebra = x.algebra
    if algebra == CGA3:
        return shape(x, form)
    if algebra == _CGA2:
        return shape_of_plane(x, form)
    if algebra in (PGA3, _PGA2):
        return of_plane_based(x, algebra == _PGA2)
    if algebra in (EGA3, _EGA2):
        return of_euclidean(x, algebra == _EGA2)
    raise ValueError(f"there is no image of objects of {algebra}")


_NONE = 1e-10
_AXES = ("e1", "e2", "e3")


def of_plane_based(x: Multivector, plane: bool) -> Shape:
    """The shape of an object of PGA3, or with `plane` of the algebra of the plane.

    Raises ValueError: why there is none.
    """
    lifted = PGA3.multivector(dict(x.items()))
    if len(x.grades) > 1:
        frames = moved_frame(lifted, _point, _place)
        return Frames(frames.origins, frames.axes, flat=plane)
    if plane:
        lifted = lifted ^ PGA3.blade("e3")
    (grade,) = lifted.grades
    size = max(abs(value) for value in lifted.values)
    if grade == 1:
        normal, length = _unit(_triple(lifted, "e1", "e2", "e3"), size)
        return PlaneShape(-lifted.coefficient("e0") / length * normal, normal)
    if grade == 2:
        along, length = _unit(_triple(lifted, "e2^e3", "e3^e1", "e1^e2"), size)
        moment = _triple(lifted, "e1^e0", "e2^e0", "e3^e0") / length
        return Line(np.cross(moment, along), along)
    if grade == 3:
        if abs(lifted.coefficient("e1^e2^e3")) <= _NONE * size:
            raise ValueError("it lies at infinity")
        return Points(_place(lifted)[None])
    raise ValueError("a pseudoscalar has no image")


def of_euclidean(x: Multivector, plane: bool) -> Shape:
    """The shape of an object of EGA3, or with `plane` of the algebra of the plane.

    Raises ValueError: why there is none.
    """
    lifted = EGA3.multivector(dict(x.items()))
    if x.grades == (1,):
        return Arrow(np.zeros(3), _triple(lifted, *_AXES))
    if x.grades == (2,):
        across = _triple(lifted, "e2^e3", "e3^e1", "e1^e2")
        area = float(np.linalg.norm(across))
        return Circle(np.zeros(3), across / area, (area / np.pi) ** 0.5, filled=True)
    if len(x.grades) == 1:
        raise ValueError("a pseudoscalar has no image")
    frames = moved_frame(lifted, _vector, lambda y: _triple(y, *_AXES))
    return Frames(frames.origins, frames.axes, flat=plane)


def _unit(vector: FloatArray, size: float) -> tuple[FloatArray, float]:
    length = float(np.linalg.norm(vector))
    if length <= _NONE * size:
        raise ValueError("it lies at infinity")
    return vector / length, length


def _triple(x: Multivector, *blades: str) -> FloatArray:
    return np.array([x.coefficient(blade) for blade in blades], dtype=np.float64)


def _vector(position: FloatArray) -> Multivector:
    return EGA3.vector(position.tolist())


def _point(position: FloatArray) -> Multivector:
    """The meet of the three planes across the axes through it."""
    planes = [
        PGA3.blade(a) - float(v) * PGA3.blade("e0") for a, v in zip(_AXES, position, strict=True)
    ]
    return planes[0] ^ planes[1] ^ planes[2]


def _place(x: Multivector) -> FloatArray:
    parts = _triple(x, "e0^e2^e3", "e1^e0^e3", "e1^e2^e0")
    return -parts / float(x.coefficient("e1^e2^e3"))
