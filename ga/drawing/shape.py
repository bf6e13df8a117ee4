"""Shapes: what there is to see of an object, in coordinates of space.

Positions are arrays ``(3,)`` or ``(n, 3)`` in metres; what lies in a plane has z = 0 and belongs to
an image without depth if everything in it does. Imaginary shapes have a negative squared radius:
their radius here is the root of its size, and they are drawn dashed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Points:
    """One or more points ``(n, 3)``."""

    positions: FloatArray
    kind: str = "point"

    def extent(self) -> FloatArray:
        """Points ``(k, 3)`` that the image must hold."""
        return self.positions


@dataclass(frozen=True, eq=False)
class Sphere:
    """A sphere."""

    center: FloatArray
    radius: float
    imaginary: bool = False

    @property
    def kind(self) -> str:
        """What it is called."""
        return "imaginary sphere" if self.imaginary else "sphere"

    def extent(self) -> FloatArray:
        """Points ``(k, 3)`` that the image must hold."""
        return self.center + self.radius * np.vstack([np.eye(3), -np.eye(3)])


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle about a unit normal; `filled` for the plane of a bivector."""

    center: FloatArray
    normal: FloatArray
    radius: float
    imaginary: bool = False
    filled: bool = False

    @property
    def kind(self) -> str:
        """What it is called."""
        if self.filled:
            return "bivector"
        return "imaginary circle" if self.imaginary else "circle"

    def extent(self) -> FloatArray:
        """Points ``(k, 3)`` that the image must hold."""
        return self.around(16)

    def around(self, count: int) -> FloatArray:
        """Points ``(count + 1, 3)`` once around, the last one the first again."""
        first, second = across(self.normal)
        turn: FloatArray = np.linspace(0.0, 2.0 * np.pi, count + 1)[:, None]
        return self.center + self.radius * (np.cos(turn) * first + np.sin(turn) * second)


@dataclass(frozen=True, eq=False)
class PlaneShape:
    """The plane through a point across a unit normal."""

    point: FloatArray
    normal: FloatArray
    kind: str = "plane"

    def nearest(self, place: FloatArray) -> FloatArray:
        """Its point that is nearest to a place."""
        foot: FloatArray = place - np.dot(place - self.point, self.normal) * self.normal
        return foot


@dataclass(frozen=True, eq=False)
class Line:
    """The line through a point along a unit direction."""

    point: FloatArray
    direction: FloatArray
    kind: str = "line"

    def nearest(self, place: FloatArray) -> FloatArray:
        """Its point that is nearest to a place."""
        along = np.dot(place - self.point, self.direction)
        foot: FloatArray = self.point + along * self.direction
        return foot


@dataclass(frozen=True, eq=False)
class PointPair:
    """Two points; those of an imaginary pair are drawn hollow."""

    first: FloatArray
    second: FloatArray
    imaginary: bool = False

    @property
    def kind(self) -> str:
        """What it is called."""
        return "imaginary point pair" if self.imaginary else "point pair"

    def extent(self) -> FloatArray:
        """Points ``(k, 3)`` that the image must hold."""
        return np.stack([self.first, self.second])


@dataclass(frozen=True, eq=False)
class Arrow:
    """A vector from a place."""

    start: FloatArray
    vector: FloatArray
    kind: str = "vector"

    def extent(self) -> FloatArray:
        """Points ``(k, 3)`` that the image must hold."""
        return np.stack([self.start, self.start + self.vector])


@dataclass(frozen=True, eq=False)
class Frames:
    """Where a motion takes the axes: origins ``(n, 3)`` and axes ``(n, 3, 3)``, rows of unit length
    but for the scale of the motion. Several are joined by their path.
    """

    origins: FloatArray
    axes: FloatArray
    flat: bool = False

    @property
    def kind(self) -> str:
        """What it is called."""
        return "pose" if len(self.origins) == 1 else "path"

    def extent(self) -> FloatArray:
        """Points ``(k, 3)`` that the image must hold."""
        return self.origins


Finite = Points | Sphere | Circle | PointPair | Arrow | Frames
Shape = Finite | PlaneShape | Line


def across(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors that make a right-handed frame with a unit normal as the third."""
    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(axis, normal)
    first = first / np.linalg.norm(first)
    return first, np.cross(normal, first)


def is_flat(shape: Shape) -> bool:
    """Whether a shape lies in the plane of x and y as those of plane algebras do."""
    if isinstance(shape, Points | PointPair | Arrow):
        return bool(np.all(_ends(shape)[:, 2] == 0.0))
    if isinstance(shape, Circle):
        return bool(shape.center[2] == 0.0 and abs(shape.normal[2]) == 1.0)
    if isinstance(shape, Line):
        return bool(shape.point[2] == 0.0 and shape.direction[2] == 0.0)
    return isinstance(shape, Frames) and shape.flat


def _ends(shape: Points | PointPair | Arrow) -> FloatArray:
    return shape.extent()
