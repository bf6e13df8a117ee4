"""What is put on the body: rims, soles, scarf, goggles, ear pads, pack, eyes and mouth.

Each is a closed surface of its own: a tube around a curve, or a rounded solid. Curves and places
are found on the body's surface, so that they sit on it whatever its shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from docs.making.figure.proportions import HIP_HALF_WIDTH_M
from docs.making.figure.shape.anatomy import (
    BOOT_Z,
    COLLAR_Z,
    CUFF,
    HEM_Z,
    RIM,
    SHOULDER_M,
    SKULL_M,
    arm_axes,
)
from docs.making.figure.shape.fields import BodyField
from motorcade.ga.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Piece:
    """A closed surface and how it lies in the image.

    Attributes:
        name: what it is; the paint goes by it.
        vertices, normals: (V, 3).
        triangles: (T, 3).
        flat_m: (V, 2) its unrolled surface, metres; vertices are doubled along its seams.
        joint: that carries it whole; empty where it goes with the skin below it.
        mirrored: whether there is another on the right, its mirror image.
    """

    name: str
    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    flat_m: FloatArray
    joint: str = ""
    mirrored: bool = False


def pieces(field: BodyField) -> list[Piece]:
    """All of them; those with a twin on the left only."""
    return [*_clothes(field), *_head(field), _pack()]


def _clothes(field: BodyField) -> list[Piece]:
    level, aside = np.eye(3)[:2], HIP_HALF_WIDTH_M
    cuff = SHOULDER_M + (CUFF + 0.004) * arm_axes()[2]
    boot = np.array([0.0, aside, BOOT_Z])
    made = [
        tube("hem", girdle(field, np.array([0.0, 0.0, HEM_Z]), level, 36), (0.019, 0.013), 6),
        tube("boot rim", girdle(field, boot, level, 18), (0.018, 0.013), 6, mirrored=True),
        tube(
            "glove rim", girdle(field, cuff, arm_axes()[:2], 16), (0.015, 0.011), 6, mirrored=True
        ),
        tube("sole", _sole_outline(field), (0.019, 0.011), 6, mirrored=True),
    ]
    turn = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
    for joint, up, wide, thick in (("chest", 0.0, 0.092, 0.044), ("neck", 0.042, 0.078, 0.036)):
        ring = np.stack(
            [
                wide * np.cos(turn) - 0.004,
                1.08 * wide * np.sin(turn),
                COLLAR_Z + up - 0.016 * np.cos(turn) + 0.006 * np.sin(3.0 * turn + up * 60.0),
            ],
            axis=1,
        )
        made.append(tube("scarf", ring, (thick, thick), 8, joint))
    ends = np.array([[0.104, 0.030, 1.190], [0.128, 0.052, 1.13], [0.136, 0.060, 1.06]])
    made.append(_limb("scarf", ends, (0.030, 0.036, 0.042), 0.45, "chest"))
    return made


def _head(field: BodyField) -> list[Piece]:
    height, slope = RIM
    plane = np.stack([np.array([1.0, 0.0, slope]) / np.hypot(1.0, slope), [0.0, 1.0, 0.0]])
    rim = girdle(field, np.array([0.0, 0.0, height]), plane, 36)
    made = [tube("cap rim", rim, (0.017, 0.012), 6, joint="head")]
    at, axes = _seat(field, np.array([-0.06, 1.0, -0.05]))
    made.append(_disc("ear pad", at - 0.006 * axes[2], axes, 0.082, 0.040, "head"))
    made.append(_disc("ear cap", at + 0.028 * axes[2], axes, 0.048, 0.018, "head"))
    at, axes = _seat(field, np.array([1.0, 0.315, 0.53]))
    turn = np.linspace(0.0, 2.0 * np.pi, 21)[:-1]
    ring = (
        at
        + 0.014 * axes[2]
        + 0.062 * (np.cos(turn)[:, None] * axes[0] + np.sin(turn)[:, None] * axes[1])
    )
    made.append(tube("goggle", ring, (0.016, 0.016), 7, joint="head", mirrored=True))
    made.append(_disc("lens", at + 0.008 * axes[2], axes, 0.060, 0.024, "head"))
    bridge, _ = _seat(field, np.array([1.0, 0.0, 0.555]))
    ends = bridge + np.array([[0.008, -0.035, 0], [0.014, 0.0, 0.003], [0.008, 0.035, 0]])
    made.append(_limb("goggle", ends, (0.012, 0.011, 0.012), 1.0, "head"))
    at, axes = _seat(field, np.array([1.0, 0.385, -0.235]))
    made.append(ball("eye", at - 0.004 * axes[2], axes, (0.030, 0.041, 0.014), "head", True))
    at, axes = _seat(field, np.array([1.0, 0.40, 0.105]))
    line = np.linspace(-1.0, 1.0, 4)[:, None]
    arch = 0.006 * (1.0 - 2.0 * line**2) - 0.005 * line
    brow = at + 0.027 * line * axes[0] + arch * axes[1] - 0.008 * line**2 * axes[2]
    made.append(_limb("brow", brow, (0.0055,) * 4, 1.0, "head", mirrored=True))
    made.append(mouth(field))
    return made


def mouth(field: BodyField, wide: float = 0.20, curve: float = 0.055) -> Piece:
    """A line that smiles: half its width as a slope from the skull's centre, and how it bends."""
    line = np.linspace(-1.0, 1.0, 7)
    points = np.stack(
        [
            _seat(field, np.array([1.0, wide * share, -0.475 + curve * (share**2 - 0.5)]))[0]
            for share in line
        ]
    )
    return _limb("mouth", points, (0.0045, *[0.0062] * 5, 0.0045), 1.0, "head")


