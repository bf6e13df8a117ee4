"""Soft shadow of a mesh on the plane it stands on, computed in the plane's own frame.

The lamp's light: every triangle that faces the lamp drops its projected area onto a grid on the
ground, blurred by as much as the lamp's apparent radius spreads it over the triangle's height:
sharp where the figure touches the ground, soft where it is far above. Light from all sides: the
same without blur, from a few directions spread over the sky as they light the ground, which is the
ambient occlusion of the ground about the feet. The grid is then carried into the image by the
plane's homography. Everything is deterministic.

The frame: ground is z = 0, z up, metres, the grid centred on the origin.
"""

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from motorcade.animation.vectors import UP
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.lens import Extent, plane_homography, seen_extent, window_of
from motorcade.tracking.cameras.camera import Camera

GRID = 320
LAYERS = 6
# Cells of the grid to one of the coarsest, which wide blurs are computed on.
COARSEST = 4
# Directions of the sky, and the coarser, smaller grid that they are gathered on: cells a side,
# its share of the whole one, and the blur of one direction and of their sum, in its cells.
SKY, SKY_GRID, SKY_SHARE, SKY_BLUR, SKY_SOFT = 24, 96, 0.6, 0.5, 0.7
# Triangles are dropped in parts of at most this width, in cells of the finest grid, and of so many
# parts along a side at most.
PART, MOST_PARTS = 3.0, 48
# Cells over which it is told how often a place is covered: triangles do not drop evenly.
OVERLAP_SOFT = 1.5
# The rim of a disc's shadow is as wide, from a fifth to four fifths, as a Gaussian's of so many of
# its radii.
DISC = 0.58
# Rays that fall less than this meet the ground nowhere.
BARELY = 1e-9
# Shade below this changes no byte of an image (`composite.SHADES` are told apart).
DARKENS = 1e-4
# In its standard deviations, how far OpenCV's blur of floats reaches.
KERNEL = 4.0
# In metres: where a corner of the ground is nearer to the camera, or behind it, it may be anywhere.
NEAREST_M = 0.01

ShadeArray = NDArray[np.float32]


@dataclass(frozen=True)
class ShadowLook:
    """How a shadow looks.

    Attributes:
        strength: share of the light that comes from the lamp, so that a full shadow takes it
            away, 0 to 1; None leaves it to the scene's lighting.
        lamp_radius_rad: apparent radius of the lamp; larger is softer; None leaves it to the
            scene's lighting.
        contact: how much of the light from the sky that a body hides is lost to the ground; what
            is not is given back by the body.

    >>> from motorcade.render import ShadowLook
    >>> overcast = ShadowLook(strength=0.1, lamp_radius_rad=0.5)  # faint and soft
    >>> overcast.contact  # dark at the feet all the same
    0.8
    """

    strength: float | None = None
    lamp_radius_rad: float | None = None
    contact: float = 0.8


def ground_shade(
    vertices: FloatArray,
    triangles: IntArray,
    light_direction: FloatArray,
    half_width_m: float,
    look: ShadowLook,
    strength: float,
    lamp_radius_rad: float,
) -> ShadeArray:
    """Share of light that the mesh takes away from each cell of the ground.

    Args:
        vertices: (V, 3) in the frame of the ground, metres.
        triangles: (T, 3) counter-clockwise from outside.
        light_direction: (3,) unit, the way the light travels; z below 0.
        half_width_m: half the width of the square grid.
        look: how the shadow looks.
        strength: share of the light that a full shadow takes away, where the look gives none.
        lamp_radius_rad: of the lamp, where the look gives none.

    Returns:
        (GRID, GRID) float32 of linear light, from 0 (full light) to 1, row along +y, column
        along +x.

    Raises:
        ValueError: light that does not come from above.

    >>> import numpy as np
    >>> from motorcade.render import ShadowLook
    >>> from motorcade.render.shadow import ground_shade
    >>> roof = np.array([[-0.5, -0.5, 0.1], [0.5, -0.5, 0.1], [0.5, 0.5, 0.1], [-0.5, 0.5, 0.1]])
    >>> faces = np.array([[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]])
    >>> noon, look = np.array([0, 0, -1.0]), ShadowLook(contact=0.0)
    >>> shade = ground_shade(roof, faces, noon, 2.0, look, 0.8, 0.1)
    >>> round(float(shade.max()), 3), float(shade[0, 0])
    (0.8, 0.0)
    """
    if not light_direction[2] < 0.0:
        raise ValueError(
            f"ground_shade(light_direction): expected light from above, got {light_direction}"
        )
    cell = 2.0 * half_width_m / GRID
    slant = light_direction[:2] / light_direction[2]
    middle, area = _parts(vertices, triangles, slant, PART * cell)
    height = np.maximum(middle[:, 2], 0.0)
    radius = lamp_radius_rad if look.lamp_radius_rad is None else look.lamp_radius_rad
    # Sides of a shadow, which are most of its rim, lie as far off as the light goes down to them.
    spread = DISC * radius / -light_direction[2]
    shadow = _spread(
        middle[:, :2].T - height * slant[:, None],
        np.maximum(area @ light_direction / light_direction[2], 0.0) / cell**2,
        0.9 + height * (spread / cell),
        cell,
    )
    full = strength if look.strength is None else look.strength
    # Area that covers a place whole hides the lamp whole; in the rim, a part of the lamp.
    lost = np.float32(full) * np.minimum(shadow, 1.0)
    if look.contact > 0.0 and full < 1.0:
        hidden = _hidden_sky(middle, area, half_width_m)
        lost += np.float32((1.0 - full) * look.contact) * hidden
    return np.asarray(lost)


