"""Where `method="auto"` starts: a path's longest smooth chain, its stamps, jumps and axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.prediction import EQUAL, standard_errors
from motorcade.fusion.smoothing.batch.columns import (
    FINEST,
    LEAST,
    NO_JUMPS,
    ColumnSegment,
    memories_beside,
    turning_model,
)
from motorcade.fusion.smoothing.batch.inliers import (
    Sizes,
    bridged_poses,
    first_sizes,
    inlier_poses,
    with_rigid,
)
from motorcade.fusion.smoothing.batch.jumps import returned_levels, squares_left, with_jumps
from motorcade.fusion.smoothing.batch.mirrored import mirrored_back, mirrored_run
from motorcade.fusion.smoothing.batch.per_axis import (
    HEAVY_TAILS,
    LAST_STEPS,
    AxisModels,
    Measured,
    PerAxisPath,
    chosen_models,
    settled,
    smoothed_per_axis,
)
from motorcade.fusion.smoothing.batch.predicted import (
    beside_jumps,
    judged_runs,
    worse_than_measured,
)
from motorcade.fusion.smoothing.representations import (
    REPRESENTATIONS,
    Representation,
    restored,
)
from motorcade.fusion.smoothing.window import gaussian
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

FIRST_STEPS = 3
_BODY = "motor"
_MISSES = "what lies next to a pose predicts it better than any spline"
# Columns that one twist has in these.
_STIFF = {_BODY: 6, "rotor": 3}
# Of fewer numbers that say as much, so many standard errors of prediction are borne: one in twenty.
_SURELY = 2.0
# Axes apart neglect that errors turn along with a body. So far it turns, in rad, while its usual
# axis is averaged over, where that may count.
_TURNS = 1.0
# Where an axis does not tell its noise, so far from one pose to the next: over a gap it turns half
# around, and the short way from pose to pose is wrong.
_FAR = 0.5
# A changing acceleration tells stamps and axes from each other as well as any order that is chosen.
_FIRST_ORDER = (2,)
# By how much the logarithm of poses must be likelier with even stamps, or with a marker's mirror
# for a jump, for these to be taken.
_LIKELIER = 10.0
# Runs of a flat marker's other candidate are read with a loss so wide.
_WIDTH = 3.5
# Deviation of the window that a first path is averaged by, in usual intervals.
_FIRST_WINDOW = 2.0
# How often poses beside jumps may be corrected before a first path is what it is.
_CORRECTIONS = 5
# Stamps that are off even ones by no more than this share of the interval are taken as they are.
_STEADY = 0.02
# The interval may be off the median one by this share, and is told from so many stamps at first.
_DETUNED, _COUNTED_FIRST = 0.1, 500
# So many intervals a stamp these may span: over longer gaps stamps that tremble by a tenth of the
# interval do not tell how many of it passed, and the lines to be looked at grow with the gap.
_LONGEST_SPAN = 16.0


@dataclass(frozen=True, eq=False)
class PathStart:
    """A path's longest smooth chain.

    Fields:
        trajectory: with runs of a marker's other candidate mirrored back, and such as are wrong
            together moved back.
        weights: 1 where a pose belongs to the chain, or the chain does not tell where it should be
            (see `predicted`), else 0.
        mirrored: which poses were, either way.
        as_measured: the trajectory before that.
        jumps: rows before which the level jumps, as the chain tells.
    """

    trajectory: Trajectory
    weights: FloatArray
    mirrored: NDArray[np.bool_]
    as_measured: Trajectory
    jumps: IntArray = field(default_factory=lambda: NO_JUMPS)

    @classmethod
    def of(cls, trajectory: Trajectory) -> list[PathStart]:
        """Of a trajectory of 16 poses or more with every run mirrored back that a marker explains;
        then without those that a marker explains in part, so that the path leaps to the rest.
        """
        time_s, poses = trajectory.time_s, trajectory.poses
        kept = inlier_poses(time_s, poses.rigid, *first_sizes(trajectory))
        start = cls(trajectory, kept.astype(np.float64), np.zeros_like(kept), trajectory)
        if np.all(kept):
            return [start]
        sizes, starts = start._sizes(), list[PathStart]()
        kept = inlier_poses(time_s, poses.rigid, *sizes[:2])
        plain = judged_runs(time_s, poses.rigid, kept)
        back, mirrored = mirrored_back(time_s, poses.rigid, kept, sizes, _WIDTH)
        while True:
            rigid = Motor(np.where(mirrored[:, None], back.coefficients, poses.rigid.coefficients))
            chain = inlier_poses(time_s, rigid, *sizes[:2]) if np.any(mirrored) else kept
            judged = judged_runs(time_s, rigid, chain)
            read = replace(trajectory, poses=with_rigid(poses, rigid))
            weights = judged.motion.astype(np.float64)
            starts.append(cls(read, weights, mirrored, trajectory, judged.jumps))
            torn = mirrored & beside_jumps(kept, np.setdiff1d(judged.jumps, plain.jumps))
            if not np.any(torn):
                return starts
            mirrored = mirrored & ~torn

    def _sizes(self) -> tuple[Sizes, Sizes, Sizes]:
        """Noise and white acceleration of rotation, translation and scale, the likeliest."""
        measured, path = self.written(REPRESENTATIONS["rotor"])
        columns = chosen_models(measured, path, self.weights, (1,), float("inf")).columns
        sizes = [
            Sizes(
                max(_root_mean_square([one.noise for one in part]), 1e-8),
                max(_root_mean_square([one.density for one in part]), 1e-8),
            )
            for part in (columns[:3], columns[3:6], columns[6:])
        ]
        return sizes[0], sizes[1], sizes[2]

    def corrected(self, measured: Measured, path: FloatArray, models: AxisModels) -> PathStart:
        """Another start where poses beside the jumps turn out to be wrong, else the same."""
        if not len(measured.jumps):
            return self
        other = self._with_runs_mirrored(measured, path, models)
        # No rigid offset is one of Euler angles, which leap and leap back where no pose does.
        returning = other is self and measured.representation.coupled
        return self._with_levels_returned(measured, path, models) if returning else other

    def _with_runs_mirrored(
        self, measured: Measured, path: FloatArray, models: AxisModels
    ) -> PathStart:
        """The same with runs up to a jump, or between two, mirrored back where a marker's five
        numbers explain the poses clearly better than the jumps' do; of less than half the poses.
        """
        start, count = replace(self, jumps=measured.jumps), len(self.weights)
        sizes, most = start._sizes(), squares_left(measured, path, self.weights, models)
        while True:
            runs = [slice(*ends) for ends in pairwise([0, *start.jumps.tolist(), count])]
            # Either side of a leap may be mirrored for the path to go on: that is wrong which
            # leaves the fewest jumps, of equals the shortest.
            tried = list[tuple[int, int, float, PathStart]]()
            for other in (start._mirrored(run, sizes) for run in runs):
                wrong = int(np.count_nonzero(other.mirrored))
                if other is not start and 2 * wrong < count:
                    own, near = other.written(measured.representation)
                    own = replace(own, time_s=measured.time_s)
                    left = squares_left(own, near, self.weights, models)
                    if left < most - 2.0 * _LIKELIER:
                        tried.append((len(other.jumps), wrong, left, other))
            if not tried:
                return self if start.mirrored is self.mirrored else start
            *_, most, start = min(tried, key=itemgetter(0, 1))

    def _mirrored(self, run: slice, sizes: tuple[Sizes, Sizes, Sizes]) -> PathStart:
        """The same with a run mirrored back, where a marker explains all of it; poses that were
        mirrored already are then as measured.
        """
        like, poses, kept = self.trajectory, self.trajectory.poses, self.weights > 0.0
        kept[run] = False
        read = mirrored_run(like.time_s, poses.rigid, kept, run, sizes, _WIDTH)
        if read is None:
            return self
        rigid = np.array(poses.rigid.coefficients)
        weights, mirrored = np.array(self.weights), np.array(self.mirrored)
        rows = run.start + np.flatnonzero(read[1])
        rigid[rows], twice = read[0][read[1]].coefficients, rows[mirrored[rows]]
        rigid[twice] = self.as_measured.poses.rigid[twice].coefficients
        weights[rows], mirrored[rows] = 1.0, ~mirrored[rows]
        trajectory = replace(like, poses=with_rigid(poses, Motor(rigid)))
        jumps = np.setdiff1d(self.jumps, [rows[0], rows[-1] + 1])
        return PathStart(trajectory, weights, mirrored, self.as_measured, jumps)

    def _with_levels_returned(
        self, measured: Measured, path: FloatArray, models: AxisModels
    ) -> PathStart:
        """The same with runs moved back to the level that the path leaves and returns to, each
        pose once: where a jump is left then, no level returned.
        """
        returned = [
            run
            for run in returned_levels(measured, path, self.weights, models)
            if not np.any(self.mirrored[run.first : run.last])
        ]
        if not returned:
            return self
        representation, like = measured.representation, self.trajectory
        coordinates, moved = np.array(measured.coordinates), np.array(self.mirrored)
        for first, last, coordinates[first:last] in returned:
            moved[first:last] = True
        other = restored(representation, coordinates, like).poses
        poses = np.where(moved[:, None], other.coefficients, like.poses.coefficients)
        trajectory = replace(like, poses=type(like.poses)(poses))
        jumps = np.setdiff1d(measured.jumps, [row for run in returned for row in run[:2]])
        return PathStart(trajectory, self.weights, moved, self.as_measured, jumps)

    def written(self, representation: Representation) -> tuple[Measured, FloatArray]:
        """The measured poses, and the chain's with what lies between them, as coordinates."""
        time_s = self.trajectory.time_s
        between = bridged_poses(time_s, self.trajectory.poses, self.weights > 0.0)
        if representation.coupled:
            # Summed up along a path with noise, steps would wander.
            usual_s = float(np.median(np.diff(time_s)))
            steady = Trajectory(self.trajectory.time_ns, between)
            between = gaussian(steady, representation, sigma_s=_FIRST_WINDOW * usual_s).poses
        path = representation.coordinates(between)
        return self.measured(representation, path), path

    def measured(self, representation: Representation, path: FloatArray) -> Measured:
        """The measured poses as coordinates on the branches of a path ``(N, D)``."""
        own = representation.coordinates(self.trajectory.poses)
        time_s = self.trajectory.time_s
        return Measured(
            representation,
            time_s - time_s[0],
            np.array(representation.continued(own, path)),
            self.jumps,
            self.weights > 0.0,
        )