def _pack() -> Piece:
    """A soft box on the back."""
    half = (0.132, 0.152, 0.080)
    return ball("pack", np.array([-0.168, 0.0, 0.955]), _upright(), half, "chest", corner=3.2)


def _upright() -> FloatArray:
    """Axes (3, 3) of something seen from behind: to its right, up, back."""
    return np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])


def on_surface(field: BodyField, start: FloatArray, ways: FloatArray) -> FloatArray:
    """Where rays (N, 3) from a point (3,) inside first leave the body, within 0.6 m."""
    reach = np.linspace(0.0, 0.6, 241)
    points = start + reach[None, :, None] * ways[:, None]
    outside = field.distance_m(points.reshape(-1, 3), 0.05).reshape(len(ways), -1) > 0.0
    first = np.argmax(outside, axis=1)
    low, high = reach[first - 1], reach[first]
    for _ in range(30):
        middle = 0.5 * (low + high)
        out = field.distance_m(start + middle[:, None] * ways, 0.05) > 0.0
        low, high = np.where(out, low, middle), np.where(out, middle, high)
    return np.asarray(start + low[:, None] * ways)


def girdle(field: BodyField, centre: FloatArray, axes: FloatArray, count: int) -> FloatArray:
    """Points (count, 3) where a plane through a point inside, with axes (2, 3), cuts the skin."""
    turn = 2.0 * np.pi * np.arange(count) / count
    ways = np.cos(turn)[:, None] * axes[0] + np.sin(turn)[:, None] * axes[1]
    return on_surface(field, centre, ways)


def _sole_outline(field: BodyField) -> FloatArray:
    """Around a shoe a little above the ground."""
    centre = np.array([0.052, HIP_HALF_WIDTH_M, 0.030])
    turn = 2.0 * np.pi * np.arange(26) / 26
    ways = np.stack([1.6 * np.cos(turn), np.sin(turn), np.zeros(26)], axis=1)
    points = on_surface(field, centre, ways / np.linalg.norm(ways, axis=1, keepdims=True))
    points[:, 2] = 0.0195
    return points


