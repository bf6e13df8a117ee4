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
from motorcade.tracking.slam.map import SlamMap

__all__ = ["Tracker", "trusted"]

_FEWEST_INLIERS = 25
_LEAST_SHARE = 0.4
_GOOD_SHARE = 0.75
_CELLS, _FEWEST_CELLS = 48, 6
_EPIPOLAR_PX = 3.0
_NEIGHBOURS = 3


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
class _Moment:
    time_ns: int
    world_T_camera: Motor


class Tracker:
    """Follows the map through pictures.

    Args:
        slam_map: the map; matrix: ``(3, 3)`` intrinsics.
    """

    def __init__(self, slam_map: SlamMap, matrix: FloatArray) -> None:
        self.map = slam_map
        self.matrix = matrix
        self.ids: IntArray = np.zeros(0, dtype=np.int64)
        self.px: FloatArray = np.zeros((0, 2))
        self._picture: Picture | None = None
        self._moments: list[_Moment] = []

    def restart(
        self, picture: Picture, camera_T_world: FloatArray, ids: IntArray, px: FloatArray
    ) -> None:
        """Go on from a pose that was found otherwise; what the motion was is forgotten."""
        self._moments = []
        self.accept(picture, camera_T_world, ids, px)

    def accept(
        self, picture: Picture, camera_T_world: FloatArray, ids: IntArray, px: FloatArray
    ) -> None:
        """Take this picture, pose and corners as where the next picture is followed from."""
        self._picture, self.ids, self.px = picture, ids, px
        moment = _Moment(picture.time_ns, Motor.from_matrix(inverse(camera_T_world)))
        if self._moments and self._moments[-1].time_ns == picture.time_ns:
            self._moments.pop()
        self._moments = [*self._moments[-1:], moment]

    def step(self, picture: Picture) -> PosedPicture | None:
        """Find the pose of the next picture; None where it is lost.

        On success `ids` and `px` hold the corners that agree. On failure nothing is kept.
        """
        before = self._picture
        if before is None:
            return None
        predicted = self._predicted(picture.time_ns)
        alive = self.map.alive[self.ids]
        ids, old_px = self.ids[alive], self.px[alive]
        px, found = follow(before.gray, picture.gray, old_px, self._guess(predicted, ids, old_px))
        ids, px, old_px = ids[found], px[found], old_px[found]
        located = self.map.located[ids]
        posed = self._posed(predicted, self.map.places[ids[located]], px[located])
        if not trusted(posed, px[located], picture.gray.shape) or posed is None:
            self._picture, self._moments = None, []
            return None
        kept = np.ones(len(ids), dtype=np.bool_)
        kept[located] = posed.inliers
        kept[~located] = self._on_epipolar_line(posed, old_px[~located], px[~located])
        self.accept(picture, posed.camera_T_world, ids[kept], px[kept])
        return posed

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

    def _guess(self, predicted: FloatArray, ids: IntArray, px: FloatArray) -> FloatArray:
        """Where corners should be: by their place, or else moved as their neighbours with one."""
        last = inverse(self._moments[-1].world_T_camera.as_matrix())
        located = self.map.located[ids]
        places = self.map.places[ids[located]]
        motion = project(predicted, places, self.matrix)[0] - project(last, places, self.matrix)[0]
        usable = np.isfinite(motion[:, 0])
        guess = px.copy()
        if np.count_nonzero(usable) < _NEIGHBOURS:
            return guess
        known = px[located][usable]
        apart = np.sum((px[:, None] - known[None]) ** 2, axis=-1)
        near = np.argpartition(apart, _NEIGHBOURS - 1, axis=1)[:, :_NEIGHBOURS]
        guess += np.median(motion[usable][near], axis=1)
        rows = np.flatnonzero(located)[usable]
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
