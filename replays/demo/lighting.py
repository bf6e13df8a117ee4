"""The room's light, painted onto its surfaces once: windows, a lamp, and what all sides send back.

Irradiance at a point is the sum over points of the window and of the opening behind the camera
(with both cosines and the square of the distance) that no box hides, plus light from all around
that near boxes hide (ambient occlusion), plus the lamp on the sideboard. Light is linear RGB; 1
lights white paper to white. The sample points are fixed, so light is free of noise and the same
in every run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.replays.demo import furniture

Points = NDArray[np.float32]

DAYLIGHT = np.array([1.00, 0.965, 0.915]) * 2.45
FROM_BEHIND = np.array([0.90, 0.95, 1.00]) * 1.05
AROUND = np.array([0.185, 0.19, 0.205])
FROM_BELOW = np.array([0.12, 0.105, 0.085])
LAMP_M, LAMPLIGHT = np.array([2.30, -0.22, 0.52]), np.array([1.0, 0.72, 0.40]) * 0.10
WINDOW_GRID, OPENING_GRID, AROUND_SAMPLES = (6, 4), (3, 2), 28
REACH_M = 0.7
CHUNK = 2000


@dataclass(frozen=True)
class Occluders:
    """Boxes that hide light, as arrays: each is half-sizes about a centre, turned about z."""

    center_m: Points
    half_m: Points
    cos: Points
    sin: Points

    @classmethod
    def of(cls, boxes: Sequence[furniture.Box]) -> Occluders:
        """The occluders of these boxes; sheets thinner than 3 mm hide nothing."""
        thick = [box for box in boxes if box.hides and min(box.size_m) > 0.003]
        base = np.array([box.base_m for box in thick])
        size = np.array([box.size_m for box in thick])
        turn = np.array([box.turn_rad for box in thick])
        base[:, 2] += 0.5 * size[:, 2]
        parts = (base, 0.5 * size, np.cos(turn), np.sin(turn))
        return cls(*(part.astype(np.float32) for part in parts))

    def near(self, low: Points, high: Points) -> Occluders:
        """Those that reach into a box of the world."""
        radius = np.linalg.norm(self.half_m, axis=1)[:, None]
        close = np.all((self.center_m + radius > low) & (self.center_m - radius < high), axis=1)
        return Occluders(self.center_m[close], self.half_m[close], self.cos[close], self.sin[close])

    def hide(self, start: Points, step: Points) -> NDArray[np.bool_]:
        """Whether a box stands between `start` and `start + step`, for rays (N, 3)."""
        if not len(start):
            return np.zeros(0, dtype=bool)
        ends = np.concatenate([start, start + step])
        boxes = self.near(ends.min(axis=0), ends.max(axis=0))
        # A row a box, all rays at once: (K, N).
        x, y, z = (start[:, k] - boxes.center_m[:, k, None] for k in range(3))
        c, s = boxes.cos[:, None], boxes.sin[:, None]
        near, far = np.float32(1e-4), np.float32(1.0)
        for axis, (origin, way) in enumerate(
            (
                (c * x + s * y, c * step[:, 0] + s * step[:, 1]),
                (c * y - s * x, c * step[:, 1] - s * step[:, 0]),
                (z, step[None, :, 2]),
            )
        ):
            inverse = 1.0 / np.where(np.abs(way) < 1e-9, np.float32(1e-9), way)
            half = boxes.half_m[:, axis, None]
            low, two = (-half - origin) * inverse, (half - origin) * inverse
            near = np.maximum(near, np.minimum(low, two))
            far = np.minimum(far, np.maximum(low, two))
        return np.asarray(np.any(near < far, axis=0))


def irradiance(points: FloatArray, normals: FloatArray, occluders: Occluders) -> FloatArray:
    """Light that arrives at surface points.

    Args:
        points: (N, 3) world; neighbours in the array should be neighbours in the room.
        normals: (N, 3) unit.
        occluders: what hides light.

    Returns:
        (N, 3) linear RGB.
    """
    x0, x1, z0, z1 = furniture.WINDOW_M
    window = _grid((x0, furniture.WALLS_Y_M[1], z0), (x1 - x0, 0, 0), (0, 0, z1 - z0), WINDOW_GRID)
    y0, y1, z0, z1 = furniture.OPENING_M
    opening = _grid(
        (furniture.WALLS_X_M[0], y0, z0), (0, y1 - y0, 0), (0, 0, z1 - z0), OPENING_GRID
    )
    total = np.empty((len(points), 3))
    for begin in range(0, len(points), CHUNK):
        part = slice(begin, begin + CHUNK)
        facing = normals[part].astype(np.float32)
        at = (points[part] + 2e-3 * normals[part]).astype(np.float32)
        total[part] = (
            _from_area(at, facing, occluders, window, 1) * DAYLIGHT
            + _from_area(at, facing, occluders, opening, 0) * FROM_BEHIND
            + _from_around(at, facing, occluders)
            + _from_lamp(at, facing, occluders)
        )
    return total


def _grid(
    corner: tuple[float, ...],
    across: tuple[float, ...],
    up: tuple[float, ...],
    cells: tuple[int, int],
) -> tuple[Points, float]:
    """Points spread evenly over a rectangle, and the area of each."""
    u = (np.arange(cells[0]) + 0.5) / cells[0]
    # Every other row is shifted by half a cell, so that shadows of posts do not step together.
    v = (np.arange(cells[1]) + 0.5) / cells[1]
    uu, vv = np.meshgrid(u, v)
    uu = np.mod(uu + 0.5 / cells[0] * (np.arange(cells[1]) % 2)[:, None], 1.0)
    a, b = np.array(across), np.array(up)
    points = np.array(corner) + uu.reshape(-1, 1) * a + vv.reshape(-1, 1) * b
    area = float(np.linalg.norm(a) * np.linalg.norm(b)) / points.shape[0]
    return points.astype(np.float32), area


def _from_area(
    at: Points, facing: Points, occluders: Occluders, source: tuple[Points, float], axis: int
) -> FloatArray:
    """Share (N, 1) of a bright rectangle's light that arrives; `axis` is its normal's."""
    light = np.zeros(len(at))
    points, area = source
    every = np.concatenate([at, points])
    between = occluders.near(every.min(axis=0), every.max(axis=0))
    for target in points:
        step = target - at
        square = np.sum(step * step, axis=1)
        cosines = np.maximum(np.sum(step * facing, axis=1), 0.0) * np.abs(step[:, axis])
        value = area * cosines / np.maximum(square * square, 1e-3)
        lit = np.flatnonzero(value > 1e-6)
        value[lit[between.hide(at[lit], step[lit])]] = 0.0
        light += value
    return np.asarray(light[:, None] * (2.0 / np.pi))


def _from_around(at: Points, facing: Points, occluders: Occluders) -> FloatArray:
    """Light from all sides, hidden by boxes within reach; a warmer part comes from below."""
    near = occluders.near(at.min(axis=0) - REACH_M, at.max(axis=0) + REACH_M)
    open_share = np.zeros(len(at))
    for way in _sphere(AROUND_SAMPLES):
        step = way + facing
        step *= REACH_M / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-3)
        open_share += ~near.hide(at, step.astype(np.float32))
    open_share *= _corner_share(at, facing) / AROUND_SAMPLES
    below = 0.5 * (1.0 - facing[:, 2:3])
    return np.asarray(open_share[:, None] * (AROUND + FROM_BELOW * below))


def _sphere(count: int) -> Points:
    """Directions spread evenly (a Fibonacci spiral)."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    angle = k * np.pi * (3.0 - np.sqrt(5.0))
    radius = np.sqrt(1.0 - z * z)
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
    return ring.astype(np.float32)


def _corner_share(at: Points, facing: Points) -> FloatArray:
    """How much of its surroundings a point sees where walls, floor and ceiling meet."""
    share = np.ones(len(at))
    for axis, (low, high) in enumerate(
        (furniture.WALLS_X_M, furniture.WALLS_Y_M, (furniture.FLOOR_M, furniture.CEILING_M))
    ):
        level = np.abs(facing[:, axis]) < 0.5
        distance = np.minimum(at[:, axis] - low, high - at[:, axis])
        share *= np.where(level, 1.0 - 0.42 * np.exp(-np.maximum(distance, 0.0) / 0.22), 1.0)
    return share


def _from_lamp(at: Points, facing: Points, occluders: Occluders) -> FloatArray:
    """The warm lamp on the sideboard."""
    step = (LAMP_M - at).astype(np.float32)
    square = np.maximum(np.sum(step * step, axis=1), 0.02)
    value = np.maximum(np.sum(step * facing, axis=1), 0.0) / square**1.5
    lit = np.flatnonzero(value * LAMPLIGHT.max() > 1e-3)
    value[lit[occluders.hide(at[lit], step[lit])]] *= 0.25
    return np.asarray(value[:, None] * LAMPLIGHT)
