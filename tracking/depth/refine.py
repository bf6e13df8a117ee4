"""A path and its map refined by whole depth images, once tracking is done.

Tracking uses depth at corners alone. Here the surfaces of keyframes and of frames between them,
neighbours and those that came back to the same place, are laid on each other (point to plane),
together with the map's corners. All other frames follow them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.adjustment import (
    CamerasPrior,
    NothingShared,
    RgbdFit,
    adjust_rgbd,
    plane_distance_m,
)
from motorcade.tracking.depth.cameras import DepthCamera, DepthImage
from motorcade.tracking.depth.residuals import GLOBALS, DepthSurfaces, Matches, RgbdState
from motorcade.tracking.slam.mapping.map import MapSnapshot

_MOST_FRAMES = 60
"""Keyframes, and as many between: equations of so many poses are solved in a tenth of a second, and
their surfaces fill 60 MB. What lies between moves as they do."""
_FOCAL_SIGMA = 0.1
"""Share by which a stated focal length is believed to be wrong where it contradicts."""
_NEIGHBOURS = 2
_PARTNERS = 12
_FEWEST_SHARED = 20
_FACING = 0.5
_NEAR = 0.5
"""Keyframes whose axes lie within 60 degrees, and half the scene's depth from each other."""


@dataclass(frozen=True, eq=False)
class RefinedByDepth:
    """What became of a path and its map.

    Fields:
        trajectory: world_T_camera of the same frames.
        map: with refined keyframes, and points moved along with them.
        before_m, after_m: median distance between the surfaces of two frames; it became less.
    """

    trajectory: Trajectory
    map: MapSnapshot
    before_m: float
    after_m: float


