"""Materials of the synthetic room: photographs that come with scikit-image, and plain paints.

Only pictures inside the scikit-image wheel are used; nothing is downloaded. A material is a
picture of the light that a surface sends back, linear RGB from 0 to 1, sampled at a number of
pixels a metre over a rectangle whose rows run downwards.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.replays.demo.furniture import BOARD

LinearImage = NDArray[np.float32]

# sRGB paints
PAINTS: dict[str, tuple[float, float, float]] = {
    "plaster": (0.87, 0.85, 0.81),
    "sage": (0.58, 0.66, 0.62),
    "ceiling": (0.93, 0.93, 0.91),
    "paper": (0.93, 0.92, 0.89),
    "oak": (0.70, 0.56, 0.41),
    "walnut": (0.37, 0.26, 0.19),
    "navy": (0.16, 0.24, 0.38),
    "cream": (0.88, 0.82, 0.70),
    "rust": (0.69, 0.33, 0.20),
    "teal": (0.18, 0.43, 0.44),
    "ochre": (0.80, 0.60, 0.24),
    "plum": (0.40, 0.23, 0.32),
}
# photograph, metres that it covers, sRGB tint, contrast kept
TILED: dict[str, tuple[str, float, tuple[float, float, float], float]] = {
    "stone": ("gravel.png", 0.30, (0.80, 0.78, 0.745), 0.34),
    "brick": ("brick.png", 0.98, (0.79, 0.70, 0.635), 0.75),
    "carpet": ("gravel.png", 0.9, (0.50, 0.47, 0.46), 0.5),
    "grass": ("grass.png", 0.42, (0.42, 0.60, 0.27), 1.6),
}
# The brick photograph shows a pavement from a slant: these corners of it (x, y) form a rectangle
# whose sides lie on joints.
PAVEMENT = ((38.0, 0.0), (453.0, 0.0), (505.0, 511.0), (4.0, 511.0))
# photographs in a frame; page and board come without one
FRAMED = {
    "astronaut": "astronaut.png",
    "coffee": "coffee.png",
    "cat": "chelsea.png",
    "hubble": "hubble_deep_field.jpg",
}
FRAME_SHARE = 0.055


def material(name: str, size_m: tuple[float, float], pixels_per_m: float) -> LinearImage:
    """A material over a rectangle.

    Args:
        name: a paint, a tiled photograph, a framed one, "page", "doors" or "board".
        size_m: width and height of the rectangle.
        pixels_per_m: resolution; the picture's width is rounded up to a multiple of 4.

    Returns:
        (rows, columns, 3) linear RGB, 0 to 1.

    Raises:
        ValueError: an unknown material.
    """
    columns = max(4, 4 * int(np.ceil(size_m[0] * pixels_per_m / 4.0)))
    rows = max(4, int(np.ceil(size_m[1] * pixels_per_m)))
    if name in PAINTS:
        return np.full((rows, columns, 3), linear(np.array(PAINTS[name])), dtype=np.float32)
    if name in TILED:
        return _tiled(name, rows, columns, pixels_per_m)
    if name in FRAMED:
        return _framed(FRAMED[name], rows, columns)
    if name == "page":
        page = cv2.resize(_photograph("page.png"), (columns, rows), interpolation=cv2.INTER_AREA)
        return np.asarray(0.25 + 0.6 * page, dtype=np.float32)
    if name == "doors":
        return _doors(rows, columns)
    if name == "board":
        return _board(rows, columns)
    raise ValueError(f"material: expected one of the room's materials, got '{name}'")


def linear(color: NDArray[Any]) -> NDArray[np.float32]:
    """Linear light of sRGB values."""
    low, high = color / 12.92, ((color + 0.055) / 1.055) ** 2.4
    return np.asarray(np.where(color < 0.04045, low, high), dtype=np.float32)


@cache
def _photograph(name: str) -> LinearImage:
    """A picture out of the scikit-image wheel, (h, w, 3) linear."""
    import skimage
    from skimage.io import imread

    picture = np.asarray(imread(Path(skimage.__file__).parent / "data" / name))
    if picture.ndim == 2:
        picture = np.repeat(picture[..., None], 3, axis=2)
    return linear(picture[..., :3] / 255.0)


@cache
def _courses() -> LinearImage:
    """The pavement seen from above and turned, so that its bricks lie in level courses."""
    side = 768
    square = np.array([[0, 0], [side, 0], [side, side], [0, side]], dtype=np.float32)
    unwarp = cv2.getPerspectiveTransform(np.array(PAVEMENT, dtype=np.float32), square)
    above = cv2.warpPerspective(
        _photograph("brick.png"), unwarp, (side, side), flags=cv2.INTER_CUBIC
    )
    return np.ascontiguousarray(np.rot90(np.clip(above, 0.0, 1.0)))


def _tiled(name: str, rows: int, columns: int, pixels_per_m: float) -> LinearImage:
    """A photograph repeated, its grey drawn towards one tint."""
    file, tile_m, tint, contrast = TILED[name]
    side = max(8, round(tile_m * pixels_per_m))
    photo = _courses() if name == "brick" else _photograph(file)
    how = cv2.INTER_AREA if side < photo.shape[1] else cv2.INTER_CUBIC
    tile = cv2.resize(photo, (side, side), interpolation=how)
    relief = 1.0 + contrast * (tile / tile.mean(axis=(0, 1)) - 1.0)
    if name == "brick":  # courses go on across a mirror, not across a plain seam
        relief = np.concatenate([relief, relief[:, ::-1]], axis=1)
    repeats = (rows // side + 1, columns // side + 1, 1)
    whole = np.tile(np.clip(relief, 0.08, 2.2), repeats)[:rows, :columns]
    return np.asarray(np.clip(whole * linear(np.array(tint)), 0.0, 0.95), dtype=np.float32)


def _framed(file: str, rows: int, columns: int) -> LinearImage:
    """A photograph behind a white mat in a dark wooden frame."""
    picture = np.full((rows, columns, 3), linear(np.array(PAINTS["walnut"])), dtype=np.float32)
    edge = max(1, round(FRAME_SHARE * min(rows, columns)))
    picture[edge:-edge, edge:-edge] = linear(np.array(PAINTS["paper"]))
    mat = 2 * edge
    inside = (columns - 2 * mat, rows - 2 * mat)
    photo = _photograph(file)
    height, width = photo.shape[:2]
    share = min(width / inside[0], height / inside[1])
    wide, tall = int(inside[0] * share), int(inside[1] * share)
    left, top = (width - wide) // 2, (height - tall) // 2
    cropped = photo[top : top + tall, left : left + wide]
    picture[mat:-mat, mat:-mat] = cv2.resize(cropped, inside, interpolation=cv2.INTER_AREA)
    return picture


def _doors(rows: int, columns: int) -> LinearImage:
    """Three doors with dark gaps and small knobs."""
    picture = np.full((rows, columns, 3), linear(np.array(PAINTS["oak"])), dtype=np.float32)
    for k in range(4):
        at = min(columns - 3, round(k * columns / 3))
        picture[:, max(0, at - 2) : at + 2] *= 0.25
    for k in range(3):
        center = (round((k + 0.88) * columns / 3), rows // 3)
        cv2.circle(picture, center, max(2, columns // 90), (0.03, 0.02, 0.015), -1, cv2.LINE_AA)
    return picture


def _board(rows: int, columns: int) -> LinearImage:
    """The printed markers with their quiet zone, filling the rectangle."""
    quiet = BOARD.pattern.quiet_m
    pixels_per_m = columns / (BOARD.size_m[0] + 2.0 * quiet)
    drawn, (origin_x, origin_y) = BOARD.draw(pixels_per_m)
    tall = BOARD.size_m[1] + 2.0 * quiet
    stretch = rows / tall / pixels_per_m
    place = np.array(
        [
            [1.0, 0.0, quiet * pixels_per_m - 0.5 - origin_x],
            [0.0, stretch, quiet * rows / tall - 0.5 - stretch * origin_y],
        ]
    )
    flat = cv2.warpAffine(drawn, place, (columns, rows), borderValue=255)
    ink = np.repeat(flat[..., None].astype(np.float32) / 255.0, 3, axis=2)
    return np.asarray(0.025 + 0.80 * ink, dtype=np.float32)
