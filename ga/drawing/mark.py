"""Marks: dots, strokes, faces, balls and names in space, of which every image is made.

Strokes and faces are short pieces, so that each is wholly before or behind what it crosses, but for
a piece's own size. Widths are in pixels, lengths in metres, colours as `colors` names them.

The ground of an image: axes with their numbers, and a grid of round steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

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
    across,
)

_CELLS = 10
_AXIS_COLORS = ("red", "green", "blue")
# How many poses of a path show their axes.
_MOST_AXES = 8


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line through points ``(n, 3)``."""

    points: FloatArray
    color: str
    width: float = 2.0
    dashed: bool = False
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class Face:
    """A flat polygon with corners ``(n, 3)``; `owner` tells apart faces of different objects."""

    points: FloatArray
    color: str
    opacity: float
    owner: int


@dataclass(frozen=True, eq=False)
class Dot:
    """A point, of a radius in pixels."""

    point: FloatArray
    color: str
    radius: float = 4.0
    hollow: bool = False


@dataclass(frozen=True, eq=False)
class BallMark:
    """A sphere with its shading, or the outline of an imaginary one."""

    center: FloatArray
    radius: float
    color: str
    imaginary: bool = False


@dataclass(frozen=True, eq=False)
class Label:
    """A text beside one of the places ``(n, 3)``, as far from it as `reach` in metres."""

    text: str
    places: FloatArray
    color: str
    reach: float = 0.0


Mark = Stroke | Face | Dot | BallMark | Label


@dataclass(frozen=True, eq=False)
class Extent:
    """What an image shows: the box of it, its middle, and how far it reaches from there."""

    low: FloatArray
    high: FloatArray
    radius: float

    @property
    def center(self) -> FloatArray:
        """The middle of the box."""
        return (self.low + self.high) / 2


def extent_of(shapes: list[Shape]) -> Extent:
    """The extent that holds all that is finite, and of planes and lines what is nearest to it."""
    unbounded = [shape for shape in shapes if isinstance(shape, PlaneShape | Line)]
    ends = [shape.extent() for shape in shapes if not isinstance(shape, PlaneShape | Line)]
    held = np.vstack(ends) if ends else np.zeros((1, 3))
    middle = (held.min(axis=0) + held.max(axis=0)) / 2
    held = np.vstack([held, *(shape.nearest(middle)[None] for shape in unbounded)])
    low, high = held.min(axis=0), held.max(axis=0)
    radius = float(np.linalg.norm(held - (low + high) / 2, axis=1).max())
    return Extent(low, high, radius if radius > 1e-12 * (1.0 + np.abs(held).max()) else 1.0)


def marks_of(shape: Shape, extent: Extent, color: str, owner: int) -> Iterator[Mark]:
    """The marks of a shape in an image of this extent."""
    if isinstance(shape, Points):
        for point in shape.positions:
            yield from _stem(point, extent)
            yield Dot(point, color)
    elif isinstance(shape, Sphere):
        yield from _sphere(shape, color)
    elif isinstance(shape, Circle):
        yield from _circle(shape, color, owner)
    elif isinstance(shape, PlaneShape):
        yield from _plane(shape, extent, color, owner)
    elif isinstance(shape, Line):
        yield from pieces(_line_ends(shape, extent), color, 30)
    elif isinstance(shape, PointPair):
        yield from pieces(shape.extent(), color, 16, width=1.2, dashed=True)
        yield from (Dot(point, color, hollow=shape.imaginary) for point in shape.extent())
    elif isinstance(shape, Arrow):
        yield from arrow(shape.start, shape.vector, color)
    else:
        yield from _frames(shape, extent, color)


