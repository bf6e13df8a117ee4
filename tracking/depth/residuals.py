"""Residuals of colour and depth images between pairs of frames, and their derivatives.

Rays of colour meet the local plane that the same frame's depth shows; measured points are carried
to the local planes of another frame. Which plane belongs to what is looked up at one state, and
kept while poses and cameras are moved.

The inverse depth of a plane is linear in the pixel, whatever the focal length: where
``1/z = w + wu (u - u0) + wv (v - v0)``, the plane is ``n . X = 1`` with
``n = (fx wu, fy wv, w + wu (cx - u0) + wv (cy - v0))``. So planes that were fitted once serve all
focal lengths that are tried.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.cameras import DepthCamera, DepthImage
from motorcade.tracking.planes.plane import depth_sigma_m

GLOBALS = 8
"""Logarithms of the scales of both focal lengths (colour, depth), then a twist of the depth camera
in its own frame: rotation (rad), translation (m)."""
CORNER_PX = 4.5
"""Of corners: a structured-light sensor matches windows of 9 pixels, so that the surface behind a
corner may be that of half a window beside it. Counted as surely as it was tracked, to half a pixel,
a corner pulls surfaces apart; as it is, corners hold what depth alone does not (a flat wall). On
frames 0 to 399 of 7-Scenes' kitchen surfaces 300 frames apart ended 8.0 mm from each other with
0.5 px, 6.8 with 2 and with 4 px."""
GATE = 6.0
_COSINE = 0.7
"""Surfaces that face further apart than 45 degrees are not the same."""
_LOOKUPS = 4
_NEAR_PX = 3.0
_EVERY_PX = 28


@dataclass(frozen=True, eq=False)
class Matches:
    """Corners of one frame tracked to another: ``(n,)`` both frames, ``(n, 2)`` both pixels."""

    first: IntArray
    second: IntArray
    px: FloatArray
    second_px: FloatArray


@dataclass(frozen=True, eq=False)
class RgbdState:
    """Poses, and the cameras that the frames were taken by."""

    world_T_colour: Motor
    colour: Camera
    depth: DepthCamera

    def moved(self, step: FloatArray) -> RgbdState:
        """Retract by eight globals, then six numbers a frame."""
        shared = step[:GLOBALS]
        return RgbdState(
            self.world_T_colour.retract(step[GLOBALS:].reshape(-1, 6)),
            _zoomed(self.colour, shared[0]),
            DepthCamera(
                _zoomed(self.depth.camera, shared[1]),
                self.depth.colour_T_depth.retract(shared[2:]),
            ),
        )


class FrameMatrices:
    """A state's matrices."""

    def __init__(self, state: RgbdState) -> None:
        self.colour, self.depth = state.colour, state.depth.camera
        self.world_T = state.world_T_colour.as_matrix()
        self.T_world = state.world_T_colour.inverse().as_matrix()
        self.colour_T_depth = state.depth.colour_T_depth.as_matrix()
        self.depth_T_colour = state.depth.colour_T_depth.inverse().as_matrix()
        self.focal = np.array([self.depth.fx, self.depth.fy])
        self.centre = np.array([self.depth.cx, self.depth.cy])

    def planes(self, planes: FloatArray, px: FloatArray) -> FloatArray:
        """Planes at pixels of depth, as ``n . X = 1`` in the depth camera."""
        return normals(planes, px, self.focal, self.centre)


@dataclass(frozen=True, eq=False)
class Link:
    """Derivatives ``(n, r, 6)`` by twists of both frames' poses."""

    by_first: FloatArray
    by_second: FloatArray

    @classmethod
    def of(
        cls, first: FloatArray, relative: FloatArray, second: FloatArray, by_point: FloatArray
    ) -> Link:
        """From the point in both colour cameras, what carries it, and ``(n, r, 3)``."""
        turned = np.einsum("nrj,njk->nrk", by_point, relative[:, :3, :3])
        return cls(_by_motion(first, turned), -_by_motion(second, by_point))


