"""Frame by frame: where the points of the map are in the next picture, and the pose that follows.

The pose is predicted at constant velocity, corners are followed from where that puts them, and the
pose is refined on them; where the prediction does not explain the picture it is searched from
scratch. A pose is given only if enough corners, spread enough, agree with it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import FloatArray, IntArray, Motor
from motorcade.tracking.slam.features import Picture, follow, grid_cells
from motorcade.tracking.slam.geometry import (
    BoolArray,
    PosedPicture,
    inverse,
    pose_by_sampling,
    project,
    refine_pose,
)

__all__ = ["Followed", "Tracker", "trusted"]

_FEWEST_INLIERS = 25
_LEAST_SHARE = 0.4
_GOOD_SHARE = 0.75
_CELLS, _FEWEST_CELLS = 48, 6
_EPIPOLAR_PX = 3.0
_NEIGHBOURS = 3
_KEPT_SHARE = 0.8
_MOVED_SHARE = 0.06
_FEW_POINTS = 150


def trusted(posed: PosedPicture | None, px: FloatArray, shape: tuple[int, ...]) -> bool:
    """Whether a pose stands on enough corners, on enough of them all, and on enough of the picture.

    Args:
        posed: the pose; None is never trusted.
        px: ``(n, 2)`` the corners it was fitted to.
        shape: (height, width) of the picture.
    """
    if posed is None:
        return False
    count = int(np.count_nonzero(posed.inliers))
    if count < max(_FEWEST_INLIERS, _LEAST_SHARE * len(px)):
        return False
    cells = len(np.unique(grid_cells(px[posed.inliers], shape, _CELLS)))
    return cells >= _FEWEST_CELLS and bool(np.isfinite(posed.covariance).all())


@dataclass(frozen=True, eq=False)
class Followed:
    """Points of the map in one picture, as they are followed from there.

    What the tracker knows of the map is copied here, so the map may change meanwhile.

    Args:
        picture: the picture; camera_T_world: its pose ``(4, 4)``.
        ids: ``(n,)`` numbers of the points; px: ``(n, 2)`` where they are seen.
        places: ``(n, 3)`` where they are in the world, NaN where that is not known yet.
    """

    picture: Picture
    camera_T_world: FloatArray
    ids: IntArray
    px: FloatArray
    places: FloatArray

    @property
    def located(self) -> BoolArray:
        """Which points ``(n,)`` have a place."""
        known: BoolArray = np.isfinite(self.places[:, 0])
        return known


@dataclass(frozen=True, eq=False)
class _Moment:
    time_ns: int
    world_T_camera: Motor


class Tracker:
    """Follows points of the map through pictures; it never looks at the map itself.

    Args:
        matrix: ``(3, 3)`` intrinsics.
    """

    def __init__(self, matrix: FloatArray) -> None:
        self.matrix = matrix
        self._followed: Followed | None = None
        self._reference: Followed | None = None
        self._located_then = 0
        self._moments: list[_Moment] = []

    @property
    def followed(self) -> Followed:
        """What is followed, in the newest picture.

        Raises:
            RuntimeError: nothing is followed.
        """
        if self._followed is None:
            raise RuntimeError("Tracker.followed: expected a picture that was tracked, got none")
        return self._followed

    def restart(self, followed: Followed) -> None:
        """Go on from a pose that was found otherwise; what the motion was is forgotten."""
        self._moments = []
        self._reference = followed
        self._accept(followed)

    def anchor(self, keyframe: Followed, before: FloatArray) -> None:
        """Take over what the map made of a picture that was tracked: the newest, or one before.

        New points are followed from the keyframe to the newest picture; poses since then move as
        the keyframe moved.

        Args:
            keyframe: the keyframe with its points, as the map has it now.
            before: camera_T_world ``(4, 4)`` the keyframe had when it was tracked.
        """
        self._reference = keyframe
        self._located_then = int(np.count_nonzero(keyframe.located))
        last = self._followed
        if last is None:
            return
        if last.picture.time_ns == keyframe.picture.time_ns:
            self._accept(keyframe)
            return
        correction = inverse(before) @ keyframe.camera_T_world
        moved_back = Motor.from_matrix(inverse(correction))
        self._moments = [
            _Moment(one.time_ns, moved_back @ one.world_T_camera) for one in self._moments
        ]
        pose = last.camera_T_world @ correction
        _, rows, last_rows = np.intersect1d(
            keyframe.ids, last.ids, assume_unique=True, return_indices=True
        )
        px = self._guess(keyframe, pose)
        px[rows] = last.px[last_rows]
        new = np.setdiff1d(np.arange(len(px)), rows)
        px[new], found = follow(keyframe.picture.gray, last.picture.gray, keyframe.px[new], px[new])
        kept = np.sort(np.concatenate([rows, new[found]]))
        self._followed = Followed(
            last.picture, pose, keyframe.ids[kept], px[kept], keyframe.places[kept]
        )

    def lose(self) -> None:
        """Forget what was followed."""
        self._followed, self._moments = None, []

    def wants_keyframe(self) -> bool:
        """Whether the newest picture should become a keyframe, by what is followed in it."""
        now, then = self.followed, self._reference
        located = int(np.count_nonzero(now.located))
        if then is None or located < max(_FEW_POINTS, _KEPT_SHARE * self._located_then):
            return True
        _, one, other = np.intersect1d(then.ids, now.ids, assume_unique=True, return_indices=True)
        motion = np.linalg.norm(then.px[one] - now.px[other], axis=1)
        return bool(np.median(motion) > _MOVED_SHARE * now.picture.gray.shape[1])

    def step(self, picture: Picture) -> PosedPicture | None:
        """Find the pose of the next picture; None where it is lost.

        On success `followed` holds the corners that agree; on failure what it held before.
        """
        before = self._followed
        if before is None:
            return None
        predicted = self._predicted(picture.time_ns)
        guess = self._guess(before, predicted)
        px, found = follow(before.picture.gray, picture.gray, before.px, guess)
        ids, places = before.ids[found], before.places[found]
        px, old_px = px[found], before.px[found]
        located = np.isfinite(places[:, 0])
        posed = self._posed(predicted, places[located], px[located])
        if not trusted(posed, px[located], picture.gray.shape) or posed is None:
            return None
        kept = np.ones(len(ids), dtype=np.bool_)
        kept[located] = posed.inliers
        kept[~located] = self._on_epipolar_line(posed, old_px[~located], px[~located])
        self._accept(Followed(picture, posed.camera_T_world, ids[kept], px[kept], places[kept]))
        return posed

    def _accept(self, followed: Followed) -> None:
        """Take this picture, pose and corners as where the next picture is followed from."""
        self._followed = followed
        time_ns = followed.picture.time_ns
        moment = _Moment(time_ns, Motor.from_matrix(inverse(followed.camera_T_world)))
        if self._moments and self._moments[-1].time_ns == time_ns:
            self._moments.pop()
        self._moments = [*self._moments[-1:], moment]

    def _predicted(self, time_ns: int) -> FloatArray:
        """The pose at a stamp if the motion goes on as it was."""
        last = self._moments[-1]
        pose = last.world_T_camera
        if len(self._moments) > 1:
            first = self._moments[0]
            share = (time_ns - last.time_ns) / (last.time_ns - first.time_ns)
            motion = (first.world_T_camera.inverse() @ pose).as_twist()
            pose = pose @ Motor.from_twist(min(share, 3.0) * motion)
        return pose.inverse().as_matrix()

    def _guess(self, start: Followed, pose: FloatArray) -> FloatArray:
        """Where corners should be: by their place, or else moved as their neighbours with one."""
        located = start.located
        places = start.places[located]
        there, _ = project(pose, places, self.matrix)
        motion = there - project(start.camera_T_world, places, self.matrix)[0]
        usable = np.isfinite(motion[:, 0])
        guess = start.px.copy()
        if np.count_nonzero(usable) < _NEIGHBOURS:
            return guess
        known = start.px[located][usable]
        rows = np.flatnonzero(located)[usable]
        strange = np.setdiff1d(np.arange(len(guess)), rows)
        apart = np.sum((guess[strange, None] - known[None]) ** 2, axis=-1)
        near = np.argpartition(apart, _NEIGHBOURS - 1, axis=1)[:, :_NEIGHBOURS]
        guess[strange] += np.median(motion[usable][near], axis=1)
        guess[rows] = known + motion[usable]
        return guess

    def _posed(
        self, predicted: FloatArray, points: FloatArray, px: FloatArray
    ) -> PosedPicture | None:
        if len(points) < _FEWEST_INLIERS:
            return None
        refined = refine_pose(predicted, points, px, self.matrix)
        if np.count_nonzero(refined.inliers) >= _GOOD_SHARE * len(points):
            return refined
        sampled = pose_by_sampling(points, px, self.matrix)
        better = sampled is not None and np.count_nonzero(sampled.inliers) > np.count_nonzero(
            refined.inliers
        )
        return sampled if better else refined

    def _on_epipolar_line(
        self, posed: PosedPicture, old_px: FloatArray, px: FloatArray
    ) -> BoolArray:
        """Corners ``(n,)`` without a place that moved as the new pose allows."""
        relative = posed.camera_T_world @ self._moments[-1].world_T_camera.as_matrix()
        x, y, z = relative[:3, 3]
        to_plane = np.linalg.inv(self.matrix)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        fundamental = to_plane.T @ cross @ relative[:3, :3] @ to_plane
        lines = np.concatenate([old_px, np.ones((len(px), 1))], axis=1) @ fundamental.T
        length = np.linalg.norm(lines[:, :2], axis=1)
        offset = np.abs(np.sum(lines[:, :2] * px, axis=1) + lines[:, 2])
        # Without motion there is no line, and nothing speaks against the corner.
        near: BoolArray = offset <= _EPIPOLAR_PX * length + 1e-12
        return near