def first_path(
    starts: Sequence[PathStart],
    representation: Representation,
    known: AxisModels | None = None,
    even: bool | None = None,
) -> tuple[PathStart, bool, Measured, PerAxisPath]:
    """A first path with its jumps, and whether stamps are taken for even for it.

    Of starts it is that which leaves the fewest jumps, of equals the fewest poses out; and another
    one where poses between jumps turn out to be wrong. Models and whether stamps are even may be
    known.
    """
    tried = []
    for start in starts:
        tried.append(_first_path(start, representation, known, even))
        if not len(tried[-1][2].jumps):
            break
    start, even, measured, path, models = min(
        tried, key=lambda path: (len(path[2].jumps), np.count_nonzero(path[0].weights == 0.0))
    )
    smoothed = smoothed_per_axis(measured, path, start.weights, models, HEAVY_TAILS, FIRST_STEPS)
    return start, even, measured, smoothed


def _first_path(
    start: PathStart, representation: Representation, known: AxisModels | None, even: bool | None
) -> tuple[PathStart, bool, Measured, FloatArray, AxisModels]:
    """The same of one start, still to be smoothed by models."""
    for corrections_left in range(_CORRECTIONS, -1, -1):
        measured, path = start.written(representation)
        models = known or chosen_models(measured, path, start.weights, _FIRST_ORDER)
        even_s = even_stamps(measured.time_s) if even is None or even else None
        if even_s is not None:
            in_step = replace(measured, time_s=even_s)
            others = known or chosen_models(in_step, path, start.weights, _FIRST_ORDER)
            even = even or others.score - _LIKELIER > models.score
            measured, models = (in_step, others) if even else (measured, models)
        measured, jumping = with_jumps(measured, path, start.weights, models)
        models = known or jumping
        other = start.corrected(measured, path, models) if corrections_left else start
        if other is start:
            break
        start = other
    return start, bool(even), measured, path, models


