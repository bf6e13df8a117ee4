"""Where marks come to lie in an image, and in which order they are drawn.

The projection is parallel. The viewer is in the direction ``d = (cos e cos a, cos e sin a, sin e)``
for an azimuth a and an elevation e; to the right goes ``r = (-sin a, cos a, 0)``, and up goes
``u = d × r``. A point p lies at ``(x + s p·r, y - s p·u)`` in the image, with a scale s and a
shift (x, y) that let all marks just fit; it is the nearer to the viewer the larger ``p·d``.
``turning.js`` does the same in the browser.

Far marks are drawn first. A ball is drawn as its far and its near half; what lies inside comes
between them, what lies before or behind it comes after or before both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.drawing.mark import BallMark, Dot, Face, Label, Mark, Stroke

MARGIN = 30.0
# What lies as near as this to a ball's surface, in radii, lies outside.
_SURFACE = 0.01
# Pixels count downwards.
_DOWN = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True, eq=False)
class View:
    """A parallel projection onto an image of so many pixels; `flat` looks down along z.

    Raises:
        ValueError: angles that are not finite, an image smaller than 100 or larger than 10000.
    """

    azimuth_deg: float = -52.0
    elevation_deg: float = 22.0
    width: int = 640
    height: int = 480
    flat: bool = False

    def __post_init__(self) -> None:
        if not np.isfinite([self.azimuth_deg, self.elevation_deg]).all():
            raise ValueError(
                f"view: expected finite angles, got {self.azimuth_deg} and {self.elevation_deg}"
            )
        if not 100 <= min(self.width, self.height) <= max(self.width, self.height) <= 10_000:
            raise ValueError(
                f"view: expected from 100 to 10000 pixels, got {self.width} x {self.height}"
            )

    def axes(self) -> FloatArray:
        """The unit vectors right, up and to the viewer, as rows."""
        if self.flat:
            return np.eye(3)
        a, e = np.radians([self.azimuth_deg, self.elevation_deg])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        viewer = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        return np.stack([right, np.cross(viewer, right), viewer])


@dataclass(frozen=True, eq=False)
class Placed:
    """A mark with its points in the image ``(n, 3)``: x and y in pixels, and the depth."""

    mark: Mark
    points: FloatArray
    key: tuple[float, float]
    radius: float = 0.0
    near: bool = False


@dataclass(frozen=True, eq=False)
class Projection:
    """A view, enlarged and shifted so that its marks fill the image."""

    view: View
    scale: float
    shift: FloatArray

    def place(self, points: FloatArray) -> FloatArray:
        """Points ``(n, 3)`` of space in the image; depths are in pixels too."""
        turned = self.scale * (points @ self.view.axes().T)
        rotated: FloatArray = turned * _DOWN + self.shift
        return rotated


def projection_of(view: View, marks: list[Mark]) -> Projection:
    """The view that just holds all marks."""
    points = np.vstack([_points(mark, view.axes()) for mark in marks]) @ view.axes().T
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.array([view.width, view.height])
    scale = float(np.min((size - 2 * MARGIN) / np.maximum((high - low)[:2], 1e-300)))
    middle = scale * (low + high) / 2 * _DOWN
    return Projection(view, scale, np.array([*(size / 2), 0.0]) - middle)


def placed(marks: list[Mark], projection: Projection) -> list[Placed]:
    """The marks in the order in which they are drawn, names left out."""
    balls = [mark for mark in marks if isinstance(mark, BallMark) and not mark.imaginary]
    spots = [
        (projection.place(ball.center[None])[0], ball.radius * projection.scale) for ball in balls
    ]
    placed = []
    for mark in marks:
        if isinstance(mark, Label):
            continue
        points = projection.place(_own_points(mark))
        if isinstance(mark, BallMark):
            radius = mark.radius * projection.scale
            depth = float(points[0, 2])
            placed.append(Placed(mark, points, (depth - radius / 2, -1e9), radius))
            if not mark.imaginary:
                placed.append(Placed(mark, points, (depth + radius / 2, -1e9), radius, near=True))
        else:
            placed.append(Placed(mark, points, _key(points.mean(axis=0), spots)))
    return sorted(placed, key=lambda item: item.key)


def _key(middle: FloatArray, spots: list[tuple[FloatArray, float]]) -> tuple[float, float]:
    """The depth at which a mark is drawn, and its own among those drawn at the same."""
    depth = float(middle[2])
    low, high = -np.inf, np.inf
    for center, radius in spots:
        square = radius**2 - float(np.sum((middle[:2] - center[:2]) ** 2))
        if square <= 0.0:
            continue
        off, half = depth - float(center[2]), square**0.5 - _SURFACE * radius
        if off > half:
            low = max(low, center[2] + radius / 2)
        elif off < -half:
            high = min(high, center[2] - radius / 2 - 1e-6)
        else:
            low = max(low, center[2] - radius / 2)
            high = min(high, center[2] + radius / 2 - 1e-6)
    return float(max(min(depth, high), low)), depth


def _own_points(mark: Mark) -> FloatArray:
    if isinstance(mark, Stroke | Face):
        return mark.points
    if isinstance(mark, Dot):
        return mark.point[None]
    return mark.center[None] if isinstance(mark, BallMark) else mark.places


def _points(mark: Mark, axes: FloatArray) -> FloatArray:
    """What an image must hold of a mark."""
    if isinstance(mark, BallMark):
        return mark.center + mark.radius * np.vstack([axes, -axes])
    return _own_points(mark)
