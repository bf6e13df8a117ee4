"""Which poses the others predict well enough to call them wrong.

That a run of poses lies off the path that bridges it says nothing where such a bridge errs as much
over good poses: where motion is jerky, or the run is long. How much it errs is told by the path
itself: segments of good poses as long as the run, next to it, are left out and bridged likewise
(cross-validation that leaves out blocks: P. Burman, E. Chow, D. Nolan, A cross-validatory method
for dependent data, Biometrika 81, 1994).
"""

from __future__ import annotations

from itertools import pairwise, takewhile
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.batch.columns import NO_JUMPS
from motorcade.fusion.smoothing.batch.inliers import bridged, crossings, with_rigid
from motorcade.fusion.smoothing.batch.per_axis import (
    AxisModels,
    Measured,
    PerAxisPath,
    smoothed_per_axis,
)
from motorcade.fusion.smoothing.representations import restored
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# A run is wrong where it lies off by more than so many times what good poses do: three deviations.
_WRONG = 3.0
# Segments to both sides of a run that its prediction is judged by, and good poses between them,
# which tell the speed.
_BESIDE, _BETWEEN = 6, 4
_FEWEST = 2
# Steps to both sides that a leap is judged by.
_AROUND = 12
# Poses left out that lie no more than so many times as far off as good ones stay as measured.
_AS_GOOD = 2.0
# A pose held out misses by its own and its prediction's error: as large where by so many times one.
_AS_SURE = 2.0**0.5
# A path across poses left out is the smoothest there is: where it bends by so many times as much as
# it does anywhere it was not led there but astray.
_ASTRAY = 2.0
# Poses at an end that may not be a level of their own.
FEWEST_AT_LEVEL = 6
# All but so few steps of good poses bend less than a leap does.
_MOST = 0.99
# What the path misses behind a run that it returns from, of how far off this lies.
_RETURNED = 0.7
# By how much the leaps to a run and back may differ, in the bends of all but few steps.
_BACK = 2.0**0.5

Kept = NDArray[np.bool_]


class JudgedRuns(NamedTuple):
    """Poses ``(N,)`` that belong to the motion, and rows before which its level jumps."""

    motion: Kept
    jumps: IntArray


def judged_runs(time_s: FloatArray, poses: Motor, kept: Kept) -> JudgedRuns:
    """Which poses belong to the motion, and where its level jumps.

    Of a run of others, what the path leaps to and leaps back from is wrong, if it lies off where
    the kept poses predict it by more than they err over good poses. Where the path leaps on, or
    ends there, poses that agree with each other are a level of their own. All else is motion.

    Args:
        time_s: ``(N,)`` increasing.
        poses: as measured.
        kept: which belong to one smooth chain.
    """
    bent = _bends(time_s, poses)
    usual = ~_widened(~kept)
    most = np.quantile(bent[:-1][usual], _MOST, axis=0) if np.any(usual) else np.zeros(2)
    while True:
        motion, leaps = np.ones_like(kept), []
        for first, last in runs_of(~kept):
            edges = _leaps(bent, ~_widened(~kept), most, first, last)
            if len(edges) > 1:
                motion[edges[0] : edges[-1]] = False
                leaps.append(edges)
        if not leaps or not np.any(motion[1:] & motion[:-1]):
            return JudgedRuns(motion if not leaps else kept, NO_JUMPS)
        held_out = _HeldOut(time_s, poses, motion, most)
        right = [piece for edges in leaps for piece in held_out.right_among(edges)]
        if not right:
            break
        kept = motion.copy()
        for first, last in right:
            kept[first:last] = True
    jumps = list[int]()
    for edges in leaps:
        stays, before = held_out.judged(edges)
        for first, last in stays:
            motion[first:last] = True
        jumps += before
    return JudgedRuns(motion, np.array(jumps, dtype=np.int64))


