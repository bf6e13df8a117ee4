"""Soft contact shadow of a mesh on the plane it stands on, computed in the plane's own frame.

Every triangle that faces the lamp drops its projected area onto a grid on the ground, blurred by
as much as the lamp's apparent radius spreads it over the triangle's height: sharp where the figure
touches the ground, soft where it is far above. A second, vertical pass stands for the sky that
the body hides close around its feet. The grid is then carried into the picture by the plane's
homography. Everything is deterministic.

The frame: ground is z = 0, z up, metres, the grid centred on the origin.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.vectors import UP
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.lens import Extent, plane_homography, seen_extent, window_of
from motorcade.tracking.cameras.camera import Camera

GRID = 320
LAYERS = 6
# Cells of the grid to one of the coarsest, which wide blurs are computed on.
COARSEST = 4
# How quickly area that hides sky turns dark; one full layer lets exp(-2.2) = 11 % through.
DENSITY = 2.2
# Rays that fall less than this meet the ground nowhere.
BARELY = 1e-9
# Shade below this changes no byte of a picture (`composite.SHADES` are told apart).
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
        lamp_radius_rad: apparent radius of the lamp; larger is softer.
        contact: share that the hidden sky takes away at the feet, 0 to 1.
        contact_height: height up to which the body hides sky, as a share of the grid's half-width.

    >>> from motorcade.render import ShadowLook
    >>> overcast = ShadowLook(strength=0.1, lamp_radius_rad=0.5)  # faint and soft
    >>> overcast.contact  # dark at the feet all the same
    0.5
    """

    strength: float | None = None
    lamp_radius_rad: float = 0.12
    contact: float = 0.50
    contact_height: float = 0.22


def ground_shade(
    vertices: FloatArray,
    triangles: IntArray,
    light_direction: FloatArray,
    half_width_m: float,
    look: ShadowLook,
    strength: float,
) -> ShadeArray:
    """Share of light that the mesh takes away from each cell of the ground.

    Args:
        vertices: (V, 3) in the frame of the ground, metres.
        triangles: (T, 3) counter-clockwise from outside.
        light_direction: (3,) unit, the way the light travels; z below 0.
        half_width_m: half the width of the square grid.
        look: how the shadow looks.
        strength: share of the light that a full shadow takes away, where the look gives none.

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
    >>> shade = ground_shade(roof, faces, np.array([0, 0, -1.0]), 2.0, ShadowLook(contact=0.0), 0.8)
    >>> bool(shade.max() <= 0.8), float(shade[0, 0])
    (True, 0.0)
    """
    if not light_direction[2] < 0.0:
        raise ValueError(
            f"ground_shade(light_direction): expected light from above, got {light_direction}"
        )
    # A coordinate at once: (3 coordinates, 3 corners, T).
    corners = np.take(np.ascontiguousarray(vertices.T), np.ascontiguousarray(triangles.T), axis=1)
    middle = (corners[:, 0] + corners[:, 1] + corners[:, 2]) / 3.0
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * np.stack([a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))])
    height = np.maximum(middle[2], 0.0)
    cell = 2.0 * half_width_m / GRID
    slant = light_direction[:2] / light_direction[2]
    # A disc of radius r has a standard deviation of r / 2; slanting light stretches it.
    spread = 0.5 * look.lamp_radius_rad * (-light_direction[2]) ** -1.5
    shadow = _spread(
        middle[:2] - height * slant[:, None],
        np.maximum(light_direction @ area / light_direction[2], 0.0) / cell**2,
        0.9 + height * (spread / cell),
        cell,
    )
    top = look.contact_height * half_width_m
    near = np.clip(1.0 - height / top, 0.0, 1.0) ** 2
    sky = _spread(
        middle[:2],
        np.maximum(-area[2], 0.0) / cell**2 * near,
        0.010 * half_width_m / cell + 0.8 * height / cell,
        cell,
    )
    # Area that covers a place whole hides the lamp whole; in the rim, a part of the lamp.
    full = strength if look.strength is None else look.strength
    direct = np.float32(full) * np.minimum(shadow, 1.0)
    ambient = np.float32(look.contact) * (1.0 - np.exp(np.float32(-DENSITY) * sky))
    return np.asarray(1.0 - (1.0 - direct) * (1.0 - ambient))


def shade_step_m(half_width_m: float) -> float:
    """By multiples of this the grid may be moved without changing what it samples, metres."""
    return COARSEST * 2.0 * half_width_m / GRID


def shade_extent(
    shade: ShadeArray, half_width_m: float, camera: Camera, camera_T_ground: Motor
) -> Extent | None:
    """The part of a camera's picture that shade darkens, or None where it darkens no byte.

    The arguments are those of `shade_in_picture`.
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


def shade_in_picture(
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
        part: of the picture that is wanted; there is no shade elsewhere. All of it by default.

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
    ground_to_picture = plane_homography(camera, camera_T_ground)
    part_to_picture = np.array([[1.0, 0.0, first[0]], [0.0, 1.0, first[1]], [0.0, 0.0, 1.0]])
    seen = cv2.warpPerspective(
        shade,
        np.linalg.inv(ground_to_picture @ grid_to_ground) @ part_to_picture,
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
    cells, in a few layers.
    """
    total = np.zeros((GRID, GRID), np.float32)
    facing = np.flatnonzero(amount > 0.0)
    if not facing.size:
        return total
    at, amount, sigma = np.take(at, facing, axis=1) / cell, amount[facing], sigma[facing]
    widest = max(float(sigma.max()), 1.5 * float(sigma.min()))
    widths = np.geomspace(float(sigma.min()), widest, LAYERS)
    place = np.interp(sigma, widths, np.arange(LAYERS))
    for layer, width in enumerate(widths):
        share = amount * np.maximum(1.0 - np.abs(place - layer), 0.0)
        held = np.flatnonzero(share > 0.0)
        if held.size:
            _add_blurred(total, np.take(at, held, axis=1), share[held], float(width))
    return total


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
        (max(int(one.min()) - reach, 0), min(int(one.max()) + reach + 2, size)) for one in (x, y)
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


def ground_depth(camera: Camera, camera_T_ground: Motor) -> FloatArray:
    """Depth of the ground along the optical axis, for every pixel.

    Args:
        camera: pinhole.
        camera_T_ground: pose of the ground in the camera.

    Returns:
        (height, width) metres; infinite at and above the horizon.
    """
    up = camera_T_ground.rotor.apply(UP)
    offset = float(np.dot(up, camera_T_ground.translation_m))
    fall = _falls(camera, up, np.arange(camera.width), np.arange(camera.height))
    meets = offset * fall > BARELY
    return np.asarray(np.where(meets, offset / np.where(meets, fall, 1.0), np.inf))


def _falls(camera: Camera, up: FloatArray, columns: ArrayLike, rows: ArrayLike) -> FloatArray:
    """How far the rays of pixels (rows, columns), one metre deep, go along the ground's normal."""
    x = (np.asarray(columns) - camera.cx) / camera.fx
    y = (np.asarray(rows) - camera.cy) / camera.fy
    return np.asarray(up[0] * x[None, :] + up[1] * y[:, None] + up[2])
