"""The textured room: a corridor around a block that reaches the ceiling, with boxes in it.

World: metres, z up, floor at z = 0, origin in the middle of the block. From no place can one see
the whole corridor, so whoever walks around the block leaves the start's view and comes back to it.
Every face has a texture of its own that repeats nowhere: noise of many sizes under random bars.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray

__all__ = ["Panel", "Room", "bars_over_noise", "furnished_room", "upright_box"]

WALL_X_M, WALL_Y_M, CEILING_M = 4.0, 3.0, 2.6
BLOCK_X_M, BLOCK_Y_M = 1.8, 1.0
TEXELS_PER_M = 256
TILE_M = 1.0
"""Panels are cut into tiles of about this size, each drawn at the fineness that suits it."""
_BARS_PER_M2 = 30
_PLAIN_GRAY = 128
# centre x, y; size x, y, z (m); turn about z (rad)
_BOXES = (
    (3.45, 2.45, 0.7, 0.6, 1.1, 0.3),
    (3.60, -2.50, 0.5, 0.6, 0.8, -0.4),
    (-3.45, 2.50, 0.6, 0.7, 1.4, 0.5),
    (-3.50, -2.40, 0.7, 0.5, 0.6, 0.2),
    (0.60, 2.72, 0.9, 0.4, 0.9, 0.0),
    (-1.10, -2.70, 0.8, 0.4, 0.7, 0.05),
    (3.70, 0.30, 0.4, 0.7, 0.5, 0.0),
    (-3.70, -0.40, 0.4, 0.8, 1.0, 0.0),
)


@dataclass(frozen=True, eq=False)
class Panel:
    """A textured rectangle, seen from one side.

    Args:
        corner_m: ``(3,)`` where the texture's upper left corner lies.
        right_m, down_m: ``(3,)`` from there along the texture's rows and columns, to its ends;
            ``right x down`` points away from who sees it.
        texture: ``(h, w)`` uint8.
    """

    corner_m: FloatArray
    right_m: FloatArray
    down_m: FloatArray
    texture: NDArray[np.uint8]

    def tiles(self) -> list[Panel]:
        """The panel cut into tiles of about `TILE_M`, cut between texels."""
        height, width = self.texture.shape
        down = _cuts(float(np.linalg.norm(self.down_m)), height)
        right = _cuts(float(np.linalg.norm(self.right_m)), width)
        return [
            Panel(
                self.corner_m + self.right_m * (left / width) + self.down_m * (top / height),
                self.right_m * ((end - left) / width),
                self.down_m * ((bottom - top) / height),
                self.texture[top:bottom, left:end],
            )
            for top, bottom in pairwise(down)
            for left, end in pairwise(right)
        ]


@dataclass(frozen=True, eq=False)
class Room:
    """All panels of a room."""

    panels: tuple[Panel, ...]


def furnished_room(rng: np.random.Generator, *, textured: bool = True) -> Room:
    """The corridor with its boxes; without texture every face has the same grey.

    Args:
        rng: of the textures; the shape is always the same.
        textured: whether there is anything to see.
    """
    shell = upright_box((0.0, 0.0), (2 * WALL_X_M, 2 * WALL_Y_M, CEILING_M), 0.0)
    faces = [_flipped(*face) for face in shell]
    faces += upright_box((0.0, 0.0), (2 * BLOCK_X_M, 2 * BLOCK_Y_M, CEILING_M), 0.0)[:4]
    for x, y, sx, sy, sz, turn in _BOXES:
        faces += upright_box((x, y), (sx, sy, sz), turn)[:5]
    return Room(
        tuple(Panel(*face, bars_over_noise(face[1], face[2], rng, textured)) for face in faces)
    )


Face = tuple[FloatArray, FloatArray, FloatArray]


def upright_box(
    centre_m: tuple[float, float], size_m: tuple[float, float, float], turn_rad: float
) -> list[Face]:
    """Corner, right and down of a box's faces seen from outside: four sides, top, bottom."""
    sx, sy, sz = size_m
    x = sx * np.array([np.cos(turn_rad), np.sin(turn_rad), 0.0])
    y = sy * np.array([-np.sin(turn_rad), np.cos(turn_rad), 0.0])
    z = np.array([0.0, 0.0, sz])
    low = np.array([*centre_m, 0.0]) - 0.5 * (x + y)
    return [
        (low + z, x, -z),
        (low + x + z, y, -z),
        (low + x + y + z, -x, -z),
        (low + y + z, -y, -z),
        (low + y + z, x, -y),
        (low, x, y),
    ]


def _flipped(corner: FloatArray, right: FloatArray, down: FloatArray) -> Face:
    """The same rectangle seen from its other side."""
    return corner + right, -right, down


def bars_over_noise(
    right: FloatArray, down: FloatArray, rng: np.random.Generator, textured: bool = True
) -> NDArray[np.uint8]:
    """Noise of many sizes under randomly turned bars, without detail finer than two texels."""
    width, height = (max(8, round(float(np.linalg.norm(e)) * TEXELS_PER_M)) for e in (right, down))
    if not textured:
        return np.full((height, width), _PLAIN_GRAY, dtype=np.uint8)
    total = np.full((height, width), float(rng.uniform(75.0, 175.0)), dtype=np.float32)
    for coarse, contrast in ((4, 16.0), (16, 16.0), (64, 12.0)):
        shape = (max(2, height // coarse), max(2, width // coarse))
        noise = rng.standard_normal(shape, dtype=np.float32)
        total += contrast * cv2.resize(noise, (width, height), interpolation=cv2.INTER_CUBIC)
    for _ in range(round(_BARS_PER_M2 * width * height / TEXELS_PER_M**2)):
        middle = rng.uniform((0.0, 0.0), (width, height))
        size = TEXELS_PER_M * rng.uniform((0.03, 0.02), (0.20, 0.10))
        corners = cv2.boxPoints((middle.tolist(), size.tolist(), float(rng.uniform(0.0, 180.0))))
        # Added, not painted over: what lies below stays visible.
        low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0)) + 1
        left, top = np.maximum(low, 0).astype(int)
        part = total[top : max(int(high[1]), 0), left : max(int(high[0]), 0)]
        if part.size:
            bar = np.zeros(part.shape, dtype=np.uint8)
            cv2.fillConvexPoly(bar, np.rint(corners - (left, top)).astype(np.int32), 1)
            part += np.float32(rng.choice((-1.0, 1.0)) * rng.uniform(20.0, 60.0)) * bar
    soft = cv2.GaussianBlur(total, (0, 0), 1.0)
    return np.asarray(np.clip(np.rint(soft), 5, 250), dtype=np.uint8)


def _cuts(length_m: float, texels: int) -> list[int]:
    """Where to cut a side into tiles, in texels, both ends included."""
    pieces = max(1, round(length_m / TILE_M))
    return [round(texels * piece / pieces) for piece in range(pieces + 1)]