def unpredicted(
    like: Trajectory, measured: Measured, smoothed: PerAxisPath, models: AxisModels, tails: float
) -> Kept:
    """Rotations and positions ``(N, 2)`` left out that are right, and better as measured.

    Good ones held out tell that: where a path predicts them as well as they are measured, it
    stands in for them. Measured are the poses that it is like, as coordinates.
    """
    poses, kept = like.poses.rigid, smoothed.weights > 0.0
    beside_jump = beside_jumps(kept, measured.jumps)
    stay = np.repeat(beside_jump[:, None], 2, axis=1)

    def rigid(path: PerAxisPath) -> Motor:
        return restored(measured.representation, path.coordinates, like).poses.rigid

    far, rows = _off(poses, rigid(smoothed)), np.flatnonzero(kept)
    runs = runs_of(~kept & measured.motion & ~beside_jump)
    lengths = np.array([_rounded_up(last - first) for first, last in runs])
    for length in np.unique(lengths):
        inside = rows[_blocks(len(rows), int(length))]
        weights = np.array(smoothed.weights)
        weights[inside] = 0.0
        without = smoothed_per_axis(measured, smoothed.coordinates, weights, models, tails, 1)
        errors = _size(_off(poses, rigid(without))[inside])
        for first, last in runs[lengths == length]:
            beside = _near(inside, first)
            near, usual = _size(errors[beside]), _size(_size(far[inside[beside]]))
            if len(errors[beside]) < _FEWEST:
                stay[first:last] = True
                continue
            right = np.all(far[first:last] <= _AS_GOOD * near, axis=1)
            stay[first:last] = right[:, None] & (near > _AS_SURE * usual)
    stay |= _astray(measured.time_s, rigid(smoothed), kept)[:, None]
    return stay | (~kept[:, None] & (far <= _AS_SURE * _unsure(measured, smoothed)))


def _unsure(measured: Measured, smoothed: PerAxisPath) -> FloatArray:
    """By how much rotations and positions of a path may be off ``(N, 2)``, in rad and m; 0 where
    that is less than a good pose's noise.

    What is measured no more than √2 times so far from there is expected to be no farther off.
    """
    ends, noise = (0, *measured.representation.ends), smoothed.noise**2
    sizes = np.zeros((len(smoothed.spread), 2))
    for part, axes in enumerate(slice(*pair) for pair in pairwise(ends)):
        variance, least = smoothed.spread[:, axes] @ noise[axes], np.sum(noise[axes])
        sizes[:, part] = np.sqrt(np.where(variance > least, variance, 0.0))
    return np.asarray(sizes / measured.representation.units, dtype=np.float64)


def _astray(time_s: FloatArray, path: Motor, kept: Kept) -> Kept:
    """Poses left out between others that a path bends more for than a smooth one would."""
    astray, bent, near = np.zeros_like(kept), _bent(time_s, path), _widened(~kept)
    if np.all(near):
        return astray
    most = _ASTRAY * np.max(bent[~near], axis=0)
    for first, last in runs_of(~kept):
        if first > 0 and last < len(kept):  # beyond the ends it is not led anywhere
            astray[first:last] = np.any(bent[first - 1 : last + 1] > most)
    return astray


def _bent(time_s: FloatArray, path: Motor) -> FloatArray:
    """By how much the rates of a path change at each pose, a second ``(N, 2)``."""
    rates = (path[:-1].inverse() @ path[1:]).as_twist() / np.diff(time_s)[:, None]
    return _parts(np.pad(np.diff(rates, axis=0), ((1, 1), (0, 0))) / np.gradient(time_s)[:, None])


def worse_than_measured(like: Trajectory, measured: Measured, smoothed: PerAxisPath) -> Kept:
    """Whether a path predicts rotations and positions ``(2,)`` far worse than neighbours do.

    Errors that last are much alike in neighbours, which predict these somewhat better than any path
    that does without; a path that misses poses twice as far does not follow them.
    """
    kept, time_s, poses = smoothed.weights > 0.0, measured.time_s, like.poses.rigid
    rows = 1 + np.flatnonzero(kept[:-2] & kept[1:-1] & kept[2:])
    if not len(rows):
        return np.zeros(2, dtype=np.bool_)
    others = measured.representation.retract(measured.coordinates, -smoothed.left_out)
    ours = restored(measured.representation, others, like).poses.rigid[rows]
    share = (time_s[rows] - time_s[rows - 1]) / (time_s[rows + 1] - time_s[rows - 1])
    step = (poses[rows - 1].inverse() @ poses[rows + 1]).as_twist()
    theirs = poses[rows - 1] @ Motor.from_twist(share[:, None] * step)
    errors = [_size(_off(poses[rows], one)) for one in (ours, theirs)]
    return np.asarray(errors[0] > _AS_GOOD * errors[1])


