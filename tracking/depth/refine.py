"""A path and its map refined by whole depth images, once tracking is done.

Tracking uses depth at corners alone. Here the surfaces of keyframes and of frames between them,
neighbours and those that came back to the same place, are laid on each other (point to plane),
together with the map's corners. All other frames follow them.

Unknown are the poses of some frames and, if they are asked for, what registers depth to colour:
both focal lengths and the depth camera's pose on the colour camera. There are two kinds of
residuals, each in its standard deviations and with a loss that outliers hardly pull:

- a corner of one frame is put on the surface that the same frame's depth shows, and reprojected
  into another frame, where it was tracked to;
- a pixel of one frame's depth is carried to another frame, and its distance from the local plane of
  that frame's depth is taken.

Which plane belongs to which ray is looked up anew between the minimisations.

Sources: Chen & Medioni 1992 (point to plane); Herrera, Kannala & Heikkila 2012 (colour and depth
cameras in one adjustment).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.progress import track
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.cameras import DepthCamera, DepthImage
from motorcade.tracking.depth.residuals import (
    CORNER_PX,
    GLOBALS,
    CornerLinks,
    DepthLinks,
    DepthSurfaces,
    FrameMatrices,
    Matches,
    RgbdState,
)
from motorcade.tracking.optimise import NormalEquations, Stop, huber_cauchy, minimise
from motorcade.tracking.slam.mapping.map import MapSnapshot

_HUBER, _OUTLIER = 1.5, 3.0
_ROUNDS = 8
_FAR_M = 0.1
"""Surfaces farther apart than that are two, when distances are only measured."""
_FEWEST_FRAMES = 3
_STEP = 1e-6
_STOP = Stop(steps=6, gain=1e-5)


class NothingShared(ValueError):
    """The frames see too little of the same for their poses to be adjusted."""


@dataclass(frozen=True, eq=False)
class CamerasPrior:
    """What is believed of the cameras beforehand: a state, and ``(8,)`` deviations of globals.

    A deviation of zero keeps the global where it is.
    """

    colour: Camera
    depth: DepthCamera
    sigma: FloatArray


@dataclass(frozen=True, eq=False)
class RgbdFit:
    """Where an adjustment ended.

    Fields:
        state: poses and cameras.
        covariance: ``(8, 8)`` of the globals, by what single frames change of them; infinite
            where fewer than three are compared with later ones.
        cost: mean robust loss of a residual.
        corner_px, plane_m: median reprojection error and median distance between the surfaces.
        count: residuals that took part.
    """

    state: RgbdState
    covariance: FloatArray
    cost: float
    corner_px: float
    plane_m: float
    count: int


def adjust_rgbd(
    start: RgbdState,
    surfaces: DepthSurfaces,
    matches: Matches,
    pairs: Sequence[tuple[int, int]],
    fixed: Sequence[int],
    prior: CamerasPrior,
) -> RgbdFit:
    """Minimise over the poses of all frames but the fixed ones, and over the free globals.

    Args:
        start: where to begin.
        surfaces: of the frames' depth images.
        matches: corners tracked between frames.
        pairs: frames whose depth is compared.
        fixed: frames that stay where they are, one at least a connected set.
        prior: of the globals.

    Raises:
        NothingShared: fewer residuals than unknowns.
    """
    free = np.ones(GLOBALS + 6 * len(start.world_T_colour), dtype=np.bool_)
    free[:GLOBALS] = prior.sigma > 0.0
    for frame in fixed:
        free[GLOBALS + 6 * frame : GLOBALS + 6 * frame + 6] = False
    state, problem = start, _Problem(start, surfaces, matches, pairs, prior, free)
    for _ in track(range(_ROUNDS), "laying depth on depth", _ROUNDS):
        minimum = minimise(state, problem.evaluate, problem.moved, _STOP)
        settled = minimum.start_cost - minimum.evaluation.cost <= 1e-3 * minimum.start_cost
        state = minimum.state
        problem = _Problem(state, surfaces, matches, pairs, prior, free)
        if settled:
            break
    return problem.fit(state)


def plane_distance_m(
    state: RgbdState, surfaces: DepthSurfaces, pairs: Sequence[tuple[int, int]]
) -> float:
    """Median distance between the surfaces of pairs of frames; NaN where none meet."""
    depths = DepthLinks.at(state, surfaces, pairs, gate_m=_FAR_M)
    distance_m = depths.residuals(FrameMatrices(state))[2]
    return float(np.median(distance_m)) if len(distance_m) else float("nan")


class _Problem:
    """The residuals with the planes that belong to them at one state."""

    def __init__(
        self,
        at: RgbdState,
        surfaces: DepthSurfaces,
        matches: Matches,
        pairs: Sequence[tuple[int, int]],
        prior: CamerasPrior,
        free: NDArray[np.bool_],
    ) -> None:
        self.prior, self.free = prior, free
        self.corners = CornerLinks.at(at, surfaces, matches)
        self.depths = DepthLinks.at(at, surfaces, pairs)
        if len(self.corners.matches.first) + len(self.depths.first) < np.count_nonzero(free):
            raise NothingShared(
                "frames: expected as many shared corners and surfaces as there are unknowns, "
                "got fewer"
            )

    def evaluate(self, state: RgbdState) -> _Evaluation:
        return _Evaluation(self, state)

    def moved(self, state: RgbdState, step: FloatArray) -> RgbdState:
        whole = np.zeros(len(self.free))
        whole[self.free] = step
        return state.moved(whole)

    def fit(self, state: RgbdState) -> RgbdFit:
        here = _Evaluation(self, state)
        sizes = np.concatenate([here.corner_size, here.depth_size])
        return RgbdFit(
            state,
            self._covariance(here),
            here.cost / max(len(sizes), 1),
            CORNER_PX * float(np.median(here.corner_size)) if len(here.corner_size) else np.nan,
            float(np.median(here.distance_m)) if len(here.distance_m) else np.nan,
            len(sizes),
        )

    def _covariance(self, here: _Evaluation) -> FloatArray:
        """Of the globals ``(8, 8)``, by what they would be without one frame or the other.

        A sensor's errors are alike all over an image, so that thousands of residuals say little
        more than one does: those of a frame are left out together (the jackknife, in one step).
        Where fewer than three can be left out, their spread says nothing.
        """
        covariance, shared = np.zeros((GLOBALS, GLOBALS)), self.free[:GLOBALS]
        if not shared.any():
            return covariance
        whole, size = here.equations.information, len(self.free)
        frames: dict[int, NormalEquations] = {}
        for first, columns, own in here.by_pair():
            frame = frames.setdefault(
                first, NormalEquations(np.zeros((size, size)), np.zeros(size))
            )
            frame.information[np.ix_(columns, columns)] += own.information
            frame.gradient[columns] += own.gradient
        if len(frames) < _FEWEST_FRAMES:
            return np.diag(np.where(shared, np.inf, 0.0))
        without = []
        for frame in frames.values():
            left = whole - frame.information[np.ix_(self.free, self.free)]
            moved = np.linalg.pinv(left, rcond=1e-9, hermitian=True) @ frame.gradient[self.free]
            without.append(moved[: np.count_nonzero(shared)])
        off = np.array(without) - np.mean(without, axis=0)
        covariance[np.ix_(shared, shared)] = (1.0 - 1.0 / len(without)) * off.T @ off
        return covariance


class _Evaluation:
    """Residuals and equations of one state."""

    def __init__(self, problem: _Problem, state: RgbdState) -> None:
        self._problem, self._state = problem, state
        self._frames = FrameMatrices(state)
        corners, depths = problem.corners, problem.depths
        self._corner, self._corner_in_second, _ = corners.residuals(self._frames)
        self._depth, self._depth_in_second, self.distance_m = depths.residuals(self._frames)
        self.corner_size = np.linalg.norm(self._corner, axis=-1)
        self.depth_size = np.abs(self._depth[:, 0])
        by_corner, self._corner_weight = huber_cauchy(self.corner_size, _HUBER, 2 * _OUTLIER)
        by_depth, self._depth_weight = huber_cauchy(self.depth_size, _HUBER, _OUTLIER)
        self._prior = self._prior_residuals()
        self.cost = float(by_corner.sum() + by_depth.sum() + 0.5 * np.sum(self._prior**2))

    def _prior_residuals(self) -> FloatArray:
        prior, state = self._problem.prior, self._state
        off = np.zeros(GLOBALS)
        off[0] = np.log(state.colour.fx / prior.colour.fx)
        off[1] = np.log(state.depth.camera.fx / prior.depth.camera.fx)
        off[2:] = prior.depth.colour_T_depth.local(state.depth.colour_T_depth)
        used = prior.sigma > 0.0
        return np.where(used, off, 0.0) / np.where(used, prior.sigma, 1.0)

    @cached_property
    def equations(self) -> NormalEquations:
        size = len(self._problem.free)
        information, gradient = np.zeros((size, size)), np.zeros(size)
        for _, columns, own in self.by_pair():
            information[np.ix_(columns, columns)] += own.information
            gradient[columns] += own.gradient
        sigma = self._problem.prior.sigma
        for index in np.flatnonzero(sigma > 0.0):
            information[index, index] += sigma[index] ** -2
            gradient[index] += self._prior[index] / sigma[index]
        free = self._problem.free
        return NormalEquations(information[np.ix_(free, free)], gradient[free])

    def by_pair(self) -> Iterator[tuple[int, IntArray, NormalEquations]]:
        """The first frame of each pair, the unknowns that its residuals speak of, and what of."""
        corners, depths = self._problem.corners.pairs, self._problem.depths.pairs
        shared = self._by_globals()
        for pairs, residual, link, weight, by_globals in (
            (corners, self._corner, self._corner_in_second, self._corner_weight, shared[0]),
            (depths, self._depth, self._depth_in_second, self._depth_weight, shared[1]),
        ):
            for rows, first, second in pairs:
                jacobian = np.concatenate(
                    [by_globals[rows], link.by_first[rows], link.by_second[rows]], axis=-1
                ).reshape(-1, GLOBALS + 12)
                columns = np.concatenate(
                    [
                        np.arange(GLOBALS),
                        GLOBALS + 6 * first + np.arange(6),
                        GLOBALS + 6 * second + np.arange(6),
                    ]
                )
                weights = np.repeat(weight[rows], residual.shape[1])
                yield first, columns, NormalEquations.of(jacobian, residual[rows].ravel(), weights)

    def _by_globals(self) -> tuple[FloatArray, FloatArray]:
        """Derivatives by the globals, by differences: they are few, and the planes stay."""
        corner = np.zeros((*self._corner.shape, GLOBALS))
        depth = np.zeros((*self._depth.shape, GLOBALS))
        for index in np.flatnonzero(self._problem.free[:GLOBALS]):
            step = np.zeros(GLOBALS + 6 * len(self._state.world_T_colour))
            step[index] = _STEP
            frames = FrameMatrices(self._state.moved(step))
            there, _, _ = self._problem.corners.residuals(frames)
            corner[..., index] = (there - self._corner) / _STEP
            there, _, _ = self._problem.depths.residuals(frames)
            depth[..., index] = (there - self._depth) / _STEP
        return np.nan_to_num(corner), np.nan_to_num(depth)


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
        every = np.union1d(snapshot.time_ns[own], between).astype(np.int64).tolist()
        images = {stamp: depth_at(stamp) for stamp in track(every, "reading depth", len(every))}
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