def in_better_axes(
    start: PathStart, measured: Measured, smoothed: PerAxisPath
) -> tuple[Measured, PerAxisPath]:
    """The same in axes of the body, where these predict better."""
    turned, path = in_axes_of_body(start, measured, smoothed)
    world = chosen_models(measured, smoothed.coordinates, smoothed.weights, _FIRST_ORDER)
    if chosen_models(turned, path, smoothed.weights, _FIRST_ORDER).score <= world.score:
        return measured, smoothed
    return turned, replace(smoothed, coordinates=path)


def in_axes_of_body(
    start: PathStart, measured: Measured, smoothed: PerAxisPath
) -> tuple[Measured, FloatArray]:
    """Measured poses and the path in axes of the body."""
    body, like = REPRESENTATIONS[_BODY], start.trajectory
    path = body.coordinates(restored(measured.representation, smoothed.coordinates, like).poses)
    turned = replace(start.measured(body, path), time_s=measured.time_s, jumps=measured.jumps)
    return turned, path


def of_one_twist(
    start: PathStart,
    measured: Measured,
    smoothed: PerAxisPath,
    models: AxisModels,
    tails: float,
    any_axes: bool,
) -> tuple[Measured, PerAxisPath, AxisModels]:
    """The same by a constant twist of motors, or of rotors, where no other motion is left and it
    predicts poses as well; by one of motors if any axes may be taken for those that were.
    """
    tried = [(measured, smoothed.coordinates)]
    if any_axes and measured.representation.name != _BODY:
        tried.insert(0, in_axes_of_body(start, measured, smoothed))
    for each, path in tried:
        # Where nothing else is left no level jumped; and poses that were read by some path tell a
        # twist, which needs few, what that path was.
        poses = replace(each, jumps=NO_JUMPS, motion=each.motion & ~start.mirrored)
        columns = _STIFF.get(poses.representation.name, 0)
        own = models.columns[:columns]
        if not own:
            continue
        by_twist = _stiff(models, np.zeros(columns))
        weights = smoothed.weights * poses.motion
        twisted = smoothed_per_axis(poses, path, weights, by_twist, tails, LAST_STEPS)
        beyond = poses.representation.local(poses.coordinates, twisted.coordinates)
        lasting = memories_beside(ColumnSegment(poses.time_s, beyond, twisted.weights), columns)
        if lasting is not None:
            by_twist = _stiff(models, lasting)
            if np.any(lasting):
                path, weights = twisted.coordinates, twisted.weights
                twisted = smoothed_per_axis(poses, path, weights, by_twist, tails, 1)
            if _gain(smoothed, twisted) >= -_SURELY:
                return poses, twisted, by_twist
    return measured, smoothed, models


