"""Soft contact shadow of a mesh on the plane it stands on, computed in the plane's own frame.

Every triangle that faces the lamp drops its projected area onto a grid on the ground, blurred by
as much as the lamp's apparent radius spreads it over the triangle's height: sharp where the figure
touches the ground, soft where it is far above. A second, vertical pass stands for the sky that
the body hides close around its feet. The grid is then carried into the picture by the plane's
homography. Everything is deterministic.

The frame: ground is z = 0, z up, metres, the grid centred on the origin.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.animation.vectors import UP
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.lens import plane_homography
from motorcade.tracking.cameras.camera import Camera

GRID = 320
LAYERS = 6
# Cells of the grid to one of the coarsest, which wide blurs are computed on.
COARSEST = 4
# How quickly area that hides sky turns dark; one full layer lets exp(-2.2) = 11 % through.
DENSITY = 2.2
# Rays that fall less than this meet the ground nowhere.
BARELY = 1e-9


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
) -> FloatArray:
    """Share of light that the mesh takes away from each cell of the ground.

    Args:
        vertices: (V, 3) in the frame of the ground, metres.
        triangles: (T, 3) counter-clockwise from outside.
        light_direction: (3,) unit, the way the light travels; z below 0.
        half_width_m: half the width of the square grid.
        look: how the shadow looks.
        strength: share of the light that a full shadow takes away, where the look gives none.

    Returns:
        (GRID, GRID) of linear light, from 0 (full light) to 1, row along +y, column along +x.

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
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = 0.5 * np.cross(b - a, c - a)
    middle = (a + b + c) / 3.0
    height = np.maximum(middle[:, 2], 0.0)
    cell = 2.0 * half_width_m / GRID
    slant = light_direction[:2] / light_direction[2]
    # A disc of radius r has a standard deviation of r / 2; slanting light stretches it.
    spread = 0.5 * look.lamp_radius_rad * (-light_direction[2]) ** -1.5
    shadow = _spread(
        middle[:, :2] - height[:, None] * slant,
        np.maximum(area @ light_direction / light_direction[2], 0.0) / cell**2,
        0.9 + height * (spread / cell),
        cell,
    )
    top = look.contact_height * half_width_m
    near = np.clip(1.0 - height / top, 0.0, 1.0) ** 2
    sky = _spread(
        middle[:, :2],
        np.maximum(-area[:, 2], 0.0) / cell**2 * near,
        0.010 * half_width_m / cell + 0.8 * height / cell,
        cell,
    )
    # Area that covers a place whole hides the lamp whole; in the rim, a part of the lamp.
    full = strength if look.strength is None else look.strength
    direct = full * np.minimum(shadow, 1.0)
    ambient = look.contact * (1.0 - np.exp(-DENSITY * sky))
    return np.asarray(1.0 - (1.0 - direct) * (1.0 - ambient))


def shade_step_m(half_width_m: float) -> float:
    """By multiples of this the grid may be moved without changing what it samples, metres."""
    return COARSEST * 2.0 * half_width_m / GRID


def shade_in_picture(
    shade: FloatArray, half_width_m: float, camera: Camera, camera_T_ground: Motor
) -> FloatArray | None:
    """The ground's shade as a camera sees it.

    Args:
        shade: (GRID, GRID) as from `ground_shade`.
        half_width_m: of its grid.
        camera: pinhole.
        camera_T_ground: pose of the ground in the camera.

    Returns:
        (height, width) float32 shade of every pixel, or None where the camera is below the ground.
    """
    eye_height_m = camera_T_ground.inverse().translation_m[2]
    if eye_height_m <= 0.0:
        return None
    cell = 2.0 * half_width_m / GRID
    grid_to_ground = np.array(
        [[cell, 0.0, 0.5 * cell - half_width_m], [0.0, cell, 0.5 * cell - half_width_m], [0, 0, 1]]
    )
    ground_to_picture = plane_homography(camera, camera_T_ground)
    picture_to_grid = np.linalg.inv(ground_to_picture @ grid_to_ground)
    shown = cv2.warpPerspective(
        shade.astype(np.float32),
        picture_to_grid,
        (camera.width, camera.height),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=0.0,
    )
    offset, fall = _offset_and_fall(camera, camera_T_ground)
    # What falls to the ground is one side of a straight line: the corners tell of all pixels.
    if np.min(offset * fall[:: max(1, len(fall) - 1), :: max(1, fall.shape[1] - 1)]) <= BARELY:
        shown[offset * fall <= BARELY] = 0.0
    return np.asarray(shown, dtype=np.float64)