def name_of(text: str, shape: Shape, extent: Extent, color: str) -> Label:
    """A name at one of the places where it may stand beside a shape."""
    if isinstance(shape, Sphere):
        return Label(text, shape.center[None], color, shape.radius)
    if isinstance(shape, Circle):
        return Label(text, shape.around(12)[:-1], color)
    if isinstance(shape, PlaneShape):
        return Label(text, 0.97 * (_corners(shape, extent) - extent.center) + extent.center, color)
    if isinstance(shape, Line):
        ends = _line_ends(shape, extent)
        return Label(text, np.stack([ends[1] * 0.95 + ends[0] * 0.05, ends[0]]), color)
    if isinstance(shape, Arrow):
        return Label(text, (shape.start + shape.vector)[None], color)
    if isinstance(shape, Frames):
        return Label(text, shape.origins[[-1, 0]], color)
    return Label(text, shape.extent()[::-1][:8], color)


def pieces(
    points: FloatArray,
    color: str,
    count: int,
    *,
    width: float = 2.0,
    dashed: bool = False,
    opacity: float = 1.0,
) -> Iterator[Stroke]:
    """A line through points in so many strokes; of a dashed one every second is left out."""
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(length)])
    stops = np.linspace(0.0, along[-1], count + 1)
    for k in range(0, count, 2 if dashed else 1):
        inner = points[(along > stops[k]) & (along < stops[k + 1])]
        ends = [[np.interp(s, along, points[:, i]) for i in range(3)] for s in stops[k : k + 2]]
        yield Stroke(np.vstack([ends[0], *inner, ends[1]]), color, width, dashed, opacity)


def arrow(start: FloatArray, vector: FloatArray, color: str, width: float = 2.0) -> Iterator[Mark]:
    """A vector with four barbs at its tip."""
    tip, length = start + vector, float(np.linalg.norm(vector))
    yield from pieces(np.stack([start, tip]), color, 12, width=width)
    first, second = across(vector / length)
    for side in (first, second, -first, -second):
        yield Stroke(np.stack([tip - 0.12 * vector + 0.05 * length * side, tip]), color, width)


def _stem(point: FloatArray, extent: Extent) -> Iterator[Mark]:
    """A thin line from a point down, or up, to the ground: without it one cannot tell its depth."""
    foot = np.array([point[0], point[1], ground_level(extent)])
    height = abs(float(point[2] - foot[2])) / extent.radius
    if height > 0.02:
        count = 1 + 2 * round(12.0 * min(height, 4.0))
        yield from pieces(np.stack([foot, point]), "axis", count, width=0.9, dashed=True)


def ground_level(extent: Extent) -> float:
    """At which height the ground lies: 0 where that is within reach, otherwise below all."""
    near = extent.low[2] - extent.radius <= 0.0 <= extent.high[2] + extent.radius
    return 0.0 if near else float(extent.low[2])


def _sphere(shape: Sphere, color: str) -> Iterator[Mark]:
    yield BallMark(shape.center, shape.radius, color, shape.imaginary)
    if shape.imaginary:
        return
    # Just outside, so that what lies on the far side is behind the ball.
    for axis in np.eye(3):
        around = Circle(shape.center, axis, 1.002 * shape.radius).around(48)
        yield from pieces(around, color, 16, width=0.9, opacity=0.55)


def _circle(shape: Circle, color: str, owner: int) -> Iterator[Mark]:
    around = shape.around(96)
    if shape.filled:
        yield Face(around[:-1], color, 0.25, owner)
    yield from pieces(around, color, 48, dashed=shape.imaginary)


def _corners(shape: PlaneShape, extent: Extent) -> FloatArray:
    """The square that stands for a plane, about its point nearest to the middle."""
    middle, (first, second) = shape.nearest(extent.center), across(shape.normal)
    sides = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return np.array([middle + 0.95 * extent.radius * (a * first + b * second) for a, b in sides])


def _plane(shape: PlaneShape, extent: Extent, color: str, owner: int) -> Iterator[Mark]:
    corners = _corners(shape, extent)
    start, along, up = corners[2], corners[3] - corners[2], corners[1] - corners[2]
    steps = np.linspace(0.0, 1.0, _CELLS + 1)
    for a, b in pairwise(steps):
        for c, d in pairwise(steps):
            cell = [start + s * along + t * up for s, t in ((a, c), (b, c), (b, d), (a, d))]
            yield Face(np.array(cell), color, 0.22, owner)
    yield from pieces(np.vstack([corners, corners[:1]]), color, 4 * _CELLS, width=1.1)