def _stiff(models: AxisModels, lasting: FloatArray) -> AxisModels:
    """The same with columns of one twist, whose errors last so long."""
    columns = [
        replace(model, stiff=True, memory_s=float(memory_s), unobservable="")
        for model, memory_s in zip(models.columns, lasting, strict=False)
    ]
    return replace(models, columns=(*columns, *models.columns[len(columns) :]))


def of_one_turn(
    start: PathStart, measured: Measured, smoothed: PerAxisPath, models: AxisModels, tails: float
) -> tuple[Measured, PerAxisPath, AxisModels]:
    """The same with rotations smoothed together, where a body turns so fast that axes apart neglect
    what counts, and unless they predict held-out poses better all the same.

    What axes apart took for jumps of the level is none then, or they do.
    """
    usual_s, own = float(np.median(np.diff(measured.time_s))), models.columns[:3]
    if measured.representation.name not in _STIFF or own[0].stiff:
        return measured, smoothed, models
    path = restored(measured.representation, smoothed.coordinates, start.trajectory).poses.rigid
    turn = float(np.median((path[:-1].rotor.inverse() @ path[1:].rotor).angle())) / usual_s
    rates = [column.rate(usual_s) for column in own if not column.unobservable]
    if turn < np.median([*(_TURNS * rate for rate in rates), *[_FAR / usual_s] * (3 - len(rates))]):
        return measured, smoothed, models
    noise = max(_root_mean_square([one.noise for one in own]), 1e-9)
    poses = start.trajectory.poses.rigid
    least = EQUAL if len(measured.jumps) or not rates else -EQUAL
    # Poses that were read by axes apart may be where these went, not where the body did.
    for among in (measured.motion, measured.motion & ~start.mirrored):
        steady, weights = replace(measured, jumps=NO_JUMPS, motion=among), smoothed.weights * among
        model = turning_model(measured.time_s, poses, weights, noise).told(usual_s)
        if model.unobservable:
            continue
        joint = replace(models, columns=(*[model] * 3, *models.columns[3:]))
        turned = smoothed_per_axis(steady, smoothed.coordinates, weights, joint, tails, LAST_STEPS)
        if _gain(smoothed, turned) > least:
            measured, smoothed, models, least = steady, turned, joint, EQUAL
        if not np.any(start.mirrored):
            break
    return measured, smoothed, models


