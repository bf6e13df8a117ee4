"""Signed distances of the figure's building blocks, and how they melt into one another.

One block does for every part: a straight axis around which an ellipse changes its half-widths and
its place along smooth curves, closed by half ellipsoids. With one station it is an ellipsoid, with
two a round cone, with many a limb with its muscles. Values are distances in metres to first order
near the surface, which is what Newton steps and unions need; far away only their sign is good.
Source of the estimate for ellipsoids and of the smooth minimum: I. Quílez, "Distance functions"
and "Smooth minimum", iquilezles.org.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, IntArray

SAMPLES = 129
FAR_M = 1.0


@dataclass(frozen=True, eq=False)
class BodyBlock:
    """A part of a body.

    Attributes:
        origin_m: (3,) where the axis has its zero.
        axes: (3, 3) rows: first and second cross axis, axis.
        span_m: first and last station along the axis.
        profile_m: (SAMPLES, 4) half-widths along the cross axes and shifts of the centre along
            them, at even steps of the span.
        caps_m: how far the two ends are rounded beyond the span.
        blend_m: width of its seam with what is there already.
        carve: whether it is taken away rather than added.
        low_m, high_m: (3,) corners of a box around it.
    """

    origin_m: FloatArray
    axes: FloatArray
    span_m: tuple[float, float]
    profile_m: FloatArray
    caps_m: tuple[float, float]
    blend_m: float
    carve: bool
    low_m: FloatArray
    high_m: FloatArray

    def distance_m(self, points_m: FloatArray) -> FloatArray:
        """Signed distances (N,) of points (N, 3), negative inside."""
        local = (points_m - self.origin_m) @ self.axes.T
        first, last = self.span_m
        along = np.clip(local[:, 2], first, last)
        beyond = local[:, 2] - along
        place = (along - first) * ((SAMPLES - 1) / max(last - first, 1e-9))
        k = np.minimum(place.astype(np.int64), SAMPLES - 2)
        share = (place - k)[:, None]
        here = self.profile_m[k] * (1.0 - share) + self.profile_m[k + 1] * share
        cap = np.where(beyond < 0.0, self.caps_m[0], self.caps_m[1])
        half = np.stack([here[:, 0], here[:, 1], cap], axis=1)
        scaled = np.stack([local[:, 0] - here[:, 2], local[:, 1] - here[:, 3], beyond], axis=1)
        scaled /= half
        size = np.sqrt(np.einsum("ni,ni->n", scaled, scaled))
        steep = scaled / half
        slope = np.sqrt(np.einsum("ni,ni->n", steep, steep))
        return np.asarray(size * (size - 1.0) / np.maximum(slope, 1e-9) - 1e-9 * (size < 1e-6))


def block(
    origin_m: ArrayLike,
    axes: ArrayLike,
    rows: Sequence[tuple[float, ...]],
    caps_m: tuple[float, float],
    blend_m: float,
    *,
    carve: bool = False,
) -> BodyBlock:
    """A block from rows `(station, half_1, half_2[, shift_1[, shift_2]])`, in metres.

    Args:
        origin_m: (3,).
        axes: (3, 3) orthonormal rows: first cross axis, second, axis.
        rows: at rising stations.
        caps_m: rounding beyond the first and the last station.
        blend_m: see `Block`.
        carve: see `Block`.
    """
    table = np.array([row + (0.0,) * (5 - len(row)) for row in rows])
    at = np.linspace(table[0, 0], table[-1, 0], SAMPLES)
    curves = [smooth_curve(table[:, 0], table[:, column], at) for column in range(1, 5)]
    profile, turn, start = np.stack(curves, axis=1), np.array(axes), np.array(origin_m)
    centre = profile[:, 2:] @ turn[:2] + at[:, None] * turn[2]
    caps = np.zeros((SAMPLES, 1))
    caps[0], caps[-1] = caps_m
    half = np.sqrt(np.hstack([profile[:, :2], caps]) ** 2 @ turn**2)
    low, high = (centre - half).min(axis=0) + start, (centre + half).max(axis=0) + start
    span = (float(table[0, 0]), float(table[-1, 0]))
    return BodyBlock(start, turn, span, profile, caps_m, blend_m, carve, low, high)


@dataclass(frozen=True, eq=False)
class BodyField:
    """Blocks melted together in their order: a solid, cut off flat at the ground z = 0.

    Args:
        blocks: of the half with y of 0 or more; the other half is its mirror image.
        sole_m: width over which the edge of the cut is rounded.
    """

    blocks: tuple[BodyBlock, ...]
    sole_m: float

    def distance_m(self, points_m: FloatArray, near_m: float = 0.0) -> FloatArray:
        """Signed distances (N,) of points (N, 3).

        Args:
            points_m: anywhere.
            near_m: how far from the surface values shall still be good.
        """
        half = points_m.copy()
        half[:, 1] = np.abs(half[:, 1])
        columns = np.ascontiguousarray(half.T)
        total = np.full(len(half), FAR_M)
        for part in self.blocks:
            reach = part.blend_m + near_m + 1e-3
            index = _within(columns, part.low_m - reach, part.high_m + reach)
            own = part.distance_m(half[index])
            if part.carve:
                total[index] = -_melted(-total[index], own, part.blend_m)
            else:
                total[index] = _melted(total[index], own, part.blend_m)
        low = np.flatnonzero(half[:, 2] < near_m + 2.0 * self.sole_m)
        total[low] = -_melted(-total[low], half[low, 2], self.sole_m)
        return total

    def gradient(self, points_m: FloatArray, step_m: float = 2e-4) -> FloatArray:
        """Slopes (N, 3) of the distance, from four points around each one."""
        corners = np.array([[1.0, -1.0, -1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, 1.0, 1]])
        around = (points_m[:, None] + step_m * corners).reshape(-1, 3)
        values = self.distance_m(around, 2.0 * step_m).reshape(-1, 4)
        return np.asarray(values @ corners / (4.0 * step_m))


def _within(columns: FloatArray, low: FloatArray, high: FloatArray) -> IntArray:
    """Numbers of the points in a box, from their coordinates (3, N)."""
    index = np.flatnonzero((columns[2] > low[2]) & (columns[2] < high[2]))
    for axis in (1, 0):
        own = columns[axis, index]
        index = index[(own > low[axis]) & (own < high[axis])]
    return index


def _melted(first: FloatArray, second: FloatArray, width: float) -> FloatArray:
    """Minimum of two distances, rounded where they differ by less than `width`."""
    mixed = np.maximum(width - np.abs(first - second), 0.0) / width
    return np.asarray(np.minimum(first, second) - mixed * mixed * mixed * (width / 6.0))


def smooth_curve(stations: FloatArray, controls: FloatArray, at: FloatArray) -> FloatArray:
    """Values of a cubic curve through controls, without overshoot between them.

    Piecewise cubic Hermite with the limited slopes of Fritsch and Butland (1984), so that a limb
    never grows wider than the wider of two neighbouring controls.

    Args:
        stations: (K,) increasing.
        controls: (K,) values there.
        at: (*,) positions; outside the stations the end values hold.
    """
    if len(stations) < 2:
        return np.full(at.shape, controls[0])
    step = np.diff(stations)
    secant = np.diff(controls) / step
    slope = np.zeros(len(stations))
    left, right = secant[:-1], secant[1:]
    same = left * right > 0.0
    first, second = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
    denominator = np.where(same, first * right + second * left, 1.0)
    slope[1:-1] = np.where(same, (first + second) * left * right / denominator, 0.0)
    slope[0], slope[-1] = secant[0], secant[-1]
    place = np.clip(at, stations[0], stations[-1])
    k = np.clip(np.searchsorted(stations, place, side="right") - 1, 0, len(step) - 1)
    u = (place - stations[k]) / step[k]
    rise = controls[k] * (1 + 2 * u) * (1 - u) ** 2 + controls[k + 1] * (3 - 2 * u) * u**2
    slopes = slope[k] * u * (1 - u) ** 2 - slope[k + 1] * u**2 * (1 - u)
    return np.asarray(rise + step[k] * slopes)
