"""Closed smooth surfaces swept along a line: the turned wood that the mannequin is made of.

A loft is a stack of superelliptic rings between two poles. Its own frame has the sweep along an
axis, with ring half-widths `a` and `b` along the two others; triangles run counter-clockwise seen
from outside. All lengths are metres.
"""

from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Profile:
    """How a loft widens and bends along its axis, as controls that are joined by a smooth curve.

    Attributes:
        stations_m: (K,) increasing positions along the axis; the surface ends at the outer two.
        half_a_m: (K,) half-width along the first cross axis.
        half_b_m: (K,) half-width along the second cross axis.
        shift_a_m: (K,) displacement of the ring's centre along the first cross axis.
        shift_b_m: (K,) the same along the second.
        cap_start_m: length over which the first end is rounded to its pole.
        cap_end_m: length over which the last end is rounded to its pole.
        exponent: of the superellipse; 2 is an ellipse, larger is squarer.
    """

    stations_m: FloatArray
    half_a_m: FloatArray
    half_b_m: FloatArray
    shift_a_m: FloatArray
    shift_b_m: FloatArray
    cap_start_m: float
    cap_end_m: float
    exponent: float = 2.0


def profile(
    *rows: tuple[float, ...], caps_m: tuple[float, float], exponent: float = 2.0
) -> Profile:
    """A profile from rows `(station, half_a, half_b[, shift_a[, shift_b]])`, in metres.

    Args:
        rows: the controls, at rising stations.
        caps_m: rounding length at the first and at the last end.
        exponent: of the superellipse.

    Returns:
        The profile; shifts that a row leaves out are zero.
    """
    table = np.array([row + (0.0,) * (5 - len(row)) for row in rows])
    return Profile(
        table[:, 0], table[:, 1], table[:, 2], table[:, 3], table[:, 4], *caps_m, exponent=exponent
    )


def smooth_curve(stations: FloatArray, controls: FloatArray, at: FloatArray) -> FloatArray:
    """Values of a cubic curve through controls, without overshoot between them.

    Piecewise cubic Hermite with the limited slopes of Fritsch and Butland (1984), so that a limb
    never grows wider than the wider of two neighbouring controls.

    Args:
        stations: (K,) increasing.
        controls: (K,) values there.
        at: (*,) positions; outside the stations the end values hold.

    Returns:
        (*,) values.
    """
    if len(stations) < 2:
        return np.full(at.shape, controls[0])
    step = np.diff(stations)
    secant = np.diff(controls) / step
    slope = np.zeros(len(stations))
    left, right = secant[:-1], secant[1:]
    same = left * right > 0.0
    first, second = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
    denominator = np.where(same, first * right + second * left, 1.0)
    slope[1:-1] = np.where(same, (first + second) * left * right / denominator, 0.0)
    slope[0], slope[-1] = secant[0], secant[-1]
    place = np.clip(at, stations[0], stations[-1])
    k = np.clip(np.searchsorted(stations, place, side="right") - 1, 0, len(step) - 1)
    u = (place - stations[k]) / step[k]
    rise = controls[k] * (1 + 2 * u) * (1 - u) ** 2 + controls[k + 1] * (3 - 2 * u) * u**2
    bend = slope[k] * u * (1 - u) ** 2 - slope[k + 1] * u**2 * (1 - u)
    return np.asarray(rise + step[k] * bend)


def loft(
    shape: Profile, sides: int, rings: int, cap_rings: int
) -> tuple[FloatArray, IntArray, FloatArray]:
    """The closed surface of a profile, swept along +z of its own frame.

    Args:
        shape: the profile; its `a` lies along x and its `b` along y.
        sides: vertices a ring.
        rings: rings between the two rounded ends.
        cap_rings: rings in each rounded end.

    Returns:
        vertices (V, 3), triangles (T, 3) counter-clockwise from outside, and the station (V,) of
        each vertex along the axis.
    """
    start, end = shape.stations_m[0], shape.stations_m[-1]
    angle = np.arange(1, cap_rings + 1) * (0.5 * np.pi / (cap_rings + 1))
    body = np.linspace(start + shape.cap_start_m, end - shape.cap_end_m, rings)
    station = np.concatenate(
        [
            start + shape.cap_start_m * (1.0 - np.cos(angle)),
            body,
            end - shape.cap_end_m * (1.0 - np.cos(angle[::-1])),
        ]
    )
    shrink = np.concatenate([np.sin(angle), np.ones(rings), np.sin(angle[::-1])])
    ring = _unit_ring(sides, shape.exponent)
    half_a = smooth_curve(shape.stations_m, shape.half_a_m, station) * shrink
    half_b = smooth_curve(shape.stations_m, shape.half_b_m, station) * shrink
    walls = np.empty((len(station), sides, 3))
    walls[..., 0] = half_a[:, None] * ring[:, 0]
    walls[..., 1] = half_b[:, None] * ring[:, 1]
    walls[..., 2] = 0.0
    poles = np.zeros((2, 3))
    vertices = np.concatenate([walls.reshape(-1, 3), poles])
    along = np.concatenate([np.repeat(station, sides), [start, end]])
    vertices[:, 0] += smooth_curve(shape.stations_m, shape.shift_a_m, along)
    vertices[:, 1] += smooth_curve(shape.stations_m, shape.shift_b_m, along)
    vertices[:, 2] = along
    return vertices, _stacked_triangles(len(station), sides), along


def vertex_normals(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Unit normals of a triangle mesh, the mean of the faces around each vertex by their area.

    Args:
        vertices: (V, 3) m.
        triangles: (T, 3) vertex indices, counter-clockwise from outside.

    Returns:
        (V, 3) unit vectors. Every vertex must belong to a triangle with area.
    """
    corners = vertices[triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(total, triangles[:, corner], face)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(total / length)


def _unit_ring(sides: int, exponent: float) -> FloatArray:
    """(sides, 2) points of the unit superellipse, counter-clockwise."""
    angle = np.arange(sides) * (2.0 * np.pi / sides)
    point = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.asarray(np.sign(point) * np.abs(point) ** (2.0 / exponent))


def _stacked_triangles(rings: int, sides: int) -> IntArray:
    """Triangles of a stack of rings whose two poles are the last two vertices."""
    here = np.arange(sides)
    after = (here + 1) % sides
    base = (np.arange(rings - 1) * sides)[:, None]
    a, b = base + here, base + after
    c, d = b + sides, a + sides
    walls = np.concatenate(
        [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    )
    first_pole = np.full(sides, rings * sides)
    last_pole = first_pole + 1
    top = (rings - 1) * sides
    caps = [np.stack([after, here, first_pole], -1)]
    caps.append(np.stack([top + here, top + after, last_pole], -1))
    return np.concatenate([walls, *caps])
