"""Runs of poses that are a flat marker's other candidate, read as what they tell nevertheless.

The image of a flat marker allows two poses, mirrored about the line of sight to its centre
(`wrong_planar_pose`); the mirror of the wrong one is the right one again. Where a tracker takes the
wrong one the path leaps, and leaps back. For each run of poses that the chain of `inliers`
leaves out, the marker is searched for, centre and normal at rest in the world, whose mirror puts
the run on the path of the poses around it. The turn of one leap, about an axis through the centre
and across the line of sight, tells all five numbers; then they and the path are estimated together.
A run that no marker explains is left as it is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.motions.degradations import wrong_planar_pose
from motorcade.fusion.smoothing.batch.inliers import (
    Charged,
    PathState,
    Problem,
    Sizes,
    inlier_poses,
    loss_weights,
)
from motorcade.fusion.smoothing.representations import REPRESENTATIONS, Representation
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray

# Shorter runs are bridged as well as they are read.
_SHORTEST = 4
# Poses around a run that tell the path there, and poses of it, those whose place is then known
# best, that a marker is first estimated from.
_AROUND, _TRIED = 30, 6
# Process noise across a run may be so many times what the model says.
_PROCESS_FACTOR = 3.0
# Models of the motion: the twist in the body is constant, or the turn and the shift in the world.
_MODELS = ("motor", "rotor")
# Turns that are told from noise, in its deviations.
_TURN_DEVIATIONS = 6.0
# Squared length of a pose's six numbers, in deviations: beyond the first it is thrown off, up to
# the second it is explained.
_THROWN, _EXPLAINED = 200.0, 25.0
# What each of the fewest poses of a run must save at least, in squared deviations.
_GAIN = 30.0
# A step of a run is a usual one up to so many median ones, and a leap from so many times that on.
_TORN = 2.0
_ROUNDS = 8
_STEP = 1e-6


def mirrored_back(
    time_s: FloatArray,
    poses: Motor,
    kept: NDArray[np.bool_],
    sizes: tuple[Sizes, Sizes, Sizes],
    width: float,
) -> tuple[Motor, NDArray[np.bool_]]:
    """The path with the runs that a marker explains mirrored back, and which of its rows they are.

    Args:
        time_s: ``(N,)`` increasing.
        poses: ``(N,)`` as measured.
        kept: which belong to the motion; see `inlier_poses`.
        sizes: of rotation and translation, as there.
        width: of Cauchy's loss, in deviations of a pose.
    """
    explained = np.zeros(len(poses), dtype=np.bool_)
    coefficients = np.array(poses.coefficients)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], ~kept, [0]])))
    for first, last in edges.reshape(-1, 2):
        read = mirrored_run(time_s, poses, kept, slice(first, last), sizes, width)
        if read is not None:
            rows = first + np.flatnonzero(read[1])
            coefficients[rows], explained[rows] = read[0][read[1]].coefficients, True
    return Motor(coefficients), explained


def mirrored_run(
    time_s: FloatArray,
    poses: Motor,
    kept: NDArray[np.bool_],
    run: slice,
    sizes: tuple[Sizes, Sizes, Sizes],
    width: float,
) -> tuple[Motor, NDArray[np.bool_]] | None:
    """The poses ``(K,)`` of one such run mirrored, and which of them that explains; else None."""
    part = slice(max(0, run.start - _AROUND), min(len(poses), run.stop + _AROUND))
    # Without two poses around the run not even a velocity is left to read it by.
    if run.stop - run.start < _SHORTEST or np.count_nonzero(kept[part]) < 2:
        return None
    within = slice(run.start - part.start, run.stop - part.start)
    read = _Run.likelier(time_s[part], poses[part], kept[part], within, sizes, width).read()
    return None if read is None or _torn(poses[run], *read, sizes) else read


def _torn(
    poses: Motor, read: Motor, turned: NDArray[np.bool_], sizes: tuple[Sizes, Sizes, Sizes]
) -> bool:
    """Whether poses that agree with each other do not when some of them are mirrored."""
    rows = np.flatnonzero(turned[1:] != turned[:-1])
    noise = np.repeat([one.noise for one in sizes[:2]], 3)
    mirrored = Motor(np.where(turned[:, None], read.coefficients, poses.coefficients))
    before, after = (
        np.linalg.norm((path[:-1].inverse() @ path[1:]).as_twist() / noise, axis=1)
        for path in (poses, mirrored)
    )
    usual = _TORN * np.median(before)
    return bool(np.any((before[rows] < usual) & (after[rows] > _TORN * usual)))


class _Expected(NamedTuple):
    """Where the path puts the poses of a run, with deviations ``(K, 6)``."""

    poses: Motor
    deviation: FloatArray

    def vectors(self, poses: Motor) -> FloatArray:
        return (self.poses.inverse() @ poses).as_twist() / self.deviation


class _Run:
    """A segment of a path with a run of poses left out."""

    @classmethod
    def likelier(cls, *segment: Any) -> _Run:
        """The segment as a body in free flight or as a screw, whichever its good poses tell."""
        return min((cls(REPRESENTATIONS[name], *segment) for name in _MODELS), key=_Run._doubt)

    def __init__(
        self,
        representation: Representation,
        time_s: FloatArray,
        poses: Motor,
        kept: NDArray[np.bool_],
        run: slice,
        sizes: tuple[Sizes, Sizes, Sizes],
        width: float,
    ) -> None:
        self.time_s, self.run, self.sizes, self.width = time_s, run, sizes, width
        self.poses, self.kept = poses[run], kept
        self.problem = Problem(representation, time_s, poses, kept, sizes)
        self.path = self.problem.narrowed("cauchy", width)

    def _doubt(self) -> float:
        return self.problem.charged(self.path, "cauchy", self.width, self.kept).cost

    def read(self) -> tuple[Motor, NDArray[np.bool_]] | None:
        """The run's poses mirrored and which of them that explains; None where it is too few."""
        marker = self._first_marker()
        if marker is None:
            return None
        everyone = np.ones(len(self.time_s), dtype=np.bool_)
        plain = self.problem.descended(self.path, "cauchy", self.width, everyone, _ROUNDS)
        marker, mirrored, turned = self._refined(marker)
        explained = turned & (mirrored.squares[self.run] < _EXPLAINED)
        saved = plain.cost - mirrored.cost
        if np.count_nonzero(explained) < _SHORTEST or saved < _GAIN * _SHORTEST:
            return None
        return self._mirrored(marker), explained

    def _mirrored(self, marker: FloatArray) -> Motor:
        """The run's poses ``(*, K)`` by markers ``(*, 6)``."""
        normal = marker[..., 3:] / np.linalg.norm(marker[..., 3:], axis=-1, keepdims=True)
        return wrong_planar_pose(self.poses, marker[..., None, :3], normal[..., None, :])

    def _expected(self) -> _Expected:
        """Where the path puts the run, and how surely: with states known a seconds before and b
        behind, white acceleration of unit density moves a pose by ``a³ b³ / 3 (a + b)³``.
        """
        time_s, run = self.time_s, self.run
        before_s = time_s[run] - (time_s[run.start - 1] if run.start > 0 else -np.inf)
        behind_s = (time_s[run.stop] if run.stop < len(time_s) else np.inf) - time_s[run]
        spread = (1.0 / before_s + 1.0 / behind_s) ** -3.0 / 3.0
        noise, density = (np.repeat(pair, 3) for pair in zip(*self.sizes[:2], strict=True))
        variance = 2.0 * noise**2 + (_PROCESS_FACTOR * density) ** 2 * spread[:, None]
        poses = self.problem.representation.poses(self.path.coordinates[run]).rigid
        return _Expected(poses, np.sqrt(variance))

    def _first_marker(self) -> FloatArray | None:
        """Of markers that explain a leap, that which explains most; None without leaps."""
        expected = self._expected()
        surest = np.argsort(expected.deviation[:, 3])[:_TRIED]
        off, deviation = expected.vectors(self.poses)[surest], expected.deviation[surest]
        squares = np.sum(off**2, axis=1)
        leap, thrown = (off * deviation)[np.argmax(squares)], squares > _THROWN
        # In the middle of a run at a low rate even the largest leap would not show.
        shown = np.sum((leap / deviation) ** 2, axis=1) > _THROWN
        guesses = _markers(self.poses, expected, surest[thrown], self.sizes[0].noise)
        if 2 * np.count_nonzero(thrown) < np.count_nonzero(shown) or not len(guesses):
            return None
        off = expected.vectors(self._mirrored(guesses))[:, surest]
        charged = np.sum(np.log1p(np.sum(off**2, axis=-1) / self.width**2), axis=-1)
        return np.asarray(guesses[int(np.argmin(charged))])

    def _refined(self, marker: FloatArray) -> tuple[FloatArray, Charged, NDArray[np.bool_]]:
        """Marker and path together, by Gauss-Newton; the path's own unknowns are eliminated.

        Every pose of the run is read anew each time, mirrored or as measured, whichever lies nearer
        to the path: with the wrong candidates the chain may leave out right poses beside them.
        """
        run, problem = self.run, self._with(marker)
        path, among = problem.narrowed("cauchy", self.width), np.ones(len(self.time_s), np.bool_)
        for _ in range(_ROUNDS):
            turned = self._read_anew(problem, marker, path)
            squares = problem.charged(path, "cauchy", self.width, among).squares[run]
            weight = turned * loss_weights(squares, "cauchy", self.width)
            by_marker, ways = self._by_marker(marker, path)
            weighed = (weight[:, None] * problem.noise**-2.0)[:, :, None] * by_marker
            vector = problem.representation.local(path.coordinates[run], problem.measured[run])
            by_pose = problem.representation.local_jacobians(vector)[1]
            pull = np.zeros((len(self.time_s), 2 * len(problem.noise), len(ways)))
            pull[run, : by_marker.shape[1]] = np.swapaxes(by_pose, 1, 2) @ weighed
            alone, along = problem.stepped(path, "cauchy", self.width, pull)
            normal = np.einsum("nik,nil->kl", weighed, by_marker)
            normal -= np.einsum("nik,nil->kl", pull, along)
            right = -np.einsum("nik,ni->k", weighed, vector)
            right -= np.einsum("nik,ni->k", pull, alone)
            step = np.linalg.lstsq(normal, right, rcond=1e-10)[0]
            marker = marker + step @ ways
            marker[3:] /= np.linalg.norm(marker[3:])
            path = problem.retract(path, alone - along @ step)
        turned = self._read_anew(problem, marker, path)
        return marker, problem.charged(path, "cauchy", self.width, among), turned

    def _read_anew(
        self, problem: Problem, marker: FloatArray, state: PathState
    ) -> NDArray[np.bool_]:
        """Put the run's poses into the problem as they lie nearest; which of them are mirrored."""
        here = state.coordinates[self.run]
        read = [problem.written(poses, here) for poses in (self.poses, self._mirrored(marker))]
        squares = [
            np.sum((problem.representation.local(here, coordinates) / problem.noise) ** 2, axis=1)
            for coordinates in read
        ]
        turned = np.asarray(squares[1] <= squares[0])
        problem.measured[self.run] = np.where(turned[:, None], read[1], read[0])
        return turned

    def _with(self, marker: FloatArray) -> Problem:
        """The segment with those of the run mirrored for which the path bends least."""
        coefficients = np.array(self.problem.poses.rigid.coefficients)
        turned = self._smoothest(Motor(coefficients), self._mirrored(marker))
        rows = self.run.start + np.flatnonzero(turned)
        coefficients[rows] = self._mirrored(marker)[turned].coefficients
        poses = Motor(coefficients)
        kept = inlier_poses(self.time_s, poses, *self.sizes[:2])
        return Problem(self.problem.representation, self.time_s, poses, kept, self.sizes)

    def _smoothest(self, measured: Motor, mirrored: Motor) -> NDArray[np.bool_]:
        """Which poses of the run are mirrored on the path whose speed changes least from pose to
        pose, by dynamic programming: where both candidates come close, a run ends without a leap.
        """
        first, last = max(self.run.start - 2, 0), min(self.run.stop + 2, len(self.time_s))
        either = np.repeat(measured.coefficients[first:last, None], 2, axis=1)
        offered = np.zeros(last - first, dtype=np.bool_)
        offered[self.run.start - first : self.run.stop - first] = True
        either[offered, 1] = mirrored.coefficients
        candidates, step_s = Motor(either), np.diff(self.time_s[first:last])[:, None]
        steps = (candidates[:-1, :, None].inverse() @ candidates[1:, None, :]).as_twist()
        rates = steps / step_s[:, None, None]
        noise, density = (np.repeat(pair, 3) for pair in zip(*self.sizes[:2], strict=True))
        before, behind = 1.0 / step_s[:-1], 1.0 / step_s[1:]
        variance = noise**2 * (before**2 + behind**2 + (before + behind) ** 2)
        variance += 0.5 * density**2 * (step_s[:-1] + step_s[1:])
        bends = rates[1:, None] - rates[:-1, ..., None, :]
        squares = np.sum(bends**2 / variance[:, None, None, None], axis=-1)
        price = np.log1p(squares / self.width**2)
        price[~offered[2:], :, :, 1] = np.inf
        return _cheapest(price, offered)[self.run.start - first : self.run.stop - first]

    def _by_marker(self, marker: FloatArray, path: PathState) -> tuple[FloatArray, FloatArray]:
        """Derivatives ``(K, 6, 5)`` of the residuals, and the ways ``(5, 6)`` a marker may go."""
        across = np.linalg.svd(marker[None, 3:])[2][1:]
        ways = np.block([[np.eye(3), np.zeros((3, 3))], [np.zeros((2, 3)), across]])
        here = path.coordinates[self.run]
        ahead, back = (
            self.problem.representation.local(
                here, self.problem.representation.coordinates(self._mirrored(marker + step * ways))
            )
            for step in (_STEP, -_STEP)
        )
        return np.moveaxis((ahead - back) / (2.0 * _STEP), 0, -1), ways


