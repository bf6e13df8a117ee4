"""What stands in the synthetic room, in metres: world z up, origin on the table top.

The board hangs upright like a poster on an easel and faces −x, towards the camera: its x is the
world's −y, its y the world's z. The table in front of it is free around the origin, where a
character of about 0.23 m stands. A box is a centre on its underside, a size and a turn about z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor, Rotor
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
