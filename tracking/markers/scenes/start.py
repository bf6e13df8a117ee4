"""Where a scene's poses are to begin with: one is found after another, by what is seen of it.

An observation of whose chain one pose alone is missing proposes that pose. Of a frame's proposals
the one that reprojects the frame best is taken; of a pose that stays, the one that most frames
agree on, the surest first. Where nothing more is seen, odometry places the next pose; then poses
are taken that were stated with so much doubt that they were not begun with.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.mapping.rig import agreed
from motorcade.tracking.markers.scenes.scene import MarkerScene, StatedPose
from motorcade.tracking.markers.scenes.table import BODY, CAMERA, CARRIER, MARKER, SceneObservations

_SURE_RAD, _SURE_M = 0.5, 0.5
"""A pose stated with more doubt is worth no more than a guess."""
_MOST_PROPOSALS = 8
_MOST_VOTES = 100
_FAR_PX = 20.0
_ANOTHER_RAD = np.radians(10.0)
_AMBIGUOUS = 16.0
"""Beyond this many χ² a pose is not the other one: 1 of 3,000 by chance. Where a frame's best pose
fits worse than noise allows, noise is taken to be as large as the misfit."""
_NEAR_NS = 1_000_000_000
_AGREE_SHARE = 0.1
_SUPPORT = 0.5


class Start:
    """The table while it is filled.

    Attributes:
        poses: ``(P, 8)`` coefficients.
        known: ``(P,)``.
    """

    def __init__(self, seen: SceneObservations, scene: MarkerScene) -> None:
        self._seen, self._scene = seen, scene
        self._chain = seen.usual_chain
        self.poses = np.tile(Motor.identity().coefficients, (seen.rows, 1))
        self.known = np.zeros(seen.rows, bool)
        self._staying = np.zeros(seen.rows, bool)
        self._staying[: len(seen.names) + len(seen.marker_ids)] = True
        for first, body in zip(seen.first_row.tolist(), scene.bodies, strict=True):
            self._staying[first] |= not body.moves

    def fill(self) -> None:
        """Find all that can be found."""
        self._state(sure=True)
        self._anchor()
        while True:
            if self._see():
                continue
            if self._lead_on() or self._state(sure=False):
                continue
            break
        self._wiggle()

    def place_again(self, poses: Motor) -> None:
        """Place frames anew that an adjustment left far from what they show.

        It may have begun in the wrong one of two planar poses, or been pulled off by an observation
        that was no marker's.
        """
        self.poses = poses.coefficients.copy()
        self._frames_off()
        self.fill()

    def _wiggle(self) -> None:
        """Poses of a camera's frames begin as its usual one."""
        usual, own = self._seen.usual_camera, self._seen.chain[:, CAMERA]
        new = ~self.known[own] & self.known[usual]
        self.poses[own[new]] = self.poses[usual[new]]
        self.known[own[new]] = True

    def _frames_off(self) -> None:
        errors = self._seen.errors_px(Motor(self.poses))
        known = self.known[self._seen.chain].all(axis=1)
        if not known.any():
            return
        beyond = errors > self._seen.limits_px(self._scene.sigma_px)
        for column in (CARRIER, BODY):
            rows = self._seen.chain[:, column]
            usable = known & ~self._staying[rows]
            if not usable.any():
                continue
            rows, off = rows[usable], beyond[usable]
            seen = np.bincount(rows, minlength=len(self.known))
            bad = np.bincount(rows, off, minlength=len(self.known))
            self.known[(2.0 * bad >= seen) & (seen > 0)] = False

    def _state(self, *, sure: bool) -> bool:
        """Take poses as they were stated; whether any was new."""
        new = False
        for row, stated in stated_rows(self._seen, self._scene):
            spread = np.sqrt(np.diag(stated.covariance))
            is_sure = spread[:3].max() <= _SURE_RAD and spread[3:].max() <= _SURE_M
            if not self.known[row] and is_sure == sure:
                self._set(row, stated.pose)
                new = True
        return new

    def _anchor(self) -> None:
        """A world, and a frame for each body of which no marker is stated: its first ones'."""
        still = [k for k, body in enumerate(self._scene.bodies) if not body.moves]
        rows = self._seen.first_row[still]
        if not self.known[rows].any():
            self._set(int(rows[0]), Motor.identity())
        for k in range(len(self._scene.bodies)):
            mine = np.flatnonzero(self._seen.marker_body == k)
            rows = len(self._seen.names) + mine
            if len(mine) and not self.known[rows].any() and self._free(k):
                seen = np.bincount(self._seen.marker, minlength=len(self._seen.marker_ids))[mine]
                self._set(int(rows[np.argmax(seen)]), Motor.identity())

    def _free(self, body: int) -> bool:
        """Whether the frame of a body is nowhere fixed: it moves, or no pose of it was stated."""
        carriers = {self._scene.camera_body[name] for name in self._seen.names}
        own = self._scene.bodies[body]
        return not own.moves or own.name not in carriers

    def _set(self, row: int, pose: Motor) -> None:
        self.poses[row], self.known[row] = pose.coefficients, True

    def _see(self) -> bool:
        """Poses that observations propose; whether any was found."""
        missing = ~self.known[self._chain]
        single = np.flatnonzero(np.count_nonzero(missing, axis=1) == 1)
        if not len(single):
            return False
        slot = np.argmax(missing[single], axis=1)
        target = self._chain[single, slot]
        passing = ~self._staying[target]
        if passing.any():
            self._place(single[passing], target[passing], slot[passing])
            return True
        return self._vote(single, target, slot)

    def _proposed(self, rows: IntArray, which: IntArray, slot: IntArray) -> Motor:
        """Missing poses by observations ``(n,)``, of each by one of its planar poses."""
        chain, table = self._chain[rows], Motor(self.poses)
        camera, carrier, body, marker = (table[chain[:, k]] for k in range(4))
        seen = self._seen.camera_T_marker[rows, which]
        proposed = np.empty((len(rows), 8))
        ways: tuple[tuple[int, Callable[[IntArray], Motor]], ...] = (
            (CAMERA, lambda k: carrier[k].inverse() @ body[k] @ marker[k] @ seen[k].inverse()),
            (CARRIER, lambda k: body[k] @ marker[k] @ (camera[k] @ seen[k]).inverse()),
            (BODY, lambda k: carrier[k] @ camera[k] @ seen[k] @ marker[k].inverse()),
            (MARKER, lambda k: body[k].inverse() @ carrier[k] @ camera[k] @ seen[k]),
        )
        for column, make in ways:
            mine = np.flatnonzero(slot == column)
            if len(mine):
                proposed[mine] = make(mine).coefficients
        return Motor(proposed)

    def _place(self, rows: IntArray, target: IntArray, slot: IntArray) -> None:
        """Each pose of a frame: of its proposals the one that all its observations fit best.

        Where another one fits nearly as well, the one nearer to the next frame that is sure.
        """
        size = np.ptp(self._seen.corners_px[rows], axis=1).prod(axis=-1)
        order = np.lexsort((-size, target))
        rows, target, slot = rows[order], target[order], slot[order]
        starts = np.flatnonzero(np.concatenate([[True], target[1:] != target[:-1]]))
        counts = np.diff(np.concatenate([starts, [len(target)]]))
        group = np.repeat(np.arange(len(starts)), counts)
        few = np.flatnonzero(np.arange(len(target)) - starts[group] < _MOST_PROPOSALS)
        offer, which = np.repeat(few, 2), np.tile([0, 1], len(few))  # the largest, both poses
        proposed = self._proposed(rows[offer], which, slot[offer])
        sizes = counts[group[offer]]
        ends = np.cumsum(sizes)
        each = np.repeat(np.arange(len(offer)), sizes)
        judge = np.arange(ends[-1]) - (ends - sizes)[each] + starts[group[offer]][each]
        cost = self._cost(rows[judge], target[judge], proposed[each])
        total = np.bincount(each, cost, minlength=len(offer))
        chi2 = np.asarray(4.0 * total / self._seen.noise_px**2, np.float64)
        best = np.full(len(starts), np.inf)
        np.minimum.at(best, group[offer], chi2)
        chi2 /= np.maximum(best / (8 * counts - 6), 1.0)[group[offer]]  # noisier than the others
        self._choose(target[offer], proposed, chi2)

    def _choose(self, target: IntArray, proposed: Motor, chi2: FloatArray) -> None:
        order = np.lexsort((chi2, target))
        target, proposed, chi2 = target[order], proposed[order], chi2[order]
        first = np.flatnonzero(np.concatenate([[True], target[1:] != target[:-1]]))
        best = np.repeat(first, np.diff(np.concatenate([first, [len(target)]])))
        apart = (proposed[best].inverse() @ proposed).rotor.angle()
        rival = np.flatnonzero((apart > _ANOTHER_RAD) & (chi2 - chi2[best] < _AMBIGUOUS))
        unsure = np.unique(target[rival])
        sure = first[~np.isin(target[first], unsure)]
        self.poses[target[sure]] = proposed[sure].coefficients
        self.known[target[sure]] = True
        for row in self._by_nearness(unsure):
            mine = np.flatnonzero(target == row)
            mine = mine[chi2[mine] - chi2[mine[0]] < _AMBIGUOUS]
            near = self._neighbour(int(row))
            turn = (
                np.zeros(1)
                if near is None
                else (Motor(self.poses[near]).inverse() @ proposed[mine]).rotor.angle()
            )
            self._set(int(row), proposed[mine[int(np.argmin(turn))]])

    def _by_nearness(self, rows: IntArray) -> IntArray:
        """Those with a known neighbour in time come first."""
        nearest = [self._neighbour(int(row)) for row in rows]
        off = [
            np.inf if known_row is None else abs(known_row - row)
            for row, known_row in zip(rows, nearest, strict=True)
        ]
        return rows[np.argsort(off, kind="stable")]

    def _neighbour(self, row: int) -> int | None:
        """The nearest known frame of the same body within a second."""
        body = int(np.searchsorted(self._seen.first_row, row, side="right")) - 1
        first, time_ns = int(self._seen.first_row[body]), self._seen.time_ns
        here = time_ns[row - first]
        low, high = np.searchsorted(time_ns, [here - _NEAR_NS, here + _NEAR_NS + 1])
        frames = low + np.flatnonzero(self.known[first + low : first + high])
        if not len(frames):
            return None
        return first + int(frames[np.argmin(np.abs(time_ns[frames] - here))])

    def _cost(self, rows: IntArray, target: IntArray, proposed: Motor) -> FloatArray:
        """Squared errors (px²), bounded, of observations whose missing pose is as proposed."""
        chain, table = self._chain[rows], Motor(self.poses)
        posed = [
            Motor(
                np.where(
                    (chain[:, k] == target)[:, None],
                    proposed.coefficients,
                    table.coefficients[chain[:, k]],
                )
            )
            for k in range(4)
        ]
        camera_T_marker = (posed[CARRIER] @ posed[CAMERA]).inverse() @ posed[BODY] @ posed[MARKER]
        residuals = self._seen.residuals_px(
            rows, camera_T_marker[:, None].apply(self._seen.points_m[rows])
        )
        squares: FloatArray = np.sum(residuals**2, axis=(-1, -2)) / 4.0
        return np.asarray(np.minimum(np.nan_to_num(squares, nan=np.inf), _FAR_PX**2), np.float64)

    def _vote(self, rows: IntArray, target: IntArray, slot: IntArray) -> bool:
        """Poses that stay: those that most frames agree on."""
        votes: dict[int, tuple[Motor, float]] = {}
        for row in np.unique(target).tolist():
            mine = np.flatnonzero(target == row)
            mine = mine[np.linspace(0, len(mine) - 1, min(len(mine), _MOST_VOTES)).astype(np.int64)]
            seen, which = np.repeat(rows[mine], 2), np.tile([0, 1], len(mine))
            proposed = self._proposed(seen, which, np.repeat(slot[mine], 2))
            side_m = self._seen.side_m[self._seen.marker[seen]]
            poses = self._seen.camera_T_marker[seen, which]
            far_m = np.linalg.norm(poses.translation_m, axis=-1)
            reach_m = _AGREE_SHARE * np.maximum(far_m, side_m)
            votes[row] = agreed(proposed, self._seen.probability[seen, which], reach_m)
        most = max(support for _, support in votes.values())
        for row, (pose, support) in votes.items():
            if support >= _SUPPORT * most:
                self._set(row, pose)
        return True

    def _lead_on(self) -> bool:
        """Frames that odometry reaches from the nearest known one."""
        new = False
        for k, body in enumerate(self._scene.bodies):
            if body.odometry is None or not body.moves:
                continue
            rows = self._seen.first_row[k] + np.arange(len(self._seen.time_ns))
            path = body.odometry.trajectory.transformed_by(
                right=body.odometry.body_T_odometry.inverse()
            )
            time_ns = self._seen.time_ns
            inside = (time_ns >= path.time_ns[0]) & (time_ns <= path.time_ns[-1])
            from_ = np.flatnonzero(self.known[rows] & inside)
            to = np.flatnonzero(~self.known[rows] & inside)
            if not len(from_) or not len(to):
                continue
            near = from_[_nearest(time_ns[from_], time_ns[to])]
            steps = path.motors_at(time_ns[near]).inverse() @ path.motors_at(time_ns[to])
            self.poses[rows[to]] = (Motor(self.poses[rows[near]]) @ steps).coefficients
            self.known[rows[to]] = True
            new = True
        return new


def stated_rows(seen: SceneObservations, scene: MarkerScene) -> list[tuple[int, StatedPose]]:
    """Row of the table and pose of all that was stated."""
    rows = [
        (row, scene.cameras[name]) for row, name in enumerate(seen.names) if name in scene.cameras
    ]
    for k, (marker, body) in enumerate(
        zip(seen.marker_ids.tolist(), seen.marker_body.tolist(), strict=True)
    ):
        fixed = scene.bodies[body].markers.get(marker)
        if fixed is not None and fixed.stated is not None:
            rows.append((len(seen.names) + k, fixed.stated))
    for row, owner in zip(seen.first_row.tolist(), scene.bodies, strict=True):
        if owner.stated is not None and not owner.moves:
            rows.append((row, owner.stated))
    return rows


def _nearest(sorted_ns: IntArray, time_ns: IntArray) -> NDArray[np.int64]:
    after = np.clip(np.searchsorted(sorted_ns, time_ns), 1, max(len(sorted_ns) - 1, 1))
    if len(sorted_ns) == 1:
        return np.zeros(len(time_ns), np.int64)
    before = after - 1
    return np.where(
        time_ns - sorted_ns[before] <= sorted_ns[after] - time_ns, before, after
    ).astype(np.int64)
