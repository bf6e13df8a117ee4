"""What stands in the synthetic room, and its light, in metres: world z up, origin on the table top.

The board hangs upright like a poster on an easel and faces −x, towards the camera: its x is the
world's −y, its y the world's z. The table in front of it is free around the origin, where a
character of about 0.23 m stands. A box is a centre on its underside, a size and a turn about z.

The light is painted onto surfaces once: windows, a lamp, and what all sides send back.
Irradiance at a point is the sum over points of the window and of the opening behind the camera
(with both cosines and the square of the distance) that no box hides, plus light from all around
that near boxes hide (ambient occlusion), plus the lamp on the sideboard. Light is linear RGB; 1
lights white paper to white. The sample points are fixed, so light is free of noise and the same
in every run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.demo import furniture
from motorcade.tracking.boards import MarkerGrid

FLOOR_M, CEILING_M = -0.74, 1.90
WALLS_X_M, WALLS_Y_M = (-2.2, 2.6), (-1.75, 1.75)
# The window in the left wall: x from, x to, z from, z to.
WINDOW_M = (-0.55, 1.45, 0.10, 1.60)
# A wide opening behind the camera: y from, y to, z from, z to.
OPENING_M = (-1.20, 1.40, -0.30, 1.70)

BOARD = MarkerGrid("tag36h11", 3, 2, 0.08, 0.02)
BOARD_MIDDLE_M = (0.170, 0.120, 0.140)
BOARD_THICKNESS_M = 0.006

# The images of the room are seen by this camera.
CHARACTER_HEIGHT_M = 0.23


@dataclass(frozen=True)
class Box:
    """A box that stands on something.

    Attributes:
        base_m: (3,) centre of its underside.
        size_m: (3,) along its own x, y and z.
        material: of all faces.
        front: material of the face towards −x of its own, where it differs.
        top: material of the upper face, where it differs.
        turn_rad: about z.
        hides: whether it hides light from others; small things among many do not.
    """

    base_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    material: str
    front: str = ""
    top: str = ""
    turn_rad: float = 0.0
    hides: bool = True


@dataclass(frozen=True)
class Turned:
    """A body of revolution about z: (height, radius) controls above a foot, in metres.

    Its upper end is closed by a disc of the colour `inside`; colours are sRGB.
    """

    foot_m: tuple[float, float, float]
    outline_m: tuple[tuple[float, float], ...]
    color: tuple[float, float, float]
    inside: tuple[float, float, float]


def world_T_board() -> Motor:
    """Pose of the board's frame: origin at the printed top-left corner of its first marker."""
    width, height = BOARD.size_m
    x, y, z = BOARD_MIDDLE_M
    turn = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    corner = np.array([x, y + 0.5 * width, z + 0.5 * height])
    return Motor.from_rotor_translation(Rotor.from_matrix(turn), corner)


def boxes() -> list[Box]:
    """Every box of the room."""
    return [*_table(), *_easel(), *_table_things(), *_sideboard(), *_bookcase(), *_corner()]


def _table() -> list[Box]:
    """A stone top on four legs."""
    top = Box((0.02, 0.0, -0.03), (1.16, 1.70, 0.03), "oak", top="stone")
    legs = [
        Box((0.02 + sx * 0.52, sy * 0.78, FLOOR_M), (0.05, 0.05, -0.03 - FLOOR_M), "oak")
        for sx in (-1.0, 1.0)
        for sy in (-1.0, 1.0)
    ]
    return [top, *legs]


def _easel() -> list[Box]:
    """The printed board, a ledge under it and two props behind."""
    quiet = BOARD.pattern.quiet_m
    width, height = BOARD.size_m[0] + 2.0 * quiet, BOARD.size_m[1] + 2.0 * quiet
    x, y, z = BOARD_MIDDLE_M
    behind = x + BOARD_THICKNESS_M
    low = z - 0.5 * height
    return [
        Box((x + 0.5 * BOARD_THICKNESS_M, y, low), (BOARD_THICKNESS_M, width, height), "paper",
            front="board"),
        Box((x + 0.012, y, 0.0), (0.060, width + 0.03, low), "walnut"),
        Box((behind + 0.009, y - 0.07, low), (0.018, 0.022, 0.18), "walnut"),
        Box((behind + 0.009, y + 0.07, low), (0.018, 0.022, 0.18), "walnut"),
    ]  # fmt: skip


def _table_things() -> list[Box]:
    """Books, a framed cat and a sheet of paper, clear of the place to stand."""
    turn = math.radians
    return [
        Box((0.26, -0.33, 0.0), (0.17, 0.24, 0.030), "navy", turn_rad=turn(8.0)),
        Box((0.265, -0.33, 0.030), (0.155, 0.22, 0.024), "cream", turn_rad=turn(-6.0)),
        Box((0.26, -0.325, 0.054), (0.14, 0.20, 0.028), "rust", turn_rad=turn(14.0)),
        Box((0.33, 0.53, 0.0), (0.016, 0.27, 0.20), "walnut", front="cat", turn_rad=turn(24.0)),
        Box((-0.12, -0.42, 0.0), (0.21, 0.297, 0.0015), "paper", top="page", turn_rad=turn(-17.0)),
    ]


