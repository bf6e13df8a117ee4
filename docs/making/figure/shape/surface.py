"""The mesh of a field's zero: marching cubes in stretched space, then pulled onto the true zero.

Fingers and a face need smaller triangles than a trunk. The grid is even in a stretched copy of
space in which hands and head are larger; its mesh comes back finer there. Only the left half is
made, on a grid with a plane at y = 0, and mirrored: the figure is symmetric to the bit.
Marching cubes: Lorensen and Cline (1987) in the form of Lewiner et al. (2003), by scikit-image.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from docs.making.figure.proportions import ARM_SPREAD_RAD
from docs.making.figure.shape.anatomy import SHOULDER_M
from docs.making.figure.shape.fields import BodyField
from motorcade.animation.easing import smoothstep
from motorcade.animation.vectors import box_corners
from motorcade.ga.arrays import FloatArray, IntArray

Flags = NDArray[np.bool_]

# Corners of the half space that holds the rest pose, metres.
LOW_M, HIGH_M = np.array([-0.26, 0.0, -0.02]), np.array([0.26, 0.62, 1.78])
# The grid is first seen in blocks of so many steps.
COARSE = 4
# Triangles times the square of the grid's step, by the number of triangles: the first guess.
GUESS = ([5_000, 8_000, 12_000, 20_000], [7.2, 7.1, 6.65, 6.2])
TOLERANCE, TRIES = 0.06, 10
RELAXATIONS, NEWTON_STEPS = 6, 4
# How much larger the head is, the hands at least and at most, and the step that fingers need.
HEAD, HANDS, HANDS_ALONG, FINGER_STEP_M = 1.1, (1.8, 2.6), 1.5, 0.0100
SHOULDER = (float(SHOULDER_M[0]), float(SHOULDER_M[1]), float(SHOULDER_M[2]))
ARM_LINE = (0.0, 1.0, -1.0 / float(np.tan(ARM_SPREAD_RAD)))


@dataclass(frozen=True)
class SymmetricMesh:
    """A closed surface that is its own mirror image.

    Attributes:
        vertices: (V, 3) m.
        normals: (V, 3) unit, outwards.
        triangles: (T, 3) counter-clockwise from outside.
        twins: (V,) the vertex at the mirrored place; itself in the plane y = 0.
        step_m: of the grid, about the length of an edge where nothing is stretched.
    """

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    twins: IntArray
    step_m: float


@dataclass(frozen=True)
class Stretch:
    """Space made larger beyond a station along one axis, around a straight line.

    Attributes:
        axis: 1 or 2, along which it begins.
        begin_m, end_m: between which the scales rise from 1.
        across, along: scales across that axis and along it, beyond.
        centre_m: (3,) a point of the line.
        direction: (3,) of the line, 1 along the axis.
    """

    axis: int
    begin_m: float
    end_m: float
    across: float
    along: float
    centre_m: tuple[float, float, float]
    direction: tuple[float, float, float]

    def _share(self, station: FloatArray) -> FloatArray:
        return smoothstep((station - self.begin_m) / (self.end_m - self.begin_m))

    def _table(self) -> tuple[FloatArray, FloatArray]:
        """Stations and where they come to lie."""
        station = np.linspace(-0.1, 2.0, 2101)
        scale = 1.0 + (self.along - 1.0) * self._share(station)
        step = 0.5 * (scale[1:] + scale[:-1]) * np.diff(station)
        return station, np.concatenate([[0.0], np.cumsum(step)]) + station[0]

    def _line(self, station: FloatArray) -> FloatArray:
        """(N, 3) the line's point at each station."""
        centre, direction = np.array(self.centre_m), np.array(self.direction)
        return np.asarray(centre + (station - centre[self.axis])[:, None] * direction)

    def forward(self, points: FloatArray) -> FloatArray:
        """Stretched points (N, 3)."""
        station = points[:, self.axis]
        line = self._line(station)
        scale = 1.0 + (self.across - 1.0) * self._share(station)
        made = line + (points - line) * scale[:, None]
        made[:, self.axis] = np.interp(station, *self._table())
        return np.asarray(made)

    def back(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (N, 3) before the stretch, and its scale (N,) across there."""
        known, stretched = self._table()
        station = np.interp(points[:, self.axis], stretched, known)
        line = self._line(station)
        scale = 1.0 + (self.across - 1.0) * self._share(station)
        unstretched = points.copy()
        unstretched[:, self.axis] = station
        return np.asarray(line + (unstretched - line) / scale[:, None]), scale


@dataclass(frozen=True)
class Grid:
    """An even grid in stretched space: its step there, and how much larger the hands are."""

    step_m: float

    @property
    def stretches(self) -> tuple[Stretch, Stretch]:
        """Hands, then head. Coarse grids need larger hands, or fingers would fall through."""
        hands = float(np.clip(self.step_m / FINGER_STEP_M, *HANDS))
        return (
            Stretch(1, 0.370, 0.430, hands, HANDS_ALONG, SHOULDER, ARM_LINE),
            Stretch(2, 1.230, 1.330, HEAD, HEAD, (0.0, 0.0, 1.5), (0.0, 0.0, 1.0)),
        )

    def stretched(self, points: FloatArray) -> FloatArray:
        """Points (N, 3) taken into stretched space."""
        for stretch in self.stretches:
            points = stretch.forward(points)
        return points

    def back(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (N, 3) taken back from it, and how much larger it is there (N,)."""
        total = np.ones(len(points))
        for stretch in self.stretches[::-1]:
            points, scale = stretch.back(points)
            total *= scale
        return points, total


def meshed(field: BodyField, triangles: int) -> SymmetricMesh:
    """The field's surface with about so many triangles (to 15 %).

    Raises:
        RuntimeError: no grid was found whose surface is one piece without handles.
    """
    step = float(np.sqrt(np.interp(triangles, *GUESS) / triangles))
    for _ in range(TRIES):
        points, faces = _half(field, Grid(step))
        share = 2 * len(faces) / triangles
        if abs(share - 1.0) > TOLERANCE:
            step *= float(np.sqrt(share))
        elif not _is_disc(points, faces):  # fingers that fell off, or grew together
            step *= 0.985
        else:
            break
    else:
        raise RuntimeError(f"meshed: no grid gives about {triangles} triangles in one whole piece")
    middle = points[:, 1] == 0.0
    both, whole = _mirrored(points, faces, middle)
    half = _relaxed(both, whole)[: len(points)]
    half[middle, 1] = 0.0
    vertices = _pulled(field, Grid(step).back(half)[0], middle)
    slope = field.gradient(vertices)
    slope[middle, 1] = 0.0
    normals = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    count, aside = len(points), np.flatnonzero(~middle)
    twins = np.concatenate([np.arange(count), aside])
    twins[aside] = count + np.arange(len(aside))
    vertices, normals = (_mirrored(one, faces, middle)[0] for one in (vertices, normals))
    return SymmetricMesh(vertices, normals, whole, twins, step)


def _half(field: BodyField, grid: Grid) -> tuple[FloatArray, IntArray]:
    """Marching cubes over the left half, in stretched space."""
    from skimage.measure import marching_cubes

    low, volume = _sampled(field, grid)
    points, faces, _, _ = marching_cubes(volume, 0.0, gradient_direction="ascent")
    made = points.astype(np.float64) * grid.step_m + low
    made[points[:, 1] == 0.0, 1] = 0.0
    return made, faces[:, ::-1].astype(np.int64)


def _sampled(field: BodyField, grid: Grid) -> tuple[FloatArray, NDArray[np.float32]]:
    """First node and float32 values (X, Y, Z) of the grid: exact near the surface, signs beyond."""
    step = grid.step_m
    reach = grid.stretched(box_corners(np.stack([LOW_M, HIGH_M])))
    low, high = reach.min(axis=0), reach.max(axis=0)
    # the ground falls between two planes of nodes
    low[1], low[2] = 0.0, (np.floor(low[2] / step) - 0.37) * step
    blocks = np.ceil((high - low) / (COARSE * step)).astype(int)
    centre = (np.moveaxis(np.indices(blocks), 0, -1) + 0.5) * (COARSE * step) + low
    points, scale = grid.back(centre.reshape(-1, 3))
    radius = 0.5 * np.sqrt(3.0) * COARSE * step
    rough = (scale * field.distance_m(points, 2.0 * radius)).reshape(blocks)
    near = np.abs(rough) < 1.45 * radius
    volume = np.repeat(np.repeat(np.repeat(rough, COARSE, 0), COARSE, 1), COARSE, 2)
    volume = np.pad(volume.astype(np.float32), ((0, 1),) * 3, mode="edge")
    wanted = np.zeros(volume.shape, dtype=bool)
    flags = np.repeat(np.repeat(np.repeat(near, COARSE, 0), COARSE, 1), COARSE, 2)
    for dx in (0, 1):
        for dy in (0, 1):
            for dz in (0, 1):
                nx, ny, nz = flags.shape
                wanted[dx : nx + dx, dy : ny + dy, dz : nz + dz] |= flags
    nodes = np.argwhere(wanted)
    points, scale = grid.back(nodes * step + low)
    volume[wanted] = scale * field.distance_m(points, 2.5 * step)
    volume[volume == 0.0] = 1e-9
    return low, volume


def _is_disc(points: FloatArray, faces: IntArray) -> bool:
    """Whether half a body is one piece without handles: its Euler characteristic is 1."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    count = len(np.unique(edges[:, 0] * len(points) + edges[:, 1]))
    return len(points) - count + len(faces) == 1


def _mirrored(points: FloatArray, faces: IntArray, middle: Flags) -> tuple[FloatArray, IntArray]:
    """Both halves of a mesh whose open edge lies in the plane y = 0, which they share."""
    count = len(points)
    aside = ~middle
    twin = np.arange(count)
    twin[aside] = count + np.arange(int(aside.sum()))
    both = np.concatenate([points, points[aside] * [1.0, -1.0, 1.0]])
    return both, np.concatenate([faces, twin[faces][:, ::-1]])


def _relaxed(points: FloatArray, faces: IntArray) -> FloatArray:
    """Vertices moved along the surface towards the mean of their neighbours: even triangles."""
    from scipy.sparse import coo_array

    count, edges = len(points), faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    links = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (count, count)).tocsr()
    share = 1.0 / np.bincount(edges[:, 0], minlength=count)[:, None]
    ones = np.ones(faces.size)
    corners = coo_array((ones, (faces.T.ravel(), np.tile(np.arange(len(faces)), 3)))).tocsr()
    for _ in range(RELAXATIONS):
        first, second, third = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
        normal = np.asarray(corners @ np.cross(second - first, third - first))
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        move = share * (links @ points) - points
        points = points + 0.6 * (move - np.sum(move * normal, axis=1, keepdims=True) * normal)
    return points


def _pulled(field: BodyField, points: FloatArray, middle: Flags) -> FloatArray:
    """Vertices moved onto the true zero by Newton steps; those in the middle stay there."""
    for _ in range(NEWTON_STEPS):
        slope = field.gradient(points)
        slope[middle, 1] = 0.0
        size = np.maximum(np.einsum("ni,ni->n", slope, slope), 0.05)
        points = points - (field.distance_m(points, 0.01) / size)[:, None] * slope
    return points