def in_part(smoothed: Trajectory, measured: Trajectory, share: FloatArray) -> Trajectory:
    """A path that goes so far ``(N, 2)``, in rotation and position, from measured to smoothed."""
    stay, rows = np.all(share == 0.0, axis=1), np.flatnonzero(np.any(share < 1.0, axis=1))
    path = smoothed.poses.rigid
    own, other = path[rows], measured.poses.rigid[rows]
    turn = (other.rotor.inverse() @ own.rotor).as_rotation_vector()
    rotors = other.rotor @ Rotor.from_rotation_vector(share[rows, :1] * turn)
    shift = own.translation_m - other.translation_m
    shifts = other.translation_m + share[rows, 1:] * shift
    rigid = np.array(path.coefficients)
    rigid[rows] = Motor.from_rotor_translation(rotors, shifts).coefficients
    coefficients = np.array(with_rigid(smoothed.poses, Motor(rigid)).coefficients)
    coefficients[stay] = measured.poses.coefficients[stay]
    poses = type(smoothed.poses)(coefficients)
    return Trajectory(smoothed.time_ns, poses, smoothed.parent, smoothed.child)


class _HeldOut:
    """Runs that are held out, and how well the kept poses predict as many good ones."""

    def __init__(self, time_s: FloatArray, poses: Motor, kept: Kept, most: FloatArray) -> None:
        self.time_s, self.poses, self.kept, self.most = time_s, poses, kept, most
        self.rows, self.count = np.flatnonzero(kept), len(kept)
        self.good = poses[self.rows]
        self.off = _off(poses, bridged(time_s, poses, kept))
        gaps, _, missing = crossings(time_s, poses, kept)
        self.missed = dict(zip(gaps[:, 0].tolist(), _parts(missing), strict=True))
        self.errors: dict[int, tuple[IntArray, FloatArray, FloatArray]] = {}

    def right_among(self, edges: list[int]) -> list[tuple[int, int]]:
        """The longest part of a run between leaps that agrees and lies where the kept poses predict
        it, or leads to them or on from them over what is left out: then the level jumps beside it.
        """
        near = self._near(edges[0], edges[-1])
        if near is None or len(edges) == 2:
            return []
        right = [
            (begin, end)
            for begin, end in pairwise(edges)
            if end - begin > 2
            and (
                not np.any(_size(self.off[begin:end]) > near[0])
                or self._leads_on(edges[0], begin, end, edges[-1])
            )
        ]
        return sorted(right, key=lambda piece: piece[0] - piece[1])[:1]

    def _leads_on(self, first: int, begin: int, end: int, last: int) -> bool:
        """Whether part of a run is crossed to, or from, as well as as many good poses are."""
        around = slice(max(first - _AROUND, 0), last + _AROUND)
        kept = np.array(self.kept)
        kept[begin:end] = True
        gaps, _, missing = crossings(self.time_s[around], self.poses[around], kept[around])
        for (before, behind), missed in zip(gaps + around.start, _parts(missing), strict=True):
            near = self._near(before + 1, behind)
            beside = begin == behind or end == before + 1
            shorter = behind - before - 1 <= end - begin
            if near is not None and beside and shorter and not np.any(missed > near[1]):
                return True
        return False

    def _leaps_back(self, first: int, last: int) -> bool:
        """Whether the path leaps back by as much as it leaps off, so that a run is off alike."""
        if last - first < 2 or first < 2 or last > self.count - 2:
            return False
        rates = (self.poses[:-1].inverse() @ self.poses[1:]).as_twist()
        rates /= np.diff(self.time_s)[:, None]
        leaps = []
        for row in (first, last):
            usual = 0.5 * (rates[row - 2] + rates[row]) * (self.time_s[row] - self.time_s[row - 1])
            expected = self.poses[row - 1] @ Motor.from_twist(usual)
            turn = (expected.rotor.inverse() @ self.poses[row].rotor).as_rotation_vector()
            leaps.append([turn, self.poses[row].translation_m - expected.translation_m])
        return not np.any(np.linalg.norm(np.sum(leaps, axis=0), axis=1) > _BACK * self.most)

    def judged(self, edges: list[int]) -> tuple[list[tuple[int, int]], list[int]]:
        """Parts of a run between leaps that are motion, and rows before which its level jumps."""
        first, last = edges[0], edges[-1]
        whole, longest = [(first, last)], max(np.diff(edges))
        agrees = longest > (1 if len(edges) == 2 else 2)
        if first == 0 or last == self.count:
            # What the path leaps to and back from is wrong, however few poses lie behind it.
            pieces = [piece for piece in pairwise(edges) if not self._leaps_back(*piece)]
            beside = [piece for piece in pieces if not self._far_at_end(first, last, *piece)]
            inward = pieces[:: -1 if first == 0 else 1]
            by_end = list(takewhile(lambda piece: piece in beside, inward))
            near_by = by_end + [
                piece for piece in beside if piece[1] - piece[0] > 2 and piece not in by_end
            ]
            levels = [piece for piece in pairwise(edges) if piece[1] - piece[0] >= FEWEST_AT_LEVEL]
            if near_by or not levels:
                return near_by, []
            return levels, [last if first == 0 else first]
        near = self._near(first, last)
        far, missed = _size(self.off[first:last]), self.missed[first - 1]
        if near is None or (len(edges) == 2 and not np.any(far > near[0])):
            return whole, []
        returns = not np.any(missed > near[1])
        if agrees:  # poses that do not agree are wrong wherever the path goes on
            far = np.max([_size(self.off[slice(*piece)]) for piece in pairwise(edges)], axis=0)
            far_off = bool(np.any((far > near[0]) & (missed < _RETURNED * far)))
            returns = returns and (far_off or self._leaps_back(first, last))
        if returns:
            return [], []
        return (whole, [first, last]) if agrees and len(edges) == 2 else ([], [last])

    def _far_at_end(self, first: int, last: int, begin: int, end: int) -> bool:
        """Whether part of a run at an end lies off the pose next to it farther than it may move."""
        border, next_to = (last, end - 1) if first == 0 else (first - 1, begin)
        place = int(np.searchsorted(self.rows, border))
        near = slice(max(place - _AROUND, 0), place + _AROUND)
        step = np.median(_off(self.good[near][1:], self.good[near][:-1]), axis=0)
        rows = abs(border - next_to) + end - begin
        return bool(np.any(self.off[next_to] > _WRONG * rows * step))

    def _near(self, first: int, last: int) -> tuple[FloatArray, FloatArray] | None:
        """Three deviations of bridging as many good poses beside a run, and of missing its end."""
        if first == 0 or last == self.count:
            return None
        length = self._length(first, last)
        if length not in self.errors:
            self.errors[length] = self._bridged(length)
        blocks, *errors = self.errors[length]
        near = _near(blocks, first)
        if len(blocks[near]) < _FEWEST:
            return None
        bridging, misses = (_WRONG * _size(one[near]) for one in errors)
        return bridging, misses

    def _length(self, first: int, last: int) -> int:
        """Good poses in as long a time as a run and the gaps beside it take, in powers of √2."""
        usual_s = float(np.median(np.diff(self.time_s[self.rows])))
        span_s = self.time_s[last] - self.time_s[first - 1]
        return min(_rounded_up(max(round(span_s / usual_s) - 1.0, 1.0)), len(self.rows))

    def _bridged(self, length: int) -> tuple[IntArray, FloatArray, FloatArray]:
        """Blocks of so many kept rows that are left out, and errors ``(S, 2)`` of bridging them.

        These are of the poses between, and of what the speed beside them misses the far end by.
        """
        rows, time_s = self.rows, self.time_s[self.rows]
        inside = _blocks(len(rows), length)
        among = np.ones(len(rows), dtype=np.bool_)
        among[inside] = False
        off = _off(self.good, bridged(time_s, self.good, among))[inside]
        return rows[inside], _size(off), _parts(crossings(time_s, self.good, among)[2])