def _line_ends(shape: Line, extent: Extent) -> FloatArray:
    """The segment of a line that stands for it."""
    middle = shape.nearest(extent.center)
    off = float(np.linalg.norm(middle - extent.center))
    reach = max((1.3 * extent.radius) ** 2 - off**2, (0.8 * extent.radius) ** 2) ** 0.5
    return np.stack([middle - reach * shape.direction, middle + reach * shape.direction])


def _frames(shape: Frames, extent: Extent, color: str) -> Iterator[Mark]:
    count = len(shape.origins)
    if count > 1:
        yield from pieces(shape.origins, color, min(4 * count, 120))
    chosen = np.unique(np.linspace(0, count - 1, min(count, _MOST_AXES)).round().astype(int))
    length = (0.35 if count == 1 else 0.22) * extent.radius
    for k in chosen:
        for axis, axis_color in list(zip(shape.axes[k], _AXIS_COLORS, strict=True))[
            : 3 - shape.flat
        ]:
            yield from arrow(shape.origins[k], length * axis, axis_color, 1.8)
        yield Dot(shape.origins[k], color, 3.0)


_AXES = "xyz"


def round_step(length: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is no more than a length.

    >>> from motorcade.ga.drawing.mark import round_step
    >>> [round_step(x) for x in (0.07, 1.0, 4.9, 30.0)]
    [0.05, 1.0, 2.0, 20.0]
    """
    power = 10.0 ** math.floor(math.log10(length))
    factor = max(f for f in (1.0, 2.0, 5.0) if f * power <= length * (1.0 + 1e-9))
    return factor * power


def ground(extent: Extent, *, flat: bool) -> Iterator[Mark]:
    """The marks of the grid, of axes through the origin where that is near, and their numbers."""
    step = round_step(extent.radius / 2.0)
    room = (0.6 if flat else 0.25) * extent.radius
    low, high = extent.low - room, extent.high + room
    near = np.maximum(low, -high) < 2.0 * extent.radius  # there the box is to hold the origin
    low = np.floor(np.where(near, np.minimum(low, 0.0), low) / step) * step
    high = np.ceil(np.where(near, np.maximum(high, 0.0), high) / step) * step
    level = 0.0 if flat else ground_level(extent)
    origin = np.clip(np.zeros(3), low, high)
    origin[2] = level
    for axis in (0, 1):
        other = 1 - axis
        for at in np.arange(low[axis], high[axis] + step / 2, step):
            if abs(at - origin[axis]) < step / 2:  # there the other axis lies
                continue
            ends = np.full((2, 3), level)
            ends[:, axis], ends[:, other] = at, (low[other], high[other])
            yield from pieces(ends, "grid", 5, width=0.8)
    for axis in range(2 if flat else 3):
        first = float(low[axis]) if axis < 2 else level
        last = max(float(high[axis]), first + step)
        yield from _axis(axis, origin, step, first, last, all_numbers=flat)


def _axis(
    axis: int, origin: FloatArray, step: float, first: float, last: float, *, all_numbers: bool
) -> Iterator[Mark]:
    """One axis with its name, and the number of its last step or of all."""
    unit = np.eye(3)[axis]
    ends = np.stack([origin, origin])
    ends[:, axis] = first, last
    yield from pieces(ends, "axis", 12, width=1.2)
    yield Label(_AXES[axis], (ends[1] + 0.1 * step * unit)[None], "axis")
    stops = np.arange(math.ceil(first / step) * step, last - step / 2, step)
    for at in stops if all_numbers else stops[-1:]:
        if abs(at) > step / 2:
            place = origin.copy()
            place[axis] = at
            yield Dot(place, "axis", 1.6)
            yield Label(f"{round(at / step) * step:.6g}", place[None], "axis")