def _parts(
    vertices: FloatArray, triangles: IntArray, slant: FloatArray, width_m: float
) -> tuple[FloatArray, FloatArray]:
    """Middles (P, 3) and areas with their normals (P, 3) of triangles, cut into parts where they
    are wide, or their shadow is, aside by `slant` of their height.
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    area = 0.5 * np.cross(ab, ac)
    middle = a + (ab + ac) / 3.0
    sides = np.stack([ab, ac, ac - ab])
    thrown = sides[..., :2] - sides[..., 2:] * slant
    square = np.maximum(np.sum(thrown**2, axis=2), np.sum(sides**2, axis=2))
    longest = np.sqrt(np.max(square, axis=0))
    wide = longest > width_m
    if not wide.any():
        return middle, area
    middles, areas = [middle[~wide]], [area[~wide]]
    count = np.minimum(np.ceil(longest / width_m), MOST_PARTS).astype(np.int64)
    for n in np.unique(count[wide]):
        own = wide & (count == n)
        u, v = _middles(int(n))
        cut = a[own, None] + u[:, None] * ab[own, None] + v[:, None] * ac[own, None]
        middles.append(cut.reshape(-1, 3))
        areas.append(np.repeat(area[own] / n**2, n**2, axis=0))
    return np.concatenate(middles), np.concatenate(areas)


def _middles(n: int) -> tuple[FloatArray, FloatArray]:
    """Middles of the n² equal parts of a triangle, as shares (n²,) of two of its sides."""
    i, j = (part.ravel() for part in np.mgrid[:n, :n])
    upright, turned = i + j < n, i + j < n - 1
    u = np.concatenate([i[upright] + 1 / 3, i[turned] + 2 / 3]) / n
    v = np.concatenate([j[upright] + 1 / 3, j[turned] + 2 / 3]) / n
    return u, v


def _hidden_sky(middle: FloatArray, area: FloatArray, half_width_m: float) -> ShadeArray:
    """Share (GRID, GRID) of evenly bright sky, as it lights the ground, that is hidden there."""
    cell = 2.0 * SKY_SHARE * half_width_m / SKY_GRID
    wide = SKY_GRID + 2  # what falls outside is gathered in a rim
    at, height = (middle[:, :2] / cell).T.astype(np.float32), middle[:, 2].astype(np.float32) / cell
    amount = area.astype(np.float32) / np.float32(cell**2)
    total = np.zeros((SKY_GRID, SKY_GRID), np.float32)
    for slope in _sky_slopes():
        facing = np.maximum(-(amount[:, 0] * slope[0] + amount[:, 1] * slope[1] + amount[:, 2]), 0)
        column, row = (
            np.clip(at[k] - slope[k] * height + (0.5 * SKY_GRID + 1), 0, wide - 1).astype(np.intp)
            for k in range(2)
        )
        dropped = np.bincount(row * wide + column, weights=facing, minlength=wide * wide)
        inside = dropped.reshape(wide, wide)[1:-1, 1:-1].astype(np.float32)
        total += np.minimum(cv2.GaussianBlur(inside, (0, 0), SKY_BLUR), 1.0)
    soft = cv2.GaussianBlur(total / SKY, (0, 0), SKY_SOFT, borderType=cv2.BORDER_REPLICATE)
    size = round(SKY_SHARE * GRID)
    rim = (GRID - size) // 2
    shown = cv2.resize(soft * _fading(), (size, size), interpolation=cv2.INTER_LINEAR)
    return np.pad(shown, (rim, GRID - size - rim)).astype(np.float32)


@cache
def _sky_slopes() -> tuple[tuple[np.float32, np.float32], ...]:
    """Level parts x / z and y / z of directions of the sky that light the ground alike."""
    k = np.arange(SKY) + 0.5
    level, turn = np.sqrt(k / SKY), k * np.pi * (3.0 - np.sqrt(5.0))
    slope = np.stack([np.cos(turn), np.sin(turn)]) * level / np.sqrt(1.0 - k / SKY)
    return tuple((np.float32(x), np.float32(y)) for x, y in slope.T)


@cache
def _fading() -> ShadeArray:
    """1 about the middle of the sky's grid, falling to 0 at its edge."""
    along = np.abs(np.arange(SKY_GRID) + 0.5 - 0.5 * SKY_GRID) / (0.5 * SKY_GRID)
    falling = np.clip(3.0 * (1.0 - along), 0.0, 1.0)
    return np.outer(falling, falling).astype(np.float32)