def _spread(at: FloatArray, amount: FloatArray, sigma: FloatArray, cell: float) -> FloatArray:
    """Drop amounts onto the grid, each blurred by its own width in cells, in a few layers."""
    facing = np.flatnonzero(amount > 0.0)
    if not facing.size:
        return np.zeros((GRID, GRID))
    at, amount, sigma = at[facing], amount[facing], sigma[facing]
    widest = max(float(sigma.max()), 1.5 * float(sigma.min()))
    widths = np.geomspace(float(sigma.min()), widest, LAYERS)
    place = np.interp(sigma, widths, np.arange(LAYERS))
    total = np.zeros((GRID, GRID))
    for layer, width in enumerate(widths):
        share = amount * np.maximum(1.0 - np.abs(place - layer), 0.0)
        held = np.flatnonzero(share > 0.0)
        if held.size:
            total += _blurred(at[held] / cell, share[held], float(width))
    return total


def _blurred(at_cell: FloatArray, amount: FloatArray, width: float) -> FloatArray:
    """Amounts on the whole grid, blurred; for wide blurs a coarser grid is enough."""
    coarse = 1 if width < 4.0 else 2 if width < 8.0 else COARSEST
    size = GRID // coarse
    dropped = _dropped(at_cell / coarse + 0.5 * size - 0.5, amount / coarse**2, size)
    soft = cv2.GaussianBlur(
        dropped.astype(np.float32), (0, 0), width / coarse, borderType=cv2.BORDER_CONSTANT
    )
    return np.asarray(cv2.resize(soft, (GRID, GRID), interpolation=cv2.INTER_LINEAR))


def _dropped(at_cell: FloatArray, amount: FloatArray, size: int) -> FloatArray:
    """Bilinear sums of amounts on a square grid; what falls outside is lost."""
    x, y = np.ascontiguousarray(at_cell.T)
    inside = (x >= 0.0) & (x < size - 1) & (y >= 0.0) & (y < size - 1)
    if not inside.all():
        x, y, amount = x[inside], y[inside], amount[inside]
    column, row = x.astype(np.int64), y.astype(np.int64)
    right, up = x - column, y - row
    first = row * size + column
    above, below = amount * up, amount * (1.0 - up)
    cells = np.concatenate([first, first + 1, first + size, first + size + 1])
    shares = [below * (1.0 - right), below * right, above * (1.0 - right), above * right]
    total = np.bincount(cells, weights=np.concatenate(shares), minlength=size * size)
    return np.asarray(total.reshape(size, size))


def ground_depth(camera: Camera, camera_T_ground: Motor) -> FloatArray:
    """Depth of the ground along the optical axis, for every pixel.

    Args:
        camera: pinhole.
        camera_T_ground: pose of the ground in the camera.

    Returns:
        (height, width) metres; infinite at and above the horizon.
    """
    offset, fall = _offset_and_fall(camera, camera_T_ground)
    meets = offset * fall > BARELY
    return np.asarray(np.where(meets, offset / np.where(meets, fall, 1.0), np.inf))


def _offset_and_fall(camera: Camera, camera_T_ground: Motor) -> tuple[float, FloatArray]:
    """The ground's offset from the camera along its normal, and how far each pixel's ray, one
    metre deep, goes along it.
    """
    up = camera_T_ground.rotor.apply(UP)
    x = (np.arange(camera.width) - camera.cx) / camera.fx
    y = (np.arange(camera.height) - camera.cy) / camera.fy
    fall = up[0] * x[None, :] + up[1] * y[:, None] + up[2]
    return float(np.dot(up, camera_T_ground.translation_m)), fall
