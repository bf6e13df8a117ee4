"""Builds the synthetic room: surfaces whose light is painted on, to be drawn without lighting.

Nothing in the room moves, so its light is computed once. Photographs get a texture of material
times light; painted boxes are cut into small rectangles with the light at their corners and all
become one mesh. Colours are sRGB after a soft tone curve; what the camera adds comes later.

Only images inside the scikit-image wheel are used; nothing is downloaded. A material is an
image of the light that a surface sends back, linear RGB from 0 to 1, sampled at a number of
pixels a metre over a rectangle whose rows run downwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render import Surface
from motorcade.replays.demo import furniture
from motorcade.replays.demo.furniture import BOARD, Occluders, irradiance

SKY = np.array([0.86, 0.93, 1.0])
EXPOSURE = 1.50
# How far inside its panel the outermost light is taken, so that it is not inside a neighbour.
INSET_M = 0.003
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
FINE_PIXELS_PER_M = {"board": 2600.0, "cat": 1500.0, "page": 1500.0}


@dataclass(frozen=True)
class WallPanel:
    """A rectangle of one material.

    Attributes:
        corner_m: (3,) its lower left corner, seen from the front.
        across_m: (3,) from there to the lower right one.
        up_m: (3,) from there to the upper left one.
        pixels_per_m: of its texture.
        cells_per_m: of its light.
    """

    corner_m: FloatArray
    across_m: FloatArray
    up_m: FloatArray
    material: str
    pixels_per_m: float
    cells_per_m: float

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height."""
        return float(np.linalg.norm(self.across_m)), float(np.linalg.norm(self.up_m))

    @property
    def normal(self) -> FloatArray:
        """(3,) unit vector towards the viewer."""
        out = np.cross(self.across_m, self.up_m)
        return np.asarray(out / np.linalg.norm(out))

    def cells(self) -> tuple[int, int]:
        """Rows and columns of light cells."""
        wide, tall = self.size_m
        return max(1, round(tall * self.cells_per_m)), max(1, round(wide * self.cells_per_m))

    def nodes(self, inset_m: float) -> FloatArray:
        """World points (rows + 1, columns + 1, 3) at the corners of cells, lowest row first."""
        rows, columns = self.cells()
        wide, tall = self.size_m
        aside, below = min(0.4, inset_m / wide), min(0.4, inset_m / tall)
        u = np.clip(np.linspace(0.0, 1.0, columns + 1), aside, 1.0 - aside)
        v = np.clip(np.linspace(0.0, 1.0, rows + 1), below, 1.0 - below)
        return np.asarray(
            self.corner_m + u[None, :, None] * self.across_m + v[:, None, None] * self.up_m
        )


@cache
def room() -> tuple[Surface, ...]:
    """All surfaces of the room, their light painted on; computed once in a process."""
    things, bodies = furniture.boxes(), furniture.turned_bodies()
    occluders = Occluders.of([*things, *(_slim_box(body) for body in bodies)])
    panels = _shell() + [panel for box in things for panel in _faces(box)]
    light = _light(panels, occluders)
    painted = [k for k, panel in enumerate(panels) if panel.material in PAINTS]
    surfaces = [_painted([panels[k] for k in painted], [light[k] for k in painted])]
    for panel, own in zip(panels, light, strict=True):
        if panel.material not in PAINTS:
            surfaces.append(_textured(panel, own))
    behind = Occluders.of(things)
    return (*surfaces, _window(), *(_light_body(body, behind) for body in bodies))