def _by_motion(point: FloatArray, by_point: FloatArray) -> FloatArray:
    """``(n, r, 6)`` by a motion of points: about them (rad), then along (m)."""
    turn = np.cross(point[:, None], by_point)
    return np.concatenate([turn, by_point], axis=-1)


def _apply(matrix: FloatArray, points: FloatArray) -> FloatArray:
    turned: FloatArray = np.einsum("...ij,...j->...i", matrix[..., :3, :3], points)
    return turned + matrix[..., :3, 3]


def _runs(first: IntArray, second: IntArray) -> list[tuple[IntArray, int, int]]:
    """Rows of every pair of frames."""
    if not len(first):
        return []
    keys, owner = np.unique(np.stack([first, second], axis=-1), axis=0, return_inverse=True)
    order = np.argsort(owner.ravel(), kind="stable")
    rows = np.split(order, np.searchsorted(owner.ravel()[order], np.arange(1, len(keys))))
    return [(mine, int(a), int(b)) for mine, (a, b) in zip(rows, keys, strict=True)]


@dataclass(frozen=True, eq=False)
class CornerLinks:
    """Corners, and the plane of their own frame's depth that each one's ray meets."""

    matches: Matches
    planes: FloatArray
    plane_px: FloatArray
    pairs: list[tuple[IntArray, int, int]]

    @classmethod
    def at(cls, state: RgbdState, surfaces: DepthSurfaces, matches: Matches) -> CornerLinks:
        """Look up the planes at a state; corners whose ray meets none are left out."""
        frames = FrameMatrices(state)
        origin, along = _rays(frames, matches.px)
        ahead = np.full(len(along), 2.0)
        planes, at = np.zeros((len(along), 3)), np.zeros((len(along), 2))
        for _ in range(_LOOKUPS):
            px = state.depth.camera.project(origin + ahead[:, None] * along, allow_nan=True)
            planes, at = surfaces.at(matches.first, px)
            ahead = np.nan_to_num(_met(frames.planes(planes, at), origin, along), nan=2.0)
        px = state.depth.camera.project(origin + ahead[:, None] * along, allow_nan=True)
        near = np.isfinite(planes[:, 0]) & (np.linalg.norm(px - at, axis=-1) < _NEAR_PX)
        kept = Matches(
            matches.first[near], matches.second[near], matches.px[near], matches.second_px[near]
        )
        return cls(kept, planes[near], at[near], _runs(kept.first, kept.second))

    def residuals(self, frames: FrameMatrices) -> tuple[FloatArray, Link, FloatArray]:
        """Residuals ``(n, 2)``, their derivatives, and depths ``(n,)`` in metres."""
        matches = self.matches
        origin, along = _rays(frames, matches.px)
        ahead = _met(frames.planes(self.planes, self.plane_px), origin, along)
        point = frames.colour.unproject(matches.px) * ahead[:, None]
        relative = frames.T_world[matches.second] @ frames.world_T[matches.first]
        there = _apply(relative, point)
        px, by_point = frames.colour.project_jacobian(np.nan_to_num(there, nan=-1.0))
        lost = ~np.isfinite(px[:, 0])
        residual = np.where(lost[:, None], 2 * GATE, (px - matches.second_px) / CORNER_PX)
        by_point = np.where(lost[:, None, None], 0.0, by_point / CORNER_PX)
        return residual, Link.of(point, relative, there, by_point), ahead