def shade_step_m(half_width_m: float) -> float:
    """By multiples of this the grid may be moved without changing what it samples, metres."""
    return COARSEST * 2.0 * half_width_m / GRID


def shade_extent(
    shade: ShadeArray, half_width_m: float, camera: Camera, camera_T_ground: Motor
) -> Extent | None:
    """The part of a camera's image that shade darkens, or None where it darkens no byte.

    The arguments are those of `shade_in_image`.
    """
    dark = shade > DARKENS
    columns, rows = (np.flatnonzero(dark.any(axis=axis)) for axis in (0, 1))
    if not columns.size or camera_T_ground.inverse().translation_m[2] <= 0.0:
        return None
    cell = 2.0 * half_width_m / GRID
    x, y = (
        cell * (np.array([held[0] - 1.0, held[-1] + 1.0]) + 0.5) - half_width_m
        for held in (columns, rows)
    )
    corners = [[x[i], y[k], 0.0] for i in (0, 1) for k in (0, 1)]
    return seen_extent(camera, camera_T_ground.apply(corners), NEAREST_M, 1.0)


def shade_in_image(
    shade: ShadeArray,
    half_width_m: float,
    camera: Camera,
    camera_T_ground: Motor,
    part: Extent | None = None,
) -> ShadeArray | None:
    """The ground's shade as a camera sees it.

    Args:
        shade: (GRID, GRID) as from `ground_shade`.
        half_width_m: of its grid.
        camera: pinhole.
        camera_T_ground: pose of the ground in the camera.
        part: of the image that is wanted; there is no shade elsewhere. All of it by default.

    Returns:
        (height, width) float32 shade of every pixel, or None where the camera is below the ground.
    """
    if camera_T_ground.inverse().translation_m[2] <= 0.0:
        return None
    shown = np.zeros((camera.height, camera.width), np.float32)
    if part is None:
        part = np.zeros(2, np.int64), np.array([camera.width, camera.height]) - 1
    first, last = part
    cell = 2.0 * half_width_m / GRID
    corner = 0.5 * cell - half_width_m
    grid_to_ground = np.array([[cell, 0.0, corner], [0.0, cell, corner], [0.0, 0.0, 1.0]])
    ground_to_image = plane_homography(camera, camera_T_ground)
    part_to_image = np.array([[1.0, 0.0, first[0]], [0.0, 1.0, first[1]], [0.0, 0.0, 1.0]])
    seen = cv2.warpPerspective(
        shade,
        np.linalg.inv(ground_to_image @ grid_to_ground) @ part_to_image,
        (int(last[0] - first[0]) + 1, int(last[1] - first[1]) + 1),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=0.0,
    )
    up = camera_T_ground.rotor.apply(UP)
    offset = float(np.dot(up, camera_T_ground.translation_m))
    # What falls to the ground is one side of a straight line: the corners tell of all pixels.
    if np.min(offset * _falls(camera, up, [first[0], last[0]], [first[1], last[1]])) <= BARELY:
        columns, rows = (np.arange(first[k], last[k] + 1) for k in (0, 1))
        seen[offset * _falls(camera, up, columns, rows) <= BARELY] = 0.0
    shown[window_of(part)] = seen
    return shown


def _spread(at: FloatArray, amount: FloatArray, sigma: FloatArray, cell: float) -> ShadeArray:
    """Drop amounts (T,) at places (2, T) in metres onto the grid, each blurred by its own width in
    cells, in a few layers. Where several lie over one another they cover the place once.
    """
    total = np.zeros((GRID, GRID), np.float32)
    facing = np.flatnonzero(amount > 0.0)
    if not facing.size:
        return total
    at, amount, sigma = np.take(at, facing, axis=1) / cell, amount[facing], sigma[facing]
    # What is sharp is cut off where it is full; shares of it would leave holes.
    soft = np.clip(0.5 * (sigma - 1.0), 0.0, 1.0)
    amount = amount / (1.0 + soft * (_overlap(at, amount) - 1.0))
    widest = max(float(sigma.max()), 1.5 * float(sigma.min()))
    widths = np.geomspace(float(sigma.min()), widest, LAYERS)
    place = np.interp(sigma, widths, np.arange(LAYERS))
    for layer, width in enumerate(widths):
        share = amount * np.maximum(1.0 - np.abs(place - layer), 0.0)
        held = np.flatnonzero(share > 0.0)
        if held.size:
            _add_blurred(total, np.take(at, held, axis=1), share[held], float(width))
    return total