def _gain(before: PerAxisPath, after: PerAxisPath) -> float:
    """By how many standard errors one path predicts poses held out better than another did.

    Axes count by their noise; such as have hardly any beside the others would drown these.
    """
    kept = (before.weights > 0.0) & (after.weights > 0.0)
    parts = np.maximum(before.noise, after.noise)[:6].reshape(-1, 3)
    usual = np.sqrt(np.mean(parts**2, axis=1, keepdims=True))
    noise = np.maximum(parts, FINEST * usual).ravel() + LEAST
    lost = _held_out(before, kept) - _held_out(after, kept)
    return float(standard_errors(lost[:, :6] @ noise**-2))


def _held_out(smoothed: PerAxisPath, kept: NDArray[np.bool_]) -> FloatArray:
    """Squares ``(M, d)`` by which axes are missed, as generalised cross-validation has them."""
    shares = 1.0 - smoothed.weights[kept, None] * smoothed.spread[kept]
    return np.asarray((smoothed.left_out[kept] * shares / np.mean(shares, axis=0)) ** 2)


def no_worse(
    start: PathStart,
    measured: Measured,
    smoothed: PerAxisPath,
    models: AxisModels,
    tails: float,
    known: FloatArray,
) -> tuple[PerAxisPath, AxisModels]:
    """The same through every rotation, or position, that it predicts worse than neighbours do.

    Where noise is known ``(d,)``, not NaN, it is smoothed by that.
    """
    worse = worse_than_measured(start.trajectory, measured, smoothed)
    if not np.any(worse):
        return smoothed, models
    parts = np.searchsorted(measured.representation.ends, np.arange(len(known)), "right")
    through = np.append(worse, False)[parts] & np.isnan(known)
    usual_s = float(np.median(np.diff(measured.time_s)))
    columns = [
        model.through_all(usual_s, _MISSES) if every else model
        for model, every in zip(models.columns, through, strict=True)
    ]
    models = replace(models, columns=tuple(columns))
    return settled(measured, smoothed, models, tails), models


def even_stamps(time_s: FloatArray) -> FloatArray | None:
    """Even stamps that these may tremble about, from 0 on; None where they need or may not.

    The interval is that of the strongest line of the stamps' spectrum, near their median one; it is
    refined as more and more of them are counted off by it.
    """
    passed_s = time_s - time_s[0]
    usual_s = float(np.median(np.diff(time_s)))
    count = min(len(time_s), _COUNTED_FIRST)
    span = float(passed_s[count - 1]) / usual_s
    if span > _LONGEST_SPAN * count:
        return None
    finest = 0.25 / span
    rates = (1.0 + np.arange(-_DETUNED, _DETUNED, finest)) / usual_s
    each_s, first_s = 1.0 / rates[int(np.argmax(_lines(rates, passed_s[:count])))], 0.0
    turn = np.mean(np.exp(2j * np.pi / each_s * passed_s[:count]))
    first_s = float(np.angle(turn)) / (2.0 * np.pi) * each_s
    while True:
        places = np.round((passed_s[:count] - first_s) / each_s)
        if np.any(np.diff(places) < 1.0):
            return None
        each_s, first_s = np.polyfit(places, passed_s[:count], 1)
        if count == len(time_s):
            break
        count = min(len(time_s), 2 * count)
    even_s = first_s + each_s * places
    if np.max(np.abs(even_s - passed_s)) <= _STEADY * each_s:
        return None
    return np.asarray(even_s - even_s[0], dtype=np.float64)


def _lines(rates: FloatArray, time_s: FloatArray) -> FloatArray:
    """Strength of a spectrum at evenly spaced rates: a phase is that of every so many-th rate,
    turned by what the rates between differ by.
    """
    each = int(np.ceil(np.sqrt(len(rates))))
    some = np.exp(2j * np.pi * rates[::each, None] * time_s)
    between = np.exp(2j * np.pi * (rates[:each, None] - rates[0]) * time_s)
    return np.asarray(np.abs(some @ between.T).ravel()[: len(rates)], dtype=np.float64)


def _root_mean_square(sizes: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(sizes)))) if sizes else 0.0