def _sideboard() -> list[Box]:
    """A low sideboard at the far wall with books, under two images."""
    x = WALLS_X_M[1]
    body = Box((x - 0.23, 0.50, FLOOR_M), (0.44, 1.70, 0.70), "oak", front="doors")
    things = [Box((x - 0.20, 0.20, -0.04), (0.20, 0.26, 0.035), "teal")]
    things.append(Box((x - 0.20, 0.20, -0.005), (0.18, 0.24, 0.030), "cream", turn_rad=0.2))
    tones = ("rust", "navy", "cream", "teal", "ochre", "navy", "cream", "rust")
    y = 0.62
    for k, tone in enumerate(tones):
        thick, tall = 0.030 + 0.012 * (k * 5 % 3), 0.22 + 0.025 * (k * 7 % 4)
        things.append(
            Box((x - 0.18, y + 0.5 * thick, -0.04), (0.16, thick, tall), tone, hides=False)
        )
        y += thick + 0.003
    images = [
        Box((x - 0.015, 0.95, 0.42), (0.03, 0.66, 0.66), "walnut", front="astronaut"),
        Box((x - 0.015, 0.15, 0.52), (0.03, 0.72, 0.48), "walnut", front="coffee"),
    ]
    return [body, *things, *images]


def _bookcase() -> list[Box]:
    """A tall bookcase to the right, its shelves half full."""
    x, y, width = WALLS_X_M[1], -1.16, 0.92
    shelf = 0.34
    parts = [
        Box((x - 0.15, y + side * 0.5 * width, FLOOR_M), (0.30, 0.03, 2.1), "oak")
        for side in (-1.0, 1.0)
    ]
    tones = ("navy", "cream", "rust", "ochre", "teal", "plum", "cream")
    for level in range(7):
        z = FLOOR_M + 0.04 + level * shelf
        parts.append(Box((x - 0.15, y, z - 0.02), (0.30, width, 0.02), "oak"))
        reach = 0.62 + 0.24 * ((level * 3) % 4) / 3.0
        at, k = y + 0.5 * width - 0.03, level
        while level < 6 and at > y + (0.5 - reach) * width:
            thick, tall = 0.032 + 0.011 * (k * 5 % 4), 0.20 + 0.024 * (k * 7 % 4)
            parts.append(
                Box(
                    (x - 0.13, at - 0.5 * thick, z),
                    (0.19, thick, tall),
                    tones[k % len(tones)],
                    hides=False,
                )
            )
            at, k = at - thick - 0.003, k + 1
    return parts


def _corner() -> list[Box]:
    """An image on the right wall and a crate of greenery behind the table."""
    y = WALLS_Y_M[0]
    return [
        Box(
            (1.25, y + 0.015, 0.36),
            (0.03, 0.62, 0.62),
            "walnut",
            front="hubble",
            turn_rad=-0.5 * math.pi,
        ),
        Box((1.75, 1.30, FLOOR_M), (0.42, 0.42, 0.46), "rust", top="grass"),
    ]


def turned_bodies() -> list[Turned]:
    """Vases, a mug and a lamp."""
    vase = (
        (0.0, 0.030),
        (0.01, 0.036),
        (0.05, 0.050),
        (0.085, 0.047),
        (0.125, 0.024),
        (0.155, 0.020),
        (0.165, 0.024),
    )
    mug = ((0.0, 0.034), (0.004, 0.038), (0.05, 0.040), (0.088, 0.040), (0.092, 0.037))
    bowl = ((0.0, 0.030), (0.012, 0.045), (0.035, 0.066), (0.045, 0.068))
    lamp = (
        (0.0, 0.085),
        (0.02, 0.090),
        (0.16, 0.11),
        (0.28, 0.085),
        (0.33, 0.03),
        (0.40, 0.018),
        (0.41, 0.15),
        (0.44, 0.155),
        (0.66, 0.105),
        (0.665, 0.10),
    )
    x = WALLS_X_M[1]
    return [
        Turned((0.265, -0.325, 0.082), vase, (0.86, 0.84, 0.78), (0.2, 0.19, 0.17)),
        Turned((0.02, 0.42, 0.0), mug, (0.16, 0.42, 0.46), (0.16, 0.09, 0.05)),
        Turned((0.36, 0.24, 0.0), bowl, (0.80, 0.52, 0.32), (0.55, 0.33, 0.20)),
        Turned((x - 0.24, -0.22, -0.04), lamp, (0.98, 0.90, 0.72), (1.0, 0.95, 0.8)),
    ]


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