def _blocks(count: int, length: int) -> IntArray:
    """Blocks ``(S, length)`` of rows that are held out, with some between them."""
    starts = np.arange(_BETWEEN, count - length - _BETWEEN + 1, length + _BETWEEN)
    return np.asarray(starts[:, None] + np.arange(length))


def _near(blocks: IntArray, row: int) -> slice:
    """Those to both sides of a row."""
    place = int(np.searchsorted(blocks[:, 0], row))
    return slice(max(place - _BESIDE, 0), place + _BESIDE)


def _rounded_up(count: float) -> int:
    """To a power of √2, so that few lengths are held out."""
    return int(np.ceil(2.0 ** (np.ceil(2.0 * np.log2(count)) / 2.0) - 1e-9))


def runs_of(rows: Kept) -> IntArray:
    """First and one past the last ``(R, 2)`` of the runs of rows that are set."""
    return np.flatnonzero(np.diff(np.concatenate([[0], rows, [0]]))).reshape(-1, 2)


def beside_jumps(kept: Kept, jumps: IntArray) -> Kept:
    """Poses ``(N,)`` of runs that are left out next to a jump, which neither side tells."""
    beside = np.zeros_like(kept)
    for first, last in runs_of(~kept):
        beside[first:last] = bool(np.any((jumps >= first) & (jumps <= last)))
    return beside


