"""Least squares over a camera, where it stood, and rigid bodies that it saw, fitted round by round.

A board is one body; markers of unknown layout are one body each. All views are fitted at once; a
rolling shutter bends each view by its own velocity, which follows from the views beside it. Views
are eliminated (`BlockEquations`), so a step costs time in proportion to the corners.

Sources: Triggs et al. 2000 (bundle adjustment); Zhang 2000 (a camera from planes); Hedborg et al.
2012 (rolling shutter: a velocity a view, first order in the line's time).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera, by_twist
from motorcade.tracking.optimise import BlockEquations, PairIndex, Stop, huber, minimise, sum_by
from motorcade.tracking.pose import SIGMA_FLOOR_PX
from motorcade.tracking.self_calibration.lens import LensKind
from motorcade.tracking.self_calibration.result import SelfCalibrationError

READOUT_SIGMA_S = 0.03
"""No sensor reads an image for longer than its frame at 30 Hz lasts."""
_SAG = 0.01
"""Standard deviation of how far a print's rim lies off its middle's plane, over its half width."""
_NEIGHBOUR_S = 0.11
_WIDTH = 6
LEAST_VIEWS = 5
"""Fewer frames leave no halves to hold against each other."""


@dataclass(frozen=True, eq=False)
class BodyObservations:
    """Corners of bodies in views, sorted by view, then body.

    Fields:
        size: width and height of the images.
        time_s: ``(V,)`` rising.
        view, body: ``(N,)`` of each corner; every view and every body has some.
        points: ``(N, 3)`` in the body's frame, in any unit of length.
        px: ``(N, 2)``.
        shown_px: ``(N, 2)`` where the shutter's lines saw them, if that is elsewhere.
    """

    size: tuple[int, int]
    time_s: FloatArray
    view: IntArray
    body: IntArray
    points: FloatArray
    px: FloatArray
    shown_px: FloatArray | None = None

    def only(self, views: IntArray) -> BodyObservations:
        """Some views ``(v,)``, rising; bodies keep their numbers."""
        rows = np.isin(self.view, views)
        return BodyObservations(
            self.size,
            self.time_s[views],
            np.searchsorted(views, self.view[rows]),
            self.body[rows],
            self.points[rows],
            self.px[rows],
            None if self.shown_px is None else self.shown_px[rows],
        )

    @cached_property
    def starts(self) -> IntArray:
        """The first corner of each view."""
        return np.searchsorted(self.view, np.arange(len(self.time_s)))

    @cached_property
    def sag(self) -> FloatArray:
        """``(N, 3)`` heights of three ways to bend a print whose rim is one half width off."""
        low, high = self.points[:, :2].min(axis=0), self.points[:, :2].max(axis=0)
        half = 0.5 * float((high - low).max())
        x, y = ((self.points[:, :2] - 0.5 * (low + high)) / half).T
        return half * np.stack([x * x, x * y, y * y], axis=-1)

    @cached_property
    def line(self) -> FloatArray:
        """``(N, 2)`` where in the image a corner lies, across and down: -1/2 to 1/2."""
        px = self.px if self.shown_px is None else self.shown_px
        return (px + 0.5) / self.size - 0.5


@dataclass(frozen=True, eq=False)
class BodyState:
    """What is estimated.

    Fields:
        kind: the lens model.
        numbers: ``(3 + terms,)`` of the lens.
        readout_s: ``(2,)`` seconds from left edge to right, and from upper to lower.
        world_T_camera: Motor ``(V,)``.
        world_T_body: Motor ``(B,)``; the first is the world.
        bent: ``(3,)`` how a lone body is bent, see `BodyObservations.sag`: no print lies quite
            flat, and one that is taken to tells a wrong focal length.
    """

    kind: LensKind
    numbers: FloatArray
    readout_s: FloatArray
    world_T_camera: Motor
    world_T_body: Motor
    bent: FloatArray = field(default_factory=lambda: np.zeros(3))

    @property
    def shared(self) -> FloatArray:
        """All numbers: of the lens, the read-out's two, and how a body is bent."""
        return np.concatenate([self.numbers, self.readout_s, self.bent])