def _cheapest(price: FloatArray, offered: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of two candidates ``(N,)`` each pose has in the cheapest sequence.

    Args:
        price: ``(N - 2, 2, 2, 2)`` of each three poses in a row, by their candidates.
        offered: ``(N,)`` of which poses there is a second candidate.
    """
    score = np.where(
        np.logical_or.outer([False, not offered[0]], [False, not offered[1]]), np.inf, 0
    )
    before = np.zeros((len(price), 2, 2), dtype=np.int64)
    for row, each in enumerate(price):
        total = score[:, :, None] + each
        before[row] = np.argmin(total, axis=0)
        score = np.min(total, axis=0)
    pair = np.unravel_index(int(np.argmin(score)), (2, 2))
    chosen = [int(pair[1]), int(pair[0])]
    for choice in before[::-1]:
        chosen.append(int(choice[chosen[-1], chosen[-2]]))
    return np.array(chosen[::-1], dtype=np.bool_)


def _markers(poses: Motor, expected: _Expected, rows: IntArray, noise_rad: float) -> FloatArray:
    """Centres and normals ``(M, 6)`` that explain single poses of a run."""
    markers = []
    for row in rows:
        leap = poses[row] @ expected.poses[row].inverse()
        vector, shift = leap.rotor.as_rotation_vector(), leap.translation_m
        angle = float(np.linalg.norm(vector))
        if angle < _TURN_DEVIATIONS * noise_rad:
            continue
        axis, camera = vector / angle, expected.poses[row].translation_m
        across = shift - axis * (axis @ shift)
        on_axis = 0.5 * (across + np.cross(axis, across) / np.tan(0.5 * angle))
        centre = on_axis + axis * (axis @ (camera - on_axis))
        away = centre - camera
        distance = float(np.linalg.norm(away))
        if distance == 0.0:
            continue
        for half in (0.5 * angle, -0.5 * angle):
            normal = Rotor.from_rotation_vector(half * axis).apply(away / distance)
            markers.append(np.concatenate([centre, normal]))
    return np.array(markers).reshape(-1, 6)