def _overlap(at_cell: FloatArray, amount: FloatArray) -> FloatArray:
    """How often each amount's place is covered, 1 or more."""
    x, y = np.clip(at_cell + 0.5 * GRID, 0, GRID - 1).astype(np.intp)
    place = y * GRID + x
    dropped = np.bincount(place, weights=amount, minlength=GRID * GRID).astype(np.float32)
    covered = cv2.GaussianBlur(dropped.reshape(GRID, GRID), (0, 0), OVERLAP_SOFT)
    return np.asarray(np.maximum(covered.ravel()[place], 1.0), dtype=np.float64)


def _add_blurred(total: ShadeArray, at_cell: FloatArray, amount: FloatArray, width: float) -> None:
    """Add amounts to the grid, blurred; for wide blurs a coarser grid is enough."""
    coarse = 1 if width < 4.0 else 2 if width < 8.0 else COARSEST
    size = GRID // coarse
    x, y = at_cell / coarse + (0.5 * size - 0.5)
    inside = (x >= 0.0) & (x < size - 1) & (y >= 0.0) & (y < size - 1)
    if not inside.all():
        x, y, amount = x[inside], y[inside], amount[inside]
    if not x.size:
        return
    # Farther away than this the blur ends, and bringing it to the fine grid takes a cell more.
    reach = math.ceil(KERNEL * width / coarse) + 2
    (left, right), (low, high) = (
        (max(int(values.min()) - reach, 0), min(int(values.max()) + reach + 2, size))
        for values in (x, y)
    )
    soft = cv2.GaussianBlur(
        _dropped(x - left, y - low, amount / coarse**2, (high - low, right - left)),
        (0, 0),
        width / coarse,
        borderType=cv2.BORDER_CONSTANT,
    )
    if coarse > 1:
        soft = cv2.resize(soft, None, fx=coarse, fy=coarse, interpolation=cv2.INTER_LINEAR)
    total[coarse * low : coarse * high, coarse * left : coarse * right] += soft


def _dropped(
    x: FloatArray, y: FloatArray, amount: FloatArray, shape: tuple[int, int]
) -> ShadeArray:
    """Bilinear sums of amounts on a grid of some rows and columns that has room for all."""
    column, row = x.astype(np.int64), y.astype(np.int64)
    right, up = x - column, y - row
    first = row * shape[1] + column
    above, below = amount * up, amount * (1.0 - up)
    cells = np.concatenate([first, first + 1, first + shape[1], first + shape[1] + 1])
    to_right = above * right, below * right
    shares = [below - to_right[1], to_right[1], above - to_right[0], to_right[0]]
    total = np.bincount(cells, weights=np.concatenate(shares), minlength=shape[0] * shape[1])
    return total.reshape(shape).astype(np.float32)


def ground_depth(camera: Camera, camera_T_ground: Motor) -> NDArray[np.float32]:
    """Depth of the ground along the optical axis, for every pixel.

    Args:
        camera: pinhole.
        camera_T_ground: pose of the ground in the camera.

    Returns:
        (height, width) float32 metres; infinite at and above the horizon.
    """
    up = camera_T_ground.rotor.apply(UP)
    offset = float(np.dot(up, camera_T_ground.translation_m))
    across, down = _falls_along(
        camera, up, np.arange(camera.width), np.arange(camera.height), np.float32
    )
    fall = across + down
    with np.errstate(divide="ignore"):
        depth_m = np.float32(offset) / fall
    depth_m[np.float32(offset) * fall <= BARELY] = np.inf
    return np.asarray(depth_m, dtype=np.float32)


def _falls(camera: Camera, up: FloatArray, columns: ArrayLike, rows: ArrayLike) -> FloatArray:
    """How far the rays of pixels (rows, columns), one metre deep, go along the ground's normal."""
    across, down = _falls_along(camera, up, columns, rows, np.float64)
    return np.asarray(across + down)


def _falls_along(
    camera: Camera, up: FloatArray, columns: ArrayLike, rows: ArrayLike, kind: DTypeLike
) -> tuple[NDArray[Any], NDArray[Any]]:
    """What a pixel's column and its row add to that: (1, columns) and (rows, 1)."""
    x = (np.asarray(columns) - camera.cx) / camera.fx
    y = (np.asarray(rows) - camera.cy) / camera.fy
    return (up[0] * x)[None, :].astype(kind), (up[1] * y + up[2])[:, None].astype(kind)