def velocities(time_s: FloatArray, world_T_camera: Motor) -> FloatArray:
    """Twist ``(V, 6)`` per second of each view, in its own frame; 0 without near neighbours."""
    twists = np.zeros((len(time_s), 6))
    if len(time_s) < 2:
        return twists
    every = np.arange(len(time_s))
    before, after = np.maximum(every - 1, 0), np.minimum(every + 1, len(time_s) - 1)
    far = _NEIGHBOUR_S
    before = np.where(time_s - time_s[before] > far, every, before)
    after = np.where(time_s[after] - time_s > far, every, after)
    moving = np.flatnonzero(after > before)
    if len(moving):
        earlier, other = world_T_camera[before[moving]], world_T_camera[after[moving]]
        gap_s = (time_s[after] - time_s[before])[moving]
        twists[moving] = earlier.local(other) / gap_s[:, None]
    return twists


@dataclass(frozen=True)
class Freedom:
    """What may move beside the views, and how far corners count in full.

    Fields:
        lens: its numbers; readout: of the shutter; bodies: all but the first, or how a lone one
            is bent.
        limit_px: beyond it a corner counts less (Huber).
        noise_px: of a corner, against which what is expected of the lens is weighed.
    """

    lens: bool
    readout: bool
    bodies: bool
    limit_px: float
    noise_px: float

    def of(self, state: BodyState) -> IntArray:
        """Which of a state's shared numbers move."""
        bent = self.bodies and state.world_T_body.shape[0] == 1
        groups = [self.lens] * len(state.numbers) + [self.readout] * 2 + [bent] * len(state.bent)
        return np.flatnonzero(groups)