def developed(light: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Linear light as sRGB bytes, over a curve that rolls off highlights instead of clipping."""
    x = EXPOSURE * np.maximum(light, 0.0)
    shown = to_srgb(x * (1.0 + x / 4.0) / (1.0 + 0.55 * x))
    return np.asarray(np.rint(255.0 * shown), dtype=np.uint8)


def _shell() -> list[WallPanel]:
    """Walls, floor and ceiling, seen from inside."""
    (x0, x1), (y0, y1), z0, z1 = (
        furniture.WALLS_X_M,
        furniture.WALLS_Y_M,
        furniture.FLOOR_M,
        furniture.CEILING_M,
    )
    long, wide, tall = x1 - x0, y1 - y0, z1 - z0
    plan = [
        ((x1, y1, z0), (0.0, -wide, 0.0), (0.0, 0.0, tall), "brick"),
        ((x0, y0, z0), (0.0, wide, 0.0), (0.0, 0.0, tall), "plaster"),
        ((x0, y1, z0), (long, 0.0, 0.0), (0.0, 0.0, tall), "sage"),
        ((x1, y0, z0), (-long, 0.0, 0.0), (0.0, 0.0, tall), "sage"),
        ((x0, y0, z0), (long, 0.0, 0.0), (0.0, wide, 0.0), "carpet"),
        ((x0, y1, z1), (long, 0.0, 0.0), (0.0, -wide, 0.0), "ceiling"),
    ]
    return [
        WallPanel(np.array(corner), np.array(across), np.array(up), name, 260.0, 12.0)
        for corner, across, up, name in plan
    ]


def _faces(box: furniture.Box) -> list[WallPanel]:
    """The faces of a box that can be seen; what is near is drawn and lit finer."""
    near = box.base_m[0] < 0.8
    pixels, cells = (900.0, 75.0) if near else (330.0, 20.0)
    (sx, sy, sz), turn = box.size_m, box.turn_rad
    ex = np.array([np.cos(turn), np.sin(turn), 0.0])
    ey = np.array([-np.sin(turn), np.cos(turn), 0.0])
    rise = np.array([0.0, 0.0, sz])
    left = np.array(box.base_m) - 0.5 * sx * ex
    right = left + sx * ex
    plan = [
        (left + 0.5 * sy * ey, -sy * ey, rise, box.front or box.material),
        (right - 0.5 * sy * ey, sy * ey, rise, box.material),
        (left - 0.5 * sy * ey, sx * ex, rise, box.material),
        (right + 0.5 * sy * ey, -sx * ex, rise, box.material),
        (left - 0.5 * sy * ey + rise, sx * ex, sy * ey, box.top or box.material),
    ]
    return [
        WallPanel(corner, across, up, name, FINE_PIXELS_PER_M.get(name, pixels), cells)
        for corner, across, up, name in plan
    ]


def _light(panels: Sequence[WallPanel], occluders: Occluders) -> list[FloatArray]:
    """Light (rows + 1, columns + 1, 3) at the nodes of every panel, computed in one go."""
    nodes = [panel.nodes(INSET_M) for panel in panels]
    counts = [grid.size // 3 for grid in nodes]
    points = np.concatenate([grid.reshape(-1, 3) for grid in nodes])
    normals = np.repeat([panel.normal for panel in panels], counts, axis=0)
    light = irradiance(points, normals, occluders)
    parts = np.split(light, np.cumsum(counts)[:-1])
    return [part.reshape(grid.shape) for part, grid in zip(parts, nodes, strict=True)]


def _textured(panel: WallPanel, light: FloatArray) -> Surface:
    """A panel with its light multiplied into its image."""
    base = material(panel.material, panel.size_m, panel.pixels_per_m)
    height, width = base.shape[:2]
    rows, columns = light.shape[0] - 1, light.shape[1] - 1
    # Pixel centres in cells, counted from the upper left node.
    x = ((np.arange(width) + 0.5) * (columns / width)).astype(np.float32)
    y = ((np.arange(height) + 0.5) * (rows / height)).astype(np.float32)
    grid_x, grid_y = np.meshgrid(x, y)
    own = np.ascontiguousarray(light[::-1]).astype(np.float32)
    spread = cv2.remap(own, grid_x, grid_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return Surface(
        panel.corner_m + SQUARE @ np.stack([panel.across_m, panel.up_m]),
        np.tile(panel.normal, (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]]),
        texture=developed(base * spread),
        texture_coordinates=SQUARE,
    )


def _painted(panels: Sequence[WallPanel], light: Sequence[FloatArray]) -> Surface:
    """All plain panels as one mesh with the light in its vertex colours."""
    vertices, normals, triangles, colors = [], [], [], []
    begin = 0
    for panel, own in zip(panels, light, strict=True):
        rows, columns = panel.cells()
        grid = panel.nodes(0.0).reshape(-1, 3)
        vertices.append(grid)
        normals.append(np.tile(panel.normal, (len(grid), 1)))
        base = linear(np.array(PAINTS[panel.material]))
        colors.append(developed(own.reshape(-1, 3) * base) / 255.0)
        triangles.append(_lattice(rows, columns) + begin)
        begin += len(grid)
    return Surface(
        np.concatenate(vertices),
        np.concatenate(normals),
        np.concatenate(triangles),
        colors=np.concatenate(colors),
    )


def _lattice(rows: int, columns: int) -> IntArray:
    """Triangles over a grid of (rows + 1) by (columns + 1) nodes, row by row."""
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1, 1)
    a, b, c, d = first, first + 1, first + columns + 2, first + columns + 1
    return np.concatenate([np.hstack([a, b, c]), np.hstack([a, c, d])])


def _window() -> Surface:
    """The bright window with its bars, just inside the left wall."""
    x0, x1, z0, z1 = furniture.WINDOW_M
    rows, columns = 300, 400
    image = np.empty((rows, columns, 3))
    image[:] = SKY * np.linspace(1.25, 0.85, rows)[:, None, None]
    bars = np.array([0.80, 0.79, 0.76]) * 0.5
    for at in (0, columns // 2, columns):
        image[:, max(0, at - 9) : at + 9] = bars
    for at in (0, rows // 2, rows):
        image[max(0, at - 9) : at + 9] = bars
    y = furniture.WALLS_Y_M[1] - 0.008
    return Surface(
        np.array([[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]]),
        np.tile([0.0, -1.0, 0.0], (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]]),
        texture=developed(image),
        texture_coordinates=SQUARE,
    )


def _slim_box(body: furniture.Turned) -> furniture.Box:
    """A slim box in a turned body's place, to throw its shadow."""
    side = 1.6 * max(radius for _, radius in body.outline_m)
    return furniture.Box(body.foot_m, (side, side, body.outline_m[-1][0]), "plaster")


def _light_body(body: furniture.Turned, occluders: Occluders) -> Surface:
    """A body of revolution with the light in its vertex colours."""
    sides, steps = 40, 28
    outline = np.array(body.outline_m)
    height = np.linspace(outline[0, 0], outline[-1, 0], steps)
    radius = np.interp(height, outline[:, 0], outline[:, 1])
    radius = np.convolve(np.pad(radius, 1, mode="edge"), [0.25, 0.5, 0.25], mode="valid")
    angle = np.arange(sides + 1) * (2.0 * np.pi / sides)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    walls = np.empty((steps, sides + 1, 3))
    walls[..., :2] = radius[:, None, None] * ring
    walls[..., 2] = height[:, None]
    normals = np.empty_like(walls)
    normals[..., :2] = ring
    normals[..., 2] = -np.gradient(radius, height)[:, None]
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    vertices = walls.reshape(-1, 3) + np.array(body.foot_m)
    light = irradiance(vertices, normals.reshape(-1, 3), occluders)
    lid, lid_normals, lid_light = _lid(vertices[-(sides + 1) :], occluders)
    shown = np.concatenate(
        [light * linear(np.array(body.color)), lid_light * linear(np.array(body.inside))]
    )
    fan = np.arange(sides)[:, None] + len(vertices) + np.array([[1, 2, 0]])
    fan[:, 2] = len(vertices)
    return Surface(
        np.concatenate([vertices, lid]),
        np.concatenate([normals.reshape(-1, 3), lid_normals]),
        np.concatenate([_lattice(steps - 1, sides), fan]),
        colors=developed(shown) / 255.0,
    )


def _lid(rim: FloatArray, occluders: Occluders) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A disc just below a rim: middle and rim vertices, their normals, and their light."""
    disc = np.concatenate([rim.mean(axis=0, keepdims=True), rim]) - np.array([0.0, 0.0, 0.004])
    normals = np.tile([0.0, 0.0, 1.0], (len(disc), 1))
    return disc, normals, irradiance(disc, normals, occluders)


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
        pixels_per_m: resolution; the image's width is rounded up to a multiple of 4.

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
    return np.asarray(to_linear(color), dtype=np.float32)


@cache
def _photograph(name: str) -> LinearImage:
    """An image out of the scikit-image wheel, (h, w, 3) linear."""
    import skimage
    from skimage.io import imread

    image = np.asarray(imread(Path(skimage.__file__).parent / "data" / name))
    if image.ndim == 2:
        image = np.repeat(image[..., None], 3, axis=2)
    return linear(image[..., :3] / 255.0)


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
    image = np.full((rows, columns, 3), linear(np.array(PAINTS["walnut"])), dtype=np.float32)
    edge = max(1, round(FRAME_SHARE * min(rows, columns)))
    image[edge:-edge, edge:-edge] = linear(np.array(PAINTS["paper"]))
    mat = 2 * edge
    inside = (columns - 2 * mat, rows - 2 * mat)
    photo = _photograph(file)
    height, width = photo.shape[:2]
    share = min(width / inside[0], height / inside[1])
    wide, tall = int(inside[0] * share), int(inside[1] * share)
    left, top = (width - wide) // 2, (height - tall) // 2
    cropped = photo[top : top + tall, left : left + wide]
    image[mat:-mat, mat:-mat] = cv2.resize(cropped, inside, interpolation=cv2.INTER_AREA)
    return image


def _doors(rows: int, columns: int) -> LinearImage:
    """Three doors with dark gaps and small knobs."""
    image = np.full((rows, columns, 3), linear(np.array(PAINTS["oak"])), dtype=np.float32)
    for k in range(4):
        at = min(columns - 3, round(k * columns / 3))
        image[:, max(0, at - 2) : at + 2] *= 0.25
    for k in range(3):
        center = (round((k + 0.88) * columns / 3), rows // 3)
        cv2.circle(image, center, max(2, columns // 90), (0.03, 0.02, 0.015), -1, cv2.LINE_AA)
    return image


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