def _rays(frames: FrameMatrices, px: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rays of the colour camera's pixels in the depth camera, a metre along its axis."""
    turn = frames.depth_T_colour[:3, :3]
    return frames.depth_T_colour[:3, 3], frames.colour.unproject(px) @ turn.T


def _met(planes: FloatArray, origin: FloatArray, along: FloatArray) -> FloatArray:
    """How far along rays ``(n, 3)`` they meet planes ``n . X = 1``."""
    slope = np.sum(planes * along, axis=-1)
    return (1.0 - planes @ origin) / np.where(slope > 1e-3, slope, np.nan)


@dataclass(frozen=True, eq=False)
class DepthLinks:
    """Pixels of one frame's depth, and the planes of another's that they fall on."""

    first: IntArray
    second: IntArray
    px: FloatArray
    inverse: FloatArray
    planes: FloatArray
    plane_px: FloatArray
    pairs: list[tuple[IntArray, int, int]]

    @classmethod
    def at(
        cls,
        state: RgbdState,
        surfaces: DepthSurfaces,
        pairs: Sequence[tuple[int, int]],
        gate_m: float | None = None,
    ) -> DepthLinks:
        """Look up the planes at a state; those too far, or turned away, are left out."""
        grids = {frame: surfaces.grid(frame, _EVERY_PX) for frame, _ in pairs}
        none = np.zeros(0, dtype=np.int64)
        first = np.concatenate([none, *(np.full(len(grids[a][1]), a) for a, _ in pairs)])
        second = np.concatenate([none, *(np.full(len(grids[a][1]), b) for a, b in pairs)])
        px = np.concatenate([np.zeros((0, 2)), *(grids[a][0] for a, _ in pairs)])
        inverse = np.concatenate([np.zeros(0), *(grids[a][1] for a, _ in pairs)])
        frames = FrameMatrices(state)
        _, relative, _, there = _brought(frames, first, second, px, inverse)
        planes, at = surfaces.at(second, state.depth.camera.project(there, allow_nan=True))
        own, own_px = surfaces.at(first, px)
        facing = frames.planes(planes, at)
        turned = (frames.depth_T_colour @ relative @ frames.colour_T_depth)[:, :3, :3]
        own_facing = np.einsum("nij,nj->ni", turned, frames.planes(own, own_px))
        lengths = np.linalg.norm(facing, axis=-1) * np.linalg.norm(own_facing, axis=-1)
        apart = np.abs(np.sum(facing * there, axis=-1) - 1.0) / np.linalg.norm(facing, axis=-1)
        near = np.sum(facing * own_facing, axis=-1) > _COSINE * lengths
        near &= apart < (GATE * _sigma_m(there[:, 2]) if gate_m is None else gate_m)
        return cls(
            first[near],
            second[near],
            px[near],
            inverse[near],
            planes[near],
            at[near],
            _runs(first[near], second[near]),
        )

    def residuals(self, frames: FrameMatrices) -> tuple[FloatArray, Link, FloatArray]:
        """Residuals ``(n, 1)``, their derivatives, and distances ``(n,)`` in metres."""
        point, relative, other, there = _brought(
            frames, self.first, self.second, self.px, self.inverse
        )
        plane = frames.planes(self.planes, self.plane_px)
        length = np.linalg.norm(plane, axis=-1)
        distance = (np.sum(plane * there, axis=-1) - 1.0) / length
        sigma = _sigma_m(1.0 / self.inverse)
        turned = plane / length[:, None] @ frames.depth_T_colour[:3, :3]
        by_point = (turned / sigma[:, None])[:, None]
        link = Link.of(point, relative, other, by_point)
        return (distance / sigma)[:, None], link, np.abs(distance)


def _sigma_m(depth_m: FloatArray) -> FloatArray:
    """Of the distance between two measured surfaces."""
    return np.asarray(np.sqrt(2.0) * depth_sigma_m(depth_m))


def _brought(
    frames: FrameMatrices, first: IntArray, second: IntArray, px: FloatArray, inverse: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Measured points in the first colour camera, the motion, and in the second's both cameras."""
    ray = (px - frames.centre) / frames.focal
    seen = np.concatenate([ray, np.ones((len(ray), 1))], axis=-1) / inverse[:, None]
    point = _apply(frames.colour_T_depth, seen)
    relative = frames.T_world[second] @ frames.world_T[first]
    other = _apply(relative, point)
    return point, relative, other, _apply(frames.depth_T_colour, other)


def _zoomed(camera: Camera, logarithm: float) -> Camera:
    factor = float(np.exp(logarithm))
    return replace(camera, fx=camera.fx * factor, fy=camera.fy * factor)


_HALF = 3
"""Windows of 7 by 7 pixels: the noise of a plane's depth is a seventh of a pixel's, and a surface
of 2 cm at 2 m still fills one."""
_EVERY = 4
_SIGMAS = 3.0
"""A window that scatters by more than so many times the sensor's noise holds an edge."""


@dataclass(frozen=True, eq=False)
class DepthSurfaces:
    """The local planes of several depth images of one size, at every fourth pixel.

    Fields:
        planes: ``(k, rows, columns, 3)`` float32: inverse depth in 1/m, and its slopes along u and
            v; NaN at gaps, edges and where the surface is no plane.
    """

    planes: NDArray[np.float32]

    @classmethod
    def of(cls, images: list[DepthImage]) -> DepthSurfaces:
        """Fit them all."""
        return cls(np.stack([_fitted(image) for image in images]))

    def at(self, image: IntArray, px: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The planes ``(n, 3)`` nearest to pixels ``(n, 2)``, NaN for none, and their pixels."""
        cell = np.rint(np.nan_to_num(px, nan=-1e6) / _EVERY).astype(np.int64)
        rows, columns = self.planes.shape[1:3]
        inside = np.all((cell >= 0) & (cell < (columns, rows)), axis=-1)
        cell = np.where(inside[:, None], cell, 0)
        planes = self.planes[image, cell[:, 1], cell[:, 0]].astype(np.float64)
        planes[~inside] = np.nan
        return planes, (cell * _EVERY).astype(np.float64)

    def grid(self, image: int, every_px: int) -> tuple[FloatArray, FloatArray]:
        """Pixels ``(n, 2)`` of a grid that have a plane, and their inverse depths ``(n,)``."""
        step = max(every_px // _EVERY, 1)
        inverse = self.planes[image, step // 2 :: step, step // 2 :: step, 0]
        rows, columns = np.nonzero(np.isfinite(inverse))
        px = _EVERY * (np.stack([columns, rows], axis=-1) * step + step // 2)
        return px.astype(np.float64), inverse[rows, columns].astype(np.float64)


def _fitted(depth_m: DepthImage) -> NDArray[np.float32]:
    known = np.isfinite(depth_m) & (depth_m > 0.0)
    inverse = np.zeros(depth_m.shape)
    inverse[known] = 1.0 / depth_m[known].astype(np.float64)
    side = 2 * _HALF + 1
    ones, ramp = np.ones(side), np.arange(-_HALF, _HALF + 1.0)
    spread = float(np.sum(ramp**2)) * side

    def summed(image: FloatArray, along: FloatArray, down: FloatArray) -> FloatArray:
        sums = cv2.sepFilter2D(image, cv2.CV_64F, along, down, borderType=cv2.BORDER_CONSTANT)
        return np.asarray(sums, np.float64)

    full = summed(known.astype(np.float64), ones, ones) > side * side - 0.5
    mean = summed(inverse, ones, ones) / side**2
    slope_u, slope_v = summed(inverse, ramp, ones) / spread, summed(inverse, ones, ramp) / spread
    scatter = summed(inverse**2, ones, ones) / side**2 - mean**2
    scatter -= (slope_u**2 + slope_v**2) * spread / side**2
    ahead = 1.0 / np.where(full, mean, 1.0)
    full &= scatter <= (_SIGMAS * depth_sigma_m(ahead) / ahead**2) ** 2
    planes = np.stack([mean, slope_u, slope_v], axis=-1)
    planes[~full] = np.nan
    return planes[::_EVERY, ::_EVERY].astype(np.float32)


def normals(
    planes: FloatArray, px: FloatArray, focal: FloatArray, centre: FloatArray
) -> FloatArray:
    """The planes ``n . X = 1`` as ``(n, 3)``, of planes at pixels; lengths ``(2,)`` in pixels."""
    slopes = planes[:, 1:]
    offset = planes[:, 0] + np.sum(slopes * (centre - px), axis=-1)
    return np.concatenate([slopes * focal, offset[:, None]], axis=-1)
