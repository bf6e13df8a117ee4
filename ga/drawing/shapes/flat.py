"""Shapes of plane-based and Euclidean multivectors.

In plane-based algebra a vector ``n + d e0`` is the plane ``n·x + d = 0``, a bivector a line and a
trivector a point; its even versors are motors. In Euclidean algebra vectors are arrows from the
origin, bivectors discs of their area, and even versors turn the axes.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga.algebra import EGA3, PGA3, Multivector
from motorcade.ga.arrays import FloatArray
from motorcade.ga.drawing.shapes.conformal import moved_frame
from motorcade.ga.drawing.shapes.shape import Arrow, Circle, Frames, Line, PlaneShape, Points, Shape

_NONE = 1e-10
_AXES = ("e1", "e2", "e3")


def of_plane_based(x: Multivector, plane: bool) -> Shape:
    """The shape of an object of PGA3, or with `plane` of the algebra of the plane.

    Raises:
        ValueError: why there is none.
    """
    lifted = PGA3.multivector(dict(x.items()))
    if len(x.grades) > 1:
        found = moved_frame(lifted, _point, _place)
        return Frames(found.origins, found.axes, flat=plane)
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
    raise ValueError("a pseudoscalar has no picture")


def of_euclidean(x: Multivector, plane: bool) -> Shape:
    """The shape of an object of EGA3, or with `plane` of the algebra of the plane.

    Raises:
        ValueError: why there is none.
    """
    lifted = EGA3.multivector(dict(x.items()))
    if x.grades == (1,):
        return Arrow(np.zeros(3), _triple(lifted, *_AXES))
    if x.grades == (2,):
        across = _triple(lifted, "e2^e3", "e3^e1", "e1^e2")
        area = float(np.linalg.norm(across))
        return Circle(np.zeros(3), across / area, (area / np.pi) ** 0.5, filled=True)
    if len(x.grades) == 1:
        raise ValueError("a pseudoscalar has no picture")
    found = moved_frame(lifted, _vector, lambda y: _triple(y, *_AXES))
    return Frames(found.origins, found.axes, flat=plane)


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