def _seat(field: BodyField, way: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A point (3,) of the head along a direction, and axes there: aside, up, outwards."""
    at = on_surface(field, SKULL_M, way[None] / np.linalg.norm(way))
    out = field.gradient(at)[0]
    out /= np.linalg.norm(out)
    aside = np.cross([0.0, 0.0, 1.0], out)
    aside /= np.linalg.norm(aside)
    return at[0], np.stack([aside, np.cross(out, aside), out])


def tube(
    name: str,
    ring: FloatArray,
    half_m: tuple[float, float],
    sides: int,
    joint: str = "",
    mirrored: bool = False,
) -> Piece:
    """A tube around a closed curve (K, 3), with half-widths across and along its plane's normal.

    The half-widths are along the normal of the curve's plane, and out of it.
    """
    count = len(ring)
    ahead = np.roll(ring, -1, axis=0) - np.roll(ring, 1, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    up = np.sum(np.cross(ring - ring.mean(axis=0), ahead), axis=0)
    up /= np.linalg.norm(up)
    out = np.cross(ahead, up)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    up_here = np.cross(out, ahead)
    rows = np.arange(count + 1) % count
    turn = 2.0 * np.pi * np.arange(sides + 1) / sides + np.pi
    high, wide = half_m
    across = np.cos(turn)[None, :, None] * out[rows, None]
    along = np.sin(turn)[None, :, None] * up_here[rows, None]
    points = ring[rows, None] + wide * across + high * along
    slope = across / wide + along / high
    normals = slope / np.linalg.norm(slope, axis=-1, keepdims=True)
    steps = np.linalg.norm(np.diff(ring[rows], axis=0), axis=1)
    far = np.concatenate([[0.0], np.cumsum(steps)])
    girth = np.pi * (high + wide)
    flat = np.stack(
        np.broadcast_arrays(far[:, None], girth * np.arange(sides + 1)[None] / sides), axis=-1
    )
    grid = _grid(count, sides)
    return _piece(name, points, normals, grid, flat, joint, mirrored)


def _limb(
    name: str,
    line: FloatArray,
    half_m: tuple[float, ...],
    flatness: float,
    joint: str,
    mirrored: bool = False,
) -> Piece:
    """A rounded stick along points (K, 3), as thick as `flatness` times its half-widths."""
    sides, fine = 6, 2 * len(line) - 1
    share = np.linspace(0.0, len(line) - 1.0, fine)
    at = np.stack([np.interp(share, np.arange(len(line)), column) for column in line.T], axis=1)
    half = np.interp(share, np.arange(len(line)), half_m)
    ahead = np.gradient(at, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(np.array([1.0, 0.0, 0.0]), ahead)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    out = np.cross(ahead, side)
    # half a ball at each end
    cap = np.linspace(-np.pi / 2.0, 0.0, 3)[:-1]
    flat_half = flatness * half
    rows = np.concatenate([[0] * 2, np.arange(fine), [fine - 1] * 2])
    size = np.concatenate([np.cos(cap), np.ones(fine), np.cos(cap[::-1])])
    push = np.concatenate([np.sin(cap), np.zeros(fine), -np.sin(cap[::-1])])
    centre = at[rows] + (push * half[rows])[:, None] * ahead[rows]
    turn = 2.0 * np.pi * np.arange(sides + 1) / sides
    across = np.cos(turn)[None, :, None] * side[rows, None]
    through = np.sin(turn)[None, :, None] * out[rows, None]
    wide, thick = (half[rows] * size)[:, None, None], (flat_half[rows] * size)[:, None, None]
    points = centre[:, None] + wide * across + thick * through
    slope = (
        size[:, None, None] * (across + through / flatness)
        + push[:, None, None] * ahead[rows, None]
    )
    normals = slope / np.linalg.norm(slope, axis=-1, keepdims=True)
    far = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(centre, axis=0), axis=1))])
    girth = np.pi * (1.0 + flatness) * float(np.mean(half))
    flat = np.stack(
        np.broadcast_arrays(far[:, None], girth * np.arange(sides + 1)[None] / sides), axis=-1
    )
    return _piece(
        name, points, normals, _grid(len(rows) - 1, sides)[:, ::-1], flat, joint, mirrored
    )


def _disc(
    name: str, centre: FloatArray, axes: FloatArray, radius_m: float, thick_m: float, joint: str
) -> Piece:
    """A cushion with a flat middle, seen along the third of its axes (3, 3)."""
    return ball(name, centre, axes, (radius_m, radius_m, thick_m), joint, True, power=3.0)


def ball(
    name: str,
    centre: FloatArray,
    axes: FloatArray,
    half_m: tuple[float, float, float],
    joint: str,
    mirrored: bool = False,
    power: float = 0.0,
    corner: float = 2.0,
) -> Piece:
    """An ellipsoid with half-axes along axes (3, 3), laid flat as it is seen along the third.

    With a power it is a cushion: its thickness falls off with that power of the radius. With a
    corner above 2 its outline nears a rectangle (a superellipse).
    """
    sides = 18 if corner == 2.0 else 28
    tilt = np.concatenate([np.linspace(0.0, 0.5 * np.pi, 5), [0.7 * np.pi, np.pi]])
    turn = 2.0 * np.pi * np.arange(sides + 1) / sides
    radius, height = np.sin(tilt), np.cos(tilt)
    if power:
        height = np.sign(height) * np.abs(1.0 - radius**power) ** (1.0 / power)
    around = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    outline = around / np.sum(np.abs(around) ** corner, axis=-1, keepdims=True) ** (1.0 / corner)
    level = outline[None] * radius[:, None, None]
    unit = np.concatenate([level, np.broadcast_to(height[:, None, None], level[..., :1].shape)], -1)
    points = centre + (unit * np.array(half_m)) @ axes
    slope = unit.copy()
    squared = np.sign(outline) * np.abs(outline) ** (corner - 1.0)
    slope[..., :2] = squared[None] * radius[:, None, None]
    if power:
        slope = np.sign(unit) * np.abs(unit) ** (power - 1.0)
        slope[..., :2] = unit[..., :2] * np.maximum(radius, 1e-9)[:, None, None] ** (power - 2.0)
    slope = slope / np.array(half_m)
    normals = slope / np.maximum(np.linalg.norm(slope, axis=-1, keepdims=True), 1e-12) @ axes
    # the front as it is seen, the back beyond it as a narrow rim
    spread = np.where(height >= 0.0, radius, 2.0 - radius)
    spread = np.where(height >= 0.0, spread, 1.0 + 0.25 * (spread - 1.0))
    flat = outline[None] * spread[:, None, None] * np.array([half_m[0], -half_m[1]])
    return _piece(name, points, normals, _grid(len(tilt) - 1, sides), flat, joint, mirrored)


def _grid(rows: int, columns: int) -> IntArray:
    """Triangles of a grid of so many cells, row after row."""
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1)
    below = corner + columns + 1
    first = np.stack([corner, below, corner + 1], axis=1)
    return np.concatenate([first, np.stack([corner + 1, below, below + 1], axis=1)])


def _piece(
    name: str,
    points: FloatArray,
    normals: FloatArray,
    triangles: IntArray,
    flat: FloatArray,
    joint: str,
    mirrored: bool,
) -> Piece:
    """Without triangles that have no area."""
    vertices = points.reshape(-1, 3)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    real = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-10
    used, numbers = np.unique(triangles[real], return_inverse=True)
    return Piece(
        name,
        vertices[used],
        normals.reshape(-1, 3)[used],
        numbers.reshape(-1, 3),
        flat.reshape(-1, 2)[used] - flat.reshape(-1, 2)[used].min(axis=0),
        joint,
        mirrored,
    )