def _bends(time_s: FloatArray, poses: Motor) -> FloatArray:
    """By how much each step ``(N + 1, 2)`` differs from those beside it, in rad and m.

    Row k is of the step before pose k. A turn, however fast, changes steps little by little; a leap
    is unlike what the steps on either side go on to, two and three of them, and unlike their mean.
    There is none beyond the ends.
    """
    rates = (poses[:-1].inverse() @ poses[1:]).as_twist() / np.diff(time_s)[:, None]
    ahead, count = np.pad(rates, ((3, 3), (0, 0)), "edge"), len(rates)
    unlike = [_parts(rates - 0.5 * (ahead[2:-4] + ahead[4:-2]))]
    for side in (-1, 1):
        near, far, last = (ahead[3 + side * k :][:count] for k in (1, 2, 3))
        slopes = (2.0 * near - far, (4.0 * near + far - 2.0 * last) / 3.0)
        unlike.append(_parts(rates - near))
        unlike.append(np.max([_parts(rates - one) for one in slopes], axis=0))
    least = np.min(unlike, axis=0)
    least[[0, -1]] = _parts(rates[[0, -1]] - rates[[1, -2]])
    return np.pad(least * float(np.median(np.diff(time_s))), ((1, 1), (0, 0)))


def _leaps(bent: FloatArray, usual: Kept, most: FloatArray, first: int, last: int) -> list[int]:
    """Rows before which the path leaps, of a run and the one behind it; with the path's ends.

    A leap is a step that bends more than usual ones do beside the run and, but for few, anywhere.
    """
    beside = slice(max(first - _AROUND, 0), last + _AROUND)
    near = bent[:-1][beside][usual[beside]]
    least = _WRONG * np.maximum(np.median(near, axis=0) if len(near) else 0.0, most)
    leaps = first + np.flatnonzero(np.any(bent[first : last + 1] > least, axis=1))
    ends = {one for one in (0, len(usual)) if one in (first, last)}
    return sorted(ends.union(leaps.tolist()))


def _widened(rows: Kept) -> Kept:
    """Rows with those next to them."""
    return np.convolve(rows, np.ones(5), "same") > 0.5


def _off(poses: Motor, predicted: Motor) -> FloatArray:
    """By how much each lies off, in rad and m ``(N, 2)``."""
    return _parts((predicted.inverse() @ poses).as_twist())


def _parts(twists: FloatArray) -> FloatArray:
    """Sizes ``(N, 2)`` of both parts of twists ``(N, 6)``."""
    return np.asarray(np.linalg.norm(twists.reshape(-1, 2, 3), axis=2), dtype=np.float64)


def _size(off: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(off**2, axis=-2)), dtype=np.float64)