def refine_by_depth(
    snapshot: MapSnapshot,
    path: Trajectory,
    colour: Camera,
    taken_by: DepthCamera,
    depth_at: Callable[[int], DepthImage | None],
) -> RefinedByDepth | None:
    """Refine a metric map and the path that was tracked in it.

    Args:
        snapshot: the map.
        path: poses of frames, keyframes among them.
        colour: the camera of the map's pixels: a pinhole, or a fisheye as it is.
        taken_by: the depth images' camera, a pinhole.
        depth_at: the depth image ``(height, width)`` of a frame of the path, by its stamp.

    Returns:
        None where there is nothing to lay on each other (fewer than two frames with depth, or
        frames that see too little of the same), and where the surfaces lie no nearer to each other
        afterwards: then the path is better left as it was tracked.
    """
    between = path.time_ns[:: max(-(-len(path) // _MOST_FRAMES), 1)]
    seen = RgbdFrames.of(snapshot, path, between, colour, taken_by, depth_at)
    fit = None if seen is None else seen.adjusted(np.zeros(GLOBALS))
    if seen is None or fit is None:
        return None
    before_m = plane_distance_m(seen.start, seen.surfaces, seen.pairs)
    after_m = plane_distance_m(fit.state, seen.surfaces, seen.pairs)
    if not after_m < before_m:  # NaN, where no surfaces meet, neither
        return None
    moved = _Moved(seen.time_ns, seen.start.world_T_colour, fit.state.world_T_colour)
    keyframes = moved.poses(snapshot.time_ns, snapshot.world_T_camera)
    refined = Trajectory(path.time_ns, moved.poses(path.time_ns, path.motors))
    return RefinedByDepth(
        refined,
        replace(snapshot, world_T_camera=keyframes, points=_points(snapshot, keyframes)),
        before_m,
        after_m,
    )


@dataclass(frozen=True, eq=False)
class FocalFactor:
    """By what both focal lengths, of colour and of depth, have to be multiplied; its deviation."""

    factor: float
    sigma: float


def focal_factor(
    snapshot: MapSnapshot,
    path: Trajectory,
    colour: Camera,
    taken_by: DepthCamera,
    depth_at: Callable[[int], DepthImage | None],
) -> FocalFactor | None:
    """Find by what both focal lengths are wrong alike, of depth that lies on colour.

    Edges that fit tell the ratio of both, and nothing else: here they are found each for itself, by
    corners and by surfaces that a moving camera saw again, and the mean of both is taken. (It needs
    rotation: a camera that only shifts sees the same with longer lenses and farther away.)

    Args:
        snapshot: the map.
        path: poses of frames, keyframes among them.
        colour: the camera of the map's pixels.
        taken_by: the depth images' camera.
        depth_at: the depth image of a keyframe, by its stamp.

    Returns:
        None where frames see too little of the same.
    """
    seen = RgbdFrames.of(snapshot, path, snapshot.time_ns[:0], colour, taken_by, depth_at)
    sigma = np.zeros(GLOBALS)
    sigma[:2] = _FOCAL_SIGMA
    fit = None if seen is None else seen.adjusted(sigma)
    if fit is None:
        return None
    state = fit.state
    longer = state.colour.fx / colour.fx * state.depth.camera.fx / taken_by.camera.fx
    spread = float(np.sqrt(fit.covariance[:2, :2].sum())) / 2.0
    return FocalFactor(float(np.sqrt(longer)), float(np.sqrt(longer)) * spread)


@dataclass(frozen=True, eq=False)
class RgbdFrames:
    """Frames of a path that have depth, as an adjustment takes them.

    Fields:
        time_ns: their stamps ``(k,)``.
        start: their poses and cameras; surfaces: of their depth.
        matches: corners that keyframes share.
        pairs: frames that look at the same.
    """

    time_ns: IntArray
    start: RgbdState
    surfaces: DepthSurfaces
    matches: Matches
    pairs: list[tuple[int, int]]

    @classmethod
    def of(
        cls,
        snapshot: MapSnapshot,
        path: Trajectory,
        between: IntArray,
        colour: Camera,
        taken_by: DepthCamera,
        depth_at: Callable[[int], DepthImage | None],
    ) -> RgbdFrames | None:
        """Of a map's keyframes and frames between; None with fewer than two that have depth."""
        own = np.flatnonzero(np.isin(snapshot.time_ns, path.time_ns))
        own = own[:: max(-(-len(own) // _MOST_FRAMES), 1)]
        images = {
            stamp: depth_at(stamp)
            for stamp in np.union1d(snapshot.time_ns[own], between).astype(np.int64).tolist()
        }
        stamps = np.array([stamp for stamp, one in images.items() if one is not None], np.int64)
        if len(stamps) < 2:
            return None
        rows = own[np.isin(snapshot.time_ns[own], stamps)]
        surfaces = DepthSurfaces.of([one for one in images.values() if one is not None])
        start = RgbdState(path.motors_at(stamps), colour, taken_by)
        matches = _matches(snapshot, rows, np.searchsorted(stamps, snapshot.time_ns[rows]))
        return cls(stamps, start, surfaces, matches, _overlapping(start.world_T_colour, surfaces))

    def adjusted(self, sigma: FloatArray) -> RgbdFit | None:
        """Adjust the poses, and the cameras by deviations ``(8,)``; None without enough to see."""
        prior = CamerasPrior(self.start.colour, self.start.depth, sigma)
        try:
            return adjust_rgbd(self.start, self.surfaces, self.matches, self.pairs, [0], prior)
        except NothingShared:
            return None


@dataclass(frozen=True, eq=False)
class _Moved:
    """How keyframes moved; what lies between two moves as both do, by its share of the time."""

    time_ns: IntArray
    before: Motor
    after: Motor

    def poses(self, time_ns: IntArray, poses: Motor) -> Motor:
        first = np.clip(
            np.searchsorted(self.time_ns, time_ns, side="right") - 1, 0, len(self.time_ns) - 2
        )
        span = self.time_ns[first + 1] - self.time_ns[first]
        share = np.clip((time_ns - self.time_ns[first]) / span, 0.0, 1.0)
        world_T_world = self.after @ self.before.inverse()
        earlier, other = world_T_world[first] @ poses, world_T_world[first + 1] @ poses
        return earlier.retract(share[:, None] * earlier.local(other))


def _points(snapshot: MapSnapshot, keyframes: Motor) -> FloatArray:
    """Each point where the first keyframe that saw it has taken it."""
    points, seen = np.array(snapshot.points), np.full(len(snapshot.points), -1)
    seen[snapshot.point_of[::-1]] = snapshot.keyframe_of[::-1]
    held = np.flatnonzero(seen >= 0)
    owner = seen[held]
    in_camera = snapshot.world_T_camera[owner].inverse().apply(points[held])
    points[held] = keyframes[owner].apply(in_camera)
    return points


def _matches(snapshot: MapSnapshot, rows: IntArray, frames: IntArray) -> Matches:
    """Corners that keyframes `rows` near each other share, both ways, by numbers of `frames`."""
    first, second, px, second_px = [], [], [], []
    order = np.lexsort((snapshot.point_of, snapshot.keyframe_of))
    keyframe_of, point_of = snapshot.keyframe_of[order], snapshot.point_of[order]
    seen_px = snapshot.px[order]
    limits = np.searchsorted(keyframe_of, [rows, rows + 1])
    for a in range(len(rows)):
        mine = slice(limits[0, a], limits[1, a])
        for b in range(a + 1, min(a + 1 + _NEIGHBOURS, len(rows))):
            other = slice(limits[0, b], limits[1, b])
            _, here, away = np.intersect1d(
                point_of[mine], point_of[other], assume_unique=True, return_indices=True
            )
            if len(here) < _FEWEST_SHARED:
                continue
            there, back = seen_px[mine][here], seen_px[other][away]
            first += [np.full(len(here), frames[a]), np.full(len(here), frames[b])]
            second += [np.full(len(here), frames[b]), np.full(len(here), frames[a])]
            px += [there, back]
            second_px += [back, there]
    none, nowhere = np.zeros(0, dtype=np.int64), np.zeros((0, 2))
    return Matches(
        np.concatenate([none, *first]),
        np.concatenate([none, *second]),
        np.concatenate([nowhere, *px]),
        np.concatenate([nowhere, *second_px]),
    )


def _overlapping(world_T_camera: Motor, surfaces: DepthSurfaces) -> list[tuple[int, int]]:
    """Pairs of keyframes that look at the same: neighbours, and some of those farther apart."""
    axes = world_T_camera.as_matrix()[:, :3, 2]
    places = world_T_camera.translation_m
    depth_m = 1.0 / float(np.nanmedian(surfaces.planes[..., 0]))
    pairs = []
    for a in range(len(places) - 1):
        later = np.arange(a + 1, len(places))
        near = np.linalg.norm(places[later] - places[a], axis=-1) < _NEAR * depth_m
        near &= axes[later] @ axes[a] > _FACING
        far = later[near & (later > a + _NEIGHBOURS)]
        spread = np.unique(np.linspace(0, len(far) - 1, _PARTNERS).astype(np.int64))
        chosen = [*later[:_NEIGHBOURS].tolist(), *(far[spread].tolist() if len(far) else [])]
        pairs += [(a, b) for b in chosen]
    return pairs
