"""The ground of a picture: axes with their numbers, and a grid of round steps."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.drawing.marks.mark import Dot, Extent, Label, Mark, ground_level, pieces

_AXES = "xyz"


def round_step(length: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is no more than a length.

    >>> from motorcade.ga.drawing.marks.ground import round_step
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