class BodyReprojection:
    """All corners against their reprojection; infinite cost where no camera is like that."""

    def __init__(
        self, seen: BodyObservations, velocity: FloatArray, free: Freedom, state: BodyState
    ) -> None:
        self._seen, self._state, self._free = seen, state, free
        self.cost = np.inf
        if not (np.isfinite(state.numbers).all() and state.numbers[0] > 0.0):
            return
        self._camera = state.kind.camera(state.numbers, seen.size)
        camera_T_body = state.world_T_camera.inverse()[seen.view] @ state.world_T_body[seen.body]
        self._camera_R_body = camera_T_body.rotor.as_matrix()
        still = camera_T_body.apply(seen.points)
        still = still + self._camera_R_body[:, :, 2] * (seen.sag @ state.bent)[:, None]
        turn, shift = velocity[seen.view, :3], velocity[seen.view, 3:]
        late_s = (seen.line @ state.readout_s)[:, None]
        moves = np.cross(still, turn) - shift
        self._by_time = moves + late_s * np.cross(moves, turn)
        self._in_camera = still + late_s * (moves + 0.5 * late_s * np.cross(moves, turn))
        self._pixels, self._by_point = self._camera.project_jacobian(self._in_camera)
        self.residuals_px: FloatArray = self._pixels - seen.px
        loss, self.weight = huber(np.linalg.norm(self.residuals_px, axis=-1), free.limit_px)
        self._away, self._expected = self._prior()
        cost = float(loss.sum() + 0.5 * (self._expected * self._away**2).sum())
        self.cost = cost if np.isfinite(cost) else np.inf

    @property
    def starts(self) -> IntArray:
        """The first corner of each view."""
        return self._seen.starts

    def _prior(self) -> tuple[FloatArray, FloatArray]:
        """How far the numbers are from what is expected, and the weight of that."""
        away, information = self._state.kind.prior(self._state.numbers, self._seen.size)
        away = np.concatenate([away, self._state.readout_s, self._state.bent])
        others = np.full(2, READOUT_SIGMA_S**-2.0), np.full(3, _SAG**-2.0)
        both = np.concatenate([information, *others])
        return away, both * self._free.noise_px**2

    @cached_property
    def free_numbers(self) -> IntArray:
        """Which of the shared numbers move."""
        return self._free.of(self._state)

    @cached_property
    def by_shared(self) -> FloatArray:
        """Derivative ``(N, 2, 6 g)`` by the free numbers, filled up with zeros to groups of six."""
        seen, free = self._seen, self.free_numbers
        by_lens = self._state.kind.by_numbers(self._camera, self._in_camera, self._pixels)
        by_time = np.einsum("nij,nj->ni", self._by_point, self._by_time)
        by_readout = by_time[:, :, None] * seen.line[:, None, :]
        by_height = np.einsum("nij,nj->ni", self._by_point, self._camera_R_body[:, :, 2])
        by_bend = by_height[:, :, None] * seen.sag[:, None, :]
        every = np.concatenate([by_lens, by_readout, by_bend], axis=-1)[..., free]
        filled = np.zeros((len(seen.px), 2, -(-len(free) // _WIDTH) * _WIDTH))
        filled[..., : len(free)] = every
        return filled

    @property
    def by_all_shared(self) -> FloatArray:
        """Derivative ``(N, 2, p)`` by the free numbers, and by the bodies but the first if free."""
        by_free = self.by_shared[..., : len(self.free_numbers)]
        if not self._free.bodies:
            return by_free
        seen, (_, by_body) = self._seen, self._body_pairs()
        others = np.zeros((len(by_body), 2, self._body_width + _WIDTH))
        columns = _WIDTH * seen.body[:, None] + np.arange(_WIDTH)
        others[np.arange(len(by_body))[:, None], :, columns] = by_body.swapaxes(-1, -2)
        return np.concatenate([by_free, others[..., _WIDTH:]], axis=-1)

    def expected_of(self, count: int) -> FloatArray:
        """Information of what is expected of the first of `count` parameters that views share."""
        expected = self._expected[self.free_numbers]
        return np.append(expected, np.zeros(count - len(expected)))

    @cached_property
    def by_view(self) -> FloatArray:
        """Derivative ``(N, 2, 6)`` by the twist of each corner's view."""
        return by_twist(self._in_camera, self._by_point)

    @cached_property
    def equations(self) -> BlockEquations:
        """Groups: the free numbers in sixes, then every body but the first; blocks: the views."""
        seen = self._seen
        by_view = self.by_view
        pull = (by_view * self.weight[:, None, None]).swapaxes(-1, -2)
        information, gradient = self._shared()
        wide = len(gradient)
        groups, views = wide // _WIDTH, np.arange(len(seen.starts))
        met = np.add.reduceat(pull @ self.by_shared, seen.starts, axis=0)
        block_of, group_of = np.repeat(views, groups), np.tile(np.arange(groups), len(views))
        met = met.reshape(len(views), 6, groups, 6).swapaxes(1, 2)
        coupling = met.reshape(len(views) * groups, 6, 6)
        if self._free.bodies and self._state.world_T_body.shape[0] > 1:
            index, by_body = self._body_pairs()
            others = np.zeros((wide + self._body_width, wide + self._body_width))
            others[:wide, :wide] = information
            information, gradient = others, np.append(gradient, np.zeros(self._body_width))
            self._add_bodies(by_body, information, gradient, wide)
            rows = seen.body > 0
            block_of = np.concatenate([block_of, index.rows])
            group_of = np.concatenate([group_of, groups + index.columns])
            coupling = np.concatenate([coupling, index.sums(pull[rows] @ by_body[rows])])
        return BlockEquations(
            information,
            gradient,
            np.add.reduceat(pull @ by_view, seen.starts, axis=0),
            np.add.reduceat((pull @ self.residuals_px[..., None])[..., 0], seen.starts, axis=0),
            block_of,
            group_of,
            coupling,
        )

    def _shared(self) -> tuple[FloatArray, FloatArray]:
        """Information and gradient of the free numbers."""
        pull, free = self.by_shared * self.weight[:, None, None], self.free_numbers
        flat = pull.reshape(2 * len(pull), -1) if pull.size else np.zeros((2 * len(pull), 0))
        information = flat.T @ self.by_shared.reshape(flat.shape)
        gradient = flat.T @ self.residuals_px.ravel()
        own = np.arange(len(free))
        information[own, own] += self._expected[free]
        gradient[own] += self._expected[free] * self._away[free]
        return information, gradient

    @property
    def _body_width(self) -> int:
        return (int(self._state.world_T_body.shape[0]) - 1) * _WIDTH

    def _body_pairs(self) -> tuple[PairIndex, FloatArray]:
        """Which view sees which body (but the first), and the derivative by each corner's body."""
        seen = self._seen
        by_body = -by_twist(seen.points, self._by_point @ self._camera_R_body)
        rows = seen.body > 0
        return PairIndex(seen.view[rows], seen.body[rows] - 1), by_body

    def _add_bodies(
        self, by_body: FloatArray, information: FloatArray, gradient: FloatArray, wide: int
    ) -> None:
        """Put the bodies behind the `wide` free numbers."""
        seen = self._seen
        pull = (by_body * self.weight[:, None, None]).swapaxes(-1, -2)
        bodies = int(self._state.world_T_body.shape[0])
        own = sum_by(pull @ by_body, seen.body, bodies)[1:]
        across = sum_by(pull @ self.by_shared, seen.body, bodies)[1:]
        push = sum_by((pull @ self.residuals_px[..., None])[..., 0], seen.body, bodies)[1:]
        for body in range(bodies - 1):
            place = slice(wide + body * _WIDTH, wide + (body + 1) * _WIDTH)
            information[place, place] = own[body]
            information[place, :wide] = across[body]
            information[:wide, place] = across[body].T
            gradient[place] = push[body]


def spread_runs(count: int, most: int) -> IntArray:
    """At most `most` of `count` frames, in runs of three neighbours that are spread evenly.

    >>> from motorcade.tracking.self_calibration.bodies import spread_runs
    >>> spread_runs(12, 6)
    array([ 0,  1,  2,  9, 10, 11])
    """
    if count <= most:
        return np.arange(count)
    firsts = np.linspace(0, count - 3, max(most // 3, 1)).astype(np.int64)
    return np.unique(firsts[:, None] + np.arange(3))


_STOP = Stop(steps=40, gain=1e-6)
_ROUNDS = 3
_NO_IMAGE = (
    "views: expected corners that one camera explains, got some that it would not see: tags that "
    "moved, or too few frames to tell how they lie"
)
_LIMIT = 3.0  # of the noise of a coordinate
_MEDIAN_OF_TWO = float(np.sqrt(2.0 * np.log(2.0)))  # median length of two standard normal numbers


@dataclass(frozen=True, eq=False)
class BodyFit:
    """A state that is least squares.

    Fields:
        state: where it ended.
        residuals_px: ``(N, 2)`` reprojection minus corner.
        covariance: ``(p, p)`` of the free ones of the state's shared numbers, for independent
            corners.
        sigma_px: noise of a coordinate.
        evaluation: the problem there.
        focal_by_view: ``(V,)`` change of the focal length that each view alone asks for, and
        focal_sigma: ``(V,)`` its standard deviation, pixels.
    """

    state: BodyState
    residuals_px: FloatArray
    covariance: FloatArray
    sigma_px: float
    evaluation: BodyReprojection
    focal_by_view: FloatArray
    focal_sigma: FloatArray

    def camera(self, size: tuple[int, int]) -> Camera:
        """The camera that was found."""
        return self.state.kind.camera(self.state.numbers, size)

    @property
    def rms_px(self) -> float:
        """Root mean square distance of corners from their reprojection."""
        return float(np.sqrt((self.residuals_px**2).sum(axis=-1).mean()))


def fit(
    seen: BodyObservations,
    start: BodyState,
    *,
    lens: bool = True,
    readout: bool = False,
    bodies: bool = True,
    alike: float = 1.0,
) -> BodyFit:
    """Minimise the reprojection error over the views and what else is free.

    Args:
        seen: corners.
        start: a state that is near.
        lens: whether its numbers are free.
        readout: whether the shutter's is.
        bodies: whether all but the first are, or how a lone one is bent.
        alike: by how much corners that err alike make errors larger than their noise says: so much
            less they weigh against what is expected of the lens (`certainty.error_inflation`).

    Raises:
        SelfCalibrationError: a start from which some corner has no image.
    """
    state, noise_px = start, _noise_px(seen, start)
    for _ in range(_ROUNDS):
        free = Freedom(lens, readout, bodies, _LIMIT * noise_px, alike * noise_px)
        evaluate = partial(
            BodyReprojection, seen, velocities(seen.time_s, state.world_T_camera), free
        )
        if not np.isfinite(evaluate(state).cost):
            raise SelfCalibrationError(_NO_IMAGE)
        minimum = minimise(state, evaluate, partial(_retract, free), _STOP)
        before, state, at = noise_px, minimum.state, minimum.evaluation
        noise_px = median_noise_px(at.residuals_px)
        if not readout and abs(noise_px - before) < 0.05 * before:
            break
    return _fitted(state, at, noise_px)


def _retract(free: Freedom, state: BodyState, step: tuple[FloatArray, FloatArray]) -> BodyState:
    groups, views = step
    lens, moved = len(state.numbers), free.of(state)
    wide = -(-len(moved) // 6)
    shared = state.shared
    shared[moved] += groups[:wide].ravel()[: len(moved)]
    bodies = state.world_T_body
    if free.bodies and bodies.shape[0] > 1:
        bodies = bodies.retract(np.concatenate([np.zeros((1, 6)), groups[wide:]]))
    return replace(
        state,
        numbers=shared[:lens],
        readout_s=shared[lens : lens + 2],
        bent=shared[lens + 2 :],
        world_T_camera=state.world_T_camera.retract(views),
        world_T_body=bodies,
    )


def _noise_px(seen: BodyObservations, state: BodyState) -> float:
    velocity = velocities(seen.time_s, state.world_T_camera)
    at = BodyReprojection(seen, velocity, Freedom(False, False, False, 1.0, 1.0), state)
    if not np.isfinite(at.cost):
        raise SelfCalibrationError(_NO_IMAGE)
    return median_noise_px(at.residuals_px)


def median_noise_px(residuals_px: FloatArray, floor_px: float = SIGMA_FLOOR_PX) -> float:
    """Noise of a coordinate that outliers do not move."""
    median = float(np.median(np.linalg.norm(residuals_px, axis=-1)))
    return max(median / _MEDIAN_OF_TWO, floor_px)


def _fitted(state: BodyState, at: BodyReprojection, noise_px: float) -> BodyFit:
    equations, free = at.equations, at.free_numbers
    if not len(free):
        nothing = np.zeros(len(equations.blocks))
        return BodyFit(state, at.residuals_px, np.zeros((0, 0)), noise_px, at, nothing, nothing)
    inverse = np.linalg.inv(equations.reduced_information)
    covariance = np.asarray(noise_px**2 * inverse[: len(free), : len(free)], np.float64)
    by_view, information = _focal_alone(at, equations.blocks)
    sigma = np.asarray(noise_px / np.sqrt(information), np.float64)
    return BodyFit(state, at.residuals_px, covariance, noise_px, at, by_view, sigma)


def _focal_alone(at: BodyReprojection, blocks: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Change ``(V,)`` of the focal length that each view asks for, its pose free, all else held.

    Returns:
        the changes, and their information for corners of unit noise.
    """
    by_focal, starts = at.by_shared[..., 0], at.starts
    pulled = at.weight[:, None] * by_focal
    shared = np.add.reduceat(np.einsum("nij,ni->nj", at.by_view, pulled), starts, axis=0)
    weighed = at.weight[:, None] * at.residuals_px
    pull = np.add.reduceat(np.einsum("nij,ni->nj", at.by_view, weighed), starts, axis=0)
    own = np.add.reduceat((pulled * by_focal).sum(axis=-1), starts)
    gradient = np.add.reduceat((pulled * at.residuals_px).sum(axis=-1), starts)
    held = np.linalg.solve(blocks + 1e-9 * np.eye(6), np.stack([shared, pull], axis=-1))
    information = np.maximum(own - (shared * held[..., 0]).sum(axis=-1), 1e-12)
    change = -(gradient - (shared * held[..., 1]).sum(axis=-1)) / information
    return change, information
